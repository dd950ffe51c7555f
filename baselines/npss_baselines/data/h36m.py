"""Read Human3.6M as exponential maps, in its usual layout: ``dataset/S5/walking_1.txt``, ..."""

from __future__ import annotations

import contextlib
import hashlib
import os
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import numpy as np
import numpy.typing as npt

from npss.files import doing, read_text, write_stream_atomically
from npss.protocol import (
    ACTIONS,
    FPS,
    POSE,
    TEST_LENGTHS,
    TEST_SUBJECT,
    TRAIN_SUBJECTS,
    Window,
    random_windows,
    srnn_windows,
)
from npss.validation import one_of, positive_integer

Float32 = npt.NDArray[np.float32]

#: The functions that draw the test windows, by name.
WINDOWS: dict[str, Callable[..., tuple[Window, ...]]] = {
    "srnn-8": srnn_windows,
    "srnn-8-late": partial(srnn_windows, late=True),
    "random-256": random_windows,
}
#: All subjects.
SUBJECTS = tuple(sorted((*TRAIN_SUBJECTS, TEST_SUBJECT)))
#: Frames per second of a file.
FILE_FPS = 50


@dataclass(frozen=True)
class H36M:
    """A copy of the data set, checked by `open_root`.

    Attributes
    ----------
    folder : Path
        The folder that holds ``S1``, ``S5``, ...
    cache : Path or None
        The folder that caches parsed files in binary, which are many times faster to read.
    """

    folder: Path
    cache: Path | None = None


def open_root(root: str | os.PathLike[str], *, cache: str | os.PathLike[str] | None = None) -> H36M:
    """Find the data set, and check that its test set does not leak into its training set.

    Parameters
    ----------
    root : path
        The folder that holds ``dataset``, or ``dataset`` itself.
    cache : path, optional
        A folder, created if missing, that caches every parsed file in binary under the digest of its content. It never
        goes stale, and serves all copies of the data set. By default, nothing is written.

    Returns
    -------
    H36M
        The argument of the other functions.

    Raises
    ------
    FileNotFoundError
        If the data set is missing.
    ValueError
        If another subject's file is a byte copy of one of the test subject's. Such copies of the data set circulate,
        and models trained on them have seen the test set. Names both files.

    Examples
    --------
    >>> open_root("nowhere")
    Traceback (most recent call last):
    FileNotFoundError: nowhere: no Human3.6M in it; expected files such as dataset/S5/walking_1.txt
    """
    top = Path(root)
    folder = next((place for place in (top / "dataset", top) if any(place.glob("S*/*_[12].txt"))), None)
    if folder is None:
        raise FileNotFoundError(
            f"{top}: no Human3.6M in it; expected files such as dataset/S{TEST_SUBJECT}/walking_1.txt"
        )
    data = H36M(folder, None if cache is None else Path(cache))
    _refuse_leaks(data)
    return data


def missing(data: H36M) -> list[str]:
    """List the files that this copy of the data set lacks.

    Parameters
    ----------
    data : H36M
        From `open_root`.

    Returns
    -------
    list of str
        Names such as ``S5/waiting_1.txt``, of the 210 in the whole data set.
    """
    names = (_name(subject, action, clip) for subject in SUBJECTS for action in ACTIONS for clip in (1, 2))
    return [name for name in names if not (data.folder / name).is_file()]


def load(data: H36M, subject: int, action: str, clip: int, *, fps: int = FILE_FPS) -> Float32:
    """Read a clip.

    Parameters
    ----------
    data : H36M
        From `open_root`.
    subject : {1, 5, 6, 7, 8, 9, 11}
        The subject.
    action : str
        One of `npss.protocol.ACTIONS`.
    clip : {1, 2}
        The number of the clip.
    fps : {50, 25}, optional
        Frames per second: all rows of the file, or the first, third, and so on.

    Returns
    -------
    (T, 99) ndarray of float32
        Translation, then rotations as exponential maps in radians.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, or the file is broken: names the file and the line.
    FileNotFoundError
        If this copy of the data set lacks the file.
    """
    return next(iter(_load(data, [_name(subject, action, clip)], fps).values()))


def training_clips(
    data: H36M, actions: Sequence[str], *, subjects: Sequence[int] = TRAIN_SUBJECTS, fps: int = FILE_FPS
) -> dict[str, Float32]:
    """Read both clips of every training subject.

    Parameters
    ----------
    data : H36M
        From `open_root`.
    actions : sequence of str
        Actions, of `npss.protocol.ACTIONS`.
    subjects : sequence of int, optional
        Subjects, of `npss.protocol.TRAIN_SUBJECTS`. If a copy of the data set is incomplete, name those to train on,
        and report them with the results.
    fps : {50, 25}, optional
        As for `load`.

    Returns
    -------
    dict of str to (T, 99) ndarray of float32
        The clips by file name, ``S1/walking_1.txt``, sorted by subject, action and clip.

    Raises
    ------
    TypeError, ValueError
        As `load`; or if there are no actions or subjects, or the test subject is among them.
    FileNotFoundError
        If files are missing; names all of them, and the subjects that have every file.
    """
    if isinstance(actions, str) or not actions:
        raise ValueError(f"actions: expected a sequence of actions, got {actions!r}")
    if not subjects or not set(subjects) <= set(TRAIN_SUBJECTS):
        raise ValueError(f"subjects: expected one or more of the training subjects {TRAIN_SUBJECTS}, got {subjects!r}")
    files = {s: [_name(s, action, clip) for action in actions for clip in (1, 2)] for s in subjects}
    try:
        return _load(data, [name for names in files.values() for name in names], fps)
    except FileNotFoundError as error:
        complete = tuple(s for s, names in files.items() if all((data.folder / name).is_file() for name in names))
        raise FileNotFoundError(f"{error}; subjects with all files: {complete}") from None


