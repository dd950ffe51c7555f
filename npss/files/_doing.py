"""Errors of the system that say what was being done."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def doing(what: str) -> Iterator[None]:
    """Let an OSError of the block say what was being done, and to which file.

    Parameters
    ----------
    what : str
        What the block does, such as ``'reading the votes'``.

    Returns
    -------
    context manager
        Of the block.

    Raises
    ------
    OSError
        That of the block, with `what` in front of its message.

    Examples
    --------
    >>> with doing("reading the votes"):
    ...     open("votes.csv")
    Traceback (most recent call last):
    FileNotFoundError: [Errno 2] reading the votes: votes.csv: No such file or directory
    """
    try:
        yield
    except OSError as error:
        file = "" if error.filename is None else f"{error.filename}: "
        raise OSError(error.errno, f"{what}: {file}{error.strerror or error}") from error
