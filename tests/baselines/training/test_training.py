"""Training: the same seed gives the same run, even if it is killed; and the commands, end to end."""

import csv
import json
import math
import pickle
import re
import signal
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors import safe_open
from safetensors.torch import load_file
from safetensors.torch import save as serialized
from torch import nn

import npss
from npss.commands import main
from npss.console import _progress
from npss.files._samples import converted, read_poses
from npss.predictors import zero_velocity
from npss.protocol import ACTIONS, COLUMNS, SLICES_MS, TRAIN_SUBJECTS
from npss_baselines.commands import train_options
from npss_baselines.commands.evaluate import evaluate
from npss_baselines.data import windows
from npss_baselines.data.h36m_source import Human36M
from npss_baselines.data.synthetic import synthetic_task, synthetic_training_set, synthetic_validation
from npss_baselines.evaluation.draws import evaluate_run
from npss_baselines.models import MODELS
from npss_baselines.runs import config, folder, launch, log, weights
from npss_baselines.runs.predictor import ModelPredictor
from npss_baselines.training import objectives, selection, trainer
from npss_baselines.training.rmsprop import RMSpropTF
from outcomes import same
from texts import check_texts
from trainings import RECIPE, TINY, Tiny, TinyConfig, command, configured, outcome, train_until_killed, trained

pytestmark = pytest.mark.usefixtures("_tiny")


# --- interrupting and resuming ---


@pytest.mark.parametrize(
    ("average", "moments"),
    [
        (
            None,
            [
                ("writing", 1),  # the configuration
                ("writing", 2),  # the first checkpoint
                ("iteration", 2),  # iteration 2; number 1 is in the checkpoint
                ("writing", 3),  # the first model, after iteration 3
                ("written", 4),  # that model and its metrics, before their checkpoint
                ("written", 5),  # after their checkpoint
                ("written", 3),  # the checkpoints of iterations 4 and 5
            ],
        ),
        (0.5, [("iteration", 5), ("writing", 3)]),
    ],
)
def test_a_run_that_is_killed_repeatedly_ends_like_an_uninterrupted_one(tmp_path, processes, average, moments):
    configuration = replace(configured(), average=average)
    expected = trained(tmp_path / "whole", configuration)
    out = tmp_path / "killed"
    for moment, number in moments:
        process = processes.Process(target=train_until_killed, args=(out, configuration, moment, number))
        process.start()
        process.join()
        assert process.exitcode == -signal.SIGKILL, (moment, number)
        if (out / weights.FILE).exists():
            folder.load(out)  # existing files are complete
    assert trained(out, configuration) == expected
    assert same(outcome(out), outcome(tmp_path / "whole"))
    assert trained(out, configuration) == expected  # nothing remains to do
    assert same(outcome(out), outcome(tmp_path / "whole"))


# --- several runs at once ---


def trained_together(out, configurations, device="cpu"):
    together = []
    for i, configuration in enumerate(configurations):
        folder = out / str(i)
        folder.mkdir(parents=True, exist_ok=True)
        config.write(folder / config.FILE, configuration, device)
        together.append((configuration, synthetic_training_set(3, 60), synthetic_validation(2), folder))
    return trainer.train_together(together, out, device=device)


@pytest.mark.parametrize("optimizer", ["rmsprop-tf", "adam", "sgd"])
def test_runs_together_give_the_same_as_alone(tmp_path, optimizer):
    """To the bit: batches, noise and dropout, gradient clipping, the moving average."""
    recipe = replace(RECIPE, optimizer=optimizer, momentum=0.9)
    several = [replace(configured(), recipe=recipe, average=0.5, seed=seed) for seed in (5, 6, 7)]
    rows = trained_together(tmp_path / "together", several)
    for i, configuration in enumerate(several):
        assert trained(tmp_path / str(i), configuration) == rows[i]
        for file in (weights.FILE, log.FILE, config.FILE):
            assert (tmp_path / "together" / str(i) / file).read_bytes() == (tmp_path / str(i) / file).read_bytes()


@pytest.mark.parametrize("device", ["cpu", "cuda"])
def test_runs_together_can_be_resumed(request, tmp_path, monkeypatch, capsys, device):
    """From a checkpoint between two validations, which holds losses."""
    if device == "cuda":
        request.getfixturevalue("gpu")
    several = [replace(configured(), seed=seed, checkpoint_every=1) for seed in (5, 6)]
    expected = trained_together(tmp_path / "whole", several, device)
    validate, calls = trainer.TrainingRun.validate, []

    def fail(member, iteration):
        calls.append(iteration)
        if len(calls) == 4:  # the second member's second validation
            raise OSError("no space left")
        return validate(member, iteration)

    with monkeypatch.context() as patch:
        patch.setattr(trainer.TrainingRun, "validate", fail)
        with pytest.raises(OSError, match="no space"):
            trained_together(tmp_path / "cut", several, device)
    assert torch.load(tmp_path / "cut" / config.CHECKPOINT, weights_only=True)["losses"][1]["loss"].shape == (2,)
    with pytest.raises(ValueError, match=r"^--resume: .*last\.ckpt holds 0, 1, not 0$"):
        trained_together(tmp_path / "cut", several[:1], device)
    capsys.readouterr()
    resumed = trained_together(tmp_path / "cut", several, device)
    assert re.search(r"^resuming at [1-9]\d?% of 10 iterations$", capsys.readouterr().out, re.M)
    for i, rows in enumerate(resumed):
        assert [row["loss"] for row in rows] == pytest.approx([row["loss"] for row in expected[i]], rel=1e-3)
    if device == "cuda":
        return  # up to rounding
    assert resumed == expected
    for i in ("0", "1"):
        for file in (weights.FILE, log.FILE):
            assert (tmp_path / "cut" / i / file).read_bytes() == (tmp_path / "whole" / i / file).read_bytes()


