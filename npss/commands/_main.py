"""The entry point of the command ``npss``."""

from __future__ import annotations

from collections.abc import Sequence

import npss
from npss.commands import (
    _compare,
    _demo,
    _diagnose,
    _doctor,
    _explain,
    _identify,
    _leaderboard,
    _report,
    _score,
    _study,
)
from npss.console import Parser, add_completion, run, versions


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command ``npss``.

    Parameters
    ----------
    arguments : sequence of str, optional
        The arguments (default: those of the process).

    Returns
    -------
    int
        The exit status, as `npss.console.run` returns it.
    """
    return run("npss", _parser, arguments)


def _parser() -> Parser:
    parser = Parser(
        prog="npss", description="Score and compare human motion prediction by NPSS: one meaning per number."
    )
    parser.add_argument("--version", action="version", version=versions("npss", npss.__version__, "numpy"))
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (_score, _compare, _diagnose, _leaderboard, _report, _study, _explain, _identify, _demo, _doctor):
        command.add_parser(commands)
    add_completion(parser, commands)
    return parser
