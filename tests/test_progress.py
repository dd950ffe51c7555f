"""The progress line: on a terminal, for long work, gone when it is over."""

import io

import numpy as np
import pytest

from npss import _progress
from npss._cli import main
from npss._progress import Progress


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    """A clock that goes on by a second whenever it is looked at."""
    seconds = iter(range(1000))
    monkeypatch.setattr(_progress.time, "monotonic", lambda: float(next(seconds)))


def test_shows_how_much_and_how_long(monkeypatch, clock):
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    with Progress("counting") as progress:
        progress(0.25)
        progress(0.5)
    shown = terminal.getvalue().split("\r")
    assert shown[1].startswith("counting [########                      ]  25%, 3 s left")
    assert shown[2].startswith("counting [###############               ]  50%, 2 s left")
    assert shown[3] == "\x1b[K"


def test_is_silent_where_there_is_no_terminal_or_no_time_has_passed(monkeypatch, clock):
    text = io.StringIO()
    monkeypatch.setattr("sys.stderr", text)
    with Progress("counting") as progress:
        progress(0.5)
    assert text.getvalue() == ""
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setattr(_progress.time, "monotonic", lambda: 0.0)
    with Progress("counting") as progress:
        progress(0.5)
    assert terminal.getvalue() == ""


def test_scoring_files_shows_it(monkeypatch, clock, tmp_path, capsys):
    terminal = Terminal()
    np.save(tmp_path / "gt.npy", np.random.default_rng(0).normal(size=(9, 20, 3)))
    monkeypatch.setattr("sys.stderr", terminal)
    assert main(["score", f"{tmp_path}/gt.npy", f"{tmp_path}/gt.npy", "--workers", "2"]) == 0
    assert "NPSS paper [##############################] 100%" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\x1b[K")
