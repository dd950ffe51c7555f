"""Submissions: files with predictions of several models on one ground truth, for leaderboards and reports."""

from __future__ import annotations

import errno
import os
import warnings
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from npss._analysis.blocks import Groups
from npss._metric.frames import whole_times
from npss._metric.registry import metric_called
from npss.console._progress import Progress
from npss.files._arrays import MAX_SIZE
from npss.files._formats import FORMATS, listed, suffixes
from npss.files._json import read_json
from npss.files._meta import Meta
from npss.files._results import is_folder_of_results, read_results
from npss.files._samples import Pair, features_of
from npss.protocol import (
    ACTIONS,
    FPS,
    SLICES_MS,
    TEST_LENGTHS,
    VERIFIED,
    Verification,
    lafan1,
    verify,
    window_blocks,
)
from npss.protocol._h36m import BLOCKED
from npss.ranking._names import names_of_paths
from npss.records import Record, measure
from npss.validation import Array

_SAME_POSE = 1e-3  # radians, or millimetres: files hold ground truth in various precisions

#: The name of the ground truth on pages and in pictures, beside the names of models.
TRUTH = "ground truth"

#: Fields that `records_of` itself adds to signatures.
MEASURED = ("representation", "frames", "fps", "unwrap", "columns", "average")

#: Pairs by model and action, or condition. Without a meta, they are Human3.6M poses, exponential maps at 25 frames per
#: second.
Submissions = Mapping[str, Mapping[str, Pair]]


def read_submissions(paths: Iterable[Path], *, max_size: float = MAX_SIZE) -> dict[str, dict[str, Pair]]:
    """Read the results of each model; a folder stands for all that it holds, unless it holds those of one model.

    A model is named after its file ``MODEL.h5``, or its folder in ``MODEL/samples.h5``, with as many folders before it
    as make the name unique. The arrays of one file may take `max_size` GiB of memory.

    Raises
    ------
    ValueError
        If there are no files, a file is a duplicate, a prediction and its ground truth differ in shape, or the ground
        truths of two models differ; names the file or the models.
    """
    files = names_of_paths(sample_files(paths))
    submissions = {model: read_actions(file, max_size=max_size) for model, file in files.items()}
    if TRUTH in submissions:
        raise ValueError(f"a model must not be called {TRUTH!r}")
    check_truths(submissions)
    return submissions


def sample_files(paths: Iterable[Path]) -> list[Path]:
    """Return the results of models at these paths.

    Parameters
    ----------
    paths : iterable of Path
        Files or folders of results, or folders with them; hidden files do not count.

    Returns
    -------
    list of Path
        ``MODEL.h5`` or ``MODEL/samples.h5``, in any registered format, or a folder MODEL of .npy files.

    Raises
    ------
    ValueError
        If a path does not exist or is not a file of samples, or a folder has none.
    """
    files, endings = [], suffixes("samples")
    for path in paths:
        if not path.exists():
            raise ValueError(f"{path}: {os.strerror(errno.ENOENT)}")
        if not path.is_dir() and path.suffix not in endings:
            raise ValueError(f"{path}: expected {listed('samples')} samples")
        samples = [path]
        if path.is_dir() and not is_folder_of_results(path):
            visible = [file for file in (*path.iterdir(), *path.glob("*/samples.*")) if not _hidden(file, path)]
            found = (file for file in visible if file.is_file() and file.suffix in endings)
            samples = sorted((*found, *filter(is_folder_of_results, visible)))
        if not samples:
            raise ValueError(f"{path}: no results in it ({listed('samples')}, or folders of .npy files)")
        files += samples
    return files


def _hidden(file: Path, folder: Path) -> bool:
    """Return whether a file is hidden, as ``.ipynb_checkpoints/samples.h5`` or macOS's ``._model.h5``."""
    return any(part.startswith(".") for part in file.relative_to(folder).parts)