def test_different_runs_cannot_be_trained_together(tmp_path):
    several = [configured(), replace(configured(), seed=1, recipe=replace(RECIPE, lr=0.1))]
    with pytest.raises(ValueError, match=r"^runs: .*1 differs from .*0 in more than actions and seed"):
        trained_together(tmp_path, several)


def test_graphs_are_captured_again_when_the_loss_changes(tmp_path, monkeypatch):
    """Captured is replaced by the captured loss, called with the iteration of its capture."""
    recipe = replace(RECIPE, noise_std=((5, 0.1),))
    captured, used = [], []

    class Called:
        def __init__(self, loss, batch, parameters):
            captured.append(loss.keywords["iteration"])
            self.loss = loss

        def launch(self, seed, batch):
            used.append(self.loss.keywords["iteration"])
            torch.manual_seed(seed)
            self.parts = self.loss(*batch)

        def result(self):
            return self.parts

    several = [replace(configured(), recipe=recipe, seed=seed) for seed in (5, 6)]
    expected = trained_together(tmp_path / "plain", several)
    monkeypatch.setattr(trainer, "Captured", Called)
    monkeypatch.setattr(trainer.Training, "_run", trainer.Training._replay)
    assert trained_together(tmp_path / "graphs", several) == expected
    assert captured == [0, 0, 3, 3, 5, 5]
    assert used == sorted([0, 3, 3, 5, 5, 5, 5, 5, 0, 0] * 2)


@pytest.mark.usefixtures("gpu")
@pytest.mark.parametrize("name", ["tiny", "vgru-d"])
def test_on_a_gpu_runs_give_the_same_alone_together_and_resumed(tmp_path, monkeypatch, name):
    """One graph for each member and each weight of the closed loop; losses are equal up to rounding."""
    spec, recipe = MODELS[name], replace(RECIPE, iterations=6, closed_weight=((0, 0.1), (3, 0.5)))
    small = spec.config if name == "tiny" else replace(spec.config, n_units=16)
    several = [replace(configured(), name=name, model=small, recipe=recipe, seed=seed) for seed in (5, 6, 7)]
    rows = trained_together(tmp_path / "together", several, "cuda")
    training_set = synthetic_training_set(3, 60), synthetic_validation(2)
    for i, configuration in enumerate(several):
        (tmp_path / str(i)).mkdir()
        alone = trainer.train(configuration, *training_set, tmp_path / str(i), device="cuda")
        (tmp_path / f"plain-{i}").mkdir()
        with monkeypatch.context() as patch:
            patch.setattr(trainer.Training, "_replay", trainer.Training._run)
            plain = trainer.train(configuration, *training_set, tmp_path / f"plain-{i}", device="cuda")
        for one in (alone, plain):
            assert [row["loss"] for row in one] == pytest.approx([row["loss"] for row in rows[i]], rel=1e-3)
    first = [replace(one, recipe=replace(recipe, iterations=3)) for one in several]
    trained_together(tmp_path / "parts", first, "cuda")
    resumed = trained_together(tmp_path / "parts", several, "cuda")
    for of_resumed, of_whole in zip(resumed, rows, strict=True):
        assert of_resumed[-1]["loss"] == pytest.approx(of_whole[-1]["loss"], rel=1e-3)


def test_a_checkpoint_cannot_run_code(tmp_path):
    class Hostile:
        def __reduce__(self):
            return (Path.touch, (tmp_path / "ran",))

    for content in (pickle.dumps(Hostile(), 2), b"", b"nonsense"):
        (tmp_path / config.CHECKPOINT).write_bytes(content)
        with pytest.raises(ValueError, match=r"last\.ckpt: not a checkpoint"):
            trained(tmp_path, configured())
    torch.save({"state_dict": Hostile()}, tmp_path / config.CHECKPOINT)
    with pytest.raises(ValueError, match=r"last\.ckpt: not a checkpoint"):
        trained(tmp_path, configured())
    assert not (tmp_path / "ran").exists()


# --- an iteration ---


