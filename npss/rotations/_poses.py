"""Convert Human3.6M poses to the Euler angles that are scored."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.rotations._blocks import BadRotationError, in_blocks
from npss.rotations._euler import H36M, euler_form
from npss.rotations._expmap import EXPMAP
from npss.rotations._forms import converter, rotation_array
from npss.rotations._legacy import legacy_euler
from npss.validation import Array, Float64, check_finite

#: Columns of a pose.
POSE = 99
#: Leading columns that are not scored: translation and rotation of the root.
UNSCORED = 6
#: Scored rotations.
JOINTS = (POSE - UNSCORED) // 3


def poses_to_euler(poses: npt.ArrayLike, *, legacy: bool = False) -> Float64:
    """Convert Human3.6M poses from exponential maps to Euler angles, and set unscored columns to zero.

    Parameters
    ----------
    poses : (..., 99) array_like
        Columns 0-2 are the translation, 3-5 the rotation of the root, then 31 joints with three columns each;
        all rotations are exponential maps in radians.
    legacy : bool
        Reproduce the released code to rounding, flaws included: see `npss.rotations.expmap_to_euler`.

    Returns
    -------
    (..., 99) ndarray
        Zeros in columns 0-5, then the Euler angles of the joints in radians, in the Human3.6M convention. float64 for
        any precision of `poses`.

    Raises
    ------
    TypeError
        If `poses` is not an array of real numbers.
    ValueError
        If the last axis does not have 99 columns, a value in any column is not finite, or an angle is 2**52 or more.
        The message names the first index.

    Examples
    --------
    >>> import numpy as np
    >>> from npss import poses_to_euler
    >>> poses = np.full((2, 99), 0.3)
    >>> poses_to_euler(poses).reshape(2, 33, 3)[0, :3].round(4)
    array([[ 0.    ,  0.    ,  0.    ],
           [ 0.    ,  0.    ,  0.    ],
           [-0.2601, -0.337 , -0.2601]])
    """
    array = rotation_array("poses", poses, (POSE,))
    if not np.isfinite(array[..., :UNSCORED]).all():
        check_finite("poses", array)
    out = np.zeros(array.shape)
    kernel = legacy_euler if legacy else converter(EXPMAP, euler_form(H36M), array.dtype)
    try:
        in_blocks(_joints(array), _joints(out), (1, 1), kernel, out.dtype)
        return out
    except BadRotationError as error:
        bad = error
    check_finite("poses", array)
    *frame, joint = (int(i) for i in np.unravel_index(bad.position, _joints(array).shape[:-1]))
    raise ValueError(f"poses: {bad.what} at index {(*frame, UNSCORED + 3 * joint)}")


def _joints(poses: Array) -> Array:
    """View the scored columns as rotation vectors ``(..., 31, 3)``."""
    return poses[..., UNSCORED:].reshape((*poses.shape[:-1], JOINTS, 3))
