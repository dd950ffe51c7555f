"""Tasks: the windows of an action, split into seed frames and target frames."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from npss.protocol import Window
from npss.records import Groups

N_SEED, N_TARGET = 50, 100


class Task(NamedTuple):
    """The windows of an action: exponential maps at 25 frames per second."""

    action: str
    protocol: str
    seed_frames: npt.NDArray[np.floating[Any]]  # (N, 50, 99)
    target: npt.NDArray[np.floating[Any]]  # (N, 100, 99)
    groups: Groups = None  # the block of each window; None if unknown


def task_of(
    action: str,
    protocol: str,
    clips: Sequence[npt.NDArray[np.floating[Any]]],
    windows: Sequence[Window],
    groups: Groups = None,
) -> Task:
    """Cut windows from clips ``(T, 99)``, in float64, which all reference numbers use."""
    seed = np.stack([clips[window.clip][window.seed_frames] for window in windows]).astype(np.float64)
    target = np.stack([clips[window.clip][window.target] for window in windows]).astype(np.float64)
    return Task(action, protocol, seed, target, groups)
