"""``npss-baselines train manifold``: train the motion manifold."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import asdict, replace
from pathlib import Path
from typing import TypeVar

from npss.console import Parser, add_plugin
from npss_baselines.commands.sources import add_folder_options, folders_of
from npss_baselines.commands.train_options import file_of, options_of, refuse_changes, unrecorded_arguments
from npss_baselines.data import SOURCES
from npss_baselines.manifold.model.projector import Projector
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.features import local_positions
from npss_baselines.manifold.motion.measures import joint_error
from npss_baselines.manifold.motion.prepared import motion_set
from npss_baselines.manifold.motion.split import split, subjects_of
from npss_baselines.manifold.training import config, folder, trainer
from npss_baselines.manifold.training.config import FILE, Configuration
from npss_baselines.manifold.training.recipe import RECIPES
from npss_baselines.runs import launch, weights
from npss_baselines.runs.config import paths_of

AnyParser = TypeVar("AnyParser", bound=argparse.ArgumentParser)


def run(arguments: Sequence[str], command: Parser | None = None) -> None:
    """Train, and print the results.

    Parameters
    ----------
    arguments : sequence of str
        Arguments after ``train manifold``.
    command : Parser, optional
        The parser of the command, which names these options in errors.

    Raises
    ------
    TypeError, ValueError, FileNotFoundError
        If an argument, a file or the motion is invalid.
    """
    configuration, options = parse(arguments, command)
    device = launch.device_of(options.device)
    before = launch.existing_runs([options.out])
    threads = launch.threads_of(options.threads, before)
    folders, recorded_in = _folders(options)
    with ExitStack() as stack:
        for name, root in folders.items():
            stack.enter_context(launch.explain_missing_data(SOURCES[name].option, root, recorded_in.get(name)))
        motion = motion_set(folders, cache=options.cache, quick=configuration.quick)
    training_set, validation_set, test_set = split(motion)
    data = config.data_of(training_set)
    if configuration.data.digest not in ("", data.digest):
        raise ValueError(
            f"--resume: {options.out / FILE} was trained on other windows: {_described(configuration.data)}, not "
            f"{_described(data)}"
        )
    configuration = replace(configuration, data=data)
    print(
        f"training on {_described(data)} of {len(subjects_of(training_set))} subjects; validating on "
        f"{len(validation_set.windows)} windows of {', '.join(subjects_of(validation_set))}",
        flush=True,
    )
    resume = ["train", "manifold", "--resume", "--out", str(options.out), *unrecorded_arguments(options)]
    with (
        launch.use_threads(threads),
        launch.explain_resuming([options.out], resume),
        launch.exclusive_folders(options.out, [options.out], before),
    ):
        paths = {SOURCES[name].option: root for name, root in folders.items()}
        plugins = {SOURCES.plugin(name) for name in folders} - {None}
        config.write(options.out / FILE, configuration, device, paths, sorted(map(str, plugins)))
        rows = trainer.train(
            configuration, training_set, validation_set, options.out, device=device, tensorboard=options.tensorboard
        )
    kept = trainer.best(rows, configuration.select)
    print(
        f"{options.out / weights.FILE}: weights of epoch {kept['epoch']} of {rows[-1]['epoch']}, joint error "
        f"{kept['error']:.4f} body heights on validation windows"
    )
    if test_set is not None:
        projector = folder.load(options.out).projector
        error = error_of(projector, test_set)
        print(f"joint error {error:.4f} body heights on windows of {', '.join(subjects_of(test_set))}")
        print(f"    {projector.signature}")


def parse(arguments: Sequence[str], command: Parser | None = None) -> tuple[Configuration, argparse.Namespace]:
    """Parse arguments; the configuration of a resumed run, or of ``--config``, replaces the recipe.

    Parameters
    ----------
    arguments, command
        As of `run`.

    Returns
    -------
    configuration : Configuration
        The configuration of the run, with data only if the run is resumed.
    options : Namespace
        Other options: ``out``, ``resume``, ``cache``, ``device``, ``threads``, ``tensorboard``, and the folders of
        sources.

    Raises
    ------
    TypeError, ValueError
        If an argument is unknown or invalid. The message lists valid ones.
    """
    if {"-h", "--help"} & set(arguments):
        _add_options(config.parser_of(config.defaults())).print_help()
        raise SystemExit(0)
    options, rest = options_of(arguments, _add_options, command)
    file = file_of(options)
    if file is not None and options.recipe is not None:
        raise ValueError(f"--recipe: conflicts with {file}, which states the recipe's settings")
    base = stored = config.defaults(options.recipe or "default") if file is None else config.read(file)
    if options.depth is not None:
        if options.depth > base.model.depth:
            raise ValueError(f"--depth: expected at most {base.model.depth} layers, got {options.depth}")
        base = replace(base, model=replace(base.model, widths=base.model.widths[: options.depth]))
    if options.quick:
        base = config.quick(base)
    resumed = file is not None and file == options.out / FILE
    if not resumed:
        base = replace(base, data=config.Data())
    reader = config.parser_of(base)
    if command is not None:
        command.also_reads(reader)
    configuration = config.configuration_of(base, reader, lambda: reader.parse_args(rest))
    if file is not None and resumed:
        refuse_changes(file, asdict(stored), asdict(configuration))
    return configuration, options


def _folders(options: argparse.Namespace) -> tuple[dict[str, Path], dict[str, Path]]:
    """Return the folders of sources by name, and the files that state those without an option.

    For a resumed run, an option replaces that folder only. For the ``--config`` of another run, its folders count only
    if no option names a folder.
    """
    named = folders_of(options)
    file = file_of(options)
    if file is None or (named and file != options.out / FILE):
        return named, {}
    paths = paths_of(file)
    recorded = {name: paths[source.option] for name, source in SOURCES.items() if source.option in paths}
    return recorded | named, {name: file for name in recorded if name not in named}


def error_of(projector: Projector, motion: MotionSet) -> float:
    """Return the joint error of a set's projected windows, in body heights."""
    projected = local_positions(projector.project(motion.windows))
    return joint_error(local_positions(motion.windows), projected, motion.mask)


def _described(data: config.Data) -> str:
    return f"{data.windows} windows of {data.clips} clips ({', '.join(data.sources)})"


def _add_options(parser: AnyParser) -> AnyParser:
    """Add the options that are not fields of the configuration."""
    parser.add_argument("--out", type=Path, metavar="RUN", help="write the run to this folder, created if missing")
    add_folder_options(parser, SOURCES.values(), environment=False)
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="cache prepared motion in this folder, to load it faster"
    )
    parser.add_argument(
        "--quick", action="store_true", help="use a small part of the data and few epochs, to try things out"
    )
    parser.add_argument(
        "--recipe", choices=tuple(RECIPES), help="start from the settings of this recipe (default: default)"
    )
    parser.add_argument("--depth", type=int, choices=(1, 2, 3), metavar="N", help="train N layers, 1 to 3 (default: 3)")
    parser.add_argument("--config", type=Path, metavar="FILE", help=f"start from this configuration, a {FILE}")
    parser.add_argument("--resume", action="store_true", help="resume an interrupted run, or start it")
    launch.add_device(parser)
    launch.add_threads(parser)
    add_plugin(parser)
    parser.add_argument("--tensorboard", action="store_true", help="also write TensorBoard logs")
    return parser
