"""Run a command: an error becomes one line and an exit status."""

from __future__ import annotations

import argparse
import errno
import os
import signal
import sys
from collections.abc import Callable, Sequence

from npss.console._encoding import allow_any_text, discard_output, warnings_in_one_line
from npss.console._parser import split_plugins
from npss.extras import EXTRAS, install_hint
from npss.plugins import load, load_installed, raised_by

_FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
#: Optional packages: the extra of ``npss-metric`` that brings each, and those that ``npss-baselines`` brings.
_EXTRAS = {extra.package: name for name, extra in EXTRAS.items()}
_OF_BASELINES = ("filelock", "jsonargparse", "lightning", "safetensors", "torch")


def run(prog: str, parser: Callable[[], argparse.ArgumentParser], arguments: Sequence[str] | None) -> int:
    """Import plugins, parse the arguments, and call ``run`` of the chosen subcommand.

    Parameters
    ----------
    prog : str
        The name of the command.
    parser : callable
        Makes the parser; called after plugins are imported, since it lists what they register.
    arguments : sequence of str or None
        The arguments; None for those of this process.

    Returns
    -------
    int
        The exit status: 0; 2 after an error, which becomes one line; 130 after Ctrl-C.

    Raises
    ------
    Exception
        Any other error, which is a bug. If a plugin raised it, a note names the plugin.
    """
    allow_any_text()
    options = argparse.Namespace()
    try:
        with warnings_in_one_line(prog):
            plugins, others = split_plugins(sys.argv[1:] if arguments is None else arguments)
            load_installed()
            for plugin in plugins:
                load(plugin)
            options = parser().parse_args(others)
            options.run(options)
        print(end="", flush=True)
    except BrokenPipeError:  # the reader has stopped, as in `npss score ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        print(f"{prog}: interrupted", file=sys.stderr)
        return 128 + signal.SIGINT
    except (argparse.ArgumentError, ImportError, OSError, TypeError, ValueError) as error:
        message = error_text(error, getattr(options, "extra", None))
        if "parser" in options:
            message = options.parser.as_typed(message)
        if place := raised_by(error):
            message = f"{message} ({place})"
        print(f"{prog}: error: {' '.join(message.split())}", file=sys.stderr)
        discard_output()
        return 2
    except Exception as error:
        if place := raised_by(error):
            error.add_note(f"({place})")
        raise
    return 0


def error_text(error: Exception, extra: str | None = None) -> str:
    """Return an error as text, without error numbers, and with an install hint for a missing package.

    Parameters
    ----------
    error : Exception
        The error.
    extra : str, optional
        The extra of ``npss-baselines`` that the command needs.
    """
    if isinstance(error, OSError) and error.strerror:
        if error.filename is not None:
            return f"{error.filename}: {error.strerror}"
        if error.errno in _FULL and error.strerror == os.strerror(error.errno):  # other outputs are named
            return f"cannot write to standard output: {error.strerror}"
        return error.strerror
    package = (error.name or "").partition(".")[0] if isinstance(error, ModuleNotFoundError) else ""
    if package in _OF_BASELINES or (package in _EXTRAS and extra):
        return f"this needs {package}, which is not installed; {install_hint(extra or 'all', baselines=True)}"
    if package in _EXTRAS:
        return f"this needs {package}, which is not installed; {install_hint(_EXTRAS[package])}"
    return str(error)
