"""Named arrays in files: headers are checked first, and only the needed arrays are read.

Files may come from anywhere. None can run code (no pickles), cause another file to be read, or take more memory than
allowed, however much it expands.
"""

from __future__ import annotations

import math
import stat
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
import numpy.typing as npt

from npss.validation import Array

#: The most memory that the arrays of one file may take by default, in GiB.
MAX_SIZE = 2.0

_GIB = 2**30
_NUMBER = 8  # bytes: all computation is in float64


class Header(NamedTuple):
    """The declaration of an array in a file.

    Attributes
    ----------
    shape : tuple of int
        The shape.
    dtype : dtype
        The type of the values.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]


class Arrays(Protocol):
    """The arrays of an open file, by name."""

    def names(self, prefix: str) -> list[str]:
        """Return the names that begin with a prefix: an empty text, or a folder of names with its ``/``."""

    def __contains__(self, name: str) -> bool:
        """Return whether there is an array, or a folder, of this name."""

    def header(self, name: str) -> Header:
        """Return the declaration of an array."""

    def overhead(self, name: str) -> int:
        """Return the memory that reading an array may take beside the array itself, in bytes."""

    def read(self, name: str) -> Array:
        """Read an array."""


@contextmanager
def in_memory(arrays: Mapping[str, npt.ArrayLike]) -> Iterator[Arrays]:
    """Wrap arrays that are in memory already, for formats whose files take as much memory as disk space.

    Parameters
    ----------
    arrays : mapping of str to array_like
        Arrays by name.

    Returns
    -------
    context manager
        Yields `Arrays`.

    Raises
    ------
    ValueError
        If a value is not a regular array.

    Examples
    --------
    >>> with in_memory({"motion": [[1.0, 2.0]]}) as arrays:
    ...     arrays.header("motion").shape
    (1, 2)
    """
    yield _InMemory({name: np.asanyarray(array) for name, array in arrays.items()})


def read_arrays(arrays: Arrays, names: Iterable[str], max_size: float) -> dict[str, Array]:
    """Read arrays, unless they may take more than `max_size` GiB of memory."""
    names = list(names)
    size = sum(_NUMBER * math.prod(arrays.header(name).shape) for name in names)
    size += max((arrays.overhead(name) for name in names), default=0)
    if size > max_size * _GIB:
        raise ValueError(
            f"its arrays may take {size / _GIB:.3g} GiB of memory, more than {max_size:g}; raise --max-size"
        )
    return {name: arrays.read(name) for name in names}


def check_regular(path: Path) -> None:
    """Raise unless `path` is a regular file: reading a named pipe would wait for a writer."""
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        raise ValueError(f"expected a file, got a {'folder' if stat.S_ISDIR(mode) else 'pipe or a device'}")


@contextmanager
def naming_file(path: Path) -> Iterator[None]:
    """Prefix errors with the file; for broken files, libraries raise errors of many types."""
    try:
        yield
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror or error}") from error
    except (TypeError, ValueError) as error:
        kind = TypeError if isinstance(error, TypeError) else ValueError
        raise kind(f"{path}: {error}") from error
    except Exception as error:
        raise ValueError(f"{path}: not a readable {path.suffix} file ({error})") from error


class _InMemory:
    """Arrays in memory."""

    def __init__(self, arrays: Mapping[str, Array]) -> None:
        self._arrays = arrays

    def names(self, prefix: str) -> list[str]:
        return [name for name in self._arrays if name.startswith(prefix)]

    def __contains__(self, name: str) -> bool:
        return name in self._arrays

    def header(self, name: str) -> Header:
        return Header(self._arrays[name].shape, self._arrays[name].dtype)

    def overhead(self, name: str) -> int:
        return 0

    def read(self, name: str) -> Array:
        return self._arrays[name]
