"""A cache of prepared motion."""

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

#: Raise it whenever the same files give other features: cached sets of other versions are ignored.
VERSION = 1


def cached(folder: Path, key: Any, make: Callable[[], MotionSet]) -> MotionSet:
    """Return the set stored under a key, or make and store it.

    Parameters
    ----------
    folder : Path
        The cache, created if missing.
    key : JSON value
        What the set is made from. `VERSION`, the frame rate and the skeleton `JOINTS` are added to it.
    make : callable
        Makes the set if the cache does not have it or the file is broken.
    """
    full_key = json.dumps([VERSION, FPS, JOINTS.names, JOINTS.offsets.tolist(), key])
    path = folder / f"motion-{hashlib.sha256(full_key.encode()).hexdigest()[:32]}.npz"
    with contextlib.suppress(FileNotFoundError, ValueError):
        return load(path)
    motion = make()
    with doing("making the cache"):
        folder.mkdir(parents=True, exist_ok=True)
    save(path, motion)
    return motion


def save(path: Path, motion: MotionSet) -> None:
    """Write a set to a file, atomically.

    Parameters
    ----------
    path : Path
        An ``.npz`` file: the features of all clips, concatenated, and the clips' descriptions as JSON.
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
        Written by `save`.

    Returns
    -------
    MotionSet
        The set that was saved.

    Raises
    ------
    FileNotFoundError
        If the file does not exist.
    ValueError
        If it is not such a file, of another version, or broken. The message names it.
    """
    try:
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as file:
            header, rows = parse_json(file["header"].item()), file["features"]
        if header["version"] != VERSION:
            raise ValueError(f"version {header['version']}, not {VERSION}")
        clips = [ClipInfo(**clip) for clip in header["clips"]]
        _check(clips, rows)
    except (ValueError, TypeError, KeyError, AttributeError, EOFError, zipfile.BadZipFile) as error:
        raise ValueError(f"{path}: not a valid set of prepared motion: {error}") from error
    ends = np.cumsum([clip.n_frames for clip in clips])
    return motion_set_of(clips, np.split(rows, ends[:-1]))


def _check(clips: Sequence[ClipInfo], rows: npt.NDArray[Any]) -> None:
    """Check that the clips are valid and that the features are those of all their frames."""
    for clip in clips:
        if type(clip.n_frames) is not int or clip.n_frames < 1:
            raise ValueError(f"clip {clip.name!r} has {clip.n_frames!r} frames")
        if not all(isinstance(text, str) for text in (clip.name, clip.source, clip.subject, clip.description)):
            raise ValueError(f"clip {clip.name!r}: expected strings as name, source, subject and description")
    n_frames = sum(clip.n_frames for clip in clips)
    if rows.dtype != np.float32 or rows.ndim != 2 or len(rows) != n_frames or 0 in rows.shape:
        raise ValueError(f"features of dtype {rows.dtype} and shape {rows.shape} for {n_frames} frames")
    if not np.isfinite(rows).all():
        raise ValueError("features must be finite")
