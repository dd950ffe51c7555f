"""Versions of installed packages."""

from __future__ import annotations

import platform
from importlib import metadata


def installed(package: str) -> str | None:
    """Return the version of a package.

    Parameters
    ----------
    package : str
        The name under which it is installed.

    Returns
    -------
    str or None
        The version; None if the package is missing.

    Examples
    --------
    >>> installed("a-package-that-nobody-has") is None
    True
    """
    try:
        return metadata.version(package)
    except metadata.PackageNotFoundError:
        return None


def versions(prog: str, version: str, *packages: str) -> str:
    """Return the version of a command and of what it uses, in one line.

    Parameters
    ----------
    prog, version : str
        The name of the command, and its version.
    *packages : str
        The packages that it uses.

    Returns
    -------
    str
        The line.

    Examples
    --------
    >>> versions("npss", "1.0").startswith("npss 1.0 (Python 3.")
    True
    """
    used = [f"{package} {installed(package) or 'missing'}" for package in packages]
    return f"{prog} {version} ({', '.join([*used, f'Python {platform.python_version()}'])})"
