"""Run folders: a model with all that it takes to predict, written and read."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from npss.protocol import COLUMNS, POSE, Normalization
from npss.validation import Seed, renamed
from npss_baselines.models import MODELS
from npss_baselines.models.base import MotionModel
from npss_baselines.runs import config, weights
from npss_baselines.runs.config import Configuration
from npss_baselines.runs.predictor import ModelPredictor

_PART = "model"  # of the file of weights


@dataclass(frozen=True)
class Run:
    """A model with all that it takes to predict.

    Attributes
    ----------
    configuration : Configuration
        What it is, and what it was trained on.
    model : MotionModel
        The model.
    normalization : Normalization
        By which it sees poses.
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
            One that the model was trained on.
        seed : int or numpy.random.Generator
            Where noise comes from: each call of the predictor is another draw.

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
def predictor_of(path: Path, action: str, *, seed: Seed) -> ModelPredictor:
    """Return the predictor that a run is: `load`, then `Run.predictor`.

    Parameters
    ----------
    path : Path
        The folder of the run.
    action : str
        One that the model was trained on.
    seed : int or numpy.random.Generator
        Where noise comes from: each call of the predictor is another draw.
    """
    return load(path).predictor(action, seed=seed)


def save(folder: Path, model: MotionModel, normalization: Normalization, measured: dict[str, Any]) -> None:
    """Write the weights, the statistics by which the model sees poses and, in the header, what it is worth."""
    statistics = {"mean": normalization.mean, "std": normalization.std}
    weights.save(folder, _PART, model, statistics, measured)


def load(path: Path) -> Run:
    """Read a run; nothing in its files can run code.

    Parameters
    ----------
    path : Path
        The folder of the run. It may still be in training: then the model is the best one so far.

    Returns
    -------
    Run
        On the CPU, in evaluation mode.

    Raises
    ------
    FileNotFoundError, ValueError
        If a file is missing, is broken or does not fit the other: names it.
    """
    configuration = config.read(config.of_run(path))
    with torch.random.fork_rng(devices=[]):  # the weights are drawn, and then replaced
        model = MODELS[configuration.name].build(configuration.model, len(configuration.actions))
    shapes = {"mean": (POSE,), "std": (POSE,)}
    stored = weights.load(path, _PART, model, shapes, configuration, "when it validates for the first time")
    return Run(configuration, model.eval(), Normalization(**stored.statistics, columns=COLUMNS))
