"""Restore what is missing in a clip, on its own skeleton."""

from __future__ import annotations

import numpy as np

from npss.validation import Float64
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.clips.lost import Lost, Mask
from npss_baselines.manifold.motion.features import FPS, VELOCITIES
from npss_baselines.manifold.motion.onto_skeleton import Fitted
from npss_baselines.manifold.motion.own_clip import prepare_clip
from npss_baselines.manifold.motion.runs import runs
from npss_baselines.manifold.restorers.restorer import Restorer


def restored(simple: Bvh, mapping: JointMapping, lost: Lost, restorer: Restorer) -> Fitted:
    """Restore a clip; what is not missing returns exactly.

    The restorer sees the clip's features at 30 frames per second, and which are known. The changes that it makes go
    back onto the skeleton by inverse kinematics.

    Parameters
    ----------
    simple : Bvh
        The clip, y up, in which `filled` has put simple values for missing ones.
    mapping : JointMapping
        Its common joints.
    lost : Lost
        What is missing.
    restorer : Restorer
        The way to restore it.

    Returns
    -------
    Fitted
        The clip on its skeleton, and how far its joints are from where the restorer puts them.

    Raises
    ------
    ValueError
        If nothing is known, or the motion cannot be prepared.
    """
    if not lost.places.any():  # as of a finger
        return Fitted(simple, np.zeros(lost.places.shape))
    clip = prepare_clip(simple, mapping)
    known = known_features(lost.places, simple.fps, len(clip.features))
    if not known.any():
        raise ValueError("missing: nothing of the clip is known")
    left = Corrupted(clip.features[np.newaxis], known[np.newaxis])
    features = np.where(known, clip.features, restorer.restore(left)[0])
    return clip.back(closed(features, clip.features, known), places=lost.places, turning=lost.rotations)


def known_features(missing: Mask, fps: float, n_frames: int) -> Mask:
    """Return which features at 30 frames per second are known, ``(n_frames, 63)``.

    A place is known if it is in a frame of the file less than half a frame away. Velocities go with the hips.

    Parameters
    ----------
    missing : (T, 20) ndarray of bool
        Which common joints have no place, in the frames of the file.
    fps : float
        Frames per second of the file.
    n_frames : int
        The number of frames of the features.
    """
    times = np.arange(n_frames) * fps / FPS
    near = max(0.5, fps / FPS / 2) + 1e-6
    first = np.clip(np.ceil(times - near), 0, len(missing) - 1).astype(int)
    last = np.clip(np.floor(times + near), 0, len(missing) - 1).astype(int)
    seen = np.concatenate([np.zeros((1, missing.shape[1]), int), np.cumsum(~missing, axis=0)])
    places = seen[last + 1] > seen[first]
    return np.concatenate([np.repeat(places, 3, axis=1), np.repeat(places[:, :1], VELOCITIES, axis=1)], axis=1)


def closed(features: Float64, before: Float64, known: Mask) -> Float64:
    """Let the path through frames without known velocities end where it ends in the motion before.

    Parameters
    ----------
    features, before : (T, F) ndarray
        Features after and before restoration, with the same known velocities.
    known : (T, F) ndarray of bool
        Which features are known.

    Returns
    -------
    (T, F) ndarray
        Features. In a gap, the remaining turn and displacement are spread evenly; without a known frame before or
        after it, the path is that of the motion before.
    """
    path = features.copy()
    seen = known[:, -1]
    facing = np.cumsum(before[:, -VELOCITIES]) - before[0, -VELOCITIES]  # the first frame's turn does not count
    for start, end in runs(~seen):
        gap, n = slice(start, end), end - start
        if start == 0 or end == len(path):
            path[gap, -VELOCITIES:] = before[gap, -VELOCITIES:]
            continue
        path[gap, -3] += (before[gap, -3] - path[gap, -3]).mean()
        angles = facing[start - 1] + np.cumsum(path[gap, -3])
        rest = (_turned(before[gap, -2:], facing[gap]) - _turned(path[gap, -2:], angles)).mean(axis=0)
        path[gap, -2:] += _turned(np.tile(rest, (n, 1)), -angles)
    return path


def _turned(vectors: Float64, angles: Float64) -> Float64:
    """Rotate horizontal vectors x, z ``(n, 2)`` about y, from z to x, by angles ``(n,)`` in radians."""
    sin, cos = np.sin(angles), np.cos(angles)
    x, z = vectors.T
    return np.stack([cos * x + sin * z, cos * z - sin * x], axis=-1)
