"""Run folders of the manifold: save and load."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import torch

from npss_baselines.manifold.model.autoencoder import Autoencoder
from npss_baselines.manifold.model.projector import Manifold
from npss_baselines.manifold.motion.scaling import Scaling
from npss_baselines.manifold.training import config
from npss_baselines.manifold.training.config import Configuration
from npss_baselines.runs import weights
from npss_baselines.runs.config import file_in

__all__ = ["Run", "load"]

_PART = "network"  # name of the network in the weights file


@dataclass(frozen=True, eq=False)
class Run:
    """A trained manifold, with its configuration and results.

    Attributes
    ----------
    configuration : Configuration
        Network, training and data.
    projector : Manifold
        The manifold, on the CPU.
    measured : dict
        Results of the kept weights: see `npss_baselines.manifold.training.trainer.train`.
    """

    configuration: Configuration
    projector: Manifold
    measured: dict[str, Any]


def save(
    folder: Path,
    network: Autoencoder,
    scaling: Scaling,
    measured: dict[str, Any],
) -> None:
    """Write the weights, the scaling of features and, in the header, the results."""
    statistics = {"mean": scaling.mean, "scale": scaling.scale}
    weights.save(folder, _PART, network, statistics, measured)


def load(path: Path) -> Run:
    """Load a run; its files cannot run code.

    Parameters
    ----------
    path : Path
        The folder of the run. In the last phase of training, it holds the best weights so far.

    Returns
    -------
    Run
        The run, on the CPU and in evaluation mode.

    Raises
    ------
    FileNotFoundError, ValueError
        If a file is missing, broken or does not match the other. The message names it.
    """
    configuration = config.read(file_in(path))
    with torch.random.fork_rng(devices=[]):  # the random weights are replaced below
        network = Autoencoder(configuration.model)
    shapes = dict.fromkeys(("mean", "scale"), (configuration.model.n_features,))
    stored = weights.load(path, _PART, network, shapes, configuration, "in its last phase, after each epoch")
    signature = f"manifold-{stored.digest[:12]}"
    return Run(configuration, Manifold(network.eval(), Scaling(**stored.statistics), signature), stored.measured)
