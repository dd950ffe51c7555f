"""Tests of training: gradients against autograd, interruption, and the command."""

import copy
import csv
import json
import math
import pickle
import signal
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
import torch
from safetensors.torch import load_file
from safetensors.torch import save as serialized

from manifold_trainings import TINY, configured, outcome, small_chunks, train_until_killed, trained, walkers
from npss_baselines.commands import train_manifold
from npss_baselines.data.synthetic import synthetic_clips
from npss_baselines.manifold.model.autoencoder import Autoencoder, AutoencoderConfig
from npss_baselines.manifold.model.per_window_sgd import PerWindowSGD
from npss_baselines.manifold.motion.dataset import MotionSet, prepare
from npss_baselines.manifold.motion.features import local_positions
from npss_baselines.manifold.motion.split import held_out_subjects, split, validation_subjects
from npss_baselines.manifold.training import config, folder, trainer
from npss_baselines.manifold.training.loss import loss_of
from npss_baselines.manifold.training.recipe import PAPER, RECIPES, Stage
from npss_baselines.runs import launch, log, weights
from npss_baselines.runs.config import CHECKPOINT
from outcomes import same
from texts import check_texts


@pytest.fixture(autouse=True)
def _small_chunks(monkeypatch):
    """Use several chunks per epoch, and save only some."""
    small_chunks(monkeypatch.setattr)


@pytest.fixture(scope="module")
def sets():
    return walkers(4, 240, 1), walkers(2, 160, 2)


# --- the loss and its gradient ---


def frame_weights(mask, pooled, width):
    """Return the weights of frames, by counting."""
    counts = np.array([[any(window[t : t + pooled]) for t in range(0, len(window), pooled)] for window in mask])
    return torch.from_numpy(counts / (counts.sum(1, keepdims=True) * width)).unsqueeze(2)


@pytest.mark.parametrize("unpool", ["both", "half"])
@pytest.mark.parametrize("random", [True, False])
@pytest.mark.parametrize("depth", [1, 2, 3])
def test_per_window_sgd_equals_autograd(unpool, random, depth):
    """Compare in float64, up to rounding, with clipped and unclipped values."""
    torch.manual_seed(depth)
    made = AutoencoderConfig(n_features=6, widths=(5, 7, 4)[:depth], kernel=5, unpool=unpool, eps=0.4)
    network = Autoencoder(made).double()
    for layer in network.first():
        torch.nn.init.uniform_(layer.bias, -0.2, 0.2)
        with torch.no_grad():
            layer.weight *= 1.5
    other = copy.deepcopy(network)
    rng = np.random.default_rng(0)
    windows = torch.from_numpy(rng.normal(size=(4, 16, 6)))
    mask = rng.random((4, 16)) < 0.7
    of_frames, of_steps = frame_weights(mask, 1, 6), frame_weights(mask, 2**depth, made.widths[-1])
    options = {"corruption": 0.3, "sparsity": 0.2, "random": random}
    by_hand = PerWindowSGD(network.first(), 16, **options)
    optimizer = torch.optim.SGD(other.parameters(), lr=0.1)
    clipped = other.encode(windows).detach().abs() > 0.6
    assert clipped.any()
    assert not clipped.all()
    for i in range(4):
        torch.manual_seed(i)
        loss = loss_of(other.first(), windows[[i]], of_frames[[i]], of_steps[[i]], **options)
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
        torch.manual_seed(i)
        with torch.no_grad():
            assert by_hand.step(windows[i], of_frames[i], of_steps[i], 0.1).item() == pytest.approx(loss.item())
        by_hand.keep()
        for first, second in zip(network.parameters(), other.parameters(), strict=True):
            torch.testing.assert_close(first, second, rtol=0, atol=1e-12)


