"""Motion whose shares of power outside DC are those that score best, by a network or without one.

Most of a four-second NPSS is the share of each angle's power outside DC. These predictors are made for the metric: they
predict the shares, and impose them on the motion of other predictors.
"""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import torch

from npss.predictors import periodic
from npss.validation import Array, Float64
from npss_baselines.data.tasks import N_TARGET
from npss_baselines.fitted.angles import ANGLES, SWAPPED
from npss_baselines.fitted.base import Fitted, Progress, checked, inside
from npss_baselines.fitted.blend import Blend, BlendSettings
from npss_baselines.fitted.motion import Motion
from npss_baselines.fitted.network import Ensemble, NetworkSettings, train, weighted_median
from npss_baselines.fitted.shares import halves, moments

_ROUNDS = 15
_PULL = np.exp(-np.arange(N_TARGET) / 12)[:, np.newaxis]  # towards the blend, in the first second
_HIGHEST = 15  # frequency, in cycles per four seconds
_LARGEST = 0.99  # share


def with_shares(motion: Float64, paper: Float64, released: Float64) -> Float64:
    """Return motion (N, 100, D) with these shares (N, D), near the given motion in the first second.

    The circularly even and odd halves of each angle's deviation from its mean are scaled to the shares; all of the
    angle is scaled to be near the given one, which no share depends on; and the first second is pulled back.
    """
    outside, even = (np.clip(s, 1e-6, _LARGEST) / (1 - np.clip(s, 1e-6, _LARGEST)) for s in (paper, released))
    odd = np.maximum(outside - even, 1e-6)
    result = motion
    for _ in range(_ROUNDS):
        mean = result.mean(axis=1, keepdims=True)
        deviation = _low_pass(result - mean)
        parts = []
        for half, target in zip(halves(deviation), (even, odd), strict=True):
            power = np.square(half).mean(axis=1, keepdims=True)
            parts.append(half * np.abs(mean) * np.sqrt(target[:, np.newaxis] / (power + 1e-12)))
        scaled = mean + parts[0] + parts[1]
        products = (scaled * motion).sum(axis=1), np.square(scaled).sum(axis=1) + 1e-12
        scaled = scaled * np.clip(products[0] / products[1], 0.5, 2)[:, np.newaxis]
        result = scaled + _PULL * (motion - scaled)
    return result


class WithShares(Fitted):
    """A blend of simple predictors, with the predicted shares of power outside DC."""

    _blend: Blend

    @abstractmethod
    def shares(self, seed: Float64, action: int) -> tuple[Float64, Float64]:
        """Return the shares (N, 48) over four seconds, `paper` and `released`."""

    def predict(self, seed: Float64, action: int) -> Float64:
        """Predict the angles."""
        return with_shares(self._blend.predict(seed, action), *self.shares(seed, action))


class MedianShare(WithShares):
    """Shares without a network: the geometric mean of the training median and the share of the periodic continuation.

    The median of each angle is weighted by power, over windows and their mirror images.
    """

    Settings: ClassVar[type] = BlendSettings

    def __init__(self, blend: Blend, medians: Float64) -> None:
        self._blend = blend
        self._medians = medians  # (A, 2, 48)

    @classmethod
    def fit(cls, motion: Motion, settings: Any, *, seed: int, progress: Progress) -> Self:
        """Fit the blend and the medians."""
        blend = Blend.fit(motion, settings, progress=progress)
        medians = []
        for action in motion.actions[: motion.n_predicted]:
            found = moments(motion.of(actions=[action]).windows().target.astype(np.float64))
            outside = (found.variance, found.even)
            medians.append([_median(share, found.mean**2 + o) for share, o in zip(found.shares, outside, strict=True)])
        return cls(blend, np.array(medians))

    def arrays(self) -> dict[str, Array]:
        """Return the blend and the medians."""
        return {"medians": self._medians, **{f"blend.{k}": v for k, v in self._blend.arrays().items()}}

    @classmethod
    def restore(cls, n_predicted: int, settings: Any, arrays: Mapping[str, Array]) -> Self:
        """Return the predictor with these arrays."""
        blend = Blend.restore(n_predicted, settings, inside(arrays, "blend"))
        own = {name: value for name, value in arrays.items() if not name.startswith("blend.")}
        return cls(blend, *checked(own, {"medians": (n_predicted, 2, len(ANGLES))}))

    def shares(self, seed: Float64, action: int) -> tuple[Float64, Float64]:
        """Return the geometric means."""
        cycle = moments(periodic(seed, N_TARGET)).shares
        paper, released = (np.sqrt(m * s) for m, s in zip(self._medians[action], cycle, strict=True))
        return paper, released


@dataclass(frozen=True)
class ShareSettings(NetworkSettings, BlendSettings):
    """The settings of `DCShare`: those of its networks and of its blend."""


class DCShare(WithShares):
    """Shares by networks that are trained on all actions of the source."""

    Settings: ClassVar[type] = ShareSettings
    others: ClassVar[bool] = True

    def __init__(self, blend: Blend, ensemble: Ensemble) -> None:
        self._blend = blend
        self._ensemble = ensemble

    @classmethod
    def fit(cls, motion: Motion, settings: Any, *, seed: int, progress: Progress) -> Self:
        """Fit the blend, and train the networks."""
        blend = Blend.fit(motion, settings, progress=lambda share: progress(0.1 * share))
        ensemble = train(motion, settings, seed=seed, progress=lambda share: progress(0.1 + 0.9 * share))
        return cls(blend, ensemble)

    def arrays(self) -> dict[str, Array]:
        """Return the blend and the networks' weights."""
        return {**self._ensemble.arrays(), **{f"blend.{k}": v for k, v in self._blend.arrays().items()}}

    @classmethod
    def restore(cls, n_predicted: int, settings: Any, arrays: Mapping[str, Array]) -> Self:
        """Return the predictor with these arrays."""
        blend = Blend.restore(n_predicted, settings, inside(arrays, "blend"))
        own = {name: value for name, value in arrays.items() if not name.startswith("blend.")}
        return cls(blend, Ensemble.restore(settings.networks, settings.hidden, own))

    def shares(self, seed: Float64, action: int) -> tuple[Float64, Float64]:
        """Ask the networks."""
        shares, _ = self._ensemble.answers(seed, action)
        return shares[:, :, 0, 0], shares[:, :, 0, 1]


def _median(share: Array, weight: Array) -> Float64:
    """Return the weighted median of each angle (48,), over windows and their mirror images."""
    both = (torch.from_numpy(np.concatenate([values, values[:, SWAPPED]])) for values in (share, weight))
    return weighted_median(*both).numpy()


def _low_pass(deviation: Float64) -> Float64:
    """Return motion (N, 100, D) without frequencies above `_HIGHEST`."""
    spectrum = np.fft.rfft(deviation, axis=1)
    spectrum[:, _HIGHEST + 1 :] = 0
    return np.fft.irfft(spectrum, deviation.shape[1], axis=1)
