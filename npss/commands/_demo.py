"""``npss demo``: a leaderboard on generated motion."""

from __future__ import annotations

import argparse
from typing import Any

from npss.gait import gait
from npss.predictors import PREDICTORS
from npss.protocol import FPS, SLICES_MS
from npss.records import measure, summary
from npss.rotations._poses import poses_to_euler

N_SEQUENCES, N_SEED, N_TARGET = 64, 50, 100


def add_parser(commands: Any) -> None:
    """Add the command to ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "demo",
        help="rank predictors on a generated gait",
        description="Rank untrained predictors on a generated gait, with all conventions side by side.",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the leaderboard."""
    poses = gait(N_SEQUENCES, N_SEED + N_TARGET, seed=0)
    seed, target = poses[:, :N_SEED], poses[:, N_SEED:]
    records = []
    for name, predict in PREDICTORS.items():
        record = measure(
            poses_to_euler(target),
            poses_to_euler(predict(seed, N_TARGET)),
            fps=FPS,
            at_ms=SLICES_MS,
            representation="euler",
            frames=N_TARGET,
            protocol=f"synthetic-{N_SEQUENCES}",
        )
        records.append({"model": name, "action": "gait", **record})
    print(summary(records))
    print("\nEach convention gives a prediction another score. To read a signature: npss explain 'SIGNATURE'")