def test_loss():
    network = Autoencoder(replace(TINY, n_features=6)).double()
    rng = np.random.default_rng(0)
    windows, mask = torch.from_numpy(rng.normal(size=(3, 8, 6))), rng.random((3, 8)) < 0.6
    with torch.no_grad():
        code, projected = network.encode(windows), network.project(windows)
        loss = loss_of(
            network.first(),
            windows,
            frame_weights(mask, 1, 6),
            frame_weights(mask, 4, 5),
            corruption=0.0,
            sparsity=0.3,
            random=False,
        )
    squares, magnitudes = ((projected - windows) ** 2).numpy(), code.abs().numpy()
    steps = mask.reshape(3, 2, 4).any(2)
    each = [squares[i][mask[i]].mean() + 0.3 * magnitudes[i][steps[i]].mean() for i in range(3)]
    assert loss.item() == pytest.approx(np.mean(each))


@pytest.mark.parametrize("loss", ["mean", "sum"])
def test_masked_frames_do_not_count(sets, tmp_path, loss):
    """Padding beyond the reach of filters has no effect; within it, padding is only context."""
    training_set, validation_set = sets
    windows = training_set.windows.copy()
    windows[0, 120:] = 1e3
    other = replace(training_set, windows=windows)
    plain = Stage(epochs=1, corruption=0.0, sparsity=0.1)
    losses = []
    for i, motion in enumerate((training_set, other)):
        module = trainer.Training(configured(layers=plain, loss=loss), motion, validation_set, tmp_path)
        module._begin(0)
        losses.append([])
        for phase in range(2):
            module._begin(phase)
            tensors = (module._seen[:1], module._of_frames[:1], module._of_steps[:1])
            layer = module.network.first()[phase : phase + 1]
            options = {"corruption": 0.0, "sparsity": 0.1, "random": False}
            losses[i].append(loss_of(layer, *tensors, **options).item())
    assert losses[0] == pytest.approx(losses[1], rel=1e-6)
    assert module._of_frames[0].sum() == pytest.approx(1 / 4 if loss == "mean" else 50)


def test_rescaled_corruption():
    """The expected input is then the motion."""
    torch.manual_seed(0)
    network = Autoencoder(TINY)
    windows = torch.randn(3, 8, 63)
    of_frames, of_steps = torch.rand(3, 8, 1), torch.zeros(3, 2, 1)
    torch.manual_seed(1)
    loss = loss_of(
        network.first(), windows, of_frames, of_steps, corruption=0.25, sparsity=0.0, random=False, rescale=True
    )
    torch.manual_seed(1)
    kept = torch.empty_like(windows).bernoulli_(0.75)
    expected = ((network.project(windows * kept * 4 / 3) - windows) ** 2 * of_frames).sum() / 3
    torch.testing.assert_close(loss, expected)


# --- a run ---


