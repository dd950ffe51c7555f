"""What there is to predict: the test windows of Human3.6M, or a gait that needs no data."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from npss import gait
from npss.ranking import known_blocks
from npss.records import Groups
from npss_baselines.data import h36m

N_SEED, N_TARGET = 50, 100


class Task(NamedTuple):
    """What there is to predict: exponential maps at 25 frames per second."""

    action: str
    protocol: str
    seed_frames: npt.NDArray[np.floating[Any]]  # (N, 50, 99)
    target: npt.NDArray[np.floating[Any]]  # (N, 100, 99)
    groups: Groups = None  # the block of each window: those of one depend on each other; None: not known


def h36m_tasks(
    root: Path, actions: Sequence[str], windows: str = "srnn-8", *, cache: Path | None = None
) -> Iterator[Task]:
    """Yield the test windows of the actions, in the files of Human3.6M below `root`."""
    data = h36m.open_root(root, cache=cache)
    for action in actions:
        seed, target = h36m.load_test_windows(data, action, windows)
        # Reference numbers are computed in float64 throughout.
        groups = known_blocks(windows, action, target.shape)
        yield Task(action, windows, seed.astype(np.float64), target.astype(np.float64), groups)


def synthetic_task(n: int = 64) -> Task:
    """Return `n` windows of a gait generated here; always the same, and independent of each other."""
    poses = gait.gait(n, N_SEED + N_TARGET, seed=0)
    return Task("gait", f"synthetic-{n}", poses[:, :N_SEED], poses[:, N_SEED:], tuple(range(n)))


def add_task_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say what there is to predict."""
    source = parser.add_mutually_exclusive_group()
    h36m.add_option(source)
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="keep the files there in binary, to load faster next time"
    )
    source.add_argument("--synthetic", action="store_true", help="a generated gait, which needs no data")
    parser.add_argument(
        "--actions",
        nargs="+",
        metavar="ACTION",
        help="of Human3.6M (default: walking eating smoking); models come first",
    )
    parser.add_argument(
        "--windows",
        choices=h36m.WINDOWS,
        help="the eight windows of published tables (default), the same one frame later, or 256 random ones",
    )


def tasks_of(options: argparse.Namespace) -> Iterator[Task]:
    """Return the tasks that the options ask for."""
    if options.synthetic:
        if options.actions or options.windows:
            raise ValueError("--synthetic has one action and its own windows: leave out --actions and --windows")
        return iter([synthetic_task()])
    if options.h36m is None:
        raise ValueError("--h36m DIR names the folder of Human3.6M; --synthetic needs no data")
    actions = options.actions or ("walking", "eating", "smoking")
    return h36m_tasks(Path(options.h36m), actions, options.windows or h36m.WINDOWS[0], cache=options.cache)
