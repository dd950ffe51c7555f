"""The files of motion that commands read: arrays and samples, never pickles."""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple, TypeVar

import numpy as np

from npss._checks import Array, Float64, check_finite, real_array
from npss._poses import POSE, poses_to_euler

Read = TypeVar("Read")

_SAMPLE = re.compile(r"expmap/(gt|preds)/(.+)_([0-9]+)")


class Pair(NamedTuple):
    """Ground truth and prediction to be compared."""

    name: str | None  # of the action or the array, where the file names it
    gt: Array
    pred: Array
    stored_curve: Float64 | None = None  # the Euler error of every frame, as the file states it


def read_pair(gt: Path, pred: Path) -> list[Pair]:
    """Read ground truth and prediction from two ``.npy`` or ``.npz`` files; arrays of a ``.npz`` pair by name."""
    truths, predictions = _read_arrays(gt), _read_arrays(pred)
    if len(truths) == len(predictions) == 1:
        (name, truth), (other, prediction) = *truths.items(), *predictions.items()
        return [Pair(name if name == other else None, truth, prediction)]
    if truths.keys() != predictions.keys():
        only = sorted(name or "the unnamed array" for name in truths.keys() ^ predictions.keys())
        raise ValueError(f"{pred}: its arrays pair by name with those of {gt}; without a partner: {', '.join(only)}")
    return [Pair(name, truths[name], predictions[name]) for name in truths]


def read_samples(path: Path) -> list[Pair]:
    """Read a file of samples, as `read_poses` does, as Human3.6M Euler angles."""
    return [pair._replace(gt=poses_to_euler(pair.gt), pred=poses_to_euler(pair.pred)) for pair in read_poses(path)]


def read_poses(path: Path) -> list[Pair]:
    """Read a file of samples: ground truth and predictions, one pair an action, as Human3.6M exponential maps.

    The layout, of ``.h5`` as of ``.npz``: ``expmap/gt/ACTION_i`` and ``expmap/preds/ACTION_i``, each (T, 99),
    exponential maps at 25 frames per second; optionally ``mean_ACTION_error`` (T,).
    """
    if path.suffix in (".h5", ".hdf5"):
        arrays = _read_h5(path)
    elif path.suffix == ".npz":
        arrays = {str(name): array for name, array in _read_arrays(path).items()}
    else:
        raise ValueError(f"{path}: one file alone is expected to be .h5 or .npz samples; else give GT and PRED")
    found: dict[str, dict[str, dict[int, Array]]] = defaultdict(lambda: {"gt": {}, "preds": {}})
    for name, array in arrays.items():
        if match := _SAMPLE.fullmatch(name):
            kind, action, index = match.groups()
            samples = found[action][kind]
            if int(index) in samples:
                raise ValueError(f"{path}: {name} is there twice, under indices written differently")
            samples[int(index)] = _sample(f"{path}: {name}", array)
    if not found:
        raise ValueError(f"{path}: no arrays expmap/gt/ACTION_i and expmap/preds/ACTION_i in it")
    pairs = []
    for action, kinds in sorted(found.items()):
        if alone := sorted(kinds["gt"].keys() ^ kinds["preds"].keys()):
            raise ValueError(f"{path}: {action}_{alone[0]} is not in both expmap/gt and expmap/preds")
        gt, pred = (_stack(path, action, kinds[kind]) for kind in ("gt", "preds"))
        curve = arrays.get(f"mean_{action}_error")
        if curve is not None:
            curve = real_array(f"{path}: mean_{action}_error", curve)
            check_finite(f"{path}: mean_{action}_error", curve)
            if curve.shape != gt.shape[1:2]:
                raise ValueError(f"{path}: mean_{action}_error has shape {curve.shape}, expected {gt.shape[1:2]}")
        pairs.append(Pair(action, gt, pred, curve))
    return pairs


def _sample(name: str, values: Any) -> Float64:
    """Read one sequence of poses."""
    sample = real_array(name, values)
    if sample.ndim != 2 or sample.shape[1] != POSE or len(sample) == 0:
        raise ValueError(f"{name}: expected shape (T, {POSE}), got {sample.shape}")
    check_finite(name, sample)
    return sample.astype(np.float64)


def _stack(path: Path, action: str, samples: Mapping[int, Array]) -> Float64:
    shapes = {sample.shape for sample in samples.values()}
    if len(shapes) > 1:
        raise ValueError(f"{path}: the samples of {action} differ in shape: {sorted(shapes)}")
    return np.stack([samples[index] for index in sorted(samples)])


def _read_arrays(path: Path) -> dict[str | None, Array]:
    """Read a ``.npy`` (memory-mapped, under the name None) or the arrays of a ``.npz``."""
    if path.suffix == ".npy":
        return {None: _or_say(path, lambda: np.load(path, mmap_mode="r", allow_pickle=False))}
    if path.suffix != ".npz":
        raise ValueError(f"{path}: expected a .npy or .npz file")

    def load() -> dict[str | None, Array]:
        with np.load(path, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}

    arrays: dict[str | None, Array] = _or_say(path, load)
    if not arrays:
        raise ValueError(f"{path}: no arrays in it")
    return arrays


def _read_h5(path: Path) -> dict[str, Array]:
    try:
        import h5py
    except ImportError:
        raise ValueError(f"{path}: reading .h5 needs h5py: pip install 'npss[h5]'") from None

    def load() -> dict[str, Array]:
        arrays: dict[str, Array] = {}

        def visit(name: str, item: Any) -> None:
            if isinstance(item, h5py.Dataset):
                arrays[name] = item[()]

        with h5py.File(path, "r") as file:
            file.visititems(visit)
        return arrays

    return _or_say(path, load)


def _or_say(path: Path, load: Callable[[], Read]) -> Read:
    """Load, or raise a ValueError that names the file."""
    try:
        return load()
    except OSError as error:
        # A missing file says so itself; other OSErrors are h5py's about broken ones.
        raise ValueError(f"{path}: {error.strerror or error}") from error
    except Exception as error:  # broken archives raise errors of many kinds
        raise ValueError(f"{path}: not a readable {path.suffix} file ({error})") from error
