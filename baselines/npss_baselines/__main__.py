"""The command ``npss-baselines``."""

import os
import sys
from collections.abc import Sequence

import npss
from npss.console import add_completion, run, versions
from npss_baselines.commands import (
    evaluate,
    lafan1,
    leaderboard,
    manifold,
    params,
    predict,
    reproduce,
    sensitivity,
    train,
)
from npss_baselines.commands.parser import CommandParser


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command and return its exit status."""
    if arguments is None:
        # Of this process. Before torch loads its threads, also for a plugin: threads that wait for each other should
        # sleep. By default, they spin, which slows all of them down many times where other programs use their cores.
        os.environ.setdefault("OMP_WAIT_POLICY", "PASSIVE")
    return run("npss-baselines", _parser, arguments)


def _parser() -> CommandParser:
    parser = CommandParser(prog="npss-baselines", description="Train and score reference models of human motion.")
    version = versions("npss-baselines", npss.__version__, "torch", "lightning")
    parser.add_argument("--version", action="version", version=version)
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (evaluate, leaderboard, sensitivity, params, train, predict, manifold, reproduce, lafan1):
        command.add_parser(commands)
    add_completion(parser, commands)
    return parser


if __name__ == "__main__":
    sys.exit(main())
