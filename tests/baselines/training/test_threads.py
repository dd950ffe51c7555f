"""Threads: how many train, how they wait, and how a slower pace is noticed."""

import json
import os
import subprocess
import sys

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from npss_baselines.manifold.training import loss
from npss_baselines.manifold.training import trainer as manifold_trainer
from npss_baselines.runs import config, launch
from npss_baselines.runs.pace import Pace
from npss_baselines.training import trainer
from trainings import command

pytestmark = pytest.mark.usefixtures("_tiny")

MODEL = ["tiny", "--data", "synthetic", "--iterations", "2", "--recipe.batch", "2"]
MANIFOLD = ["manifold", "--quick", "--model.widths", "[4,5]", "--whole.epochs", "1", "--layers.epochs", "0"]


@pytest.fixture
def used(monkeypatch):
    """Collect the numbers of threads that compute losses; torch has three at first."""
    numbers = set()
    before = torch.get_num_threads()
    torch.set_num_threads(3)
    model_loss, loss_of = trainer.TrainingRun.loss, loss.loss_of

    def of_model(*arguments):
        numbers.add(torch.get_num_threads())
        return model_loss(*arguments)

    def of_manifold(*arguments, **options):
        numbers.add(torch.get_num_threads())
        return loss_of(*arguments, **options)

    monkeypatch.setattr(trainer.TrainingRun, "loss", of_model)
    monkeypatch.setattr(manifold_trainer, "loss_of", of_manifold)
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    yield numbers
    assert torch.get_num_threads() == 3  # as before
    torch.set_num_threads(before)


@pytest.mark.parametrize("options", [MODEL, MANIFOLD], ids=["model", "manifold"])
def test_the_number_of_threads_is_chosen_and_recorded(tmp_path, monkeypatch, used, options):
    def train(*more):
        used.clear()
        out = tmp_path / "-".join(more or ("default",))
        assert command("train", *options, *more, "--out", out) == 0
        assert used == {json.loads((out / config.FILE).read_text(encoding="utf-8"))["made_with"]["threads"]}
        return used

    assert train() == {1}
    assert train("--threads", "2") == {2}
    monkeypatch.setenv("OMP_NUM_THREADS", "3")  # what torch has read
    assert train("--resume") == {3}
    assert train("--threads", "1") == {1}


@pytest.mark.slow
def test_a_resumed_run_keeps_its_number_of_threads(tmp_path, used):
    out = tmp_path / "r"
    assert command("train", *MODEL, "--threads", "2", "--out", out) == 0
    for more, expected in (([], 2), (["--threads", "1"], 1), ([], 1)):
        (out / config.CHECKPOINT).unlink()
        used.clear()
        assert command("train", "--resume", "--out", out, *more) == 0
        assert used == {expected}
    used.clear()  # another run is of this machine
    assert command("train", "--config", out / config.FILE, "--out", tmp_path / "again") == 0
    assert used == {1}


@pytest.mark.parametrize("made_with", [{}, {"threads": None}, None])
def test_older_runs_record_no_threads(tmp_path, monkeypatch, made_with):
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    text = json.dumps({} if made_with is None else {"made_with": made_with})
    (tmp_path / config.FILE).write_text(text, encoding="utf-8")
    assert config.recorded_threads(tmp_path / config.FILE) is None
    assert launch.threads_of(None, [tmp_path]) == 1
    assert launch.threads_of(5, [tmp_path]) == 5


@pytest.mark.parametrize(
    ("made_with", "message"),
    [
        (2, "expected an object, got 2"),
        ({"threads": 0}, "threads: expected a positive integer, got 0"),
        ({"threads": "2"}, "threads: expected a positive integer, got '2'"),
        ({"threads": True}, "threads: expected a positive integer, got True"),
        ({"threads": 1.5}, r"threads: expected a positive integer, got 1\.5"),
    ],
)
def test_errors_name_an_invalid_record(tmp_path, made_with, message):
    (tmp_path / config.FILE).write_text(json.dumps({"made_with": made_with}), encoding="utf-8")
    with pytest.raises(ValueError, match=rf"config\.json: made_with: {message}$"):
        launch.threads_of(None, [tmp_path])


@pytest.mark.parametrize("options", [MODEL, MANIFOLD], ids=["model", "manifold"])
@pytest.mark.parametrize(
    ("value", "message"),
    [("0", "--threads: expected a positive integer, got 0"), ("two", "argument --threads: invalid int value: 'two'")],
)
def test_invalid_numbers_are_refused(tmp_path, capsys, options, value, message):
    assert command("train", *options, "--threads", value, "--out", tmp_path / "r") == 2
    assert message in capsys.readouterr().err
    assert not list(tmp_path.iterdir())


# --- how threads wait ---


def waiting(code, **variables):
    """Run code in a process of its own; return what the environment says there, and libgomp's numbers of spins."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith(("OMP_", "GOMP_"))}
    done = subprocess.run(
        [sys.executable, "-c", f"import os, sys\n{code}\nprint(os.environ.get('OMP_WAIT_POLICY'))", "params"],
        env={**environment, "OMP_DISPLAY_ENV": "VERBOSE", **variables},
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    counts = [line.split("'")[1] for line in done.stderr.splitlines() if "GOMP_SPINCOUNT" in line]
    return done.stdout.splitlines()[-1], counts


COMMAND = "from npss_baselines.__main__ import main; main()"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("variables", "policy", "count"),
    [({}, "PASSIVE", "0"), ({"OMP_WAIT_POLICY": "ACTIVE"}, "ACTIVE", None), ({"GOMP_SPINCOUNT": "7"}, "PASSIVE", "7")],
)
def test_threads_of_the_command_sleep_while_they_wait(variables, policy, count):
    """Unless the user's variables say otherwise. The count is of spins, where torch has the runtime of GCC."""
    found, counts = waiting(COMMAND, **variables)
    assert found == policy
    if counts and count is not None:
        assert counts == [count]


@pytest.mark.slow
def test_the_library_leaves_the_environment_alone():
    assert waiting("from npss_baselines.__main__ import main; main(['params'])")[0] == "None"


# --- the pace ---

works = st.floats(1e-3, 1e3)


@given(st.lists(works, min_size=1, max_size=300), st.floats(1e-3, 100.0), st.floats(1.0, 2.9), st.integers(6, 299))
def test_a_pace_that_stays_is_not_noticed(works, seconds, slower, later):
    """In seconds per unit of work; steps may stop now and then."""
    pace = Pace()
    for i, work in enumerate(works):
        stopped = 1000.0 if i % 5 == 2 else 1.0
        assert pace(seconds * work * stopped * (slower if i >= later else 1.0), work) is None


@given(st.lists(works, min_size=5, max_size=50), st.floats(3.1, 100.0), st.floats(30.0, 1e3))
def test_a_slower_pace_is_noticed_once(works, slower, seconds):
    """After five steps that take half a minute or longer, with the factor."""
    pace = Pace()
    first = [pace(seconds * work, work) for work in [1e-9, *[1.0] * 5]]
    later = [pace(seconds * slower * work, work) for work in [*[1.0] * 5, *works]]
    assert first == [None] * 6
    assert [value for value in later if value is not None] == [pytest.approx(slower)]
    assert later[4] == pytest.approx(slower)


def test_short_slowness_is_not_noticed():
    """Fifty steps of .1 s take 5 s; the next window lasts half a minute and holds few of them."""
    pace = Pace()
    assert not any(pace(0.1, 1.0) for _ in range(400))
    assert not any(pace(1.0, 1.0) for _ in range(10))
    assert not any(pace(0.1, 1.0) for _ in range(1000))
