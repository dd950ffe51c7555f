"""Ridge regression from the cosine transform of the seed frames to that of the target frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from npss.validation import Array, Float64
from npss_baselines.data.tasks import N_SEED, N_TARGET
from npss_baselines.fitted.angles import ANGLES, mirrored
from npss_baselines.fitted.base import Fitted, Progress, checked
from npss_baselines.fitted.cosine import cosines
from npss_baselines.fitted.motion import Motion

D = len(ANGLES)


@dataclass(frozen=True)
class RidgeSettings:
    """The settings of `Ridge`.

    Attributes
    ----------
    seed_coefficients, target_coefficients : int
        Coefficients of each angle in the seed frames, and in the target frames.
    penalty : float
        The penalty of a squared weight, relative to a window.
    """

    seed_coefficients: int = 15
    target_coefficients: int = 30
    penalty: float = 0.1


class Ridge(Fitted):
    """A linear map for each action.

    It reads the cosine transform of each angle's difference from the last seed frame, and the last seed frame; it
    predicts the cosine transform of the difference from the last seed frame. Mirror images of windows are fitted, too.
    """

    Settings: ClassVar[type] = RidgeSettings

    def __init__(self, settings: RidgeSettings, read: Float64, predicted: Float64, weights: Float64) -> None:
        self.settings = settings
        self._read = read  # (A, F), means of what is read
        self._predicted = predicted  # (A, K), means of what is predicted
        self._weights = weights  # (A, F, K)

    @classmethod
    def fit(cls, motion: Motion, settings: Any, *, seed: int, progress: Progress) -> Self:
        """Fit the map of each action."""
        read, predicted, weights = [], [], []
        for action in motion.actions[: motion.n_predicted]:
            windows = motion.of(actions=[action]).windows()
            frames = np.concatenate([windows.seed, windows.target], axis=1).astype(np.float64)
            frames = np.concatenate([frames, mirrored(frames)])
            x = _features(frames[:, :N_SEED], settings)
            last = frames[:, N_SEED - 1 : N_SEED]
            y = _transform(frames[:, N_SEED:] - last, settings.target_coefficients).reshape(len(x), -1)
            read.append(x.mean(axis=0))
            predicted.append(y.mean(axis=0))
            x -= read[-1]
            penalty = settings.penalty * len(x) * np.eye(x.shape[1])
            weights.append(np.linalg.solve(x.T @ x + penalty, x.T @ (y - predicted[-1])))
            progress(len(weights) / motion.n_predicted)
        return cls(settings, np.stack(read), np.stack(predicted), np.stack(weights))

    def arrays(self) -> dict[str, Array]:
        """Return means and weights."""
        return {"read": self._read, "predicted": self._predicted, "weights": self._weights}

    @classmethod
    def restore(cls, n_predicted: int, settings: Any, arrays: Mapping[str, Array]) -> Self:
        """Return the map with these weights."""
        n_read, n_written = (settings.seed_coefficients + 1) * D, settings.target_coefficients * D
        shapes = {"read": (n_read,), "predicted": (n_written,), "weights": (n_read, n_written)}
        return cls(settings, *checked(arrays, {name: (n_predicted, *shape) for name, shape in shapes.items()}))

    def predict(self, seed: Float64, action: int) -> Float64:
        """Predict the angles."""
        y = (_features(seed, self.settings) - self._read[action]) @ self._weights[action] + self._predicted[action]
        coefficients = y.reshape(len(seed), self.settings.target_coefficients, D)
        basis = cosines(N_TARGET, self.settings.target_coefficients)
        predicted: Float64 = seed[:, -1:] + np.einsum("kt,nkd->ntd", basis, coefficients)
        return predicted


def _features(seed: Float64, settings: RidgeSettings) -> Float64:
    """Return what the map reads (N, F)."""
    last = seed[:, -1]
    coefficients = _transform(seed - last[:, np.newaxis], settings.seed_coefficients)
    return np.concatenate([coefficients.reshape(len(seed), -1), last], axis=1)


def _transform(frames: Float64, n: int) -> Float64:
    """Return the first coefficients (N, n, D) of the cosine transform over the frames (N, T, D)."""
    coefficients: Float64 = np.einsum("kt,ntd->nkd", cosines(frames.shape[1], n), frames, optimize=True)
    return coefficients
