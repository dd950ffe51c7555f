"""``npss-baselines leaderboard``: rank predictors and prediction files on the same windows."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from npss import metrics
from npss.commands import add_leaderboard_options, add_metrics, leaderboard_of, show_leaderboard, write_report
from npss.files import MAX_SIZE, Pair, check_output, listed
from npss.predictors import PREDICTORS, Predictor
from npss.ranking import check_truths, read_actions, records_of, sample_files
from npss_baselines.commands.evaluate import by_name, is_run
from npss_baselines.commands.sources import add_task_options, tasks_of
from npss_baselines.data.tasks import Task

_DESCRIPTION = """\
Rank predictors and prediction files on the same test windows: Euler error and NPSS with intervals, and marks on
differences beyond chance. Give models before the options. Needs pandas; --report also needs matplotlib (extras pandas
and plot of npss-metric).
"""


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss-baselines``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "leaderboard", help="rank predictors and prediction files", description=_DESCRIPTION
    )
    parser.add_argument(
        "models",
        nargs="*",
        metavar="MODEL",
        help=f"{', '.join(PREDICTORS)}, a file of samples ({listed('samples')}), or the folder of a trained model "
        "(default: all these predictors)",
    )
    add_task_options(parser)
    add_leaderboard_options(parser)
    add_metrics(parser)
    parser.add_argument("--manifold", type=Path, metavar="RUN", help="compute metric G by the manifold in this folder")
    parser.add_argument("--report", type=Path, metavar="FILE", help="also write a full report on one HTML page to FILE")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the leaderboard; write the report if requested."""
    if options.report:
        check_output(options.report, map(Path, options.models))
    if bool({"g", "G"} & {*options.metrics}) != (options.manifold is not None):
        raise ValueError("--manifold RUN: the manifold for --metrics G; give both or neither")
    tasks = list(tasks_of(options))
    submissions = submit(options.models or list(PREDICTORS), tasks, max_size=options.max_size)
    groups = {task.action: task.groups for task in tasks}
    if options.manifold:
        _register_g(options.manifold)
    records = records_of(submissions, metrics=options.metrics, groups=groups, protocol=tasks[0].protocol)
    board = leaderboard_of(records, options)
    if options.report:
        write_report(options.report, submissions, board)
    show_leaderboard(board, options)


def submit(models: list[str], tasks: list[Task], *, max_size: float = MAX_SIZE) -> dict[str, dict[str, Pair]]:
    """Predict the windows with predictors and trained models, and read the files of other predictions."""
    if unknown := [m for m in models if m not in PREDICTORS and not is_run(m) and not Path(m).suffix]:
        raise ValueError(
            f"MODEL: {unknown[0]!r} is neither one of {', '.join(PREDICTORS)}, nor a file, nor the folder of a run"
        )
    groups = ([m] if m in PREDICTORS or is_run(m) else map(str, sample_files([Path(m)])) for m in models)
    named = by_name([model for group in groups for model in group])
    actions = [task.action for task in tasks]
    submissions: dict[str, dict[str, Pair]] = {}
    for name, model in named.items():
        if model in PREDICTORS:
            submissions[name] = {task.action: _predicted(PREDICTORS[model], task) for task in tasks}
        elif is_run(model):
            from npss_baselines.runs import folder  # imports torch, which predictors do not need

            trained = folder.load(Path(model))
            submissions[name] = {
                task.action: _predicted(trained.predictor(task.action, seed=0), task)
                for task in tasks
                if task.action in trained.configuration.actions
            }
        else:
            contents = read_actions(Path(model), max_size=max_size)
            submissions[name] = {action: pair for action, pair in contents.items() if action in actions}
    if empty := [name for name, pairs in submissions.items() if not pairs]:
        raise ValueError(f"MODEL: {empty[0]!r} has none of the actions {', '.join(actions)}")
    truth = {task.action: Pair(task.action, task.target, task.target) for task in tasks}
    check_truths({"the test windows": truth, **submissions})
    return submissions


def _register_g(manifold: Path) -> None:
    """Register the distance G by a manifold as a metric."""
    # These import torch, which predictors do not need.
    from npss_baselines.manifold.applications.distance import metric_of
    from npss_baselines.manifold.training.folder import load

    metrics.register(metric_of(load(manifold).projector), replace=True)


def _predicted(predictor: Predictor, task: Task) -> Pair:
    return Pair(task.action, task.target, predictor(task.seed_frames, task.target.shape[1]))
