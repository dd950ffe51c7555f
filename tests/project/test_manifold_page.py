"""The commands of docs/manifold.md that need no data, run as they are printed."""

import re
import shlex
from pathlib import Path

import pytest

from npss_baselines.__main__ import main
from npss_baselines.manifold.applications.restore import RESTORATIONS

PAGE = Path(__file__).parents[2] / "docs" / "manifold.md"


@pytest.mark.skipif(not PAGE.exists(), reason="the documentation is not beside the tests")
def test_the_commands_do_what_the_page_says(tmp_path, monkeypatch, capsys):
    pytest.importorskip("torch")
    pytest.importorskip("matplotlib")
    monkeypatch.chdir(tmp_path)
    (commands,) = re.findall(r"^```sh\n(.*?)^```", PAGE.read_text(encoding="utf-8"), flags=re.M | re.S)
    for command in commands.splitlines():
        program, *arguments = shlex.split(command)
        assert program == "npss-baselines"
        assert main(arguments) == 0, capsys.readouterr().err
    printed = capsys.readouterr().out
    for use in (*RESTORATIONS, "interpolate", "sample", "filters"):
        assert f"\n{use}: " in printed
    assert Path("repair.png").stat().st_size > 10_000
