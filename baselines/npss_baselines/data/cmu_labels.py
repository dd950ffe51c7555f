"""What is done in a clip of CMU's, in a word."""

from __future__ import annotations

import re

#: What is looked for in CMU's descriptions, by label. Of two that begin at one place, the one further up wins.
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
    """Return the action that comes first in a description of CMU's, or ``""`` where none of `KEYWORDS` does.

    Examples
    --------
    >>> label_of("playground - climb, jump down, dangle, legs push off against")
    'climb'
    >>> label_of("unscrew bottlecap, drink soda")
    'drink'
    >>> label_of("wash windows")
    ''
    """
    found = _ANY.search(description.lower())
    return list(KEYWORDS)[int(str(found.lastgroup)[1:])] if found else ""
