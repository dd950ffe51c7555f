"""The command reproduce: from a plan to records, which are never computed twice."""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import torch
from filelock import FileLock

from npss_baselines.__main__ import main
from npss_baselines.data import pose_sources
from npss_baselines.reproduction import job, processes
from npss_baselines.reproduction.plan import read_plan

pytestmark = pytest.mark.slow

SYNTHETIC = pose_sources()["synthetic"]
PLAN = """
[recipes.untrained]
what = "not trained"
[recipes.ours]
what = "Adam"
settings.select = "last"
settings.recipe = {{ optimizer = "adam", batch = 2, n_seed = 3, n_target = 4 }}
[rows.still]
model = "zero-velocity"
recipe = "untrained"
tables = ["table-4"]
[rows.tiny]
model = "gru-d"
recipe = "ours"
iterations = {iterations}
tables = ["table-4"]
settings.model.size = 4
[[order]]
why = "a test"
rows = ["still", "tiny"]
actions = ["gait"]
seeds = [0]
budget = "hours"
"""


@pytest.fixture
def plan(tmp_path):
    file = tmp_path / "plan.toml"
    file.write_text(PLAN.format(iterations=2), encoding="utf-8")
    return file


@pytest.fixture
def in_process(monkeypatch):
    """Run jobs in this process, which has imported what they need, on one thread as theirs."""

    def run(jobs, *, workers, say):
        return [job for job in jobs if main(job.command[3:]) != 0]

    monkeypatch.setattr(processes, "run", run)
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    yield
    torch.set_num_threads(threads)


def reproduce(tmp_path, plan, *options):
    arguments = ["reproduce", "--synthetic", "--out", tmp_path / "out", "--plan", plan, *options]
    return main([str(argument) for argument in arguments])


def record_of(tmp_path, name):
    return json.loads((tmp_path / "out" / "records" / f"{name}.json").read_text(encoding="utf-8"))


@pytest.mark.usefixtures("in_process")
def test_a_plan_becomes_records_once(tmp_path, plan, capsys):
    assert reproduce(tmp_path, plan) == 0
    records = {path: path.read_bytes() for path in (tmp_path / "out" / "records").rglob("*.json")}
    assert len(records) == 2
    still, tiny = (record_of(tmp_path, f"{row}/gait-seed-0") for row in ("still", "tiny"))
    assert [one["model"] for one in still["measured"]] == ["still", "still"]
    assert ["unwrap:target" in one["signature"] for one in still["measured"]] == [False, True]
    assert set(still["measured"][0]["npss"]) == {"paper", "released", "literal"}
    assert tiny["configuration"]["recipe"]["iterations"] == 2
    assert tiny["configuration"]["model"]["size"] == 4
    assert tiny["trained_with"]["threads"] == 1
    assert tiny["seconds"] >= 0
    assert tiny["why"] == "a test"
    table = (tmp_path / "out" / "tables" / "table-4-gait.md").read_text(encoding="utf-8")
    assert f"{still['measured'][0]['npss']['paper']:.3f}".removeprefix("0") in table
    assert "| tiny  | ours" in table
    capsys.readouterr()
    assert reproduce(tmp_path, plan) == 0
    said = capsys.readouterr().err
    assert "2 runs, 2 done" in said
    assert f"the tables of what is done are in {tmp_path / 'out' / 'tables'}" in said
    assert {path: path.read_bytes() for path in (tmp_path / "out" / "records").rglob("*.json")} == records
    # Without its record, a trained model is measured again, and not trained again.
    file = tmp_path / "out" / "records" / "tiny" / "gait-seed-0.json"
    weights = tmp_path / "out" / "runs" / "tiny" / "gait-seed-0" / "model.safetensors"
    before, stored = weights.stat().st_mtime_ns, file.read_text(encoding="utf-8")
    file.unlink()
    assert reproduce(tmp_path, plan) == 0
    assert weights.stat().st_mtime_ns == before
    assert file.read_text(encoding="utf-8") == stored


def test_list_runs_nothing(tmp_path, plan, capsys):
    assert reproduce(tmp_path, plan, "--list") == 0
    out = capsys.readouterr().out
    assert "still/gait-seed-0" in out
    assert "a test" in out
    assert not (tmp_path / "out").exists()
    assert main(["reproduce", "--synthetic", "--plan", str(plan), "--list"]) == 0  # without a folder, too
    assert capsys.readouterr().out == out


