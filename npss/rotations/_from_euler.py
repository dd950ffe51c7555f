"""Conversions from Euler angles."""

from __future__ import annotations

import numpy.typing as npt

from npss.rotations._euler import H36M, euler_form
from npss.rotations._expmap import EXPMAP
from npss.rotations._forms import convert
from npss.rotations._matrix import MATRIX
from npss.rotations._quaternion import QUATERNION
from npss.validation import Array


def euler_to_expmap(angles: npt.ArrayLike, *, seq: str = H36M) -> Array:
    """Convert Euler angles to exponential maps.

    Parameters
    ----------
    angles : (..., 3) array_like
        Angles in radians, in the order of the letters; any finite value.
    seq : str
        As in `expmap_to_euler`: ``"h36m"``, or three letters, upper case intrinsic, lower case extrinsic.

    Returns
    -------
    (..., 3) ndarray
        Rotation vectors in radians of length in [0, pi]; at pi, where v and -v are one rotation, the first
        component that is not zero is positive. float32 for float32, float64 for all else.

    Raises
    ------
    TypeError
        If `angles` is not an array of real numbers, or `seq` not a string.
    ValueError
        If the shape is another one, a value is not finite (the first index is named), or `seq` is no
        sequence.

    Examples
    --------
    >>> from npss.rotations import euler_to_expmap
    >>> euler_to_expmap([0.3, 0, 0], seq="XYZ").round(12)
    array([0.3, 0. , 0. ])
    """
    return convert("angles", angles, euler_form(seq), EXPMAP)


def euler_to_matrix(angles: npt.ArrayLike, *, seq: str = H36M) -> Array:
    """Convert Euler angles to rotation matrices.

    Parameters
    ----------
    angles : (..., 3) array_like
        Angles in radians, in the order of the letters; any finite value.
    seq : str
        As in `expmap_to_euler`: ``"h36m"``, or three letters, upper case intrinsic, lower case extrinsic.

    Returns
    -------
    (..., 3, 3) ndarray
        Matrices R that rotate column vectors, ``R @ x``. float32 for float32, float64 for all else.

    Raises
    ------
    TypeError
        If `angles` is not an array of real numbers, or `seq` not a string.
    ValueError
        If the shape is another one, a value is not finite (the first index is named), or `seq` is no
        sequence.

    Examples
    --------
    The intrinsic sequence multiplies the elementary rotations from left to right:

    >>> import numpy as np
    >>> from npss.rotations import euler_to_matrix
    >>> Rx, Ry, Rz = euler_to_matrix([[0.3, 0, 0], [0, 0.2, 0], [0, 0, 0.1]], seq="XYZ")
    >>> bool(np.allclose(Rx @ Ry @ Rz, euler_to_matrix([0.3, 0.2, 0.1], seq="XYZ")))
    True
    """
    return convert("angles", angles, euler_form(seq), MATRIX)


def euler_to_quaternion(angles: npt.ArrayLike, *, seq: str = H36M) -> Array:
    """Convert Euler angles to unit quaternions.

    Parameters
    ----------
    angles : (..., 3) array_like
        Angles in radians, in the order of the letters; any finite value.
    seq : str
        As in `expmap_to_euler`: ``"h36m"``, or three letters, upper case intrinsic, lower case extrinsic.

    Returns
    -------
    (..., 4) ndarray
        Unit quaternions in the order w, x, y, z, with w >= 0; where w is 0, the first component that is not
        zero is positive. float32 for float32, float64 for all else.

    Raises
    ------
    TypeError
        If `angles` is not an array of real numbers, or `seq` not a string.
    ValueError
        If the shape is another one, a value is not finite (the first index is named), or `seq` is no
        sequence.

    See Also
    --------
    continuous : the same quaternions without jumps of sign between frames, to be scored.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.rotations import euler_to_quaternion
    >>> euler_to_quaternion([np.pi / 2, 0, 0], seq="ZYX").round(4)
    array([0.7071, 0.    , 0.    , 0.7071])
    """
    return convert("angles", angles, euler_form(seq), QUATERNION)
