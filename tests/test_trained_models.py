"""A trained model beside predictors: `python -m baselines evaluate` and `leaderboard`."""

import csv
import io
import json

import pytest

pytest.importorskip("torch")
pytest.importorskip("lightning")
pytest.importorskip("jsonargparse")
pytest.importorskip("pandas")

from baselines.__main__ import main


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("runs") / "small"
    command = ["train", "vgru-d", "--data", "synthetic", "--out", str(folder), "--iterations", "2"]
    assert main([*command, "--model.n_units", "8", "--device", "cpu"]) == 0
    return folder


def records(capsys, *arguments):
    assert main(["evaluate", *map(str, arguments), "--synthetic", "--format", "json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_is_evaluated_over_draws(capsys, run):
    baseline, mean = records(capsys, "zero-velocity", run, "--draws", "3", "--seed", "5")
    assert (baseline["model"], mean["model"]) == ("zero-velocity", "small")
    assert mean["std"]["npss"]["paper"] > 0
    assert "draws:3" in mean["signature"]
    (again,) = records(capsys, run, "--draws", "3", "--seed", "5")
    assert again == mean
    (other,) = records(capsys, run, "--draws", "3", "--seed", "6")
    assert other["npss"] != mean["npss"]


def test_is_ranked_beside_predictors(capsys, run, tmp_path):
    assert main(["leaderboard", "zero-velocity", str(run), "--synthetic", "--format", "csv"]) == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    paper = {row["model"]: row for row in rows if row["column"] == "NPSS paper"}
    assert paper.keys() == {"zero-velocity", "small"}
    (alone,) = records(capsys, run)
    assert float(paper["small"]["value"]) == alone["npss"]["paper"]


def test_is_not_asked_for_what_it_was_not_trained_on(capsys, run, h36m_root):
    command = ["leaderboard", str(run), "--h36m", str(h36m_root), "--actions", "walking"]
    assert main(command) == 2
    assert "'small' has none of the actions asked for, walking" in capsys.readouterr().err


def test_folders_that_are_no_run(capsys, tmp_path):
    assert main(["evaluate", str(tmp_path), "--synthetic"]) == 2
    assert "is not one of zero-velocity" in capsys.readouterr().err
