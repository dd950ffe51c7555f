"""Names of models: one line each, never empty, unique."""

from __future__ import annotations

import os
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterable
from pathlib import Path


def one_line(name: str) -> str:
    r"""Return a name without characters that would break a line of a table or a text file.

    Control characters become blanks; characters of a file system that UTF-8 lacks become the replacement character.

    Examples
    --------
    >>> one_line(" my\n model ")
    'my model'
    """
    kinds = {"Cc": " ", "Cs": "\N{REPLACEMENT CHARACTER}"}
    return " ".join("".join(kinds.get(unicodedata.category(letter), letter) for letter in name).split())


def model_name(name: str) -> str:
    """Return the name of a model on one line.

    Raises
    ------
    ValueError
        If the name has no visible character.
    """
    line = one_line(name)
    if not any(letter.isprintable() and not letter.isspace() for letter in line):
        raise ValueError(f"the name of a model is empty: {name!r}")
    return line


def names_of_paths(paths: Iterable[Path], *, taken: Collection[str] = ()) -> dict[str, Path]:
    """Name models by their paths: by the last part, and by as many parts before it as make the name unique.

    The last part is the name of a folder, or of a file without its suffix; ``MODEL/samples.h5`` is called ``MODEL``.

    Parameters
    ----------
    paths : iterable of Path
        A folder or a file for each model.
    taken : collection of str, optional
        Names with another meaning: a path with such an ending is named with the part before it.

    Returns
    -------
    dict of str to Path
        Paths by name, in their order.

    Raises
    ------
    ValueError
        If a path is a duplicate, or two paths differ only in the suffix or in blanks.

    Examples
    --------
    >>> list(names_of_paths([Path("/runs/walking"), Path("/runs2/walking"), Path("/runs/eating.h5")]))
    ['runs/walking', 'runs2/walking', 'eating']
    >>> list(names_of_paths([Path("/mine/linear")], taken=["linear"]))
    ['mine/linear']
    """
    files: dict[tuple[str, ...], Path] = {}
    for path in paths:
        parts = _parts(path)
        if parts in files:
            raise ValueError(f"{path}: duplicate model {parts[-1]!r}, also in {files[parts]}")
        files[parts] = path
    lengths = dict.fromkeys(files, 1)
    while True:
        names = {parts: "/".join(parts[-length:]) for parts, length in lengths.items()}
        count = Counter([*names.values(), *taken])
        duplicates = [parts for parts, name in names.items() if count[name] > 1]
        if not duplicates:
            return {name: files[parts] for parts, name in names.items()}
        for parts in duplicates:
            lengths[parts] += 1


def _parts(path: Path) -> tuple[str, ...]:
    """Return the parts of the absolute path of a model; a link keeps its name."""
    whole = Path(os.path.abspath(path))  # noqa: PTH100 - resolve() follows links
    if not path.is_dir():
        whole = whole.parent if whole.stem == "samples" else whole.with_suffix("")
    *folders, last = whole.parts[1:] or [""]
    return (whole.drive, *(one_line(folder) for folder in folders), model_name(last))
