"""Generated motion in the common form: walks that need no data."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from npss.gait import gait
from npss.validation import positive_integer
from npss_baselines.data.human36m import joints_of_poses
from npss_baselines.data.motion import Clip


def synthetic_clips(n: int, n_frames: int, seed: int, *, fps: float = 30.0) -> Iterator[Clip]:
    """Generate walks along winding paths, each of another walker.

    Parameters
    ----------
    n : int
        Number of clips. The first clips are the same however many there are.
    n_frames : int
        Frames of each.
    seed : int
        Where the randomness comes from.
    fps : float, optional
        Frames per second.

    Yields
    ------
    Clip
        ``gait/0``, ``gait/1``, ..., in millimetres; the ground, y = 0, is where a foot is lowest. Feet slide.

    Raises
    ------
    TypeError, ValueError
        If a number is not a positive one; the seed may be 0.

    Examples
    --------
    >>> clip = next(synthetic_clips(1, 200, seed=0))
    >>> clip.name, clip.subject, clip.positions.shape
    ('gait/0', 'synthetic/0', (200, 20, 3))
    """
    for walker in range(positive_integer("n", n)):
        poses = gait(1, n_frames, fps=fps, seed=np.random.default_rng([seed, walker]))[0]
        # As they are, displacements sideways and up and turns of the root have a mean: it would drift and tumble.
        poses[:, [0, 1, 3, 5]] = 0
        poses[:, 4] /= 3  # radians per frame: bends, not spins
        positions = joints_of_poses(poses)
        positions[..., 1] -= positions[..., 1].min()
        yield Clip(f"gait/{walker}", "synthetic", f"synthetic/{walker}", "gait", fps, positions)
