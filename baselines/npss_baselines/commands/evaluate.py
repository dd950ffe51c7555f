"""``npss-baselines evaluate``: score predictors on the test windows of Human3.6M, or on a gait that needs no data."""

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
from npss_baselines.commands.sources import add_task_options, tasks_of
from npss_baselines.data.tasks import Task
from npss_baselines.evaluation.evaluate import evaluate


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss-baselines``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "evaluate",
        help="score predictors on the test windows of Human3.6M",
        description="Score predictors on test windows, by NPSS under every convention and by the Euler error.",
    )
    parser.add_argument(
        "models",
        nargs="*",
        metavar="MODEL",
        help=f"of {', '.join(PREDICTORS)} (all of them if none is named), or the folder of a trained model",
    )
    add_task_options(parser)
    parser.add_argument(
        "--draws",
        type=int,
        default=1,
        metavar="N",
        help="predictions of a trained model, of which mean and standard deviation are taken (the paper's tables: 30)",
    )
    parser.add_argument("--seed", type=int, default=0, help="of the noise of trained models (default: 0)")
    parser.add_argument(
        "--unwrap",
        choices=("off", "target", "seed"),
        default="off",
        help="remove jumps of 2 pi before NPSS: not (default, as published), over the target, or from the seed on",
    )
    add_metrics(parser)
    parser.add_argument(
        "--sequences",
        action="store_true",
        help="measure each sequence, too, and state its block (JSON): a leaderboard of such records has intervals and "
        "comparisons",
    )
    parser.add_argument(
        "--format", choices=("table", "json", "markdown"), help="default: table on a terminal, else json"
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the records."""
    models = options.models or list(PREDICTORS)
    if unknown := [model for model in models if model not in PREDICTORS and not is_run(model)]:
        raise ValueError(f"MODEL: {unknown[0]!r} is not one of {', '.join(PREDICTORS)}, nor the folder of a run")
    named = by_name(models)
    to_do = [(name, model, task) for task in tasks_of(options) for name, model in named.items()]
    records = []
    with Progress("evaluating") as progress:
        for done, (name, model, task) in enumerate(to_do):
            records.append(_record(name, model, task, options, partial(_tell, progress, done, len(to_do))))
            progress((done + 1) / len(to_do))
    form = options.format or ("table" if sys.stdout.isatty() else "json")
    if form == "json":
        print(json.dumps(records, indent=2))
    else:
        print(summary(records, markdown=form == "markdown"))


def is_run(name: str) -> bool:
    """Say whether that is the folder of a trained model."""
    return (Path(name) / "config.json").is_file()


def by_name(models: Sequence[str]) -> dict[str, str]:
    """Return predictors by their names, and folders and files by names that tell them apart, from predictors, too.

    Raises
    ------
    ValueError
        If one is there twice.
    """
    if twice := [model for model in models if models.count(model) > 1]:
        raise ValueError(f"MODEL: {twice[0]!r} is there twice")
    paths = names_of_paths((Path(model) for model in models if model not in PREDICTORS), taken=PREDICTORS)
    names = {path: name for name, path in paths.items()}
    return {model if model in PREDICTORS else names[Path(model)]: model for model in models}


def _tell(progress: Progress, done: int, n: int, share: float) -> None:
    """Say that so many of n are done, and a share of the next one."""
    progress((done + share) / n)


def _record(
    name: str, model: str, task: Task, options: argparse.Namespace, progress: Callable[[float], None]
) -> Record:
    measured: dict[str, Any] = {"metrics": options.metrics, "unwrapped": options.unwrap, "sequences": options.sequences}
    if model in PREDICTORS:
        return evaluate(name, PREDICTORS[model], task, **measured)
    from npss_baselines.evaluation.draws import evaluate_run  # imports torch, which predictors do not need

    return evaluate_run(
        Path(model), task, name=name, draws=options.draws, seed=options.seed, progress=progress, **measured
    )