def test_training_equals_a_plain_loop(sets, tmp_path):
    """Compare order, seeds, corruption, frozen layers, rates and clipping with a plain loop."""
    training_set, validation_set = sets
    configuration = replace(configured(), seed=7, select="last")
    before = torch.get_rng_state()
    rows = trained(tmp_path, configuration, sets)
    assert torch.equal(torch.get_rng_state(), before)

    frames = training_set.windows[training_set.mask].astype(np.float64)
    mean = frames.mean(0)
    scale = frames.std(0)
    scale[:60] = np.sqrt(np.mean(scale[:60] ** 2))
    scale /= 0.5
    windows = torch.from_numpy(((training_set.windows - mean) / scale).astype(np.float32))
    n = len(windows)
    torch.manual_seed(7)
    network = Autoencoder(TINY)
    first, second = network.first()
    phases = [([first], configuration.layers, 0), ([second], configuration.layers, 1)]
    phases.append(([first, second], configuration.whole, 0))
    expected, norms = [], []
    for number, (layers, stage, below) in enumerate(phases):
        parameters = [parameter for layer in layers for parameter in layer.parameters()]
        kind = torch.optim.Adam if stage.optimizer == "adam" else torch.optim.SGD
        optimizer = kind(parameters, lr=stage.lr)
        seen = network.encode(windows, below).detach()
        of_frames = frame_weights(training_set.mask, 2**below, seen.shape[2]).float()
        of_steps = frame_weights(training_set.mask, 2 ** (below + len(layers)), layers[-1].bias.numel()).float()
        chunks, n_batches = math.ceil(n / 3), math.ceil(n / stage.batch)
        for epoch in range(stage.epochs):
            order, losses = np.random.default_rng([7, number, epoch]).permutation(n), []
            for i in range(n_batches):
                if i * stage.batch % 3 == 0:
                    entropy = np.random.SeedSequence([7, number, epoch * chunks + i * stage.batch // 3, 1])
                    torch.manual_seed(int(entropy.generate_state(1, np.uint64)[0]))
                batch = order[i * stage.batch :][: stage.batch]
                loss = loss_of(
                    layers,
                    seen[batch],
                    of_frames[batch],
                    of_steps[batch],
                    corruption=0.1,
                    sparsity=stage.sparsity,
                    random=stage.unpool == "random",
                    rescale=stage.rescale,
                )
                optimizer.zero_grad()
                loss.backward()
                if stage.clip_norm:
                    norms.append(torch.nn.utils.clip_grad_norm_(parameters, stage.clip_norm).item())
                share = (epoch + i / n_batches) / 3
                cosine = stage.optimizer == "adam"
                rate = 1e-2 * (1 + math.cos(math.pi * share)) / 2 if cosine else 0.05 * 0.9**epoch
                optimizer.param_groups[0]["lr"] = rate
                optimizer.step()
                losses += [loss.item()] * len(batch)
            expected.append((["layer 1", "layer 2", "whole"][number], epoch + 1, np.mean(losses)))
    assert max(norms) > 0.1  # clipping had something to do
    assert [(row["phase"], row["epoch"]) for row in rows] == [(phase, epoch) for phase, epoch, _ in expected]
    assert [row["loss"] for row in rows] == pytest.approx([loss for _, _, loss in expected], rel=1e-4)
    for name, value in outcome(tmp_path)["weights"].items():
        torch.testing.assert_close(value, network.state_dict()[name.removeprefix("network.")], rtol=1e-4, atol=1e-5)
    # Measure the error again, from the file.
    projected = folder.load(tmp_path).projector.project(validation_set.windows)
    distances = np.linalg.norm(local_positions(projected) - local_positions(validation_set.windows), axis=-1)
    assert rows[-1]["error"] == pytest.approx(distances[validation_set.mask].mean(), rel=1e-5)
    with (tmp_path / log.FILE).open(encoding="utf-8") as file:
        read = list(csv.DictReader(file))
    assert [float(row["error"]) for row in read] == [row["error"] for row in rows]


def test_interrupted_run_gives_the_same_result(tmp_path, sets, processes):
    configuration = configured()
    expected = trained(tmp_path / "whole", configuration, sets)
    out = tmp_path / "killed"
    for moment, number in (
        ("writing", 2),  # the first checkpoint
        ("batch", 9),  # window 9 of layer 1
        ("batch", 20),  # in layer 2
        ("written", 7),  # the model of the last phase's first epoch is there, but not the checkpoint that goes with it
        ("batch", 2),
    ):
        process = processes.Process(target=train_until_killed, args=(out, configuration, sets, moment, number))
        process.start()
        process.join()
        assert process.exitcode == -signal.SIGKILL, (moment, number)
        if (out / weights.FILE).exists():
            folder.load(out)  # the file is whole
    assert (out / weights.FILE).exists()
    assert trained(out, configuration, sets) == expected
    assert same(outcome(out), outcome(tmp_path / "whole"))
    assert trained(out, configuration, sets) == expected  # nothing is left to do
    assert same(outcome(out), outcome(tmp_path / "whole"))


def test_kept_weights(tmp_path, sets, monkeypatch):
    for select, epoch in (("best", 2), ("last", 3)):
        errors = iter([0.1, 0.1, 0.1, 0.1, 0.4, 0.2, 0.3])  # those of other phases do not count
        monkeypatch.setattr(trainer.Training, "_error", lambda *_, errors=errors: next(errors))
        rows = trained(tmp_path / select, configured(select=select), sets)
        kept = trainer.best(rows, select)
        assert (kept["phase"], kept["epoch"]) == ("whole", epoch)
        assert folder.load(tmp_path / select).measured == kept
    first, second = (load_file(tmp_path / select / weights.FILE) for select in ("best", "last"))
    assert not same(first, second)
    last = outcome(tmp_path / "last")["weights"]
    assert same({name: second[name] for name in last}, last)


def test_stages_without_epochs_are_skipped(tmp_path, sets):
    rows = trained(tmp_path, configured(layers=Stage(epochs=0)), sets)
    assert {row["phase"] for row in rows} == {"whole"}
    rows = trained(tmp_path / "layers", configured(whole=Stage(epochs=0)), sets)
    assert [row["phase"] for row in rows] == ["layer 1"] * 2 + ["layer 2"] * 2
    assert folder.load(tmp_path / "layers").measured["phase"] == "layer 2"
    with pytest.raises(ValueError, match=r"^whole: expected at least one epoch"):
        configured(layers=Stage(epochs=0), whole=Stage(epochs=0))


def test_it_learns_and_another_seed_is_another_run(tmp_path, sets):
    rows = trained(tmp_path / "0", configured(), sets)
    others = trained(tmp_path / "1", replace(configured(), seed=1), sets)
    assert rows[-1]["loss"] < 0.9 * rows[-3]["loss"]
    assert all(a["loss"] != b["loss"] for a, b in zip(rows, others, strict=True))


def test_divergence(tmp_path, sets):
    for wrong, phase, option in (("layers", "layer 1", "layers.lr"), ("whole", "whole", "whole.lr")):
        configuration = configured(**{wrong: Stage(epochs=9, lr=1e9)})
        message = rf"^training has diverged: .* in epoch \d of {phase}; try a lower --{option}"
        with pytest.raises(ValueError, match=message):
            trained(tmp_path / wrong, configuration, sets)


def test_divergence_in_the_last_step(tmp_path, sets):
    """No loss is computed after the last step."""
    n = len(sets[0].windows)
    configuration = configured(layers=Stage(epochs=0), whole=Stage(epochs=1, batch=n, lr=1e30))
    message = r"^training has diverged: .* every value must be finite in epoch 1 of whole; try a lower --whole\.lr"
    with pytest.raises(ValueError, match=message):
        trained(tmp_path, configuration, sets)
    assert not (tmp_path / weights.FILE).exists()


def test_motion_of_the_wrong_shape(tmp_path, sets):
    with pytest.raises(ValueError, match=r"^model.n_features: 60, but the motion has 63"):
        trained(tmp_path, configured(model=replace(TINY, n_features=60)), sets)
    with pytest.raises(ValueError, match=r"^model: 160 frames are not a multiple of 64"):
        trained(tmp_path, configured(model=replace(TINY, widths=(2,) * 6)), sets)


# --- files ---


@pytest.fixture
def run(tmp_path, sets):
    trained(tmp_path, configured(layers=Stage(epochs=0), whole=Stage(epochs=1)), sets)
    return tmp_path


def test_signature_depends_on_weights_and_training(run):
    loaded = folder.load(run)
    signature = loaded.projector.signature
    assert signature.startswith("manifold-")
    assert folder.load(run).projector.signature == signature
    statistics, network = loaded.projector.scaling, loaded.projector.network
    signatures = {signature}
    for changed in ({"seed": 1}, {"data": config.Data(("cmu",), 1, 2, "ab")}, {"whole": Stage(epochs=2)}):
        other = replace(loaded.configuration, **changed)
        config.write(run / config.FILE, other, "cpu")
        signatures.add(folder.load(run).projector.signature)
    config.write(run / config.FILE, loaded.configuration, "cuda")
    assert folder.load(run).projector.signature == signature
    with torch.no_grad():
        network.first()[0].bias[0] += 1e-6
    folder.save(run, network, statistics, loaded.measured)
    signatures.add(folder.load(run).projector.signature)
    assert len(signatures) == 5


def test_broken_runs_are_named(run):
    content = (run / weights.FILE).read_bytes()
    tensors = load_file(run / weights.FILE)
    header = {"validation": "{}"}
    bias = "network.layers.0.bias"
    for wrong in (
        b"",
        b"nonsense",
        content[:-8],
        serialized(tensors),
        serialized(tensors, {"validation": "{"}),
        serialized({name: value for name, value in tensors.items() if name != "mean"}, header),
        serialized({name: value for name, value in tensors.items() if name != bias}, header),
        serialized(tensors | {bias: torch.zeros(3)}, header),
        serialized(tensors | {"scale": torch.ones(60)}, header),
    ):
        (run / weights.FILE).write_bytes(wrong)
        with pytest.raises(ValueError, match=rf"{weights.FILE}: not the weights of the model in .*{config.FILE}"):
            folder.load(run)
    (run / weights.FILE).unlink()
    with pytest.raises(FileNotFoundError, match=rf"{weights.FILE}: no such file; a run writes it"):
        folder.load(run)


def test_a_checkpoint_cannot_run_code(tmp_path, sets):
    class Hostile:
        def __reduce__(self):
            return (Path.touch, (tmp_path / "ran",))

    for content in (pickle.dumps(Hostile(), 2), b"nonsense"):
        (tmp_path / CHECKPOINT).write_bytes(content)
        with pytest.raises(ValueError, match=r"last\.ckpt: not a checkpoint"):
            trained(tmp_path, configured(), sets)
    assert not (tmp_path / "ran").exists()


@pytest.mark.parametrize("recipe", RECIPES)
def test_configuration_reproduces_a_run(tmp_path, recipe):
    options = [
        "--recipe",
        recipe,
        "--seed",
        "5",
        "--depth",
        "2",
        "--quick",
        "--model.eps",
        "0.1",
        "--layers.lr",
        "0.25",
    ]
    configuration, _ = train_manifold.parse([*options, "--out", str(tmp_path / "a")])
    chosen = RECIPES[recipe]
    assert configuration.model == AutoencoderConfig(widths=(64, 128), unpool=chosen.unpool, eps=0.1)
    for name in ("scale", "size", "loss", "start"):
        assert getattr(configuration, name) == getattr(chosen, name)
    assert configuration.seed == 5
    assert configuration.quick
    assert configuration.layers == replace(chosen.layers, lr=0.25, epochs=min(chosen.layers.epochs, 5))
    (tmp_path / "a").mkdir()
    config.write(tmp_path / "a" / config.FILE, configuration, "cpu")
    assert config.read(tmp_path / "a" / config.FILE) == configuration
    again, _ = train_manifold.parse(["--config", str(tmp_path / "a" / config.FILE), "--out", str(tmp_path / "b")])
    assert again == configuration
    resumed, _ = train_manifold.parse([*options[2:], "--resume", "--out", str(tmp_path / "a")])
    assert resumed == configuration


def test_schedule_of_the_paper():
    configuration, _ = train_manifold.parse(["--recipe", "paper", "--out", "nowhere"])
    assert (PAPER.layers.epochs, PAPER.layers.batch, PAPER.layers.optimizer) == (25, 1, "sgd")
    assert PAPER.layers.learning_rate(0) == 0.5
    assert PAPER.layers.learning_rate(2) == pytest.approx(0.5 * 0.81)
    assert (PAPER.layers.corruption, PAPER.layers.sparsity, PAPER.layers.unpool) == (0.1, 0.01, "random")
    assert (PAPER.whole.learning_rate(24), PAPER.whole.sparsity, PAPER.whole.unpool) == (0.01, 0, "even")
    assert not PAPER.layers.rescale
    assert not PAPER.whole.rescale
    assert (PAPER.scale, PAPER.size, PAPER.loss, PAPER.start) == ("none", 1, "mean", "glorot")
    assert configuration.model.widths == (64, 128, 256)
    assert [phase.name for phase in configuration.phases] == ["layer 1", "layer 2", "layer 3", "whole"]


@pytest.mark.parametrize(
    ("fields", "error", "message"),
    [
        ({"epochs": -1}, ValueError, "epochs: expected 0 or more, got -1"),
        ({"epochs": 1.5}, TypeError, "epochs: expected a whole number"),
        ({"batch": 0}, ValueError, "batch: "),
        ({"optimizer": "adamw"}, ValueError, "optimizer: expected one of adam, sgd"),
        ({"lr": 0.0}, ValueError, "lr: "),
        ({"lr_schedule": "steps"}, ValueError, "lr_schedule: "),
        ({"lr_decay": 1.1}, ValueError, "lr_decay: expected a factor of at most 1"),
        ({"clip_norm": 0.0}, ValueError, "clip_norm: "),
        ({"corruption": 1.0}, ValueError, "corruption: expected a probability below 1"),
        ({"corruption": "some"}, TypeError, "corruption: expected a number"),
        ({"rescale": 1}, TypeError, "rescale: expected true or false"),
        ({"sparsity": math.nan}, ValueError, "sparsity: expected a number of at least 0"),
        ({"unpool": "both"}, ValueError, "unpool: expected one of even, random"),
    ],
)
def test_invalid_stage(fields, error, message):
    with pytest.raises(error, match=f"^{message}"):
        Stage(**fields)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ([], r"expected an object, got \[\]"),
        ({}, "name: expected one of manifold, got None"),
        ({"name": "vgru-d"}, "name: expected one of manifold, got 'vgru-d'"),
        (
            {"name": "manifold", "colour": 1},
            "unknown field 'colour'; expected made_with, paths, plugins, name, model, .*",
        ),
        ({"name": "manifold", "model": {"cell": 1}}, "model: unknown field 'cell'; expected n_features, .*"),
        ({"name": "manifold", "layers": {"class_path": "hostile.Stage"}}, "layers: unknown field 'class_path'"),
        ({"name": "manifold", "whole": "hostile.json"}, "whole: expected an object, got 'hostile.json'"),
        ({"name": "manifold", "data": {"path": "x"}}, "data: unknown field 'path'"),
        ({"name": "manifold", "data": {"windows": "many"}}, "windows: expected int, got 'many'"),
        ({"name": "manifold", "quick": "yes"}, "quick: expected true or false"),
        ({"name": "manifold", "scale": "unit"}, "scale: "),
        ({"name": "manifold", "size": 0.0}, "size: "),
        ({"name": "manifold", "start": "zero"}, "start: "),
        ({"name": "manifold", "seed": -1}, "seed: expected an integer from 0"),
    ],
)
def test_invalid_configuration_files_are_named(tmp_path, content, message):
    file = tmp_path / "some.json"
    file.write_text(json.dumps(content), encoding="utf-8")
    with pytest.raises(ValueError, match=rf"some\.json: {message}"):
        config.read(file)