def read_actions(file: Path, *, max_size: float = MAX_SIZE) -> dict[str, Pair]:
    """Read the results of a model, and check that predictions and ground truths have the same shape.

    Parameters
    ----------
    file : Path
        The file, ``.h5``, ``.hdf5`` or ``.npz``, or a folder of ``.npy`` files.
    max_size : float, optional
        The most memory that its arrays may take, in GiB.

    Returns
    -------
    dict of str to Pair
        Pairs by action.

    Raises
    ------
    ValueError
        If it is not such a file, or a prediction has another shape than its ground truth; names the file.
    """
    pairs = {str(pair.name): pair for pair in read_results(file, max_size=max_size)}
    for action, pair in pairs.items():
        if pair.gt.shape != pair.pred.shape:
            raise ValueError(
                f"{file}: {action}: the predictions have {pair.pred.shape[1]} frames, the ground truth "
                f"{pair.gt.shape[1]}; expected equal lengths"
            )
    return pairs


@contextmanager
def naming(model: str, action: str) -> Iterator[None]:
    """Name the model and the action in errors about its motion."""
    try:
        yield
    except (TypeError, ValueError) as error:
        raise ValueError(f"{model!r} on {action!r}: {error}") from error


def check_truths(submissions: Submissions) -> None:
    """Check that all models predict the same motion.

    Parameters
    ----------
    submissions : mapping of str to mapping of str to Pair
        Pairs by model and action.

    Raises
    ------
    ValueError
        If the ground truths of an action differ; names two models.
    """
    first: dict[str, tuple[str, Pair]] = {}
    for model, actions in submissions.items():
        for action, pair in actions.items():
            other, expected = first.setdefault(action, (model, pair))
            if expected.gt.shape != pair.gt.shape:
                difference = f"shapes {expected.gt.shape} and {pair.gt.shape}"
            elif differing := _differing(expected.meta, pair.meta):
                difference = f"{differing} of their meta"
            elif (distance := np.abs(expected.gt - pair.gt).max(axis=(1, 2))).max() > _tolerance(expected):
                difference = f"by up to {distance.max():.3g}, in sequence {int(distance.argmax())}"
            else:
                continue
            raise ValueError(
                f"{action}: the ground truths of {other!r} and {model!r} differ ({difference}), so they cannot be "
                "compared"
            )


def _tolerance(pair: Pair) -> float:
    """Return the largest difference of equal ground truths; of small motion in any unit, a part of its size."""
    return _SAME_POSE if pair.meta is None else _SAME_POSE * min(1.0, float(np.abs(pair.gt).max()))


def _differing(one: Meta | None, other: Meta | None) -> str:
    """Return the name of a field that two models state differently, or nothing."""
    if one is None or other is None:
        return "" if one is other else "presence"
    return next((name for name in ("representation", "fps") if getattr(one, name) != getattr(other, name)), "")


def records_of(
    submissions: Submissions,
    *,
    metrics: Sequence[str] = (),
    edges_ms: Sequence[float] = (),
    groups: Mapping[str, Groups] | None = None,
    **context: Any,
) -> list[Record]:
    """Measure every prediction and its single sequences: a record for each model and action.

    Parameters
    ----------
    submissions : mapping of str to mapping of str to Pair
        Pairs by model and action: ``(N, T, 99)`` exponential maps at 25 frames per second, or what their meta says.
    metrics : sequence of str, optional
        Names of other metrics to measure by.
    edges_ms : sequence of float, optional
        Edges of windows of time, in milliseconds, to score, too.
    groups : mapping of str to sequence, optional
        The blocks of the sequences, by action; by default those of the file, or else they follow from ``protocol`` and
        the lengths of the clips, if both are known.
    **context
        Known fields for the signatures, such as ``protocol='srnn-8'``.

    Returns
    -------
    list of dict
        Records as `npss.records.measure` returns them, with ``model`` and ``action``.

    Raises
    ------
    ValueError
        If a metric is unknown, the number of sequences is not the number of windows of the protocol, or a file states
        another protocol.
    """
    for name in metrics:
        metric_called(name, "metrics")
    records = []
    pairs = [(model, action, pair) for model, actions in submissions.items() for action, pair in actions.items()]
    with Progress("scoring") as progress:
        for done, (model, action, pair) in enumerate(pairs, 1):
            with naming(model, action):
                measured = _measure(pair, action, groups, context, metrics=metrics, edges_ms=edges_ms)
            records.append({"model": model, "action": action, **measured})
            progress(done / len(pairs))
    return records


