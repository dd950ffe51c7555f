"""Tasks: the windows of an action, split into seed frames and target frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from npss.protocol import Window
from npss.records import Groups

N_SEED, N_TARGET = 50, 100

Poses = npt.NDArray[np.floating[Any]]


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
    seed_frames = np.stack([clips[window.clip][window.seed_frames] for window in windows])
    target = np.stack([clips[window.clip][window.target] for window in windows])
    return Task(action, protocol, seed_frames.astype(np.float64), target.astype(np.float64), groups)
