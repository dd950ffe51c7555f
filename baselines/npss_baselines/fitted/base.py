"""What all fitted predictors share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np
import numpy.typing as npt
import torch

from npss.predictors import gated_periodic
from npss.validation import Array, Float64, check_finite, positive_integer, real_array, renamed
from npss_baselines.data.tasks import N_SEED, N_TARGET
from npss_baselines.fitted.angles import ROOT, angles_of, poses_of
from npss_baselines.fitted.motion import Motion

#: Called with the share of the work that is done.
Progress = Callable[[float], None]
_POSE = 99


@contextmanager
def one_thread() -> Iterator[None]:
    """Use one thread of torch: small products are no faster on more, and the result depends on no machine's number."""
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    try:
        yield
    finally:
        torch.set_num_threads(threads)


class Fitted(ABC):
    """A predictor of Euler angles, fitted to training motion: 100 frames after 50, at 25 frames per second.

    A subclass is fitted by `fit`, and is restored by `restore` from the arrays that `arrays` returns.
    """

    #: The settings of the fit: a dataclass of numbers and text.
    Settings: ClassVar[type]
    #: Whether other actions than those to predict are fitted, too.
    others: ClassVar[bool] = False

    @classmethod
    @abstractmethod
    def fit(cls, motion: Motion, settings: Any, *, seed: int, progress: Progress) -> Self:
        """Fit to motion; the same motion, settings and seed give the same predictor."""

    @abstractmethod
    def arrays(self) -> dict[str, Array]:
        """Return everything that was fitted."""

    @classmethod
    @abstractmethod
    def restore(cls, n_predicted: int, settings: Any, arrays: Mapping[str, Array]) -> Self:
        """Return the predictor with these arrays.

        Raises
        ------
        KeyError, ValueError
            If an array is missing or has another shape.
        """

    @abstractmethod
    def predict(self, seed: Float64, action: int) -> Float64:
        """Predict angles (N, 100, 48) from those of the seed frames (N, 50, 48); `action` is an index."""


def checked(arrays: Mapping[str, Array], shapes: Mapping[str, tuple[int, ...]]) -> list[Array]:
    """Return the arrays of these names; raise unless they have these shapes, and there are no others."""
    if names := sorted(set(arrays) ^ set(shapes)):
        raise ValueError(f"{names[0]}: {'unknown' if names[0] in arrays else 'missing'}")
    for name, shape in shapes.items():
        if arrays[name].shape != shape:
            raise ValueError(f"{name}: expected shape {shape}, got {arrays[name].shape}")
    return [arrays[name] for name in shapes]


def inside(arrays: Mapping[str, Array], part: str) -> dict[str, Array]:
    """Return the arrays of a part, whose names begin with it and a dot."""
    return {name.removeprefix(f"{part}."): value for name, value in arrays.items() if name.startswith(f"{part}.")}


@dataclass(frozen=True)
class FittedPredictor:
    """A fitted predictor of an action as a `npss.predictors.Predictor`.

    Attributes
    ----------
    fitted : Fitted
        The predictor of angles.
    action : int
        The index of the action.
    """

    fitted: Fitted
    action: int

    @renamed(seed="seed_frames")
    def __call__(self, seed_frames: npt.ArrayLike, n_target: int) -> Array:
        """Predict the frames after the seed frames.

        Parameters
        ----------
        seed_frames : (N, S, 99) array_like
            Poses of Human3.6M at 25 frames per second, as exponential maps; the last 50 frames are read.
        n_target : int
            Number of frames to predict, at most 100.

        Returns
        -------
        (N, n_target, 99) ndarray
            Poses. The root moves as `npss.predictors.gated_periodic` predicts; other columns that do not vary are those
            of the last seed frame. float32 for float32 input, else float64.

        Raises
        ------
        TypeError, ValueError
            If the input is invalid.
        """
        if positive_integer("n_target", n_target) > N_TARGET:
            raise ValueError(
                f"n_target: expected at most {N_TARGET} frames, which the predictor is fitted to, got {n_target}"
            )
        given = real_array("seed_frames", seed_frames)
        if given.ndim != 3 or given.shape[2] != _POSE or 0 in given.shape:
            raise ValueError(f"seed_frames: expected shape (N, S, {_POSE}), got {given.shape}")
        if given.shape[1] < N_SEED:
            raise ValueError(f"seed_frames: {given.shape[1]} frames, but the predictor uses the last {N_SEED}")
        check_finite("seed_frames", given)
        seen = given[:, -N_SEED:].astype(np.float64)
        poses = poses_of(self.fitted.predict(angles_of(seen), self.action)[:, :n_target], seen[:, -1])
        poses[..., :ROOT] = gated_periodic(seen, n_target)[..., :ROOT]
        return poses.astype(given.dtype if given.dtype == np.float32 else np.float64)
