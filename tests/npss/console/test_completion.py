"""Completion of a command in a shell."""

import shutil
import subprocess
import sys

import pytest

from command_line import run

WORDS = {
    ("score", "--conv"): "--convention",
    ("score", "--convention", "re"): "released",
    ("sco",): "score",
    ("study", "pl"): "plan",
    ("score", "some-"): "some-file.npy",
}


@pytest.mark.skipif(shutil.which("bash") is None, reason="needs bash")
def test_bash_completes_commands_options_choices_and_files(capsys, tmp_path):
    pytest.importorskip("shtab")
    status, script, _ = run(capsys, "completion", "bash")
    assert status == 0
    (tmp_path / "some-file.npy").touch()
    for words in WORDS:
        script += (
            f'COMP_WORDS=(npss {" ".join(words)}); COMP_CWORD={len(words)}; _shtab_npss; echo "${{COMPREPLY[*]}}"\n'
        )
    done = subprocess.run(["bash"], input=script, cwd=tmp_path, capture_output=True, encoding="utf-8", timeout=60)
    assert done.stdout.split() == list(WORDS.values()), done.stderr


def test_what_is_missing_is_said(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "shtab", None)
    status, _, err = run(capsys, "completion", "zsh")
    assert (status, err.count("\n")) == (2, 1)
    assert "completion needs shtab; in the project's folder: pip install '.[completion]'" in err
