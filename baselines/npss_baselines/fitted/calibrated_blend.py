"""A blend of simple predictors whose power and speed are calibrated: good in every column of the tables."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import torch
from torch import Tensor

from npss.validation import Array, Float64
from npss_baselines.data.tasks import N_TARGET
from npss_baselines.fitted.base import Fitted, Progress, inside, one_thread
from npss_baselines.fitted.blend import Blend, BlendSettings
from npss_baselines.fitted.cosine import cosines
from npss_baselines.fitted.descriptors import MOVING, SPANS
from npss_baselines.fitted.motion import Motion
from npss_baselines.fitted.network import Ensemble, NetworkSettings, train

_BLOCK = 128  # sequences at a time
_PULL = (1 + np.arange(N_TARGET) / 2) ** -2.0  # weight of the distance from the blend


@dataclass(frozen=True)
class CalibratedSettings(NetworkSettings, BlendSettings):
    """The settings of `CalibratedBlend`.

    Attributes
    ----------
    coefficients : int
        Coefficients of the cosine transform of each angle that are changed.
    damping : float
        How much less the k-th of them is changed: the step is divided by 1 + damping * k.
    steps : int
        Steps of gradient descent.
    rate : float
        Highest rate of the steps, in radians.
    near : float
        Weight of the distance from the blend in the first second.
    speed : float
        Weight of the speed.
    """

    coefficients: int = 40
    damping: float = 0.1
    steps: int = 300
    rate: float = 0.05
    near: float = 0.2
    speed: float = 0.1


class CalibratedBlend(Fitted):
    """A blend of simple predictors, moved by gradient descent to predicted shares and speeds.

    The networks predict each angle's share of power outside DC over four seconds and the windows of Table 5 of the NPSS
    paper, under both conventions, and its mean speed after the first second. The first second stays near the blend.
    """

    Settings: ClassVar[type] = CalibratedSettings
    others: ClassVar[bool] = True

    def __init__(self, settings: CalibratedSettings, blend: Blend, ensemble: Ensemble) -> None:
        self.settings = settings
        self._blend = blend
        self._ensemble = ensemble

    @classmethod
    def fit(cls, motion: Motion, settings: Any, *, seed: int, progress: Progress) -> Self:
        """Fit the blend, and train the networks."""
        blend = Blend.fit(motion, settings, progress=lambda share: progress(0.1 * share))
        ensemble = train(motion, settings, seed=seed, progress=lambda share: progress(0.1 + 0.9 * share))
        return cls(settings, blend, ensemble)

    def arrays(self) -> dict[str, Array]:
        """Return the blend and the networks' weights."""
        return {**self._ensemble.arrays(), **{f"blend.{k}": v for k, v in self._blend.arrays().items()}}

    @classmethod
    def restore(cls, n_predicted: int, settings: Any, arrays: Mapping[str, Array]) -> Self:
        """Return the predictor with these arrays."""
        blend = Blend.restore(n_predicted, settings, inside(arrays, "blend"))
        own = {name: value for name, value in arrays.items() if not name.startswith("blend.")}
        return cls(settings, blend, Ensemble.restore(settings.networks, settings.hidden, own))

    def predict(self, seed: Float64, action: int) -> Float64:
        """Predict the angles."""
        blend = self._blend.predict(seed, action)
        shares, speed = self._ensemble.answers(seed, action)
        blocks = [slice(start, start + _BLOCK) for start in range(0, len(seed), _BLOCK)]
        return np.concatenate([calibrated(blend[b], shares[b], speed[b], self.settings) for b in blocks])


def calibrated(blend: Float64, shares: Float64, speed: Float64, settings: CalibratedSettings) -> Float64:
    """Move a blend to shares and speeds.

    Parameters
    ----------
    blend : (N, 100, D) ndarray
        The motion to start from.
    shares : (N, D, 4, 2) ndarray
        Shares of power outside DC, by span, `paper` and `released`.
    speed : (N, D) ndarray
        Mean speeds after the first second, in radians per frame.
    settings : CalibratedSettings
        The settings of the descent.

    Returns
    -------
    (N, 100, D) ndarray
        The motion.
    """
    start = torch.from_numpy(blend.transpose(0, 2, 1)).float()  # (N, D, 100)
    asked, pace = torch.from_numpy(shares).float(), torch.from_numpy(speed).float()
    n = settings.coefficients
    basis = torch.from_numpy(cosines(N_TARGET, n)).float() / (1 + settings.damping * torch.arange(n))[:, None]
    pull = torch.from_numpy(_PULL).float()
    # All of a sequence's terms are relative to its power, so that sequences do not depend on each other.
    powers = [_powers(start, first, end) for first, end in SPANS]
    scale = [(mean**2 * asked[:, :, i, 0]).sum(1, keepdim=True) + 1e-6 for i, (mean, _, _) in enumerate(powers)]
    generator = torch.Generator().manual_seed(0)
    noise = 1e-3 * torch.randn(start.shape[1], n, generator=generator)  # an angle that stands still has no gradient
    with one_thread():
        change = noise.expand(len(start), -1, -1).clone().requires_grad_()
        optimizer = torch.optim.Adam([change], settings.rate, betas=(0.9, 0.98))
        for step in range(settings.steps):
            optimizer.param_groups[0]["lr"] = settings.rate * 0.5 * (1 + np.cos(np.pi * step / settings.steps))
            motion = start + change @ basis
            loss = torch.zeros(len(start))
            for i, (first, end) in enumerate(SPANS):
                mean, variance, even = _powers(motion, first, end)
                for kind, outside in enumerate((variance, even)):
                    weight = (mean**2 + outside).detach()
                    share = outside / (mean**2 + outside + 1e-9)
                    error = (weight * (share - asked[:, :, i, kind]).abs()).sum(1) / scale[i][:, 0]
                    loss = loss + (settings.whole if i == 0 else 1.0) * error / 8
            paces = _pace(motion)
            total = pace.sum(1)
            loss = loss + settings.speed * ((paces - pace).abs().sum(1) + (paces.sum(1) - total).abs()) / total
            near = ((motion - start).square() * pull).sum((1, 2)) / (pull.sum() * 0.05)
            loss = loss + settings.near * near
            optimizer.zero_grad()
            loss.sum().backward()  # type: ignore[no-untyped-call]
            optimizer.step()
        with torch.no_grad():
            motion = start + change @ basis
    return motion.double().numpy().transpose(0, 2, 1)


def _powers(motion: Tensor, first: int, end: int) -> tuple[Tensor, Tensor, Tensor]:
    """Return mean, variance and variance of the circularly even half over a span (N, D)."""
    span = motion[..., first:end]
    mean = span.mean(-1)
    deviation = span - mean[..., None]
    even = (deviation + deviation.flip(-1).roll(1, -1)) / 2
    return mean, deviation.square().mean(-1), even.square().mean(-1)


def _pace(motion: Tensor) -> Tensor:
    """Return the mean speed of each angle after the first second (N, D)."""
    first, end = MOVING
    steps = motion[..., first - 1 : end].diff(dim=-1)
    return (steps.square() + 1e-8).sqrt().mean(-1)
