"""Sources of motion: one object per data set, which names its option and reads its files."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import islice
from pathlib import Path
from typing import Any, NamedTuple

from npss.protocol import FPS, Window
from npss.records import Groups
from npss.validation import one_of
from npss_baselines.data.motion import Clip, joints_of_poses
from npss_baselines.data.tasks import N_SEED, N_TARGET, Poses, Task, task_of
from npss_baselines.data.windows import STRIDE, TrainingSet, grid, training_set_of

#: Recordings of each subject that `PoseSource.clips` reads in a quick trial.
QUICK = 2


class Source(ABC):
    """A data set of joint positions: motion for the manifold.

    Attributes
    ----------
    name : str
        The name in configurations and clips: lower-case letters, digits and hyphens.
    description : str
        What the source is, for help and errors: a noun phrase such as ``"the folder of our walks"``.
    generated : bool
        Whether the source needs no files. If so, its option is a flag.
    environment : str
        The environment variable that holds the default folder; empty for none.
    y_up : bool
        Whether y is known to be up. If not, the manifold's preparation estimates the direction.
    test_subjects, validation_subjects : tuple
        Held-out subjects, and subjects on which weights are chosen.
    """

    name: str
    description: str
    generated: bool = False
    environment: str = ""
    y_up: bool = True
    test_subjects: tuple[Any, ...] = ()
    validation_subjects: tuple[Any, ...] = ()

    @property
    def option(self) -> str:
        """The command-line option, without its hyphens; by default, the name."""
        return self.name

    @property
    def vocabulary(self) -> str:
        """The name of the set of labels, shared by sources whose labels are comparable; by default, the name."""
        return self.name

    def subject(self, subject: object) -> str:
        """Return the name of a subject for `Clip.subject`, unique among sources."""
        return f"{self.name}/{subject}"

    def label(self, description: str) -> str:
        """Return the action in a clip's description, ``""`` if none; by default, the description."""
        return description

    @abstractmethod
    def clips(
        self,
        folder: Path,
        *,
        quick: bool = False,
        cache: Path | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> Iterator[Clip]:
        """Read all clips lazily.

        Parameters
        ----------
        folder : Path
            The folder of the data set; unused for generated motion.
        quick : bool, optional
            Read a small part, for a trial.
        cache : Path, optional
            A folder, perhaps missing, to cache files that are faster to read.
        progress : callable, optional
            Called with the share that has been read.
        """


class Recording(NamedTuple):
    """One recording of a `PoseSource`."""

    name: str
    subject: Any
    action: str
    poses: Poses  # (T, 99)


class PoseSource(Source):
    """A data set of poses in the layout of Human3.6M: motion for models to predict, and for the manifold.

    A pose has 99 columns: the displacement and rotation of the root since the previous frame, then the exponential maps
    in radians of the joints of `npss.skeleton.H36M`. A subclass defines the attributes below and `recordings`; it may
    override the windows that follow from them.

    Attributes
    ----------
    actions : tuple of str
        All actions.
    train_subjects : tuple
        Subjects to train on, disjoint from `test_subjects`.
    fps : int
        Frames per second of the recordings, a multiple of 25. Windows are at 25.
    """

    actions: tuple[str, ...]
    train_subjects: tuple[Any, ...] = ()
    fps: int = FPS

    @property
    def default_actions(self) -> tuple[str, ...]:
        """The default actions of evaluation; the first is the default of training."""
        return self.actions

    @property
    def protocols(self) -> tuple[str, ...]:
        """The names of the protocols in signatures; the first is the default."""
        return (f"{self.name}-all",)

    @abstractmethod
    def recordings(
        self, folder: Path, *, actions: Sequence[str], subjects: Sequence[Any], cache: Path | None = None
    ) -> Iterable[Recording]:
        """Read the recordings of some actions and subjects, subject by subject."""

    def training_set(
        self, folder: Path, actions: Sequence[str], *, subjects: Sequence[Any] | None = None, cache: Path | None = None
    ) -> TrainingSet:
        """Read a training set, normalised by the statistics of all frames of the recordings.

        Parameters
        ----------
        folder : Path
            The folder of the data set; unused for generated motion.
        actions : sequence of str
            Actions, in the order of the label.
        subjects : sequence, optional
            Subjects, of `train_subjects`; by default, all.
        cache : Path, optional
            As of `clips`.

        Raises
        ------
        TypeError, ValueError, FileNotFoundError
            As `recordings`; or if the columns that vary differ from those of Human3.6M.
        """
        chosen = self.train_subjects if subjects is None else subjects
        recordings = self.recordings(folder, actions=actions, subjects=chosen, cache=cache)
        clips = ((recording.name, recording.action, recording.poses) for recording in recordings)
        return training_set_of(actions, clips, every=self.fps // FPS)

    def validation_tasks(self, folder: Path, actions: Sequence[str], *, cache: Path | None = None) -> list[Task]:
        """Read the validation windows; by default, those of the validation subjects."""
        clips = {action: self._clips_of(folder, action, self.validation_subjects, cache) for action in actions}
        return [self._task(action, f"{self.name}-validation", clips[action]) for action in actions]

    def held_out_tasks(
        self, folder: Path, actions: Sequence[str], subjects: Sequence[Any], *, cache: Path | None = None
    ) -> list[Task]:
        """Read windows of training subjects that are held out: one at every 25th frame; a clip is a block.

        Raises
        ------
        TypeError, ValueError, FileNotFoundError
            As `recordings`; or if no clip of an action is long enough for a window.
        """
        tasks = []
        for action in actions:
            clips = self._clips_of(folder, action, subjects, cache)
            windows = grid([len(clip) for clip in clips])
            if not windows:
                raise ValueError(f"{self.name}: no clip of {action} is long enough for a window")
            protocol = f"held-out-{'-'.join(map(str, subjects))}-every-{STRIDE}"
            tasks.append(task_of(action, protocol, clips, windows, tuple(window.clip for window in windows)))
        return tasks

    def test_clips(self, folder: Path, action: str, *, cache: Path | None = None) -> list[Poses]:
        """Read the clips ``(T, 99)`` of an action for test windows, at 25 frames per second."""
        return self._clips_of(folder, action, self.test_subjects, cache)

    def windows(self, protocol: str, lengths: Sequence[int]) -> tuple[Window, ...]:
        """Return the windows in clips of some lengths; by default, side by side, with two seconds after each.

        ``npss-baselines sensitivity`` reads the motion after a window.
        """
        length = N_SEED + N_TARGET
        return tuple(
            Window(clip, start, N_SEED, N_TARGET)
            for clip, n_frames in enumerate(lengths)
            for start in range(0, n_frames - length - N_SEED + 1, length)
        )

    def blocks(self, protocol: str, action: str, windows: Sequence[Window]) -> Groups:
        """Return the block of each window; by default, a clip is a block."""
        return tuple(window.clip for window in windows)

    def tasks(
        self,
        folder: Path,
        actions: Sequence[str] = (),
        protocol: str | None = None,
        *,
        cache: Path | None = None,
    ) -> Iterator[Task]:
        """Yield the test windows of some actions.

        Parameters
        ----------
        folder : Path
            The folder of the data set; unused for generated motion.
        actions : sequence of str, optional
            Actions, of `actions`; by default, `default_actions`.
        protocol : str, optional
            Protocol, of `protocols`; by default, the first.
        cache : Path, optional
            As of `clips`.

        Raises
        ------
        TypeError, ValueError, FileNotFoundError
            As `test_clips`; or if the action or protocol is unknown, or no window fits.
        """
        protocol = self.protocols[0] if protocol is None else protocol
        one_of("protocol", protocol, self.protocols)
        for action in actions or self.default_actions:
            one_of("actions", action, self.actions)
            yield self._task(action, protocol, self.test_clips(folder, action, cache=cache))

    def clips(
        self,
        folder: Path,
        *,
        quick: bool = False,
        cache: Path | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> Iterator[Clip]:
        """Compute joint positions from the poses of all subjects; if `quick`, of the first recordings of each."""
        subjects = dict.fromkeys((*self.train_subjects, *self.validation_subjects, *self.test_subjects))
        for done, subject in enumerate(subjects, 1):
            recordings = self.recordings(folder, actions=self.actions, subjects=[subject], cache=cache)
            for name, _, action, poses in islice(recordings, QUICK if quick else None):
                yield Clip(name, self.name, self.subject(subject), action, self.fps, joints_of_poses(poses))
            progress(done / len(subjects))

    def _clips_of(self, folder: Path, action: str, subjects: Sequence[Any], cache: Path | None) -> list[Poses]:
        """Read the recordings of an action, at 25 frames per second."""
        recordings = self.recordings(folder, actions=[action], subjects=subjects, cache=cache)
        return [recording.poses[:: self.fps // FPS] for recording in recordings]

    def _task(self, action: str, protocol: str, clips: Sequence[Poses]) -> Task:
        """Cut clips into windows, in float64, which all reference numbers use."""
        windows = self.windows(protocol, [len(clip) for clip in clips])
        if not windows:
            raise ValueError(f"{self.name}: no clip of {action} is long enough for a window")
        return task_of(action, protocol, clips, windows, self.blocks(protocol, action, windows))