@pytest.mark.parametrize("optimizer", ["rmsprop-tf", "adam", "sgd"])
def test_training_equals_a_plain_loop(tmp_path, optimizer):
    """Seeds, batches, loss, clipping, learning rate and moving average, compared with an explicit loop."""
    recipe = replace(RECIPE, optimizer=optimizer, momentum=0.9)
    configuration = replace(configured("--seed", "7"), recipe=recipe, select="last", average=0.8)
    training_set = synthetic_training_set(3, 60)
    before = torch.get_rng_state()
    rows = trained(tmp_path, configuration, training_set)
    assert torch.equal(torch.get_rng_state(), before)  # torch's global generator is unchanged

    batches = windows.Batches(training_set, batch=4, n_seed=6, n_target=4, seed=7)
    torch.manual_seed(7)
    model = Tiny(TinyConfig(), 1)
    steps = {
        "rmsprop-tf": lambda: RMSpropTF(model.parameters(), 1e-2, momentum=0.9),
        "adam": lambda: torch.optim.Adam(model.parameters(), 1e-2),
        "sgd": lambda: torch.optim.SGD(model.parameters(), 1e-2, momentum=0.9),
    }[optimizer]()
    average, losses, norms = None, [], []
    for i in range(10):
        batch = batches[i]
        torch.manual_seed(int(np.random.SeedSequence([7, i, 1]).generate_state(1, np.uint64)[0]))
        loss = objectives.loss(model, *map(torch.from_numpy, batch), recipe, i)["loss"]
        steps.zero_grad()
        loss.backward()
        norms.append(nn.utils.clip_grad_norm_(model.parameters(), 0.2).item())
        steps.param_groups[0]["lr"] = 1e-2 if i < 4 else 5e-3 if i < 8 else 2.5e-3
        steps.step()
        losses.append(loss.item())
        now = {name: value.detach().clone() for name, value in model.state_dict().items()}
        average = now if average is None else {name: 0.8 * average[name] + 0.2 * now[name] for name in now}
    assert max(norms) > 0.2  # clipping had an effect
    assert same(
        outcome(tmp_path)["weights"], outcome(tmp_path)["weights"] | {f"members.0.model.{k}": v for k, v in now.items()}
    )
    for name, value in folder.load(tmp_path).model.state_dict().items():
        torch.testing.assert_close(value, average[name])
    assert [row["iteration"] for row in rows] == [3, 6, 9, 10]
    assert [row["lr"] for row in rows] == [1e-2, 5e-3, 2.5e-3, 2.5e-3]
    for row, of in zip(rows, (losses[:3], losses[3:6], losses[6:9], losses[9:]), strict=True):
        assert row["loss"] == pytest.approx(np.mean(of), rel=1e-6)


def test_another_seed_is_another_run(tmp_path):
    first, second = (trained(tmp_path / seed, configured("--seed", seed)) for seed in ("0", "1"))
    assert all(a["loss"] != b["loss"] for a, b in zip(first, second, strict=True))


def test_a_model_can_memorise_a_window(tmp_path):
    training_set = synthetic_training_set(2, 500)
    clip = training_set.clips[0]
    one = replace(training_set, clips=(clip._replace(poses=clip.poses[: windows.FIRST + 7]),))
    recipe = replace(RECIPE, iterations=100, n_seed=3, n_target=3, optimizer="adam", lr=2e-2, lr_milestones=(), batch=1)
    settings = TinyConfig(units=16, dropout=0, noise=0)
    configuration = replace(configured(), model=settings, recipe=recipe, validate_every=50, checkpoint_every=50)
    rows = trained(tmp_path, configuration, one)
    of_the_mean_pose = np.square(one.clips[0].poses[windows.FIRST :]).mean()
    assert rows[-1]["open"] < 0.02 * of_the_mean_pose
    assert rows[-1]["closed"] < 0.02 * of_the_mean_pose


def test_diverging_training_raises(tmp_path):
    configuration = configured("--recipe.lr", "1e38", "--recipe.optimizer", "sgd", "--recipe.clip_norm", "null")
    with pytest.raises(ValueError, match=r"^training of .* has diverged by iteration 3: the loss was \w+; try a lower"):
        trained(tmp_path, configuration)
    assert not (tmp_path / weights.FILE).exists()


# --- the choice of weights ---


@pytest.mark.parametrize(
    ("select", "average"), [("released", None), ("paper", None), ("euler", None), ("last", None), ("released", 0.5)]
)
def test_the_best_weights_are_kept(tmp_path, select, average):
    configuration = replace(configured("--select", select), average=average)
    rows = trained(tmp_path, configuration)
    of = {
        "released": lambda row: row["npss_released"],
        "paper": lambda row: row["npss_paper"],
        "euler": lambda row: np.mean([row[f"euler_{time}"] for time in SLICES_MS]),
        "last": lambda row: -row["iteration"],
    }[select]
    expected = min(rows, key=of)
    assert selection.best(rows, select) is expected
    with (tmp_path / log.FILE).open(encoding="utf-8") as file:
        assert [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)] == rows
    # Measured again, from the files.
    (task,) = synthetic_validation(2)
    pred = folder.load(tmp_path).predictor("gait", seed=0)(task.seed_frames, 100)
    gt, pred = npss.poses_to_euler(task.target), npss.poses_to_euler(pred)
    assert expected["npss_released"] == npss.score(gt, pred, convention="released")
    assert expected["npss_paper"] == npss.score(gt, pred)
    errors = npss.euler_error(gt, pred)
    assert [expected[f"euler_{time}"] for time in SLICES_MS] == [errors[time] for time in SLICES_MS]
    assert (average is None) == ("npss_paper_not_averaged" not in expected)
    with safe_open(tmp_path / weights.FILE, "pt") as file:
        measured = json.loads(file.metadata()["validation"])
    assert npss.parse_signature(measured.pop("signature"))["protocol"] == "synthetic-validation-2"
    assert measured == expected


def test_actions_have_equal_weight():
    tasks = [task for n in (2, 3) for task in synthetic_validation(n)]
    alone = [selection.measure([zero_velocity], [task]) for task in tasks]
    both = selection.measure([zero_velocity] * 2, tasks)
    assert both == {name: pytest.approx((alone[0][name] + alone[1][name]) / 2) for name in alone[0]}


# --- runs as predictors ---


