"""Run the plugins of docs/extending.md."""

import os
import re
import subprocess
import sys
import tomllib

import numpy as np
import pytest

from command_line import run, samples
from entry_points import declare
from npss import files, plugins
from pages import PROJECT, marked
from registered import restored

PAGE = PROJECT / "docs" / "extending.md"
pytestmark = pytest.mark.skipif(not PAGE.exists(), reason="needs the documentation")


def printed(kind, name):
    return marked(PAGE, kind, name)


def call(folder, line, *path):
    """Run a command line in a separate process, and return its output."""
    command, *arguments = line.split()
    module = {"npss": "npss", "npss-baselines": "npss_baselines"}[command]
    path = os.pathsep.join([*map(str, path), os.environ.get("PYTHONPATH", "")])
    done = subprocess.run(
        [sys.executable, "-P", "-m", module, *arguments],
        capture_output=True,
        encoding="utf-8",
        cwd=folder,
        env=os.environ | {"PYTHONPATH": path, "PYTHONUTF8": "1"},
    )
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done.stdout


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """Import the plugin from the current folder, and write equal predictions in its format and as ``.npz``."""
    (tmp_path / "text_format.py").write_text(printed("file", "text_format.py"), encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "path", list(sys.path))
    with restored(files.FORMATS):
        plugins.load("text_format")
        write_samples(tmp_path)
        yield tmp_path
    del sys.modules["text_format"]


def write_samples(folder):
    rng = np.random.default_rng(0)
    gt = 0.02 * rng.normal(size=(3, 50, 99)).cumsum(axis=1)
    for name, noise in (("walking", 0.01), ("other", 0.5)):
        poses = gt, gt + noise * rng.normal(size=gt.shape)
        files.write_samples(folder / f"{name}.npz", samples(poses))
        if name == "walking":
            files.write_samples(folder / "walking.poses", samples(poses, curve=np.zeros(50)))


def test_the_examples_are_short():
    assert len(printed("file", "text_format.py").splitlines()) <= 35


def test_a_metric(folder):
    pytest.importorskip("pandas")
    (folder / "mpjpe.py").write_text(printed("file", "mpjpe.py"), encoding="utf-8")
    score, leaderboard = (call(folder, line) for line in printed("command", "a metric").splitlines())
    assert re.search(r"^MPJPE 80 ms .*  mpjpe\|version:1\|.*\|root:fixed$", score, re.M)
    assert "MPJPE 400 ms" in leaderboard
    assert "MPJPE: in mm." in leaderboard


def test_a_file_format(folder):
    pytest.importorskip("pandas")
    score, leaderboard = (call(folder, line) for line in printed("command", "a file format").splitlines())
    assert score == call(folder, "npss score walking.npz")
    assert leaderboard == call(folder, "npss leaderboard walking.npz other.npz")


def test_a_broken_file_of_the_format(folder, capsys):
    path = folder / "walking.poses"
    path.write_text(path.read_text(encoding="utf-8").replace("gt walking 0 ", "gt walking 0 x", 1), encoding="utf-8")
    status, out, err = run(capsys, "score", path, "--plugin", "text_format")
    assert (status, out) == (2, "")
    assert err.startswith(f"npss: error: {path}: line 1: could not convert string to float: 'x")


def test_ways_to_name_plugins(folder):
    pytest.importorskip("pandas")
    (folder / "my_package").mkdir()
    (folder / "my_package/metrics.py").write_text("print('imported')", encoding="utf-8")
    first, second = (call(folder, line) for line in printed("command", "plugins").splitlines())
    assert first == second
    assert first.startswith("imported\n")
    assert "walking" in first


def test_an_installed_plugin(folder):
    """Install the plugin: put metadata beside the module."""
    declared = tomllib.loads(printed("file", "pyproject.toml"))["project"]
    site = folder / "installed"
    ((group, points),) = declared["entry-points"].items()
    declare(site, group, points)
    (folder / "text_format.py").rename(site / "text_format.py")
    assert "NPSS" in call(folder, "npss score walking.poses", site)
