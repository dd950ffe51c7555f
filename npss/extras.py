"""What to install where an optional package is missing, in the words that every message has."""

from __future__ import annotations

__all__ = ["install_hint"]

#: Until the names are registered on an index, anybody may take them there, so hints install from the project's folder.
HINT = "in the project's folder: pip install {}"


def install_hint(extras: str, *, baselines: bool = False) -> str:
    """Return how to install extras.

    Parameters
    ----------
    extras : str
        Their names, separated by commas.
    baselines : bool, optional
        Whether they are extras of ``npss-baselines``, and not of ``npss-metric``.

    Returns
    -------
    str
        The end of a message that says what is missing.

    Examples
    --------
    >>> install_hint("h5")
    "in the project's folder: pip install '.[h5]'"
    >>> install_hint("manifold", baselines=True)
    "in the project's folder: pip install . './baselines[manifold]'"
    """
    return HINT.format(f". './baselines[{extras}]'" if baselines else f"'.[{extras}]'")
