"""The action of a CMU clip, in a word."""

from __future__ import annotations

import re

#: Patterns of the labels in CMU's descriptions. Of two that match at the same place, the upper one wins.
KEYWORDS = {
    "jumping jacks": r"jumping jacks",
    "jump": r"jumps?",
    "walk": r"walk",
    "run": r"run|jog",
    "dance": r"dance",
    "climb": r"climb",
    "soccer": r"soccer",
    "basketball": r"basketball",
    "laugh": r"laugh",
    "drink": r"drink",
    "sit": r"sit",
    "swordplay": r"swordplay",
    "punch": r"punch|boxing",
}
_ANY = re.compile("|".join(f"(?P<k{i}>\\b(?:{pattern})\\b)" for i, pattern in enumerate(KEYWORDS.values())))


def label_of(description: str) -> str:
    """Return the first action in a CMU description, or ``""`` if it has none of `KEYWORDS`.

    Examples
    --------
    >>> label_of("playground - climb, jump down, dangle, legs push off against")
    'climb'
    >>> label_of("unscrew bottlecap, drink soda")
    'drink'
    >>> label_of("wash windows")
    ''
    """
    match = _ANY.search(description.lower())
    return list(KEYWORDS)[int(str(match.lastgroup)[1:])] if match else ""
