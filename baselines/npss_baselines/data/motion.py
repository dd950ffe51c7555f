"""The common form of motion: positions of the same 20 joints for every skeleton."""

from __future__ import annotations

import re
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from npss.skeleton import H36M, Skeleton, poses_to_positions
from npss.validation import Float64, check_finite, is_real, real_array

# Connected joints, from the root on. The arms start at the neck: in Human3.6M's skeleton, the shoulders, the parents of
# the arms, coincide with the neck.
_CHAINS = (
    ("Hips", "LeftUpLeg", "LeftLeg", "LeftFoot", "LeftToeBase"),
    ("Hips", "RightUpLeg", "RightLeg", "RightFoot", "RightToeBase"),
    ("Hips", "Spine1", "Neck", "Head"),
    ("Neck", "LeftArm", "LeftForeArm", "LeftHand", "LeftHandIndex"),
    ("Neck", "RightArm", "RightForeArm", "RightHand", "RightHandIndex"),
)
#: The 20 joints, named as in `npss.skeleton.H36M`.
NAMES = ("Hips", *(name for chain in _CHAINS for name in chain[1:]))
#: The body height, from the ground under the rest pose to its topmost joint, the head: the unit of all lengths.
HEIGHT = 1.0


@dataclass(frozen=True, eq=False)
class Clip:
    """A piece of motion in the common form.

    Attributes
    ----------
    name : str
        Unique within its source: ``02_01``, ``salsa/03``, ``S5/walking_1``.
    source : str
        ``cmu``, ``cmu-styles``, ``h36m``, ``bvh`` or ``synthetic``.
    subject : str
        The person: ``cmu/02``, ``h36m/S5``, ``synthetic/3``; empty if the source does not say.
    description : str
        The action, in the words of the source.
    fps : float
        Frames per second.
    positions : (T, 20, 3) ndarray of float64
        Positions of the joints of `JOINTS`, path included, in the source's unit of length. y is up as far as the
        source knows; for Human3.6M, see `npss_baselines.data.h36m_source.h36m_clips`.

    Raises
    ------
    TypeError
        If `fps` or `positions` does not hold real numbers.
    ValueError
        If `fps` is not positive, the shape is wrong, or a value is not finite. Names the clip.
    """

    name: str
    source: str
    subject: str
    description: str
    fps: float
    positions: Float64

    def __post_init__(self) -> None:
        where = f"{self.source} {self.name}"
        if not is_real(self.fps):
            raise TypeError(f"{where}: fps: expected a positive number, got {self.fps!r}")
        if not (np.isfinite(self.fps) and self.fps > 0):
            raise ValueError(f"{where}: fps: expected a positive, finite number, got {self.fps!r}")
        positions = real_array(f"{where}: positions", self.positions)
        if positions.ndim != 3 or positions.shape[1:] != (len(NAMES), 3):
            raise ValueError(f"{where}: positions: expected shape (T, {len(NAMES)}, 3), got {positions.shape}")
        check_finite(f"{where}: positions", positions)
        object.__setattr__(self, "positions", positions.astype(np.float64, copy=False))


def _joints() -> Skeleton:
    """Build the joints from Human3.6M's skeleton: arms to the sides, symmetric, on the ground, of height 1."""
    pose = np.tile(np.eye(3), (len(H36M.names), 1, 1))
    for side, x in (("Left", 1), ("Right", -1)):  # its arms point up; a turn about z points them to the sides
        pose[H36M.names.index(f"{side}Shoulder")] = [[0, x, 0], [-x, 0, 0], [0, 0, 1]]
    rest = H36M.positions(pose)[[H36M.names.index(name) for name in NAMES]]
    other = {"Left": "Right", "Right": "Left"}
    mirrored = [NAMES.index(re.sub("^(Left|Right)", lambda side: other[side[0]], name)) for name in NAMES]
    rest = (rest + rest[mirrored] * (-1, 1, 1)) / 2
    rest[:, 1] -= rest[:, 1].min()
    rest *= HEIGHT / rest[:, 1].max()
    parent_of = {joint: parent for chain in _CHAINS for parent, joint in pairwise(chain)}
    parents = [NAMES.index(parent_of[name]) if name in parent_of else -1 for name in NAMES]
    return Skeleton(
        NAMES, parents, [rest[j] - rest[parent] if parent >= 0 else rest[j] for j, parent in enumerate(parents)]
    )


#: The 20 joints with the bone lengths of Human3.6M's skeleton, made symmetric; x points to the figure's left, y up,
#: z ahead. The rest pose stands on the ground, y = 0, with its arms to the sides.
JOINTS = _joints()
_IN_POSES = [H36M.names.index(name) for name in NAMES]


def joints_of_poses(poses: npt.ArrayLike) -> Float64:
    """Compute the 20 joints' positions ``(..., T, 20, 3)``, in mm, with path, of Human3.6M's poses ``(..., T, 99)``."""
    positions: Float64 = poses_to_positions(np.asarray(poses, np.float64), root="path")[..., _IN_POSES, :]
    return positions
