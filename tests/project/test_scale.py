"""Run the programs of docs/scale.md: their scores equal those of a single pass, to the bit."""

import os
import re
import subprocess
import sys

import numpy as np
import pytest

import npss
from pages import PROJECT

PAGE = PROJECT / "docs" / "scale.md"
NEEDS = {"concurrent.futures": "numpy", "dask": "distributed", "torch.distributed": "torch"}


def programs():
    if not PAGE.exists():
        return {}
    sections = re.findall(
        r"^## `?([\w.]+)`?.*?^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), flags=re.M | re.S
    )
    return dict(sections)


@pytest.mark.skipif(not PAGE.exists(), reason="needs the documentation")
def test_page_has_all_programs():
    assert programs().keys() == NEEDS.keys()


@pytest.mark.parametrize("name", programs())
def test_scores_equal_a_single_pass(name, tmp_path):
    pytest.importorskip(NEEDS[name])
    program = tmp_path / "program.py"
    program.write_text(programs()[name], encoding="utf-8")
    done = subprocess.run(
        [sys.executable, str(program)],
        capture_output=True,
        encoding="utf-8",
        cwd=tmp_path,
        timeout=240,
        env={**os.environ, "OMP_NUM_THREADS": "1"},
    )
    assert done.returncode == 0, done.stderr
    gt, pred = np.random.default_rng(0).normal(size=(2, 40, 50, 6)).cumsum(axis=2)
    convention = "released" if name == "concurrent.futures" else "paper"
    score = npss.score(gt, pred, convention=convention)
    assert f"{{'npss': {score!r}, 'sequences': 40, 'features': 6," in done.stdout
    assert f"convention:{convention}|frames:50" in done.stdout
