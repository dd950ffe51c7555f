"""Generated walks as a source that needs no data."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

import numpy as np

from npss.gait import gait
from npss.validation import positive_integer
from npss_baselines.data.motion import Clip, joints_of_poses
from npss_baselines.data.source import PoseSource, Recording
from npss_baselines.data.tasks import N_SEED, N_TARGET, Poses, Task
from npss_baselines.data.windows import TrainingSet, training_set_of

#: The only action.
GAIT = "gait"


class Synthetic(PoseSource):
    """A generated gait, always the same.

    Parameters
    ----------
    n : int
        Number of walkers in the test set.
    """

    name = "synthetic"
    description = "a generated gait, which needs no data"
    generated = True
    actions = (GAIT,)
    validation_subjects = (2, 3)  # for the manifold, like those below
    test_subjects = (0, 1)

    def __init__(self, n: int = 64) -> None:
        self.n = positive_integer("n", n)

    @property
    def protocols(self) -> tuple[str, ...]:
        """One window of each walker: ``synthetic-64``."""
        return (f"synthetic-{self.n}",)

    def recordings(
        self, folder: Path, *, actions: Sequence[str], subjects: Sequence[object], cache: Path | None = None
    ) -> Iterator[Recording]:
        """Generate the walkers of the training set, without names."""
        return synthetic_recordings()

    def validation_tasks(self, folder: Path, actions: Sequence[str], *, cache: Path | None = None) -> list[Task]:
        """Generate the 16 walkers of the validation set."""
        return synthetic_validation()

    def test_clips(self, folder: Path, action: str, *, cache: Path | None = None) -> list[Poses]:
        """Generate the walkers of the test set: one window each, and two more seconds."""
        return [*gait(self.n, N_SEED + N_TARGET + N_SEED, seed=0)]

    def clips(
        self,
        folder: Path,
        *,
        quick: bool = False,
        cache: Path | None = None,
        progress: Callable[[float], None] = lambda share: None,
    ) -> Iterator[Clip]:
        """Generate 32 walks of 500 frames; if `quick`, 8."""
        return synthetic_clips(8 if quick else 32, 500, seed=0)


def synthetic_task(n: int = 64) -> Task:
    """Generate `n` independent test windows; always the same."""
    return next(Synthetic(n).tasks(Path()))


def synthetic_recordings(n: int = 32, n_frames: int = 500) -> Iterator[Recording]:
    """Generate `n` walkers to train on; always the same, and in no other set."""
    for i, walk in enumerate(gait(n, n_frames, seed=1)):
        yield Recording(f"{GAIT}_{i}", "", GAIT, walk)


def synthetic_training_set(n: int = 32, n_frames: int = 500) -> TrainingSet:
    """Return the training set of `synthetic_recordings`."""
    recordings = synthetic_recordings(n, n_frames)
    return training_set_of([GAIT], ((recording.name, recording.action, recording.poses) for recording in recordings))


def synthetic_validation(n: int = 16) -> list[Task]:
    """Generate `n` walkers to validate on; always the same, and in no other set."""
    walks = gait(n, N_SEED + N_TARGET, seed=2)
    return [Task(GAIT, f"synthetic-validation-{n}", walks[:, :N_SEED], walks[:, N_SEED:])]


def synthetic_clips(n: int, n_frames: int, seed: int, *, fps: float = 30.0) -> Iterator[Clip]:
    """Generate walks along winding paths, each by another walker.

    Parameters
    ----------
    n : int
        Number of clips. The first clips do not depend on it.
    n_frames : int
        Number of frames of each clip.
    seed : int
        Seed of the random generator.
    fps : float, optional
        Frames per second.

    Yields
    ------
    Clip
        ``gait/0``, ``gait/1``, ..., in millimetres; the ground, y = 0, is the lowest position of a foot. Feet slide.

    Raises
    ------
    TypeError, ValueError
        If a number is not positive; the seed may be 0.

    Examples
    --------
    >>> clip = next(synthetic_clips(1, 200, seed=0))
    >>> clip.name, clip.subject, clip.positions.shape
    ('gait/0', 'synthetic/0', (200, 20, 3))
    """
    for walker in range(positive_integer("n", n)):
        poses = gait(1, n_frames, fps=fps, seed=np.random.default_rng([seed, walker]))[0]
        # Sideways and vertical displacements and rotations of the root have a mean: it would drift and tumble.
        poses[:, [0, 1, 3, 5]] = 0
        poses[:, 4] /= 3  # radians per frame: the path bends, the walker does not spin
        positions = joints_of_poses(poses)
        positions[..., 1] -= positions[..., 1].min()
        yield Clip(f"gait/{walker}", "synthetic", f"synthetic/{walker}", "gait", fps, positions)
