"""CMU's motion as sources, from the BVH files of B. Hahne's conversion (cgspeed)."""

from __future__ import annotations

import csv
import os
import re
from collections.abc import Callable, Iterable, Iterator, Sequence
from io import StringIO
from itertools import islice
from pathlib import Path
from typing import NamedTuple

from npss.files import read_text
from npss.validation import each
from npss_baselines.data import bvh
from npss_baselines.data.cmu_labels import label_of
from npss_baselines.data.motion import NAMES, Clip
from npss_baselines.data.source import QUICK, Source

_LEFT = {
    "UpLeg": "Thigh",
    "Leg": "Shin",
    "Foot": "Foot",
    "ToeBase": "FootEnd",
    "Arm": "Shldr",
    "ForeArm": "ForeArm",
    "Hand": "Hand",
    "HandIndex": "Mid1",  # of the knuckles the one in line with the forearm, as in Human3.6M's skeleton
}
#: What the 20 joints are called in these files; the end site of ``lFoot`` is ``lFootEnd``.
CMU_NAMES = {
    "Hips": "hip",
    "Spine1": "abdomen",
    "Neck": "neck",
    "Head": "head",
    **{f"Left{name}": f"l{its}" for name, its in _LEFT.items()},
    **{f"Right{name}": f"r{its}" for name, its in _LEFT.items()},
}
#: The frames that a file begins with, and that are left out: a T-pose of the converter's, and the seven in which it
#: leads over to what was captured, the hands moving at up to 30 metres per second.
LEAD_IN = 8
#: The folders of `styles_clips`.
STYLES = ("indian", "martial", "salsa")
#: Subjects whose clips are read if it is to be quick.
QUICK_SUBJECTS = ("02", "08", "09")


