"""Run the program of docs/identify.md."""

import contextlib
import io

import pytest

from pages import PROJECT, blocks

PAGE = PROJECT / "docs" / "identify.md"


@pytest.mark.skipif(not PAGE.exists(), reason="needs the documentation")
def test_program():
    (program,), (shown,) = blocks(PAGE, "python"), blocks(PAGE, "text")
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(program, {})
    assert printed.getvalue() == shown
