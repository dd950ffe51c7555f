"""A blend of four simple predictors, which is near the truth in the first second."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
import torch

from npss.predictors import gated_periodic
from npss.validation import Array, Float64
from npss_baselines.data.tasks import N_TARGET
from npss_baselines.fitted.base import Progress, inside, one_thread
from npss_baselines.fitted.motion import LENGTH, Motion, folds
from npss_baselines.fitted.nearest import Nearest, NearestSettings
from npss_baselines.fitted.ridge import Ridge, RidgeSettings

N_PREDICTORS = 4  # zero-velocity, gated periodic, ridge, nearest continuations
_FRAMES = (0, 1, 3, 5, 7, 9, 13, 18, 24, 35, 50, 70, 99)  # that weights are fitted on
_STEPS, _RATE = 300, 0.05
_POWERS = 3  # of the logarithm of time, in the logits of the weights


@dataclass(frozen=True)
class BlendSettings:
    """The settings of the predictors that are blended.

    Attributes
    ----------
    penalty : float
        The penalty of ridge.
    neighbours : int
        Number of nearest continuations.
    folds : int
        Number of folds, by subject, that ridge and neighbours are fitted without in turn, to fit the weights on them.
    """

    penalty: float = 0.1
    neighbours: int = 10
    folds: int = 3


class Blend:
    """A convex combination for each action and frame, by weights that are smooth in the logarithm of time.

    The weights minimise the Euclidean norm of the error of all angles on training subjects that ridge and neighbours
    have not seen.
    """

    def __init__(self, ridge: Ridge, nearest: Nearest, logits: Float64) -> None:
        self._ridge, self._nearest = ridge, nearest
        self._logits = logits  # (A, 4, powers)

    @classmethod
    def fit(cls, motion: Motion, settings: BlendSettings, *, progress: Progress) -> Self:
        """Fit the predictors and their weights, for each action to predict."""
        logits = []
        for i, action in enumerate(motion.actions[: motion.n_predicted]):
            grams = []
            of_action = motion.of(actions=[action])
            parts = folds(of_action.groups, settings.folds)
            for held_out in parts if len(parts) > 1 else [()]:
                ridge, nearest = _fitted(of_action.of(without=held_out), settings)
                rest = set(of_action.groups) - set(held_out) if held_out else ()
                windows = of_action.of(without=rest).windows(stride=20)
                predicted = _all(windows.seed.astype(np.float64), ridge, nearest, 0)
                error = (predicted - windows.target)[:, :, list(_FRAMES)]  # (4, N, frames, 48)
                grams.append(np.einsum("antd,bntd->ntab", error, error))
                progress((i + len(grams) / (len(parts) + 1)) / motion.n_predicted)
            logits.append(_fit_weights(np.concatenate(grams)))
        return cls(*_fitted(motion, settings), np.stack(logits))

    def arrays(self) -> dict[str, Array]:
        """Return what was fitted."""
        parts = {"ridge": self._ridge.arrays(), "nearest": self._nearest.arrays()}
        inner = {f"{part}.{name}": value for part, arrays in parts.items() for name, value in arrays.items()}
        return {"blend": self._logits, **inner}

    @classmethod
    def restore(cls, n_predicted: int, settings: BlendSettings, arrays: Mapping[str, Array]) -> Self:
        """Return the blend with these arrays."""
        ridge = Ridge.restore(n_predicted, RidgeSettings(penalty=settings.penalty), inside(arrays, "ridge"))
        nearest = Nearest.restore(n_predicted, NearestSettings(settings.neighbours), inside(arrays, "nearest"))
        logits = arrays["blend"]
        if logits.shape != (n_predicted, N_PREDICTORS, _POWERS):
            raise ValueError(f"blend: expected shape {(n_predicted, N_PREDICTORS, _POWERS)}, got {logits.shape}")
        return cls(ridge, nearest, logits)

    def predict(self, seed: Float64, action: int) -> Float64:
        """Predict angles (N, 100, 48)."""
        weights = _weights(torch.from_numpy(self._logits[action]), range(N_TARGET)).numpy()
        blended: Float64 = np.einsum("ta,antd->ntd", weights, _all(seed, self._ridge, self._nearest, action))
        return blended


def _fitted(motion: Motion, settings: BlendSettings) -> tuple[Ridge, Nearest]:
    ridge = Ridge.fit(motion, RidgeSettings(penalty=settings.penalty), seed=0, progress=lambda share: None)
    neighbours = NearestSettings(settings.neighbours)
    return ridge, Nearest.fit(motion, neighbours, seed=0, progress=lambda share: None)


def _all(seed: Float64, ridge: Ridge, nearest: Nearest, action: int) -> Float64:
    """Return the predictions (4, N, 100, 48) of all four."""
    still = np.repeat(seed[:, -1:], N_TARGET, axis=1)
    return np.stack([still, gated_periodic(seed, N_TARGET), ridge.predict(seed, action), nearest.predict(seed, action)])


def _weights(logits: torch.Tensor, frames: object) -> torch.Tensor:
    """Return the weights (frames, 4)."""
    time = torch.log(torch.tensor([*frames], dtype=torch.float64) + 1) / np.log(LENGTH)  # type: ignore[misc]
    powers = torch.stack([time**power for power in range(_POWERS)])
    return torch.softmax(logits @ powers, 0).T


def _fit_weights(grams: Float64) -> Float64:
    """Fit the logits (4, powers) to the products (N, frames, 4, 4) of the predictors' errors."""
    products = torch.from_numpy(grams)
    scale = torch.einsum("ntaa->nta", products).mean(2).sqrt().mean(0)  # all frames count alike
    logits = torch.zeros(N_PREDICTORS, _POWERS, dtype=torch.float64, requires_grad=True)
    optimizer = torch.optim.Adam([logits], _RATE)
    with one_thread():
        for _ in range(_STEPS):
            weights = _weights(logits, _FRAMES)
            squares = torch.einsum("ta,ntab,tb->nt", weights, products, weights)
            loss = ((squares + 1e-12).sqrt().mean(0) / scale).mean() + 1e-4 * logits.square().sum()
            optimizer.zero_grad()
            loss.backward()  # type: ignore[no-untyped-call]
            optimizer.step()
    return logits.detach().numpy()
