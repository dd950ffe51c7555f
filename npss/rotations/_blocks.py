"""Apply element-wise kernels to the columns of an array, block by block.

A rotation is a few adjacent numbers; a kernel needs each of them as one long column. It receives contiguous columns in
the working precision, in blocks small enough for the cache. So memory does not grow with the number of rotations, any
strides are valid, and a result does not depend on its place in the array.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from npss.validation import Array, check_finite

#: The columns of one block: 1-D arrays of the same length.
Columns = tuple[Array, ...]
#: Fills the second, uninitialised columns from the first, read-only ones.
Kernel = Callable[[Columns, Columns], None]

#: Size of one column of a block: two dozen fit into a second-level cache.
BLOCK_BYTES = 1 << 16


class BadRotationError(Exception):
    """The rotation at `position`, counted in C order, is invalid; `what` is the reason."""

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

    A rotation is the last ``core[0]`` axes of `array` and the last ``core[1]`` of `out`; the other axes are equal.

    Raises
    ------
    BadRotationError
        From the kernel, with the position counted from the start of the array.
    """
    if out.size == 0:
        return
    # View a single rotation as a row of one: numpy before 2.3 leaves buffers of 0-d operands that need a cast
    # uninitialised.
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
    # Kernels report invalid values; the caller's np.seterr must not pre-empt them.
    with blocks, np.errstate(all="ignore"):
        for columns in blocks:
            try:
                kernel(columns[:count], columns[count:])
            except BadRotationError as bad:
                bad.position += start
                raise
            start += columns[0].size


def fill(name: str, array: Array, out: Array, core: tuple[int, int], kernel: Kernel, work: np.dtype[Any]) -> None:
    """Call `in_blocks`, with errors that name the argument and the first bad index.

    Raises
    ------
    ValueError
        If `array` holds NaN, an infinity, or a rotation that is invalid for the kernel.
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
    """Return a view of `array` for each entry of its last `core` axes."""
    return [array[(..., *entry)] for entry in np.ndindex(array.shape[array.ndim - core :])]
