"""Human3.6M as a source: test windows, training recordings, and clips in the common form."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import chain, islice
from pathlib import Path

from npss.protocol import ACTIONS, TEST_SUBJECT, TRAIN_SUBJECTS, Window
from npss.ranking import known_blocks
from npss.records import Groups
from npss.validation import each
from npss_baselines.data import h36m
from npss_baselines.data.motion import Clip, joints_of_poses
from npss_baselines.data.source import QUICK, PoseSource, Recording
from npss_baselines.data.tasks import N_SEED, N_TARGET, Poses, Task, task_of
from npss_baselines.data.windows import STRIDE, validation_windows

#: Subjects to read in a quick trial.
QUICK_SUBJECTS = (1, 5)


class Human36M(PoseSource):
    """A user's copy of Human3.6M."""

    name = "h36m"
    description = "the folder of Human3.6M, with dataset/ in it"
    environment = "NPSS_H36M"
    y_up = False
    actions = ACTIONS
    default_actions = ("walking", "eating", "smoking")
    train_subjects = TRAIN_SUBJECTS
    validation_subjects = (11,)  # for the manifold; models are validated on the test clips, beside the test windows
    test_subjects = (TEST_SUBJECT,)
    fps = h36m.FILE_FPS
    protocols = tuple(h36m.WINDOWS)

    def subject(self, subject: object) -> str:
        """Return the name of a subject, such as ``h36m/S5``."""
        return f"{self.name}/S{subject}"

    def recordings(
        self, folder: Path, *, actions: Sequence[str], subjects: Sequence[int], cache: Path | None = None
    ) -> Iterator[Recording]:
        """Read both clips of every training subject and action."""
        clips = h36m.training_clips(h36m.open_root(folder, cache=cache), actions, subjects=subjects)
        for name, poses in clips.items():  # S1/walking_1.txt
            subject, _, file = name.partition("/")
            yield Recording(name, int(subject[1:]), file.rpartition("_")[0], poses)

    def validation_tasks(self, folder: Path, actions: Sequence[str], *, cache: Path | None = None) -> list[Task]:
        """Read the validation windows of each action: those in the test clips that avoid the test windows.

        Raises
        ------
        TypeError, ValueError, FileNotFoundError
            As `npss_baselines.data.h36m.load_test_clips`; or if an action has no validation window.
        """
        tasks = []
        for action in actions:
            clips = self.test_clips(folder, action, cache=cache)
            windows = validation_windows([len(clip) for clip in clips])
            if not windows:
                raise ValueError(f"actions: the test windows of {action} leave no room for a validation window")
            tasks.append(task_of(action, f"validation-every-{STRIDE}", clips, windows))
        return tasks

    def test_clips(self, folder: Path, action: str, *, cache: Path | None = None) -> list[Poses]:
        """Read the two clips of the test subject."""
        return [*h36m.load_test_clips(h36m.open_root(folder, cache=cache), action)]

    def windows(self, protocol: str, lengths: Sequence[int]) -> tuple[Window, ...]:
        """Return the windows of published tables."""
        return h36m.WINDOWS[protocol](lengths, n_seed=N_SEED, n_target=N_TARGET)

    def blocks(self, protocol: str, action: str, windows: Sequence[Window]) -> Groups:
        """Return the blocks of the protocol, if the lengths of the clips are known."""
        return known_blocks(protocol, action, (len(windows), N_TARGET))

    def clips(
        self,
        folder: Path,
        *,
        quick: bool = False,
        cache: Path | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> Iterator[Clip]:
        """Read the clips in the common form; if `quick`, the first `QUICK` of each of `QUICK_SUBJECTS`."""
        if not quick:
            return h36m_clips(folder, cache=cache, progress=progress)
        each_subject = (h36m_clips(folder, subjects=[subject], cache=cache) for subject in QUICK_SUBJECTS)
        return chain.from_iterable(islice(clips, QUICK) for clips in each_subject)


def h36m_clips(
    root: str | os.PathLike[str],
    *,
    subjects: Iterable[int] | None = None,
    cache: str | os.PathLike[str] | None = None,
    progress: Callable[[float], None] = lambda share: None,
) -> Iterator[Clip]:
    """Read the clips of a copy of Human3.6M lazily.

    Parameters
    ----------
    root : path
        The folder that holds ``dataset``, or ``dataset`` itself.
    subjects : iterable of int, optional
        Subjects to read, of `npss_baselines.data.h36m.SUBJECTS`; by default, all that have files.
    cache : path, optional
        As of `npss_baselines.data.h36m.open_root`.
    progress : callable, optional
        Called with the share that has been read; for example, a `npss.console.Progress`.

    Returns
    -------
    iterator of Clip
        By subject, action and number, at 50 frames per second, in millimetres. A clip starts at the origin with the
        pelvis upright and facing ahead, because the files do not record its initial pose. If it was tilted, the
        world is tilted instead: by 20 degrees for one subject.

    Raises
    ------
    TypeError, ValueError
        If a subject is unknown or has no clips; as `open_root`; or, while reading, if a file is broken: names the file
        and the line.
    FileNotFoundError
        If the data set is missing.
    """
    data = h36m.open_root(root, cache=cache)
    absent = set(h36m.missing(data))
    clips = []
    for subject in each("subjects", h36m.SUBJECTS if subjects is None else subjects):
        if subject not in h36m.SUBJECTS:
            raise ValueError(f"subjects: expected one or more of {h36m.SUBJECTS}, got {subject!r}")
        names = [(subject, action, clip) for action in ACTIONS for clip in (1, 2)]
        present = [name for name in names if "S{}/{}_{}.txt".format(*name) not in absent]
        if not present and subjects is not None:
            raise ValueError(f"subjects: {data.folder} has no clips of {subject}")
        clips += present
    return _read(data, clips, progress)


def _read(data: h36m.H36M, clips: list[tuple[int, str, int]], progress: Callable[[float], None]) -> Iterator[Clip]:
    for done, (subject, action, clip) in enumerate(clips, 1):
        positions = joints_of_poses(h36m.load(data, subject, action, clip))
        yield Clip(f"S{subject}/{action}_{clip}", "h36m", f"h36m/S{subject}", action, h36m.FILE_FPS, positions)
        progress(done / len(clips))
