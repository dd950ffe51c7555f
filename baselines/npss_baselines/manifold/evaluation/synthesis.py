"""Measure synthesised motion, interpolated or sampled, and the activity of hidden units."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from npss.records import Record
from npss.validation import Array, Seed, generator, renamed
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.interpolate import blend, interpolate
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.applications.sample import PRIORS, sample_codes
from npss_baselines.manifold.evaluation.records import context_of, records_of
from npss_baselines.manifold.evaluation.testbed import Testbed
from npss_baselines.manifold.motion import measures
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.features import FPS, local_positions, to_positions

#: Shares of the second motion at which interpolations are measured, and number of pairs of windows.
SHARES, PAIRS = (0.25, 0.5, 0.75), 50
#: Number of sampled motions, and of evenly spread training windows to compare them with and draw codes from.
SAMPLES, REAL = 50, 500
#: A hidden unit is idle if its standard deviation over held-out windows is below `IDLE`; a value is saturated if its
#: magnitude is above `SATURATED`.
IDLE, SATURATED = 0.01, 0.95


def interpolation(testbed: Testbed, clips: Sequence[int] | None = None) -> Iterator[Record]:
    """Measure how plausible motion between two windows is, by bone error and foot speed.

    The windows are the first ones of two clips, or random pairs of held-out windows. The metrics ``bone_error`` and
    ``foot_speed``, in body heights per second, are averaged over `SHARES`. Method ``input`` is the original motions,
    ``linear`` blended features.
    """
    if clips is None:
        first, second = pairs(testbed.test, PAIRS, seed=testbed.seed)
        context = context_of(testbed.test, pairs=len(first), seed=testbed.seed)
    else:
        first, second = (first_window(testbed.motions, clip) for clip in clips)
        context = context_of(testbed.motions, clips=" ".join(testbed.motions.clips[clip].name for clip in clips))
    motions = {
        Method("input"): [first, second],
        Method("linear"): [blend(first, second, share) for share in SHARES],
    }
    for name, projector in testbed.projectors().items():
        motions[Method(name)] = [interpolate(projector, first, second, share) for share in SHARES]
    context |= {"frames": first.shape[1], "shares": " ".join(f"{share:g}" for share in SHARES)}
    for method, parts in motions.items():
        values = validity(np.concatenate(parts))
        del values["joint_speed"]
        yield from records_of(testbed, "interpolate", method, values, context)


def sampling(testbed: Testbed) -> Iterator[Record]:
    """Measure sampled motion, and real windows as method ``input``.

    Metrics: ``bone_error``; ``foot_speed`` and ``joint_speed``, the average speed of joints in the character's frame,
    both in body heights per second. Methods are projectors, with variants from
    `npss_baselines.manifold.applications.sample.PRIORS`.
    """
    n_windows = len(testbed.training.windows)
    indices = np.linspace(0, n_windows - 1, min(REAL, n_windows)).astype(int)
    windows, mask = testbed.training.windows[indices], testbed.training.mask[indices]
    motions = {Method("input"): windows}
    for name, projector in testbed.projectors().items():
        codes = projector.encode(windows)
        for prior in priors_of(testbed, name):
            drawn = sample_codes(codes, SAMPLES, prior=prior, seed=testbed.seed)
            motions[Method(name, prior)] = projector.decode(drawn, windows.shape[1])
    context = context_of(testbed.training, frames=windows.shape[1], samples=SAMPLES, seed=testbed.seed)
    for method, motion in motions.items():
        values = validity(motion, mask if method.name == "input" else None)
        yield from records_of(testbed, "sample", method, values, context)


def priors_of(testbed: Testbed, name: str) -> tuple[str, ...]:
    """Return the priors of a projector: codes of principal components are not limited to [-1, 1]."""
    return PRIORS if name in testbed.manifolds else PRIORS[1:]


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
    """Measure motions ``(n, T, F)`` without ground truth: bone error, foot speed, joint speed."""
    counted = np.ones(motion.shape[:2], bool) if mask is None else mask
    local = local_positions(motion).astype(np.float64)
    speed = FPS * np.linalg.norm(np.diff(local, axis=1), axis=-1)  # (n, T - 1, J)
    return {
        "bone_error": measures.bone_error(local, JOINTS, counted),
        "foot_speed": measures.foot_speed(to_positions(motion), JOINTS, counted, fps=FPS),
        "joint_speed": float(speed[counted[:, 1:] & counted[:, :-1]].mean()),
    }


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
