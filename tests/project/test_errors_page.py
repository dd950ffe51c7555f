"""Run the programs of docs/errors.md."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

PAGE = Path(__file__).parents[2] / "docs" / "errors.md"


@pytest.mark.skipif(not PAGE.exists(), reason="needs the documentation")
def test_programs(tmp_path):
    programs = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), flags=re.M | re.S)
    assert len(programs) == 2
    done = subprocess.run(
        [sys.executable, "-X", "utf8", "-c", "\n".join(programs)],
        capture_output=True,
        encoding="utf-8",
        cwd=tmp_path,
        timeout=120,
    )
    assert done.returncode == 0, done.stderr
    for text in ("euler_error|version:1|fps:60|average:sum|columns:set|still:zero", "over 10 samples", "draws:10"):
        assert text in done.stdout
