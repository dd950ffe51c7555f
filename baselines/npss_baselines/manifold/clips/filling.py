"""Fill what is missing in a clip by cubics in time, joint by joint: the motion that restoration begins with."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from npss.rotations import matrix_to_quaternion, quaternion_to_matrix
from npss.validation import Float64
from npss_baselines.data.bvh import Bvh
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.simple import interpolated
from npss_baselines.manifold.clips.lost import Lost, Mask


def filled(motion: Bvh, lost: Lost) -> Bvh:
    """Return motion whose missing rotations and translations are interpolated, at the rate of the file.

    Quaternions and translations are interpolated by cubics whose slopes are those of parabolas, and held before the
    first and after the last known frame. Without any, a joint rests as in the skeleton.

    Raises
    ------
    ImportError
        If scipy is missing.
    """
    rotations, translations = motion.rotations.copy(), motion.translations.copy()
    joints = np.flatnonzero(lost.rotations.any(axis=0))
    if len(joints):
        missing = lost.rotations[:, joints]
        quaternions = np.zeros((*missing.shape, 4))
        for column, joint in enumerate(joints):
            known = ~missing[:, column]
            quaternions[:, column] = [1, 0, 0, 0]
            if known.any():
                quaternions[known, column] = without_flips(matrix_to_quaternion(rotations[known, joint]))
        between = _in_time(quaternions, missing)
        size = np.linalg.norm(between, axis=-1, keepdims=True)
        # Opposite quaternions pass zero between them, which is no rotation.
        between = np.where(size > 1e-6, between, [1, 0, 0, 0])
        turned = quaternion_to_matrix(between / np.where(size > 1e-6, size, 1))
        rotations[:, joints] = np.where(missing[..., np.newaxis, np.newaxis], turned, rotations[:, joints])
    moves = np.array([any(channel.endswith("position") for channel in of or ()) for of in motion.channels])
    joints = np.flatnonzero(lost.translations.any(axis=0) & moves)
    if len(joints):
        missing = lost.translations[:, joints]
        resting = np.where(missing[..., np.newaxis], motion.skeleton.offsets[joints], translations[:, joints])
        translations[:, joints] = _in_time(resting, missing)
    return replace(motion, rotations=rotations, translations=translations)


def _in_time(values: Float64, missing: Mask) -> Float64:
    """Interpolate values ``(T, J, n)`` of joints that are missing ``(T, J)``."""
    n_frames, _, n = values.shape
    left = Corrupted(values.reshape(1, n_frames, -1), np.repeat(~missing, n, axis=1)[np.newaxis])
    return interpolated(left, "hermite").reshape(values.shape)


def without_flips(quaternions: Float64) -> Float64:
    """Return quaternions ``(T, ..., 4)`` whose signs do not change from frame to frame: `continuous`, but faster."""
    flips = np.sum(quaternions[1:] * quaternions[:-1], axis=-1) < 0
    signs = np.concatenate([np.ones((1, *flips.shape[1:])), np.cumprod(np.where(flips, -1, 1), axis=0)])
    steady: Float64 = quaternions * signs[..., np.newaxis]
    return steady


def last_known(values: Float64) -> Float64:
    """Return values ``(T, J, ...)`` in which the last known frame of a joint stands for those with a NaN.

    Before the first known frame, and without any, it is zero, or for a matrix no turn.
    """
    known = ~np.isnan(values).reshape(*values.shape[:2], -1).any(axis=-1)
    if known.all():
        return values
    frames = np.where(known, np.arange(len(values))[:, np.newaxis], -1)
    last = np.maximum.accumulate(frames, axis=0)
    first = np.where(known.any(axis=0), known.argmax(axis=0), -1)
    chosen = np.where(last < 0, first, last)
    held: Float64 = values[np.maximum(chosen, 0), np.arange(values.shape[1])]
    resting = np.eye(3) if values.ndim == 4 else np.zeros(values.shape[2:])
    held[chosen < 0] = resting
    return held
