"""``npss-baselines``: produce reference numbers."""

import sys
from collections.abc import Sequence

from npss.console import Parser, run
from npss_baselines.commands import evaluate, leaderboard, manifold, predict, sensitivity, train
from npss_baselines.commands import params as parameters


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    return run("npss-baselines", _parser, arguments)


def _parser() -> Parser:
    parser = Parser(prog="npss-baselines", description="Reference predictors and models of human motion.")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (evaluate, leaderboard, sensitivity, parameters, train, predict, manifold):
        command.add_parser(commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())