@pytest.fixture
def run(tmp_path):
    trained(tmp_path, configured("--iterations", "1"))
    return tmp_path


def test_a_run_is_a_predictor(run):
    (task,) = synthetic_validation(3)
    before = torch.get_rng_state()
    predictor = folder.predictor_of(run, "gait", seed=5)
    first, second = predictor(task.seed_frames, 7), predictor(task.seed_frames, 7)
    assert torch.equal(torch.get_rng_state(), before)
    assert first.shape == (3, 7, 99)
    assert first.dtype == np.float64
    assert not np.array_equal(first, second)  # another draw
    again = folder.predictor_of(run, "gait", seed=5)
    assert np.array_equal(again(task.seed_frames, 7), first)
    assert np.array_equal(again(task.seed_frames, 7), second)
    single = again(task.seed_frames.astype(np.float32), 1)
    assert single.dtype == np.float32
    # By hand: normalised, predicted, un-normalised; the other columns at their mean.
    trained_run = folder.load(run)
    statistics, kept = trained_run.normalization, list(COLUMNS)
    seen = torch.from_numpy((task.seed_frames[..., kept] - statistics.mean[kept]) / statistics.std[kept]).float()
    with torch.random.fork_rng(), torch.no_grad():
        torch.manual_seed(int(np.random.default_rng(5).integers(2**63)))
        expected = trained_run.model.predict(seen, torch.ones(3, 1), 7).double().numpy()
    np.testing.assert_array_equal(first[..., kept], expected * statistics.std[kept] + statistics.mean[kept])
    others = sorted(set(range(99)) - set(kept))
    assert (first[..., others] == statistics.mean[others]).all()


def test_records_over_draws_hold_averages_and_standard_deviations(run):
    task = synthetic_task(3)
    predictor = folder.predictor_of(run, "gait", seed=4)
    single = [evaluate(run.name, predictor, task, sequences=True) for _ in range(5)]
    record = evaluate_run(run, task, draws=5, seed=4, sequences=True)
    assert (record["model"], record["action"], record["draws"]) == (run.name, "gait", 5)
    for of in (
        lambda record: record["npss"]["released"],
        lambda record: record["npss_windows"]["paper"]["1-2"],
        lambda record: record["euler_error"]["1000"],
    ):
        assert of(record) == pytest.approx(np.mean([of(one) for one in single]))
        assert of(record["std"]) == pytest.approx(np.std([of(one) for one in single]))
        assert of(record["std"]) > 0
    assert record["sequences"]["npss"]["paper"] == pytest.approx(
        np.mean([one["sequences"]["npss"]["paper"] for one in single], axis=0)
    )
    assert npss.parse_signature(record["signature"])["draws"] == 5
    assert npss.parse_signature(record["signatures"]["euler_error"])["draws"] == 5
    assert evaluate_run(run, task, draws=1, seed=4, sequences=True) == single[0]
    with pytest.raises(ValueError, match=r"^draws: expected a positive integer"):
        evaluate_run(run, task, draws=0)


def test_a_predictor_preserves_the_mode_of_the_model(run):
    model, statistics = folder.load(run).model, folder.load(run).normalization
    (task,) = synthetic_validation(1)
    for mode in (True, False):
        model.train(mode)
        ModelPredictor(model, statistics, 0, np.random.default_rng(0))(task.seed_frames, 2)
        assert model.training is mode


def test_bad_input_of_a_predictor_is_refused(run):
    predictor = folder.predictor_of(run, "gait", seed=0)
    seed = synthetic_validation(1)[0].seed_frames
    with pytest.raises(ValueError, match=r"^action: this model was trained on gait, not on 'walking'"):
        folder.predictor_of(run, "walking", seed=0)
    with pytest.raises(ValueError, match=r"^seed_frames: expected shape \(N, S, 99\), got \(50, 99\)"):
        predictor(seed[0], 3)
    with pytest.raises(ValueError, match=r"^poses: expected shape \(\.\.\., 99\)"):
        predictor(seed[..., :54], 3)
    with pytest.raises(ValueError, match=r"^n_target: "):
        predictor(seed, 0)
    nn.init.constant_(predictor.model.out.bias, np.nan)
    with pytest.raises(ValueError, match=r"^the model's prediction: nan at index"):
        predictor(seed, 3)


def test_errors_name_broken_runs(run):
    tensors = load_file(run / weights.FILE)
    wrong = [
        b"",
        b"nonsense",
        (run / weights.FILE).read_bytes()[:-8],
        serialized({name: value for name, value in tensors.items() if name != "mean"}),
        serialized({name: value for name, value in tensors.items() if name != "model.out.bias"}),
        serialized(tensors | {"model.out.bias": torch.zeros(3)}),
        serialized(tensors | {"std": torch.ones(54)}),
    ]
    for content in wrong:
        (run / weights.FILE).write_bytes(content)
        with pytest.raises(ValueError, match=rf"{weights.FILE}: not the weights of the model in .*{config.FILE}"):
            folder.load(run)
    (run / weights.FILE).unlink()
    with pytest.raises(
        FileNotFoundError, match=rf"{weights.FILE}: no such file; a run writes it at its first validation"
    ):
        folder.load(run)


# --- configurations ---


