"""Clips for in-betweening: the local quaternions and the root's path of BVH files of one skeleton."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from npss.inbetweening import Local
from npss.rotations import matrix_to_quaternion
from npss.skeleton import Skeleton
from npss_baselines.data import bvh

_SAME = 1e-4  # the part of a bone's length by which two files of one skeleton may differ


@dataclass(frozen=True)
class Clip:
    """A clip of a BVH file.

    Attributes
    ----------
    path : Path
        The file.
    motion : Local
        Local quaternions ``(T, J, 4)`` and the root's path ``(T, 3)``, in the unit of the file.
    skeleton : Skeleton
        The joints without end sites.
    fps : float
        Frames per second.
    """

    path: Path
    motion: Local
    skeleton: Skeleton
    fps: float


def read_clip(path: str | os.PathLike[str], *, fps: float | None = None) -> Clip:
    """Read a clip.

    Parameters
    ----------
    path : path
        A BVH file.
    fps : float, optional
        Frames per second to keep: every frame, or every second, third ... one.

    Returns
    -------
    Clip
        The clip. Positions of joints other than the root, if a file has any, are not used: bones have fixed lengths.

    Raises
    ------
    OSError, ValueError
        As for `npss_baselines.data.bvh.read`; if the rate of the file is not a multiple of `fps`.
    """
    file = bvh.read(path)
    joints = [j for j, channels in enumerate(file.channels) if channels is not None]
    skeleton = file.skeleton
    own = Skeleton(
        [skeleton.names[j] for j in joints],
        [joints.index(skeleton.parents[j]) if skeleton.parents[j] >= 0 else -1 for j in joints],
        skeleton.offsets[joints],
    )
    every = 1 if fps is None else round(file.fps / fps)
    if fps is not None and (every < 1 or not np.isclose(file.fps, every * fps, rtol=1e-6)):
        raise ValueError(f"{path}: {file.fps:g} frames per second, expected {fps:g} or a multiple")
    motion = Local(matrix_to_quaternion(file.rotations[::every, joints]), file.root[::every])
    return Clip(Path(path), motion, own, file.fps / every)


def read_clips(paths: Iterable[Path], *, like: Clip, fps: float) -> Iterator[Clip]:
    """Read clips of the same skeleton as another, one at a time.

    Parameters
    ----------
    paths : iterable of Path
        BVH files.
    like : Clip
        The clip whose joints they have.
    fps : float
        Frames per second to keep.

    Yields
    ------
    Clip
        Each clip.

    Raises
    ------
    OSError, ValueError
        As for `read_clip`; if a file has other joints.
    """
    for path in paths:
        clip = read_clip(path, fps=fps)
        for what in ("names", "parents"):
            one, other = getattr(clip.skeleton, what), getattr(like.skeleton, what)
            if one != other:
                raise ValueError(f"{path}: its joints are not those of {like.path}: {what} {_difference(one, other)}")
        yield clip


def bones_differ(clip: Clip, like: Clip) -> bool:
    """Return whether two clips of the same joints have bones of other lengths or directions.

    Parameters
    ----------
    clip, like : Clip
        The clips.

    Returns
    -------
    bool
        Whether an offset differs by more than a ten-thousandth of the longest bone; that of the root does not count.
    """
    inside = [j for j, parent in enumerate(like.skeleton.parents) if parent >= 0]
    one, other = clip.skeleton.offsets[inside], like.skeleton.offsets[inside]
    return bool(np.abs(one - other).max(initial=0) > _SAME * np.abs(other).max(initial=0))


def _difference(one: tuple[object, ...], other: tuple[object, ...]) -> str:
    """Return the first difference of two tuples."""
    if len(one) != len(other):
        return f"of {len(one)} joints, not {len(other)}"
    return next(f"{a}, not {b}, at joint {j}" for j, (a, b) in enumerate(zip(one, other, strict=True)) if a != b)
