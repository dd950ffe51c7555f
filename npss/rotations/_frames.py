"""Rotations in time: the axis of the frames, and what the first of them is to continue."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.rotations._forms import result_dtype, rotation_array
from npss.validation import Array, check_finite, is_integer


def rotations_in_time(
    name: str, values: npt.ArrayLike, size: int, axis: int, start: npt.ArrayLike | None
) -> tuple[Array, Array | None]:
    """Copy rotations of `size` numbers, and read what they start from.

    Returns
    -------
    rotations : (..., size) ndarray
        A new C-contiguous array, of float32 for float32 and of float64 for all else. Its frames are its rows once
        `axis` is moved to the front.
    start : (..., size) ndarray or None
        Of the shape of one frame.

    Raises
    ------
    TypeError, ValueError
        If one is no array of such rotations, or not finite, their shapes do not fit, or `axis` is none of frames.
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
