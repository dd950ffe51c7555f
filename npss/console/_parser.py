"""The parser of every command: what is wrong with its arguments is one line, which names the option that was meant."""

from __future__ import annotations

import argparse
import difflib
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn


class Parser(argparse.ArgumentParser):
    """An `argparse.ArgumentParser` whose errors are one line. Its subcommands have parsers of the same class."""

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._implied: str | None = None
        self._first: tuple[str, ...] = ()
        if self.add_help:
            add_plugin(self)

    def imply(self, command: str, commands: Any) -> None:
        """Let a subcommand be left out, one of `commands`: it is meant where the first argument names none of them."""
        self._implied, self._first = command, (*commands.choices, "-h", "--help")

    def error(self, message: str) -> NoReturn:
        """Print one line, and exit with status 2."""
        self.exit(2, f"{self.prog}: error: {' '.join(message.split())} (see {self.prog} --help)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse all arguments there are: a subcommand refuses what it does not know itself, as it knows its options."""
        if self._implied and args and args[0] not in self._first:
            args = [self._implied, *args]
        namespace, unknown = super().parse_known_args(args, namespace)
        if unknown:
            known = (name for action in self._actions for name in action.option_strings)
            self.error(f"unrecognized arguments: {' '.join(unknown)}{meant(unknown, known)}")
        return namespace, unknown


def add_plugin(parser: argparse.ArgumentParser) -> None:
    """Add ``--plugin`` to the help of a command; `run` has read it before there is a parser.

    Parameters
    ----------
    parser : ArgumentParser
        Of the command.
    """
    parser.add_argument(
        "--plugin",
        type=_abbreviated,
        default=argparse.SUPPRESS,
        metavar="MODULE",
        help="import this module first, for what it registers; may be given several times",
    )


def _abbreviated(module: str) -> NoReturn:
    """Refuse the option where `split_plugins` has not seen it: as ``--plug``, too late to import anything."""
    raise argparse.ArgumentTypeError(f"expected --plugin {module}, not abbreviated")


def split_plugins(arguments: Sequence[str]) -> tuple[list[str], list[str]]:
    """Return the plugins that arguments name, wherever that is, and all other arguments.

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
        if word == "--":  # what follows are no options
            others += [word, *words]
        elif option != "--plugin":
            others.append(word)
        elif plugin := plugin or next(words, ""):
            plugins.append(plugin)
        else:
            raise ValueError("--plugin: expected the name of a module, such as my.module")
    return plugins, others


def meant(unknown: Sequence[str], known: Iterable[str]) -> str:
    """Return what may have been meant by unknown arguments.

    Parameters
    ----------
    unknown : sequence of str
        Arguments as they were given; those that are no options are passed over.
    known : iterable of str
        The options that there are.

    Returns
    -------
    str
        The end of an error message; empty where nothing is close.

    Examples
    --------
    >>> meant(["--iteration", "9"], ["--iterations", "--seed"])
    '; did you mean --iterations?'
    >>> meant(["--recipe.rate", "9"], ["--recipe.lr", "--rate"])
    ''
    """
    options = [(*name.lstrip("-").rpartition("."), name) for name in known]  # of a group, only the rest is compared
    found: dict[str, None] = {}
    for group, _, last in (one.partition("=")[0].lstrip("-").rpartition(".") for one in unknown if one[:1] == "-"):
        names = {tail: name for prefix, _, tail, name in options if prefix == group}
        found |= dict.fromkeys(names[close] for close in difflib.get_close_matches(last, names, 1))
    return f"; did you mean {' '.join(found)}?" if found else ""