def test_layout_of_a_configuration_does_not_matter(tmp_path):
    assert check_texts(config.read, tmp_path / "some.json", '{"name": "manifold"}').name == "manifold"


# --- the command ---

LITTLE = ["--quick", "--model.widths", "[4,5]", "--whole.epochs", "1", "--layers.epochs", "0"]


@pytest.mark.parametrize("recipe", RECIPES)
def test_train_command(tmp_path, capsys, recipe):
    out = tmp_path / "run"
    train_manifold.run([*LITTLE, "--recipe", recipe, "--out", str(out)])
    printed = capsys.readouterr()
    assert printed.err == ""
    assert "training on 20 windows of 4 clips (synthetic) of 4 subjects" in printed.out
    assert "windows of synthetic/2, synthetic/3" in printed.out
    assert "body heights on windows of synthetic/0, synthetic/1" in printed.out
    assert {file.name for file in out.iterdir()} == {config.FILE, weights.FILE, CHECKPOINT, log.FILE, launch.LOCK}
    loaded = folder.load(out)
    assert loaded.configuration.data.sources == ("synthetic",)
    assert asdict(loaded.configuration)["data"]["windows"] == 20
    # Measure the printed number again.
    tested = prepare(synthetic_clips(2, 500, seed=0))
    assert {clip.subject for clip in tested.clips} <= set(held_out_subjects())
    assert f"joint error {train_manifold.error_of(loaded.projector, tested):.4f} body heights" in printed.out

    # Nothing is left to do; and other motion is refused.
    before = outcome(out)
    train_manifold.run([*LITTLE, "--out", str(out), "--resume"])
    assert same(outcome(out), before)
    other = replace(loaded.configuration, data=replace(loaded.configuration.data, digest="0"))
    config.write(out / config.FILE, other, "cpu")
    with pytest.raises(
        ValueError, match=r"^--resume: .* was trained on other windows: 20 windows of 4 clips \(synthetic\), not"
    ):
        train_manifold.run([*LITTLE, "--out", str(out), "--resume"])


