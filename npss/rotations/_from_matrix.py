"""Conversions from rotation matrices."""

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


@conversion(_contract.MATRIX, _contract.EXPMAP)
def matrix_to_expmap(R: npt.ArrayLike) -> Array:
    """Convert rotation matrices to exponential maps (the logarithm).

    {contract}

    Examples
    --------
    >>> from npss.rotations import matrix_to_expmap
    >>> matrix_to_expmap([[0, -1, 0], [1, 0, 0], [0, 0, 1]]).round(4)
    array([0.    , 0.    , 1.5708])
    """
    return convert("R", R, MATRIX, EXPMAP)


@conversion(_contract.MATRIX, _contract.QUATERNION)
def matrix_to_quaternion(R: npt.ArrayLike) -> Array:
    """Convert rotation matrices to unit quaternions.

    {contract}

    Examples
    --------
    >>> from npss.rotations import matrix_to_quaternion
    >>> matrix_to_quaternion([[1, 0, 0], [0, -1, 0], [0, 0, -1]])
    array([0., 1., 0., 0.])
    """
    return convert("R", R, MATRIX, QUATERNION)


@conversion(_contract.MATRIX, _contract.EULER)
def matrix_to_euler(R: npt.ArrayLike, *, seq: str = H36M) -> Array:
    """Convert rotation matrices to Euler angles, by default in the Human3.6M convention.

    {contract}

    Examples
    --------
    >>> import numpy as np
    >>> from npss.rotations import euler_to_matrix, matrix_to_euler
    >>> matrix_to_euler(euler_to_matrix([0.3, 0.2, 0.1])).round(12)
    array([0.3, 0.2, 0.1])
    """
    return convert("R", R, MATRIX, euler_form(seq))


@conversion(_contract.MATRIX, _contract.SIXD)
def matrix_to_sixd(R: npt.ArrayLike, *, layout: Layout = COLUMNS) -> Array:
    """Return the first two columns of rotation matrices.

    {contract}

    Examples
    --------
    >>> from npss.rotations import matrix_to_sixd
    >>> matrix_to_sixd([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    array([ 0.,  1.,  0., -1.,  0.,  0.])
    >>> matrix_to_sixd([[0, -1, 0], [1, 0, 0], [0, 0, 1]], layout="rows")
    array([ 0., -1.,  1.,  0.,  0.,  0.])
    """
    return convert("R", R, MATRIX, sixd_form(layout))
