"""Input checks of the study: counts, levels, alternatives; and the import of scipy."""

from __future__ import annotations

from importlib import import_module
from typing import Any, Literal, get_args

from npss.extras import install_hint
from npss.validation import is_integer, is_real, positive_integer

#: The alternative hypothesis: the first proportion compared with the second.
Alternative = Literal["greater", "less", "two-sided"]
ALTERNATIVES: tuple[Alternative, ...] = get_args(Alternative)


def count_of(name: str, value: object, total_name: str, total: object) -> tuple[int, int]:
    """Read a number of successes and the number of trials."""
    n = positive_integer(total_name, total)
    if not is_integer(value):
        raise TypeError(f"{name}: expected a whole number, got {value!r}")
    if not 0 <= value <= n:
        raise ValueError(f"{name}: expected 0 to {total_name} = {n}, got {value!r}")
    return int(value), n


def fraction(name: str, value: object) -> float:
    """Read a number between 0 and 1, exclusive."""
    if not is_real(value):
        raise TypeError(f"{name}: expected a number between 0 and 1, got {value!r}")
    if not 0 < value < 1:
        raise ValueError(f"{name}: expected a number between 0 and 1, exclusive, got {value!r}")
    return float(value)


def scipy_stats(who: str) -> Any:
    """Return the module ``scipy.stats``, which only the exact tests and intervals need."""
    try:
        return import_module("scipy.stats")
    except ImportError:
        raise ImportError(f"{who} needs scipy; {install_hint('study')}") from None
