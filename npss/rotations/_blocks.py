"""Element-wise work on the columns of an array, a block at a time.

A rotation is a handful of numbers that lie side by side; a kernel wants each of them as one long column. The
columns are handed over in blocks small enough for everything to stay in the cache, each one contiguous and in
the working precision, so that memory does not grow with the number of rotations, any strides will do, and a
result never depends on where in an array its rotation stands.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from npss.validation import Array, check_finite

#: The columns of one block: 1-D arrays of one length.
Columns = tuple[Array, ...]
#: Fills the second columns, which are uninitialised, from the first, which are read-only.
Kernel = Callable[[Columns, Columns], None]

#: Size of one column of a block: two dozen of them fit into a second-level cache.
BLOCK_BYTES = 1 << 16


class BadRotationError(Exception):
    """The rotation at `position`, counted in C order, cannot be read; `what` says why."""

    def __init__(self, position: int, what: str) -> None:
        super().__init__(what)
        self.position = position
        self.what = what


def require_finite(columns: Columns) -> None:
    """Raise BadRotationError unless every value in the columns is finite."""
    for column in columns:
        finite = np.isfinite(column)
        if not finite.all():
            raise BadRotationError(int(np.argmin(finite)), "a value that is not finite")


def in_blocks(array: Array, out: Array, core: tuple[int, int], kernel: Kernel, work: np.dtype[Any]) -> None:
    """Fill `out` with one call of `kernel` for each block of rotations, in precision `work`.

    A rotation is the last ``core[0]`` axes of `array` and the last ``core[1]`` of `out`; the axes before
    agree.

    Raises
    ------
    BadRotationError
        From the kernel, with the position counted from the start of the array.
    """
    if out.size == 0:
        return
    # A single rotation is seen as a row of one: over 0-d operands that need a cast, the buffers of numpy before 2.3
    # stay uninitialised.
    inputs, outputs = _columns(array[np.newaxis], core[0]), _columns(out[np.newaxis], core[1])
    count = len(inputs)
    modes: list[Any] = [["readonly", "contig"]] * count + [["writeonly", "contig"]] * len(outputs)
    blocks = np.nditer(
        inputs + outputs,
        flags=["external_loop", "buffered"],
        op_flags=modes,
        op_dtypes=[work] * (count + len(outputs)),
        casting="same_kind",
        order="C",
        buffersize=BLOCK_BYTES // work.itemsize,
    )
    start = 0
    # The kernels name what is wrong themselves; the caller's np.seterr must not speak first.
    with blocks, np.errstate(all="ignore"):
        for columns in blocks:
            try:
                kernel(columns[:count], columns[count:])
            except BadRotationError as bad:
                bad.position += start
                raise
            start += columns[0].size


def fill(name: str, array: Array, out: Array, core: tuple[int, int], kernel: Kernel, work: np.dtype[Any]) -> None:
    """`in_blocks`, with errors that name the argument and the first bad index.

    Raises
    ------
    ValueError
        If `array` holds NaN, an infinity, or a rotation that the kernel cannot read.
    """
    try:
        in_blocks(array, out, core, kernel, work)
        return
    except BadRotationError as error:
        bad = error
    check_finite(name, array)
    index = tuple(int(i) for i in np.unravel_index(bad.position, array.shape[: array.ndim - core[0]]))
    raise ValueError(f"{name}: {bad.what} at index {index}")


def _columns(array: Array, core: int) -> list[Array]:
    """Return views of `array`, one for each entry of its last `core` axes."""
    return [array[(..., *entry)] for entry in np.ndindex(array.shape[array.ndim - core :])]
