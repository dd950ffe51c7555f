"""Any folder of BVH files as a source: of any skeleton, subjects by folder, actions by name or from a list."""

from __future__ import annotations

import csv
import re
from collections import Counter
from collections.abc import Callable, Iterator
from io import StringIO
from pathlib import Path
from typing import NamedTuple

from npss.files import read_text
from npss_baselines.data import bvh, mapping
from npss_baselines.data.motion import Clip
from npss_baselines.data.source import QUICK, Source
from npss_baselines.data.upright import up_of, with_y_up

#: Optional files: a list of clips in the folder, and mappings in the folder or in those below it.
LIST, MAPPING = "labels.csv", "mapping.json"
_COLUMNS = ["file", "subject", "action"]


class BvhFolder(Source):
    """A folder of BVH files, for the manifold.

    A clip's subject is the name of the folder just below this one that holds it, and its action is the first word of
    its name: ``anna/walk_01.bvh``. Or both are in the file ``labels.csv``, with the columns ``file``, ``subject`` and
    ``action``. The subjects ``test`` and ``validation`` are held out. The common joints are guessed, or read from the
    file ``mapping.json`` nearest above the clip.
    """

    name = "bvh"
    description = (
        "a folder of BVH files of any skeleton: anna/walk_01.bvh is of subject anna; the subjects test and "
        "validation are held out"
    )
    test_subjects = ("test",)
    validation_subjects = ("validation",)

    def clips(
        self,
        folder: Path,
        *,
        quick: bool = False,
        cache: Path | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> Iterator[Clip]:
        """Read all clips; if `quick`, the first few of each subject."""
        files = _files(folder)
        if quick:
            seen: Counter[str] = Counter()
            files = [file for file in files if not seen.update([file.subject]) and seen[file.subject] <= QUICK]
        return self._read(folder, files, progress)

    def _read(self, folder: Path, files: list[_File], progress: Callable[[float], None]) -> Iterator[Clip]:
        for done, file in enumerate(files, 1):
            motion = bvh.read(file.path)
            try:
                joints = _mapping(file.path, folder) or mapping.guess(motion.skeleton)
                upright = with_y_up(motion, up_of(motion, joints))
                positions = joints.positions(upright.positions(), motion.skeleton)
            except ValueError as error:
                raise ValueError(f"{file.path}: {error}") from error
            name = file.path.relative_to(folder).with_suffix("").as_posix()
            subject = self.subject(file.subject) if file.subject else ""
            yield Clip(name, self.name, subject, file.action, motion.fps, positions)
            progress(done / len(files))


class _File(NamedTuple):
    path: Path
    subject: str
    action: str


def _files(folder: Path) -> list[_File]:
    """Return the clips of a folder by name, or those in its list."""
    found = sorted(path for path in folder.rglob("*") if path.suffix.lower() == ".bvh")
    if not found:
        raise FileNotFoundError(f"{folder}: no BVH files in it")
    if (folder / LIST).exists():
        return _listed(folder, found)
    files = []
    for path in found:
        above = path.relative_to(folder).parts[:-1]
        word = re.match(r"[^\W\d_]+", path.stem)
        files.append(_File(path, above[0] if above else "", word[0].lower() if word else ""))
    return files


def _listed(folder: Path, found: list[Path]) -> list[_File]:
    """Read the list of clips."""
    listing = folder / LIST
    files: dict[Path, _File] = {}
    rows = csv.reader(StringIO(read_text(listing), newline=""), strict=True)
    try:
        if (header := next(rows, None)) != _COLUMNS:
            raise ValueError(f"line 1: expected {','.join(_COLUMNS)}, got {header!r}")
        for row in rows:
            where = f"line {rows.line_num}"
            if len(row) != len(_COLUMNS):
                raise ValueError(f"{where}: expected a file, its subject and its action, got {row!r}")
            path = folder / row[0]
            if path not in found:
                raise ValueError(f"{where}: no BVH file {row[0]!r} in the folder")
            if path in files:
                raise ValueError(f"{where}: duplicate file {row[0]!r}")
            files[path] = _File(path, *row[1:])
    except (ValueError, csv.Error) as error:
        raise ValueError(f"{listing}: {error}") from error
    if absent := [str(path.relative_to(folder)) for path in found if path not in files]:
        raise ValueError(f"{listing}: does not list {' '.join(absent)}")
    return list(files.values())


def _mapping(clip: Path, folder: Path) -> mapping.JointMapping | None:
    """Return the mapping nearest above a clip, if there is one."""
    for parent in clip.parents:
        if (parent / MAPPING).exists():
            return mapping.read(parent / MAPPING)
        if parent == folder:
            break
    return None