@pytest.mark.parametrize("name", ["vgru-d", "mbr-sup", "srnn"])
def test_a_configuration_file_repeats_the_run(tmp_path, name):
    options = ["--actions", "eating", "walking", "--subjects", "1", "11", "--seed", "5", "--iterations", "1000"]
    options += ["--average", "0.99", "--select", "euler", "--recipe.clip_norm", "null", "--validate-on", "eating"]
    configuration, _ = train_options.parse([name, *options, "--out", str(tmp_path / "a")])
    file = tmp_path / config.FILE
    config.write(file, configuration, "cpu")
    assert config.read(file) == configuration
    assert train_options.parse(["--config", str(file), "--out", str(tmp_path / "b")])[0] == configuration
    assert configuration.recipe == replace(MODELS[name].recipe.compressed(1000), clip_norm=None)
    assert configuration.model == MODELS[name].config
    assert (configuration.validate_every, configuration.checkpoint_every) == (50, 10)
    other, _ = train_options.parse(
        ["--config", str(file), "--seed", "6", "--iterations", "500", "--out", str(tmp_path / "b")]
    )
    assert other.seed == 6
    assert other.recipe == configuration.recipe.compressed(500)
    assert other.validate_every == 25


def test_defaults_and_overrides():
    plain, options = train_options.parse(["tiny", "--out", "nowhere", "--h36m", "somewhere"])
    assert (plain.data, plain.actions, plain.subjects) == ("h36m", ("walking",), TRAIN_SUBJECTS)
    assert (plain.model, plain.recipe) == (TINY.config, TINY.recipe)
    assert (plain.average, plain.select, plain.seed) == (None, "released", 0)
    assert (options.h36m, options.out, options.resume) == (Path("somewhere"), Path("nowhere"), False)
    assert train_options.parse(["tiny", "--out", "nowhere", "--action", "all"])[0].actions == ACTIONS
    changed = configured("--model.units", "9", "--recipe.closed_weight", "[[2, 0.5]]", "--recipe.optimizer=adam")
    assert changed.model == TinyConfig(units=9)
    assert changed.recipe == replace(RECIPE, closed_weight=((2, 0.5),), optimizer="adam")
    assert (changed.actions, changed.subjects, changed.validate_on) == (("gait",), (), ("gait",))


def test_subjects_that_are_held_out_are_not_trained_on(tmp_path):
    run = ["tiny", "--out", "nowhere", "--h36m", "somewhere", "--hold-out", "6", "1"]
    held_out, _ = train_options.parse(run)
    assert (held_out.hold_out, held_out.subjects) == ((6, 1), (7, 8, 9, 11))
    config.write(tmp_path / config.FILE, held_out, "cpu")
    assert config.read(tmp_path / config.FILE) == held_out
    with pytest.raises(ValueError, match=r"^hold_out: subject 6 is one to train on"):
        train_options.parse([*run, "--subjects", "6", "7"])
    with pytest.raises(ValueError, match=r"^hold_out: expected one or more of 1, 6, 7, 8, 9, 11, .*; got 5"):
        train_options.parse([*run[:-2], "5"])
    with pytest.raises(ValueError, match=r"^hold_out: expected one or more of none, .*; got 1"):
        train_options.parse(["tiny", "--out", "nowhere", "--data", "synthetic", "--hold-out", "1"])


def test_missing_fields_of_older_configurations_are_off(tmp_path):
    """Runs that are older than these options were trained without them."""
    configuration, _ = train_options.parse(["vgru-ac", "--data", "synthetic", "--out", str(tmp_path / "a")])
    config.write(tmp_path / config.FILE, configuration, "cpu")
    content = json.loads((tmp_path / config.FILE).read_text(encoding="utf-8"))
    for option in ("own_past", "restart_derivatives"):
        assert content["model"].pop(option) is False
    assert content.pop("hold_out") == []
    (tmp_path / config.FILE).write_text(json.dumps(content), encoding="utf-8")
    assert config.read(tmp_path / config.FILE) == configuration
    options = ["vgru-ac", "--data", "synthetic", "--model.own_past", "true", "--out", str(tmp_path / "b")]
    assert train_options.parse(options)[0].model == replace(configuration.model, own_past=True)


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["walker"], "MODEL: expected one of vgru-d, gru-d, .*, tiny, .*got 'walker'"),
        ([], "MODEL: expected one of vgru-d, .* as the first argument, or --config FILE"),
        (
            ["tiny", "--model.cell", "x"],
            "unrecognized arguments: --model.cell x; the options are --model.dropout, --model.n",
        ),
        (
            ["tiny", "--recipe.rate", "x"],
            "unrecognized arguments: .*; the options are --recipe.batch, .*, --recipe.reg",
        ),
        (["tiny", "--actoins", "x"], "unrecognized arguments: --actoins x; did you mean --actions\\?$"),
        (["tiny", "--iteration", "9"], "unrecognized arguments: --iteration 9; did you mean --iterations\\?$"),
        (["tiny", "--recipe.iteration", "9"], "unrecognized arguments: .*; did you mean --recipe.iterations\\?$"),
        (["tiny", "--colour", "x"], "unrecognized arguments: .*; the options are --actions, .*, --validate-every"),
        (["tiny", "--model.units", "many"], r"model\.units:\n.*Got value: many"),
        (["tiny", "--recipe.lr", "-1"], "lr: expected a positive, finite number, got -1.0"),
        (
            ["tiny", "--action", "wlking"],
            "actions: expected one or more of directions, .*, walkingtogether, without duplicates; got wl",
        ),
        (["tiny", "--action", "walking", "walking"], "actions: .* without duplicates; got walking, walking"),
        (
            ["tiny", "--data", "synthetic", "--action", "eating"],
            "actions: expected one or more of gait, without duplicates; got eating",
        ),
        (
            ["tiny", "--validate-on", "eating"],
            "validate_on: expected one or more of walking, without duplicates; got eating",
        ),
        (["tiny", "--subjects", "5"], "subjects: expected one or more of 1, 6, 7, 8, 9, 11, without duplicates; got 5"),
        (
            ["tiny", "--data", "synthetic", "--subjects", "1"],
            "subjects: expected one or more of none, without duplicates; got 1",
        ),
        (["tiny", "--seed", "-1"], "seed: expected an integer from 0"),
        (["tiny", "--average", "1"], "average: expected a decay between 0 and 1, got 1.0"),
        (["tiny", "--validate-every", "0"], "validate_every: expected a positive integer"),
        (["tiny", "--checkpoint-every", "0"], "checkpoint_every: expected a positive integer"),
        (["tiny", "--iterations", "0"], "iterations: expected a positive integer"),
        (["tiny", "--device", "abacus"], "argument --device: invalid choice: 'abacus'"),
    ],
)
def test_errors_of_arguments_list_the_choices(options, message):
    with pytest.raises(ValueError, match=f"^{message}"):
        train_options.parse([*options, "--out", "nowhere"])