class CMU(Source):
    """Clips of CMU that `clips.csv` describes."""

    name = "cmu"
    description = "the folder of CMU's clips: clips.csv, 01/01_01.bvh ..."
    test_subjects = ("02", "14")
    validation_subjects = ("08", "12")

    def label(self, description: str) -> str:
        """Return the action that the description names first; see `label_of`."""
        return label_of(description)

    def clips(
        self,
        folder: Path,
        *,
        quick: bool = False,
        cache: Path | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> Iterator[Clip]:
        """Read all clips; quick, those of `QUICK_SUBJECTS`."""
        return cmu_clips(folder, subjects=QUICK_SUBJECTS if quick else None, progress=progress)


class CMUStyles(Source):
    """Further clips of CMU, whose subjects are not stated: dances and martial arts."""

    name = "cmu-styles"
    description = "the folder of further CMU clips: indian/04.bvh, salsa/03.bvh ..."
    option = "styles"
    vocabulary = "cmu"

    def clips(
        self,
        folder: Path,
        *,
        quick: bool = False,
        cache: Path | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> Iterator[Clip]:
        """Read all clips; quick, the first few."""
        return islice(styles_clips(folder, progress=progress), QUICK if quick else None)


class _File(NamedTuple):
    path: Path
    name: str
    subject: str
    description: str


def cmu_clips(
    root: str | os.PathLike[str],
    *,
    subjects: Iterable[str] | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Iterator[Clip]:
    """Read the clips of a folder, each when it is asked for.

    Parameters
    ----------
    root : path
        The folder that holds ``clips.csv``, with the columns ``clip`` and ``description``, and for each of its clips
        the file ``02/02_01.bvh``.
    subjects : iterable of str, optional
        Whose clips, such as ``"02"``; by default those of all.
    progress : callable, optional
        Called with the share that has been read, such as a `npss.console.Progress`.

    Returns
    -------
    iterator of Clip
        In the order of ``clips.csv``. The first `LEAD_IN` frames of every file are left out.

    Raises
    ------
    TypeError
        If `subjects` is no iterable of strings.
    FileNotFoundError
        If there is no ``clips.csv``, or a clip that it lists has no file: names all of them.
    ValueError
        If ``clips.csv`` is broken; if there is a file that it does not list, or no clip of a subject; and while
        reading, if a file is broken or of another skeleton, or has no frames beyond the first. Names the file and,
        where it can be known, the line.

    Notes
    -----
    The data is given as it is. Two clips, 07_12 and 09_10, have a path that goes back and forth, so that no foot is
    ever still, and that is half a body below the ground; in some dances a limb leaps for a few frames.
    """
    folder = Path(root)
    files = _listed(folder)
    if subjects is not None:
        wanted = each("subjects", subjects, "names", ordered=False)
        there = {file.subject: None for file in files}
        for subject in wanted:
            if not isinstance(subject, str):
                raise TypeError(f"subjects: expected strings, got {subject!r}")
            if subject not in there:
                raise ValueError(f"subjects: {folder} has no clips of {subject!r}, only of {', '.join(there)}")
        files = [file for file in files if file.subject in wanted]
    if absent := [str(file.path.relative_to(folder)) for file in files if not file.path.is_file()]:
        raise FileNotFoundError(f"{folder} lacks {' '.join(absent)}")
    return _read("cmu", [file._replace(subject=f"cmu/{file.subject}") for file in files], progress)


def styles_clips(
    root: str | os.PathLike[str], *, progress: Callable[[float], None] = lambda share: None
) -> Iterator[Clip]:
    """Read the clips of CMU that are dances and martial arts, each when it is asked for.

    Parameters
    ----------
    root : path
        The folder that holds ``indian``, ``martial`` and ``salsa``, with files such as ``salsa/03.bvh``.
    progress : callable, optional
        As of `cmu_clips`.

    Returns
    -------
    iterator of Clip
        In the order of their names. Who moves is not stated. The first `LEAD_IN` frames of every file are left out.

    Raises
    ------
    FileNotFoundError
        If there is no such file.
    ValueError
        While reading, as `cmu_clips`.
    """
    folder = Path(root)
    files = [
        _File(path, f"{style}/{path.stem}", "", style)
        for style in STYLES
        for path in sorted((folder / style).glob("*.bvh"))
    ]
    if not files:
        raise FileNotFoundError(f"no clips in {folder}: expected salsa/03.bvh and so on below it")
    return _read("cmu-styles", files, progress)


def _listed(folder: Path) -> list[_File]:
    """Read clips.csv."""
    listing = folder / "clips.csv"
    files: dict[str, _File] = {}
    rows = csv.reader(StringIO(read_text(listing), newline=""), strict=True)
    try:
        if (header := next(rows, None)) != ["clip", "description"]:
            raise ValueError(f"line 1: expected clip,description, got {header!r}")
        for row in rows:
            where = f"line {rows.line_num}"
            if len(row) != 2 or not row[1].strip():
                raise ValueError(f"{where}: expected a clip and its description, got {row!r}")
            if not (match := re.fullmatch(r"(\d{2,3})_\d{2}", row[0], re.ASCII)):
                raise ValueError(f"{where}: expected a clip such as 02_01, got {row[0]!r}")
            if row[0] in files:
                raise ValueError(f"{where}: {row[0]} is there twice")
            path = folder / match[1] / f"{row[0]}.bvh"
            files[row[0]] = _File(path, row[0], match[1], row[1])
    except (ValueError, csv.Error) as error:
        raise ValueError(f"{listing}: {error}") from error
    if not files:
        raise ValueError(f"{listing}: no clips")
    listed = {file.path for file in files.values()}
    if others := sorted(str(path.relative_to(folder)) for path in folder.glob("*/*.bvh") if path not in listed):
        raise ValueError(f"{listing}: does not list {' '.join(others)}")
    return list(files.values())


def _read(source: str, files: Sequence[_File], progress: Callable[[float], None]) -> Iterator[Clip]:
    for done, file in enumerate(files, 1):
        motion = bvh.read(file.path)
        names = motion.skeleton.names
        if absent := [name for name in CMU_NAMES.values() if name not in names]:
            raise ValueError(f"{file.path}: no joint {' '.join(absent)}: another skeleton")
        if len(motion.root) <= LEAD_IN:
            raise ValueError(f"{file.path}: {len(motion.root)} frames, of which the first {LEAD_IN} do not count")
        joints = [names.index(CMU_NAMES[name]) for name in NAMES]
        positions = motion.positions()[LEAD_IN:, joints]
        yield Clip(file.name, source, file.subject, file.description, motion.fps, positions)
        progress(done / len(files))
