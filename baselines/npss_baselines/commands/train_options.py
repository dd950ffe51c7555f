"""The options of ``npss-baselines train``."""

from __future__ import annotations

import argparse
from collections.abc import Callable, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TypeVar

from npss.console import Parser, add_plugin
from npss.validation import one_of
from npss_baselines.commands.sources import add_folder_options, folders_of, from_environment
from npss_baselines.data import Source, pose_sources
from npss_baselines.fitted import FITTED
from npss_baselines.models import MODELS
from npss_baselines.runs import config, launch
from npss_baselines.runs.config import CHECKPOINT, FILE, Configuration

AnyParser = TypeVar("AnyParser", bound=argparse.ArgumentParser)


def parse(arguments: Sequence[str], command: Parser | None = None) -> tuple[Configuration, argparse.Namespace]:
    """Read the arguments of ``npss-baselines train``.

    The command line overrides the configuration file (of ``--config``, or of the run to resume), which overrides the
    registry's defaults.

    Parameters
    ----------
    arguments : sequence of str
        The arguments after ``train``.
    command : Parser, optional
        The parser of the command, which names these options in errors.

    Returns
    -------
    configuration : Configuration
        The configuration of the run.
    options : Namespace
        The other options: ``out``, ``seeds``, ``apart``, ``resume``, ``cache``, ``device``,
        ``threads``, ``tf32``, ``tensorboard``, and the folders of sources.

    Raises
    ------
    TypeError, ValueError
        If an argument is unknown or invalid; the message lists the choices.
    """
    named = arguments and not arguments[0].startswith("-")
    name, rest = (arguments[0], arguments[1:]) if named else (None, arguments)
    if name is not None:
        one_of("MODEL", name, (*MODELS, *FITTED))
    if {"-h", "--help"} & set(rest):
        _add_options(config.parser_of(name or next(iter(MODELS)))).print_help()
        raise SystemExit(0)
    options, rest = options_of(rest, _add_options, command)
    file = file_of(options)
    if _several(options):
        if file is not None and file == options.out / FILE:
            raise ValueError(f"--out: {options.out} is a run, not a folder of runs")
        if options.seeds is not None and any(argument.partition("=")[0] == "--seed" for argument in rest):
            raise ValueError("--seed: not allowed with --seeds")
    folders = [source for source in folders_of(options) if source in pose_sources()]
    if file is not None:
        stored, parser = config.read_with_parser(file)
        if name not in (None, stored.name):
            raise ValueError(f"MODEL: {name!r}, but {file} configures {stored.name!r}")
        config.set_defaults(parser, vars(stored))
        recipe = stored.recipe
    elif name is not None:
        stored, parser, recipe = None, config.parser_of(name), MODELS[name].recipe
        config.set_defaults(parser, {"data": folders[0]} if len(folders) == 1 else {})
    elif options.resume:
        raise ValueError(f"--resume: no {FILE} in {options.out}; to start a run there, give MODEL or --config FILE")
    else:
        names = ", ".join((*MODELS, *FITTED))
        raise ValueError(f"MODEL: expected one of {names} as the first argument, or --config FILE")
    if command is not None:
        command.also_reads(parser)
    if options.iterations is not None:
        recipe = recipe.compressed(options.iterations)
        config.set_defaults(parser, {"recipe": recipe, "validate_every": None, "checkpoint_every": None})
    model = name if stored is None else stored.name
    configuration = config.configuration_of(str(model), parser, lambda: parser.parse_args(rest), also=vars(options))
    if others := [source for source in folders if source != configuration.data]:
        raise ValueError(f"--{pose_sources()[others[0]].option}: this run trains on --data {configuration.data}")
    if stored is not None and file == options.out / FILE:
        refuse_changes(options.out / FILE, asdict(stored), asdict(configuration))
    return configuration, options


def runs_of(configuration: Configuration, options: argparse.Namespace) -> list[tuple[Configuration, Path]]:
    """Return the runs to train together, each with its folder: one, unless the options ask for several.

    Parameters
    ----------
    configuration : Configuration
    options : Namespace
        From `parse`.

    Raises
    ------
    TypeError, ValueError
        If the seeds are invalid, or the folder holds other runs.
    """
    group = (options.out / CHECKPOINT).exists() and not (options.out / FILE).exists()
    if not _several(options):
        if group:
            raise ValueError(f"--out: {options.out} holds the runs of --seeds or --apart")
        return [(configuration, options.out)]
    if options.apart and configuration.validate_on != configuration.actions:
        raise ValueError("--validate-on: not allowed with --apart, which validates each model on its action")
    if options.seeds is not None and len(set(options.seeds)) < len(options.seeds):
        raise ValueError(f"--seeds: expected different seeds, got {', '.join(map(str, options.seeds))}")
    runs = []
    for action in configuration.actions if options.apart else [None]:
        for seed in [None] if options.seeds is None else options.seeds:
            run, names = configuration, []
            if action is not None:
                run, names = replace(run, actions=(action,), validate_on=(action,)), [action]
            if seed is not None:
                run, names = replace(run, seed=seed), [*names, f"seed-{seed}"]
            runs.append((run, options.out / "-".join(names)))
    for run, out in runs:
        stored = _stored(out, resume=options.resume)
        if stored is not None:
            refuse_changes(stored, asdict(config.read(stored)), asdict(run))
        elif group:
            raise ValueError(f"--out: {options.out} holds other runs, and {out.name} is not among them")
    return runs


