"""Conversions from the exponential map."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.rotations import _contract
from npss.rotations._blocks import fill
from npss.rotations._contract import conversion
from npss.rotations._euler import H36M, euler_form
from npss.rotations._expmap import EXPMAP
from npss.rotations._forms import convert, result_dtype, rotation_array
from npss.rotations._legacy import legacy_euler
from npss.rotations._matrix import MATRIX
from npss.rotations._quaternion import QUATERNION
from npss.rotations._sixd import COLUMNS, Layout, sixd_form
from npss.validation import Array


@conversion(_contract.EXPMAP, _contract.MATRIX)
def expmap_to_matrix(v: npt.ArrayLike) -> Array:
    """Convert exponential maps to rotation matrices (Rodrigues' formula).

    {contract}

    Examples
    --------
    A quarter turn about z rotates x to y:

    >>> import numpy as np
    >>> from npss.rotations import expmap_to_matrix
    >>> R = expmap_to_matrix([0, 0, np.pi / 2])
    >>> (R @ [1, 0, 0]).round(12)
    array([0., 1., 0.])
    """
    return convert("v", v, EXPMAP, MATRIX)


@conversion(_contract.EXPMAP, _contract.QUATERNION)
def expmap_to_quaternion(v: npt.ArrayLike) -> Array:
    """Convert exponential maps to unit quaternions.

    {contract}

    Examples
    --------
    >>> import numpy as np
    >>> from npss.rotations import expmap_to_quaternion
    >>> expmap_to_quaternion([0, 0, np.pi / 2]).round(4)
    array([0.7071, 0.    , 0.    , 0.7071])
    """
    return convert("v", v, EXPMAP, QUATERNION)


def expmap_to_euler(v: npt.ArrayLike, *, seq: str = H36M, legacy: bool = False) -> Array:
    """Convert exponential maps to Euler angles, by default in the Human3.6M convention.

    Parameters
    ----------
    v : (..., 3) array_like
        Rotation vectors: axis times angle in radians. Any angle below 2**52.
    seq : str
        ``"h36m"``: the Human3.6M convention, see Notes. Or three letters, upper case for rotations about the axes of
        the moving frame (intrinsic), lower case for the fixed frame (extrinsic), the first letter first: ``"XYZ"`` is
        Rx(a) @ Ry(b) @ Rz(c), ``"xyz"`` is Rz(c) @ Ry(b) @ Rx(a).
    legacy : bool
        Reproduce the released code of the NPSS paper to rounding, flaws included; only with ``seq="h36m"``.

    Returns
    -------
    (..., 3) ndarray
        Angles in radians in the order of the letters; the outer ones in [-pi, pi], the middle one in [-pi/2, pi/2], or
        in [0, pi] if the first letter is also the last. float32 for float32, float64 otherwise.

    Raises
    ------
    TypeError
        If `v` is not an array of real numbers, or `seq` is not a string.
    ValueError
        If the shape is wrong, or a value is not finite or an angle too large (the message names the first index); if
        `seq` is not a sequence; if `legacy` is set and `seq` is not ``"h36m"``.

    Notes
    -----
    With the matrix R of v, the Human3.6M angles are those of the NPSS paper, the negated angles of ``"XYZ"``::

        E2 = -asin R[0, 2]
        E1 = atan2(R[1, 2] / cos E2, R[2, 2] / cos E2)
        E3 = atan2(R[0, 1] / cos E2, R[0, 0] / cos E2)

    They are computed from an unnormalised quaternion, to working precision at every angle, including 0, pi and 2 pi,
    and reproduce the rotation even near gimbal lock. Within about sixteen machine epsilons of it, where only the sum
    or the difference of the outer angles is determined, the third angle is zero.

    The released code, `legacy`, divides v by its length plus 1.19e-7. Its error is about as large, and 1.5e-3 rad at
    1e-4 rad from gimbal lock. At gimbal lock (never reached by an angle below 1e8) it returns the angles of another
    rotation. It is computed in float64 for any precision of `v`.

    References
    ----------
    A. Gopalakrishnan, A. Mali, D. Kifer, C. L. Giles, A. G. Ororbia. "A Neural Temporal Model for
       Human Motion Prediction." CVPR 2019.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.rotations import expmap_to_euler
    >>> expmap_to_euler([[0.3, 0, 0], [0, 0.3, 0]])
    array([[-0.3,  0. ,  0. ],
           [ 0. , -0.3,  0. ]])
    >>> expmap_to_euler([0.3, 0.2, 0.1], seq="zyx").round(4)
    array([0.0696, 0.2118, 0.2938])
    """
    euler = euler_form(seq)
    if not legacy:
        return convert("v", v, EXPMAP, euler)
    if seq != H36M:
        raise ValueError(f"legacy: the released code supports only seq={H36M!r}, got seq={seq!r}")
    array = rotation_array("v", v, EXPMAP.shape)
    out = np.empty(array.shape, result_dtype(array))
    fill("v", array, out, (1, 1), legacy_euler, np.dtype(np.float64))
    return out


@conversion(_contract.EXPMAP, _contract.SIXD)
def expmap_to_sixd(v: npt.ArrayLike, *, layout: Layout = COLUMNS) -> Array:
    """Convert exponential maps to the first two columns of rotation matrices.

    {contract}

    Examples
    --------
    >>> import numpy as np
    >>> from npss.rotations import expmap_to_sixd
    >>> expmap_to_sixd([0, 0, np.pi / 2]).round(12) + 0.0
    array([ 0.,  1.,  0., -1.,  0.,  0.])
    """
    return convert("v", v, EXPMAP, sixd_form(layout))
