"""What the share network reads: descriptors of each angle in the seed frames.

They are computed from statistics that are easy to move and to scale, so that a motion can be augmented without being
computed again.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import torch
from torch import Tensor

from npss.predictors import periodic
from npss_baselines.data.tasks import N_TARGET
from npss_baselines.fitted.angles import SIGNS, SWAPPED
from npss_baselines.fitted.cosine import cosines
from npss_baselines.fitted.motion import Float32
from npss_baselines.fitted.shares import moments

#: Spans of the target frames: four seconds, and the windows of Table 5 of the NPSS paper.
SPANS = ((0, 100), (0, 25), (25, 50), (50, 100))
#: Frames whose speed is predicted: after the first second.
MOVING = (25, N_TARGET)
N_COSINES = 12
_CHUNK = 256
_SMALLEST = 1e-3  # radians: spreads below it are all the same
_LIMBS = ((0, 8), (8, 16), (16, 28), (28, 38), (38, 48))  # of `ANGLES`: right leg, left leg, trunk, left arm, right arm


class Statistics(NamedTuple):
    """Statistics of angles, float32: (N, D, ...)."""

    level: Tensor  # mean of the seed frames (N, D)
    signed: Tensor  # relative to the level, with its sign: last frame, cosine transform (N, D, 1 + 12)
    spread: Tensor  # in radians: standard deviations, speeds (N, D, 6)
    ratio: Tensor  # without a unit (N, D, 1): misfit of the period
    periodic: Tensor  # mean relative to the level, variance, even variance, by span (N, D, 4, 3)

    def mirrored(self, chosen: Tensor) -> Statistics:
        """Return the statistics with those of some motions (N,) replaced by their mirror images."""
        place, sign = torch.tensor(SWAPPED), torch.tensor(SIGNS, dtype=torch.float32)

        def swap(values: Tensor, signed: Tensor) -> Tensor:
            signs = (sign.reshape(-1, *[1] * (values.ndim - 2)) - 1) * signed + 1
            return torch.where(chosen.reshape(-1, *[1] * (values.ndim - 1)), values[:, place] * signs, values)

        one = torch.ones(1)
        return Statistics(
            swap(self.level, one),
            swap(self.signed, one),
            swap(self.spread, 0 * one),
            swap(self.ratio, 0 * one),
            swap(self.periodic, torch.tensor([1.0, 0.0, 0.0])),
        )

    def changed(self, shift: Tensor, scale: Tensor) -> Statistics:
        """Return those of motions whose level is moved by `shift` and whose deviation is scaled by `scale` (N, D)."""
        wide = scale[..., None]
        powers = torch.stack([scale, scale**2, scale**2], -1)[:, :, None]
        return Statistics(
            self.level + shift, self.signed * wide, self.spread * wide, self.ratio, self.periodic * powers
        )


def statistics_of(seed: Float32) -> Statistics:
    """Compute the statistics of seed frames (N, 50, D)."""
    parts = [_statistics(seed[start : start + _CHUNK]) for start in range(0, len(seed), _CHUNK)]
    return Statistics(
        *(torch.from_numpy(np.concatenate(values).astype(np.float32)) for values in zip(*parts, strict=True))
    )


def span_moments(target: Float32, level: Float32) -> Tensor:
    """Return mean relative to a level (N, D), variance and even variance of target frames, by span (N, D, 4, 3)."""
    parts = []
    for start in range(0, len(target), _CHUNK):
        chunk = target[start : start + _CHUNK] - level[start : start + _CHUNK, np.newaxis]
        parts.append(np.stack([np.stack(moments(chunk[:, first:end]), -1) for first, end in SPANS], 2))
    return torch.from_numpy(np.concatenate(parts).astype(np.float32))


def speeds_of(target: Float32) -> Tensor:
    """Return the mean speed of each angle after the first second, in radians per frame (N, D)."""
    first, end = MOVING
    return torch.from_numpy(np.abs(np.diff(target[:, first - 1 : end], axis=1)).mean(axis=1).astype(np.float32))


def _statistics(seed: Float32) -> tuple[np.ndarray, ...]:
    level, last = seed.mean(axis=1), seed[:, -1]
    coefficients = np.einsum("kt,ntd->ndk", cosines(seed.shape[1], N_COSINES).astype(np.float32), seed - last[:, None])
    step = np.diff(seed, axis=1)
    continued = periodic(seed, N_TARGET)
    before = periodic(seed[:, :-10], 10, lags=(15, 30))  # what the period would have predicted
    misfit = np.sqrt(np.square(before - seed[:, -10:]).mean(axis=1))
    spread = seed.std(axis=1)
    spreads = [
        spread,
        seed[:, -25:].std(axis=1),
        seed[:, -10:].std(axis=1),
        np.abs(step).mean(axis=1),
        np.abs(step[:, -10:]).mean(axis=1),
        np.abs(np.diff(continued[:, MOVING[0] - 1 :], axis=1)).mean(axis=1),
    ]
    return (
        level,
        np.concatenate([(last - level)[..., None], coefficients], -1),
        np.stack(spreads, -1),
        (misfit / (spread + _SMALLEST))[..., None],
        span_moments(continued, level).numpy(),
    )


def descriptors(statistics: Statistics) -> Tensor:
    """Return the descriptors of each angle (N, D, F)."""
    level, signed, spread, ratio, cycle = statistics
    logs = torch.log(spread + _SMALLEST)
    mean = level[..., None] + cycle[..., 0]  # (N, D, 4)
    shares = [torch.log10(share_of(cycle[..., part], mean) + 1e-4) for part in (1, 2)]
    whole = torch.log10(share_of(spread[..., 0] ** 2, level) + 1e-4)
    limbs = torch.stack([logs[:, first:end, 0].mean(1) for first, end in _LIMBS], -1)
    last = level + signed[..., 0]
    parts = [
        level[..., None],
        level.abs()[..., None],
        signed,
        logs,
        ratio.clamp(max=4),
        *shares,
        whole[..., None],
        (torch.pi - last.abs())[..., None],
        logs[:, SWAPPED, :1],
        limbs[:, None].expand(-1, level.shape[1], -1),
    ]
    return torch.cat(parts, -1)


def body(statistics: Statistics) -> Tensor:
    """Return what is read of the whole body (N, 2 D): spreads and last pose."""
    return torch.cat(
        [torch.log(statistics.spread[..., 0] + _SMALLEST), statistics.level + statistics.signed[..., 0]], 1
    )


def share_of(outside: Tensor, mean: Tensor) -> Tensor:
    """Return the share of the power outside DC."""
    return outside / (outside + mean**2 + 1e-12)