def test_a_run_needs_a_folder():
    with pytest.raises(ValueError, match=r"^--out RUN is required: the folder of the run"):
        train_options.parse(["tiny"])


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ([], r"expected an object, got \[\]"),
        ({"model": {}}, "name: expected one of .*, got None"),
        ({"name": "tiny", "colour": 1}, "unknown field 'colour'; expected made_with, paths, plugins, name, model, .*"),
        ({"name": "tiny", "model": {"cell": 1}}, "model: unknown field 'cell'; expected units, dropout, noise"),
        ({"name": "tiny", "recipe": {"class_path": "hostile.Recipe"}}, "recipe: unknown field 'class_path'"),
        ({"name": "tiny", "model": "hostile.json"}, "model: expected an object, got 'hostile.json'"),
        ({"name": "tiny", "model": {"units": "many"}}, r"model\.units:"),
        ({"name": "tiny", "actions": "walking"}, "actions: expected a sequence"),
        ({"name": "tiny", "seed": None}, "seed: expected an integer, got None"),
    ],
)
def test_errors_name_an_invalid_configuration_file(tmp_path, content, message):
    file = tmp_path / "some.json"
    file.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(ValueError, match=rf"some\.json: {message}"):
        config.read(file)


def test_the_formatting_of_a_configuration_does_not_matter(tmp_path):
    assert check_texts(config.read, tmp_path / "some.json", '{"name": "tiny"}').name == "tiny"


# --- commands ---


def test_help_names_models_and_their_fields(capsys):
    for options, expected in (
        (["train", "--help"], "vgru-d, gru-d"),
        (["train", "tiny", "-h"], "--model.units"),
        (["train", "-h"], "set the seed of the initial weights and every iteration (default: 0)"),
        (["train", "-h"], "--out RUN write the run to this folder, created if missing --config"),
        (["--help"], "train a model"),
    ):
        with pytest.raises(SystemExit) as done:
            command(*options)
        assert done.value.code == 0
        text = " ".join(capsys.readouterr().out.split())
        assert expected in text
        assert "<" not in text  # no Python types


@pytest.mark.parametrize(
    "arguments",
    [
        ["tiny", "--recipe.batch", 3],
        ["vgru-d", "--model.n_units", 4, "--recipe.batch", 2, "--recipe.n_target", 4, "--average", 0.5],
        ["mbr-sup", "--model.size", 4, "--recipe.batch", 2, "--recipe.n_target", 4],
    ],
)
def test_from_training_to_a_score_without_data(tmp_path, capsys, monkeypatch, arguments):
    monkeypatch.setattr(_progress, "_FIRST", math.inf)  # no progress lines on a slow machine
    out = tmp_path / "run"
    assert command("train", *arguments, "--data", "synthetic", "--iterations", 3, "--out", out) == 0
    captured = capsys.readouterr()
    assert captured.err == ""
    assert "weights of iteration" in captured.out
    assert "npss+euler_error|version:1|convention:released+paper|" in captured.out
    assert {file.name for file in out.iterdir()} == {
        *(config.FILE, weights.FILE, config.CHECKPOINT, log.FILE, launch.LOCK)
    }
    assert command("predict", out, "--out", tmp_path / "samples.h5", "--seed", 3) == 0
    capsys.readouterr()
    (pair,) = read_poses(tmp_path / "samples.h5")
    assert (pair.name, pair.pred.shape) == ("gait", (64, 100, 99))
    assert np.array_equal(pair.gt, synthetic_task().target)
    predicted = folder.predictor_of(out, "gait", seed=3)(synthetic_task().seed_frames, 100)
    assert np.array_equal(pair.pred, predicted)


def test_the_other_commands_read_samples(run, capsys):
    for name in ("samples.h5", "samples.npz"):
        assert command("predict", run, "--out", run / name) == 0
        capsys.readouterr()
        assert main(["score", str(run / name)]) == 0
        assert "The file's own Euler error curve is reproduced" in capsys.readouterr().out
    (pair,) = map(converted, read_poses(run / "samples.npz"))
    record = evaluate("run", folder.predictor_of(run, "gait", seed=0), synthetic_task())
    assert record["npss"]["paper"] == npss.score(pair.gt, pair.pred)


