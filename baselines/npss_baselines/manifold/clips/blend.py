"""Interpolate two clips: one motion on the skeleton of the first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from npss.rotations import matrix_to_quaternion, quaternion_to_matrix
from npss.validation import Float64
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping, guess
from npss_baselines.data.upright import Up, up_of, with_own_up, with_y_up
from npss_baselines.manifold.applications.interpolate import Way, blend
from npss_baselines.manifold.applications.interpolate import interpolate as interpolated
from npss_baselines.manifold.clips.filling import without_flips
from npss_baselines.manifold.clips.outcome import Outcome
from npss_baselines.manifold.motion.features import VELOCITIES
from npss_baselines.manifold.motion.own_clip import body_height, prepare_clip

if TYPE_CHECKING:
    from npss_baselines.manifold.model.projector import Projector  # imports torch


def interpolate(
    first: Bvh,
    second: Bvh,
    share: float,
    *,
    manifold: Projector | None = None,
    mappings: Sequence[JointMapping | None] = (None, None),
    up: Up | None = None,
) -> Outcome:
    """Interpolate two clips.

    Both are stretched to the same duration, the average of theirs by share. The directions of their bones are then
    blended along great circles, or their hidden units in a manifold; bones get their lengths, and standing feet stay in
    their place. The phases of steps are not aligned.

    Parameters
    ----------
    first, second : Bvh
        The clips; their skeletons and frame rates may differ.
    share : float
        The share of the second, from 0 to 1.
    manifold : Projector, optional
        The manifold, as `npss_baselines.manifold.training.folder.load` returns it in `Run.projector`.
    mappings : sequence of (JointMapping or None), optional
        The common joints of the two skeletons (default: guessed).
    up : {'y', 'z'}, optional
        The axis that points up in both (default: that along which the head is above the feet).

    Returns
    -------
    Outcome
        The motion on the skeleton of the first clip, at its frame rate; it begins where that begins. Without a
        manifold, a share of 0 gives the first clip.

    Raises
    ------
    ImportError
        If scipy is missing.
    TypeError, ValueError
        If an argument is invalid, or a clip cannot be prepared.
    """
    joints = [mapping or guess(clip.skeleton) for clip, mapping in zip((first, second), mappings, strict=True)]
    axes = [up_of(clip, mapping) if up is None else up for clip, mapping in zip((first, second), joints, strict=True)]
    seconds = blend((len(first.rotations) - 1) / first.fps, (len(second.rotations) - 1) / second.fps, share)
    base = _stretched(with_y_up(first, axes[0]), round(float(seconds) * first.fps) + 1)
    clip, other = prepare_clip(base, joints[0]), prepare_clip(with_y_up(second, axes[1]), joints[1])
    own, others = clip.features, _stretched_features(other.features, len(clip.features))
    way: Way = "slerp" if manifold is None else "manifold"
    features = own
    if share > 0 or manifold is not None:
        features = interpolated(manifold, own[np.newaxis], others[np.newaxis], share, way=way)[0]
    fitted = clip.back(features)
    signature = way if manifold is None else manifold.signature
    error = fitted.error / body_height(clip.common)
    return Outcome(with_own_up(fitted.motion, axes[0]), joints[0], axes[0], signature, (), error)


def _stretched(motion: Bvh, n_frames: int) -> Bvh:
    """Return a clip in another number of frames at the same rate."""
    at = np.linspace(0, len(motion.rotations) - 1, n_frames)
    quaternions = without_flips(matrix_to_quaternion(motion.rotations))
    between = _at(quaternions, at)
    between /= np.linalg.norm(between, axis=-1, keepdims=True)
    translations = _at(motion.translations, at)
    return replace(motion, rotations=quaternion_to_matrix(between), translations=translations, degrees=None)


def _stretched_features(features: Float64, n_frames: int) -> Float64:
    """Return features in another number of frames, whose velocities cover the same path."""
    stretched = _at(features, np.linspace(0, len(features) - 1, n_frames))
    stretched[:, -VELOCITIES:] *= (len(features) - 1) / max(1, n_frames - 1)
    return stretched


def _at(values: Float64, frames: Float64) -> Float64:
    """Return values ``(T, ...)`` between frames, by straight lines."""
    before = np.minimum(frames.astype(int), max(0, len(values) - 2))
    share = (frames - before).reshape(-1, *(1,) * (values.ndim - 1))
    after = np.minimum(before + 1, len(values) - 1)
    between: Float64 = values[before] * (1 - share) + values[after] * share
    return between
