"""Read rotations in time: the axis of the frames, and the frame before the first."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.rotations._forms import result_dtype, rotation_array
from npss.validation import Array, check_finite, is_integer


def rotations_in_time(
    name: str, values: npt.ArrayLike, size: int, axis: int, start: npt.ArrayLike | None
) -> tuple[Array, Array | None]:
    """Copy rotations of `size` numbers, and read the frame to start near.

    Returns
    -------
    rotations : (..., size) ndarray
        A new C-contiguous array, float32 for float32, float64 otherwise. With `axis` moved to the front, its rows are
        frames.
    start : (..., size) ndarray or None
        In the shape of one frame.

    Raises
    ------
    TypeError, ValueError
        If an array does not hold such rotations or is not finite, the shapes do not match, or `axis` is invalid.
    """
    array = rotation_array(name, values, (size,))
    if not is_integer(axis):
        raise TypeError(f"axis: expected a whole number, the axis of the frames, got {axis!r}")
    if not -array.ndim <= axis < array.ndim or axis % array.ndim == array.ndim - 1:
        raise ValueError(f"axis: expected an axis of {name} before the last, got {axis} for shape {array.shape}")
    check_finite(name, array)
    rotations = np.array(array, result_dtype(array), order="C")
    if start is None:
        return rotations, None
    first = rotation_array("start", start, (size,))
    expected = rotations.shape[: axis % array.ndim] + rotations.shape[axis % array.ndim + 1 :]
    if first.shape != expected:
        raise ValueError(f"start: expected the shape of one frame of {name}, {expected}, got {first.shape}")
    check_finite("start", first)
    return rotations, first
