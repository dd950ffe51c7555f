"""The command ``completion`` of every command: a script that completes it in a shell."""

from __future__ import annotations

import argparse
from typing import Any

from npss.extras import install_hint


def add_completion(parser: argparse.ArgumentParser, commands: Any) -> None:
    """Add the command ``completion``.

    Parameters
    ----------
    parser : ArgumentParser
        The parser of the whole command.
    commands : subparsers
        Its commands, as ``parser.add_subparsers`` returns them.
    """
    completion: argparse.ArgumentParser = commands.add_parser(
        "completion",
        help="print a script for your shell, which completes this command",
        description=f"Print a script for your shell, which completes the words of {parser.prog}.",
    )
    completion.add_argument("shell", choices=("bash", "zsh", "tcsh"), help="your shell")
    completion.set_defaults(run=_run, whole=parser)


def _run(options: argparse.Namespace) -> None:
    try:
        import shtab
    except ImportError:
        raise ImportError(f"completion needs shtab; {install_hint('completion')}") from None
    _complete_files(options.whole, shtab.FILE)
    print(shtab.complete(options.whole, options.shell))


def _complete_files(parser: argparse.ArgumentParser, files: Any) -> None:
    """Let every word that is no option and no choice complete to a file, as shells do by themselves."""
    for action in parser._actions:
        if isinstance(action, argparse._SubParsersAction):
            for command in set(action.choices.values()):
                _complete_files(command, files)
        elif action.nargs != 0 and action.choices is None:
            action.complete = files  # type: ignore[attr-defined]
