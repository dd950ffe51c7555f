"""Tasks: the windows of an action, split into seed frames and target frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np
import numpy.typing as npt

from npss.protocol import Window
from npss.records import Groups

N_SEED, N_TARGET = 50, 100

Poses = npt.NDArray[np.floating[Any]]
Precision = TypeVar("Precision", bound=np.floating[Any])


class Task(NamedTuple):
    """The windows of an action: exponential maps at 25 frames per second."""

    action: str
    protocol: str
    seed_frames: Poses  # (N, 50, 99)
    target: Poses  # (N, 100, 99)
    groups: Groups = None  # the block of each window; None if unknown


def task_of(
    action: str,
    protocol: str,
    clips: Sequence[Poses],
    windows: Sequence[Window],
    groups: Groups = None,
) -> Task:
    """Cut windows from clips ``(T, 99)``, in float64, which all reference numbers use."""
    seed_frames, target = cut(clips, windows)
    return Task(action, protocol, seed_frames.astype(np.float64), target.astype(np.float64), groups)


def cut(
    clips: Sequence[npt.NDArray[Precision]], windows: Sequence[Window]
) -> tuple[npt.NDArray[Precision], npt.NDArray[Precision]]:
    """Cut the seed frames and the target frames of windows from clips ``(T, 99)``."""
    seed_frames = np.stack([clips[window.clip][window.seed_frames] for window in windows])
    return seed_frames, np.stack([clips[window.clip][window.target] for window in windows])