def test_a_command_can_be_repeated_and_resumed(tmp_path, capsys):
    first, second = tmp_path / "first", tmp_path / "second"
    arguments = ["--data", "synthetic", "--iterations", 4, "--validate-every", 2]
    assert command("train", "tiny", *arguments, "--out", first, "--resume") == 0  # had not started
    assert command("train", "--config", first / config.FILE, "--out", second) == 0
    assert same(outcome(first), outcome(second))
    assert (first / weights.FILE).read_bytes() == (second / weights.FILE).read_bytes()
    assert command("train", "tiny", *arguments, "--out", first, "--resume") == 0
    assert command("train", "--resume", "--out", first) == 0
    assert same(outcome(first), outcome(second))
    capsys.readouterr()
    fourth = ["--config", first / config.FILE, "--seed", 1, "--resume", "--out", tmp_path / "fourth"]
    assert command("train", *fourth) == 0  # resumes nothing, so nothing is changed
    for wrong, message in (
        (["tiny", *arguments, "--out", first], f"--out: {first} already holds a run; --resume continues it"),
        (["gru-d", "--out", first, "--resume"], f"MODEL: 'gru-d', but {first / config.FILE} configures 'tiny'"),
        (["--out", first, "--resume", "--seed", 1], f"--resume: {first / config.FILE} has another value of seed; "),
        (
            ["--out", tmp_path / "third", "--resume"],
            f"--resume: no config.json in {tmp_path / 'third'}; to start a run",
        ),
        (
            ["--out", tmp_path / "third", "--config", "nowhere.json"],
            "nowhere.json: reading the configuration: No such",
        ),
    ):
        assert command("train", *wrong) == 2
        assert message in capsys.readouterr().err


def test_a_command_trains_several_at_once(tmp_path, capsys):
    options = ["tiny", "--data", "synthetic", "--iterations", 4, "--validate-every", 2]
    several = [*options, "--seeds", 3, 1, "--out", tmp_path / "several"]
    assert command("train", *several) == 0
    printed = capsys.readouterr().out
    assert command("train", *options, "--seed", 1, "--out", tmp_path / "one") == 0
    names = {file.name for file in (tmp_path / "several").iterdir()} - {launch.LOCK}
    assert names == {"seed-1", "seed-3", config.CHECKPOINT}
    for name in names - {config.CHECKPOINT}:
        assert f"{name}/{weights.FILE}: weights of iteration" in printed
    for file in (config.FILE, weights.FILE, log.FILE):
        assert (tmp_path / "several" / "seed-1" / file).read_bytes() == (tmp_path / "one" / file).read_bytes()
    assert command("train", *several, "--resume") == 0
    capsys.readouterr()
    before = sorted(tmp_path.rglob("*"))
    for wrong, message in (
        (several, f"--out: {tmp_path}/several/seed-3 already holds a run; --resume continues it"),
        ([*several, "--resume", "--average", 0.5], "seed-3/config.json has another value of average"),
        (
            [*options, "--seeds", 1, "--resume", "--out", tmp_path / "one"],
            f"--out: {tmp_path}/one is a run, not a folder",
        ),
        ([*options, "--seeds", 1, 1, "--out", tmp_path / "new"], "--seeds: expected different seeds, got 1, 1"),
        ([*options, "--seeds", 1, "--seed", 1, "--out", tmp_path / "new"], "--seed: not allowed with --seeds"),
        ([*options, "--seeds", 3, "--out", tmp_path / "several", "--resume"], "last.ckpt holds seed-3, seed-1, not se"),
        ([*several, "--resume", "--seeds", 3, 1, 2], "several holds other runs, and seed-2 is not among them"),
        ([*options, "--seeds", 2, "--out", tmp_path / "several"], "holds other runs, and seed-2 is not among them"),
        ([*options, "--out", tmp_path / "several"], f"--out: {tmp_path}/several holds the runs of --seeds"),
        (["--resume", "--out", tmp_path / "several" / "seed-1"], f"is one of several runs; give --out {tmp_path}/sev"),
        ([*options, "--seeds", -1, "--out", tmp_path / "new"], "seed: expected an integer from 0 to 2**32 - 1"),
    ):
        assert command("train", *wrong) == 2
        assert message in capsys.readouterr().err
    assert sorted(tmp_path.rglob("*")) == before


def test_apart_trains_a_model_for_each_action(tmp_path):
    options = ["tiny", "--data", "synthetic", "--iterations", 2]
    assert command("train", *options, "--apart", "--out", tmp_path / "apart") == 0
    assert command("train", *options, "--out", tmp_path / "one") == 0
    for file in (config.FILE, weights.FILE, log.FILE):
        assert (tmp_path / "apart" / "gait" / file).read_bytes() == (tmp_path / "one" / file).read_bytes()


def test_apart_and_seeds_give_separate_runs(tmp_path):
    options = ["tiny", "--actions", "eating", "walking", "--apart", "--out", str(tmp_path)]
    configurations = dict.fromkeys(("eating", "walking"))
    for configuration, out in train_options.runs_of(*train_options.parse(options)):
        assert configuration.actions == configuration.validate_on == (out.name,)
        configurations[out.name] = configuration
    assert configurations["walking"] == train_options.parse(["tiny", "--action", "walking", "--out", "nowhere"])[0]
    both = train_options.runs_of(*train_options.parse([*options, "--seeds", "0", "4"]))
    assert [out.name for _, out in both] == ["eating-seed-0", "eating-seed-4", "walking-seed-0", "walking-seed-4"]
    assert [configuration.seed for configuration, _ in both] == [0, 4, 0, 4]
    with pytest.raises(
        ValueError, match=r"^--validate-on: not allowed with --apart, which validates each model on its action"
    ):
        train_options.runs_of(*train_options.parse([*options, "--validate-on", "eating"]))


