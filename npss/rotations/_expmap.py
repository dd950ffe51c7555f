"""Read and write exponential maps: axis times angle in radians."""

from __future__ import annotations

from typing import Any

import numpy as np

from npss.rotations._blocks import BadRotationError, Columns, require_finite
from npss.rotations._forms import Form, Quaternion
from npss.validation import Array

#: Lower limit of squared angles: functions of the angle have reached their limits long before.
TINY = 1e-30

#: From here, neighbouring float64 numbers are a radian or more apart, so the angle is meaningless.
LARGEST_ANGLE = 2.0**52

#: From here, a float32 angle, with a relative error of 1e-7, is too inaccurate: use float64.
LARGEST_SINGLE_ANGLE = 8.0


def angle_of(x: Array, y: Array, z: Array) -> Array:
    """Return the lengths of the vectors, at least 1e-15."""
    angle = x * x
    angle += y * y
    angle += z * z
    np.maximum(angle, TINY, out=angle)
    np.sqrt(angle, out=angle)
    return angle


def require_angle(columns: Columns, angle: Array) -> None:
    """Raise BadRotationError unless every vector is finite and every float64 angle meaningful."""
    if not angle.max() < LARGEST_ANGLE:
        require_finite(columns)
        raise BadRotationError(int(np.argmax(angle >= LARGEST_ANGLE)), "an angle of 2**52 rad or more")


def read_expmap(columns: Columns, given: np.dtype[Any]) -> Quaternion:
    """Return ``(2, 2 tan(h) v / |v|)`` with h = |v|/2: one transcendental function, accurate at every angle.

    No float is near enough to the pole of the tangent, at half a turn, for it to overflow.
    """
    x, y, z = columns
    angle = angle_of(x, y, z)
    factor = _tangent_factor(angle)
    if angle.dtype != np.float32:
        require_angle(columns, angle)
    elif not angle.max() < LARGEST_SINGLE_ANGLE:
        wide = angle_of(*(column.astype(np.float64) for column in columns))
        require_angle(columns, wide)
        far = angle >= LARGEST_SINGLE_ANGLE
        factor[far] = _tangent_factor(wide[far])
    return 2.0, factor * x, factor * y, factor * z


def write_expmap(quaternion: Quaternion, outputs: Columns) -> None:
    """Write the axis of the quaternion times twice its angle, in [0, pi]."""
    w, x, y, z = quaternion
    length = angle_of(x, y, z)
    factor = np.arctan2(length, np.abs(w))
    factor *= 2
    factor /= length
    np.negative(factor, out=factor, where=points_backwards(w, x, y, z))
    for column, out in zip((x, y, z), outputs, strict=True):
        np.multiply(factor, column, out=out)


def points_backwards(w: Array | float, x: Array, y: Array, z: Array) -> Array:
    """Return where the first nonzero component is negative."""
    sign = np.sign(z)
    for component in (y, x, w):
        sign = np.where(component == 0, sign, np.sign(component))
    return sign < 0


def _tangent_factor(angle: Array) -> Array:
    factor = angle * 0.5
    np.tan(factor, out=factor)
    factor *= 2
    factor /= angle
    return factor


EXPMAP = Form((3,), read_expmap, write_expmap)
