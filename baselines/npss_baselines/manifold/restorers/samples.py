"""Training samples of each case of missing values: what the networks see, a first guess, and the truth."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Protocol

import numpy as np
import numpy.typing as npt

from npss.console import Progress
from npss.skeleton import Skeleton
from npss.validation import Seed, generator
from npss_baselines.manifold.applications.corrupt import branch, kinect
from npss_baselines.manifold.applications.simple import interpolated
from npss_baselines.manifold.model.gaussian import SpanGaussian
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.mirror import mirror_image
from npss_baselines.manifold.motion.windows import WINDOW
from npss_baselines.manifold.restorers import camera, fill, keys
from npss_baselines.manifold.restorers.frames import Frames
from npss_baselines.manifold.restorers.net import Float32

Bools = npt.NDArray[np.bool_]

#: Limbs that are missing, from this joint on, and how often; and the head, and two ends of limbs at once.
LIMBS = {"Hand": 0.43, "ForeArm": 0.08, "Arm": 0.05, "Foot": 0.15, "Leg": 0.06, "UpLeg": 0.03}
HEAD, TWO = 0.02, 0.18
#: Frames from one key to the next; the share of keys at irregular distances, and the largest of these; the share of
#: frames with keys on one side only.
DISTANCES, IRREGULAR, WIDEST, ONE_SIDED = (3, 25), 0.25, 45, 0.12
#: Frames of a window that the Gaussian restores for the networks of the camera.
PIECE = 40


@dataclass(frozen=True, eq=False)
class Samples:
    """Samples of one case.

    Attributes
    ----------
    inputs : (n, in) ndarray of float32
        What the networks see.
    guess, truth : (n, F) ndarray of float32
        The first guess and the true values, scaled.
    amount : (n, 1) ndarray of float32
        What the network's output is multiplied by.
    missing : (n, J) ndarray of bool
        The joints that are restored.
    kind : (n,) ndarray of int
        The kind of corruption: the losses of kinds weigh equally.
    """

    inputs: Float32
    guess: Float32
    truth: Float32
    amount: Float32
    missing: Bools
    kind: npt.NDArray[np.intp]


class Sampler(Protocol):
    """Samples of one case."""

    #: Number of values that the networks predict: those of the first features.
    outputs: int
    n_kinds: int

    def draw(self, n: int, seed: Seed) -> Samples:
        """Draw about `n` samples."""


class FillSampler:
    """Frames without some joints; see `npss_baselines.manifold.restorers.fill`."""

    def __init__(self, frames: Frames, pose: SpanGaussian, skeleton: Skeleton) -> None:
        self.frames = frames
        self.sets, shares, kinds = _sets(skeleton)
        self._shares = shares / shares.sum()
        self._kinds, self.n_kinds = kinds, int(kinds.max()) + 1
        self.outputs = 3 * len(skeleton.names)
        # The completed frame is an affine function of the known values.
        n_features = len(pose.scaling.mean)
        units = np.concatenate([np.zeros((1, n_features)), np.eye(n_features)])
        completed = [
            pose.scaling.normalize(fill.complete(pose, pose.scaling.unnormalize(units), fill.columns_of(joints)))
            for joints in self.sets
        ]
        self._maps = [((c[1:] - c[0]).astype(np.float32), c[0].astype(np.float32)) for c in completed]

    def draw(self, n: int, seed: Seed) -> Samples:
        """Draw samples of eight sets of joints."""
        rng = generator(seed)
        chosen = rng.choice(len(self.sets), 8, p=self._shares)
        inputs, guess, truth = [], [], []
        for number in chosen:
            drawn = self.frames.draw(n // 8, rng)
            around = self.frames.around(drawn, fill.OFFSETS)
            slopes, start = self._maps[number]
            completed = around @ slopes + start
            inputs.append(fill.inputs_of(completed, self.sets[number]))
            guess.append(completed[:, list(fill.OFFSETS).index(0)])
            truth.append(self.frames.scaled[drawn])
        times = n // 8
        return Samples(
            np.concatenate(inputs),
            np.concatenate(guess),
            np.concatenate(truth),
            np.ones((8 * times, 1), np.float32),
            np.repeat(self.sets[chosen], times, axis=0),
            np.repeat(self._kinds[chosen], times),
        )


class KeysSampler:
    """Frames between keys; see `npss_baselines.manifold.restorers.keys`."""

    n_kinds = 6

    def __init__(self, frames: Frames, skeleton: Skeleton) -> None:
        self.frames = frames
        self._n_joints = len(skeleton.names)
        self.outputs = frames.scaled.shape[1]

    def draw(self, n: int, seed: Seed) -> Samples:
        """Draw samples."""
        rng = generator(seed)
        drawn = self.frames.draw(n, rng)
        distance = rng.integers(DISTANCES[0], DISTANCES[1] + 1, n)
        gaps = np.repeat(distance[:, np.newaxis], 3, axis=1)
        irregular = rng.random(n) < IRREGULAR
        gaps[irregular] = rng.integers(1, DISTANCES[1] + 1, (irregular.sum(), 3))
        gaps[irregular, 1] = rng.integers(2, WIDEST + 1, irregular.sum())
        before = rng.integers(1, gaps[:, 1])
        times = np.stack([-before - gaps[:, 0], -before, gaps[:, 1] - before, gaps[:, 1] - before + gaps[:, 2]], axis=1)
        frames = drawn[:, np.newaxis] + times
        there = (frames >= self.frames.first[drawn, np.newaxis]) & (frames <= self.frames.last[drawn, np.newaxis])
        sides = rng.random(n)
        there[sides < 0.8 * ONE_SIDED, 2:] = False
        there[(sides >= 0.8 * ONE_SIDED) & (sides < ONE_SIDED), :2] = False
        useful = there[:, 1:3].any(axis=1)
        drawn, times, there, gaps = drawn[useful], times[useful], there[useful], gaps[useful]
        values = self.frames.around(drawn, times)
        guess = keys.cubic(values, times.astype(np.float64), there)
        both = there[:, 1:3].all(axis=1)
        return Samples(
            keys.inputs_of(values, guess, times, there),
            guess.astype(np.float32),
            self.frames.scaled[drawn],
            keys.amount_of(values, times, there).astype(np.float32),
            np.ones((len(drawn), self._n_joints), bool),
            np.where(both, np.searchsorted([8, 13, 19, 26], gaps[:, 1], side="right"), 5),
        )


class CameraSampler:
    """Frames seen by a noisy camera; see `npss_baselines.manifold.restorers.camera`.

    The Gaussian restores a piece of each window, and samples are of frames that have neighbours on both sides.
    """

    n_kinds = 1

    def __init__(
        self, motions: MotionSet, gaussian: SpanGaussian, skeleton: Skeleton, windows: int, seed: Seed
    ) -> None:
        rng = generator(seed)
        chosen = _windows(motions, skeleton, windows, rng)
        scaling = gaussian.scaling
        shape = (windows, PIECE, chosen.shape[-1])
        truth, means, observed = (np.empty(shape, np.float32) for _ in range(3))
        seen = np.empty(shape, bool)
        with Progress("restoring windows by the Gaussian") as progress:
            for i, window in enumerate(chosen):
                left = kinect(window[np.newaxis], skeleton, seed=rng)
                start = int(rng.integers(WINDOW - PIECE + 1))
                piece = slice(start, start + PIECE)
                features, known = left.features[:, piece], left.known[:, piece]
                mean = gaussian.restore(features, known, noise=left.noise)
                truth[i] = scaling.normalize(window[piece])
                means[i] = scaling.normalize(mean[0])
                observed[i] = scaling.normalize(interpolated(left)[0, piece])
                seen[i] = known[0]
                progress((i + 1) / windows)
        flat = (-1, shape[2])
        self._truth, self._mean, self._observed = (values.reshape(flat) for values in (truth, means, observed))
        self._known = seen.reshape(flat)
        self._margin = int(np.abs(camera.OFFSETS).max())
        self._n_joints = len(skeleton.names)
        self.outputs = self._truth.shape[1]

    def draw(self, n: int, seed: Seed) -> Samples:
        """Draw samples."""
        rng = generator(seed)
        first = PIECE * rng.integers(len(self._truth) // PIECE, size=n)
        frames = first + rng.integers(self._margin, PIECE - self._margin, n)
        inputs = camera.inputs_of(self._mean, self._observed, self._known, frames, (first, first + PIECE - 1))
        return Samples(
            inputs,
            self._mean[frames],
            self._truth[frames],
            np.ones((n, 1), np.float32),
            np.ones((n, self._n_joints), bool),
            np.zeros(n, np.intp),
        )


def _sets(skeleton: Skeleton) -> tuple[Bools, npt.NDArray[np.float64], npt.NDArray[np.intp]]:
    """Return sets of missing joints ``(sets, J)``, how often each is drawn, and its kind."""
    ends = [f"{side}{limb}" for limb in ("Hand", "Foot") for side in ("Left", "Right")]
    groups: list[tuple[Sequence[int], float, int]] = []
    for kind, (limb, share) in enumerate(LIMBS.items()):
        groups += [(branch(skeleton, f"{side}{limb}"), share / 2, kind) for side in ("Left", "Right")]
    kind = len(LIMBS)
    groups.append((branch(skeleton, "Head"), HEAD, kind))
    pairs = list(combinations(ends, 2))
    groups += [(branch(skeleton, a) + branch(skeleton, b), TWO / len(pairs), kind + 1) for a, b in pairs]
    sets = np.zeros((len(groups), len(skeleton.names)), bool)
    for row, (joints, _, _) in zip(sets, groups, strict=True):
        row[joints] = True
    return sets, np.array([share for _, share, _ in groups]), np.array([kind for _, _, kind in groups])


def _windows(motions: MotionSet, skeleton: Skeleton, n: int, rng: np.random.Generator) -> npt.NDArray[np.float64]:
    """Draw whole windows at random times, half of them mirrored."""
    clips = [i for i, clip in enumerate(motions.clips) if clip.n_frames >= WINDOW]
    if not clips:
        raise ValueError(f"motions: expected a clip of at least {WINDOW} frames")
    lengths = np.array([motions.clips[i].n_frames for i in clips], np.float64)
    sources = np.array([motions.clips[i].source for i in clips])
    weights = np.array([lengths[i] / np.sqrt(lengths[sources == source].sum()) for i, source in enumerate(sources)])
    drawn = []
    for number in rng.choice(len(clips), n, p=weights / weights.sum()):
        clip = motions.features[clips[number]]
        start = rng.integers(len(clip) - WINDOW + 1)
        window = clip[start : start + WINDOW].astype(np.float64)
        drawn.append(mirror_image(window, skeleton) if rng.random() < 0.5 else window)
    return np.stack(drawn)
