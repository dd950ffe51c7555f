"""Read and write quaternions ``(w, x, y, z)``: the cosine of half the angle, and its sine times the axis."""

from __future__ import annotations

from typing import Any

import numpy as np

from npss.rotations._blocks import BadRotationError, Columns, require_finite
from npss.rotations._expmap import points_backwards
from npss.rotations._forms import Form, Quaternion


def read_quaternion(columns: Columns, given: np.dtype[Any]) -> Quaternion:
    """Scale by a power of two, which is exact, so that the largest component is in [1/2, 1)."""
    require_finite(columns)
    largest = np.abs(columns[0])
    for column in columns[1:]:
        np.maximum(largest, np.abs(column), out=largest)
    if not largest.all():
        raise BadRotationError(int(np.argmin(largest)), "a zero quaternion, not a rotation,")
    exponent = -np.frexp(largest)[1]
    w, x, y, z = (np.ldexp(column, exponent) for column in columns)
    return w, x, y, z


def write_quaternion(quaternion: Quaternion, outputs: Columns) -> None:
    """Scale to unit length, with w >= 0."""
    w, x, y, z = quaternion
    inverse = x * x
    inverse += y * y
    inverse += z * z
    inverse += w * w
    np.sqrt(inverse, out=inverse)
    np.reciprocal(inverse, out=inverse)
    for column, out in zip(quaternion, outputs, strict=True):
        np.multiply(column, inverse, out=out)
    backwards = points_backwards(*outputs)
    for out in outputs:
        np.negative(out, out=out, where=backwards)
        out += 0.0  # turns -0.0 into 0.0


QUATERNION = Form((4,), read_quaternion, write_quaternion)
