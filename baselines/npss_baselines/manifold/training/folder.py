"""Run folders of the manifold: a projector with all that it takes, written and read."""

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
from npss_baselines.runs.config import of_run

_PART = "network"  # of the file of weights


@dataclass(frozen=True, eq=False)
class Run:
    """A manifold, and how it has come about.

    Attributes
    ----------
    configuration : Configuration
        What it is, and what it was trained on.
    projector : Manifold
        On the CPU.
    measured : dict
        What was measured when it was kept: see `npss_baselines.manifold.training.trainer.train`.
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
    """Write the weights, the statistics by which the network sees features and, in the header, what it is worth."""
    statistics = {"mean": scaling.mean, "scale": scaling.scale}
    weights.save(folder, _PART, network, statistics, measured)


def load(path: Path) -> Run:
    """Read a run; nothing in its files can run code.

    Parameters
    ----------
    path : Path
        The folder of the run. It may still be in training: in its last phase, the model is the best one so far.

    Returns
    -------
    Run
        On the CPU, in evaluation mode.

    Raises
    ------
    FileNotFoundError, ValueError
        If a file is missing, is broken or does not fit the other: names it.
    """
    configuration = config.read(of_run(path))
    with torch.random.fork_rng(devices=[]):  # the weights are drawn, and then replaced
        network = Autoencoder(configuration.model)
    shapes = dict.fromkeys(("mean", "scale"), (configuration.model.n_features,))
    stored = weights.load(path, _PART, network, shapes, configuration, "in its last phase, after each epoch")
    signature = f"manifold-{stored.digest[:12]}"
    return Run(configuration, Manifold(network.eval(), Scaling(**stored.statistics), signature), stored.measured)
