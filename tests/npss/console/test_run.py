"""Errors of a command that are no user's mistake keep their traceback."""

import pytest

from npss.console import Parser, run


def test_an_error_that_no_plugin_raised_has_no_note():
    def fail(options):
        raise KeyError("missing")

    def parser():
        made = Parser(prog="command")
        made.set_defaults(run=fail)
        return made

    with pytest.raises(KeyError, match="missing") as caught:
        run("command", parser, [])
    assert not hasattr(caught.value, "__notes__")
