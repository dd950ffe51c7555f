"""Insert frames into a clip, where some were deleted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from npss.validation import is_integer, positive_integer
from npss_baselines.data.bvh import Bvh

#: The most frames that are put in: what is made up over minutes is no motion.
MOST = 10_000


def insert(motion: Bvh, at: int, count: int) -> Bvh:
    """Insert copies of a frame, to be restored by `repair`.

    Parameters
    ----------
    motion : Bvh
        The clip.
    at : int
        The frame before which frames are inserted, not the first one.
    count : int
        The number of frames.

    Returns
    -------
    Bvh
        The clip, in which the frame before is repeated: the new frames are `at` to `at` + `count` - 1.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.

    Examples
    --------
    >>> from npss_baselines.manifold import example, insert, repair
    >>> longer = insert(example(60), 30, 15)
    >>> smooth = repair(longer, missing=["Hips"], start=30, end=45).motion
    >>> len(smooth.rotations)
    75
    """
    n_frames = len(motion.rotations)
    if not is_integer(at):
        raise TypeError(f"at: expected a frame of the file, got {at!r}")
    if n_frames < 2:
        raise ValueError(f"insert: expected a clip of at least two frames, got {n_frames}")
    if not 0 < at < n_frames:
        raise ValueError(f"at: expected a frame from 1 to {n_frames - 1}, got {at}")
    if positive_integer("insert", count) > MOST:
        raise ValueError(f"insert: expected at most {MOST} frames, got {count}")
    frames = np.concatenate([np.arange(at), np.full(count, at - 1), np.arange(at, n_frames)])
    degrees = None if motion.degrees is None else motion.degrees[frames]
    return replace(
        motion, rotations=motion.rotations[frames], translations=motion.translations[frames], degrees=degrees
    )
