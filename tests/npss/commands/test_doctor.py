"""What ``npss doctor`` says of this installation."""

import re
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

import npss
from command_line import run
from npss._metric import golden
from npss.extras import EXTRAS

PROJECT = Path(__file__).parents[3]


@pytest.mark.numeric
def test_this_machine_computes_the_golden_values(capsys):
    status, out, err = run(capsys, "doctor")
    assert (status, err) == (0, "")
    assert f"npss {npss.__version__}" in out
    assert len(re.findall(r"\d  equal  \w+\|version:1\|", out)) == len(golden.GOLDEN)
    assert golden.computed().keys() == golden.GOLDEN.keys()


def test_a_value_that_is_off_is_an_error(capsys, monkeypatch):
    text = "npss|version:1|convention:paper|frames:12"
    monkeypatch.setitem(golden.GOLDEN, text, golden.GOLDEN[text] * (1 + 3 * golden.TOLERANCE))
    status, out, _ = run(capsys, "doctor")
    assert status == 1
    assert re.findall(r"OFF  +(.*)", out) == [text]
    assert f"1 of {len(golden.GOLDEN)} values are off: do not trust" in out


def test_what_is_missing_comes_with_the_command_that_installs_it(capsys, monkeypatch):
    real = metadata.version

    def version(package):
        if package in ("pandas", "npss-baselines"):
            raise metadata.PackageNotFoundError
        return real(package)

    monkeypatch.setattr(metadata, "version", version)
    status, out, _ = run(capsys, "doctor")
    assert status == 0
    assert re.search(
        r"pandas +missing +leaderboards as tables +in the project's folder: pip install '.\[pandas\]'", out
    )
    assert re.search(r"npss-baselines +missing .*pip install \./baselines", out)


@pytest.mark.skipif(not (PROJECT / "pyproject.toml").exists(), reason="needs the project's folder")
def test_every_extra_is_listed():
    extras = tomllib.loads((PROJECT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["optional-dependencies"]
    del extras["all"]
    listed = {name: extra.package for name, extra in EXTRAS.items()}
    assert listed == {name: re.match(r"[\w-]+", packages[-1])[0] for name, packages in extras.items()}
