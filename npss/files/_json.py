"""Read JSON strictly: invalid JSON and duplicate fields are errors."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from npss.files._text import read_text


def parse_json(text: str) -> Any:
    """Parse a text in JSON.

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
        If the text is not valid JSON, is nested too deeply, or has an object with a duplicate field.
    """
    try:
        return json.loads(text, object_pairs_hook=_object)
    except ValueError as error:
        raise ValueError(f"invalid JSON ({error})") from error
    except RecursionError:
        raise ValueError("invalid JSON: nested too deeply") from None


def read_json(path: Path) -> Any:
    """Read a JSON file.

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
        If the file is not UTF-8 or not valid JSON, is nested too deeply, or has an object with a duplicate field; names
        the file.
    OSError
        If the file cannot be read.
    """
    text = read_text(path)
    try:
        return parse_json(text)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    """Make an object from its fields; of duplicate ones, Python would keep the last."""
    fields = dict(pairs)
    if len(fields) < len(pairs):
        names = [name for name, _ in pairs]
        duplicate = next(name for name in names if names.count(name) > 1)
        raise ValueError(f"duplicate field {duplicate!r}")
    return fields
