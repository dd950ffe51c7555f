"""The options that choose a source of motion and the tasks to predict, for every registered source."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterable, Iterator
from pathlib import Path

from npss_baselines.data import SOURCES, PoseSource, Source, pose_sources
from npss_baselines.data.tasks import Task


def add_folder_options(
    parser: argparse._ActionsContainer, sources: Iterable[Source], *, environment: bool = True
) -> None:
    """Add an option for the folder of each source that has one.

    Its default is the source's environment variable; without `environment`, it has none.
    """
    for source in sources:
        if not source.generated:
            variable = source.environment if environment else ""
            default = f" (default: the environment variable {variable})" if variable else ""
            parser.add_argument(
                f"--{source.option}",
                dest=source.option,
                type=Path,
                metavar="DIR",
                help=f"read {source.description}{default}",
            )


def folders_of(options: argparse.Namespace) -> dict[str, Path]:
    """Return the folders in the options, by the names of their sources."""
    folders = {name: getattr(options, source.option, None) for name, source in SOURCES.items() if not source.generated}
    return {name: folder for name, folder in folders.items() if folder is not None}


def from_environment(source: Source) -> Path | None:
    """Return the folder in a source's environment variable, if set."""
    folder = os.environ.get(source.environment) if source.environment else None
    return Path(folder) if folder else None


def add_pose_source(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose one of the sources that models can predict."""
    sources = pose_sources().values()
    group = parser.add_mutually_exclusive_group()
    add_folder_options(group, sources)
    for source in sources:
        if source.generated:
            group.add_argument(
                f"--{source.option}", dest=source.option, action="store_true", help=f"use {source.description}"
            )


def pose_source_of(options: argparse.Namespace, default: str | None = None) -> tuple[PoseSource, Path]:
    """Return the source that an option chooses, and its folder.

    Parameters
    ----------
    options : Namespace
        With those of `add_pose_source`.
    default : str, optional
        The source if no option chooses one; by default, the first whose environment variable is set.

    Raises
    ------
    ValueError
        If no source is chosen; lists the options.
    """
    sources = pose_sources()
    for source in sources.values():
        if folder := getattr(options, source.option):
            return source, Path() if source.generated else folder
    for source in sources.values() if default is None else [sources[default]]:
        if default is not None and source.generated:
            return source, Path()
        if (root := from_environment(source)) is not None:
            return source, root
    raise ValueError(needs(sources.values()))


def needs(sources: Iterable[Source], generated: str = "--") -> str:
    """Return an error text that lists the options for motion; `generated` is the prefix for generated motion."""
    options = (
        f"{generated}{source.option}" if source.generated else f"--{source.option} DIR ({source.description})"
        for source in sources
    )
    return f"no source of motion: give {' or '.join(options)}"


def add_task_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that choose the tasks to predict."""
    sources = pose_sources().values()
    add_pose_source(parser)
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="cache parsed files in this folder, to load them faster"
    )
    defaults = "; ".join(f"{source.name}: {' '.join(source.default_actions)}" for source in sources)
    parser.add_argument(
        "--actions",
        nargs="+",
        metavar="ACTION",
        help=f"predict these actions (default: {defaults})",
    )
    parser.add_argument(
        "--windows",
        dest="protocol",
        choices=[protocol for source in sources for protocol in source.protocols],
        help="choose the test windows; of Human3.6M, srnn-8: the eight of published tables; srnn-8-late: the same, one "
        "frame later; random-256: 256 random ones (default: the source's first)",
    )


def tasks_of(options: argparse.Namespace) -> Iterator[Task]:
    """Return the tasks that the options choose."""
    source, folder = pose_source_of(options)
    return source.tasks(folder, options.actions or (), options.protocol, cache=options.cache)
