"""Read results on any motion: conditions with ground truth and prediction, and what they are.

The layouts::

    MODEL.npz, MODEL.h5     CONDITION/gt and CONDITION/pred, or gt and pred alone; a JSON text meta
    MODEL/                  CONDITION_gt.npy and CONDITION_pred.npy, or gt.npy and pred.npy alone; meta.json

with or without CONDITION/samples, several predictions of each sequence; or, of Human3.6M::

    MODEL.npz, MODEL.h5     expmap/gt/ACTION_i and expmap/preds/ACTION_i: samples of Human3.6M
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from npss._metric.sequences import rows_by_length
from npss.files._arrays import MAX_SIZE, Arrays, naming_file, read_arrays
from npss.files._formats import listed, open_arrays, read_array, suffixes
from npss.files._meta import Meta
from npss.files._samples import Pair, read_poses
from npss.files._text import read_text
from npss.validation import Array, check_finite, flattened, motion_shape, motion_with_joints, real_array

#: The name of a condition whose arrays have none.
ALL = "all"
META = "meta"
_KINDS = ("gt", "pred", "samples")
_H36M = "expmap"


def is_folder_of_results(path: Path) -> bool:
    """Return whether a path is a folder of ground truths as ``.npy`` files."""
    return path.is_dir() and any(_condition(file.name.removesuffix(".npy"), "gt") for file in _visible(path, "*gt.npy"))


def read_results(path: Path, *, max_size: float = MAX_SIZE) -> list[Pair]:
    """Read the results of a model: a pair for each condition.

    Parameters
    ----------
    path : Path
        A file or a folder, as the module says.
    max_size : float, optional
        The most memory that the arrays of a file may take, in GiB.

    Returns
    -------
    list of Pair
        Pairs, named after their conditions. Sequences of unequal length become a condition for each length.

    Raises
    ------
    TypeError, ValueError
        If the path holds no results, or an array or ``meta`` is invalid; names the file and the array.
    """
    if path.is_dir():
        with naming_file(path):
            arrays, text = _of_folder(path)
            return _pairs(arrays, text)
    with naming_file(path):
        if path.suffix not in suffixes("samples"):
            raise ValueError(f"expected {listed('samples')} results, or a folder of .npy files")
        with open_arrays(path, "samples") as opened:
            names = _names(opened)
            if not any(name.split("/")[0] == _H36M for name in names):
                values = read_arrays(opened, [name for name in names if name != META], max_size)
                return _pairs(values, _text(opened.read(META)) if META in opened else None)
    return read_poses(path, max_size=max_size)


def _names(arrays: Arrays) -> list[str]:
    """Return the names of all arrays of an open file."""
    found: dict[str, None] = {}
    for name in arrays.names(""):
        inner = () if "/" in name else arrays.names(f"{name}/") if _is_folder(arrays, name) else ()
        found |= dict.fromkeys(inner or [name])
    return list(found)


def _is_folder(arrays: Arrays, name: str) -> bool:
    return any(f"{name}/{kind}" in arrays for kind in _KINDS)


def _visible(folder: Path, pattern: str) -> list[Path]:
    """Return the files of a folder that are not hidden, such as macOS's ``._gt.npy``."""
    return sorted(file for file in folder.glob(pattern) if not file.name.startswith("."))


def _of_folder(path: Path) -> tuple[dict[str, Array], str | None]:
    """Return the arrays of a folder, named as those of a file, and its meta."""
    arrays = {}
    for file in _visible(path, "*.npy"):
        name = file.name.removesuffix(".npy")
        condition, kind = next(((found, kind) for kind in _KINDS if (found := _condition(name, kind))), (None, ""))
        if condition is None:
            raise ValueError(f"{file.name}: expected CONDITION_gt.npy or CONDITION_pred.npy, or gt.npy and pred.npy")
        if f"{condition}/{kind}" in arrays:
            raise ValueError(f"{file.name}: the condition {ALL!r} has this array twice")
        with naming_file(Path(file.name)):
            arrays[f"{condition}/{kind}"] = np.asarray(read_array(file))
    if not arrays:
        raise ValueError("no .npy files in it")
    meta = path / f"{META}.json"
    return arrays, read_text(meta) if meta.exists() else None


def _condition(name: str, kind: str) -> str:
    """Return the condition of a file's name without its suffix, or nothing."""
    return ALL if name == kind else name.removesuffix(f"_{kind}") if name.endswith(f"_{kind}") else ""


