"""The mean of the nearest continuations in the training motion."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from npss.validation import Array, Float64
from npss_baselines.data.tasks import N_SEED, N_TARGET
from npss_baselines.fitted.angles import ANGLES, mirrored
from npss_baselines.fitted.base import Fitted, Progress, checked
from npss_baselines.fitted.motion import Float32, Motion

_BLOCK = 64  # sequences at a time: bounds the memory of distances and continuations


@dataclass(frozen=True)
class NearestSettings:
    """The settings of `Nearest`.

    Attributes
    ----------
    neighbours : int
        Number of continuations to average.
    frames : int
        Number of last seed frames to compare.
    pose_weight : float
        Weight of the last pose itself, relative to the motion before it.
    """

    neighbours: int = 10
    frames: int = 10
    pose_weight: float = 0.5


class Nearest(Fitted):
    """The mean of the nearest windows' continuations, moved to start at the last seed frame.

    Windows are compared by the Euclidean distance of their last seed frames, each relative to the last one, and of the
    last one. Mirror images are searched, too.
    """

    Settings: ClassVar[type] = NearestSettings

    def __init__(self, settings: NearestSettings, windows: list[Float32]) -> None:
        self.settings = settings
        self._windows = windows  # of each action, (N, frames + 100, 48)

    @classmethod
    def fit(cls, motion: Motion, settings: Any, *, seed: int, progress: Progress) -> Self:
        """Keep the windows of each action."""
        kept = []
        for action in motion.actions[: motion.n_predicted]:
            windows = motion.of(actions=[action]).windows()
            kept.append(np.concatenate([windows.seed[:, N_SEED - settings.frames :], windows.target], axis=1))
            progress(len(kept) / motion.n_predicted)
        return cls(settings, kept)

    def arrays(self) -> dict[str, Array]:
        """Return the windows of each action."""
        return {f"windows.{action}": windows for action, windows in enumerate(self._windows)}

    @classmethod
    def restore(cls, n_predicted: int, settings: Any, arrays: Mapping[str, Array]) -> Self:
        """Return the predictor with these windows."""
        names = [f"windows.{action}" for action in range(n_predicted)]
        shape = settings.frames + N_TARGET, len(ANGLES)
        return cls(settings, checked(arrays, {name: (len(arrays[name]), *shape) for name in names}))

    def predict(self, seed: Float64, action: int) -> Float64:
        """Predict the angles."""
        frames, windows = self.settings.frames, self._windows[action]
        windows = np.concatenate([windows, mirrored(windows)])
        keys = self._key(windows[:, :frames].astype(np.float64))
        squares = np.square(keys).sum(axis=1)
        predicted = np.empty((len(seed), N_TARGET, len(ANGLES)))
        for start in range(0, len(seed), _BLOCK):
            read = seed[start : start + _BLOCK, -frames:]
            distances = squares - 2 * self._key(read) @ keys.T  # up to a constant for each sequence
            nearest = np.argsort(distances, axis=1, kind="stable")[:, : self.settings.neighbours]
            chosen = windows[nearest].astype(np.float64)  # (B, neighbours, frames + 100, 48)
            moved = chosen[:, :, frames:] - chosen[:, :, frames - 1 : frames]
            predicted[start : start + _BLOCK] = read[:, -1:] + moved.mean(axis=1)
        return predicted

    def _key(self, read: Float64) -> Float64:
        """Return what is compared (N, F) of the last seed frames (N, frames, 48)."""
        last = read[:, -1:]
        pose = self.settings.pose_weight * np.sqrt(self.settings.frames) * last
        return np.concatenate([read[:, :-1] - last, pose], axis=1).reshape(len(read), -1)
