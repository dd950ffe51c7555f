"""The options that name a source of motion, and what is to be predicted of it: those that registered sources have."""

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
    """Add an option for the folder of each source that has one, which is by default that of its environment variable.

    Without `environment`, it has no default.
    """
    for source in sources:
        if not source.generated:
            variable = source.environment if environment else ""
            default = f" (default: the environment variable {variable})" if variable else ""
            parser.add_argument(
                f"--{source.option}", dest=source.option, type=Path, metavar="DIR", help=source.description + default
            )


def folders_of(options: argparse.Namespace) -> dict[str, Path]:
    """Return the folders that options name, by the names of their sources."""
    folders = {name: getattr(options, source.option, None) for name, source in SOURCES.items() if not source.generated}
    return {name: folder for name, folder in folders.items() if folder is not None}


def from_environment(source: Source) -> Path | None:
    """Return the folder that the environment variable of a source names."""
    named = os.environ.get(source.environment) if source.environment else None
    return Path(named) if named else None


def add_pose_source(parser: argparse.ArgumentParser) -> None:
    """Add the options of sources that models can predict, of which one is chosen."""
    sources = pose_sources().values()
    group = parser.add_mutually_exclusive_group()
    add_folder_options(group, sources)
    for source in sources:
        if source.generated:
            group.add_argument(f"--{source.option}", dest=source.option, action="store_true", help=source.description)


def pose_source_of(options: argparse.Namespace, default: str | None = None) -> tuple[PoseSource, Path]:
    """Return the source that an option names, and its folder.

    Parameters
    ----------
    options : Namespace
        As `add_pose_source` has added them.
    default : str, optional
        The source where no option names one; by default, the first whose environment variable is set.

    Raises
    ------
    ValueError
        If none is named: lists the options.
    """
    sources = pose_sources()
    for source in sources.values():
        if named := getattr(options, source.option):
            return source, Path() if source.generated else named
    for source in sources.values() if default is None else [sources[default]]:
        if default is not None and source.generated:
            return source, Path()
        if (folder := from_environment(source)) is not None:
            return source, folder
    raise ValueError(needs(sources.values()))


def needs(sources: Iterable[Source], generated: str = "--") -> str:
    """Say which options name motion; those of generated motion begin with `generated`."""
    return "; ".join(
        f"{generated}{source.option} is {source.description}"
        if source.generated
        else f"--{source.option} DIR names {source.description}"
        for source in sources
    )


def add_task_options(parser: argparse.ArgumentParser) -> None:
    """Add the options that say what there is to predict."""
    sources = pose_sources().values()
    add_pose_source(parser)
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="keep the files there in binary, to load faster next time"
    )
    defaults = "; ".join(f"{source.name}: {' '.join(source.default_actions)}" for source in sources)
    parser.add_argument("--actions", nargs="+", metavar="ACTION", help=f"default: {defaults}; models come first")
    parser.add_argument(
        "--windows",
        choices=[protocol for source in sources for protocol in source.protocols],
        help="of Human3.6M, the eight windows of published tables (default), the same one frame later, or 256 random "
        "ones; of each source, by default the first of its own",
    )


def tasks_of(options: argparse.Namespace) -> Iterator[Task]:
    """Return the tasks that the options ask for."""
    source, folder = pose_source_of(options)
    return source.tasks(folder, options.actions or (), options.windows, cache=options.cache)
