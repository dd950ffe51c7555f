"""Run the program of docs/comparing.md."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "comparing.md"


@pytest.mark.skipif(not PAGE.exists(), reason="needs the documentation")
def test_program(tmp_path):
    pytest.importorskip("pandas")
    (program,) = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), flags=re.M | re.S)
    done = subprocess.run(
        [sys.executable, "-X", "utf8", "-c", program], capture_output=True, encoding="utf-8", cwd=tmp_path, timeout=120
    )
    assert done.returncode == 0, done.stderr
    results = ("of the score", "p = 0.000488", "12 constant predictions")
    meanings = ("assumed independent", "NPSS paper", "npss|version:1|")
    for text in (*results, *meanings):
        assert text in done.stdout
