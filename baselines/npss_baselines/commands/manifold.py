"""``npss-baselines manifold``: clips of one's own, and numbers of trained manifolds."""

from __future__ import annotations

import argparse
from typing import Any

from npss_baselines.commands import manifold_clips, manifold_measure


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "manifold",
        help="restore, interpolate, compare and sample motion; measure a motion manifold",
        description="Restore, interpolate, compare and sample motion, of BVH files; and measure a trained motion "
        "manifold, from `npss-baselines train manifold`.",
    )
    applications = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    manifold_clips.add_parsers(applications)
    manifold_measure.add_parsers(applications)
