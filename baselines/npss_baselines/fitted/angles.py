"""The angles that predictors are fitted to: the Euler angles that are scored, and their mirror images."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss import poses_to_euler
from npss.protocol import COLUMNS
from npss.rotations import euler_to_expmap
from npss.skeleton import H36M
from npss.validation import Float64

ROOT = 6  # columns of translation and rotation of the root, which are not scored
#: The columns of a pose that are predicted: those that vary and are scored.
ANGLES = tuple(column for column in COLUMNS if column >= ROOT)
_GIMBAL = np.pi / 2 - 1e-3  # the largest second angle: beyond a right angle, Euler angles jump


def angles_of(poses: npt.ArrayLike) -> Float64:
    """Return the Euler angles (..., 48) in radians of poses (..., 99)."""
    return poses_to_euler(poses)[..., list(ANGLES)]


def poses_of(angles: Float64, last: Float64) -> Float64:
    """Return poses (N, T, 99) with these Euler angles (N, T, 48); other columns are those of a pose (N, 99)."""
    euler = np.repeat(poses_to_euler(last)[:, np.newaxis], angles.shape[1], axis=1)
    euler[..., list(ANGLES)] = angles
    joints = euler[..., ROOT:].reshape(*euler.shape[:-1], -1, 3)
    joints[..., 1] = np.clip(joints[..., 1], -_GIMBAL, _GIMBAL)
    poses = np.repeat(last[:, np.newaxis], angles.shape[1], axis=1)
    poses[..., ROOT:] = euler_to_expmap(joints).reshape(*poses.shape[:-1], -1)
    return poses


def mirrored(angles: npt.NDArray[np.floating]) -> npt.NDArray[np.floating]:
    """Return the angles (..., 48) of the mirror image: left and right change places, turns about y and z their sign."""
    return angles[..., SWAPPED] * SIGNS.astype(angles.dtype)


def _swapped() -> tuple[int, ...]:
    """Return the place, among `ANGLES`, of the angle of the other side."""
    other = {
        name: name.replace(side, opposite)
        for side, opposite in (("Left", "Right"), ("Right", "Left"))
        for name in H36M.names
        if name.startswith(side)
    }
    joint = [H36M.names.index(other.get(name, name)) for name in H36M.names]
    return tuple(ANGLES.index(3 + 3 * joint[(column - 3) // 3] + column % 3) for column in ANGLES)


#: The place of the same angle on the other side, and its sign there.
SWAPPED = list(_swapped())
SIGNS = np.array([1.0 if column % 3 == 0 else -1.0 for column in ANGLES])