def test_subjects_are_in_one_set(sets):
    clips = [
        *(f"cmu/{i:02}" for i in range(1, 15)),
        *(f"h36m/S{i}" for i in (1, 5, 6, 7, 8, 9, 11)),
        *(f"synthetic/{i}" for i in range(6)),
        *(f"bvh/{name}" for name in ("anna", "validation", "test")),
        "",
    ]
    some = sets[0]
    infos = tuple(replace(some.clips[0], name=str(i), subject=subject) for i, subject in enumerate(clips))
    features = tuple(some.features[0] for _ in clips)
    both = np.repeat(some.windows[:1], len(clips), axis=0)
    whole = MotionSet(infos, features, both, np.ones(both.shape[:2], bool), np.arange(len(clips)))
    parts = split(whole)
    subjects = [{clip.subject for clip in part.clips} for part in parts]
    assert set().union(*subjects) == set(clips)
    assert sum(map(len, subjects)) == len(clips)
    assert subjects[1] == set(validation_subjects())
    assert subjects[2] == set(held_out_subjects())
    # Without validation subjects, another subject validates; without another subject, there is an error.
    few = whole.only(subjects=["cmu/02", "cmu/05", "cmu/06"])
    assert [[clip.subject for clip in part.clips] for part in split(few)] == [
        ["cmu/05"],
        ["cmu/06"],
        ["cmu/02"],
    ]
    assert split(whole.only(subjects=["cmu/05", "cmu/06"]))[2] is None
    with pytest.raises(ValueError, match=r"^training needs two subjects, .*; the motion has cmu/02, cmu/05$"):
        split(whole.only(subjects=["cmu/02", "cmu/05"]))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--recipe", "quick"], "argument --recipe: invalid choice: 'quick'"),
        (["--depth", "4"], "argument --depth: invalid choice: 4"),
        (
            ["--layers.rate", "1"],
            "unrecognized arguments: --layers.rate 1; the options are --layers.batch, .*, --layers.unpool",
        ),
        (["--whole.lr", "-1"], "lr: expected a positive, finite number, got -1.0"),
        (["--model.widths", "[]"], "widths: expected at least one layer"),
        (["--model.kernel", "wide"], r"model\.kernel:"),
        (["--scale", "unit"], "argument --scale: invalid choice: 'unit'"),
        (["--seed", "-1"], "seed: expected an integer from 0"),
    ],
)
def test_invalid_arguments(arguments, message):
    with pytest.raises(ValueError, match=message):
        train_manifold.parse([*arguments, "--out", "nowhere"])


