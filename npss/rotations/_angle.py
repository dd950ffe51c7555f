"""The angle between two rotations."""

from __future__ import annotations

from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from npss.rotations._euler import H36M, euler_form
from npss.rotations._expmap import EXPMAP
from npss.rotations._forms import Form, convert
from npss.rotations._matrix import MATRIX
from npss.rotations._quaternion import QUATERNION
from npss.rotations._sixd import COLUMNS, Layout, sixd_form
from npss.validation import Array, one_of

#: The representations of rotations.
Representation = Literal["expmap", "matrix", "quaternion", "sixd", "euler"]


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
    return angle_between(a, b, MATRIX)


def relative_angle(
    a: npt.ArrayLike, b: npt.ArrayLike, *, representation: Representation, seq: str = H36M, layout: Layout = COLUMNS
) -> Array:
    """Return the angle of the rotation between two orientations in any representation.

    Parameters
    ----------
    a, b : (..., n) or (..., 3, 3) array_like
        Rotations of the same shape. Quaternions and 6D columns may have any nonzero length; q and -q are equal.
    representation : {'expmap', 'matrix', 'quaternion', 'sixd', 'euler'}
        The representation of both.
    seq : str, optional
        The sequence of Euler angles, as in `expmap_to_euler`.
    layout : {'columns', 'rows'}, optional
        The layout of 6D columns, as in `sixd_to_matrix`.

    Returns
    -------
    (...) ndarray
        Angles in radians in [0, pi]; a numpy scalar for two single rotations. float32 if both arguments are float32,
        float64 otherwise.

    Raises
    ------
    TypeError
        If an argument is not an array of real numbers, or an option is not a string.
    ValueError
        If the shapes are wrong or differ, a value is not finite or not a rotation (the message names the argument and
        the first index), or an option is invalid.

    See Also
    --------
    geodesic_angle : the same for matrices.

    Examples
    --------
    >>> from npss.rotations import relative_angle
    >>> relative_angle([0.1, 0, 0], [0.4, 0, 0], representation="expmap").round(12)
    np.float64(0.3)
    >>> relative_angle([1, 0, 0, 0], [-1, 0, 0, 0], representation="quaternion")
    np.float64(0.0)
    """
    return angle_between(a, b, rotation_form(representation, seq=seq, layout=layout))


def rotation_form(representation: str, *, seq: str = H36M, layout: str = COLUMNS) -> Form:
    """Return the form of a representation.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    one_of("representation", representation, get_args(Representation))
    forms = {"expmap": EXPMAP, "matrix": MATRIX, "quaternion": QUATERNION}
    others = {"sixd": sixd_form(layout), "euler": euler_form(seq)}  # built in any case, so that both are checked
    return (forms | others)[representation]


def angle_between(
    a: npt.ArrayLike,
    b: npt.ArrayLike,
    form: Form,
    names: tuple[str, str] = ("a", "b"),
    dtype: np.dtype[Any] | None = None,
) -> Array:
    """Return the angles ``(...)`` between rotations in a form, computed in `dtype` or by default that of each."""
    p = convert(names[0], a, form, QUATERNION, dtype)
    q = convert(names[1], b, form, QUATERNION, dtype)
    if p.shape != q.shape:
        raise ValueError(
            f"{names[1]}: its shape {np.shape(b)} differs from that of {names[0]}, {np.shape(a)}; nothing is broadcast"
        )
    pw, px, py, pz = (p[..., i] for i in range(4))
    qw, qx, qy, qz = (q[..., i] for i in range(4))
    w = pw * qw + px * qx + py * qy + pz * qz
    x = pw * qx - px * qw + pz * qy - py * qz
    y = pw * qy - py * qw + px * qz - pz * qx
    z = pw * qz - pz * qw + py * qx - px * qy
    angle: Array = 2 * np.arctan2(np.hypot(np.hypot(x, y), z), np.abs(w))
    return angle
