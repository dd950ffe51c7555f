"""``npss identify``: say which NPSS a function computes."""

from __future__ import annotations

import argparse
import importlib
import re
import sys
import traceback
from contextlib import redirect_stdout
from importlib.util import find_spec
from pathlib import Path
from typing import Any, get_args

from npss._identify.identify import Order, identify

_DESCRIPTION = """\
Say which NPSS a function computes, and what of it differs from the named conventions. Imports the module, from the
current folder if it is not installed, and runs the function on small generated motions.

  npss identify package.module:function
  npss identify package.module:Class       a class with update and compute
"""
_TARGET = re.compile(r"([^\W\d]\w*(?:\.[^\W\d]\w*)*):([^\W\d]\w*(?:\.[^\W\d]\w*)*)")


def add_parser(commands: Any) -> None:
    """Add the command to ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "identify",
        help="say which NPSS a function computes",
        description=_DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("function", metavar="FUNCTION", help="the function, as package.module:function")
    parser.add_argument(
        "--order",
        choices=get_args(Order),
        help="set the order of its arguments (default: by the names of its parameters)",
    )
    parser.add_argument(
        "--frame",
        type=int,
        nargs="+",
        metavar="SIZE",
        help="set the shape of a frame if the function needs a certain one, such as 99, or 22 4 for joints",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print what the function computes."""
    with redirect_stdout(sys.stderr):  # what the module and the function print is no part of the result
        result = identify(_load(options.function), order=options.order, frame=options.frame)
    print(result)


def _load(target: str) -> Any:
    """Import a function.

    Raises
    ------
    ValueError
        If the text is not of the form ``package.module:function``, or the module has no such function.
    ImportError
        If the import fails. The message names the module and the line.
    """
    match = _TARGET.fullmatch(target)
    if match is None:
        raise ValueError(f"function: expected package.module:function, got {target!r}")
    module, name = match.groups()
    package = module.partition(".")[0]
    if package not in sys.modules and find_spec(package) is None:
        sys.path.append(str(Path.cwd()))
    try:
        imported = importlib.import_module(module)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{module}.".startswith(f"{error.name}."):
            raise ImportError(f"function: {module}: {error}{_place(error)}") from error
        raise ImportError(f"function: there is no module {error.name!r}, installed or in the current folder") from None
    except (Exception, SystemExit) as error:
        raise ImportError(f"function: {module}: {type(error).__name__}: {error}{_place(error)}") from error
    function: Any = imported
    for part in name.split("."):
        if not hasattr(function, part):
            raise ValueError(f"function: {module} has no {name!r}")
        function = getattr(function, part)
    return function


def _place(error: BaseException) -> str:
    """Return the line that raised an error in a module; a SyntaxError names its line itself."""
    frame = traceback.extract_tb(error.__traceback__)[-1]
    return "" if isinstance(error, SyntaxError) else f" ({frame.filename}, line {frame.lineno})"
