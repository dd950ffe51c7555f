"""Conversions from quaternions."""

from __future__ import annotations

import numpy.typing as npt

from npss.rotations import _contract
from npss.rotations._contract import conversion
from npss.rotations._euler import H36M, euler_form
from npss.rotations._expmap import EXPMAP
from npss.rotations._forms import convert
from npss.rotations._matrix import MATRIX
from npss.rotations._quaternion import QUATERNION
from npss.rotations._sixd import COLUMNS, Layout, sixd_form
from npss.validation import Array


@conversion(_contract.QUATERNION, _contract.EXPMAP)
def quaternion_to_expmap(q: npt.ArrayLike) -> Array:
    """Convert quaternions to exponential maps.

    {contract}

    Examples
    --------
    >>> from npss.rotations import quaternion_to_expmap
    >>> quaternion_to_expmap([1, 0, 0, 1]).round(4)
    array([0.    , 0.    , 1.5708])
    """
    return convert("q", q, QUATERNION, EXPMAP)


@conversion(_contract.QUATERNION, _contract.MATRIX)
def quaternion_to_matrix(q: npt.ArrayLike) -> Array:
    """Convert quaternions to rotation matrices.

    {contract}

    Examples
    --------
    >>> from npss.rotations import quaternion_to_matrix
    >>> quaternion_to_matrix([0, 2, 0, 0])
    array([[ 1.,  0.,  0.],
           [ 0., -1.,  0.],
           [ 0.,  0., -1.]])
    """
    return convert("q", q, QUATERNION, MATRIX)


@conversion(_contract.QUATERNION, _contract.EULER)
def quaternion_to_euler(q: npt.ArrayLike, *, seq: str = H36M) -> Array:
    """Convert quaternions to Euler angles, by default in the Human3.6M convention.

    {contract}

    Examples
    --------
    >>> from npss.rotations import quaternion_to_euler
    >>> quaternion_to_euler([1, 0, 0, 1], seq="ZYX").round(4)
    array([1.5708, 0.    , 0.    ])
    """
    return convert("q", q, QUATERNION, euler_form(seq))


@conversion(_contract.QUATERNION, _contract.SIXD)
def quaternion_to_sixd(q: npt.ArrayLike, *, layout: Layout = COLUMNS) -> Array:
    """Convert quaternions to the first two columns of rotation matrices.

    {contract}

    Examples
    --------
    >>> from npss.rotations import quaternion_to_sixd
    >>> quaternion_to_sixd([1, 0, 0, 1])
    array([ 0.,  1.,  0., -1.,  0.,  0.])
    """
    return convert("q", q, QUATERNION, sixd_form(layout))
