"""A generated clip to try things out, whole and damaged."""

from __future__ import annotations

from dataclasses import replace

from npss.validation import Float64, positive_integer
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping
from npss_baselines.data.motion import NAMES
from npss_baselines.data.synthetic import synthetic_clips
from npss_baselines.manifold.clips.sampling import CENTIMETRES, figure
from npss_baselines.manifold.motion.dataset import prepare
from npss_baselines.manifold.motion.features import to_positions
from npss_baselines.manifold.motion.onto_skeleton import onto_skeleton

#: The frames in which the left leg is held from the knee on, and those in which the head jumps.
HELD, JUMPS = slice(60, 105), slice(130, 133)
_LEG = ("LeftLeg", "LeftFoot")


def example(n_frames: int = 180) -> Bvh:
    """Generate a walk on the common skeleton.

    Parameters
    ----------
    n_frames : int, optional
        The number of frames, at 30 per second.

    Returns
    -------
    Bvh
        The walk, in centimetres of a figure 170 high, y up; always the same.

    Raises
    ------
    ImportError
        If scipy is missing.
    TypeError, ValueError
        If the number is not positive, or too small for a walk.

    Examples
    --------
    >>> walk = example(60)
    >>> walk.rotations.shape[0], walk.fps
    (60, 30.0)
    """
    count = positive_integer("n_frames", n_frames)
    walks = prepare(synthetic_clips(1, count, seed=0))
    places: Float64 = to_positions(walks.features[0].astype(float)) * CENTIMETRES
    return onto_skeleton(places, figure(count), JointMapping({name: name for name in NAMES})).motion


def damaged(walk: Bvh) -> Bvh:
    """Damage a clip of `example`: the left leg is held from 2 to 3.5 s, and the head jumps at 4.3 s.

    Parameters
    ----------
    walk : Bvh
        The clip, of 134 frames or more.

    Returns
    -------
    Bvh
        The damaged clip.

    Raises
    ------
    ValueError
        If the clip is too short.

    Examples
    --------
    >>> broken = damaged(example())
    >>> bool((broken.rotations[60:105] == example().rotations[60:105]).all())
    False
    """
    if len(walk.rotations) <= JUMPS.stop:
        raise ValueError(f"walk: expected more than {JUMPS.stop} frames, got {len(walk.rotations)}")
    rotations, names = walk.rotations.copy(), walk.skeleton.names
    for name in _LEG:
        rotations[HELD, names.index(name)] = rotations[HELD.start, names.index(name)]
    neck = names.index("Neck")
    rotations[JUMPS, neck] = rotations[JUMPS, neck] @ rotations[0, names.index("RightUpLeg")]
    return replace(walk, rotations=rotations)
