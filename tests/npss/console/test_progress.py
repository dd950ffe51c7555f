"""Progress: a bar on a terminal, cleared at the end; a line now and then in a log."""

import io

import numpy as np
import pytest

from npss.commands import main
from npss.console import _progress
from npss.console._progress import Progress, duration


class Terminal(io.StringIO):
    def isatty(self):
        return True


@pytest.fixture
def clock(monkeypatch):
    """A clock that goes on by a second whenever it is looked at."""
    seconds = iter(range(1000))
    monkeypatch.setattr(_progress.time, "monotonic", lambda: float(next(seconds)))


def test_shows_the_share_and_the_remaining_time(monkeypatch, clock):
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    with Progress("counting") as progress:
        progress(0.25)
        progress(0.5)
    shown = terminal.getvalue().split("\r")
    assert shown[1].startswith("counting [########                      ]  25%, 3 s left")
    assert shown[2].startswith("counting [###############               ]  50%, 2 s left")
    assert shown[3] == "\x1b[K"


def test_resumed_work_does_not_count_earlier_work(monkeypatch, clock):
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    with Progress("counting", done=0.5) as progress:
        progress(0.5)  # nothing has been done since: how long it takes is not known
        progress(0.75)  # a quarter in 2 seconds
    assert [line.partition("%, ")[2] for line in terminal.getvalue().split("\r")[1:2]] == ["2 s left \x1b[K"]


def test_no_time_has_passed(monkeypatch):
    terminal = Terminal()
    monkeypatch.setattr("sys.stderr", terminal)
    monkeypatch.setattr(_progress.time, "monotonic", lambda: 0.0)
    with Progress("counting") as progress:
        progress(0.5)
    assert terminal.getvalue() == ""


def test_where_there_is_no_terminal_a_line_now_and_then(monkeypatch, clock):
    """After 10 seconds, and then every minute; plain text."""
    text = io.StringIO()
    monkeypatch.setattr("sys.stderr", text)
    with Progress("counting") as progress:
        for i in range(1, 101):
            progress(i / 100)
    assert text.getvalue().splitlines() == [
        "counting: 10.0% done, about 2 min left",
        "counting: 70.0% done, about 30 s left",
    ]
    assert "\r" not in text.getvalue()
    assert "\x1b" not in text.getvalue()


def test_times_in_words():
    assert [duration(seconds) for seconds in (0.2, 89.4, 90, 89 * 60, 5400, 86_340, 86_400, 1e6)] == [
        *("0 s", "89 s", "2 min", "89 min", "1 h 30 min", "23 h 59 min", "1 d 0 h", "11 d 13 h"),
    ]


def test_scoring_files_shows_it(monkeypatch, clock, tmp_path, capsys):
    terminal = Terminal()
    np.save(tmp_path / "gt.npy", np.random.default_rng(0).normal(size=(9, 20, 3)))
    monkeypatch.setattr("sys.stderr", terminal)
    assert main(["score", f"{tmp_path}/gt.npy", f"{tmp_path}/gt.npy", "--workers", "2"]) == 0
    assert "NPSS paper [##############################] 100%" in terminal.getvalue()
    assert terminal.getvalue().endswith("\r\x1b[K")
