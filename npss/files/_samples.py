"""Read files of motion: arrays and samples, never pickles."""

from __future__ import annotations

import argparse
import re
from collections import defaultdict
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np

from npss.files._arrays import MAX_SIZE, Arrays, Header, naming_file, read_arrays
from npss.files._formats import listed, open_arrays, read_array, suffixes
from npss.files._meta import Meta
from npss.rotations._poses import POSE, poses_to_euler
from npss.validation import Array, Float64, check_finite, check_real, is_real_dtype, positive_number, real_array

_SAMPLE = re.compile(r"expmap/(gt|preds)/([^/]+)_([0-9]+)")


class Pair(NamedTuple):
    """A ground truth and its prediction.

    Attributes
    ----------
    name : str or None
        The name of the action or array, if the file has one.
    gt, pred : (N, T, D) or (T, D) ndarray
        The two motions.
    stored_curve : (T,) ndarray of float64 or None
        The Euler error of each frame, as stored in the file.
    meta : Meta or None
        What the motions are; None for poses of Human3.6M or arrays that say nothing of themselves.
    groups : tuple or None
        The block of each sequence, if the file states it.
    samples : (S, N, T, D) ndarray or None
        Several predictions of each sequence, if the file has them.
    """

    name: str | None
    gt: Array
    pred: Array
    stored_curve: Float64 | None = None
    meta: Meta | None = None
    groups: tuple[str | int | None, ...] | None = None
    samples: Array | None = None


def read_pair(gt: Path, pred: Path, *, key: str | None = None, max_size: float = MAX_SIZE) -> list[Pair]:
    """Read ground truth and prediction from two files, with one array each or with arrays that pair by name.

    Parameters
    ----------
    gt, pred : Path
        The files.
    key : str, optional
        The name of the only array to read. By default all are read, except single values, text and Python objects.
    max_size : float, optional
        As for `read_poses`; an array without a name, which is mapped into memory, may be larger.
    """
    if key is not None and not {gt.suffix, pred.suffix} & set(suffixes("arrays")):
        raise ValueError(f"--key chooses an array of a {listed('arrays')} file, but neither {gt} nor {pred} is one")
    truths, predictions = (_read_motions(path, key, max_size) for path in (gt, pred))
    if len(truths) == len(predictions) == 1:
        (name, truth), (other, prediction) = *truths.items(), *predictions.items()
        return [Pair(name or None if name == other else None, truth, prediction)]
    if truths.keys() != predictions.keys():
        only = sorted(name or "the unnamed array" for name in truths.keys() ^ predictions.keys())
        raise ValueError(
            f"{pred}: its arrays pair by name with those of {gt}, but these are unpaired: {', '.join(only)}; "
            f"choose one by --key NAME"
        )
    return [Pair(name, truths[name], predictions[name]) for name in truths]


def converted(pair: Pair) -> Pair:
    """Convert the exponential maps of a pair to Euler angles, unless it has a meta; errors name the array."""
    try:
        gt, pred = features_of(pair)
    except (TypeError, ValueError) as error:
        if pair.name is None:
            raise
        raise ValueError(f"{pair.name}: {error}") from error
    return pair._replace(gt=gt, pred=pred)


def features_of(pair: Pair) -> tuple[Float64, Float64]:
    """Return both motions as Euler angles, or as they are if the pair has a meta; errors name the motion."""
    if pair.meta is not None:
        return pair.gt.astype(np.float64), pair.pred.astype(np.float64)
    angles = []
    for name, poses in (("ground truth", pair.gt), ("prediction", pair.pred)):
        try:
            angles.append(poses_to_euler(poses))
        except (TypeError, ValueError) as error:
            raise ValueError(f"{name}: {error}") from error
    gt, pred = angles
    return gt, pred


def read_poses(path: Path, *, max_size: float = MAX_SIZE) -> list[Pair]:
    """Read a file of samples: a pair of ground truth and predictions per action, as Human3.6M exponential maps.

    The layout in every format is ``expmap/gt/ACTION_i`` and ``expmap/preds/ACTION_i``, each (T, 99), exponential maps
    at 25 frames per second; optionally ``mean_ACTION_error`` (T,). Everything else is ignored.

    Parameters
    ----------
    path : Path
        The file.
    max_size : float, optional
        The most memory that its arrays may take, in GiB, at 8 bytes per number.
    """
    with naming_file(path):
        if path.suffix not in suffixes("samples"):
            raise ValueError(f"expected {listed('samples')} samples; otherwise give GT and PRED")
        with open_arrays(path, "samples") as arrays:
            actions = _actions(arrays)
            curves = {action: name for action in actions if (name := f"mean_{action}_error") in arrays}
            for action, name in curves.items():
                header, n_frames = arrays.header(name), arrays.header(actions[action]["gt"][0]).shape[0]
                check_real(name, header.dtype)
                if header.shape != (n_frames,):
                    raise ValueError(f"{name} has shape {header.shape}, expected {(n_frames,)}")
            names = [name for kinds in actions.values() for several in kinds.values() for name in several]
            values = read_arrays(arrays, [*names, *curves.values()], max_size)
        finite = {name: _float64(name, array) for name, array in values.items()}
    pairs = []
    for action, kinds in actions.items():
        gt, pred = (np.stack([finite[name] for name in kinds[kind]]) for kind in ("gt", "preds"))
        pairs.append(Pair(action, gt, pred, finite.get(f"mean_{action}_error")))
    return pairs