def _measure(
    pair: Pair, action: str, groups: Mapping[str, Groups] | None, context: Mapping[str, Any], **options: Any
) -> Record:
    """Measure a pair and its single sequences."""
    n_frames = pair.gt.shape[1]
    fps, stated = described(pair, context)
    is_euler = stated.get("representation") == "euler"
    metrics = options.get("metrics", ())
    gt, pred = features_of(pair)
    poses = pair if pair.meta is None else None
    verification = verified(pair, poses, stated.get("protocol"), fps)
    return measure(
        gt,
        pred,
        fps=fps,
        at_ms=times_of(is_euler=is_euler, metrics=metrics, fps=fps, n_frames=n_frames),
        angles=is_euler,
        poses=(pair.gt, pair.pred) if pair.meta is None else None,
        positions=positions_for(pair, metrics),
        sequences=True,
        groups=blocks_of(pair, action, groups, stated),
        frames=n_frames,
        **options,
        **stated,
        **({} if verification is None else verification.stated),
    )


def times_of(*, is_euler: bool, metrics: Sequence[str], fps: float | None, n_frames: int) -> list[int]:
    """Return the times of published tables that are frames, if the Euler error or one of the metrics needs times."""
    if fps is None or not (is_euler or any(metric_called(name, "metrics").has_times for name in metrics)):
        return []
    return whole_times(SLICES_MS, fps, n_frames)


def blocks_of(pair: Pair, action: str, groups: Mapping[str, Groups] | None, stated: Mapping[str, Any]) -> Groups:
    """Return the blocks of the sequences of a pair: as given, as its file states them, or as its protocol has them."""
    own = groups[action] if groups else pair.groups
    blocks = known_blocks(stated.get("protocol"), action, pair.gt.shape) if own is None else own
    if blocks is None and (overlap := overlapping(pair.gt)):
        i, j, shift = overlap
        warnings.warn(
            f"{action}: sequences {i} and {j} overlap, {shift} frames apart. They are not independent, "
            "so p-values and intervals are too small: give groups (--groups), or a protocol whose blocks are known "
            "(--protocol)",
            stacklevel=2,
        )
    return blocks


def overlapping(gt: Array) -> tuple[int, int, int] | None:
    """Find two sequences of a ground truth that overlap in time.

    Parameters
    ----------
    gt : (N, T, ...) ndarray
        The ground truth.

    Returns
    -------
    tuple of int or None
        The first such sequence, another, and after how many frames of it the other begins. Of motion that stands still,
        nothing can be told.
    """
    motion = gt.reshape(*gt.shape[:2], -1)
    sums = motion.sum(axis=-1)  # equal frames have equal sums
    first = dict(zip(sums[:, 0].tolist(), range(len(motion)), strict=True))
    for i, shift in np.argwhere(np.isin(sums, sums[:, 0])).tolist():
        j, rest = first[sums[i, shift].item()], motion[i, shift:]
        if j != i and (rest != rest[0]).any() and np.array_equal(rest, motion[j, : len(rest)]):
            return i, j, shift
    return None


def positions_for(pair: Pair, metrics: Sequence[str]) -> tuple[Array, Array] | None:
    """Return the positions of a pair in millimetres, if one of the metrics takes them and the pair has a meta."""
    for name in metrics:
        if pair.meta is not None and metric_called(name, "metrics").takes == "positions":
            return millimetres(pair, name)
    return None


def millimetres(pair: Pair, metric: str) -> tuple[Array, Array]:
    """Return the positions (N, T, J, 3) of a pair with a meta, in millimetres, for a metric that takes them.

    Raises
    ------
    ValueError
        If the pair has no positions, or their unit is unknown; names the metric.
    """
    assert pair.meta is not None
    try:
        return pair.meta.millimetres(pair.gt), pair.meta.millimetres(pair.pred)
    except ValueError as error:
        raise ValueError(f"metrics: {metric}: {error}") from error


