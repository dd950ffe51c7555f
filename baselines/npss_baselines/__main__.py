"""The command ``npss-baselines``."""

import sys
from collections.abc import Sequence

from npss.console import run
from npss_baselines.commands import evaluate, leaderboard, manifold, params, predict, reproduce, sensitivity, train
from npss_baselines.commands.parser import CommandParser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit status."""
    return run("npss-baselines", _parser, arguments)


def _parser() -> CommandParser:
    parser = CommandParser(prog="npss-baselines", description="Train and score reference models of human motion.")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (evaluate, leaderboard, sensitivity, params, train, predict, manifold, reproduce):
        command.add_parser(commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())