def add_max_size(parser: argparse._ActionsContainer) -> None:
    """Add the option ``--max-size``."""
    parser.add_argument(
        "--max-size",
        type=_gibibytes,
        default=MAX_SIZE,
        metavar="GIB",
        help=f"limit the arrays of one file to this much memory, in GiB (default: {MAX_SIZE:g})",
    )


def _gibibytes(text: str) -> float:
    try:
        return positive_number("size", float(text))
    except ValueError:
        raise argparse.ArgumentTypeError(f"invalid: expected a positive, finite number of GiB, got {text!r}") from None


def _actions(arrays: Arrays) -> dict[str, dict[str, list[str]]]:
    """Check all headers, and return the names of samples by action and kind, in the order of their indices."""
    by_action: dict[str, dict[str, dict[int, str]]] = defaultdict(lambda: {"gt": {}, "preds": {}})
    for name in [*arrays.names("expmap/gt/"), *arrays.names("expmap/preds/")]:
        if match := _SAMPLE.fullmatch(name):
            kind, action, index = match.groups()
            samples = by_action[action][kind]
            if int(index) in samples:
                raise ValueError(f"duplicate sample {name}, with an index written differently")
            samples[int(index)] = name
    if not by_action:
        raise ValueError("no arrays expmap/gt/ACTION_i and expmap/preds/ACTION_i in it")
    for action, kinds in by_action.items():
        if unpaired := sorted(kinds["gt"].keys() ^ kinds["preds"].keys()):
            raise ValueError(f"{action}_{unpaired[0]} is not in both expmap/gt and expmap/preds")
        for samples in kinds.values():
            shapes = {_sample_shape(name, arrays.header(name)) for name in samples.values()}
            if len(shapes) > 1:
                raise ValueError(f"the samples of {action} differ in shape: {sorted(shapes)}")
    return {
        action: {kind: [samples[index] for index in sorted(samples)] for kind, samples in kinds.items()}
        for action, kinds in sorted(by_action.items())
    }


def _sample_shape(name: str, header: Header) -> tuple[int, ...]:
    """Check that an array is a sequence of poses, and return its shape."""
    check_real(name, header.dtype)
    if len(header.shape) != 2 or header.shape[1] != POSE or header.shape[0] == 0:
        raise ValueError(f"{name}: expected shape (T, {POSE}), got {header.shape}")
    return header.shape


def _float64(name: str, values: Array) -> Float64:
    array = real_array(name, values)
    check_finite(name, array)
    return array.astype(np.float64)


def _read_motions(path: Path, key: str | None, max_size: float) -> dict[str, Array]:
    """Read the only, unnamed array of a file, or its named arrays that may be motion."""
    with naming_file(path):
        if path.suffix in suffixes("array"):
            return {"": read_array(path)}
        if path.suffix not in suffixes("arrays"):
            raise ValueError(f"expected a {listed('array', 'arrays')} file")
        with open_arrays(path, "arrays") as arrays:
            headers = {name: arrays.header(name) for name in arrays.names("")}
            return read_arrays(arrays, _motions(headers, key), max_size)


def _motions(headers: Mapping[str, Header], key: str | None) -> list[str]:
    """Return the names of the arrays to score: the chosen one, or all except values that accompany motion."""
    arrays = ", ".join(f"{name} {header.shape} of {header.dtype}" for name, header in headers.items()) or "none"
    if key is not None and key not in headers:
        raise ValueError(f"no array {key!r} in it; arrays: {arrays}")
    others = [name for name, header in headers.items() if not header.shape or header.dtype.kind in "OSUT"]
    names = [name for name in headers if name not in others] if key is None else [key]
    if not names:
        raise ValueError(f"no motion in it, an array (N, T, D) or (T, D) of numbers; arrays: {arrays}")
    motions = [name for name in names if 2 <= len(headers[name].shape) <= 5 and is_real_dtype(headers[name].dtype)]
    if len(names) > 1 and len(motions) < len(names):
        raise ValueError(f"not all arrays are motion (N, T, D) or (T, D); choose one by --key NAME: {arrays}")
    for name in names:
        check_real(name, headers[name].dtype)
    return names
