"""Convert rotations between five representations.

================  ================  =============================================================
representation    shape             convention
================  ================  =============================================================
exponential map   ``(..., 3)``      axis times angle in radians, also called rotation vector
rotation matrix   ``(..., 3, 3)``   rotates column vectors, ``R @ x``
quaternion        ``(..., 4)``      order w, x, y, z; returned with unit length and w >= 0
6D columns        ``(..., 6)``      first two columns of the matrix; ``layout="columns"`` or ``"rows"``
Euler angles      ``(..., 3)``      radians; ``seq="h36m"``, or three letters (upper case intrinsic)
================  ================  =============================================================

All functions take any number of leading axes, including none and empty ones, and return a new C-contiguous array. They
compute in float32 for float32 input and in float64 otherwise. The bits of a result do not depend on its place in the
array.

Conversions treat each rotation separately. Where a rotation has several equivalent values, a smooth motion may jump
between them from frame to frame, and every metric of the values counts the jump. `continuous` (quaternions) and
`continuous_euler` remove these jumps.

Examples
--------
>>> import numpy as np
>>> from npss.rotations import expmap_to_euler, expmap_to_matrix
>>> expmap_to_matrix(np.zeros((10, 32, 3))).shape
(10, 32, 3, 3)
>>> expmap_to_euler([0.3, 0.2, 0.1]).round(4)
array([-0.2938, -0.2118, -0.0696])
"""

from npss.rotations._angle import geodesic_angle, relative_angle
from npss.rotations._continuous import continuous
from npss.rotations._continuous_euler import continuous_euler
from npss.rotations._from_euler import euler_to_expmap, euler_to_matrix, euler_to_quaternion, euler_to_sixd
from npss.rotations._from_expmap import expmap_to_euler, expmap_to_matrix, expmap_to_quaternion, expmap_to_sixd
from npss.rotations._from_matrix import matrix_to_euler, matrix_to_expmap, matrix_to_quaternion, matrix_to_sixd
from npss.rotations._from_quaternion import (
    quaternion_to_euler,
    quaternion_to_expmap,
    quaternion_to_matrix,
    quaternion_to_sixd,
)
from npss.rotations._from_sixd import sixd_to_euler, sixd_to_expmap, sixd_to_matrix, sixd_to_quaternion
from npss.rotations._slerp import slerp

__all__ = [
    "continuous",
    "continuous_euler",
    "euler_to_expmap",
    "euler_to_matrix",
    "euler_to_quaternion",
    "euler_to_sixd",
    "expmap_to_euler",
    "expmap_to_matrix",
    "expmap_to_quaternion",
    "expmap_to_sixd",
    "geodesic_angle",
    "matrix_to_euler",
    "matrix_to_expmap",
    "matrix_to_quaternion",
    "matrix_to_sixd",
    "quaternion_to_euler",
    "quaternion_to_expmap",
    "quaternion_to_matrix",
    "quaternion_to_sixd",
    "relative_angle",
    "sixd_to_euler",
    "sixd_to_expmap",
    "sixd_to_matrix",
    "sixd_to_quaternion",
    "slerp",
]
