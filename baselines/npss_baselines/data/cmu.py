"""CMU's motion as sources: the BVH files of B. Hahne's conversion (cgspeed)."""

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
    "HandIndex": "Mid1",  # the knuckle in line with the forearm, as in Human3.6M's skeleton
}
#: The names of the 20 joints in these files; the end site of ``lFoot`` is ``lFootEnd``.
CMU_NAMES = {
    "Hips": "hip",
    "Spine1": "abdomen",
    "Neck": "neck",
    "Head": "head",
    **{f"Left{name}": f"l{theirs}" for name, theirs in _LEFT.items()},
    **{f"Right{name}": f"r{theirs}" for name, theirs in _LEFT.items()},
}
#: The first frames of a file, which are left out: the converter's T-pose, and seven frames of transition to the
#: captured motion, in which the hands move at up to 30 metres per second.
LEAD_IN = 8
#: The folders of `styles_clips`.
STYLES = ("indian", "martial", "salsa")
#: Subjects to read in a quick trial.
QUICK_SUBJECTS = ("02", "08", "09")


class CMU(Source):
    """The clips of CMU that `clips.csv` describes."""

    name = "cmu"
    description = "the folder of CMU clips: clips.csv, 01/01_01.bvh ..."
    test_subjects = ("02", "14")
    validation_subjects = ("08", "12")

    def label(self, description: str) -> str:
        """Return the first action in the description; see `label_of`."""
        return label_of(description)

    def clips(
        self,
        folder: Path,
        *,
        quick: bool = False,
        cache: Path | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> Iterator[Clip]:
        """Read all clips; if `quick`, those of `QUICK_SUBJECTS`."""
        return cmu_clips(folder, subjects=QUICK_SUBJECTS if quick else None, progress=progress)


class CMUStyles(Source):
    """More clips of CMU, without subjects: dances and martial arts."""

    name = "cmu-styles"
    description = "the folder of more CMU clips: indian/04.bvh, salsa/03.bvh ..."
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
        """Read all clips; if `quick`, the first few."""
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
    """Read the clips of a folder lazily.

    Parameters
    ----------
    root : path
        The folder that holds ``clips.csv``, with the columns ``clip`` and ``description``, and a file such as
        ``02/02_01.bvh`` for each clip.
    subjects : iterable of str, optional
        Subjects to read, such as ``"02"``; by default, all.
    progress : callable, optional
        Called with the share that has been read; for example, a `npss.console.Progress`.

    Returns
    -------
    iterator of Clip
        In the order of ``clips.csv``. The first `LEAD_IN` frames of every file are left out.

    Raises
    ------
    TypeError
        If `subjects` is not an iterable of strings.
    FileNotFoundError
        If ``clips.csv`` is missing, or files of clips in it are; names all of them.
    ValueError
        If ``clips.csv`` is broken or does not list a file; if a subject has no clips; or, while reading, if a file is
        broken, has another skeleton, or has no frames after the lead-in. Names the file and, if known, the line.

    Notes
    -----
    The data are not corrected. The paths of two clips, 07_12 and 09_10, go back and forth, so that no foot is ever
    still, half a body below the ground; in some dances, a limb jumps for a few frames.
    """
    folder = Path(root)
    files = _listed(folder)
    if subjects is not None:
        selected = each("subjects", subjects, "names", ordered=False)
        available = {file.subject: None for file in files}
        for subject in selected:
            if not isinstance(subject, str):
                raise TypeError(f"subjects: expected strings, got {subject!r}")
            if subject not in available:
                raise ValueError(f"subjects: {folder} has no clips of {subject!r}, only of {', '.join(available)}")
        files = [file for file in files if file.subject in selected]
    if absent := [str(file.path.relative_to(folder)) for file in files if not file.path.is_file()]:
        raise FileNotFoundError(f"{folder} lacks {' '.join(absent)}")
    return _read("cmu", [file._replace(subject=f"cmu/{file.subject}") for file in files], progress)


def styles_clips(
    root: str | os.PathLike[str], *, progress: Callable[[float], None] = lambda share: None
) -> Iterator[Clip]:
    """Read the dances and martial arts of CMU lazily.

    Parameters
    ----------
    root : path
        The folder that holds ``indian``, ``martial`` and ``salsa``, with files such as ``salsa/03.bvh``.
    progress : callable, optional
        As of `cmu_clips`.

    Returns
    -------
    iterator of Clip
        In the order of their names, without subjects. The first `LEAD_IN` frames of every file are left out.

    Raises
    ------
    FileNotFoundError
        If there are no such files.
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
        raise FileNotFoundError(f"{folder}: no clips in it; expected files such as salsa/03.bvh")
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
                raise ValueError(f"{where}: duplicate clip {row[0]}")
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
            raise ValueError(f"{file.path}: another skeleton, without the joints {' '.join(absent)}")
        if len(motion.root) <= LEAD_IN:
            raise ValueError(f"{file.path}: {len(motion.root)} frames, expected more than the {LEAD_IN} of the lead-in")
        joints = [names.index(CMU_NAMES[name]) for name in NAMES]
        positions = motion.positions()[LEAD_IN:, joints]
        yield Clip(file.name, source, file.subject, file.description, motion.fps, positions)
        progress(done / len(files))
