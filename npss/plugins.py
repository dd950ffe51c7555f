"""Plugins: modules that register metrics, data sources, file formats or models of one's own when they are imported.

Commands import a plugin if ``--plugin MODULE`` names it, or if it is installed with an entry point of the group
`GROUP`. Nothing else imports one: files of data and runs may say that they need a plugin, and no more.
"""

from __future__ import annotations

import importlib
import re
import sys
import traceback
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import entry_points
from importlib.util import find_spec
from pathlib import Path
from typing import TypeVar

__all__ = ["GROUP", "Registry", "load", "require", "with_plugins"]

#: The group of the entry points that installed plugins declare.
GROUP = "npss.plugins"

_MODULE = re.compile(r"[^\W\d]\w*(\.[^\W\d]\w*)*")
_importing: list[str] = []  # plugins, the innermost last
_named: dict[str, None] = {}  # by the command line, in their order

Entry = TypeVar("Entry")


class Registry(Mapping[str, Entry]):
    """What there is of one kind, by name: a read-only mapping, to which plugins add.

    Parameters
    ----------
    kind : str
        What the entries are, for messages.
    entries : mapping of str to object, optional
        What is in it from the beginning, and stays.

    Examples
    --------
    >>> colours = Registry("colour", {"red": 0xFF0000})
    >>> colours.register("blue", 0x0000FF)
    >>> list(colours)
    ['red', 'blue']
    >>> colours.register("blue", 0x000088)
    Traceback (most recent call last):
    ValueError: the colour 'blue' is registered already
    """

    def __init__(self, kind: str, entries: Mapping[str, Entry] | None = None) -> None:
        self._kind = kind
        self._entries = dict(entries or {})
        self._built_in = frozenset(self._entries)
        self._plugins: dict[str, str] = {}

    def __getitem__(self, name: str) -> Entry:
        return self._entries[name]

    def __iter__(self) -> Iterator[str]:
        return iter(self._entries)

    def __len__(self) -> int:
        return len(self._entries)

    def register(self, name: str, entry: Entry, *, replace: bool = False) -> None:
        """Add an entry.

        Parameters
        ----------
        name : str
            What it is called from now on.
        entry : object
            The entry.
        replace : bool, optional
            Take the place of a registered entry, as a notebook does whose cell is run again.

        Raises
        ------
        TypeError
            If the name is not a text.
        ValueError
            If it is blank, or registered already and not to be replaced, or built in.
        """
        if not isinstance(name, str):
            raise TypeError(f"the name of a {self._kind}: expected a text, got {name!r}")
        if not name.strip() or not name.isprintable():
            raise ValueError(f"the name of a {self._kind}: expected a text that can be printed, got {name!r}")
        if name in self._built_in or (name in self._entries and not replace):
            plugin = self._plugins.get(name)
            raise ValueError(f"the {self._kind} {name!r} is registered already{f', by {plugin}' if plugin else ''}")
        self._entries[name] = entry
        if _importing:
            self._plugins[name] = _importing[-1]

    def plugin(self, name: str) -> str | None:
        """Return the plugin that registered an entry; None if there was none.

        Parameters
        ----------
        name : str
            Of an entry.

        Raises
        ------
        KeyError
            If there is no such entry.
        """
        if name not in self._entries:
            raise KeyError(name)
        return self._plugins.get(name)


def load(name: str) -> None:
    """Import a plugin.

    What is installed comes first; a module that is not is looked for in the current folder, which then is the last
    entry of the import path.

    Parameters
    ----------
    name : str
        Its module, such as ``my.module``.

    Raises
    ------
    ValueError
        If it is not the name of a module.
    ImportError
        If it cannot be imported: names the plugin, and where in it an error was raised.
    """
    if not _MODULE.fullmatch(name) or name.endswith(".py"):
        raise ValueError(f"--plugin: expected the name of a module, such as my.module, got {name!r}")
    package = name.partition(".")[0]
    if package not in sys.modules and find_spec(package) is None:
        sys.path.append(str(Path.cwd()))
    _import(name, f"--plugin {name}")
    _named[name] = None


def load_installed() -> None:
    """Import the plugins that are installed: the modules of the entry points of `GROUP`.

    Raises
    ------
    ImportError
        If one cannot be imported: names it, and where in it an error was raised.
    """
    for point in sorted(entry_points(group=GROUP)):
        _import(point.module, f"the installed plugin {point.name} ({point.module})")


def with_plugins(arguments: Sequence[str]) -> list[str]:
    """Return the arguments of a command with the options that name the plugins which `load` has imported.

    Parameters
    ----------
    arguments : sequence of str
        The arguments.

    Returns
    -------
    list of str
        ``[*arguments, "--plugin", "my.module", ...]``
    """
    return [*arguments, *(word for name in _named for word in ("--plugin", name))]


def require(plugins: object) -> None:
    """Make sure that the plugins which a file states are imported; none is imported here.

    Parameters
    ----------
    plugins : object
        What the file states: a list of the names of modules.

    Raises
    ------
    ValueError
        If it is no such list; if one is not imported: gives the option that imports it.
    """
    if not isinstance(plugins, list) or not all(isinstance(name, str) and _MODULE.fullmatch(name) for name in plugins):
        raise ValueError(f"plugins: expected a list of modules, got {plugins!r}")
    if missing := [name for name in plugins if name not in sys.modules]:
        options = " ".join(f"--plugin {name}" for name in missing)
        raise ValueError(f"it needs what a plugin registers; if you trust the module, add {options}")


def _import(name: str, what: str) -> None:
    """Import a module; `what` begins the message of the error."""
    _importing.append(name)
    try:
        importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise ImportError(f"{what}: {error}{_place(error)}") from error
        raise ImportError(f"{what}: there is no module {error.name!r}, installed or in the current folder") from None
    except Exception as error:
        raise ImportError(f"{what}: {type(error).__name__}: {error}{_place(error)}") from error
    finally:
        _importing.pop()


def _place(error: Exception) -> str:
    """Return the line of a plugin that raised an error; one of syntax says so itself."""
    ours = (Path(__file__).parent, Path(importlib.__file__).parent)
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        file = Path(frame.filename)
        if file.is_file() and not any(file.is_relative_to(folder) for folder in ours):
            return f" ({file}, line {frame.lineno})"
    return ""
