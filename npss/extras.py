"""The install hints for optional packages, in one wording for all messages."""

from __future__ import annotations

__all__ = ["install_hint"]

#: Anybody may register the names on an index before this project does, so hints install from the project's folder.
HINT = "in the project's folder: pip install {}"


def install_hint(extras: str, *, baselines: bool = False) -> str:
    """Return the command that installs extras.

    Parameters
    ----------
    extras : str
        Names of the extras, separated by commas.
    baselines : bool, optional
        Whether they are extras of ``npss-baselines`` instead of ``npss-metric``.

    Returns
    -------
    str
        The end of a message about a missing package.

    Examples
    --------
    >>> install_hint("h5")
    "in the project's folder: pip install '.[h5]'"
    >>> install_hint("manifold", baselines=True)
    "in the project's folder: pip install . './baselines[manifold]'"
    """
    return HINT.format(f". './baselines[{extras}]'" if baselines else f"'.[{extras}]'")
