"""``npss-baselines train`` for fitted predictors, and the commands that read their runs."""

import json

import pytest

from npss_baselines.__main__ import main

pytest.importorskip("torch", reason="needs torch")


@pytest.fixture(autouse=True)
def no_environment(monkeypatch):
    monkeypatch.delenv("NPSS_H36M", raising=False)


def command(*arguments):
    try:
        return main([str(argument) for argument in arguments])
    except SystemExit as end:
        return end.code


def test_from_fitting_to_a_leaderboard(tmp_path, capsys):
    out = tmp_path / "runs" / "linear"
    assert command("train", "ridge", "--data", "synthetic", "--out", out, "--seed", 7) == 0
    assert "ridge, fitted to gait" in capsys.readouterr().out
    assert sorted(file.name for file in out.iterdir() if not file.name.startswith(".")) == [
        "config.json",
        "model.safetensors",
    ]
    assert json.loads((out / "config.json").read_text(encoding="utf-8"))["seed"] == 7
    assert command("evaluate", "zero-velocity", out, "--synthetic", "--format", "json") == 0
    zero, ridge = json.loads(capsys.readouterr().out)
    assert ridge["model"] == "linear"
    assert ridge["npss"]["released"] < zero["npss"]["released"]
    assert command("predict", out, "--out", tmp_path / "linear.npz") == 0
    capsys.readouterr()
    pytest.importorskip("pandas")
    files = [out, tmp_path / "linear.npz", "zero-velocity"]
    assert command("leaderboard", *files, "--synthetic", "--format", "csv") == 0
    rows = [line.split(",") for line in capsys.readouterr().out.splitlines()]
    scores = {row[0]: float(row[3]) for row in rows if row[1:3] == ["gait", "NPSS paper"]}
    assert len(scores) == 3
    assert sorted(scores.values())[0] == pytest.approx(sorted(scores.values())[1], rel=1e-9)  # folder and file


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("ridge",), "--out"),
        (("ridge", "--out", "RUN"), "no source of motion: give --h36m DIR"),
        (("ridge", "--out", "RUN", "--data", "nowhere"), "--data"),
        (
            ("ridge", "--out", "RUN", "--data", "synthetic", "--action", "sit"),
            "--action: expected one of gait, got 'sit'",
        ),
        (
            ("ridge", "--out", "RUN", "--data", "synthetic", "--h36m", "x"),
            "--h36m: this run trains on --data synthetic",
        ),
        (("ridge", "--out", "RUN", "--data", "synthetic", "--seed", "-1"), "seed: expected an integer from 0"),
        (("rigde", "--out", "RUN"), "MODEL: expected one of vgru-d"),
    ],
)
def test_errors(arguments, message, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert command("train", *arguments) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "RUN").exists()


def test_a_run_is_not_overwritten(tmp_path, capsys):
    (tmp_path / "config.json").write_text("{}", encoding="utf-8")
    assert command("train", "ridge", "--data", "synthetic", "--out", tmp_path) == 2
    assert "already holds a run" in capsys.readouterr().err


def test_help_names_all_fitted_predictors(capsys):
    assert command("train", "--help") == 0
    assert "ridge, nearest-10" in " ".join(capsys.readouterr().out.split())
    assert command("train", "nearest-10", "--help") == 0
    assert "nearest-10, mean of the ten nearest continuations" in " ".join(capsys.readouterr().out.split())
