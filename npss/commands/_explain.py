"""``npss explain``: explain a signature."""

from __future__ import annotations

import argparse
from typing import Any

from npss._metric.explain import explain


def add_parser(commands: Any) -> None:
    """Add the command to ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "explain",
        help="explain a signature in plain words",
        description="Explain in plain words what was computed, and whether it is comparable with published tables.",
    )
    parser.add_argument("signature", metavar="SIGNATURE", help="a signature as printed with a score, in quotes")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the explanation."""
    print(explain(options.signature))
