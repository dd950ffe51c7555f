"""The parser of every command: errors are one line, and suggest the option that was probably meant."""

from __future__ import annotations

import argparse
import difflib
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn


class Parser(argparse.ArgumentParser):
    """An `argparse.ArgumentParser` with one-line errors. Subcommands use the same class."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._implied: str | None = None
        self._first: tuple[str, ...] = ()
        if self.add_help:
            add_plugin(self)

    def imply(self, command: str, commands: Any) -> None:
        """Imply a subcommand: `command` runs if the first argument names none of `commands`."""
        self._implied, self._first = command, (*commands.choices, "-h", "--help")

    def error(self, message: str) -> NoReturn:
        """Print one line, and exit with status 2."""
        self.exit(2, f"{self.prog}: error: {' '.join(message.split())} (see {self.prog} --help)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse all arguments; a subcommand refuses unknown ones itself, since it can suggest its options."""
        if self._implied and args and args[0] not in self._first:
            args = [self._implied, *args]
        namespace, unknown = super().parse_known_args(args, namespace)
        if unknown:
            options = (name for action in self._actions for name in action.option_strings)
            self.error(f"unrecognized arguments: {' '.join(unknown)}{meant(unknown, options)}")
        return namespace, unknown


def add_plugin(parser: argparse.ArgumentParser) -> None:
    """Add ``--plugin`` to the help of a command; `run` reads it before it makes the parser.

    Parameters
    ----------
    parser : ArgumentParser
        The parser of the command.
    """
    parser.add_argument(
        "--plugin",
        type=_abbreviated,
        default=argparse.SUPPRESS,
        metavar="MODULE",
        help="import MODULE first, to use what it registers (repeatable)",
    )


def _abbreviated(module: str) -> NoReturn:
    """Refuse an abbreviation such as ``--plug``: `split_plugins` missed it, and it is too late to import a module."""
    raise argparse.ArgumentTypeError(f"cannot be abbreviated, write --plugin {module}")


def split_plugins(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the plugins in `arguments`, at any place, and all other arguments.

    Raises
    ------
    ValueError
        If the last argument is an option without its plugin.

    Examples
    --------
    >>> split_plugins(["--plugin", "a", "score", "gt.npy", "--plugin=b.c", "pred.npy"])
    (['a', 'b.c'], ['score', 'gt.npy', 'pred.npy'])
    """
    plugins, others = [], []
    words = iter(arguments)
    for word in words:
        option, _, plugin = word.partition("=")
        if word == "--":  # no options follow
            others += [word, *words]
        elif option != "--plugin":
            others.append(word)
        elif plugin := plugin or next(words, ""):
            plugins.append(plugin)
        else:
            raise ValueError("--plugin: expected the name of a module, such as my.module")
    return plugins, others


def meant(unknown: Sequence[str], known: Iterable[str]) -> str:
    """Suggest options for unknown arguments.

    Parameters
    ----------
    unknown : sequence of str
        The unknown arguments; only options among them count.
    known : iterable of str
        All known options.

    Returns
    -------
    str
        The end of an error message; empty if no option is close.

    Examples
    --------
    >>> meant(["--iteration", "9"], ["--iterations", "--seed"])
    '; did you mean --iterations?'
    >>> meant(["--recipe.rate", "9"], ["--recipe.lr", "--rate"])
    ''
    """
    options = [(*name.lstrip("-").rpartition("."), name) for name in known]  # names are compared within their group
    matches: dict[str, None] = {}
    for group, _, last in (word.partition("=")[0].lstrip("-").rpartition(".") for word in unknown if word[:1] == "-"):
        names = {tail: name for prefix, _, tail, name in options if prefix == group}
        matches |= dict.fromkeys(names[close] for close in difflib.get_close_matches(last, names, 1))
    return f"; did you mean {' '.join(matches)}?" if matches else ""
