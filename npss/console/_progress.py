"""The progress of long work: a bar on a terminal; a line now and then in a log."""

from __future__ import annotations

import sys
import time
from types import TracebackType

_PATIENCE = 1.0  # seconds before anything is shown
_INTERVAL = 0.2  # seconds between two updates
_FIRST, _EVERY = 10.0, 60.0  # seconds before the first plain line, and between two


class Progress:
    """Show the progress of long work on standard error.

    Parameters
    ----------
    what : str
        The name of the work.
    done : float, optional
        The share done before, if work is resumed.

    Examples
    --------
    >>> with Progress("counting") as progress:
    ...     for i in range(10):
    ...         progress((i + 1) / 10)
    """

    def __init__(self, what: str, *, done: float = 0.0) -> None:
        self._what = what
        self._done = done
        self._began = time.monotonic()
        self._shown = 0.0  # time of the last update; 0 before the first
        self._next = self._began + _FIRST  # time of the next plain line

    def __call__(self, share: float) -> None:
        """Report that this share, from 0 to 1, is done."""
        now = time.monotonic()
        if share <= self._done:
            return
        remaining = duration((now - self._began) * (1 - share) / (share - self._done))
        if sys.stderr.isatty():
            if now - self._began >= _PATIENCE and now - self._shown >= _INTERVAL:
                self._shown = now
                bar = "#" * round(30 * share)
                sys.stderr.write(f"\r{self._what} [{bar:30}] {share:4.0%}, {remaining} left \x1b[K")
                sys.stderr.flush()
        elif now >= self._next:
            self._next = now + _EVERY
            print(f"{self._what}: {share:.1%} done, about {remaining} left", file=sys.stderr, flush=True)

    def __enter__(self) -> Progress:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Clear the line."""
        if self._shown:
            sys.stderr.write("\r\x1b[K")
            sys.stderr.flush()


def duration(seconds: float) -> str:
    """Write a duration in words, to about two digits.

    Parameters
    ----------
    seconds : float
        The duration.

    Returns
    -------
    str
        The duration in seconds, minutes, hours or days.

    Examples
    --------
    >>> [duration(seconds) for seconds in (3.2, 100, 7790, 273_000)]
    ['3 s', '2 min', '2 h 10 min', '3 d 3 h']
    """
    if seconds < 90:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60)
    if minutes < 90:
        return f"{minutes} min"
    hours, minutes = divmod(minutes, 60)
    if hours < 24:
        return f"{hours} h {minutes} min"
    return f"{hours // 24} d {hours % 24} h"