@pytest.mark.usefixtures("in_process")
def test_what_was_cut_off_is_resumed_to_the_same_numbers(tmp_path):
    plan = tmp_path / "plan.toml"
    plan.write_text(PLAN.format(iterations=60), encoding="utf-8")
    options = ["--plan", str(plan), "--only", "tiny", "--out", str(tmp_path / "out")]
    process = subprocess.Popen([sys.executable, "-m", "npss_baselines", "reproduce", "--synthetic", *options])
    run = tmp_path / "out" / "runs" / "tiny" / "gait-seed-0"
    while not (run / "last.ckpt").exists():
        assert process.poll() is None
        time.sleep(0.02)
    process.send_signal(signal.SIGTERM)
    assert process.wait() == 128 + signal.SIGTERM
    assert not (run / job.TRAINED).exists()
    assert reproduce(tmp_path, plan, "--only", "tiny") == 0
    resumed = record_of(tmp_path, "tiny/gait-seed-0")
    (tmp_path / "out").rename(tmp_path / "interrupted")
    assert reproduce(tmp_path, plan, "--only", "tiny") == 0
    whole = record_of(tmp_path, "tiny/gait-seed-0")
    assert resumed["validation"] == whole["validation"]
    assert resumed["measured"] == whole["measured"]


@pytest.mark.usefixtures("in_process")
def test_a_run_of_another_plan_is_not_continued(tmp_path, plan, capsys):
    assert reproduce(tmp_path, plan) == 0
    for file in (tmp_path / "out" / "records" / "tiny", tmp_path / "out" / "runs" / "tiny"):
        for path in (*file.rglob("*.json"),):
            if path.name != "config.json":
                path.unlink()
    plan.write_text(PLAN.format(iterations=3), encoding="utf-8")
    assert reproduce(tmp_path, plan) == 2
    assert "config.json: a run of another plan" in capsys.readouterr().err


@pytest.mark.usefixtures("in_process")
def test_a_record_of_another_plan_is_refused_before_work(tmp_path, plan, capsys):
    assert reproduce(tmp_path, plan) == 0
    text = plan.read_text(encoding="utf-8")
    for old, new, field in (
        ("iterations = 2", "iterations = 3", "configuration.recipe.iterations"),
        ("size = 4", "size = 5", "configuration.model.size"),
        ('model = "zero-velocity"', 'model = "repeat-50"', "model"),
    ):
        plan.write_text(text.replace(old, new), encoding="utf-8")
        assert reproduce(tmp_path, plan) == 2
        assert f"json: a record of another plan ({field}" in capsys.readouterr().err
    plan.write_text(text, encoding="utf-8")
    assert reproduce(tmp_path, plan, "--list") == 0
    assert capsys.readouterr().out.count("done") == 2


@pytest.mark.usefixtures("in_process")
def test_damaged_records_are_refused_before_work(tmp_path, plan, capsys):
    folder = tmp_path / "out" / "records" / "still"
    folder.mkdir(parents=True)
    (folder / "gait-seed-0.json").write_text('{"row": "still"}', encoding="utf-8")
    assert reproduce(tmp_path, plan) == 2
    assert "gait-seed-0.json: expected list as 'actions'" in capsys.readouterr().err
    assert not (tmp_path / "out" / "runs").exists()


@pytest.mark.usefixtures("in_process")
def test_failures_are_listed_and_leave_the_others_alone(tmp_path, plan, capsys):
    text = plan.read_text(encoding="utf-8")
    plan.write_text(text.replace("batch = 2", "batch = 2, lr = 1e30"), encoding="utf-8")
    assert reproduce(tmp_path, plan) == 2
    error = capsys.readouterr().err
    assert "1 of 2 runs failed: tiny/gait-seed-0" in error
    assert "diverge" in error
    record_of(tmp_path, "still/gait-seed-0")


def test_one_command_at_a_time(tmp_path, plan, capsys):
    (tmp_path / "out").mkdir()
    with FileLock(tmp_path / "out" / ".lock"):
        assert reproduce(tmp_path, plan) == 2
    assert "another process is reproducing" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--only", "table-9"], "only"),
        (["--workers", "0"], "workers"),
    ],
)
def test_bad_options_are_refused(tmp_path, plan, capsys, options, message):
    assert reproduce(tmp_path, plan, *options) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_the_folder_is_required(capsys):
    assert main(["reproduce", "--synthetic"]) == 2
    assert "--out DIR is required" in capsys.readouterr().err


def test_the_trial_keeps_apart(tmp_path):
    place = job.Place(SYNTHETIC, Path(), tmp_path / "trial", True)
    run = read_plan().runs(SYNTHETIC, budget="minutes")
    assert run
    assert all(place.record(one).is_relative_to(tmp_path / "trial") for one in run)
