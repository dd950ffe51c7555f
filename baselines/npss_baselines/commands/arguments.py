"""The command line of training."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TypeVar

from npss.console import add_plugin
from npss.validation import one_of
from npss_baselines.commands.sources import add_folder_options, folders_of, from_environment
from npss_baselines.data import Source, pose_sources
from npss_baselines.models import MODELS
from npss_baselines.runs import config, launch
from npss_baselines.runs.config import CHECKPOINT, FILE, Configuration

Parser = TypeVar("Parser", bound=argparse.ArgumentParser)


def parse(arguments: Sequence[str]) -> tuple[Configuration, argparse.Namespace]:
    """Read the arguments of ``npss-baselines train``.

    The file, that of ``--config`` or of the run that is resumed, is stronger than the registry's defaults, and the
    command line is the strongest.

    Returns
    -------
    configuration : Configuration
        What the run is.
    options : Namespace
        What else was said: ``out``, ``seeds``, ``apart``, ``resume``, ``cache``, ``device``, ``tf32``,
        ``tensorboard``, and the folders of sources.

    Raises
    ------
    TypeError, ValueError
        If an argument is not one, or not what it should be: says what there is.
    """
    named = arguments and not arguments[0].startswith("-")
    name, rest = (arguments[0], arguments[1:]) if named else (None, arguments)
    if name is not None:
        one_of("MODEL", name, tuple(MODELS))
    if {"-h", "--help"} & set(rest):
        _add_options(config.parser_of(name or next(iter(MODELS)))).print_help()
        raise SystemExit(0)
    options, rest = _options(rest)
    file = file_of(options)
    if _several(options):
        if file is not None and file == options.out / FILE:
            raise ValueError(f"--out: {options.out} is a run, not a folder of several")
        if options.seeds is not None and any(argument.partition("=")[0] == "--seed" for argument in rest):
            raise ValueError("--seed: --seeds says which already")
    folders = [source for source in folders_of(options) if source in pose_sources()]
    if file is not None:
        stored, parser = config.read_with_parser(file)
        if name not in (None, stored.name):
            raise ValueError(f"MODEL: {name!r}, but {file} is of a {stored.name!r}")
        config.set_defaults(parser, vars(stored))
        recipe = stored.recipe
    elif name is not None:
        stored, parser, recipe = None, config.parser_of(name), MODELS[name].recipe
        config.set_defaults(parser, {"data": folders[0]} if len(folders) == 1 else {})
    elif options.resume:
        raise ValueError(f"--resume: no {FILE} in {options.out}; to begin a run there, name MODEL or --config FILE")
    else:
        raise ValueError(f"MODEL: expected one of {', '.join(MODELS)}, or --config FILE")
    if options.iterations is not None:
        recipe = recipe.compressed(options.iterations)
        config.set_defaults(parser, {"recipe": recipe, "validate_every": None, "checkpoint_every": None})
    model = name if stored is None else stored.name
    configuration = config.configuration_of(str(model), parser, lambda: parser.parse_args(rest), also=vars(options))
    if others := [source for source in folders if source != configuration.data]:
        raise ValueError(f"--{pose_sources()[others[0]].option}: the run is trained on --data {configuration.data}")
    if stored is not None and file == options.out / FILE:
        refuse_changes(options.out / FILE, asdict(stored), asdict(configuration))
    return configuration, options


def runs_of(configuration: Configuration, options: argparse.Namespace) -> list[tuple[Configuration, Path]]:
    """Return the runs that are to be trained together, each with its folder: one, unless several were asked for.

    Parameters
    ----------
    configuration : Configuration
    options : Namespace
        From `parse`.

    Raises
    ------
    TypeError, ValueError
        If seeds are not what they should be, or there are other runs already.
    """
    group = (options.out / CHECKPOINT).exists() and not (options.out / FILE).exists()
    if not _several(options):
        if group:
            raise ValueError(f"--out: {options.out} is a folder of several runs, of --seeds or --apart")
        return [(configuration, options.out)]
    if options.apart and configuration.validate_on != configuration.actions:
        raise ValueError("--validate-on: with --apart, each model is validated on its own action")
    if options.seeds is not None and len(set(options.seeds)) < len(options.seeds):
        raise ValueError(f"--seeds: expected each once; got {', '.join(map(str, options.seeds))}")
    runs = []
    for action in configuration.actions if options.apart else [None]:
        for seed in [None] if options.seeds is None else options.seeds:
            one, names = configuration, []
            if action is not None:
                one, names = replace(one, actions=(action,), validate_on=(action,)), [action]
            if seed is not None:
                one, names = replace(one, seed=seed), [*names, f"seed-{seed}"]
            runs.append((one, options.out / "-".join(names)))
    for one, out in runs:
        stored = _stored(out, resume=options.resume)
        if stored is not None:
            refuse_changes(stored, asdict(config.read(stored)), asdict(one))
        elif group:
            raise ValueError(f"--out: {options.out} has other runs already, and {out.name} is none of them")
    return runs


def folder_of(options: argparse.Namespace, source: Source, begun: Sequence[Path]) -> tuple[Path | None, Path | None]:
    """Return where the motion is: where the command line says, or the run, or the environment.

    Parameters
    ----------
    options : Namespace
        From `parse`.
    source : Source
        Of the motion.
    begun : sequence of Path
        The folders of the runs that are to be resumed.

    Returns
    -------
    root : Path or None
        The folder.
    recorded_in : Path or None
        The configuration that says so, if it is that.
    """
    if source.generated:
        return None, None
    files = [folder / FILE for folder in begun] or ([] if options.config is None else [options.config])
    named: Path | None = getattr(options, source.option)
    if named is None:
        for file in files:
            if source.option in (paths := config.paths_of(file)):
                return paths[source.option], file
    return named or from_environment(source), None


def resuming(options: argparse.Namespace, said: Sequence[str]) -> list[str]:
    """Return the arguments of ``npss-baselines`` with which a run, or all that are trained together, goes on.

    Parameters
    ----------
    options : Namespace
        From `parse`.
    said : sequence of str
        What was parsed.
    """
    if _several(options):
        return ["train", *said, *([] if options.resume else ["--resume"])]
    return ["train", "--resume", "--out", str(options.out), *not_in_configuration(options)]


def not_in_configuration(options: argparse.Namespace) -> list[str]:
    """Return what else was said that a run does not remember: on what it is computed, and what is written beside it."""
    said = [] if options.cache is None else ["--cache", str(options.cache)]
    said += [] if options.device == "auto" else ["--device", options.device]
    return said + [f"--{name}" for name in ("tf32", "tensorboard") if getattr(options, name, False)]


def _several(options: argparse.Namespace) -> bool:
    """Return whether more than one run is asked for, each with a folder in that of the command."""
    return options.seeds is not None or options.apart


def _options(arguments: Sequence[str]) -> tuple[argparse.Namespace, list[str]]:
    """Read what a configuration does not hold; return the arguments that are left for its parser, too."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    try:
        return _add_options(parser).parse_known_args(arguments)
    except argparse.ArgumentError as error:
        raise ValueError(str(error)) from None


