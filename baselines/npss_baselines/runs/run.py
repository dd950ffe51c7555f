"""Runs that have been trained: their two files, and the predictors that they are."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import torch

from npss.extras import install_hint
from npss.files import write_bytes_atomically
from npss.protocol import COLUMNS, POSE, Normalization
from npss.validation import Array, Seed, check_finite, generator, positive_integer, renamed
from npss_baselines.models import MODELS
from npss_baselines.models.base import MotionModel
from npss_baselines.runs import config
from npss_baselines.runs.config import Configuration

try:
    from safetensors import SafetensorError
    from safetensors.torch import load_file
    from safetensors.torch import save as serialized
except ImportError:
    raise ImportError(f"trained models need safetensors; {install_hint('all', baselines=True)}") from None

#: The file of a run that holds the weights.
FILE = "model.safetensors"
_WEIGHT = "model."  # before the names of weights, which are beside the statistics


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


@dataclass(frozen=True)
class ModelPredictor:
    """A model as a `npss.predictors.Predictor`.

    Attributes
    ----------
    model : MotionModel
        On any device.
    normalization : Normalization
        By which it sees poses.
    action : int
        Which of its actions is predicted.
    seed : int or numpy.random.Generator
        Where noise comes from.
    """

    model: MotionModel
    normalization: Normalization
    action: int
    seed: Seed

    def __post_init__(self) -> None:
        object.__setattr__(self, "seed", generator(self.seed))

    @renamed(seed="seed_frames")
    def __call__(self, seed_frames: npt.ArrayLike, n_target: int) -> Array:
        """Predict.

        Parameters
        ----------
        seed_frames : (N, S, 99) array_like
            What the model sees: poses of Human3.6M at 25 frames per second, as exponential maps.
        n_target : int
            Frames to predict.

        Returns
        -------
        (N, n_target, 99) ndarray
            Poses; columns that the model does not see are at their mean. float32 for float32, float64 for all else.

        Raises
        ------
        TypeError, ValueError
            If the input is not as described, or a predicted value is NaN or infinite.
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


def save(path: Path, model: MotionModel, normalization: Normalization, measured: dict[str, Any]) -> None:
    """Write the weights, the statistics by which the model sees poses and, as metadata, what it is worth."""
    tensors = {f"{_WEIGHT}{name}": value.detach().cpu().contiguous() for name, value in model.state_dict().items()}
    tensors |= {"mean": torch.tensor(normalization.mean), "std": torch.tensor(normalization.std)}
    content = serialized(tensors, {"validation": json.dumps(measured)})  # one entry: several are in any order
    write_bytes_atomically(path / FILE, content)


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
    file = path / FILE
    if not file.exists():
        raise FileNotFoundError(f"{file} is not there (yet): a run writes it when it validates for the first time")
    try:
        tensors = load_file(file)
        mean, std = (tensors.pop(name).numpy() for name in ("mean", "std"))
        model.load_state_dict({name.removeprefix(_WEIGHT): value for name, value in tensors.items()})
        if not mean.shape == std.shape == (POSE,):
            raise ValueError(f"mean and std have shapes {mean.shape} and {std.shape}")
    except (KeyError, RuntimeError, SafetensorError, ValueError) as error:
        raise ValueError(f"{file}: not the weights of the model in {path / config.FILE} ({error})") from error
    return Run(configuration, model.eval(), Normalization(mean, std, COLUMNS))