def described(pair: Pair, context: Mapping[str, Any]) -> tuple[float | None, dict[str, Any]]:
    """Return the frames per second of a pair, and the other fields of its signature.

    Parameters
    ----------
    pair : Pair
        The pair.
    context : mapping
        Fields that the caller states.

    Returns
    -------
    fps : float or None
        Frames per second, if known.
    context : dict
        The fields.

    Raises
    ------
    ValueError
        If the caller states another value than the file.
    """
    if pair.meta is None:
        return FPS, {"representation": "euler", **context}
    own = pair.meta.context()
    for name in own.keys() & context.keys():
        if own[name] != context[name]:
            raise ValueError(f"{name}: the file states {own[name]!r}, not {context[name]!r}")
    return pair.meta.fps, {**own, **context}


def verified(pair: Pair, poses: Pair | None, protocol: str | None, fps: float | None) -> Verification | None:
    """Compare the ground truth of a pair to that of a protocol.

    Parameters
    ----------
    pair : Pair
        The pair.
    poses : Pair or None
        The pair as exponential maps, if known.
    protocol : str or None
        The name of the protocol.
    fps : float or None
        Frames per second.

    Returns
    -------
    Verification or None
        None if the name is unknown.
    """
    if protocol not in VERIFIED:
        return None
    if protocol == lafan1.name:
        try:
            return verify(pair.gt, protocol, fps=fps)
        except ValueError as error:  # other features, which are scored all the same
            return Verification(protocol=protocol, findings=(str(error),))
    if poses is None:
        return Verification(protocol=protocol, undecided=("it is compared by exponential maps: samples, or --expmap",))
    return verify(poses.gt, protocol, action=pair.name if pair.name in ACTIONS else None, fps=fps)


def known_blocks(protocol: object, action: str, shape: tuple[int, ...]) -> Groups:
    """Return the blocks of the windows of a protocol.

    Parameters
    ----------
    protocol : object
        The name of the protocol; any other value is an unknown protocol.
    action : str
        The action of Human3.6M.
    shape : tuple of int
        The shape of the motion, ``(N, T, ...)``.

    Returns
    -------
    tuple of str or None
        A label for each sequence; None if the protocol or the lengths of the clips are unknown.

    Raises
    ------
    ValueError
        If N is not the number of windows.
    """
    lengths = TEST_LENGTHS.get(action, (None, None))
    if protocol not in BLOCKED or None in lengths:
        return None
    labels = window_blocks(protocol, [length for length in lengths if length is not None], n_target=shape[1])
    if len(labels) != shape[0]:
        raise ValueError(f"{action}: the protocol {protocol} has {len(labels)} windows, got {shape[0]} sequences")
    return labels


def read_records(path: Path) -> list[Record]:
    """Read records, as ``npss-baselines evaluate --format json`` prints them, by suffix or else as JSON."""
    form = FORMATS.get(path.suffix)
    records = ((form and form.records) or read_json)(path)
    if not isinstance(records, list) or not all(isinstance(record, dict) for record in records):
        raise ValueError(f"{path}: expected a list of records")
    return records


def read_all(
    paths: Sequence[Path],
    *,
    metrics: Sequence[str] = (),
    edges_ms: Sequence[float] = (),
    max_size: float = MAX_SIZE,
    **context: Any,
) -> list[Record]:
    """Read files of records, and measure files of predictions."""
    records, of_records = [], suffixes("records")
    origin: dict[str, Path] = {}
    for path in paths:
        for record in read_records(path) if path.suffix in of_records else ():
            name = f"{record.get('action')!r} of {record.get('model')!r}"
            if origin.setdefault(name, path) != path:
                raise ValueError(f"{path}: {name} is also in {origin[name]}")
            records.append(record)
    samples = [path for path in paths if path.suffix not in of_records]
    if not samples:
        if options := [*context, *(["metrics"] if metrics else []), *(["edges_ms"] if edges_ms else [])]:
            raise ValueError(f"{options[0]}: only for files of results; records state their own")
        return records
    submissions = read_submissions(samples, max_size=max_size)
    return records + records_of(submissions, metrics=metrics, edges_ms=edges_ms, **context)
