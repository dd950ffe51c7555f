"""Names of models: one line each, never empty, and such that two models are told apart."""

from __future__ import annotations

import os
import unicodedata
from collections import Counter
from collections.abc import Collection, Iterable
from pathlib import Path


def one_line(name: str) -> str:
    r"""Return a name without what would break the line of a table, or a file of text.

    Control characters become blanks, and what a file system holds but UTF-8 does not becomes the replacement character.

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
        If nothing of it can be seen.
    """
    line = one_line(name)
    if not any(letter.isprintable() and not letter.isspace() for letter in line):
        raise ValueError(f"the name of a model is empty: {name!r}")
    return line


def names_of_paths(paths: Iterable[Path], *, taken: Collection[str] = ()) -> dict[str, Path]:
    """Name models by their paths: by the last part, and by as many before it as it takes to tell two apart.

    The last part is the name of a folder, or of a file without its suffix; ``MODEL/samples.h5`` is called ``MODEL``.

    Parameters
    ----------
    paths : iterable of Path
        A folder or a file for each model.
    taken : collection of str, optional
        Names that mean something else: a path that ends so is named with the part before it.

    Returns
    -------
    dict of str to Path
        By name, in the order of the paths.

    Raises
    ------
    ValueError
        If a path is there twice, or two differ in the suffix or in blanks alone.

    Examples
    --------
    >>> list(names_of_paths([Path("/runs/walking"), Path("/runs2/walking"), Path("/runs/eating.h5")]))
    ['runs/walking', 'runs2/walking', 'eating']
    >>> list(names_of_paths([Path("/mine/linear")], taken=["linear"]))
    ['mine/linear']
    """
    found: dict[tuple[str, ...], Path] = {}
    for path in paths:
        parts = _parts(path)
        if parts in found:
            raise ValueError(f"{path}: there is another file of a model {parts[-1]!r}, {found[parts]}")
        found[parts] = path
    lengths = dict.fromkeys(found, 1)
    while True:
        names = {parts: "/".join(parts[-length:]) for parts, length in lengths.items()}
        count = Counter([*names.values(), *taken])
        alike = [parts for parts, name in names.items() if count[name] > 1]
        if not alike:
            return {name: found[parts] for parts, name in names.items()}
        for parts in alike:
            lengths[parts] += 1


def _parts(path: Path) -> tuple[str, ...]:
    """Return the parts of the absolute path of a model; links are named as they are, not as what they point to."""
    whole = Path(os.path.abspath(path))  # noqa: PTH100 - resolve() follows links
    if not path.is_dir():
        whole = whole.parent if whole.stem == "samples" else whole.with_suffix("")
    *folders, last = whole.parts[1:] or [""]
    return (whole.drive, *(one_line(folder) for folder in folders), model_name(last))
