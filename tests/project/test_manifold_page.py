"""Run the commands of docs/manifold.md that need no data."""

import shlex
from pathlib import Path

import pytest

from npss_baselines.__main__ import main
from npss_baselines.manifold.applications.restore import RESTORATIONS
from pages import PROJECT, blocks

PAGE = PROJECT / "docs" / "manifold.md"
pytestmark = pytest.mark.skipif(not PAGE.exists(), reason="needs the documentation")


@pytest.mark.slow
def test_commands(tmp_path, monkeypatch, capsys):
    pytest.importorskip("torch")
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    (commands,) = blocks(PAGE, "sh")
    for command in commands.splitlines():
        program, *arguments = shlex.split(command)
        assert program == "npss-baselines"
        assert main(arguments) == 0, capsys.readouterr().err
    printed = capsys.readouterr().out
    for application in (*RESTORATIONS, "interpolate", "sample", "filters"):
        assert f"\n{application}: " in printed
    assert Path("repair.png").stat().st_size > 10_000


def test_a_clip_is_repaired(tmp_path, monkeypatch, capsys):
    pytest.importorskip("scipy")
    monkeypatch.chdir(tmp_path)
    (commands,) = blocks(PAGE.with_name("repair.md"), "sh")
    for command in commands.splitlines():
        assert main(shlex.split(command)[1:]) == 0, capsys.readouterr().err
    assert "LeftLeg, LeftFoot: held" in capsys.readouterr().out
    assert Path("fixed.bvh").exists()
    assert Path("fixed.html").stat().st_size > 10_000
