"""The parser of the commands of ``npss-baselines``."""

from __future__ import annotations

from argparse import Namespace
from typing import Any

from npss.console import Parser


class CommandParser(Parser):
    """A parser whose subcommands may read their own arguments.

    Parameters
    ----------
    forward : bool
        Leave all arguments to the command, in ``arguments``: its options depend on them.
    **options
        As of `argparse.ArgumentParser`.
    """

    def __init__(self, *, forward: bool = False, **options: Any) -> None:
        super().__init__(**options)
        self._forward = forward

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse the arguments, or leave them as they are."""
        if not self._forward:
            return super().parse_known_args(args, namespace)
        namespace, _ = super().parse_known_args([], namespace)
        self._words = args or ()
        return Namespace(**vars(namespace), arguments=list(args or ())), []
