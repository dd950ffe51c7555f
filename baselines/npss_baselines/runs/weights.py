"""The weights of a run: a safetensors file with the statistics of the data, and validation scores in its header."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch
from torch import Tensor, nn

from npss.extras import install_hint
from npss.files import parse_json, write_bytes_atomically
from npss.validation import Array
from npss_baselines.runs import config

try:
    from safetensors import SafetensorError, safe_open
    from safetensors.torch import load_file
    from safetensors.torch import save as serialized
except ImportError:
    raise ImportError(f"trained models need safetensors; {install_hint('all', baselines=True)}") from None

#: The file of the weights.
FILE = "model.safetensors"
_MEASURED = "validation"  # the only entry of the header: the order of several would be arbitrary


class Stored(NamedTuple):
    """Statistics, scores and digest of a file of weights.

    Attributes
    ----------
    statistics : dict of str to ndarray
        Statistics of the data, by name.
    measured : dict
        The validation scores of the weights.
    digest : str
        Digest of the configuration and of every bit of the tensors.
    """

    statistics: dict[str, Array]
    measured: dict[str, Any]
    digest: str


def save(
    folder: Path, part: str, model: nn.Module, statistics: Mapping[str, Array], measured: Mapping[str, Any]
) -> None:
    """Write weights atomically.

    Parameters
    ----------
    folder : Path
        The folder of the run.
    part : str
        Name of the model in the file; the names of weights start with it and a dot.
    model : Module
        The model, on any device.
    statistics : mapping of str to ndarray
        Statistics of the data, for its normalisation.
    measured : mapping
        The model's validation scores, as JSON can hold them.
    """
    tensors = {f"{part}.{name}": value.detach().cpu().contiguous() for name, value in model.state_dict().items()}
    tensors |= {name: torch.tensor(value) for name, value in statistics.items()}
    write_bytes_atomically(folder / FILE, serialized(tensors, {_MEASURED: json.dumps(measured)}))


def load(
    folder: Path, part: str, model: nn.Module, shapes: Mapping[str, tuple[int, ...]], configuration: Any, when: str
) -> Stored:
    """Read weights into a model, without running code.

    Parameters
    ----------
    folder : Path
        The folder of the run.
    part : str
        As for `save`.
    model : Module
        The model that gets the weights.
    shapes : mapping of str to tuple of int
        The shapes of the statistics, by name.
    configuration : dataclass
        The configuration of the run, for the digest.
    when : str
        When a run writes the file, for the error if it is missing.

    Raises
    ------
    FileNotFoundError, ValueError
        If the file is missing, broken or does not match the model; names it.
    """
    file = folder / FILE
    if not file.exists():
        raise FileNotFoundError(f"{file}: no such file; a run writes it {when}")
    try:
        tensors = load_file(file)
        with safe_open(file, "pt") as opened:
            measured = parse_json(opened.metadata()[_MEASURED])
        digest = _digest(configuration, tensors)
        statistics = {name: tensors.pop(name).numpy() for name in shapes}
        model.load_state_dict({name.removeprefix(f"{part}."): value for name, value in tensors.items()})
        for name, shape in shapes.items():
            if statistics[name].shape != shape:
                raise ValueError(f"{name}: expected shape {shape}, got {statistics[name].shape}")
    except (AttributeError, KeyError, RuntimeError, SafetensorError, TypeError, ValueError) as error:
        raise ValueError(f"{file}: not the weights of the model in {folder / config.FILE} ({error})") from error
    return Stored(statistics, measured, digest)


def _digest(configuration: Any, tensors: Mapping[str, Tensor]) -> str:
    digest = hashlib.sha256(json.dumps(asdict(configuration)).encode())
    for name in sorted(tensors):
        digest.update(name.encode() + np.ascontiguousarray(tensors[name].numpy()).tobytes())
    return digest.hexdigest()
