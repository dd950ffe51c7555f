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
from npss.protocol import FPS, SLICES_MS

_SUFFIXES = (".h5", ".hdf5", ".npz")
_SAME_POSE = 1e-3  # radians, or millimetres: files hold ground truth in various precision

#: By model and action: Human3.6M poses, exponential maps at 25 frames per second.
Submissions = Mapping[str, Mapping[str, Pair]]


def read_submissions(paths: Iterable[Path]) -> dict[str, dict[str, Pair]]:
    """Read one file of samples for each model, whose name is the file's; of a folder, all such files.

    Raises
    ------
    ValueError
        If there are none, two have the same name, or their ground truths differ.
    """
    files: list[Path] = []
    for path in paths:
        inside = sorted(file for file in path.iterdir() if file.suffix in _SUFFIXES) if path.is_dir() else [path]
        if not inside:
            raise ValueError(f"{path}: no samples in it ({', '.join(_SUFFIXES)})")
        files += inside
    stems = [file.stem for file in files]
    if twice := [file for place, file in enumerate(files) if file.stem in stems[:place]]:
        raise ValueError(f"{twice[0]}: there is another file of a model {twice[0].stem!r}")
    found = {file.stem: {str(pair.name): pair for pair in read_poses(file)} for file in files}
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
    return records + (records_of(read_submissions(samples), **context) if samples else [])
