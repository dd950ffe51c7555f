"""Rank predictors and prediction files on the same windows: a leaderboard, and a page that shows it all."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from baselines.evaluate import Task, add_task_options, tasks_of
from baselines.predictors import PREDICTORS
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
        help=f"of {', '.join(PREDICTORS)} (all of them if none is named), or a file of samples (.h5, .npz)",
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
    """Let predictors predict, and read what other models have predicted, of the same windows."""
    files = [Path(model) for model in models if model not in PREDICTORS]
    if unknown := [file for file in files if not file.suffix]:
        raise ValueError(f"MODEL: {str(unknown[0])!r} is not one of {', '.join(PREDICTORS)}, nor a file")
    found: dict[str, dict[str, Pair]] = {
        name: {
            task.action: Pair(task.action, task.target, PREDICTORS[name](task.seed, task.target.shape[1]))
            for task in tasks
        }
        for name in models
        if name in PREDICTORS
    }
    asked = [task.action for task in tasks]
    for name, pairs in read_submissions(files).items():
        found[name] = {action: pair for action, pair in pairs.items() if action in asked}
        if not found[name]:
            raise ValueError(f"MODEL: {name!r} has none of the actions asked for, {', '.join(asked)}")
    truth = {task.action: Pair(task.action, task.target, task.target) for task in tasks}
    check_truths({"the test windows": truth, **found})
    return found
