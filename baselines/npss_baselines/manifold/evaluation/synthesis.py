"""Measure synthesised motion, interpolated or sampled, and the activity of hidden units."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

import npss
from npss.records import Record
from npss.validation import Array, Float64, Seed, generator, renamed
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.interpolate import Way, interpolate, possible
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.applications.sample import PRIORS, motion_of, sample_codes
from npss_baselines.manifold.applications.simple import with_lengths
from npss_baselines.manifold.evaluation.fidelity import NEIGHBOURS, descriptors, nearest_npss, precision_and_recall
from npss_baselines.manifold.evaluation.intervals import difference_interval
from npss_baselines.manifold.evaluation.records import context_of, records_of
from npss_baselines.manifold.evaluation.testbed import Testbed
from npss_baselines.manifold.model.projector import Projector
from npss_baselines.manifold.motion import measures
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.features import FPS, local_positions, to_positions
from npss_baselines.manifold.motion.smooth import smoothed

#: Shares of the second motion at which interpolations are measured, and number of pairs of windows.
SHARES, PAIRS = (0.25, 0.5, 0.75), 50
#: The default of `interpolate`, which other methods are compared with.
DEFAULT = Method("slerp", "possible")
#: Number of sampled motions, and of evenly spread held-out windows to compare them with.
SAMPLES = 200
#: A joint snaps while its jerk is larger, in body heights per second cubed: .001 of the time in real motion.
SNAP = 1000.0
#: A hidden unit is idle if its standard deviation over held-out windows is below `IDLE`; a value is saturated if its
#: magnitude is above `SATURATED`.
IDLE, SATURATED = 0.01, 0.95


def interpolation(testbed: Testbed, clips: Sequence[int] | None = None) -> Iterator[Record]:
    """Measure how plausible motion between two windows is.

    The windows are the first ones of two clips, or random pairs of held-out windows. All measures are averaged over
    `SHARES`: ``bone_error``; ``foot_speed`` and ``joint_speed`` in body heights per second; ``jerk`` in body heights
    per second cubed; ``snaps``, the share of joints and frames with a jerk above `SNAP`; ``npss``, of the interpolation
    to the first and to the second motion as ground truth, in the character's frame, where each counts by its share.

    Method ``input`` is the original motions. The others are ways of
    `npss_baselines.manifold.applications.interpolate.interpolate`: unconstrained, with the ``lengths`` of bones, and
    made ``possible``, where decoded motion is also smoothed.

    For pairs of windows, records have the ends ``low`` and ``high`` of the 95 % interval of the difference from
    `DEFAULT`, with the pair as block.
    """
    if clips is None:
        first, second = pairs(testbed.test, PAIRS, seed=testbed.seed)
        context = context_of(testbed.test, pairs=len(first), seed=testbed.seed)
    else:
        first, second = (first_window(testbed.motions, clip) for clip in clips)
        context = context_of(testbed.motions, clips=" ".join(testbed.motions.clips[clip].name for clip in clips))
    context |= {"frames": first.shape[1], "shares": " ".join(f"{share:g}" for share in SHARES)}
    measured = {Method("input"): [_plausibility(first), _plausibility(second)]}
    for method, blended in interpolations(testbed, first, second):
        measured[method] = [
            _plausibility(motion) | {"npss": _npss_to_both(motion, first, second, share)}
            for share, motion in zip(SHARES, blended, strict=True)
        ]
    sums = {
        method: {name: np.stack([part[name] for part in parts]).sum(axis=0) for name in parts[0]}
        for method, parts in measured.items()
    }
    for method, by_metric in sums.items():
        values = {name: _quotient(*adds.sum(axis=1)) for name, adds in by_metric.items()}
        for record in records_of(testbed, "interpolate", method, values, context):
            name = record["metric"]
            if clips is None and method not in (DEFAULT, Method("input")):
                low, high = difference_interval(sums[DEFAULT][name], by_metric[name], seed=testbed.seed)
                record |= {"against": str(DEFAULT), "low": low, "high": high}
            yield record


def interpolations(testbed: Testbed, first: Array, second: Array) -> Iterator[tuple[Method, list[Array]]]:
    """Yield the interpolations of windows ``(n, T, F)`` at each of `SHARES`, by method."""
    unknown = np.zeros(first.shape, bool)
    ways: list[tuple[str, Way, Projector | None]] = [("linear", "linear", None), ("slerp", "slerp", None)]
    ways += [(name, "manifold", projector) for name, projector in testbed.projectors().items()]
    for name, way, projector in ways:
        free = [interpolate(projector, first, second, share, way=way, constrained=False) for share in SHARES]
        yield Method(name), free
        if way != "slerp":  # which keeps lengths
            yield Method(name, "lengths"), [with_lengths(motion, unknown, JOINTS) for motion in free]
        # As by `interpolate`, where the motion is decoded only once.
        smooth = free if projector is None else [smoothed(motion) for motion in free]
        made = [possible(motion, first, second, share) for motion, share in zip(smooth, SHARES, strict=True)]
        yield Method(name, "possible"), made


def sampling(testbed: Testbed) -> Iterator[Record]:
    """Measure sampled motion.

    Metrics are those of `validity`; ``nearest_npss``, the average of `fidelity.nearest_npss`; and ``precision`` and
    ``recall`` by `fidelity.descriptors`, scaled to their deviation in training motion. The last three compare with
    whole held-out windows, at most `SAMPLES`. Methods are projectors with a prior of
    `npss_baselines.manifold.applications.sample.PRIORS`, as decoded; with ``possible``, by
    `npss_baselines.manifold.applications.sample.motion_of`. Method ``input`` is as many whole training windows, drawn
    at random: real motion of other subjects.
    """
    windows = testbed.training.windows[testbed.training.mask.all(axis=1)]
    real = _spread(testbed.test.windows[testbed.test.mask.all(axis=1)], SAMPLES)
    n_frames = windows.shape[1]
    drawn = generator(testbed.seed).choice(len(windows), size=min(SAMPLES, len(windows)), replace=False)
    motions = {Method("input"): windows[drawn].astype(np.float64)}
    for name, projector in testbed.projectors().items():
        codes = projector.encode(windows)
        for prior in priors_of(testbed, name):
            sampled = sample_codes(codes, SAMPLES, prior=prior, seed=testbed.seed)
            motions[Method(name, prior)] = projector.decode(sampled, n_frames)
            if prior == PRIORS[0]:
                motions[Method(name, f"{prior}, possible")] = motion_of(projector, sampled, n_frames)
    context = context_of(testbed.test, frames=n_frames, samples=SAMPLES, seed=testbed.seed)
    deviation = descriptors(windows, testbed.scaling).std(axis=0)
    unit = np.where(deviation > 0, deviation, 1)
    for method, motion in motions.items():
        values = validity(motion)
        if len(real) > NEIGHBOURS:
            sets = [descriptors(each, testbed.scaling) / unit for each in (real, motion)]
            values["nearest_npss"] = float(nearest_npss(*map(_coordinates, (real, motion))).mean())
            values["precision"], values["recall"] = precision_and_recall(*sets)
        yield from records_of(testbed, "sample", method, values, context)


def _spread(windows: Array, n: int) -> Array:
    """Return at most n evenly spread windows."""
    chosen: Array = windows[np.linspace(0, len(windows) - 1, min(n, len(windows))).round().astype(int)]
    return chosen


def _coordinates(motion: Array) -> Array:
    """Return the coordinates ``(n, T, 3 J)`` of joints in the character's frame."""
    return local_positions(motion).reshape(*motion.shape[:2], -1)


