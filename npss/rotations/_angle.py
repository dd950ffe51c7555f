"""The angle between two rotations."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.rotations._forms import convert
from npss.rotations._matrix import MATRIX
from npss.rotations._quaternion import QUATERNION
from npss.validation import Array


def geodesic_angle(a: npt.ArrayLike, b: npt.ArrayLike) -> Array:
    """Return the angle of the rotation between two orientations.

    It is the geodesic distance on the rotation group.

    Parameters
    ----------
    a, b : (..., 3, 3) array_like
        Rotation matrices of the same shape. Entries of ``a @ a.T`` must be within 1e-6 of the identity in double
        precision (and for integers), 1e-4 in single and 1e-2 in half precision, and the determinant must be positive.

    Returns
    -------
    (...) ndarray
        Angles in radians in [0, pi]; 0 for equal matrices; a numpy scalar for two single matrices. float32 if both
        arguments are float32, float64 otherwise.

    Raises
    ------
    TypeError
        If an argument is not an array of real numbers.
    ValueError
        If the shapes are wrong or differ, a value is not finite, or a matrix is not a rotation. The message names the
        argument and the first index.

    Notes
    -----
    For the quaternion of ``a.T @ b``, the angle is twice the arc tangent of the length of the vector part over the
    real part. The usual arc cosine of the trace loses half of the digits near 0 and near pi.

    Examples
    --------
    >>> from npss.rotations import expmap_to_matrix, geodesic_angle
    >>> a, b = expmap_to_matrix([[0.1, 0, 0], [0.4, 0, 0]])
    >>> geodesic_angle(a, b).round(12)
    np.float64(0.3)
    """
    p = convert("a", a, MATRIX, QUATERNION)
    q = convert("b", b, MATRIX, QUATERNION)
    if p.shape != q.shape:
        raise ValueError(f"b: its shape {np.shape(b)} differs from that of a, {np.shape(a)}; nothing is broadcast")
    pw, px, py, pz = (p[..., i] for i in range(4))
    qw, qx, qy, qz = (q[..., i] for i in range(4))
    w = pw * qw + px * qx + py * qy + pz * qz
    x = pw * qx - px * qw + pz * qy - py * qz
    y = pw * qy - py * qw + px * qz - pz * qx
    z = pw * qz - pz * qw + py * qx - px * qy
    angle: Array = 2 * np.arctan2(np.hypot(np.hypot(x, y), z), np.abs(w))
    return angle
