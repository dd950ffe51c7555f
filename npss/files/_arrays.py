"""Arrays by name, in ``.npz`` and ``.h5`` files: what they declare is looked at first, and only what is needed is read.

Files come from anywhere. None can run code (no pickles), make another file be read, or take more memory than is
allowed, whatever it expands to.
"""

from __future__ import annotations

import math
import stat
import zipfile
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import Any, NamedTuple, Protocol

import numpy as np
from numpy.lib import format as npy

from npss.validation import Array

#: How much memory the arrays of one file may take, in GiB, unless somebody allows more.
MAX_SIZE = 2.0

_GIB = 2**30
_HEAD = 2**14  # bytes, more than numpy trusts of a header; it would read all that one claims to have before it says so
_NUMBER = 8  # bytes: all is computed in float64


class Header(NamedTuple):
    """What a file declares of an array."""

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
def open_arrays(path: Path) -> Iterator[Arrays]:
    """Open a ``.npz`` or ``.h5`` file; `naming_file` lets errors name it."""
    check_regular(path)
    if path.suffix == ".npz":
        with zipfile.ZipFile(path) as archive:
            yield _Npz(archive)
        return
    from npss.files._h5 import open_h5  # here, since few need h5py

    with open_h5(path) as arrays:
        yield arrays


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


def read_npy(path: Path) -> Array:
    """Map the array of a ``.npy`` file into memory; it may be larger than that."""
    check_regular(path)
    try:
        return npy.open_memmap(path, mode="r")
    except ValueError as error:
        raise ValueError(f"not a readable .npy file ({error})") from error


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


class _Npz:
    """The arrays of a ``.npz``."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        self._members: dict[str, zipfile.ZipInfo] = {}
        for member in archive.infolist():
            if member.filename in self._members:
                raise ValueError(f"{member.filename} is there twice")
            self._members[member.filename] = member

    def names(self, prefix: str) -> list[str]:
        names = [file.removesuffix(".npy") for file in self._members if file.endswith(".npy")]
        return [name for name in names if name.startswith(prefix)]

    def __contains__(self, name: str) -> bool:
        return f"{name}.npy" in self._members

    def header(self, name: str) -> Header:
        member = self._members[f"{name}.npy"]
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise ValueError(f"{name}: compressed in a way that numpy does not write")
        with self._archive.open(member) as stream:
            head = BytesIO(stream.read(_HEAD))
        try:
            read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
            shape, _, dtype = read[npy.read_magic(head)](head)
        except (KeyError, ValueError) as error:
            raise ValueError(f"{name}: not a .npy array ({error})") from error
        # numpy would make room for the whole array before it sees that the file is shorter.
        if not dtype.hasobject and (size := math.prod(shape) * dtype.itemsize) > member.file_size:
            raise ValueError(f"{name}: its shape {shape} is of {size} bytes, and there are {member.file_size}")
        return Header(shape, dtype)

    def overhead(self, name: str) -> int:
        return 0  # it is read in small pieces

    def read(self, name: str) -> Array:
        with self._archive.open(f"{name}.npy") as stream:
            array: Array = npy.read_array(stream, allow_pickle=False)
        return array
