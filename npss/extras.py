"""The optional packages: what each is for, and the install hints in one wording for all messages."""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["EXTRAS", "Extra", "install_hint"]

#: Anybody may register the names on an index before this project does, so hints install from the project's folder.
HINT = "in the project's folder: pip install {}"


class Extra(NamedTuple):
    """What an extra of ``npss-metric`` brings.

    Attributes
    ----------
    package : str
        The name of the package.
    purpose : str
        What it is for.
    """

    package: str
    purpose: str


#: The extras of ``npss-metric``, except for those that only collect others.
EXTRAS = {
    "h5": Extra("h5py", ".h5 files"),
    "pandas": Extra("pandas", "leaderboards as tables"),
    "plot": Extra("matplotlib", "pictures and reports"),
    "study": Extra("scipy", "exact tests of user studies"),
    "torch": Extra("torch", "NPSS of tensors and as a loss"),
    "torchmetrics": Extra("torchmetrics", "NPSS in training loops"),
    "completion": Extra("shtab", "completion of commands in a shell"),
}


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
