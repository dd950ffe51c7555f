"""What a command prints: signs such as † in ASCII where the encoding lacks them, and warnings in one line."""

from __future__ import annotations

import codecs
import io
import os
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

_NAME = "npss-ascii"  # of the error handler
_IN_ASCII = {"†": "^", "–": "-", "—": "-", "−": "-", "∞": "inf", "…": "...", "×": "x", "·": "*", "µ": "u", "μ": "u"}


def allow_any_text() -> None:
    """Let standard output replace what it cannot encode, unless it has been told what to do then."""
    if isinstance(sys.stdout, io.TextIOWrapper) and sys.stdout.errors in ("strict", "surrogateescape"):
        sys.stdout.reconfigure(errors=_NAME)


def discard_output() -> None:
    """Give up what standard output could not write, lest Python tries again, and complains again, at its end."""
    try:
        print(end="", flush=True)
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


@contextmanager
def warnings_in_one_line(prog: str) -> Iterator[None]:
    """Let a warning of the block be one line that names the program, and no line of its code."""

    def line(message: Warning | str, *_: object, **__: object) -> str:
        return f"{prog}: warning: {' '.join(str(message).split())}\n"

    before = warnings.formatwarning
    warnings.formatwarning = line
    try:
        yield
    finally:
        warnings.formatwarning = before


def _in_ascii(error: UnicodeError) -> tuple[str, int]:
    """Return ASCII for the characters that cannot be encoded, as an error handler of `codecs`."""
    if not isinstance(error, UnicodeEncodeError):
        raise error
    return "".join(_IN_ASCII.get(letter, "?") for letter in error.object[error.start : error.end]), error.end


codecs.register_error(_NAME, _in_ascii)
