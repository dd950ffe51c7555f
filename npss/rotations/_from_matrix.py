"""Conversions from rotation matrices."""

from __future__ import annotations

import numpy.typing as npt

from npss.rotations._euler import H36M, euler_form
from npss.rotations._expmap import EXPMAP
from npss.rotations._forms import convert
from npss.rotations._matrix import MATRIX
from npss.rotations._quaternion import QUATERNION
from npss.validation import Array


def matrix_to_expmap(R: npt.ArrayLike) -> Array:
    """Convert rotation matrices to exponential maps (the logarithm).

    Parameters
    ----------
    R : (..., 3, 3) array_like
        Rotation matrices. No entry of ``R @ R.T`` may be off the identity by more than 1e-6 in double
        precision (integers included), 1e-4 in single and 1e-2 in half precision, and the determinant must be
        positive.

    Returns
    -------
    (..., 3) ndarray
        Rotation vectors in radians of length in [0, pi]; at pi, where v and -v are one rotation, the first
        component that is not zero is positive. float32 for float32, float64 for all else.

    Raises
    ------
    TypeError
        If `R` is not an array of real numbers.
    ValueError
        If the shape is another one, a value is not finite or a matrix not a rotation; the first index is
        named.

    Examples
    --------
    >>> from npss.rotations import matrix_to_expmap
    >>> matrix_to_expmap([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).round(4)
    array([0.    , 0.    , 1.5708])
    """
    return convert("R", R, MATRIX, EXPMAP)


def matrix_to_quaternion(R: npt.ArrayLike) -> Array:
    """Convert rotation matrices to unit quaternions.

    Parameters
    ----------
    R : (..., 3, 3) array_like
        Rotation matrices. No entry of ``R @ R.T`` may be off the identity by more than 1e-6 in double
        precision (integers included), 1e-4 in single and 1e-2 in half precision, and the determinant must be
        positive.

    Returns
    -------
    (..., 4) ndarray
        Unit quaternions in the order w, x, y, z, with w >= 0; where w is 0, the first component that is not
        zero is positive. float32 for float32, float64 for all else.

    Raises
    ------
    TypeError
        If `R` is not an array of real numbers.
    ValueError
        If the shape is another one, a value is not finite or a matrix not a rotation; the first index is
        named.

    See Also
    --------
    continuous : the same quaternions without jumps of sign between frames, to be scored.

    Examples
    --------
    >>> from npss.rotations import matrix_to_quaternion
    >>> matrix_to_quaternion([[1, 0, 0], [0, -1, 0], [0, 0, -1]])
    array([0., 1., 0., 0.])
    """
    return convert("R", R, MATRIX, QUATERNION)


def matrix_to_euler(R: npt.ArrayLike, *, seq: str = H36M) -> Array:
    """Convert rotation matrices to Euler angles, by default those in which Human3.6M is scored.

    Parameters
    ----------
    R : (..., 3, 3) array_like
        Rotation matrices. No entry of ``R @ R.T`` may be off the identity by more than 1e-6 in double
        precision (integers included), 1e-4 in single and 1e-2 in half precision, and the determinant must be
        positive.
    seq : str
        As in `expmap_to_euler`: ``"h36m"``, or three letters, upper case intrinsic, lower case extrinsic.

    Returns
    -------
    (..., 3) ndarray
        Angles in radians in the order of the letters; the outer ones in [-pi, pi], the middle one in [-pi/2,
        pi/2], or in [0, pi] where the first letter is also the last. At gimbal lock the third is zero.
        float32 for float32, float64 for all else.

    Raises
    ------
    TypeError
        If `R` is not an array of real numbers, or `seq` not a string.
    ValueError
        If the shape is another one, a value is not finite or a matrix not a rotation (the first index is
        named); if `seq` is no sequence.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.rotations import euler_to_matrix, matrix_to_euler
    >>> matrix_to_euler(euler_to_matrix([0.3, 0.2, 0.1])).round(12)
    array([0.3, 0.2, 0.1])
    """
    return convert("R", R, MATRIX, euler_form(seq))
