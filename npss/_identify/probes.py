"""Small motions on which the choices behind an NPSS can be told apart.

Every value is a multiple of 1/32 below 4, or that times a power of two, which bfloat16 holds exactly. Features have
power in real parts, imaginary parts and DC: tones are cosines, plus noise.
"""

from __future__ import annotations

from functools import lru_cache
from typing import NamedTuple

import numpy as np

from npss._identify.compute import features
from npss.validation import Float64


class Probe(NamedTuple):
    """A pair of ``(N, T, D)`` motions, and the shape of a frame, whose product is D."""

    gt: Float64
    pred: Float64
    frame: tuple[int, ...]

    def scaled(self, gt: float, pred: float) -> Probe:
        """Return the probe with both motions multiplied."""
        return self._replace(gt=self.gt * gt, pred=self.pred * pred)


@lru_cache(maxsize=16)
def ordinary(frame: tuple[int, ...], wider: tuple[int, ...]) -> tuple[Probe, ...]:
    """Return probes in which every feature has power; two have frames of the second shape."""
    return (
        _walks(3, 24, frame),
        _noise(4, 25, frame),  # an odd number of frames
        _tones(5, 16, wider),
        _loud(3, 20, frame),
        _loud(6, 15, wider),
        _shifted(2, 32, frame),
        _offset(3, 24, frame),
        _odd(2, 18, wider),
        _noise(1, 21, frame),  # one sequence
        _walks(2, 100, frame),
    )


def batches(frame: tuple[int, ...]) -> tuple[Probe, tuple[int, ...]]:
    """Return a probe for batches, and their sizes."""
    return _exchanged(5, 20, frame), (2, 3)


def unusual(frame: tuple[int, ...], wider: tuple[int, ...]) -> dict[str, Probe]:
    """Return probes by what is unusual about them; with many features only if frames may have several shapes."""
    probes = {"many sequences": _exchanged(140, 6, frame), "many frames": _noise(2, 250, frame)}
    if wider != frame:
        probes["many features"] = _noise(2, 12, (12 * frame[0], *frame[1:]))
    probes["constant features"] = _constant(3, 22, frame)
    # Among many features, some have so little power that an epsilon would show.
    return {what: probe.scaled(32, 32) for what, probe in probes.items()}


def _constant(n: int, t: int, frame: tuple[int, ...]) -> Probe:
    """Hold a feature of both motions, and one of each."""
    gt, pred, _ = _noise(n, t, frame)
    gt, pred = gt.copy(), pred.copy()
    gt[:, :, 0] = 1.5
    pred[:, :, 0] = 1.25
    gt[:, :, -1] = 0.75
    pred[:, :, features(frame) // 2] = -0.5
    return Probe(gt, pred, frame)


def _walks(n: int, t: int, frame: tuple[int, ...]) -> Probe:
    """Random walks about a mean pose."""
    random = _random("walks", n, t, frame)
    steps = random.normal(scale=0.15, size=(2, n, t, features(frame))).cumsum(axis=2)
    pose = _pose(random, n, frame)
    return _probe(pose + steps[0], pose * random.uniform(0.8, 1.2, size=pose.shape) + steps[1], frame)


def _noise(n: int, t: int, frame: tuple[int, ...]) -> Probe:
    random = _random("noise", n, t, frame)
    gt, pred = random.normal(scale=0.8, size=(2, n, t, features(frame)))
    return _probe(gt + _pose(random, n, frame) / 2, pred + _pose(random, n, frame) / 2, frame)


def _tones(n: int, t: int, frame: tuple[int, ...]) -> Probe:
    """Pure tones with an offset, of another frequency in the prediction."""
    random = _random("tones", n, t, frame)
    phase = 2 * np.pi * np.arange(t)[:, np.newaxis] / t
    cycles = random.integers(1, t // 2 - 1, size=(2, n, 1, features(frame)))
    gt, pred = random.uniform(0.5, 1.5, size=cycles.shape) * np.cos(cycles * phase)
    pose = _pose(random, n, frame)
    wobble = random.normal(scale=0.1, size=gt.shape)  # tones alone have no imaginary part
    return _probe(gt + pose, pred + pose / 2 + wobble, frame)


def _loud(n: int, t: int, frame: tuple[int, ...]) -> Probe:
    """Vary the loudness of sequences and of features; the sequence that is predicted worst is loud."""
    random = _random("loud", n, t, frame)
    gt, _, _ = _noise(n, t, frame)
    _, other, _ = _walks(n, t, frame)
    pred = gt[:, ::-1].copy()
    pred[0] = other[0]
    loudness = 2.0 ** random.integers(0, 3, size=(2, 1, 1, features(frame)))
    loudness = (
        loudness * 2.0 ** np.array([np.r_[4, np.arange(n - 1) % 2], np.r_[0, np.arange(n - 1) % 4]])[..., None, None]
    )
    return Probe(gt * loudness[0], pred * loudness[1], frame)


def _exchanged(n: int, t: int, frame: tuple[int, ...]) -> Probe:
    """Predict each sequence by another, so that each batch has an error: reversed in time, it has its own power."""
    probe = _loud(n, t, frame)
    return probe._replace(pred=np.roll(probe.pred, 1, axis=0))


def _shifted(n: int, t: int, frame: tuple[int, ...]) -> Probe:
    """Make the prediction late by five frames, and noisy."""
    random = _random("shifted", n, t, frame)
    gt, _, _ = _walks(n, t, frame)
    return _probe(gt, np.roll(gt, 5, axis=1) + random.normal(scale=0.3, size=gt.shape), frame)


def _offset(n: int, t: int, frame: tuple[int, ...]) -> Probe:
    """Give the prediction another mean pose."""
    random = _random("offset", n, t, frame)
    gt, pred = random.normal(scale=0.5, size=(2, n, t, features(frame)))
    return _probe(gt, pred + 2 * np.sign(_pose(random, n, frame)), frame)


def _odd(n: int, t: int, frame: tuple[int, ...]) -> Probe:
    """Motion with most of its power in imaginary parts, so that squares of complex numbers have a negative sum."""
    random = _random("odd", n, t, frame)
    phase = 2 * np.pi * np.arange(t)[:, np.newaxis] / t
    cycles = random.integers(1, t // 2 - 1, size=(2, n, 1, features(frame)))
    gt, pred = 1.5 * np.sin(cycles * phase) + random.normal(scale=0.4, size=(2, n, t, features(frame)))
    return _probe(gt + _pose(random, n, frame) / 4, pred + _pose(random, n, frame) / 4, frame)


def _pose(random: np.random.Generator, n: int, frame: tuple[int, ...]) -> Float64:
    """Draw mean poses ``(n, 1, D)`` between 0.5 and 1.5 away from 0."""
    shape = (n, 1, features(frame))
    return np.asarray(random.choice([-1.0, 1.0], size=shape) * random.uniform(0.5, 1.5, size=shape))


def _random(kind: str, n: int, t: int, frame: tuple[int, ...]) -> np.random.Generator:
    return np.random.default_rng([*kind.encode(), n, t, features(frame)])


def _probe(gt: Float64, pred: Float64, frame: tuple[int, ...]) -> Probe:
    gt, pred = (np.clip(np.round(motion * 32), -127, 127) / 32 for motion in (gt, pred))
    return Probe(gt, pred, frame)
