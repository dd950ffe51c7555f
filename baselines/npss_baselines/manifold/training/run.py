"""Runs of the manifold that have been trained: their two files, and the projectors that they are."""

from __future__ import annotations

import hashlib
import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import torch
from safetensors import SafetensorError, safe_open
from safetensors.torch import load_file
from safetensors.torch import save as serialized
from torch import Tensor

from npss.files import write_bytes_atomically
from npss_baselines.manifold.model.autoencoder import Autoencoder
from npss_baselines.manifold.model.projector import Manifold
from npss_baselines.manifold.motion.normalization import Normalization
from npss_baselines.manifold.training import config
from npss_baselines.manifold.training.config import Configuration
from npss_baselines.runs.config import of_run
from npss_baselines.runs.run import FILE

__all__ = ["FILE", "Run", "load", "save"]

_WEIGHT = "network."  # before the names of weights, which are beside the statistics


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
        What was measured when it was kept: see `npss_baselines.manifold.training.loop.train`.
    """

    configuration: Configuration
    projector: Manifold
    measured: dict[str, Any]


def save(
    path: Path,
    configuration: Configuration,
    network: Autoencoder,
    normalization: Normalization,
    measured: dict[str, Any],
) -> None:
    """Write the weights, the statistics by which the network sees features and, as metadata, what it is worth."""
    tensors = {f"{_WEIGHT}{name}": value.detach().cpu().contiguous() for name, value in network.state_dict().items()}
    tensors |= {name: torch.tensor(getattr(normalization, name)) for name in ("mean", "scale")}
    content = serialized(tensors, {"validation": json.dumps(measured)})  # one entry: several are in any order
    write_bytes_atomically(path / FILE, content)


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
    file = path / FILE
    if not file.exists():
        raise FileNotFoundError(f"{file} is not there (yet): a run writes it in its last phase, after each epoch")
    try:
        tensors = load_file(file)
        with safe_open(file, "pt") as opened:
            measured = json.loads(opened.metadata()["validation"])
        signature = _signature(configuration, tensors)
        mean, scale = (tensors.pop(name).numpy() for name in ("mean", "scale"))
        network.load_state_dict({name.removeprefix(_WEIGHT): value for name, value in tensors.items()})
        if not mean.shape == scale.shape == (configuration.model.n_features,):
            raise ValueError(f"mean and scale have shapes {mean.shape} and {scale.shape}")
    except (AttributeError, KeyError, RuntimeError, SafetensorError, TypeError, ValueError) as error:
        raise ValueError(f"{file}: not the weights of the model in {path / config.FILE} ({error})") from error
    return Run(configuration, Manifold(network.eval(), Normalization(mean, scale), signature), measured)


def _signature(configuration: Configuration, tensors: dict[str, Tensor]) -> str:
    """Return a digest of the weights, and of what they were trained on and how."""
    digest = hashlib.sha256(json.dumps(asdict(configuration)).encode())
    for name in sorted(tensors):
        digest.update(name.encode() + tensors[name].numpy().tobytes())
    return f"manifold-{digest.hexdigest()[:12]}"