def _text(array: Array) -> str:
    """Return the text of a single value, as numpy and HDF5 store it."""
    value = array.item() if isinstance(array, np.ndarray) and array.size == 1 else array
    if isinstance(value, bytes):
        value = value.decode("utf-8")
    if not isinstance(value, str):
        raise TypeError(f"{META}: expected a text, got {value!r:.100}")
    return value


def _pairs(arrays: Mapping[str, Array], text: str | None) -> list[Pair]:
    meta = Meta() if text is None else Meta.parse(text)
    conditions: dict[str, dict[str, Array]] = {}
    for name, array in arrays.items():
        condition, _, kind = name.rpartition("/")
        if kind not in _KINDS or "/" in condition:
            raise ValueError(
                f"{name}: expected CONDITION/gt, CONDITION/pred and {META}, or {_H36M}/gt/ACTION_i and "
                f"{_H36M}/preds/ACTION_i"
            )
        if not condition.isprintable() or " ".join(condition.split()) != condition:
            raise ValueError(f"{name!r}: expected the name of a condition in one line of printable text")
        found = conditions.setdefault(condition or ALL, {})
        if kind in found:
            raise ValueError(f"{name}: the condition {ALL!r} has this array twice")
        found[kind] = array
    if not conditions:
        raise ValueError("no arrays gt and pred in it")
    for field in ("lengths", "groups"):
        if unknown := [name for name in getattr(meta, field) if name not in conditions]:
            raise ValueError(f"meta: {field}: no condition {unknown[0]!r}; conditions: {', '.join(conditions)}")
    return [pair for name, found in conditions.items() for pair in _of_condition(name, found, meta)]


def _flat_samples(samples: Array, representation: str | None) -> Array:
    """Return samples ``(S, ...)``, each flattened joint by joint."""
    array = real_array("samples", samples)
    if array.ndim < 3 or not len(array):
        raise ValueError(f"samples: expected shape (S, N, T, ...), got {array.shape}")
    return array.reshape(len(array), *motion_shape("samples", array.shape[1:], representation))


def _of_condition(name: str, found: Mapping[str, Array], meta: Meta) -> list[Pair]:
    """Return the pair of a condition, or one for each length of its sequences."""
    if missing := [kind for kind in ("gt", "pred") if kind not in found]:
        raise ValueError(f"{name}: no array {missing[0]}")
    try:
        # What lies beyond a length need not be finite.
        gt, pred = (flattened(motion_with_joints(kind, found[kind], meta.representation)) for kind in ("gt", "pred"))
        samples = None if "samples" not in found else _flat_samples(found["samples"], meta.representation)
    except (TypeError, ValueError) as error:
        raise type(error)(f"{name}: {error}") from error
    if gt.shape != pred.shape:
        raise ValueError(f"{name}: pred: its shape {pred.shape} differs from that of gt, {gt.shape}")
    if samples is not None and samples.shape[1:] != gt.shape:
        raise ValueError(f"{name}: samples: expected shape (S, *{gt.shape}), got {samples.shape}")
    if gt.ndim == 2:
        gt, pred = gt[np.newaxis], pred[np.newaxis]
        samples = None if samples is None else samples[:, np.newaxis]
    groups, lengths = meta.groups.get(name), meta.lengths.get(name)
    for field, values in (("groups", groups), ("lengths", lengths)):
        if values is not None and len(values) != len(gt):
            raise ValueError(f"meta: {field}: {name}: expected one for each of {len(gt)} sequences, got {len(values)}")
    if lengths is None:
        lengths = (gt.shape[1],) * len(gt)
    if (longest := max(lengths)) > gt.shape[1]:
        raise ValueError(f"meta: lengths: {name}: {longest} frames, but the arrays have {gt.shape[1]}")
    pairs = []
    of_lengths = rows_by_length(lengths)
    for rows in of_lengths:
        chosen, length = list(rows), lengths[rows[0]]
        cut_gt, cut_pred = gt[chosen, :length], pred[chosen, :length]
        label = name if len(of_lengths) == 1 else f"{name}, {length} frames"
        check_finite(f"{label}: gt", cut_gt)
        check_finite(f"{label}: pred", cut_pred)
        drawn = None if samples is None else samples[:, chosen, :length]
        if drawn is not None:
            check_finite(f"{label}: samples", drawn)
        of_pair = None if groups is None else tuple(groups[i] for i in chosen)
        pairs.append(Pair(label, cut_gt, cut_pred, meta=meta, groups=of_pair, samples=drawn))
    return pairs
