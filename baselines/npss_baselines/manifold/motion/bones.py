"""Normalise bone lengths, so that all motion has the same skeleton."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Float64, each
from npss_baselines.manifold.motion.joints import first_frame, joint_named, positions_of

#: The first and the last joint of each leg.
LEGS = (("LeftUpLeg", "LeftFoot"), ("RightUpLeg", "RightFoot"))


def normalise_lengths(
    positions: npt.ArrayLike, skeleton: Skeleton, *, legs: Sequence[tuple[str, str]] = LEGS
) -> Float64:
    """Give every bone the length of the skeleton's bone, and keep its direction.

    The root's path and height are scaled by the ratio of leg lengths, skeleton to motion, so that steps keep their
    proportion to the legs and feet stay near the ground.

    Parameters
    ----------
    positions : (..., T, J, 3) array_like
        Positions of the skeleton's joints, y up, in any unit.
    skeleton : npss.skeleton.Skeleton
        Its offsets have the target lengths.
    legs : sequence of (str, str), optional
        First and last joint of each leg. A leg is as long as the bones from one to the other. Lengths are averaged over
        legs and, in the motion, over frames.

    Returns
    -------
    (..., T, J, 3) ndarray of float64
        Positions in the unit of the skeleton.

    Raises
    ------
    TypeError
        If `positions` does not hold real numbers, or `legs` is not a sequence.
    ValueError
        If the shape is wrong, a position is not finite, a leg is not a chain of bones or has no length, or a bone has
        length in the skeleton but none in the motion. The message names the joint and the first such frame.

    Examples
    --------
    >>> from npss.skeleton import Skeleton
    >>> leg = Skeleton(["hip", "knee", "foot"], [-1, 0, 1], [[0, 0, 0], [0, -5, 0], [0, -5, 0]])
    >>> bent = [[[8, 8, 0], [8, 4, 0], [8, 4, -4]]]
    >>> normalise_lengths(bent, leg, legs=[("hip", "foot")]).tolist()
    [[[10.0, 10.0, 0.0], [10.0, 5.0, 0.0], [10.0, 5.0, -5.0]]]
    """
    array = positions_of(positions, skeleton)
    chains = [_chain(skeleton, *pair) for pair in each("legs", legs, "pairs of joints")]
    if not chains:
        raise ValueError("legs: expected at least one pair of joints")
    joints = list(skeleton._order[1:])
    parents = [skeleton.parents[j] for j in joints]
    target_lengths = np.linalg.norm(skeleton.offsets, axis=-1)  # (J,)
    bones = array.copy()
    bones[..., joints, :] -= array[..., parents, :]
    lengths = np.linalg.norm(bones, axis=-1)  # (..., T, J)
    for j in joints:
        if target_lengths[j] > 0 and not lengths[..., j].all():
            raise ValueError(
                f"positions: {skeleton.names[j]} coincides with its parent {skeleton.names[skeleton.parents[j]]} "
                f"at frame {first_frame(lengths[..., j] == 0)}, so the bone has no direction"
            )
    target_leg, leg = _leg(target_lengths, chains), _leg(lengths, chains)
    if not target_leg > 0:
        raise ValueError("legs: the skeleton's legs have no length")
    bones[..., skeleton._order[0], :] *= target_leg / leg
    scale = np.divide(target_lengths, lengths, out=np.zeros_like(lengths), where=(lengths > 0) & (target_lengths > 0))
    bones[..., joints, :] *= scale[..., joints, np.newaxis]
    for j, parent in zip(joints, parents, strict=True):
        bones[..., j, :] += bones[..., parent, :]
    return bones


def leg_length(lengths: Float64, skeleton: Skeleton) -> float:
    """Return the length of a leg of `LEGS`, averaged over legs and frames, from the lengths of bones ``(..., J)``."""
    return _leg(lengths, [_chain(skeleton, *pair) for pair in LEGS])


def _leg(lengths: Float64, chains: Sequence[list[int]]) -> float:
    return float(np.mean([lengths[..., chain].sum(axis=-1).mean() for chain in chains]))


def _chain(skeleton: Skeleton, first: str, last: str) -> list[int]:
    """Return the joints whose bones lead from joint `first` down to joint `last`."""
    top, joint = joint_named("legs", skeleton, first), joint_named("legs", skeleton, last)
    chain = []
    while joint not in (top, -1):
        chain.append(joint)
        joint = skeleton.parents[joint]
    if joint == -1:
        raise ValueError(f"legs: {last} is not below {first} in the skeleton")
    return chain