def load_test_clips(data: H36M, action: str) -> list[Float32]:
    """Read the test subject's two clips, at 25 frames per second, from which test windows are cut.

    Parameters
    ----------
    data : H36M
        From `open_root`.
    action : str
        One of `npss.protocol.ACTIONS`.

    Returns
    -------
    list of (T, 99) ndarray of float32
        Translation, then rotations as exponential maps in radians.

    Raises
    ------
    TypeError, ValueError
        As `load`; or if a clip's length differs from `npss.protocol.TEST_LENGTHS`, if known: a truncated clip would
        have other test windows. Names the file and both lengths.
    FileNotFoundError
        If this copy of the data set lacks one of the two; names it.

    Warns
    -----
    UserWarning
        If the expected length of a clip is unknown.
    """
    clips = _load(data, [_name(TEST_SUBJECT, action, clip) for clip in (1, 2)], FPS)
    for (name, clip), length in zip(clips.items(), TEST_LENGTHS[action], strict=True):
        if length is None:
            warnings.warn(
                f"{data.folder / name}: length not checked, because the expected length is unknown", stacklevel=2
            )
        elif len(clip) != length:
            raise ValueError(
                f"{data.folder / name}: {len(clip)} frames at {FPS} frames per second, expected {length}; test windows "
                f"depend on the length, so scores would not be comparable"
            )
    return list(clips.values())


def _name(subject: int, action: str, clip: int) -> str:
    """Return the name of a file in the data set."""
    one_of("action", action, ACTIONS)
    for name, value, choices in (("subject", subject, SUBJECTS), ("clip", clip, (1, 2))):
        if positive_integer(name, value) not in choices:
            raise ValueError(f"{name}: expected one of {', '.join(map(str, choices))}, got {value!r}")
    return f"S{subject}/{action}_{clip}.txt"


def _load(data: H36M, names: Sequence[str], fps: int) -> dict[str, Float32]:
    """Read files, after checking that all exist."""
    if fps not in (FPS, FILE_FPS):
        raise ValueError(f"fps: expected {FILE_FPS} or {FPS} frames per second, got {fps!r}")
    if absent := [name for name in names if not (data.folder / name).is_file()]:
        raise FileNotFoundError(f"{data.folder} lacks {' '.join(absent)}")
    return {name: np.ascontiguousarray(_read(data.folder / name, data.cache)[:: FILE_FPS // fps]) for name in names}


def _refuse_leaks(data: H36M) -> None:
    """Raise if another subject's file is a byte copy of one of the test subject's; compare sizes first."""
    test_folder = data.folder / f"S{TEST_SUBJECT}"
    tests: dict[int, list[Path]] = {}
    for file in sorted(test_folder.glob("*.txt")):
        tests.setdefault(file.stat().st_size, []).append(file)
    for file in sorted(data.folder.glob("S*/*.txt")):
        if file.parent == test_folder:
            continue
        for test in tests.get(file.stat().st_size, ()):
            if file.read_bytes() == test.read_bytes():
                raise ValueError(
                    f"{file} is a copy of {test}: this copy of Human3.6M leaks its test set into its training set"
                )


def _read(path: Path, cache: Path | None) -> Float32:
    """Read a file, from the cache if it has one with this content."""
    if cache is None:
        return _parse(path)
    cached = cache / f"{hashlib.sha256(path.read_bytes()).hexdigest()}.npy"
    with contextlib.suppress(OSError, ValueError, EOFError):  # missing or damaged: written again
        rows: Float32 = np.load(cached, allow_pickle=False)
        if rows.dtype == np.float32 and rows.ndim == 2 and rows.shape[1] == POSE:
            return rows
    rows = _parse(path)
    with doing("creating the cache"):
        cache.mkdir(parents=True, exist_ok=True)
    write_stream_atomically(cached, lambda stream: np.save(stream, rows))
    return rows


def _parse(path: Path) -> Float32:
    """Parse a text file; each number is the float32 nearest to the float64 of its decimal digits."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # for an empty file, which raises below
            rows: Float32 = np.loadtxt(
                path, dtype=np.float32, delimiter=",", comments=None, ndmin=2, encoding="utf-8-sig"
            )
    except ValueError as error:
        raise ValueError(f"{path}: {_fault(path) or error}") from error
    if rows.shape[1] != POSE or not np.isfinite(rows).all():
        raise ValueError(f"{path}: {_fault(path)}")
    return rows


def _fault(path: Path) -> str | None:
    """Describe the first fault of a file, with its line."""
    lines = read_text(path).splitlines()
    for number, line in enumerate(lines, 1):
        fields = line.split(",")
        if not line.strip():
            continue
        if len(fields) != POSE:
            return f"line {number} has {len(fields)} columns, not {POSE}"
        for column, field in enumerate(fields):
            where = f"line {number}, column {column} (of 0 to {POSE - 1}): {field!r}"
            try:
                value = float(field)
            except ValueError:
                return f"{where} is not a number"
            if not abs(value) <= float(np.finfo(np.float32).max):  # NaN included
                return f"{where} is not a finite number"
    return "no rows" if not any(line.strip() for line in lines) else None
