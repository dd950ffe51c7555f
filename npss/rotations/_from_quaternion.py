"""Conversions from quaternions."""

from __future__ import annotations

import numpy.typing as npt

from npss.rotations._euler import H36M, euler_form
from npss.rotations._expmap import EXPMAP
from npss.rotations._forms import convert
from npss.rotations._matrix import MATRIX
from npss.rotations._quaternion import QUATERNION
from npss.validation import Array


def quaternion_to_expmap(q: npt.ArrayLike) -> Array:
    """Convert quaternions to exponential maps.

    Parameters
    ----------
    q : (..., 4) array_like
        Quaternions in the order w, x, y, z, of any length but zero; q and -q are the same rotation.

    Returns
    -------
    (..., 3) ndarray
        Rotation vectors in radians of length in [0, pi]; at pi, where v and -v are one rotation, the first
        component that is not zero is positive. float32 for float32, float64 for all else.

    Raises
    ------
    TypeError
        If `q` is not an array of real numbers.
    ValueError
        If the shape is another one, a value is not finite or a quaternion is zero; the first index is named.

    Examples
    --------
    >>> from npss.rotations import quaternion_to_expmap
    >>> quaternion_to_expmap([1, 0, 0, 1]).round(4)
    array([0.    , 0.    , 1.5708])
    """
    return convert("q", q, QUATERNION, EXPMAP)


def quaternion_to_matrix(q: npt.ArrayLike) -> Array:
    """Convert quaternions to rotation matrices.

    Parameters
    ----------
    q : (..., 4) array_like
        Quaternions in the order w, x, y, z, of any length but zero; q and -q are the same rotation.

    Returns
    -------
    (..., 3, 3) ndarray
        Matrices R that rotate column vectors, ``R @ x``. float32 for float32, float64 for all else.

    Raises
    ------
    TypeError
        If `q` is not an array of real numbers.
    ValueError
        If the shape is another one, a value is not finite or a quaternion is zero; the first index is named.

    Examples
    --------
    >>> from npss.rotations import quaternion_to_matrix
    >>> quaternion_to_matrix([0, 2, 0, 0])
    array([[ 1.,  0.,  0.],
           [ 0., -1.,  0.],
           [ 0.,  0., -1.]])
    """
    return convert("q", q, QUATERNION, MATRIX)


def quaternion_to_euler(q: npt.ArrayLike, *, seq: str = H36M) -> Array:
    """Convert quaternions to Euler angles, by default those in which Human3.6M is scored.

    Parameters
    ----------
    q : (..., 4) array_like
        Quaternions in the order w, x, y, z, of any length but zero; q and -q are the same rotation.
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
        If `q` is not an array of real numbers, or `seq` not a string.
    ValueError
        If the shape is another one, a value is not finite or a quaternion is zero (the first index is named);
        if `seq` is no sequence.

    Examples
    --------
    >>> from npss.rotations import quaternion_to_euler
    >>> quaternion_to_euler([1, 0, 0, 1], seq="ZYX").round(4)
    array([1.5708, 0.    , 0.    ])
    """
    return convert("q", q, QUATERNION, euler_form(seq))
