"""The command line of training."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, TypeVar

from baselines.data import h36m
from baselines.models import MODELS
from baselines.training.config import FILE, Configuration, configuration_of, defaults, parser_of, read
from npss._checks import one_of

DEVICES = ("auto", "cpu", "cuda")

Parser = TypeVar("Parser", bound=argparse.ArgumentParser)


def parse(arguments: Sequence[str]) -> tuple[Configuration, argparse.Namespace]:
    """Read the arguments of ``python -m baselines train``.

    The file, that of ``--config`` or of the run that is resumed, is stronger than the registry's defaults, and the
    command line is the strongest.

    Returns
    -------
    configuration : Configuration
        What the run is.
    options : Namespace
        What else was said: ``out``, ``seeds``, ``apart``, ``resume``, ``h36m``, ``cache``, ``device``, ``tf32`` and
        ``tensorboard``.

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
        _add_options(parser_of(defaults(name or next(iter(MODELS))))).print_help()
        raise SystemExit(0)
    options = _options(rest)
    file = file_of(options)
    if file is not None and file == options.out / FILE and _several(options):
        raise ValueError(f"--out: {options.out} is a run, not a folder of several")
    if name is None and file is None:
        raise ValueError(f"MODEL: expected one of {', '.join(MODELS)}, or --config FILE")
    known = defaults(str(name)) if file is None else vars(read(file)).copy()
    if name not in (None, known["name"]):
        raise ValueError(f"MODEL: {name!r}, but {file} is of a {known['name']!r}")
    if options.iterations is not None:
        recipe = known["recipe"].compressed(options.iterations)
        known |= {"recipe": recipe, "validate_every": None, "checkpoint_every": None}
    parser = _add_options(parser_of(known))
    configuration = configuration_of(known["name"], parser, lambda: parser.parse_args(rest))
    if file is not None and file == options.out / FILE:
        refuse_changes(file, asdict(read(file)), asdict(configuration))
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
        If seeds are not what they should be, or a run is there already or has another configuration.
    """
    if not _several(options):
        return [(configuration, options.out)]
    apart = [replace(configuration, actions=(action,), validate_on=(action,)) for action in configuration.actions]
    if options.apart and configuration.validate_on != configuration.actions:
        raise ValueError("--validate-on: with --apart, each model is validated on its own action")
    runs = []
    for of_action in apart if options.apart else [configuration]:
        for seed in options.seeds or [None]:
            names = ([of_action.actions[0]] if options.apart else []) + ([] if seed is None else [f"seed-{seed}"])
            one = of_action if seed is None else replace(of_action, seed=seed)
            runs.append((one, options.out / "-".join(names)))
    if len({out for _, out in runs}) < len(runs):
        raise ValueError(f"--seeds: expected each once; got {', '.join(map(str, options.seeds))}")
    for one, out in runs:
        if (out / FILE).exists():
            if not options.resume:
                raise ValueError(f"--out: there is a run in {out} already; --resume goes on with it")
            refuse_changes(out / FILE, asdict(read(out / FILE)), asdict(one))
    return runs


def _several(options: argparse.Namespace) -> bool:
    """Return whether more than one run is asked for, each with a folder in that of the command."""
    return options.seeds is not None or options.apart


def _options(arguments: Sequence[str]) -> argparse.Namespace:
    """Read what a configuration does not hold, of arguments of which others are for `parser_of`."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    try:
        return _add_options(parser).parse_known_args(arguments)[0]
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
    h36m.add_option(parser)
    parser.add_argument("--cache", type=Path, metavar="DIR", help="keep the files there in binary, to load faster")
    parser.add_argument("--device", choices=DEVICES, default=DEVICES[0], help="auto: cuda if there is one, else cpu")
    parser.add_argument(
        "--tf32", action="store_true", help="on a GPU, round what is multiplied to ten bits: faster, and less exact"
    )
    parser.add_argument("--tensorboard", action="store_true", help="write logs for TensorBoard, too")
    return parser


def file_of(options: argparse.Namespace) -> Path | None:
    """Return the file to begin with, after making sure that no run is overwritten."""
    if options.out is None:
        raise ValueError("--out RUN names the folder of the run")
    stored: Path = options.out / FILE
    given: Path | None = options.config
    if not stored.exists():
        return given
    if not options.resume:
        raise ValueError(f"--out: there is a run in {options.out} already; --resume goes on with it")
    return stored


def refuse_changes(file: Path, stored: dict[str, Any], asked: dict[str, Any]) -> None:
    """Raise if a run was to be resumed with another configuration than is stored in its file."""
    changed = [name for name, value in asked.items() if value != stored[name]]
    if changed:
        raise ValueError(
            f"--resume: {file} has another value of {', '.join(changed)}; leave it out, or begin a new run"
        )
