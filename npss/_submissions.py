"""Predictions of several models on one ground truth, as files hold them: what leaderboards and reports are made of."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from npss._files import Pair, read_poses
from npss._poses import poses_to_euler
from npss._progress import Progress
from npss._records import Record, measure
from npss._results import one_line
from npss.protocol import FPS, SLICES_MS

_SUFFIXES = (".h5", ".hdf5", ".npz")
_SAME_POSE = 1e-3  # radians, or millimetres: files hold ground truth in various precision

#: What pages and pictures call the ground truth, beside the names of models.
TRUTH = "ground truth"

#: Fields of signatures that `records_of` states itself.
MEASURED = ("representation", "frames", "fps", "unwrap", "columns", "average")

#: By model and action: Human3.6M poses, exponential maps at 25 frames per second.
Submissions = Mapping[str, Mapping[str, Pair]]


def read_submissions(paths: Iterable[Path]) -> dict[str, dict[str, Pair]]:
    """Read one file of samples for each model, and of a folder all that are in it.

    A model is called as its file, ``MODEL.h5``; or as its folder, where the file is ``MODEL/samples.h5``.

    Raises
    ------
    ValueError
        If there are none, two have the same name, or their ground truths differ.
    """
    files: dict[str, Path] = {}
    for path in paths:
        if not path.exists():
            raise ValueError(f"{path}: no such file or folder")
        inside = [path]
        if not path.is_dir() and path.suffix not in _SUFFIXES:
            raise ValueError(f"{path}: expected samples ({', '.join(_SUFFIXES)})")
        if path.is_dir():
            several = sorted([*path.iterdir(), *path.glob("*/samples.*")])
            inside = [file for file in several if file.suffix in _SUFFIXES and file.is_file()]
        if not inside:
            raise ValueError(f"{path}: no samples in it ({', '.join(_SUFFIXES)})")
        for file in inside:
            model = one_line(file.parent.name if file.stem == "samples" else file.stem)
            if model == TRUTH:
                raise ValueError(f"{file}: no model may be called {TRUTH!r}")
            if model in files:
                raise ValueError(f"{file}: there is another file of a model {model!r}, {files[model]}")
            files[model] = file
    found = {model: {str(pair.name): pair for pair in read_poses(file)} for model, file in files.items()}
    check_truths(found)
    return found


def check_truths(submissions: Submissions) -> None:
    """Raise the ValueError that names two models whose ground truths differ."""
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


def records_of(submissions: Submissions, **context: Any) -> list[Record]:
    """Measure every prediction, with its single sequences: a record for each model and action."""
    found = []
    pairs = [(model, action, pair) for model, actions in submissions.items() for action, pair in actions.items()]
    with Progress("scoring") as progress:
        for done, (model, action, pair) in enumerate(pairs, 1):
            n_frames = pair.gt.shape[1]
            measured = measure(
                poses_to_euler(pair.gt),
                poses_to_euler(pair.pred),
                fps=FPS,
                at_ms=[time for time in SLICES_MS if time * FPS <= n_frames * 1000],
                sequences=True,
                representation="euler",
                frames=n_frames,
                **context,
            )
            found.append({"model": model, "action": action, **measured})
            progress(done / len(pairs))
    return found


def read_records(path: Path) -> list[Record]:
    """Read records from JSON, as ``python -m baselines evaluate --format json`` prints them."""
    try:
        records = json.loads(path.read_text(encoding="utf-8"))
    except (UnicodeDecodeError, json.JSONDecodeError) as error:
        raise ValueError(f"{path}: not JSON ({error})") from error
    if not isinstance(records, list) or not all(isinstance(record, dict) for record in records):
        raise ValueError(f"{path}: expected a list of records")
    return records


def read_all(paths: Sequence[Path], **context: Any) -> list[Record]:
    """Read records from ``.json`` files, and measure the predictions that the others hold."""
    records = [record for path in paths if path.suffix == ".json" for record in read_records(path)]
    samples = [path for path in paths if path.suffix != ".json"]
    if context and not samples:
        raise ValueError(f"{next(iter(context))}: records state their own; it is for files of samples")
    return records + (records_of(read_submissions(samples), **context) if samples else [])
