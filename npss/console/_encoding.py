"""The output of a command: ASCII for characters that the encoding lacks, such as †, and one-line warnings."""

from __future__ import annotations

import codecs
import io
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

_NAME = "npss-ascii"  # the error handler
_IN_ASCII = {"†": "^", "–": "-", "—": "-", "−": "-", "∞": "inf", "…": "...", "×": "x", "·": "*", "µ": "u", "μ": "u"}


def allow_any_text() -> None:
    """Let standard output replace what it cannot encode, unless it has an error handler already."""
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors in ("strict", "surrogateescape"):
        sys.stdout.reconfigure(errors=_NAME)


def discard_output() -> None:
    """Discard output that could not be written, so that Python does not try, and complain, again when it exits."""
    try:
        print(end="", flush=True)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def warnings_in_one_line(prog: str) -> Iterator[None]:
    """Print each warning as one line that names the program instead of a line of code."""

    def line(message: Warning | str, *_: object, **__: object) -> str:
        return f"{prog}: warning: {' '.join(str(message).split())}\n"

    before = warnings.formatwarning
    warnings.formatwarning = line
    try:
        yield
    finally:
        warnings.formatwarning = before


def _in_ascii(error: UnicodeError) -> tuple[str, int]:
    """Replace characters that cannot be encoded by ASCII, as an error handler of `codecs`."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_IN_ASCII.get(letter, "?") for letter in error.object[error.start : error.end]), error.end


codecs.register_error(_NAME, _in_ascii)