def _add_options(parser: Parser) -> Parser:
    """Add what a configuration does not hold."""
    parser.add_argument("--out", type=Path, metavar="RUN", help="the folder of the run, which is made")
    parser.add_argument("--config", type=Path, metavar="FILE", help=f"begin with this configuration, a {FILE}")
    parser.add_argument("--iterations", type=int, metavar="N", help="train for so many, all schedules in proportion")
    parser.add_argument(
        "--seeds", nargs="+", type=int, metavar="SEED", help="train a run for each at once, in folders below --out"
    )
    parser.add_argument(
        "--apart", action="store_true", help="train a model for each of the actions at once, as --seeds"
    )
    parser.add_argument("--resume", action="store_true", help="go on where the run was cut off, if it had begun")
    add_folder_options(parser, pose_sources().values())
    parser.add_argument("--cache", type=Path, metavar="DIR", help="keep the files there in binary, to load faster")
    launch.add_device(parser)
    parser.add_argument(
        "--tf32", action="store_true", help="on a GPU, round what is multiplied to ten bits: faster, and less exact"
    )
    add_plugin(parser)
    parser.add_argument("--tensorboard", action="store_true", help="write logs for TensorBoard, too")
    return parser


def file_of(options: argparse.Namespace) -> Path | None:
    """Return the file to begin with, after making sure that no run is overwritten."""
    if options.out is None:
        raise ValueError("--out RUN names the folder of the run")
    given: Path | None = options.config
    stored = _stored(options.out, resume=options.resume)
    if stored is None:
        return given
    if (options.out.parent / CHECKPOINT).exists() and not (options.out / CHECKPOINT).exists():
        raise ValueError(
            f"--resume: {options.out} is one of several runs; name --out {options.out.parent}, as at first"
        )
    return stored


def _stored(out: Path, *, resume: bool) -> Path | None:
    """Return the configuration of the run that is there, if any, which is to be resumed."""
    stored = out / FILE
    if not stored.exists():
        return None
    if not resume:
        raise ValueError(f"--out: there is a run in {out} already; --resume goes on with it")
    return stored


def refuse_changes(file: Path, stored: dict[str, Any], asked: dict[str, Any]) -> None:
    """Raise if a run was to be resumed with another configuration than is stored in its file."""
    changed = [name for name, value in asked.items() if value != stored[name]]
    if changed:
        raise ValueError(
            f"--resume: {file} has another value of {', '.join(changed)}; leave it out, or begin a new run"
        )
