"""Run the program of docs/identify.md."""

import contextlib
import io
import re
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "identify.md"


@pytest.mark.skipif(not PAGE.exists(), reason="needs the documentation")
def test_program():
    text = PAGE.read_text(encoding="utf-8")
    (program,) = re.findall(r"^```python\n(.*?)^```", text, flags=re.M | re.S)
    (shown,) = re.findall(r"^```text\n(.*?)^```", text, flags=re.M | re.S)
    with contextlib.redirect_stdout(io.StringIO()) as printed:
        exec(program, {})
    assert printed.getvalue() == shown
