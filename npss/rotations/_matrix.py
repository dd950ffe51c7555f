"""Read and write rotation matrices that rotate column vectors, ``R @ x``."""

from __future__ import annotations

from typing import Any

import numpy as np

from npss.rotations._blocks import BadRotationError, Columns, require_finite
from npss.rotations._forms import Form, Quaternion
from npss.validation import Array

#: Tolerance of an entry of ``R @ R.T`` by item size. Wide enough for matrices rounded to the next lower precision.
_TOLERANCE = {2: 1e-2, 4: 1e-4, 8: 1e-6}


def tolerance(given: np.dtype[Any]) -> float:
    """Return 1e-2 for half, 1e-4 for single and 1e-6 for double precision and integers."""
    return _TOLERANCE[given.itemsize] if given.kind == "f" else 1e-6


def read_matrix(columns: Columns, given: np.dtype[Any]) -> Quaternion:
    """Check that the columns are entries of rotations, and return a quaternion."""
    require_finite(columns)
    _require_rotation(columns, tolerance(given))
    return longest_quaternion(columns)


def longest_quaternion(columns: Columns) -> Quaternion:
    """Return the longest of the four multiples of the quaternion that a matrix contains.

    They are the rows of four times the outer product of the unit quaternion with itself. The longest has the largest
    diagonal element.
    """
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = columns
    ww, xx = 1 + r00 + r11 + r22, 1 + r00 - r11 - r22
    yy, zz = 1 - r00 + r11 - r22, 1 - r00 - r11 + r22
    wx, wy, wz = r21 - r12, r02 - r20, r10 - r01
    xy, xz, yz = r10 + r01, r20 + r02, r21 + r12
    w_or_x = _where(ww >= xx, (ww, wx, wy, wz), (wx, xx, xy, xz))
    y_or_z = _where(yy >= zz, (wy, xy, yy, yz), (wz, xz, yz, zz))
    w, x, y, z = _where(np.maximum(ww, xx) >= np.maximum(yy, zz), w_or_x, y_or_z)
    return w, x, y, z


def write_matrix(quaternion: Quaternion, outputs: Columns) -> None:
    """Divide quadratic polynomials in the quaternion by its squared length."""
    w, x, y, z = quaternion
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = outputs
    scale = 2 / (w * w + x * x + y * y + z * z)
    sw, sx, sy, sz = scale * w, scale * x, scale * y, scale * z
    xx, yy, zz = sx * x, sy * y, sz * z
    xy, xz, yz = sx * y, sx * z, sy * z
    wx, wy, wz = sw * x, sw * y, sw * z
    np.subtract(1, yy + zz, out=r00)
    np.subtract(1, xx + zz, out=r11)
    np.subtract(1, xx + yy, out=r22)
    np.subtract(xy, wz, out=r01)
    np.add(xy, wz, out=r10)
    np.subtract(xz, wy, out=r20)
    np.add(xz, wy, out=r02)
    np.subtract(yz, wx, out=r12)
    np.add(yz, wx, out=r21)


def _require_rotation(columns: Columns, allowed: float) -> None:
    rows = columns[:3], columns[3:6], columns[6:]
    defect = np.zeros_like(columns[0])
    for i, row in enumerate(rows):
        for j in range(i, 3):
            np.maximum(defect, np.abs(dot(row, rows[j]) - (i == j)), out=defect)
    straight = defect <= allowed  # false where a product overflowed
    if not straight.all():
        at = int(np.argmin(straight))
        raise BadRotationError(
            at, f"not a rotation matrix (R @ R.T is {defect[at]:.2g} off the identity, {allowed:g} allowed)"
        )
    proper = dot(cross(rows[0], rows[1]), rows[2]) > 0
    if not proper.all():
        raise BadRotationError(int(np.argmin(proper)), "a reflection, not a rotation matrix (determinant -1)")


def _where(condition: Array, yes: Columns, no: Columns) -> Columns:
    return tuple(np.where(condition, a, b) for a, b in zip(yes, no, strict=True))


def dot(a: Columns, b: Columns) -> Array:
    """Return the scalar product of vectors."""
    product: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
    return product


def cross(a: Columns, b: Columns) -> Columns:
    """Return the cross product of vectors."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


MATRIX = Form((3, 3), read_matrix, write_matrix)
