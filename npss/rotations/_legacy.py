"""Reproduce the released code's conversion of exponential maps to Euler angles, operation by operation, in float64."""

from __future__ import annotations

import numpy as np

from npss.rotations._blocks import Columns
from npss.rotations._expmap import angle_of, require_angle
from npss.validation import Array

#: Added to the angle before dividing by it, although that code runs in float64.
_EPSILON = float(np.finfo(np.float32).eps)


def legacy_euler(columns: Columns, outputs: Columns) -> None:
    """Apply Rodrigues' formula about the axis ``v / (|v| + 1.19e-7)``, then the arcsine.

    The axis is slightly shorter than 1, so the matrix is not exactly a rotation. The error is usually 1.2e-7 rad, and
    far larger near gimbal lock.
    """
    angle = angle_of(*columns)
    require_angle(columns, angle)
    x, y, z = (column / (angle + _EPSILON) for column in columns)
    sine, versine = np.sin(angle), 1 - np.cos(angle)
    # The order matters for zeros: none of these must become -0.0, or half a turn would be -pi.
    r00 = 1 - versine * (z * z + y * y)
    r01 = (0 - sine * z) + versine * (x * y)
    r02 = (0 + sine * y) + versine * (x * z)
    r12 = (0 - sine * x) + versine * (y * z)
    r22 = 1 - versine * (y * y + x * x)

    np.clip(r02, -1, 1, out=r02)  # beyond, by rounding, the released code returns NaN
    locked: Array = np.abs(r02) == 1
    first, middle, last = outputs
    np.subtract(0, np.arcsin(r02), out=middle)
    # Dividing both arguments by cos(middle) >= 0, as the released code does, changes nothing.
    first[:] = np.where(locked, np.arctan2(r01, r02), np.arctan2(r12, r22))
    last[:] = np.where(locked, 0, np.arctan2(r01, r00))
