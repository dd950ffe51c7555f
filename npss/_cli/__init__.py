"""The command ``npss``: score files, explain signatures, see the metric at work."""

from __future__ import annotations

import argparse
import errno
import os
import signal
import sys
from collections.abc import Sequence

import npss
from npss._cli import demo, explain, leaderboard, report, score, study
from npss._cli._parser import Parser
from npss._console import allow_any_text, discard_output, warnings_in_one_line

_FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
#: The extra of ``npss`` that brings a package.
_EXTRAS = {"h5py": "h5", "matplotlib": "plot", "pandas": "pandas", "scipy": "study"} | dict.fromkeys(
    ("filelock", "jsonargparse", "lightning", "safetensors", "torch"), "baselines"
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; return its exit status: 0, or as `run` says."""
    parser = Parser(
        prog="npss", description="NPSS, the metric for long-term human motion prediction: one meaning per number."
    )
    parser.add_argument("--version", action="version", version=f"npss {npss.__version__}")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for command in (score, leaderboard, report, study, explain, demo):
        command.add_parser(commands)
    return run(parser, study.name_form(sys.argv[1:] if arguments is None else arguments))


def run(parser: argparse.ArgumentParser, arguments: Sequence[str] | None) -> int:
    """Parse the arguments and call the ``run`` that they chose.

    Its errors become one line and status 2; Ctrl-C becomes one line and status 130.
    """
    allow_any_text()
    options = parser.parse_args(arguments)
    try:
        with warnings_in_one_line(parser.prog):
            options.run(options)
        print(end="", flush=True)
    except BrokenPipeError:  # the reader has seen enough, e.g. `npss score ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        print(f"{parser.prog}: interrupted", file=sys.stderr)
        return 128 + signal.SIGINT
    except (ImportError, OSError, TypeError, ValueError) as error:
        message = told(error, getattr(options, "extra", None))
        print(f"{parser.prog}: error: {' '.join(message.split())}", file=sys.stderr)
        discard_output()
        return 2
    return 0


def told(error: Exception, extra: str | None = None) -> str:
    """Return what an error tells people: no numbers of errors, and what to install where a package is missing.

    Parameters
    ----------
    error : Exception
        Of whatever kind.
    extra : str, optional
        The extra of ``npss`` that a command needs as a whole.
    """
    if isinstance(error, OSError) and error.strerror:
        if error.filename is not None:
            return f"cannot open {error.filename}: {error.strerror}"
        if error.errno in _FULL and error.strerror == os.strerror(error.errno):  # all else that is written is named
            return f"cannot write to standard output: {error.strerror}"
        return error.strerror
    package = (error.name or "").partition(".")[0] if isinstance(error, ModuleNotFoundError) else ""
    if package in _EXTRAS:
        return f"this needs {package}, which is not installed: pip install 'npss[{extra or _EXTRAS[package]}]'"
    return str(error)
