"""Arrays by name, as files hold them: what they declare is looked at first, and only what is needed is read.

Files come from anywhere. None can run code (no pickles), make another file be read, or take more memory than is
allowed, whatever it expands to.
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

#: How much memory the arrays of one file may take, in GiB, unless somebody allows more.
MAX_SIZE = 2.0

_GIB = 2**30
_NUMBER = 8  # bytes: all is computed in float64


class Header(NamedTuple):
    """What a file declares of an array.

    Attributes
    ----------
    shape : tuple of int
        Its shape.
    dtype : dtype
        The type of its values.
    """

    shape: tuple[int, ...]
    dtype: np.dtype[Any]


class Arrays(Protocol):
    """The arrays of an open file, by name."""

    def names(self, prefix: str) -> list[str]:
        """Return the names that begin with a prefix: nothing, or a folder of names and its ``/``."""

    def __contains__(self, name: str) -> bool:
        """Say whether there is something of that name."""

    def header(self, name: str) -> Header:
        """Return what the file declares of an array."""

    def overhead(self, name: str) -> int:
        """Return how many bytes reading an array may take beside the array itself."""

    def read(self, name: str) -> Array:
        """Read an array."""


@contextmanager
def in_memory(arrays: Mapping[str, npt.ArrayLike]) -> Iterator[Arrays]:
    """Open arrays that have been read already: for formats of which a file takes as much memory as on the disk.

    Parameters
    ----------
    arrays : mapping of str to array_like
        By name.

    Returns
    -------
    context manager
        Yields `Arrays`.

    Raises
    ------
    ValueError
        If one is no regular array.

    Examples
    --------
    >>> with in_memory({"motion": [[1.0, 2.0]]}) as arrays:
    ...     arrays.header("motion").shape
    (1, 2)
    """
    yield _InMemory({name: np.asanyarray(array) for name, array in arrays.items()})


def read_arrays(arrays: Arrays, names: Iterable[str], max_size: float) -> dict[str, Array]:
    """Read some arrays, unless that may take more than `max_size` GiB of memory."""
    names = list(names)
    size = sum(_NUMBER * math.prod(arrays.header(name).shape) for name in names)
    size += max((arrays.overhead(name) for name in names), default=0)
    if size > max_size * _GIB:
        raise ValueError(
            f"its arrays may take {size / _GIB:.3g} GiB of memory, more than {max_size:g}; --max-size allows more"
        )
    return {name: arrays.read(name) for name in names}


def check_regular(path: Path) -> None:
    """Raise unless it is a file: who reads a named pipe waits for somebody to write to it."""
    mode = path.stat().st_mode
    if not stat.S_ISREG(mode):
        raise ValueError(f"expected a file, got a {'folder' if stat.S_ISDIR(mode) else 'pipe or a device'}")


@contextmanager
def naming_file(path: Path) -> Iterator[None]:
    """Let every error begin with the file that it is about; of a broken one, libraries raise many kinds."""
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
    """Arrays that have been read."""

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
