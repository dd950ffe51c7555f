"""System errors that name the operation."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def doing(what: str) -> Iterator[None]:
    """Name the operation and the file in an OSError of the block.

    Parameters
    ----------
    what : str
        The operation, such as ``'reading the votes'``.

    Returns
    -------
    context manager
        A context manager for the block.

    Raises
    ------
    OSError
        The error of the block, with the file and `what` before its message.

    Examples
    --------
    >>> with doing("reading the votes"):
    ...     open("votes.csv")
    Traceback (most recent call last):
    FileNotFoundError: [Errno 2] votes.csv: reading the votes: No such file or directory
    """
    try:
        yield
    except OSError as error:
        file = "" if error.filename is None else f"{error.filename}: "
        raise OSError(error.errno, f"{file}{what}: {error.strerror or error}") from error
