"""Sample motion from a manifold, as a clip on the common skeleton."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Seed, positive_integer
from npss_baselines.data.bvh import CHANNELS, Bvh
from npss_baselines.data.mapping import JointMapping
from npss_baselines.data.motion import JOINTS, NAMES
from npss_baselines.manifold.applications.sample import motion_of, sample_codes
from npss_baselines.manifold.clips.outcome import Outcome
from npss_baselines.manifold.model.prior import NEIGHBOURS
from npss_baselines.manifold.motion.features import FPS, to_positions
from npss_baselines.manifold.motion.onto_skeleton import onto_skeleton
from npss_baselines.manifold.motion.windows import WINDOW

if TYPE_CHECKING:
    from npss_baselines.manifold.model.projector import Projector  # imports torch

#: The body height of a sampled figure, in the unit of its file: centimetres, as most programs expect.
CENTIMETRES = 170.0


def sample(
    manifold: Projector, *, n_frames: int = WINDOW, real: npt.ArrayLike | None = None, seed: Seed = 0
) -> Outcome:
    """Sample motion from random codes, on the common skeleton, with its bone lengths.

    Parameters
    ----------
    manifold : Projector
        The manifold, as `npss_baselines.manifold.training.folder.load` returns it in `Run.projector`.
    n_frames : int, optional
        The number of frames, at 30 per second.
    real : (N, n_frames, 63) array_like, optional
        Features of real motion, five or more: codes are drawn around theirs, see `npss_baselines.manifold.model.prior`.
        By default each unit is drawn uniformly from [-1, 1], the paper's prior, which gives no plausible motion.
    seed : int or numpy.random.Generator, optional
        Source of randomness.

    Returns
    -------
    Outcome
        The motion, in centimetres of a figure 170 high, y up.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
    """
    count = positive_integer("n_frames", n_frames)
    shape = manifold.encode(np.zeros((1, count, 3 * len(NAMES) + 3))).shape
    if real is None:
        codes, way = sample_codes(np.zeros(shape), 1, prior="uniform", seed=seed), "uniform"
    else:
        if len(np.asarray(real)) <= NEIGHBOURS:
            raise ValueError(f"real: expected more than {NEIGHBOURS} motions, got {len(np.asarray(real))}")
        codes, way = sample_codes(manifold.encode(real), 1, seed=seed), "local"
    places = to_positions(motion_of(manifold, codes, count)[0]) * CENTIMETRES
    mapping = JointMapping({name: name for name in NAMES})
    fitted = onto_skeleton(places, figure(count), mapping)
    return Outcome(fitted.motion, mapping, "y", f"{way} of {manifold.signature}", (), fitted.error / CENTIMETRES)


def figure(n_frames: int) -> Bvh:
    """Return the common skeleton as a clip of its rest pose, with an end site below each joint that has no other."""
    ends = [joint for joint in range(len(NAMES)) if joint not in JOINTS.parents]
    names = [*NAMES, *(f"{NAMES[joint]}End" for joint in ends)]
    parents = [*JOINTS.parents, *ends]
    offsets = CENTIMETRES * np.concatenate([JOINTS.offsets, JOINTS.offsets[ends] / 2])
    skeleton = Skeleton(names, parents, offsets)
    positions, rotations = CHANNELS[:3], ("Zrotation", "Xrotation", "Yrotation")
    channels = [(*positions, *rotations) if parent < 0 else rotations for parent in JOINTS.parents]
    return Bvh(
        skeleton,
        (*channels, *(None for _ in ends)),
        np.tile(np.eye(3), (n_frames, len(names), 1, 1)),
        np.tile(offsets, (n_frames, 1, 1)),
        float(FPS),
    )
