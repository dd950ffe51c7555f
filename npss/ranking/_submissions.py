"""Predictions of several models on one ground truth, as files hold them: what leaderboards and reports are made of."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np

from npss._analysis.blocks import Groups
from npss.console._progress import Progress
from npss.files._arrays import MAX_SIZE
from npss.files._formats import FORMATS, listed, suffixes
from npss.files._json import read_json
from npss.files._samples import Pair, euler_of, read_poses
from npss.protocol import BLOCKED, FPS, SLICES_MS, TEST_LENGTHS, window_blocks
from npss.ranking._names import names_of_paths
from npss.records import Record, measure

_SAME_POSE = 1e-3  # radians, or millimetres: files hold ground truth in various precision

#: What pages and pictures call the ground truth, beside the names of models.
TRUTH = "ground truth"

#: Fields of signatures that `records_of` states itself.
MEASURED = ("representation", "frames", "fps", "unwrap", "columns", "average")

#: By model and action: Human3.6M poses, exponential maps at 25 frames per second.
Submissions = Mapping[str, Mapping[str, Pair]]


def read_submissions(paths: Iterable[Path], *, max_size: float = MAX_SIZE) -> dict[str, dict[str, Pair]]:
    """Read one file of samples for each model, and of a folder all that are in it.

    A model is called as its file, ``MODEL.h5``; or as its folder, where the file is ``MODEL/samples.h5``; with as much
    of the path before it as it takes to tell two apart. The arrays of one file may take `max_size` GiB of memory.

    Raises
    ------
    ValueError
        If there are none, a file is there twice, a prediction has another shape than its ground truth, or the ground
        truths of two models differ: names the file, or the models.
    """
    files = names_of_paths(sample_files(paths))
    found = {model: read_actions(file, max_size=max_size) for model, file in files.items()}
    if TRUTH in found:
        raise ValueError(f"no model may be called {TRUTH!r}")
    check_truths(found)
    return found


def sample_files(paths: Iterable[Path]) -> list[Path]:
    """Return the files of samples that paths stand for.

    Parameters
    ----------
    paths : iterable of Path
        Files; or folders, for all files in them that are not hidden.

    Returns
    -------
    list of Path
        ``MODEL.h5``, or another format that is registered, or ``MODEL/samples.h5``.

    Raises
    ------
    ValueError
        If a path does not exist, is no file of samples, or a folder has none.
    """
    files, known = [], suffixes("samples")
    for path in paths:
        if not path.exists():
            raise ValueError(f"{path}: no such file or folder")
        if not path.is_dir() and path.suffix not in known:
            raise ValueError(f"{path}: expected {listed('samples')} samples")
        inside = [path]
        if path.is_dir():
            several = [file for file in (*path.iterdir(), *path.glob("*/samples.*")) if not _hidden(file, path)]
            inside = sorted(file for file in several if file.suffix in known and file.is_file())
        if not inside:
            raise ValueError(f"{path}: no samples in it ({listed('samples')})")
        files += inside
    return files


def _hidden(file: Path, folder: Path) -> bool:
    """Say whether a file is not meant to be seen: ``.ipynb_checkpoints/samples.h5``, or macOS's ``._model.h5``."""
    return any(part.startswith(".") for part in file.relative_to(folder).parts)


