"""The parser of every command: errors are one line, and suggest the option that was probably meant."""

from __future__ import annotations

import argparse
import difflib
import itertools
import re
import sys
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn

_ARGUMENT = re.compile(r"(\w[\w.]*)(?:\[\d+\])*:\s")


class Parser(argparse.ArgumentParser):
    """An `argparse.ArgumentParser` with one-line errors. Subcommands use the same class.

    The parser of the command that was chosen is in the namespace, as ``parser``.
    """

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        self._implied: str | None = None
        self._first: tuple[str, ...] = ()
        self._words: Sequence[str] = ()
        self._others: list[argparse.Action] = []
        if self.add_help:
            add_plugin(self)

    def imply(self, command: str, commands: Any) -> None:
        """Imply a subcommand: `command` runs if the first argument names none of `commands`."""
        self._implied, self._first = command, (*commands.choices, "-h", "--help")

    def error(self, message: str) -> NoReturn:
        """Print one line, and exit with status 2."""
        missing = message.startswith("the following arguments are required")
        blamed = (a for a in self._actions if missing or message.startswith(f"argument {'/'.join(a.option_strings)}:"))
        hint = next(filter(None, map(self._hint, blamed)), "")
        self.exit(2, f"{self.prog}: error: {' '.join(message.split())}{hint} (see {self.prog} --help)\n")

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse all arguments; a subcommand refuses unknown ones itself, since it can suggest its options."""
        if self._implied and args and args[0] not in self._first:
            args = [self._implied, *args]
        self._words = sys.argv[1:] if args is None else args
        namespace, unknown = super().parse_known_args(args, namespace)
        if not hasattr(namespace, "parser"):  # of a subcommand
            namespace.parser = self
        if unknown:
            options = (name for action in self._actions for name in action.option_strings)
            self.error(f"unrecognized arguments: {' '.join(unknown)}{meant(unknown, options)}")
        return namespace, unknown

    def also_reads(self, *parsers: argparse.ArgumentParser) -> None:
        """Let `as_typed` know the options of parsers that the command itself uses.

        Parameters
        ----------
        *parsers : ArgumentParser
            The parsers.
        """
        self._others += [action for parser in parsers for action in parser._actions]

    def as_typed(self, message: str) -> str:
        """Return an error with the argument at its start as users type it: ``--at-ms: ...`` for ``at_ms: ...``.

        Parameters
        ----------
        message : str
            The error. It stays as it is if it begins with no argument of this command.

        Returns
        -------
        str
            The error. If the argument is an option that may have taken words of another argument, the error says so.

        Examples
        --------
        >>> parser = Parser(prog="score")
        >>> _ = parser.add_argument("--at-ms", type=float)
        >>> parser.as_typed("at_ms: 85 ms is not a whole number of frames")
        '--at-ms: 85 ms is not a whole number of frames'
        >>> parser.as_typed("gt: nan at index (0, 0, 0)")
        'gt: nan at index (0, 0, 0)'
        """
        match = _ARGUMENT.match(message)
        action = match and self._called(match[1])
        if not match or not action:
            return message
        words = self._words_of(action)[1:] if action.type is None else []
        hint = self._hint(action) if {*re.findall(r"'(.*?)'", message)} & {*words} else ""
        return f"{self._name(action)}: {message[match.end() :]}{hint}"

    def _called(self, name: str) -> argparse.Action | None:
        """Return the argument of a name, or of a last part such as ``lr`` of ``recipe.lr``; None if several have it."""
        actions = (*self._actions, *self._others)
        found = [action for action in actions if f".{action.dest}".endswith(f".{name}")]
        for some in ([a for a in found if self._named(a)], [a for a in found if a.dest == name], found):
            if len(some) == 1:
                return some[0]
        return None

    def _named(self, action: argparse.Action) -> str | None:
        """Return the option of an argument among the words of the command line, or None."""
        words = {word.partition("=")[0] for word in self._words}
        return next((option for option in action.option_strings if option in words), None)

    def _name(self, action: argparse.Action) -> str:
        if action.option_strings:
            return self._named(action) or max(action.option_strings, key=len)
        return action.metavar if isinstance(action.metavar, str) else action.dest

    def _words_of(self, action: argparse.Action) -> list[str]:
        """Return the words after an option, up to the next option."""
        option, words = self._named(action), [word.partition("=")[0] for word in self._words]
        after = self._words[words.index(option) + 1 :] if option in words else []
        return list(itertools.takewhile(lambda word: word[:1] != "-", after))

    def _hint(self, action: argparse.Action) -> str:
        """Return a hint if an option may have taken words that were meant for an argument without an option."""
        places = [self._name(other) for other in self._actions if not other.option_strings and other.nargs != "A..."]
        if action.nargs != "+" or not places or not self._words_of(action):
            return ""
        option = self._named(action)
        return f"; {option} takes every word up to the next option, so give {' and '.join(places)} before it"


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
