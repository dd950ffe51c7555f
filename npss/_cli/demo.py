"""``npss demo``: a leaderboard on motion that is generated here."""

from __future__ import annotations

import argparse
from typing import Any


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "demo",
        help="rank predictors on a generated gait",
        description="Rank the predictors that need no training on a synthetic gait, every convention side by side.",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the leaderboard."""
    # Here, not above: the library does not need its reference models.
    from baselines.evaluate import evaluate, summary
    from baselines.predictors import PREDICTORS
    from baselines.tasks import synthetic_task

    task = synthetic_task()
    print(summary([evaluate(name, predictor, task) for name, predictor in PREDICTORS.items()]))
    print(
        "\nOne prediction has as many scores as there are conventions. What a signature says: npss explain 'SIGNATURE'"
    )
