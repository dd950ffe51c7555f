"""Find what is missing in a clip: values that are not numbers, joints that are held, joints that jump and come back."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Literal, NamedTuple

import numpy as np

from npss.validation import Float64
from npss_baselines.data.bvh import Bvh
from npss_baselines.manifold.clips.filling import last_known
from npss_baselines.manifold.clips.gap import Gap, Why
from npss_baselines.manifold.clips.lost import Mask
from npss_baselines.manifold.motion.runs import runs

#: The shortest time for which a joint is held, and the longest for which it jumps, in seconds.
HELD, JUMP = 0.1, 0.2
#: The share of steps, outside of stretches without a change, in which a tracked joint changes.
TRACKED = 0.9
#: The least leap: of a rotation, in radians; of a translation, as a share of the longest bone.
LEAST_TURN, LEAST_MOVE = np.radians(3), 0.05
#: A leap is longer than this many times the median acceleration and twice the steps before and after it. Of 46 clips of
#: CMU, the largest leaps of 42 reach 11.7 times, at 120 and at 30 frames per second; the others have joints that flip.
UNUSUAL = 15.0
#: The same for places of the whole figure. In 28 clips of CMU, from .2 seconds on, the largest leap reaches 7.8 times.
#: Where half a second is cut out, 95 of 100 leaps exceed 20 times at 120 frames per second, and 75 of 100 exceed 10 at
#: 30.
CUT = 10.0


class _Signal(NamedTuple):
    """The rotation or the translation of a joint over time."""

    joint: int
    what: Literal["rotation", "translation"]
    values: Float64  # (T, n), with distances in radians or in the unit of the file
    absent: Mask  # (T,)
    least: float  # the least leap


def find(motion: Bvh, *, shortest: float = HELD) -> list[Gap]:
    """Find the frames in which rotations or translations of joints are missing.

    Joints are *held* if they do not change at all for some time while others move, though they change in nearly
    every frame otherwise, by steps that would add up to a least leap in this time; or if nothing changes, but the
    figure moves before and afterwards. The first of these frames is true, unless the joint leaps into it, or
    another that is held in the same frames does. Joints *jump*
    if they leap from one frame to the next, and back within `JUMP` seconds. A leap has more acceleration than motion:
    see `UNUSUAL`.

    Parameters
    ----------
    motion : Bvh
        The clip. Values that are not numbers are missing.
    shortest : float, optional
        The shortest time for which a joint is held, in seconds.

    Returns
    -------
    list of Gap
        The gaps, by joint.
    """
    signals = list(_signals(motion))
    if not signals or len(motion.rotations) < 3:
        return []
    held = _held(signals, motion.fps, shortest)
    gaps = []
    for signal, stays in zip(signals, held, strict=True):
        masks: dict[Why, Mask] = {
            "not a number": signal.absent,
            "held": stays & ~signal.absent,
            "jump": _jumps(signal, motion.fps) & ~signal.absent & ~stays,
        }
        name = motion.skeleton.names[signal.joint]
        gaps += [Gap(name, signal.what, *run, why) for why, mask in masks.items() for run in runs(mask)]
    return gaps


def _signals(motion: Bvh) -> Iterator[_Signal]:
    """Yield the rotations and translations that the channels of a file determine."""
    longest = float(np.linalg.norm(motion.skeleton.offsets, axis=-1).max())
    # The distance of matrices is nearly sqrt(2) times the angle between them.
    turns = last_known(motion.rotations).reshape(*motion.rotations.shape[:2], 9) / np.sqrt(2)
    places = last_known(motion.translations)
    for joint, channels in enumerate(motion.channels):
        kinds = {channel[1:] for channel in channels or ()}
        if "rotation" in kinds:
            absent: Mask = np.any(np.isnan(motion.rotations[:, joint]), axis=(1, 2))
            yield _Signal(joint, "rotation", turns[:, joint], absent, LEAST_TURN)
        if "position" in kinds:
            absent = np.any(np.isnan(motion.translations[:, joint]), axis=1)
            yield _Signal(joint, "translation", places[:, joint], absent, LEAST_MOVE * longest)


def leaps(motion: Bvh, gaps: Sequence[Gap] = ()) -> list[int]:
    """Find the frames to which the figure leaps and where it stays, as if frames before them were deleted.

    Parameters
    ----------
    motion : Bvh
        The clip; values that are not numbers count as the last known ones.
    gaps : sequence of Gap, optional
        What is missing: leaps into and out of a gap do not count.

    Returns
    -------
    list of int
        The frames. The joints' places leap to them from the frame before by `CUT` times the median acceleration and
        twice the steps around. None is looked for in the first and last `JUMP` seconds, where some files have a T-pose.
    """
    skeleton, edge = motion.skeleton, max(1, round(JUMP * motion.fps))
    places = skeleton.positions(last_known(motion.rotations), offsets=last_known(motion.translations))
    if len(places) < 3:
        return []
    root = places[:, [skeleton.parents.index(-1)]]
    pose = np.concatenate([places - root, root], axis=1).reshape(len(places), -1)
    steps = np.linalg.norm(np.diff(pose, axis=0), axis=1)
    changes = np.linalg.norm(np.diff(pose, n=2, axis=0), axis=1)
    if not changes.any():
        return []
    least = LEAST_MOVE * np.linalg.norm(skeleton.offsets, axis=-1).max() * np.sqrt(places.shape[1])
    around = np.maximum(np.append(0, steps[:-1]), np.append(steps[1:], 0))
    leap = steps - 2 * around > max(CUT * np.median(changes[changes > 0]), least)
    leap[:edge] = leap[-edge:] = False
    for gap in gaps:
        leap[max(0, gap.start - 1) : gap.end] = False
    return [int(step) + 1 for step in np.flatnonzero(leap)]


def _held(signals: list[_Signal], fps: float, least: float) -> list[Mask]:
    """Return in which frames each signal is held."""
    steps = np.stack([_steps(signal) for signal in signals])  # (S, T - 1)
    absent = np.stack([signal.absent for signal in signals])
    steps[absent[:, 1:] | absent[:, :-1]] = np.nan
    shortest = max(2, round(least * fps))
    stretches = [[run for run in runs(own == 0) if run[1] - run[0] >= shortest] for own in steps]
    tracked = np.array([_tracked(own, long) for own, long in zip(steps, stretches, strict=True)])
    moving = (steps[tracked] > 0).any(axis=0)
    found: list[list[tuple[int, int]]] = []  # of each signal, the stretches in which it is held
    for signal, own, long, is_tracked in zip(signals, steps, stretches, tracked, strict=True):
        usual = float(np.median(own[own > 0])) if is_tracked and (own > 0).any() else 0.0
        found.append([])
        for start, end in long:
            # If nothing else moves, the figure may rest at the beginning and at the end of the clip.
            alone = moving[start:end].mean() > 0.5
            if usual * (end - start) > signal.least and (alone or (start > 0 and end < len(own))):
                found[-1].append((start, end))
    # Joints that are lost together are lost from the same frame on, though some of them may not leap far.
    leaping = {
        run
        for signal, own, long in zip(signals, steps, found, strict=True)
        for run in long
        if _leaps_in(signal, own, *run)
    }
    held = np.zeros(absent.shape, bool)
    for mask, long in zip(held, found, strict=True):
        for start, end in long:
            mask[start + ((start, end) not in leaping) : end + 1] = True
    return list(held)


def _leaps_in(signal: _Signal, steps: Float64, start: int, end: int) -> bool:
    """Return whether the first of equal frames is lost: a signal leaps to it, or if they begin the clip, away."""
    leap, before = (start - 1, start - 2) if start else (end, end + 1)
    if not 0 <= leap < len(steps):
        return False
    around = steps[before] if 0 <= before < len(steps) else 0.0
    changes = np.linalg.norm(np.diff(signal.values, n=2, axis=0), axis=1)
    # Where nothing changes, as between the keys of stepped motion, nothing is usual.
    usual = UNUSUAL * np.median(changes[changes > 0])
    return bool(steps[leap] - 2 * around > max(usual, signal.least))


def _tracked(steps: Float64, long: list[tuple[int, int]]) -> bool:
    """Return whether a signal changes in nearly every frame outside of long stretches."""
    outside = np.ones(len(steps), bool)
    for start, end in long:
        outside[start:end] = False
    return bool(outside.any() and (steps[outside] != 0).mean() >= TRACKED)


def _steps(signal: _Signal) -> Float64:
    """Return how far a signal goes from each frame to the next, ``(T - 1,)``."""
    steps: Float64 = np.linalg.norm(np.diff(signal.values, axis=0), axis=1)
    return steps


def _jumps(signal: _Signal, fps: float) -> Mask:
    """Return in which frames a signal is elsewhere: it leaps there and back."""
    values, n = signal.values, len(signal.values)
    step = _steps(signal)
    usual = UNUSUAL * np.median(np.linalg.norm(np.diff(values, n=2, axis=0), axis=1))
    longest = max(1, round(JUMP * fps))
    jumps = np.zeros(n, bool)
    leaps = np.flatnonzero(step > signal.least)
    for first in leaps:
        for last in leaps[(leaps > first) & (leaps <= first + longest)][::-1]:
            leap = min(step[first], step[last])
            around = max(step[first - 1] if first else 0.0, step[last + 1] if last + 1 < len(step) else 0.0)
            back = np.linalg.norm(values[last + 1] - values[first])
            if leap - 2 * around > max(usual, signal.least) and back < leap / 2:
                jumps[first + 1 : last + 1] = True
                break
    return jumps
