"""Compare a restored clip with the truth."""

from __future__ import annotations

import numpy as np

from npss_baselines.data.bvh import Bvh
from npss_baselines.manifold.clips.filling import last_known
from npss_baselines.manifold.clips.gap import lost_in
from npss_baselines.manifold.clips.outcome import Outcome
from npss_baselines.manifold.motion.own_clip import body_height


def restoration_error(motion: Bvh, truth: Bvh, outcome: Outcome) -> float:
    """Return the mean distance of the joints that were missing from the truth, in body heights.

    Parameters
    ----------
    motion : Bvh
        The clip before or after restoration; values that are not numbers count as the last known ones.
    truth : Bvh
        The clip without damage, on the same skeleton.
    outcome : Outcome
        The result of restoration, which knows what was missing.

    Raises
    ------
    ValueError
        If the truth has another number of frames or other joints.
    """
    mapping, skeleton = outcome.mapping, outcome.motion.skeleton
    if truth.skeleton.names != skeleton.names:
        raise ValueError("truth: expected the joints of the clip")
    if len(truth.rotations) != len(motion.rotations):
        raise ValueError(f"truth: {len(truth.rotations)} frames, but the clip has {len(motion.rotations)}")
    right = mapping.positions(truth.positions(), skeleton)
    rotations, translations = last_known(motion.rotations), last_known(motion.translations)
    places = mapping.positions(skeleton.positions(rotations, offsets=translations), skeleton)
    lost = lost_in(outcome.gaps, motion, mapping).places
    distances = np.linalg.norm(places - right, axis=-1)[lost]
    return float(distances.mean() / body_height(right)) if distances.size else 0.0
