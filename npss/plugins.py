"""Plugins: modules that register metrics, data sources, file formats or models when they are imported.

Commands import a plugin if ``--plugin MODULE`` names it, or if it is installed with an entry point of the group
`GROUP`. Nothing else imports one: a data file or a run can only state that it needs a plugin.
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
_imported: set[str] = set()  # plugins
_named: dict[str, None] = {}  # on the command line, in order

Entry = TypeVar("Entry")


class Registry(Mapping[str, Entry]):
    """Entries of one kind by name: a read-only mapping that plugins extend.

    Parameters
    ----------
    kind : str
        The kind of entries, for messages.
    entries : mapping of str to object, optional
        Built-in entries, which cannot be replaced.

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
        return iter(tuple(self._entries))  # which may be registered meanwhile

    def __len__(self) -> int:
        return len(self._entries)

    def register(self, name: str, entry: Entry, *, replace: bool = False) -> None:
        """Add an entry.

        Parameters
        ----------
        name : str
            Name of the entry.
        entry : object
            The entry.
        replace : bool, optional
            Replace a registered entry, as when a notebook cell is run again.

        Raises
        ------
        TypeError
            If the name is not text.
        ValueError
            If the name is blank, built in, or registered already without `replace`.
        """
        self.register_all({name: entry}, replace=replace)

    def register_all(self, entries: Mapping[str, Entry], *, replace: bool = False) -> None:
        """Add several entries, or none of them.

        Parameters
        ----------
        entries : mapping of str to object
            The entries by name.
        replace : bool, optional
            As for `register`.

        Raises
        ------
        TypeError, ValueError
            As for `register`, for any of the names.
        """
        for name in entries:
            if not isinstance(name, str):
                raise TypeError(f"the name of a {self._kind}: expected text, got {name!r}")
            if not name.strip() or not name.isprintable():
                raise ValueError(f"the name of a {self._kind}: expected printable text, got {name!r}")
            if name in self._built_in or (name in self._entries and not replace):
                plugin = self._plugins.get(name)
                raise ValueError(f"the {self._kind} {name!r} is registered already{f', by {plugin}' if plugin else ''}")
        self._entries |= entries
        if _importing:
            self._plugins |= dict.fromkeys(entries, _importing[-1])

    def plugin(self, name: str) -> str | None:
        """Return the plugin that registered an entry, or None.

        Parameters
        ----------
        name : str
            Name of the entry.

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

    Installed modules come first. A module that is not installed is imported from the current folder, which becomes the
    last entry of the import path.

    Parameters
    ----------
    name : str
        Name of the module, such as ``my.module``.

    Raises
    ------
    ValueError
        If it is not the name of a module.
    ImportError
        If the import fails. The message names the plugin, and the line that raised the error.
    """
    if not _MODULE.fullmatch(name) or name.endswith(".py"):
        raise ValueError(f"--plugin: expected the name of a module, such as my.module, got {name!r}")
    package = name.partition(".")[0]
    if package not in sys.modules and find_spec(package) is None:
        sys.path.append(str(Path.cwd()))
    _import(name, f"--plugin {name}")
    _named[name] = None


def load_installed() -> None:
    """Import installed plugins: the modules of the entry points of `GROUP`.

    Raises
    ------
    ImportError
        If an import fails. The message names the plugin, and the line that raised the error.
    """
    for point in sorted(entry_points(group=GROUP)):
        _import(point.module, f"the installed plugin {point.name} ({point.module})")


def with_plugins(arguments: Sequence[str]) -> list[str]:
    """Add an option to the arguments of a command for each plugin that `load` has imported.

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
    """Check that the plugins that a file needs are imported; import none.

    Parameters
    ----------
    plugins : object
        The value in the file: a list of names of modules.

    Raises
    ------
    ValueError
        If it is not such a list, or a plugin is not imported. The message then gives the option that imports it.
    """
    if not isinstance(plugins, list) or not all(isinstance(name, str) and _MODULE.fullmatch(name) for name in plugins):
        raise ValueError(f"plugins: expected a list of names of modules, got {plugins!r}")
    if missing := [name for name in plugins if name not in sys.modules]:
        options = " ".join(f"--plugin {name}" for name in missing)
        raise ValueError(f"a plugin is required; if you trust the module, add {options}")


def raised_by(error: BaseException) -> str | None:
    """Return the plugin in which an error, or one of its causes, was raised.

    Parameters
    ----------
    error : BaseException
        An error that was caught.

    Returns
    -------
    str or None
        The name of the plugin, with the file and the line that raised the error, or called what did; None if no plugin
        that `load` or `load_installed` imported did.
    """
    cause: BaseException | None = error
    while cause is not None:
        for frame, line in reversed(list(traceback.walk_tb(cause.__traceback__))):
            module = str(frame.f_globals.get("__name__"))
            if plugin := next((name for name in _imported if f"{module}.".startswith(f"{name}.")), None):
                return f"raised in the plugin {plugin}: {frame.f_code.co_filename}, line {line}"
        cause = cause.__cause__ or cause.__context__
    return None


def _import(name: str, what: str) -> None:
    """Import a module; the error begins with `what`."""
    _importing.append(name)
    try:
        importlib.import_module(name)
        _imported.add(name)
    except ModuleNotFoundError as error:
        if error.name is None or not f"{name}.".startswith(f"{error.name}."):
            raise ImportError(f"{what}: {error}{_place(error)}") from error
        where = "installed or in the current folder"
        if package := sys.modules.get(name.partition(".")[0]):  # of that name there is only one
            where = f"in {getattr(package, '__file__', None) or next(iter(package.__path__))}"
        raise ImportError(f"{what}: there is no module {error.name!r}, {where}") from None
    except (Exception, SystemExit) as error:
        raise ImportError(f"{what}: {type(error).__name__}: {error}{_place(error)}") from error
    finally:
        _importing.pop()


def _place(error: BaseException) -> str:
    """Return the line of a plugin that raised an error; a SyntaxError names its line itself."""
    ours = (Path(__file__).parent, Path(importlib.__file__).parent)
    for frame in reversed(traceback.extract_tb(error.__traceback__)):
        file = Path(frame.filename)
        if file.is_file() and not any(file.is_relative_to(folder) for folder in ours):
            return f" ({file}, line {frame.lineno})"
    return ""
