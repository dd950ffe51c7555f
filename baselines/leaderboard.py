"""Rank predictors and prediction files on the same windows: a leaderboard, and a page that shows it all."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np

from baselines.evaluate import Task, add_task_options, is_run, tasks_of
from baselines.predictors import PREDICTORS, Predictor
from npss._cli import report
from npss._cli.leaderboard import add_options, board_of, show
from npss._files import Pair
from npss._submissions import check_truths, read_submissions, records_of

_DESCRIPTION = """\
Rank predictors, and models of which there are prediction files, on the same test windows: Euler error and NPSS with
intervals, and marks where a difference is more than chance. Needs pandas; the page needs matplotlib, too:
pip install 'npss[pandas,plot]'.
"""


def add_parser(commands: Any) -> None:
    """Add the command to those of ``python -m baselines``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "leaderboard", help="rank predictors and prediction files", description=_DESCRIPTION
    )
    parser.add_argument(
        "models",
        nargs="*",
        metavar="MODEL",
        help=f"of {', '.join(PREDICTORS)} (all of them if none is named), a file of samples (.h5, .npz), or the folder "
        "of a trained model",
    )
    add_task_options(parser)
    add_options(parser)
    parser.add_argument("--report", type=Path, metavar="FILE", help="write a page (HTML) with all there is to see")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Write the page, and print the leaderboard."""
    if options.report:
        report.check_folder(options.report)
    tasks = list(tasks_of(options))
    submissions = submit(options.models or list(PREDICTORS), tasks)
    board = board_of(records_of(submissions, protocol=tasks[0].protocol), options)
    if options.report:
        report.write(options.report, submissions, board)
    show(board, options)


def submit(models: list[str], tasks: list[Task]) -> dict[str, dict[str, Pair]]:
    """Let predictors and trained models predict, and read what others have predicted, of the same windows."""
    files = [Path(model) for model in models if model not in PREDICTORS and not is_run(model)]
    if unknown := [file for file in files if not file.suffix]:
        raise ValueError(
            f"MODEL: {str(unknown[0])!r} is not one of {', '.join(PREDICTORS)}, nor a file, nor the folder of a run"
        )
    asked = [task.action for task in tasks]
    found: dict[str, dict[str, Pair]] = {}
    for model in models:
        if model in PREDICTORS:
            found[model] = {task.action: _predicted(PREDICTORS[model], task) for task in tasks}
        elif is_run(model):
            from baselines.training import runs  # imports torch, which predictors do not need

            trained = runs.load(Path(model))
            found[Path(model).resolve().name] = {
                task.action: _predicted(trained.predictor(task.action, rng=np.random.default_rng(0)), task)
                for task in tasks
                if task.action in trained.configuration.actions
            }
    for name, pairs in read_submissions(files).items():
        found[name] = {action: pair for action, pair in pairs.items() if action in asked}
    if without := [name for name, pairs in found.items() if not pairs]:
        raise ValueError(f"MODEL: {without[0]!r} has none of the actions asked for, {', '.join(asked)}")
    truth = {task.action: Pair(task.action, task.target, task.target) for task in tasks}
    check_truths({"the test windows": truth, **found})
    return found


def _predicted(predictor: Predictor, task: Task) -> Pair:
    return Pair(task.action, task.target, predictor(task.seed, task.target.shape[1]))