def test_commands_refuse_bad_input(run, tmp_path, capsys, monkeypatch):
    monkeypatch.delenv("NPSS_H36M", raising=False)
    for wrong, message in (
        (
            ["train", "tiny", "--out", tmp_path / "new"],
            "no source of motion: give --h36m DIR (the folder of Human3.6M, with dataset/ in it) or --data synthetic",
        ),
        (
            ["predict", tmp_path / "nowhere", "--out", "x.h5"],
            f"error: {tmp_path}/nowhere: no such folder",
        ),
        (
            ["train", "tiny", "--data", "synthetic", "--device", "cpu", "--tf32", "--out", tmp_path / "new"],
            "--tf32: needs a CUDA device",
        ),
        (["predict", run, "--out", tmp_path / "x.mat"], "--out: expected a .h5, .hdf5 or .npz file, got"),
        (["predict", run, "--out", tmp_path / "x.h5", "--seed", -1], "seed: expected a whole number >= 0, got -1"),
        (["predict", run, "--out", tmp_path / "x.h5", "--actions", "eating"], "--actions: expected one of gait"),
    ):
        assert command(*wrong) == 2
        assert message in capsys.readouterr().err
    assert not (tmp_path / "new").exists()
    assert not (tmp_path / "x.h5").exists()


@pytest.mark.parametrize("terminal", [True, False])
def test_only_terminals_see_the_progress_bar(tmp_path, capsys, monkeypatch, terminal):
    monkeypatch.setattr(sys.stdout, "isatty", lambda: terminal)
    trained(tmp_path, configured("--iterations", "2"))
    captured = capsys.readouterr()
    assert ("2/2" in captured.out and "loss=" in captured.out) is terminal
    assert terminal or captured.out == captured.err == ""


def test_tensorboard_logs_hold_the_rows_of_the_table(tmp_path):
    pytest.importorskip("tensorboard")
    from tensorboard.backend.event_processing.event_accumulator import EventAccumulator

    out = tmp_path / "run"
    assert command("train", "tiny", "--data", "synthetic", "--iterations", 2, "--out", out, "--tensorboard") == 0
    events = EventAccumulator(str(out / "tensorboard")).Reload()
    logged = [(event.step, event.value) for event in events.Scalars("npss_paper")]
    with (out / log.FILE).open(encoding="utf-8") as file:
        rows = [(int(row["iteration"]), float(row["npss_paper"])) for row in csv.DictReader(file)]
    assert logged == [(step, pytest.approx(value, rel=1e-6)) for step, value in rows]


def test_real_motion(h36m_root, tmp_path, capsys):
    out, file = tmp_path / "run", tmp_path / "samples.h5"
    arguments = ["--actions", "walking", "eating", "--subjects", 1, "--validate-on", "eating", "--iterations", 2]
    assert command("train", "tiny", "--h36m", h36m_root, *arguments, "--out", out) == 0
    assert command("predict", out, "--h36m", h36m_root, "--out", file) == 0
    pairs = {pair.name: pair for pair in read_poses(file)}
    assert {name: pair.pred.shape for name, pair in pairs.items()} == dict.fromkeys(("eating", "walking"), (8, 100, 99))
    tasks = {task.action: task for task in Human36M().tasks(h36m_root, ["eating", "walking"])}
    assert all(np.array_equal(pairs[name].gt, task.target) for name, task in tasks.items())
    walking = folder.predictor_of(out, "walking", seed=0)(tasks["walking"].seed_frames, 100)
    assert np.array_equal(pairs["walking"].pred, walking)
    assert "protocol:validation-every-25|unwrap:off|actions:eating" in capsys.readouterr().out
    arguments = ["--actions", "walking", "--hold-out", 1, 11, "--iterations", 2, "--validate-every", 2]
    assert command("train", "tiny", "--h36m", h36m_root, *arguments, "--out", tmp_path / "held-out") == 0
    assert "protocol:held-out-1-11-every-25|unwrap:off|actions:walking" in capsys.readouterr().out


def test_windows_of_held_out_subjects_are_cut_from_their_clips_alone(h36m_root):
    source = Human36M()
    (task,) = source.held_out_tasks(h36m_root, ["walking"], (6, 11))
    clips = [clip[::2] for subject in (6, 11) for clip in (recorded(h36m_root, subject, i) for i in (1, 2))]
    starts = [(clip, start) for clip in range(4) for start in range(16, len(clips[clip]) - 149, 25)]
    assert task.groups == tuple(clip for clip, _ in starts)
    for (clip, start), seed_frames, target in zip(starts, task.seed_frames, task.target, strict=True):
        np.testing.assert_array_equal(np.concatenate([seed_frames, target]), clips[clip][start : start + 150])


def recorded(root, subject, clip):
    """Read a clip of walking as it is in its file."""
    return np.loadtxt(root / "dataset" / f"S{subject}" / f"walking_{clip}.txt", delimiter=",", dtype=np.float32)
