"""``npss-baselines predict``: write a trained model's predictions in the layout of the field's code."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

from npss import euler_error_curve, poses_to_euler
from npss.files import check_output, listed, suffixes, write_samples
from npss.validation import Array
from npss_baselines.commands.sources import add_task_options, pose_source_of

_DESCRIPTION = """\
Write a trained model's predictions of the test windows to a file. It holds exponential maps at 25 frames per second,
expmap/gt/ACTION_i and expmap/preds/ACTION_i, and the Euler error, mean_ACTION_error. `npss score`, `npss leaderboard`
and `npss report` read it.
"""


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss-baselines``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "predict", help="write a trained model's predictions to a file", description=_DESCRIPTION
    )
    parser.add_argument("folder", type=Path, metavar="RUN", help="the folder of a run")
    add_task_options(parser)
    parser.add_argument("--out", type=Path, metavar="FILE", required=True, help=f"write to this {listed('write')} file")
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        metavar="N",
        help="set the random seed for the model's noise, if any (default: %(default)s)",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Predict and write the file."""
    if options.out.suffix not in suffixes("write"):
        raise ValueError(f"--out: expected a {listed('write')} file, got {options.out}")
    check_output(options.out)

    from npss_baselines.runs import folder  # imports torch, which other commands do not need

    trained = folder.load(options.folder)
    configuration = trained.configuration
    source, data = pose_source_of(options, default=configuration.data)
    actions = options.actions or (configuration.actions if source.name == configuration.data else ())
    arrays: dict[str, Array] = {}
    for task in source.tasks(data, actions, options.protocol, cache=options.cache):
        predicted = trained.predictor(task.action, seed=options.seed)(task.seed_frames, task.target.shape[1])
        for kind, poses in (("gt", task.target), ("preds", predicted)):
            arrays |= {f"expmap/{kind}/{task.action}_{i}": sequence for i, sequence in enumerate(poses)}
        errors = euler_error_curve(poses_to_euler(task.target), poses_to_euler(predicted))
        arrays[f"mean_{task.action}_error"] = errors
    write_samples(options.out, arrays)
    print(options.out)