def priors_of(testbed: Testbed, name: str) -> tuple[str, ...]:
    """Return the priors of a projector: codes of principal components are not limited to [-1, 1]."""
    return PRIORS if name in testbed.manifolds else PRIORS[2:]


def filtering(testbed: Testbed) -> Iterator[Record]:
    """Measure hidden units on held-out windows: shares ``idle`` and ``saturated``, and average ``deviation``."""
    windows, context = testbed.test.windows, context_of(testbed.test)
    for name, manifold in testbed.manifolds.items():
        codes = manifold.encode(windows).astype(np.float64)
        values = {
            "idle": float((codes.std(axis=(0, 1)) < IDLE).mean()),
            "saturated": float((np.abs(codes) > SATURATED).mean()),
            "deviation": float(codes.std(axis=(0, 1)).mean()),
        }
        yield from records_of(testbed, "filters", Method(name), values, context)


def validity(motion: Array, mask: measures.Mask | None = None) -> dict[str, float]:
    """Measure motions ``(n, T, F)`` without ground truth: bone error, foot speed, joint speed, jerk, snaps."""
    return {name: _quotient(*adds.sum(axis=1)) for name, adds in _plausibility(motion, mask).items()}


def _plausibility(motion: Array, mask: measures.Mask | None = None) -> dict[str, Float64]:
    """Return what each motion adds to the two sums whose quotient is a measure of `validity`, ``(2, n)``."""
    counted = np.ones(motion.shape[:2], bool) if mask is None else mask
    local, world = local_positions(motion).astype(np.float64), to_positions(motion.astype(np.float64))
    child, parent = np.array(JOINTS.bones).T
    right = np.linalg.norm(JOINTS.offsets[child], axis=-1)
    bones = np.abs(np.linalg.norm(local[:, :, child] - local[:, :, parent], axis=-1) - right) / right
    feet, stays = measures.foot_speeds(world, JOINTS, counted, fps=FPS)
    parts: dict[str, tuple[Array, Array]] = {"bone_error": (bones, counted), "foot_speed": (feet, stays)}
    for name, positions, order in (("joint_speed", local, 1), ("jerk", world, 3)):
        change = FPS**order * np.linalg.norm(np.diff(positions, order, axis=1), axis=-1)
        whole = np.lib.stride_tricks.sliding_window_view(counted, order + 1, axis=1)
        parts[name] = (change, np.all(whole, axis=-1))
    parts["snaps"] = (parts["jerk"][0] > SNAP, parts["jerk"][1])
    return {name: _sums(*part) for name, part in parts.items()}


