"""The command ``npss``: score files, explain signatures, see the metric at work."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence

import npss
from npss._cli import demo, explain, leaderboard, report, score, study


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status: 0, or 2 with one line on what was wrong."""
    parser = argparse.ArgumentParser(
        prog="npss", description="NPSS, the metric for long-term human motion prediction: one meaning per number."
    )
    parser.add_argument("--version", action="version", version=f"npss {npss.__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (score, leaderboard, report, study, explain, demo):
        command.add_parser(commands)
    return run(parser, arguments)


def run(parser: argparse.ArgumentParser, arguments: Sequence[str] | None) -> int:
    """Parse the arguments and call the ``run`` that they chose, turning its errors into one line and status 2."""
    options = parser.parse_args(arguments)
    try:
        options.run(options)
        sys.stdout.flush()
    except BrokenPipeError:  # the reader has seen enough, e.g. `npss score ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except (ImportError, OSError, TypeError, ValueError) as error:
        message = " ".join(str(error).split())
        print(f"{parser.prog}: error: {message}", file=sys.stderr)
        return 2
    return 0
