"""The formats of numpy: one array in a ``.npy`` file, named arrays in a ``.npz`` file; never pickles."""

from __future__ import annotations

import math
import zipfile
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import numpy as np
from numpy.lib import format as npy

from npss.files._arrays import Arrays, Header
from npss.validation import Array

_HEAD = 2**14  # bytes, more than the longest header that numpy accepts; numpy reads any declared size before it refuses


def read_npy(path: Path) -> Array:
    """Map the array of a ``.npy`` file into memory; it may be larger than memory."""
    try:
        return npy.open_memmap(path, mode="r")
    except ValueError as error:
        raise ValueError(f"not a readable .npy file ({error})") from error


@contextmanager
def open_npz(path: Path) -> Iterator[Arrays]:
    """Open the arrays of a ``.npz`` file."""
    with zipfile.ZipFile(path) as archive:
        yield _Npz(archive)


def write_npz(stream: BinaryIO, arrays: Mapping[str, Array]) -> None:
    """Write named arrays to a ``.npz`` file."""
    np.savez(stream, **arrays)  # type: ignore[arg-type]  # no array is named like an option


class _Npz:
    """The arrays of a ``.npz`` file."""

    def __init__(self, archive: zipfile.ZipFile) -> None:
        self._archive = archive
        self._members: dict[str, zipfile.ZipInfo] = {}
        for member in archive.infolist():
            if member.filename in self._members:
                raise ValueError(f"duplicate array {member.filename}")
            self._members[member.filename] = member

    def names(self, prefix: str) -> list[str]:
        names = [file.removesuffix(".npy") for file in self._members if file.endswith(".npy")]
        return [name for name in names if name.startswith(prefix)]

    def __contains__(self, name: str) -> bool:
        return f"{name}.npy" in self._members

    def header(self, name: str) -> Header:
        member = self._members[f"{name}.npy"]
        if member.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise ValueError(f"{name}: unsupported compression; expected a file written by numpy")
        with self._archive.open(member) as stream:
            head = BytesIO(stream.read(_HEAD))
        try:
            read = {(1, 0): npy.read_array_header_1_0, (2, 0): npy.read_array_header_2_0}
            shape, _, dtype = read[npy.read_magic(head)](head)
        except (KeyError, ValueError) as error:
            raise ValueError(f"{name}: not a .npy array ({error})") from error
        # numpy would allocate the whole array before it sees that the file is shorter.
        if not dtype.hasobject and (size := math.prod(shape) * dtype.itemsize) > member.file_size:
            raise ValueError(f"{name}: its shape {shape} needs {size} bytes, but there are {member.file_size}")
        return Header(shape, dtype)

    def overhead(self, name: str) -> int:
        return 0  # it is read in small pieces

    def read(self, name: str) -> Array:
        with self._archive.open(f"{name}.npy") as stream:
            array: Array = npy.read_array(stream, allow_pickle=False)
        return array
