"""The weights of a run: a safetensors file, with the statistics of the data, and what was measured in its header."""

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

#: The file of a run that holds the weights.
FILE = "model.safetensors"
_MEASURED = "validation"  # in the header: a single entry, because several are in any order


class Stored(NamedTuple):
    """What is stored beside the weights.

    Attributes
    ----------
    statistics : dict of str to ndarray
        Of the data, by name.
    measured : dict
        What was measured when the weights were kept.
    digest : str
        Of the configuration and of all tensors, to the bit.
    """

    statistics: dict[str, Array]
    measured: dict[str, Any]
    digest: str


def save(
    folder: Path, part: str, model: nn.Module, statistics: Mapping[str, Array], measured: Mapping[str, Any]
) -> None:
    """Write weights: all of the file, or nothing.

    Parameters
    ----------
    folder : Path
        Of the run.
    part : str
        What the model is called in the file: names of weights begin with it and a dot.
    model : Module
        On any device.
    statistics : mapping of str to ndarray
        Of the data, by which the model sees them.
    measured : mapping
        What the model is worth; JSON can hold it.
    """
    tensors = {f"{part}.{name}": value.detach().cpu().contiguous() for name, value in model.state_dict().items()}
    tensors |= {name: torch.tensor(value) for name, value in statistics.items()}
    write_bytes_atomically(folder / FILE, serialized(tensors, {_MEASURED: json.dumps(measured)}))


def load(
    folder: Path, part: str, model: nn.Module, shapes: Mapping[str, tuple[int, ...]], configuration: Any, when: str
) -> Stored:
    """Read weights into a model; nothing in the file can run code.

    Parameters
    ----------
    folder : Path
        Of the run.
    part : str
        As for `save`.
    model : Module
        What gets the weights.
    shapes : mapping of str to tuple of int
        The statistics that there are, and their shapes.
    configuration : dataclass
        Of the run, for the digest.
    when : str
        When a run writes the file, for the error if there is none.

    Raises
    ------
    FileNotFoundError, ValueError
        If the file is missing, is broken or does not fit the model: names it.
    """
    file = folder / FILE
    if not file.exists():
        raise FileNotFoundError(f"{file} is not there (yet): a run writes it {when}")
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
