"""Read JSON strictly: what is no JSON, or has two meanings, is a ValueError."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from npss.files._text import read_text


def parse_json(text: str) -> Any:
    """Return what a text in JSON says.

    Parameters
    ----------
    text : str
        The text.

    Returns
    -------
    object
        A dict, list, str, int, float, bool or None.

    Raises
    ------
    ValueError
        If it is not JSON, is nested too deep to be read, or names a field of an object twice.
    """
    try:
        return json.loads(text, object_pairs_hook=_object)
    except ValueError as error:
        raise ValueError(f"not JSON ({error})") from error
    except RecursionError:
        raise ValueError("not JSON that can be read: nested too deep") from None


def read_json(path: Path) -> Any:
    """Return what a file in JSON says.

    Parameters
    ----------
    path : Path
        The file.

    Returns
    -------
    object
        A dict, list, str, int, float, bool or None.

    Raises
    ------
    ValueError
        If it is not UTF-8 or not JSON, is nested too deep to be read, or names a field of an object twice; names the
        file.
    OSError
        If it cannot be read.
    """
    text = read_text(path)
    try:
        return parse_json(text)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Make an object of its fields, of which Python would keep the last of a name."""
    fields = dict(pairs)
    if len(fields) < len(pairs):
        names = [name for name, _ in pairs]
        twice = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"the field {twice!r} is there twice")
    return fields
