"""HDF5 files, without links to other files; the only module that needs h5py."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any, BinaryIO

import h5py

from npss.files._arrays import Arrays, Header
from npss.validation import Array

_LINKS = 100  # followed at most, to break circles
_DEFLATE = 1032  # the highest compression ratio of HDF5's compressors
_NOT_COMPRESSORS = (h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32)


@contextmanager
def open_h5(path: Path) -> Iterator[Arrays]:
    """Open a file; no other file is read."""
    with h5py.File(path, "r") as file:
        yield _H5(file)


def write_h5(stream: BinaryIO, arrays: Mapping[str, Array]) -> None:
    """Write named arrays."""
    with h5py.File(stream, "w") as file:
        for name, array in arrays.items():
            file[name] = array


class _H5:
    """The data sets of an open file."""

    def __init__(self, file: h5py.File) -> None:
        self._file = file

    def names(self, prefix: str) -> list[str]:
        group = self._open(prefix)
        if group is None:
            return []
        if not isinstance(group, h5py.Group):
            raise ValueError(f"{prefix}: expected a group")
        return [prefix + name for name in group]

    def __contains__(self, name: str) -> bool:
        return self._open(name) is not None

    def header(self, name: str) -> Header:
        dataset = self._dataset(name)
        if dataset.shape is None:
            raise ValueError(f"{name}: the data set has no values")
        return Header(dataset.shape, dataset.dtype)

    def overhead(self, name: str) -> int:
        # A chunk is read whole, and may inflate to more than its declared size.
        dataset = self._dataset(name)
        if dataset.chunks is None:
            return 0
        stored: list[int] = []
        dataset.id.chunk_iter(lambda chunk: stored.append(chunk.size))
        properties = dataset.id.get_create_plist()
        filters = [properties.get_filter(i)[0] for i in range(properties.get_nfilters())]
        compressors = sum(code not in _NOT_COMPRESSORS for code in filters)
        inflated = max(stored, default=0) * _DEFLATE**compressors
        return int(max(math.prod(dataset.chunks) * dataset.dtype.itemsize, inflated))

    def read(self, name: str) -> Array:
        array: Array = self._dataset(name)[()]
        return array

    def _dataset(self, name: str) -> Any:
        dataset = self._open(name)
        if not isinstance(dataset, h5py.Dataset):
            raise ValueError(f"{name}: expected a data set")
        if dataset.is_virtual or dataset.external:
            raise ValueError(f"{name}: the values are in another file; copy them into this one")
        return dataset

    def _open(self, name: str) -> Any:
        """Open the object of this name, or return None; link by link, since HDF5 would follow links to other files."""
        item, steps, links = self._file, name.split("/")[::-1], 0
        while steps:
            step = steps.pop().encode("utf-8", "surrogateescape")
            if step in (b"", b"."):
                continue
            if not isinstance(item, h5py.Group) or not item.id.links.exists(step):
                if links:
                    raise ValueError(f"{name}: broken link")
                return None
            kind = item.id.links.get_info(step).type
            if kind == h5py.h5l.TYPE_HARD:
                item = item[step]
                continue
            links += 1
            if kind != h5py.h5l.TYPE_SOFT:
                raise ValueError(f"{name}: link to another file; copy its target into this one")
            if links > _LINKS:
                raise ValueError(f"{name}: circular link")
            target = item.id.links.get_val(step).decode("utf-8", "surrogateescape")
            item = self._file if target.startswith("/") else item
            steps += target.split("/")[::-1]
        return item
