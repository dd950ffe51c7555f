"""One length for every bone: motion of any figure on the same skeleton."""

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
    """Give every bone the length that it has in a skeleton; its direction stays.

    The place of the root, path and height, is scaled by the length of the legs in the skeleton over that in the
    motion: steps keep their proportion to the legs, and feet stay near the ground.

    Parameters
    ----------
    positions : (..., T, J, 3) array_like
        Positions of the skeleton's joints, y up, in any unit.
    skeleton : npss.skeleton.Skeleton
        The lengths: those of its offsets.
    legs : sequence of (str, str), optional
        First and last joint of each leg. The length of a leg is that of the bones from one to the other; that of all is
        the mean over legs, in a motion over frames too.

    Returns
    -------
    (..., T, J, 3) ndarray of float64
        In the unit of the skeleton.

    Raises
    ------
    TypeError
        If `positions` does not hold real numbers, or `legs` is no sequence.
    ValueError
        If the shape is another one, a position is not finite, a leg is no chain of the skeleton's bones or has no
        length, or a joint is where its parent is and the skeleton has a bone there: names it, and the first frame.

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
        raise ValueError("legs: no leg")
    joints = list(skeleton._order[1:])
    parents = [skeleton.parents[j] for j in joints]
    wanted = np.linalg.norm(skeleton.offsets, axis=-1)  # (J,)
    bones = array.copy()
    bones[..., joints, :] -= array[..., parents, :]
    given = np.linalg.norm(bones, axis=-1)  # (..., T, J)
    for j in joints:
        if wanted[j] > 0 and not given[..., j].all():
            raise ValueError(
                f"positions: {skeleton.names[j]} is where its parent {skeleton.names[skeleton.parents[j]]} is, "
                f"at frame {first_frame(given[..., j] == 0)}; no direction, no bone"
            )
    leg_wanted = np.mean([wanted[chain].sum() for chain in chains])
    leg_given = np.mean([given[..., chain].sum(axis=-1).mean() for chain in chains])
    if not leg_wanted > 0:
        raise ValueError("legs: they have no length in the skeleton")
    bones[..., skeleton._order[0], :] *= leg_wanted / leg_given
    scale = np.divide(wanted, given, out=np.zeros_like(given), where=(given > 0) & (wanted > 0))
    bones[..., joints, :] *= scale[..., joints, np.newaxis]
    for j, parent in zip(joints, parents, strict=True):
        bones[..., j, :] += bones[..., parent, :]
    return bones


def _chain(skeleton: Skeleton, first: str, last: str) -> list[int]:
    """Return the joints at whose bones one gets from joint `first` down to joint `last`."""
    top, joint = joint_named("legs", skeleton, first), joint_named("legs", skeleton, last)
    chain = []
    while joint not in (top, -1):
        chain.append(joint)
        joint = skeleton.parents[joint]
    if joint == -1:
        raise ValueError(f"legs: {last} does not hang on {first}")
    return chain
