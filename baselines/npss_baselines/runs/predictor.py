"""A trained model as a predictor of poses."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import torch

from npss.protocol import Normalization
from npss.validation import Array, Seed, check_finite, generator, positive_integer, renamed
from npss_baselines.models.base import MotionModel

__all__ = ["ModelPredictor"]


@dataclass(frozen=True)
class ModelPredictor:
    """A model as a `npss.predictors.Predictor`.

    Attributes
    ----------
    model : MotionModel
        The model, on any device.
    normalization : Normalization
        The normalisation of its poses.
    action : int
        The index of the action to predict.
    seed : int or numpy.random.Generator
        Source of the noise.
    """

    model: MotionModel
    normalization: Normalization
    action: int
    seed: Seed

    def __post_init__(self) -> None:
        object.__setattr__(self, "seed", generator(self.seed))

    @renamed(seed="seed_frames")
    def __call__(self, seed_frames: npt.ArrayLike, n_target: int) -> Array:
        """Predict the frames after the seed frames.

        Parameters
        ----------
        seed_frames : (N, S, 99) array_like
            Poses of Human3.6M at 25 frames per second, as exponential maps.
        n_target : int
            Number of frames to predict.

        Returns
        -------
        (N, n_target, 99) ndarray
            Poses; columns that the model does not predict are at their mean. float32 for float32 input, else float64.

        Raises
        ------
        TypeError, ValueError
            If the input is invalid, or a predicted value is NaN or infinite.
        """
        n_target = positive_integer("n_target", n_target)
        seen = self.normalization.normalize(seed_frames)
        if seen.ndim != 3 or 0 in seen.shape:
            raise ValueError(
                f"seed_frames: expected shape (N, S, {len(self.normalization.mean)}), got {np.shape(seed_frames)}"
            )
        device = next(self.model.parameters()).device
        poses = torch.from_numpy(seen.astype(np.float32)).to(device)  # (N, S, 54)
        label = torch.zeros(len(poses), self.model.n_actions, device=device)
        label[:, self.action] = 1
        training = self.model.training
        with torch.no_grad(), torch.random.fork_rng(devices=[device] if device.type == "cuda" else []):
            torch.manual_seed(int(generator(self.seed).integers(2**63)))
            try:
                predicted = self.model.eval().predict(poses, label, n_target)  # (N, n_target, 54)
            finally:
                self.model.train(training)
        values = predicted.cpu().numpy().astype(seen.dtype)
        check_finite("the model's prediction", values)
        return self.normalization.unnormalize(values)
