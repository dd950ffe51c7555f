"""The training motion that predictors are fitted to, and the windows cut from it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from npss.protocol import FPS
from npss.validation import one_of
from npss_baselines.data import PoseSource, Recording
from npss_baselines.data.tasks import N_SEED, N_TARGET
from npss_baselines.fitted.angles import ANGLES, angles_of

Float32 = npt.NDArray[np.float32]
LENGTH = N_SEED + N_TARGET
#: Frames between the starts of two windows to fit, at 25 frames per second.
STRIDE = 10
_TURN = np.pi  # a larger step of an angle from one frame to the next is a jump by a whole turn


class FittingClip(NamedTuple):
    """The angles of one recording, in radians."""

    action: str
    group: Any  # the subject, or the name of the recording where the source has no subjects
    angles: Float32  # (T, 48), in the source's frames per second
    step: int  # frames of it in one frame at 25 frames per second


class Windows(NamedTuple):
    """Windows at 25 frames per second, without jumps of a whole turn."""

    seed: Float32  # (N, 50, 48)
    target: Float32  # (N, 100, 48)
    action: npt.NDArray[np.intp]  # (N,), index of the action
    group: npt.NDArray[np.intp]  # (N,), index of the group


@dataclass(frozen=True)
class Motion:
    """Clips of the actions to predict, and perhaps of others.

    Attributes
    ----------
    actions : tuple of str
        The actions to predict, then the others.
    n_predicted : int
        The number of actions to predict.
    clips : tuple of FittingClip
        The clips.
    """

    actions: tuple[str, ...]
    n_predicted: int
    clips: tuple[FittingClip, ...]

    @property
    def groups(self) -> tuple[Any, ...]:
        """The groups of clips, to hold out in turn."""
        return tuple(dict.fromkeys(clip.group for clip in self.clips))

    def of(self, *, actions: Sequence[str] | None = None, without: Iterable[Any] = ()) -> Motion:
        """Return the clips of some actions to predict, without some groups."""
        left_out = set(without)
        kept = self.actions if actions is None else tuple(actions)
        clips = tuple(clip for clip in self.clips if clip.group not in left_out and clip.action in kept)
        return Motion(kept, self.n_predicted if actions is None else len(kept), clips)

    def windows(self, *, stride: int = STRIDE) -> Windows:
        """Cut windows from all clips; jumps of a whole turn, which say nothing about the motion, are left out.

        Raises
        ------
        ValueError
            If there is none.
        """
        kept, action, group = [], [], []
        groups = self.groups
        for clip in self.clips:
            windows = np.array([*_cut(clip, stride)], np.float32).reshape(-1, LENGTH, len(ANGLES))
            smooth = (np.abs(np.diff(windows, axis=1)) <= _TURN).all(axis=(1, 2))
            kept.append(windows[smooth])
            action += [self.actions.index(clip.action)] * int(smooth.sum())
            group += [groups.index(clip.group)] * int(smooth.sum())
        if not action:
            raise ValueError(f"no window of {LENGTH} frames without a jump of a whole turn to fit to")
        windows = np.concatenate(kept)
        return Windows(windows[:, :N_SEED], windows[:, N_SEED:], np.array(action), np.array(group))


def read_motion(
    source: PoseSource,
    folder: Path,
    actions: Sequence[str],
    *,
    subjects: Sequence[Any] | Mapping[str, Sequence[Any]] | None = None,
    others: bool = False,
    cache: Path | None = None,
) -> tuple[Motion, dict[str, tuple[Any, ...]]]:
    """Read the training recordings of some actions.

    Parameters
    ----------
    source : PoseSource
        The source of motion.
    folder : Path
        The folder of the data set; unused for generated motion.
    actions : sequence of str
        The actions to predict, of ``source.actions``.
    subjects : sequence or dict of str to sequence, optional
        Training subjects, all of whose recordings of these actions must be there; by default, for each action, the
        training subjects whose recordings are. A dict names them for each action, and all of them must be there.
    others : bool, optional
        Whether to read the source's other actions, too: those that a dict names, or else as far as the recordings of
        these subjects are there.
    cache : Path, optional
        As of ``source.recordings``.

    Returns
    -------
    motion : Motion
        The motion.
    read : dict of str to tuple
        The subjects that were read, by action.

    Raises
    ------
    TypeError, ValueError, FileNotFoundError
        As ``source.recordings``; or if an action or a subject is unknown, or no subject has an action to predict.
    """
    for action in actions:
        one_of("actions", action, source.actions)
    if not actions or len(set(actions)) < len(actions):
        raise ValueError(f"actions: expected one or more, without duplicates, got {', '.join(actions) or 'none'}")
    if isinstance(subjects, Mapping) and (missing := [action for action in actions if action not in subjects]):
        raise ValueError(f"subjects: expected those of {', '.join(actions)}, got none of {', '.join(missing)}")
    clips: list[FittingClip] = []
    read: dict[str, tuple[Any, ...]] = {}
    more = tuple(action for action in source.actions if action not in actions) if others else ()
    for action in (*actions, *more):
        if isinstance(subjects, Mapping) and action not in subjects:
            continue
        chosen = _checked(source, subjects[action] if isinstance(subjects, Mapping) else subjects)
        required = isinstance(subjects, Mapping) or (subjects is not None and action in actions)
        there = []
        for subject in chosen or (None,):
            of_subject = () if subject is None else (subject,)
            try:
                recordings = [*source.recordings(folder, actions=[action], subjects=of_subject, cache=cache)]
            except FileNotFoundError as error:
                if required or "lacks" not in str(error):
                    raise
                continue
            clips += [_clip(recording, source.fps // FPS) for recording in recordings]
            there.append(subject)
        if not there and action in actions:
            raise FileNotFoundError(f"{folder}: no training subject has all recordings of {action}")
        if there:
            read[action] = tuple(subject for subject in there if subject is not None)
    return Motion(tuple(read), len(actions), tuple(clips)), read


def _checked(source: PoseSource, subjects: Sequence[Any] | None) -> tuple[Any, ...]:
    """Return training subjects, or raise."""
    chosen = source.train_subjects if subjects is None else tuple(subjects)
    if not set(chosen) <= set(source.train_subjects) or len(set(chosen)) < len(chosen):
        raise ValueError(
            f"subjects: expected some of {', '.join(map(str, source.train_subjects)) or 'none'}, without duplicates; "
            f"got {', '.join(map(str, chosen))}"
        )
    return chosen


def folds(groups: Sequence[Any], n: int = 3) -> list[tuple[Any, ...]]:
    """Split groups into `n` folds, or fewer if there are fewer groups: neighbours together.

    Examples
    --------
    >>> folds([1, 6, 7, 8, 9, 11])
    [(1, 6), (7, 8), (9, 11)]
    """
    edges = [len(groups) * i // min(n, len(groups)) for i in range(min(n, len(groups)) + 1)]
    return [tuple(groups[start:stop]) for start, stop in pairwise(edges)]


def _clip(recording: Recording, step: int) -> FittingClip:
    group = recording.subject if recording.subject not in ("", None) else recording.name
    return FittingClip(recording.action, group, angles_of(recording.poses).astype(np.float32), step)


def _cut(clip: FittingClip, stride: int) -> Iterator[Float32]:
    span = (LENGTH - 1) * clip.step + 1
    for start in range(0, len(clip.angles) - span + 1, stride * clip.step):
        yield clip.angles[start : start + span : clip.step]
