"""``npss explain``: a signature in plain words."""

from __future__ import annotations

import argparse
from typing import Any

from npss._metric.explain import explain


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "explain",
        help="say in plain words what a signature's number is",
        description="Say in plain words what was computed, and whether it is comparable to the published tables.",
    )
    parser.add_argument("signature", help="a signature, as printed with every score (quote it: it holds '|')")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the explanation."""
    print(explain(options.signature))
