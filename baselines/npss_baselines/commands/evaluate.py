"""``npss-baselines evaluate``: score predictors on test windows."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Callable, Sequence
from functools import partial
from pathlib import Path
from typing import Any

from npss.commands import add_metrics
from npss.console import Progress
from npss.predictors import PREDICTORS
from npss.ranking import names_of_paths
from npss.records import Record, summary
from npss.validation import positive_integer
from npss_baselines.commands.sources import add_task_options, tasks_of
from npss_baselines.data.tasks import Task
from npss_baselines.evaluation.evaluate import evaluate


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss-baselines``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "evaluate",
        help="score predictors on test windows",
        description="Score predictors on test windows: NPSS under every convention, and the Euler error. "
        "Give models before the options.",
    )
    parser.add_argument(
        "models",
        nargs="*",
        metavar="MODEL",
        help=f"{', '.join(PREDICTORS)}, or the folder of a trained model (default: all these predictors)",
    )
    add_task_options(parser)
    parser.add_argument(
        "--draws",
        type=int,
        default=1,
        metavar="N",
        help="average a trained model over N draws; the paper's tables use 30 (default: %(default)s)",
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        metavar="N",
        help="set the random seed for the noise of trained models (default: %(default)s)",
    )
    parser.add_argument(
        "--unwrap",
        choices=("off", "target", "seed"),
        default="off",
        help="remove jumps of 2 pi before NPSS; off: nowhere, as published; target: in the target frames; seed: from "
        "the seed frames on (default: %(default)s)",
    )
    add_metrics(parser)
    parser.add_argument(
        "--sequences",
        action="store_true",
        help="also score each sequence and record its block (JSON), for intervals and comparisons in a leaderboard of "
        "these records",
    )
    parser.add_argument(
        "--format",
        choices=("table", "json", "markdown"),
        help="set the format of the output (default: table on a terminal, else json)",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the records."""
    positive_integer("draws", options.draws)
    models = options.models or list(PREDICTORS)
    if unknown := [model for model in models if model not in PREDICTORS and not is_run(model)]:
        raise ValueError(f"MODEL: {unknown[0]!r} is neither one of {', '.join(PREDICTORS)} nor the folder of a run")
    named = by_name(models)
    pairs = [(name, model, task) for task in tasks_of(options) for name, model in named.items()]
    records = []
    with Progress("evaluating") as progress:
        for done, (name, model, task) in enumerate(pairs):
            records.append(_record(name, model, task, options, partial(_show, progress, done, len(pairs))))
            progress((done + 1) / len(pairs))
    form = options.format or ("table" if sys.stdout.isatty() else "json")
    if form == "json":
        print(json.dumps(records, indent=2))
    else:
        print(summary(records, markdown=form == "markdown"))


def is_run(name: str) -> bool:
    """Return whether a name is the folder of a trained model."""
    return (Path(name) / "config.json").is_file()


def by_name(models: Sequence[str]) -> dict[str, str]:
    """Return models by name: predictors by their own, folders and files by names that are unique among all.

    Raises
    ------
    ValueError
        If a model is a duplicate.
    """
    if duplicates := [model for model in models if models.count(model) > 1]:
        raise ValueError(f"MODEL: duplicate {duplicates[0]!r}")
    paths = names_of_paths((Path(model) for model in models if model not in PREDICTORS), taken=PREDICTORS)
    names = {path: name for name, path in paths.items()}
    return {model if model in PREDICTORS else names[Path(model)]: model for model in models}


def _show(progress: Progress, done: int, n: int, share: float) -> None:
    """Show that `done` of `n` are done, and a share of the next."""
    progress((done + share) / n)


def _record(
    name: str, model: str, task: Task, options: argparse.Namespace, progress: Callable[[float], None]
) -> Record:
    measurements: dict[str, Any] = {
        "metrics": options.metrics,
        "unwrapped": options.unwrap,
        "sequences": options.sequences,
    }
    if model in PREDICTORS:
        return evaluate(name, PREDICTORS[model], task, **measurements)
    from npss_baselines.evaluation.draws import evaluate_run  # imports torch, which predictors do not need

    return evaluate_run(
        Path(model), task, name=name, draws=options.draws, seed=options.seed, progress=progress, **measurements
    )