def folder_of(options: argparse.Namespace, source: Source, runs: Sequence[Path]) -> tuple[Path | None, Path | None]:
    """Return the folder of the motion, from the command line, the run, or the environment, in this order.

    Parameters
    ----------
    options : Namespace
        From `parse`.
    source : Source
        The source of motion.
    runs : sequence of Path
        The folders of the runs to resume.

    Returns
    -------
    root : Path or None
        The folder.
    recorded_in : Path or None
        The configuration file that names the folder, if one does.
    """
    if source.generated:
        return None, None
    files = [folder / FILE for folder in runs] or ([] if options.config is None else [options.config])
    root: Path | None = getattr(options, source.option)
    if root is None:
        for file in files:
            if source.option in (paths := config.paths_of(file)):
                return paths[source.option], file
    return root or from_environment(source), None


def resume_arguments(options: argparse.Namespace, arguments: Sequence[str]) -> list[str]:
    """Return the arguments of ``npss-baselines`` that resume a run, or all runs that are trained together.

    Parameters
    ----------
    options : Namespace
        From `parse`.
    arguments : sequence of str
        What `parse` read.
    """
    if _several(options):
        return ["train", *arguments, *([] if options.resume else ["--resume"])]
    return ["train", "--resume", "--out", str(options.out), *unrecorded_arguments(options)]


def unrecorded_arguments(options: argparse.Namespace) -> list[str]:
    """Return the arguments that a run does not record: the cache, the device, and logs."""
    arguments = [] if options.cache is None else ["--cache", str(options.cache)]
    arguments += [] if options.device == "auto" else ["--device", options.device]
    return arguments + [f"--{name}" for name in ("tf32", "tensorboard") if getattr(options, name, False)]


def _several(options: argparse.Namespace) -> bool:
    """Return whether the options ask for several runs, each in a folder below ``--out``."""
    return options.seeds is not None or options.apart


def options_of(
    arguments: Sequence[str], add_options: Callable[[argparse.ArgumentParser], object], command: Parser | None
) -> tuple[argparse.Namespace, list[str]]:
    """Read the options that a configuration does not hold; also return the remaining arguments."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    add_options(parser)
    if command is not None:
        command.also_reads(parser)
    try:
        return parser.parse_known_args(arguments)
    except argparse.ArgumentError as error:
        raise ValueError(str(error)) from None


def _add_options(parser: AnyParser) -> AnyParser:
    """Add the options that a configuration does not hold."""
    parser.add_argument("--out", type=Path, metavar="RUN", help="write the run to this folder, created if missing")
    parser.add_argument("--config", type=Path, metavar="FILE", help=f"start from this configuration, a {FILE}")
    parser.add_argument(
        "--iterations",
        type=int,
        metavar="N",
        help="train for N iterations, all schedules in proportion (default: the recipe's)",
    )
    parser.add_argument(
        "--seeds",
        nargs="+",
        type=int,
        metavar="SEED",
        help="train one run for each seed, all at once, in folders below --out",
    )
    parser.add_argument(
        "--apart", action="store_true", help="train one model for each action, all at once, in folders below --out"
    )
    parser.add_argument("--resume", action="store_true", help="resume an interrupted run, or start it")
    add_folder_options(parser, pose_sources().values())
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="cache parsed files in this folder, to load them faster"
    )
    launch.add_device(parser)
    launch.add_threads(parser)
    parser.add_argument(
        "--tf32", action="store_true", help="on a GPU, round factors to ten bits of mantissa: faster, less exact"
    )
    add_plugin(parser)
    parser.add_argument("--tensorboard", action="store_true", help="also write TensorBoard logs")
    return parser


def file_of(options: argparse.Namespace) -> Path | None:
    """Return the configuration file to start from; refuse to overwrite a run."""
    if options.out is None:
        raise ValueError("--out RUN is required: the folder of the run")
    config_file: Path | None = options.config
    stored = _stored(options.out, resume=options.resume)
    if stored is None:
        return config_file
    if (options.out.parent / CHECKPOINT).exists() and not (options.out / CHECKPOINT).exists():
        raise ValueError(
            f"--resume: {options.out} is one of several runs; give --out {options.out.parent}, as at the start"
        )
    return stored


def _stored(out: Path, *, resume: bool) -> Path | None:
    """Return the configuration file of an existing run, if any; raise unless it is to be resumed."""
    stored = out / FILE
    if not stored.exists():
        return None
    if not resume:
        raise ValueError(f"--out: {out} already holds a run; --resume continues it")
    return stored


def refuse_changes(file: Path, stored: dict[str, Any], requested: dict[str, Any]) -> None:
    """Raise if a run is resumed with a configuration that differs from the stored one."""
    changed = [name for name, value in requested.items() if value != stored[name]]
    if changed:
        raise ValueError(
            f"--resume: {file} has another value of {', '.join(changed)}; omit the option, or start a new run"
        )