def test_a_run_is_not_overwritten(run):
    file = run / config.FILE
    with pytest.raises(ValueError, match=r"^--out RUN is required: the folder of the run"):
        train_manifold.parse([])
    for wrong, message in (
        ([], f"--out: {run} already holds a run; --resume continues it"),
        (["--resume", "--seed", "3"], f"--resume: {file} has another value of seed; omit the option"),
        (["--resume", "--quick"], f"--resume: {file} has another value of quick; omit the option"),
        (["--resume", "--depth", "1"], f"--resume: {file} has another value of model; omit the option"),
        (["--resume", "--depth", "3"], "--depth: expected at most 2 layers"),
        (["--resume", "--recipe", "paper"], f"--recipe: conflicts with {file}"),
    ):
        with pytest.raises(ValueError, match=f"^{message}"):
            train_manifold.parse([*wrong, "--out", str(run)])


def test_help_lists_all_options(capsys):
    with pytest.raises(SystemExit) as done:
        train_manifold.run(["--help"])
    assert done.value.code == 0
    printed = capsys.readouterr().out
    for option in ("--cmu", "--styles", "--h36m", "--recipe", "--quick", "--depth", "--model.eps", "--whole.lr"):
        assert option in printed


def test_real_motion(cmu_root, tmp_path, capsys):
    train_manifold.run([*LITTLE, "--cmu", str(cmu_root), "--out", str(tmp_path / "run")])
    printed = capsys.readouterr().out
    assert "(cmu) of 1 subjects; validating on 11 windows of cmu/08" in printed
    assert "body heights on windows of cmu/02" in printed
