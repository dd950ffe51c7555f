"""A line on the terminal that says how far long work is."""

from __future__ import annotations

import sys
import time
from types import TracebackType

_PATIENCE = 1.0  # seconds before anything is shown
_INTERVAL = 0.2  # seconds between two updates


class Progress:
    """Show on standard error how much of some work is done, if that is a terminal and the work is long.

    Parameters
    ----------
    what : str
        What is being done.

    Examples
    --------
    >>> with Progress("counting") as progress:
    ...     for i in range(10):
    ...         progress((i + 1) / 10)
    """

    def __init__(self, what: str) -> None:
        self._what = what
        self._began = time.monotonic()
        self._shown = 0.0  # when it was last shown; 0 before

    def __call__(self, share: float) -> None:
        """Say that this share, from 0 to 1, is done."""
        now = time.monotonic()
        if now - self._began < _PATIENCE or now - self._shown < _INTERVAL or not sys.stderr.isatty():
            return
        self._shown = now
        left = (now - self._began) * (1 - share) / share
        bar = "#" * round(30 * share)
        sys.stderr.write(f"\r{self._what} [{bar:30}] {share:4.0%}, {left:.0f} s left \x1b[K")
        sys.stderr.flush()

    def __enter__(self) -> Progress:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Clear the line."""
        if self._shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()
