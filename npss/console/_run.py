"""Run a command: what it raises becomes one line, and an exit status."""

from __future__ import annotations

import argparse
import errno
import os
import signal
import sys
from collections.abc import Callable, Sequence

from npss.console._encoding import allow_any_text, discard_output, warnings_in_one_line
from npss.console._parser import split_plugins
from npss.extras import install_hint
from npss.plugins import load, load_installed

_FULL = (errno.ENOSPC, errno.EFBIG, errno.EDQUOT)
#: What brings a package: an extra of ``npss-metric``, or the whole of ``npss-baselines``.
_EXTRAS = {"matplotlib": "plot", "pandas": "pandas", "scipy": "study"}
_OF_BASELINES = ("filelock", "jsonargparse", "lightning", "safetensors", "torch")


def run(prog: str, parser: Callable[[], argparse.ArgumentParser], arguments: Sequence[str] | None) -> int:
    """Import the plugins, parse the arguments and call the ``run`` that they chose.

    Parameters
    ----------
    prog : str
        What the command is called.
    parser : callable
        Makes its parser; called after the plugins have registered what it lists.
    arguments : sequence of str or None
        Those of the command; None for those of this process.

    Returns
    -------
    int
        The exit status: 0; 2 after an error, which becomes one line; 130 after Ctrl-C.
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
    except BrokenPipeError:  # the reader has seen enough, e.g. `npss score ... | head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    except KeyboardInterrupt:
        print(f"{prog}: interrupted", file=sys.stderr)
        return 128 + signal.SIGINT
    except (ImportError, OSError, TypeError, ValueError) as error:
        message = told(error, getattr(options, "extra", None))
        print(f"{prog}: error: {' '.join(message.split())}", file=sys.stderr)
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
        The extra of ``npss-baselines`` that a command needs as a whole.
    """
    if isinstance(error, OSError) and error.strerror:
        if error.filename is not None:
            return f"cannot open {error.filename}: {error.strerror}"
        if error.errno in _FULL and error.strerror == os.strerror(error.errno):  # all else that is written is named
            return f"cannot write to standard output: {error.strerror}"
        return error.strerror
    package = (error.name or "").partition(".")[0] if isinstance(error, ModuleNotFoundError) else ""
    if package in _OF_BASELINES or (package in _EXTRAS and extra):
        return f"this needs {package}, which is not installed; {install_hint(extra or 'all', baselines=True)}"
    if package in _EXTRAS:
        return f"this needs {package}, which is not installed; {install_hint(_EXTRAS[package])}"
    return str(error)
