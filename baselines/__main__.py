"""``python -m baselines``: produce reference numbers."""

import sys
from collections.abc import Sequence

from baselines import evaluate, leaderboard, predict, sensitivity, train
from baselines.manifold import commands as manifold
from baselines.models import parameters
from npss._cli import run
from npss._cli._parser import Parser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status."""
    parser = Parser(prog="python -m baselines", description="Reference predictors and models of human motion.")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (evaluate, leaderboard, sensitivity, parameters, train, predict, manifold):
        command.add_parser(commands)
    return run(parser, arguments)


if __name__ == "__main__":
    sys.exit(main())
