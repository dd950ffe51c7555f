"""Read and write trained models as run folders."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from npss.protocol import COLUMNS, POSE, Normalization
from npss.validation import Seed, renamed
from npss_baselines.fitted.base import FittedPredictor
from npss_baselines.models import MODELS
from npss_baselines.models.base import MotionModel
from npss_baselines.runs import config, fitted, weights
from npss_baselines.runs.config import Configuration
from npss_baselines.runs.fitted import FittedRun
from npss_baselines.runs.predictor import ModelPredictor

__all__ = ["Run", "load", "predictor_of"]

_PART = "model"  # of the file of weights


@dataclass(frozen=True)
class Run:
    """A trained model with everything that it needs to predict.

    Attributes
    ----------
    configuration : Configuration
        The configuration of the run.
    model : MotionModel
        The model.
    normalization : Normalization
        The normalisation of its poses.
    """

    configuration: Configuration
    model: MotionModel
    normalization: Normalization

    @renamed(rng="seed")
    def predictor(self, action: str, *, seed: Seed) -> ModelPredictor:
        """Return the predictor of an action.

        Parameters
        ----------
        action : str
            An action that the model was trained on.
        seed : int or numpy.random.Generator
            Source of the noise; each call of the predictor is another draw.

        Raises
        ------
        ValueError
            If the model was not trained on the action.
        """
        actions = self.configuration.actions
        if action not in actions:
            raise ValueError(f"action: this model was trained on {', '.join(actions)}, not on {action!r}")
        return ModelPredictor(self.model, self.normalization, actions.index(action), seed)


@renamed(rng="seed")
def predictor_of(path: Path, action: str, *, seed: Seed) -> ModelPredictor | FittedPredictor:
    """Return the predictor of a run: `load`, then `Run.predictor`.

    Parameters
    ----------
    path : Path
        The folder of the run.
    action : str
        An action that the model was trained on.
    seed : int or numpy.random.Generator
        Source of the noise; each call of the predictor is another draw.

    Returns
    -------
    ModelPredictor
        The predictor.

    Raises
    ------
    FileNotFoundError, ValueError
        As `load` and `Run.predictor`.
    """
    return load(path).predictor(action, seed=seed)


def save(folder: Path, model: MotionModel, normalization: Normalization, measured: dict[str, Any]) -> None:
    """Write the weights, the statistics that normalise poses and, in the header, the validation scores."""
    statistics = {"mean": normalization.mean, "std": normalization.std}
    weights.save(folder, _PART, model, statistics, measured)


def load(path: Path) -> Run | FittedRun:
    """Read a run, without running code.

    Parameters
    ----------
    path : Path
        The folder of the run. While the run trains, the model is the best so far.

    Returns
    -------
    Run or FittedRun
        A model, on the CPU, in evaluation mode; or a fitted predictor.

    Raises
    ------
    FileNotFoundError, ValueError
        If a file is missing, broken or does not match the other; names it.
    """
    file = config.file_in(path)
    if fitted.is_fitted(file):
        return fitted.load(path)
    configuration = config.read(file)
    with torch.random.fork_rng(devices=[]):  # initial weights are drawn, then replaced
        model = MODELS[configuration.name].build(configuration.model, len(configuration.actions))
    shapes = {"mean": (POSE,), "std": (POSE,)}
    stored = weights.load(path, _PART, model, shapes, configuration, "at its first validation")
    return Run(configuration, model.eval(), Normalization(**stored.statistics, columns=COLUMNS))
