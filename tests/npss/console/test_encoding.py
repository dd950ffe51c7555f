"""Characters are printed in any encoding of standard output."""

import io
import os
import subprocess
import sys
import warnings

import numpy as np
import pytest

from command_line import samples

SIGNS = "† – − ∞ … ×"


def test_warnings_are_one_line():
    from npss.console._encoding import warnings_in_one_line

    before = warnings.formatwarning
    with warnings_in_one_line("npss"):
        assert warnings.formatwarning("one\nline", UserWarning, "file.py", 1) == "npss: warning: one line\n"
    assert warnings.formatwarning is before


def printed(monkeypatch, text, encoding, errors="strict"):
    from npss.console._encoding import allow_any_text

    content = io.BytesIO()
    monkeypatch.setattr(sys, "stdout", io.TextIOWrapper(content, encoding=encoding, errors=errors))
    allow_any_text()
    print(text, end="", flush=True)
    return content.getvalue()


@pytest.mark.parametrize(
    ("encoding", "expected"),
    [
        ("utf-8", SIGNS),
        ("ascii", "^ - - inf ... x"),
        ("latin-1", "^ - - inf ... ×"),
        ("cp1252", "† – - inf … ×"),
        ("cp437", "^ - - ∞ ... x"),
        ("gbk", "^ – - ∞ … ×"),
    ],
)
def test_signs(monkeypatch, encoding, expected):
    assert printed(monkeypatch, SIGNS, encoding).decode(encoding) == expected


def test_other_characters_are_question_marks(monkeypatch):
    assert printed(monkeypatch, "日本\udcff", "cp1252") == b"???"
    assert printed(monkeypatch, "日本\udcff", "utf-8") == "日本?".encode()


def test_the_user_s_error_handler_stays(monkeypatch):
    assert printed(monkeypatch, "†", "ascii", "backslashreplace") == b"\\u2020"


def test_standard_output_may_be_missing_or_anything(monkeypatch):
    from npss.console._encoding import allow_any_text

    for stream in (None, io.StringIO()):
        monkeypatch.setattr(sys, "stdout", stream)
        allow_any_text()


def test_decoding_is_left_alone():
    with pytest.raises(UnicodeDecodeError):
        b"\xff".decode("utf-8", "npss-ascii")


@pytest.mark.parametrize("encoding", ["ascii", "latin-1", "cp1252", "cp437", "gbk"])
def test_a_leaderboard(tmp_path, encoding):
    pytest.importorskip("pandas")
    rng = np.random.default_rng(0)
    gt = 0.02 * rng.normal(size=(8, 50, 99)).cumsum(axis=1)
    for name, noise in (("close", 0.01), ("far", 0.5)):
        np.savez(tmp_path / f"{name}.npz", **samples((gt, gt + noise * rng.normal(size=gt.shape))))
    command = [sys.executable, "-m", "npss", "leaderboard", tmp_path]
    whole, narrow = (
        subprocess.run(command, capture_output=True, check=True, env=os.environ | {"PYTHONIOENCODING": name}).stdout
        for name in ("utf-8", encoding)
    )
    there_are = whole.decode()
    assert "–" in there_are
    # Sign and legend alike: of what was printed, nothing but those characters has changed.
    for sign, ascii_sign in {"†": "^", "–": "-", "∞": "inf"}.items():
        try:
            sign.encode(encoding)
        except UnicodeEncodeError:
            there_are = there_are.replace(sign, ascii_sign)
    assert narrow.decode(encoding) == there_are
