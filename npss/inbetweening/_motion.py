"""Motion of a skeleton, by local rotations and root or by global rotations and positions."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array, Float64, check_finite, real_array


class Local(NamedTuple):
    """Motion by rotations in the frames of parents.

    Attributes
    ----------
    quaternions : (..., T, J, 4) array_like
        The rotation of every joint in the frame of its parent, as unit quaternions w, x, y, z.
    root : (..., T, 3) array_like
        The position of the root.
    """

    quaternions: Array
    root: Array


class Global(NamedTuple):
    """Motion by rotations and positions in the frame of the world, or of a window.

    Attributes
    ----------
    quaternions : (..., T, J, 4) array_like
        The global rotation of every joint, as unit quaternions w, x, y, z.
    positions : (..., T, J, 3) array_like
        The position of every joint.
    """

    quaternions: Array
    positions: Array


def forward(motion: Local, skeleton: Skeleton) -> Global:
    """Compute global quaternions and positions by forward kinematics.

    Parameters
    ----------
    motion : Local
        Local rotations of the J joints of the skeleton, and the path of the root, with any leading axes.
    skeleton : Skeleton
        The joints. Their offsets are constant, in the unit of the root's path; the root's own is not used.

    Returns
    -------
    Global
        float64. Global quaternions are products of local ones, so they keep their hemispheres: a local motion that is
        continuous in time, and no joint of which is turned by half a turn from one frame to the next, is a global one.

    Raises
    ------
    TypeError
        If an array does not hold real numbers.
    ValueError
        If a shape is wrong, a value is not finite, or a quaternion is zero.

    See Also
    --------
    npss.skeleton.Skeleton.positions : positions from rotation matrices.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.inbetweening import Local, forward
    >>> from npss.skeleton import Skeleton
    >>> arm = Skeleton(["shoulder", "elbow", "hand"], [-1, 0, 1], [[0, 0, 0], [3, 0, 0], [2, 0, 0]])
    >>> half = np.sqrt(0.5)
    >>> bent = np.array([[[1, 0, 0, 0], [half, 0, 0, half], [1, 0, 0, 0]]])  # one frame; a quarter turn about z
    >>> forward(Local(bent, np.zeros((1, 3))), arm).positions.round(6)
    array([[[0., 0., 0.],
            [3., 0., 0.],
            [3., 2., 0.]]])
    """
    local, root = read_local("motion", motion)
    names, parents = skeleton.names, skeleton.parents
    if local.shape[-2] != len(names):
        raise ValueError(f"motion: expected the {len(names)} joints of the skeleton, got {local.shape[-2]}")
    quaternions = np.empty(local.shape)
    positions = np.empty((*local.shape[:-1], 3))
    done = [parents.index(-1)]
    quaternions[..., done[0], :], positions[..., done[0], :] = local[..., done[0], :], root
    for parent in done:  # grows
        for joint in (child for child in range(len(parents)) if parents[child] == parent):
            quaternions[..., joint, :] = multiply(quaternions[..., parent, :], local[..., joint, :])
            bone = rotate(quaternions[..., parent, :], skeleton.offsets[joint])
            positions[..., joint, :] = positions[..., parent, :] + bone
            done.append(joint)
    return Global(quaternions, positions)


def read_local(name: str, motion: Local) -> tuple[Float64, Float64]:
    """Read local rotations, normalised, and the root's path, in float64."""
    if not isinstance(motion, tuple) or len(motion) != 2:
        raise TypeError(f"{name}: expected Local(quaternions, root), got {type(motion).__name__}")
    quaternions, root = real_array(f"{name}: quaternions", motion[0]), real_array(f"{name}: root", motion[1])
    if quaternions.ndim < 3 or quaternions.shape[-1] != 4 or 0 in quaternions.shape:
        raise ValueError(f"{name}: quaternions: expected shape (..., T, J, 4), got {quaternions.shape}")
    if root.shape != (expected := (*quaternions.shape[:-2], 3)):
        raise ValueError(f"{name}: root: expected shape {expected}, got {root.shape}")
    check_finite(f"{name}: quaternions", quaternions)
    check_finite(f"{name}: root", root)
    return normalized(f"{name}: quaternions", quaternions.astype(np.float64)), root.astype(np.float64)


def normalized(name: str, quaternions: Float64) -> Float64:
    """Return unit quaternions."""
    lengths = np.sqrt(np.square(quaternions).sum(axis=-1, keepdims=True))
    if not lengths.all():
        index = tuple(int(i) for i in np.unravel_index(int(np.argmin(lengths)), lengths.shape[:-1]))
        raise ValueError(f"{name}: a zero quaternion, not a rotation, at index {index}")
    unit: Float64 = quaternions / lengths
    return unit


def multiply(first: npt.ArrayLike, second: npt.ArrayLike) -> Float64:
    """Return the quaternion of the rotation `second`, then `first`; leading axes are broadcast."""
    a, b, c, d = np.moveaxis(np.asarray(first), -1, 0)
    w, x, y, z = np.moveaxis(np.asarray(second), -1, 0)
    return np.stack(
        [
            a * w - b * x - c * y - d * z,
            a * x + b * w + c * z - d * y,
            a * y - b * z + c * w + d * x,
            a * z + b * y - c * x + d * w,
        ],
        axis=-1,
    )


def rotate(quaternions: Float64, vectors: Float64) -> Float64:
    """Rotate vectors by unit quaternions; leading axes are broadcast."""
    axis = quaternions[..., 1:]
    turned = 2 * np.cross(axis, vectors)
    rotated: Float64 = vectors + quaternions[..., :1] * turned + np.cross(axis, turned)
    return rotated
