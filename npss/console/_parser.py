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
    >>> meant(["--recipe.rate", "9"], ["--recipe.lr", "--rate"])
    ''
    """
    options = [(*name.lstrip("-").rpartition("."), name) for name in known]  # of a group, only the rest is compared
    found: dict[str, None] = {}
    for group, _, last in (one.partition("=")[0].lstrip("-").rpartition(".") for one in unknown if one[:1] == "-"):
        names = {tail: name for prefix, _, tail, name in options if prefix == group}
        found |= dict.fromkeys(names[close] for close in difflib.get_close_matches(last, names, 1))
    return f"; did you mean {' '.join(found)}?" if found else ""
