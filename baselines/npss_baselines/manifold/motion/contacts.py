"""Contacts of feet with the ground: find them, and hold the feet in them by bending the legs."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Float64, check_finite, real_array
from npss_baselines.manifold.motion.features import FPS, to_features, to_positions
from npss_baselines.manifold.motion.ground import ANKLES, BALLS
from npss_baselines.manifold.motion.measures import NEAR
from npss_baselines.manifold.motion.onto_skeleton import unit
from npss_baselines.manifold.motion.runs import runs

__all__ = ["contacts_of", "hold_feet"]

Contacts = npt.NDArray[np.bool_]

#: A foot stands while its ball is slower than this, in body heights per second, and as low as for `foot_speed`.
STANDING = 0.25
#: Frames in which a foot moves from and to the place where it stands.
EASE = 8
#: A leg is at most this share of its bones' lengths: a straight knee has no direction to bend in.
STRAIGHT = 0.999
#: The share of "ahead" in the direction in which a knee bends, which decides only where the leg is straight.
AHEAD = 0.02

_LEGS = (("LeftUpLeg", "LeftLeg"), ("RightUpLeg", "RightLeg"))


def contacts_of(features: npt.ArrayLike, skeleton: Skeleton, *, fps: float = FPS) -> Contacts:
    """Find the frames in which each foot stands on the ground.

    The ball of the foot is less than `NEAR` body heights above the lowest place of a ball in the motion, and slower
    than `STANDING`.

    Parameters
    ----------
    features : (..., T, 3 J + 3) array_like
        Motions.
    skeleton : npss.skeleton.Skeleton
        The skeleton, with the names of the joints of `npss_baselines.data.motion.JOINTS`.
    fps : float, optional
        Frames per second.

    Returns
    -------
    (..., T, 2) ndarray of bool
        Whether the left and the right foot stand.

    Raises
    ------
    TypeError, ValueError
        If the features are invalid, or have another number of joints.
    """
    positions = _world(features, skeleton)
    balls = positions[..., [skeleton.names.index(name) for name in BALLS], :]
    height = balls[..., 1] - balls[..., 1].min(axis=(-2, -1), keepdims=True)
    moved = np.linalg.norm(np.diff(balls, axis=-3), axis=-1) * fps
    # A frame is as slow as the faster of the steps from and to it.
    ends = np.zeros_like(height[..., :1, :])
    speed = np.maximum(np.concatenate([ends, moved], axis=-2), np.concatenate([moved, ends], axis=-2))
    stands: Contacts = (height < NEAR) & (speed < STANDING)
    return stands


def hold_feet(features: npt.ArrayLike, contacts: npt.ArrayLike, skeleton: Skeleton) -> Float64:
    """Keep standing feet in place, by bending hips and knees.

    While a foot stands, its ball stays at its average place; for `EASE` frames before and after, the foot moves there
    and back. The foot keeps its direction, so that knee and ankle are given by the lengths of thigh and shank and by
    the direction in which the knee bent. Where the place is out of reach, the foot is as near as the leg allows.

    Parameters
    ----------
    features : (n, T, 3 J + 3) array_like
        Motions, with the bone lengths of the skeleton.
    contacts : (n, T, 2) array_like of bool
        Whether the left and the right foot stand; see `contacts_of`.
    skeleton : npss.skeleton.Skeleton
        The skeleton, with the names of the joints of `npss_baselines.data.motion.JOINTS`.

    Returns
    -------
    (n, T, 3 J + 3) ndarray of float64
        Motions with the same bone lengths. Joints other than those of the legs do not move.

    Raises
    ------
    TypeError, ValueError
        If the features are invalid, or the shape of the contacts does not fit.
    """
    positions, stands = _world(features, skeleton), np.asarray(contacts)
    if stands.dtype != bool or stands.shape != (*positions.shape[:2], 2):
        raise ValueError(
            f"contacts: expected booleans of shape {(*positions.shape[:2], 2)}, got {stands.dtype} of {stands.shape}"
        )
    j = skeleton.names.index
    lengths = np.linalg.norm(skeleton.offsets, axis=-1)
    # Hips and shoulders are not moved, so that the facing direction stays as it is.
    ahead = np.cross(positions[..., j("LeftUpLeg"), :] - positions[..., j("RightUpLeg"), :], (0.0, 1.0, 0.0))
    for side, ((hip, knee), ankle, ball) in enumerate(zip(_LEGS, ANKLES, BALLS, strict=True)):
        shift = np.stack(
            [_shift(path, stand) for path, stand in zip(positions[..., j(ball), :], stands[..., side], strict=True)]
        )
        top, foot = positions[..., j(hip), :], positions[..., j(ball), :] - positions[..., j(ankle), :]
        bent, reached = _two_bones(
            top,
            positions[..., j(knee), :],
            positions[..., j(ankle), :],
            shift,
            lengths=(lengths[j(knee)], lengths[j(ankle)]),
            ahead=ahead,
        )
        moved = shift.any(axis=-1, keepdims=True)
        for name, place in ((knee, bent), (ankle, reached), (ball, reached + foot)):
            positions[..., j(name), :] = np.where(moved, place, positions[..., j(name), :])
    held: Float64 = to_features(positions, skeleton)
    return held


def _shift(path: Float64, stands: Contacts) -> Float64:
    """Return the horizontal way ``(T, 3)`` from a foot's path to where it stands, eased in and out."""
    shift, frames = np.zeros_like(path), np.arange(len(path))
    for first, end in runs(stands):
        shift[first:end] = (path[first:end].mean(axis=0) - path[first:end]) * (1, 0, 1)
    # Far from all stands, the foot is free; in between, it moves there and back.
    near = np.convolve(stands, np.ones(2 * EASE - 1), "same") > 0
    known = np.flatnonzero(stands | ~near)
    if not stands.any():
        return shift
    number = np.interp(frames, known, np.arange(len(known)))
    before = np.minimum(number.astype(int), max(0, len(known) - 2))
    share = (number - before)[:, np.newaxis]
    share *= share * (3 - 2 * share)
    after = np.minimum(before + 1, len(known) - 1)
    eased: Float64 = (1 - share) * shift[known[before]] + share * shift[known[after]]
    return eased


