"""Conversions from Euler angles."""

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


@conversion(_contract.EULER, _contract.EXPMAP)
def euler_to_expmap(angles: npt.ArrayLike, *, seq: str = H36M) -> Array:
    """Convert Euler angles to exponential maps.

    {contract}

    Examples
    --------
    >>> from npss.rotations import euler_to_expmap
    >>> euler_to_expmap([0.3, 0, 0], seq="XYZ").round(12)
    array([0.3, 0. , 0. ])
    """
    return convert("angles", angles, euler_form(seq), EXPMAP)


@conversion(_contract.EULER, _contract.MATRIX)
def euler_to_matrix(angles: npt.ArrayLike, *, seq: str = H36M) -> Array:
    """Convert Euler angles to rotation matrices.

    {contract}

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


@conversion(_contract.EULER, _contract.QUATERNION)
def euler_to_quaternion(angles: npt.ArrayLike, *, seq: str = H36M) -> Array:
    """Convert Euler angles to unit quaternions.

    {contract}

    Examples
    --------
    >>> import numpy as np
    >>> from npss.rotations import euler_to_quaternion
    >>> euler_to_quaternion([np.pi / 2, 0, 0], seq="ZYX").round(4)
    array([0.7071, 0.    , 0.    , 0.7071])
    """
    return convert("angles", angles, euler_form(seq), QUATERNION)


@conversion(_contract.EULER, _contract.SIXD)
def euler_to_sixd(angles: npt.ArrayLike, *, seq: str = H36M, layout: Layout = COLUMNS) -> Array:
    """Convert Euler angles to the first two columns of rotation matrices.

    {contract}

    Examples
    --------
    >>> import numpy as np
    >>> from npss.rotations import euler_to_sixd
    >>> euler_to_sixd([np.pi / 2, 0, 0], seq="ZYX").round(12) + 0.0
    array([ 0.,  1.,  0., -1.,  0.,  0.])
    """
    return convert("angles", angles, euler_form(seq), sixd_form(layout))