def _sums(values: Array, counted: Array) -> Float64:
    """Return the sum and the number of each motion's values ``(n, T, m)`` that count, by frame or by value."""
    counts = np.broadcast_to(counted if counted.ndim == 3 else counted[..., np.newaxis], values.shape)
    return np.stack([np.where(counts, values, 0).sum(axis=(1, 2)), counts.sum(axis=(1, 2))])


def _npss_to_both(motion: Array, first: Array, second: Array, share: float) -> Float64:
    """Return what each motion adds to the numerator and denominator of NPSS to two ground truths, by their shares."""
    pred = _coordinates(motion)
    adds = np.zeros((2, len(motion)))
    for part, original in ((1 - share, first), (share, second)):
        scored = npss.report(_coordinates(original), pred)
        adds += part * np.stack([(scored.weight * scored.emd).sum(axis=1), scored.weight.sum(axis=1)])
    return adds


def _quotient(over: float, under: float) -> float:
    return float(over / under) if under else float("nan")


@renamed(rng="seed")
def pairs(motions: MotionSet, n: int, *, seed: Seed) -> tuple[Array, Array]:
    """Draw pairs of whole windows ``(n, T, F)``, each from two different clips."""
    whole = np.flatnonzero(motions.mask.all(axis=1))
    clips = motions.clip_of[whole]
    if len(set(clips)) < 2:
        raise ValueError("motions: interpolation needs whole windows of at least two clips")
    chosen: list[tuple[int, int]] = []
    rng = generator(seed)
    while len(chosen) < n:
        first, second = rng.integers(len(whole), size=2)
        if clips[first] != clips[second]:
            chosen.append((whole[first], whole[second]))
    first, second = np.array(chosen).T
    return motions.windows[first].astype(np.float64), motions.windows[second].astype(np.float64)


def first_window(motions: MotionSet, clip: int) -> Array:
    """Return the first window of a clip, ``(1, T, F)``."""
    window: Array = motions.windows[motions.clip_of == clip][:1].astype(np.float64)
    return window
