"""Human3.6M in the common form."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator

import numpy as np
import numpy.typing as npt

from npss.protocol import ACTIONS
from npss.skeleton import H36M, poses_to_positions
from npss.validation import Float64, each
from npss_baselines.data import h36m
from npss_baselines.data.motion import NAMES, Clip

_JOINTS = [H36M.names.index(name) for name in NAMES]


def joints_of_poses(poses: npt.ArrayLike) -> Float64:
    """Compute where the 20 joints of Human3.6M's poses ``(..., T, 99)`` are: ``(..., T, 20, 3)``, in mm, with path."""
    positions: Float64 = poses_to_positions(np.asarray(poses, np.float64), root="path")[..., _JOINTS, :]
    return positions


def h36m_clips(
    root: str | os.PathLike[str],
    *,
    subjects: Iterable[int] | None = None,
    cache: str | os.PathLike[str] | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Iterator[Clip]:
    """Read the clips that a copy of Human3.6M has, each when it is asked for.

    Parameters
    ----------
    root : path
        The folder that holds ``dataset``, or ``dataset`` itself.
    subjects : iterable of int, optional
        Whose clips, of `npss_baselines.data.h36m.SUBJECTS`; by default all that there are.
    cache : path, optional
        As of `npss_baselines.data.h36m.open_root`.
    progress : callable, optional
        Called with the share that has been read, such as a `npss.console.Progress`.

    Returns
    -------
    iterator of Clip
        By subject, action and number, at 50 frames per second, in millimetres. A clip begins at the origin with the
        pelvis upright and facing ahead, for the files do not say how it was: where it was tilted, the world is, by 20
        degrees with one subject.

    Raises
    ------
    TypeError, ValueError
        If a subject is none of the data set's, or there are no clips of it; as `open_root`; and while reading, if a
        file is broken: names the file and the line.
    FileNotFoundError
        If there is no data set.
    """
    data = h36m.open_root(root, cache=cache)
    absent = set(h36m.missing(data))
    clips = []
    for subject in each("subjects", h36m.SUBJECTS if subjects is None else subjects):
        if subject not in h36m.SUBJECTS:
            raise ValueError(f"subjects: expected some of {h36m.SUBJECTS}, got {subject!r}")
        names = [(subject, action, clip) for action in ACTIONS for clip in (1, 2)]
        there = [name for name in names if "S{}/{}_{}.txt".format(*name) not in absent]
        if not there and subjects is not None:
            raise ValueError(f"subjects: {data.folder} has no clips of {subject}")
        clips += there
    return _read(data, clips, progress)


def _read(data: h36m.H36M, clips: list[tuple[int, str, int]], progress: Callable[[float], None]) -> Iterator[Clip]:
    for done, (subject, action, clip) in enumerate(clips, 1):
        positions = joints_of_poses(h36m.load(data, subject, action, clip))
        yield Clip(f"S{subject}/{action}_{clip}", "h36m", f"h36m/S{subject}", action, h36m.FILE_FPS, positions)
        progress(done / len(clips))
