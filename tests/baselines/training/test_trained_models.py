"""A trained model beside predictors: `npss-baselines evaluate` and `leaderboard`."""

import csv
import io
import json
import shutil

import numpy as np
import pytest

pytest.importorskip("torch")
pytest.importorskip("lightning")
pytest.importorskip("jsonargparse")
pytest.importorskip("pandas")

from npss.ranking._results import results_of_record
from npss.records import measure
from npss_baselines.__main__ import main
from npss_baselines.commands.evaluate import by_name
from npss_baselines.data.synthetic import synthetic_task
from npss_baselines.evaluation.draws import over_draws


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


def test_runs_and_files_of_the_same_name_get_unique_names(capsys, run, tmp_path):
    """All runs over seeds are called seed-N; a file of predictions may have the name of a predictor."""
    runs = [tmp_path / name for name in ("a/seed-0", "b/seed-0", "zero-velocity")]
    for folder in runs:
        shutil.copytree(run, folder)
    file = tmp_path / "b" / "zero-velocity.npz"
    target = synthetic_task().target
    arrays = {f"expmap/{kind}/gait_{i}": motion for kind in ("gt", "preds") for i, motion in enumerate(target)}
    np.savez(file, **arrays)

    models = ["zero-velocity", *map(str, (*runs, file))]
    names = ["zero-velocity", "a/seed-0", "b/seed-0", f"{tmp_path.name}/zero-velocity", "b/zero-velocity"]
    assert by_name(models) == dict(zip(names, models, strict=True))
    found = records(capsys, *runs[:2])
    assert [record["model"] for record in found] == ["a/seed-0", "b/seed-0"]
    assert main(["leaderboard", "zero-velocity", *map(str, (*runs[:2], file)), "--synthetic", "--format", "csv"]) == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    paper = {row["model"]: float(row["value"]) for row in rows if row["column"] == "NPSS paper"}
    assert paper.pop("zero-velocity") > 0
    own = {record["model"]: record["npss"]["paper"] for record in found}
    assert paper == {**own, f"{file.parent.name}/zero-velocity": 0.0}


@pytest.mark.parametrize("command", ["evaluate", "leaderboard"])
def test_duplicate_models_are_refused(capsys, run, command):
    assert main([command, "zero-velocity", "zero-velocity", "--synthetic"]) == 2
    assert "MODEL: duplicate 'zero-velocity'" in capsys.readouterr().err
    assert main([command, str(run), f"{run.parent}/../{run.parent.name}/{run.name}", "--synthetic"]) == 2
    assert "duplicate model 'small'" in capsys.readouterr().err


def test_a_still_sequence_has_no_euler_error_over_draws():
    """It has no Euler error in any draw."""
    gt, *preds = np.random.default_rng(0).normal(size=(4, 3, 25, 5))
    gt[1] = gt[1, 0]
    record = over_draws([measure(gt, pred, fps=25, at_ms=(80,), sequences=True, frames=25) for pred in preds])
    assert record["still"] == [1]
    assert [one is None for one in record["sequences"]["euler_error"]["80"]] == [False, True, False]
    assert len(results_of_record({"model": "m", "action": "a", **record})) == 4


def test_only_trained_actions_are_predicted(capsys, run, h36m_root):
    command = ["leaderboard", str(run), "--h36m", str(h36m_root), "--actions", "walking"]
    assert main(command) == 2
    assert "'small' has none of the actions walking" in capsys.readouterr().err


def test_folders_without_a_run(capsys, tmp_path):
    assert main(["evaluate", str(tmp_path), "--synthetic"]) == 2
    assert "is neither one of zero-velocity" in capsys.readouterr().err
