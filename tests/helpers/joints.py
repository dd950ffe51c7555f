"""Checks of positions of the 20 joints."""

import numpy as np

from npss_baselines.data.motion import JOINTS, NAMES


def at(positions, name):
    return positions[..., NAMES.index(name), :]


def lengths(positions):
    """Return the lengths of all bones, ``(..., 19)``."""
    return np.stack([np.linalg.norm(positions[..., j, :] - positions[..., p, :], axis=-1) for j, p in JOINTS.bones], -1)


def assert_left_is_left(positions):
    """Check sides: with x to the left and y up, toes are ahead of ankles and the head is up."""
    left = at(positions, "LeftUpLeg") - at(positions, "RightUpLeg")
    up = at(positions, "Neck") - at(positions, "Hips")
    ahead = np.cross(left, up)
    for side in ("Left", "Right"):
        foot = at(positions, f"{side}ToeBase") - at(positions, f"{side}Foot")
        assert ((foot * ahead).sum(-1) > 0).mean() > 0.8
    arms = at(positions, "LeftArm") - at(positions, "RightArm")
    assert ((arms * left).sum(-1) > 0).mean() > 0.8