def read_actions(file: Path, *, max_size: float = MAX_SIZE) -> dict[str, Pair]:
    """Read a file of samples, each prediction of the shape of its ground truth.

    Parameters
    ----------
    file : Path
        The file, ``.h5``, ``.hdf5`` or ``.npz``.
    max_size : float, optional
        How much memory its arrays may take, in GiB.

    Returns
    -------
    dict of str to Pair
        By action.

    Raises
    ------
    ValueError
        If it is no such file, or a prediction has another shape; names the file.
    """
    pairs = {str(pair.name): pair for pair in read_poses(file, max_size=max_size)}
    for action, pair in pairs.items():
        if pair.gt.shape != pair.pred.shape:
            raise ValueError(
                f"{file}: {action}: the predictions have {pair.pred.shape[1]} frames, the ground truth "
                f"{pair.gt.shape[1]}; nothing is cut"
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
    """Make sure that all models predict the same motion.

    Parameters
    ----------
    submissions : mapping of str to mapping of str to Pair
        By model and action.

    Raises
    ------
    ValueError
        If the ground truths of an action differ; names two models.
    """
    first: dict[str, tuple[str, Pair]] = {}
    for model, actions in submissions.items():
        for action, pair in actions.items():
            other, known = first.setdefault(action, (model, pair))
            if known.gt.shape != pair.gt.shape:
                what = f"shapes {known.gt.shape} and {pair.gt.shape}"
            elif (off := np.abs(known.gt - pair.gt).max(axis=(1, 2))).max() > _SAME_POSE:
                what = f"by up to {off.max():.3g}, in sequence {int(off.argmax())}"
            else:
                continue
            raise ValueError(
                f"{action}: the ground truths of {other!r} and {model!r} differ ({what}), so they cannot be compared"
            )


def records_of(
    submissions: Submissions,
    *,
    metrics: Sequence[str] = (),
    groups: Mapping[str, Groups] | None = None,
    **context: Any,
) -> list[Record]:
    """Measure every prediction, by other metrics, too, with its single sequences: a record for each model and action.

    Parameters
    ----------
    submissions : mapping of str to mapping of str to Pair
        By model and action, ``(N, T, 99)`` exponential maps at 25 frames per second.
    groups : mapping of str to sequence, optional
        The blocks of the sequences, by action; by default they follow from ``protocol`` and the lengths of the clips,
        where both are known.
    **context
        Known fields that the signatures state, such as ``protocol='srnn-8'``.

    Returns
    -------
    list of dict
        As `npss.records.measure` returns, with ``model`` and ``action``.

    Raises
    ------
    ValueError
        If files hold another number of sequences than the protocol has windows.
    """
    found = []
    pairs = [(model, action, pair) for model, actions in submissions.items() for action, pair in actions.items()]
    with Progress("scoring") as progress:
        for done, (model, action, pair) in enumerate(pairs, 1):
            n_frames = pair.gt.shape[1]
            with naming(model, action):
                measured = measure(
                    *euler_of(pair),
                    fps=FPS,
                    at_ms=[time for time in SLICES_MS if time * FPS <= n_frames * 1000],
                    metrics=metrics,
                    poses=(pair.gt, pair.pred),
                    sequences=True,
                    groups=groups[action] if groups else known_blocks(context.get("protocol"), action, pair.gt.shape),
                    representation="euler",
                    frames=n_frames,
                    **context,
                )
            found.append({"model": model, "action": action, **measured})
            progress(done / len(pairs))
    return found


def known_blocks(protocol: object, action: str, shape: tuple[int, ...]) -> Groups:
    """Return the blocks of the windows of a protocol.

    Parameters
    ----------
    protocol : object
        Its name; any other value is a protocol that is not known.
    action : str
        Which of Human3.6M's.
    shape : tuple of int
        That of the motion, ``(N, T, ...)``.

    Returns
    -------
    tuple of str or None
        A label for each sequence; None where the protocol or the lengths of the clips are not known.

    Raises
    ------
    ValueError
        If the shape ``(N, T, ...)`` of the motion is not that of these windows.
    """
    lengths = TEST_LENGTHS.get(action, (None, None))
    if protocol not in BLOCKED or None in lengths:
        return None
    labels = window_blocks(protocol, [length for length in lengths if length is not None], n_target=shape[1])
    if len(labels) != shape[0]:
        raise ValueError(
            f"{action}: the protocol {protocol} has {len(labels)} windows, but here are {shape[0]} sequences"
        )
    return labels


def read_records(path: Path) -> list[Record]:
    """Read records, as ``npss-baselines evaluate --format json`` prints them; JSON unless the suffix says."""
    form = FORMATS.get(path.suffix)
    records = ((form and form.records) or read_json)(path)
    if not isinstance(records, list) or not all(isinstance(record, dict) for record in records):
        raise ValueError(f"{path}: expected a list of records")
    return records


def read_all(
    paths: Sequence[Path], *, metrics: Sequence[str] = (), max_size: float = MAX_SIZE, **context: Any
) -> list[Record]:
    """Read the records that some files hold, and measure the predictions that the others do."""
    records, of_records = [], suffixes("records")
    origin: dict[str, Path] = {}
    for path in paths:
        for record in read_records(path) if path.suffix in of_records else ():
            named = f"{record.get('action')!r} of {record.get('model')!r}"
            if origin.setdefault(named, path) != path:
                raise ValueError(f"{path}: {named} is in {origin[named]}, too")
            records.append(record)
    samples = [path for path in paths if path.suffix not in of_records]
    if not samples:
        if given := [*context, *(["metrics"] if metrics else [])]:
            raise ValueError(f"{given[0]}: records state their own; it is for files of samples")
        return records
    return records + records_of(read_submissions(samples, max_size=max_size), metrics=metrics, **context)
