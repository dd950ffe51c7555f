"""Training batches and validation windows, without test frames."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from npss.protocol import COLUMNS, FPS, Normalization, Window, normalization, srnn_windows
from npss.validation import Array, is_integer, one_of, positive_integer
from npss_baselines.data.tasks import N_SEED, N_TARGET

Float32 = npt.NDArray[np.float32]

#: The first frame that a window may start at: the field leaves out earlier frames.
FIRST = 16
#: Frames between the starts of two validation windows.
STRIDE = 25
_SEEDS = 2**32  # seeds are below it, so that no two share batches


class TrainingClip(NamedTuple):
    """One recording, normalised, at 25 frames per second."""

    name: str
    action: int  # index of the action in the training set
    poses: Float32  # (T, 54)


@dataclass(frozen=True)
class TrainingSet:
    """The clips that a model is trained on.

    Attributes
    ----------
    actions : tuple of str
        The actions, in the order of the label.
    clips : tuple of TrainingClip
        All clips of all actions.
    normalization : Normalization
        The normalisation of their poses.
    """

    actions: tuple[str, ...]
    clips: tuple[TrainingClip, ...]
    normalization: Normalization


class Batch(NamedTuple):
    """A batch of training windows."""

    poses: Float32  # (B, n_seed + n_target + 1, 54)
    label: Float32  # (B, A), one-hot


class Batches:
    """The batches of a run: batch i is a function of the seed and i alone.

    Windows are drawn as in the code of the NPSS paper: the clip uniformly, regardless of its length, with replacement;
    the first frame uniformly from 16 to T - n_seed - n_target - 1, the last that fits.

    Parameters
    ----------
    training_set : TrainingSet
        The clips to cut windows from.
    batch : int
        Number of windows in a batch.
    n_seed, n_target : int
        Numbers of seed frames and of target frames; a window has one frame more, the target of the last step.
    seed : int
        Seed of the batches, from 0 to 2**32 - 1.

    Raises
    ------
    TypeError
        If a number is not an integer.
    ValueError
        If a number is out of range, or a clip is too short for a window; names the clip.
    """

    def __init__(self, training_set: TrainingSet, *, batch: int, n_seed: int, n_target: int, seed: int) -> None:
        self._clips = training_set.clips
        self._batch = positive_integer("batch", batch)
        self._window = positive_integer("n_seed", n_seed) + positive_integer("n_target", n_target) + 1
        self._seed = checked_seed(seed)
        self._labels = np.eye(len(training_set.actions), dtype=np.float32)
        #: Exclusive ends of the ranges of first frames.
        self._ends = np.array([len(clip.poses) - self._window + 1 for clip in self._clips])
        for clip, end in zip(self._clips, self._ends, strict=True):
            if end <= FIRST:
                raise ValueError(
                    f"clips: {clip.name} has {len(clip.poses)} frames at {FPS} frames per second; windows of "
                    f"{self._window} frames, from frame {FIRST} on, need at least {FIRST + self._window}"
                )

    def __getitem__(self, iteration: int) -> Batch:
        """Return the batch of an iteration."""
        rng = np.random.default_rng([self._seed, iteration])
        chosen = rng.integers(len(self._clips), size=self._batch)
        starts = rng.integers(FIRST, self._ends[chosen])
        clips = [self._clips[i] for i in chosen]
        poses = [clip.poses[start : start + self._window] for clip, start in zip(clips, starts, strict=True)]
        return Batch(np.stack(poses), self._labels[[clip.action for clip in clips]])


def checked_seed(seed: object) -> int:
    """Check a seed: an integer from 0 to 2**32 - 1."""
    if not is_integer(seed):
        raise TypeError(f"seed: expected an integer, got {seed!r}")
    if not 0 <= seed < _SEEDS:
        raise ValueError(f"seed: expected an integer from 0 to 2**32 - 1, got {seed}")
    return int(seed)


def digest(training_set: TrainingSet) -> str:
    """Return a digest of every bit of the clips."""
    result = hashlib.sha256()
    for clip in training_set.clips:
        result.update(f"{clip.name} {clip.action} {clip.poses.shape} ".encode())
        result.update(np.ascontiguousarray(clip.poses).data)
    return result.hexdigest()


def training_set_of(
    actions: Sequence[str], recordings: Iterable[tuple[str, str, Array]], *, every: int = 1
) -> TrainingSet:
    """Normalise recordings by the statistics of all their frames, and keep each `every`-th frame.

    Parameters
    ----------
    actions : sequence of str
        Actions, in the order of the label.
    recordings : iterable of (str, str, (T, 99) ndarray)
        Name, action and poses of each recording.
    every : int, optional
        Step between the frames to keep; by default, all are kept.

    Raises
    ------
    ValueError
        If the columns that vary differ from those of Human3.6M, or a recording is of another action.
    """
    recordings = list(recordings)
    statistics = normalization(poses for _, _, poses in recordings)
    if statistics.columns != COLUMNS:
        constant = sorted(set(COLUMNS) - set(statistics.columns))
        others = sorted(set(statistics.columns) - set(COLUMNS))
        faults = [f"column {constant[0]} does not vary; train on more subjects or actions"] if constant else []
        faults += [f"column {others[0]} varies, but models do not read it"] if others else []
        raise ValueError(f"clips: models read the {len(COLUMNS)} columns npss.protocol.COLUMNS: {'; '.join(faults)}")
    clips = []
    for name, action, poses in recordings:
        one_of(f"{name}: action", action, tuple(actions))
        clips.append(TrainingClip(name, actions.index(action), statistics.normalize(poses[::every]).astype(np.float32)))
    return TrainingSet(tuple(actions), tuple(clips), statistics)


def validation_windows(lengths: Sequence[int]) -> tuple[Window, ...]:
    """Return the windows on a regular grid in the test subject's two clips that avoid all test windows.

    They share no frame with the eight windows or with the late ones.

    Parameters
    ----------
    lengths : sequence of int
        Lengths of the two clips in frames, at 25 frames per second.

    Returns
    -------
    tuple of Window
        Windows of 50 + 100 frames, like those of `npss.protocol.srnn_windows`.

    Raises
    ------
    TypeError, ValueError
        As `npss.protocol.srnn_windows`.

    Examples
    --------
    >>> windows = validation_windows((1500, 1261))  # walking
    >>> len(windows), windows[0]
    (28, Window(clip=0, start=16, n_seed=50, n_target=100))
    """
    eight, late = (srnn_windows(lengths, n_seed=N_SEED, n_target=N_TARGET, late=late) for late in (False, True))
    return tuple(window for window in grid(lengths) if not any(_overlap(window, test) for test in eight + late))


def grid(lengths: Sequence[int]) -> tuple[Window, ...]:
    """Return the windows of 50 + 100 frames that start at every 25th frame of clips, from frame 16 on.

    Examples
    --------
    >>> [window.start for window in grid((200, 150, 191))]
    [16, 41, 16, 41]
    """
    return tuple(
        Window(clip, start, N_SEED, N_TARGET)
        for clip, length in enumerate(lengths)
        for start in range(FIRST, length - N_SEED - N_TARGET + 1, STRIDE)
    )


def _overlap(first: Window, second: Window) -> bool:
    return first.clip == second.clip and first.start < second.target.stop and second.start < first.target.stop