def _two_bones(
    top: Float64, knee: Float64, ankle: Float64, shift: Float64, *, lengths: tuple[float, float], ahead: Float64
) -> tuple[Float64, Float64]:
    """Return the places of knee and ankle ``(..., 3)`` for which the ankle is nearest to its shifted place."""
    thigh, shank = lengths
    # The knee bends to the side on which it was of the line from hip to ankle.
    bend = _beside(knee - top, unit(ankle - top)) + AHEAD * thigh * unit(ahead)
    way = ankle + shift - top
    along = unit(way)
    distance = np.linalg.norm(way, axis=-1, keepdims=True).clip(abs(thigh - shank), STRAIGHT * (thigh + shank))
    # The law of cosines: the knee's place along that line, and beside it.
    place = (distance**2 + thigh**2 - shank**2) / (2 * distance)
    beside = np.sqrt(np.maximum(thigh**2 - place**2, 0))
    return top + place * along + beside * unit(_beside(bend, along)), top + distance * along


def _beside(vectors: Float64, along: Float64) -> Float64:
    """Return the parts of vectors ``(..., 3)`` perpendicular to unit vectors."""
    perpendicular: Float64 = vectors - np.sum(vectors * along, axis=-1, keepdims=True) * along
    return perpendicular


def _world(features: npt.ArrayLike, skeleton: Skeleton) -> Float64:
    array = real_array("features", features)
    if array.ndim < 2 or array.shape[-1] != 3 * len(skeleton.names) + 3:
        raise ValueError(
            f"features: expected shape (..., T, {3 * len(skeleton.names) + 3}) for {len(skeleton.names)} joints, "
            f"got {array.shape}"
        )
    check_finite("features", array)
    positions: Float64 = to_positions(array.astype(np.float64))
    return positions
