"""Convert between four forms of rotations, through quaternions.

Every form is read into the columns ``(w, x, y, z)`` of a quaternion of any positive or negative length, and written
from such columns; a conversion does both. Arbitrary lengths make this fast and accurate: no step normalises what the
next one would divide out again.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from npss.rotations._blocks import Columns, Kernel, fill
from npss.validation import Array, real_array

#: Columns w, x, y, z; w may be one number for all. Not zero; the squared length is in range.
Quaternion = tuple[Array | float, Array, Array, Array]


@dataclass(frozen=True)
class Form:
    """A representation: its shape, and the kernels that read and write it."""

    #: Trailing axes of an array of rotations.
    shape: tuple[int, ...]
    #: Returns the quaternion of the columns; the second argument is the dtype of the caller's array.
    read: Callable[[Columns, np.dtype[Any]], Quaternion]
    #: Fills the columns, its last argument.
    write: Callable[[Quaternion, Columns], None]


def rotation_array(name: str, values: npt.ArrayLike, shape: tuple[int, ...]) -> Array:
    """Read `values` as real numbers of shape ``(..., *shape)``."""
    array = real_array(name, values)
    if array.shape[-len(shape) :] != shape:
        expected = ", ".join(map(str, shape))
        raise ValueError(f"{name}: expected shape (..., {expected}), got {array.shape}")
    return array


def result_dtype(array: Array) -> np.dtype[Any]:
    """Return float32 for single precision, and float64 otherwise, including half precision and integers."""
    single = array.dtype.kind == "f" and array.dtype.itemsize == 4
    return np.dtype(np.float32 if single else np.float64)


def converter(source: Form, target: Form, given: np.dtype[Any]) -> Kernel:
    """Return the kernel from one form to the other, for rotations of dtype `given`."""

    def kernel(columns: Columns, outputs: Columns) -> None:
        target.write(source.read(columns, given), outputs)

    return kernel


def convert(name: str, values: npt.ArrayLike, source: Form, target: Form, dtype: np.dtype[Any] | None = None) -> Array:
    """Convert `values` from one form to the other, in `dtype` or by default `result_dtype`; errors name `name`."""
    array = rotation_array(name, values, source.shape)
    dtype = dtype or result_dtype(array)
    core = len(source.shape), len(target.shape)
    out = np.empty(array.shape[: array.ndim - core[0]] + target.shape, dtype)
    fill(name, array, out, core, converter(source, target, array.dtype), dtype)
    return out
