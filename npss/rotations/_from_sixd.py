"""Conversions from the first two columns of rotation matrices."""

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


@conversion(_contract.SIXD, _contract.EXPMAP)
def sixd_to_expmap(sixd: npt.ArrayLike, *, layout: Layout = COLUMNS) -> Array:
    """Convert the first two columns of rotation matrices to exponential maps.

    {contract}

    Examples
    --------
    >>> from npss.rotations import sixd_to_expmap
    >>> sixd_to_expmap([0, 1, 0, -1, 0, 0]).round(4)
    array([0.    , 0.    , 1.5708])
    """
    return convert("sixd", sixd, sixd_form(layout), EXPMAP)


@conversion(_contract.SIXD, _contract.MATRIX)
def sixd_to_matrix(sixd: npt.ArrayLike, *, layout: Layout = COLUMNS) -> Array:
    """Complete the first two columns of rotation matrices.

    {contract}

    Notes
    -----
    Some code, such as PyTorch3D's, holds the first two *rows* of a matrix that rotates column vectors, one after the
    other. They are the columns of the transposed matrix: read them with ``layout="columns"``, and transpose.

    References
    ----------
    Y. Zhou, C. Barnes, J. Lu, J. Yang, H. Li, "On the Continuity of Rotation Representations in Neural Networks", CVPR
    2019, equation 15.

    Examples
    --------
    >>> from npss.rotations import sixd_to_matrix
    >>> sixd_to_matrix([0, 2, 0, -1, 1, 0])
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    >>> sixd_to_matrix([0, -1, 1, 0, 0, 0], layout="rows")
    array([[ 0., -1.,  0.],
           [ 1.,  0.,  0.],
           [ 0.,  0.,  1.]])
    """
    return convert("sixd", sixd, sixd_form(layout), MATRIX)


@conversion(_contract.SIXD, _contract.QUATERNION)
def sixd_to_quaternion(sixd: npt.ArrayLike, *, layout: Layout = COLUMNS) -> Array:
    """Convert the first two columns of rotation matrices to unit quaternions.

    {contract}

    Examples
    --------
    >>> from npss.rotations import sixd_to_quaternion
    >>> sixd_to_quaternion([0, 1, 0, -1, 0, 0]).round(4)
    array([0.7071, 0.    , 0.    , 0.7071])
    """
    return convert("sixd", sixd, sixd_form(layout), QUATERNION)


@conversion(_contract.SIXD, _contract.EULER)
def sixd_to_euler(sixd: npt.ArrayLike, *, seq: str = H36M, layout: Layout = COLUMNS) -> Array:
    """Convert the first two columns of rotation matrices to Euler angles, by default in the Human3.6M convention.

    {contract}

    Examples
    --------
    >>> from npss.rotations import sixd_to_euler
    >>> sixd_to_euler([0, 1, 0, -1, 0, 0], seq="ZYX").round(4)
    array([1.5708, 0.    , 0.    ])
    """
    return convert("sixd", sixd, sixd_form(layout), euler_form(seq))
