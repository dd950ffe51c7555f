"""Tests of a full disk: old files are kept, and one line names the file."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import npss
from command_line import run, samples
from disk import full_disk
from npss import study
from npss.console._run import error_text

OLD = b"old content"


@pytest.fixture(scope="module")
def arrays():
    gt = np.random.default_rng(0).normal(size=(2, 25, 99)).cumsum(axis=1) * 0.02
    return samples((gt, gt + 0.1 * np.random.default_rng(1).normal(size=gt.shape)))


@pytest.fixture(scope="module")
def folder(tmp_path_factory, arrays):
    root = tmp_path_factory.mktemp("models")
    for name in ("one", "two"):
        np.savez(root / f"{name}.npz", **arrays)
    return root


def keeps(path, write):
    """Check that a failed write keeps the old file and a successful one replaces it, without leftovers."""
    path.write_bytes(OLD)
    with full_disk(1024):
        message = write(path)
    assert f"cannot write {path}: File too large" in message
    assert path.read_bytes() == OLD
    assert [file.name for file in path.parent.iterdir()] == [path.name]
    write(path)
    assert path.read_bytes() != OLD
    assert [file.name for file in path.parent.iterdir()] == [path.name]


def error_of(write):
    """Return a function that writes and returns the error message, if any."""

    def function(path):
        try:
            write(path)
        except OSError as error:
            return str(error)
        return None

    return function


@pytest.mark.parametrize("command", [["report", "FOLDER"], ["study", "page", "FOLDER"]])
def test_pages(capsys, tmp_path, folder, command):
    pytest.importorskip("matplotlib")
    arguments = [folder if part == "FOLDER" else part for part in command]

    def write(path):
        status, out, err = run(capsys, *arguments, "-o", path)
        if status:
            assert (status, out) == (2, "")
            assert err.splitlines()[-1].startswith("npss: error: cannot write")  # after lines of progress
        return err

    keeps(tmp_path / "page.html", write)


@pytest.mark.parametrize("suffix", [".npz", ".h5"])
def test_predictions(tmp_path, arrays, suffix):
    pytest.importorskip("h5py")
    from npss.files import write_samples
    from npss.files._samples import read_poses

    path = tmp_path / f"samples{suffix}"
    keeps(path, error_of(lambda path: write_samples(path, arrays)))
    assert read_poses(path)[0].gt.shape == (2, 25, 99)


@pytest.mark.parametrize("suffix", [".svg", ".pdf", ".png"])
def test_pictures(tmp_path, suffix):
    figure = pytest.importorskip("matplotlib.figure").Figure()
    figure.subplots().plot(np.random.default_rng(0).normal(size=300))
    from npss.files._write import write_figure_atomically

    keeps(tmp_path / f"picture{suffix}", error_of(lambda path: write_figure_atomically(path, figure)))
    assert (tmp_path / f"picture{suffix}").read_bytes()[:5] in (b"<?xml", b"%PDF-", b"\x89PNG\r")


def test_votes(tmp_path):
    votes = [study.Vote("walking", study.Question(i, 4, "GRU-d", "VGRU-d"), "p07", "B") for i in range(1, 100)]
    keeps(tmp_path / "votes.csv", error_of(lambda path: study.write_votes(path, votes)))
    assert study.read_votes(tmp_path / "votes.csv") == votes


def test_leaderboards(tmp_path, folder):
    pd = pytest.importorskip("pandas")
    board = npss.leaderboard(folder)
    keeps(tmp_path / "board.csv", error_of(board.to_csv))
    assert (tmp_path / "board.csv").read_text(encoding="utf-8") == board.to_csv()
    board.to_csv(tmp_path / "board.csv.gz")
    pd.testing.assert_frame_equal(pd.read_csv(tmp_path / "board.csv.gz"), pd.read_csv(tmp_path / "board.csv"))
    with (tmp_path / "open.csv").open("w", encoding="utf-8") as file:
        board.to_csv(file)
    assert (tmp_path / "open.csv").read_bytes() == (tmp_path / "board.csv").read_bytes()


@pytest.mark.parametrize("options", [[], ["--format", "json"], ["--format", "html"]])
@pytest.mark.parametrize("unbuffered", ["", "1"])
def test_standard_output(folder, options, unbuffered):
    command = [sys.executable, "-m", "npss", "score", folder / "one.npz", *options]
    if "html" in options:
        pytest.importorskip("pandas")
        command = [sys.executable, "-m", "npss", "leaderboard", folder, *options]
    with Path("/dev/full").open("wb") as full:
        done = subprocess.run(
            command,
            stdout=full,
            stderr=subprocess.PIPE,
            encoding="utf-8",
            env=os.environ | {"PYTHONUNBUFFERED": unbuffered},
        )
    assert done.returncode == 2
    assert done.stderr == "npss: error: cannot write to standard output: No space left on device\n"


def test_standard_output_in_this_process(monkeypatch):
    from npss.console._encoding import discard_output

    with Path("/dev/full").open("w", encoding="utf-8") as full:
        monkeypatch.setattr(sys, "stdout", full)
        print("more than it takes")
        discard_output()
        print("goes nowhere", flush=True)
        discard_output()


def test_messages():
    full = OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    assert error_text(full) == "cannot write to standard output: No space left on device"
    assert error_text(OSError(*full.args, "runs/walking")) == "runs/walking: No space left on device"


def test_without_standard_output():
    command = [sys.executable, "-m", "npss", "explain", "npss|version:1"]
    done = subprocess.run(["bash", "-c", '"$@" >&-', "-", *command], stderr=subprocess.PIPE, encoding="utf-8")
    assert (done.returncode, done.stderr) == (0, "")
