"""A folder that keeps sets of prepared motion, so that they are prepared once."""

from __future__ import annotations

import contextlib
import hashlib
import json
import zipfile
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from npss.files import doing, parse_json, write_stream_atomically
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.motion.dataset import ClipInfo, MotionSet, motion_set_of
from npss_baselines.manifold.motion.features import FPS

#: Raised whenever the same files give other features, be it for how they are read: sets of other versions are not read.
VERSION = 1


def cached(folder: Path, key: Any, make: Callable[[], MotionSet]) -> MotionSet:
    """Return the set that a folder keeps under a key, or make it, and keep it.

    Parameters
    ----------
    folder : Path
        Made if need be.
    key : anything that json can write
        What the set is made from. `VERSION` and the skeleton `JOINTS` are part of it anyway.
    make : callable
        What makes the set. Called if the folder does not have it, or the file is broken.
    """
    whole = json.dumps([VERSION, FPS, JOINTS.names, JOINTS.offsets.tolist(), key])
    path = folder / f"motion-{hashlib.sha256(whole.encode()).hexdigest()[:32]}.npz"
    with contextlib.suppress(FileNotFoundError, ValueError):
        return load(path)
    made = make()
    with doing("making the cache"):
        folder.mkdir(parents=True, exist_ok=True)
    save(path, made)
    return made


def save(path: Path, motion: MotionSet) -> None:
    """Write a set to a file: all of it or nothing.

    Parameters
    ----------
    path : Path
        A file, ``.npz``: the features of all clips, one below the other, and what the clips are as JSON.
    motion : MotionSet
        The set.
    """
    header = json.dumps({"version": VERSION, "clips": [asdict(clip) for clip in motion.clips]})
    features = np.concatenate(motion.features)
    write_stream_atomically(path, lambda stream: np.savez(stream, header=np.array(header), features=features))


def load(path: Path) -> MotionSet:
    """Read a set from a file.

    Parameters
    ----------
    path : Path
        From `save`.

    Returns
    -------
    MotionSet
        As it was.

    Raises
    ------
    FileNotFoundError
        If there is no file.
    ValueError
        If it is another file, of another version, or broken: names it.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            header, rows = parse_json(file["header"].item()), file["features"]
        if header["version"] != VERSION:
            raise ValueError(f"version {header['version']}, not {VERSION}")
        clips = [ClipInfo(**clip) for clip in header["clips"]]
        _check(clips, rows)
    except (ValueError, TypeError, KeyError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path}: not a set of prepared motion, or a broken one: {error}") from error
    ends = np.cumsum([clip.n_frames for clip in clips])
    return motion_set_of(clips, np.split(rows, ends[:-1]))


def _check(clips: Sequence[ClipInfo], rows: npt.NDArray[Any]) -> None:
    """Raise an error unless these are clips and the features of all their frames."""
    for clip in clips:
        if type(clip.n_frames) is not int or clip.n_frames < 1:
            raise ValueError(f"clip {clip.name!r} of {clip.n_frames!r} frames")
        if not all(isinstance(text, str) for text in (clip.name, clip.source, clip.subject, clip.description)):
            raise ValueError(f"clip {clip.name!r} is not described in words")
    n_frames = sum(clip.n_frames for clip in clips)
    if rows.dtype != np.float32 or rows.ndim != 2 or len(rows) != n_frames or 0 in rows.shape:
        raise ValueError(f"features of dtype {rows.dtype} and shape {rows.shape} for {n_frames} frames")
    if not np.isfinite(rows).all():
        raise ValueError("features that are not finite")
