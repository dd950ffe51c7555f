"""The parser of every command: what is wrong with its arguments is one line, which names the option that was meant."""

from __future__ import annotations

import argparse
import difflib
from collections.abc import Iterable, Sequence
from typing import Any, NoReturn


class Parser(argparse.ArgumentParser):
    """An `argparse.ArgumentParser` whose errors are one line. Its subcommands have parsers of the same class."""

    def error(self, message: str) -> NoReturn:
        """Print one line, and exit with status 2."""
        self.exit(2, f"{self.prog}: error: {' '.join(message.split())} (see {self.prog} --help)\n")

    def parse_known_args(self, *arguments: Any, **options: Any) -> Any:
        """Parse all arguments there are: a subcommand refuses what it does not know itself, as it knows its options."""
        namespace, unknown = super().parse_known_args(*arguments, **options)
        if unknown:
            known = (name for action in self._actions for name in action.option_strings)
            self.error(f"unrecognized arguments: {' '.join(unknown)}{meant(unknown, known)}")
        return namespace, unknown


def meant(unknown: Sequence[str], known: Iterable[str]) -> str:
    """Return what may have been meant by arguments that there are not, to be added to a message; or nothing.

    Examples
    --------
    >>> meant(["--iteration", "9"], ["--iterations", "--seed"])
    '; did you mean --iterations?'
    >>> meant(["9"], ["--iterations", "--seed"])
    ''
    """
    names = list(known)
    close = [difflib.get_close_matches(one.partition("=")[0], names, 1) for one in unknown if one.startswith("-")]
    found = dict.fromkeys(name for names in close for name in names)
    return f"; did you mean {' '.join(found)}?" if found else ""
