"""Recipes and their schedules; losses compared with a computation frame by frame."""

import dataclasses
import json

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch")

import npss.torch  # noqa: E402
from npss_baselines.models import MODELS  # noqa: E402
from npss_baselines.models.base import POSE, MotionModel  # noqa: E402
from npss_baselines.models.mbr import MBR, MBRConfig  # noqa: E402
from npss_baselines.models.recipe import REGIMES, Recipe  # noqa: E402
from npss_baselines.training.objectives import Statistics, conditioned, loss, noisy  # noqa: E402

S, K, B = 4, 6, 3
pytestmark = pytest.mark.usefixtures("one_thread")
EQ6 = ((0, 0.5),)


class Leaky(MotionModel):
    """A model that is simple enough to compute by hand: a leaky sum of its inputs, plus its label."""

    def __init__(self, n_actions=2):
        super().__init__(n_actions)
        self.leak = torch.nn.Parameter(torch.tensor(0.6, dtype=torch.float64))
        self.gain = torch.nn.Parameter(torch.full((POSE,), 0.3, dtype=torch.float64))

    def begin(self, label, n_steps):
        return label.new_zeros(len(label), POSE), label.sum(1, keepdim=True)

    def step(self, pose, state):
        memory = self.leak * state[0] + pose
        return self.gain * memory + 0.1 * state[1], (memory, state[1])


def follow(model, poses, label, own):
    """Return the predictions of Leaky step by step; at the steps of `own`, it reads its last prediction."""
    leak, gain = model.leak.item(), model.gain.detach().numpy()
    memory, predictions = np.zeros_like(poses[:, 0]), []
    for t in range(poses.shape[1]):
        memory = leak * memory + (predictions[-1] if t in own else poses[:, t])
        predictions.append(gain * memory + 0.1 * label.sum(1, keepdims=True))
    return np.stack(predictions, 1)


def windows(seed=0):
    rng = np.random.default_rng(seed)
    return rng.normal(size=(B, S + K + 1, POSE)), np.eye(2)[rng.integers(2, size=B)]


def recipe(regime, **fields):
    return Recipe(regime=regime, n_seed=S, n_target=K, **fields)


def measure(model, poses, label, chosen, iteration=0, **kwargs):
    parts = loss(model, torch.tensor(poses), torch.tensor(label), chosen, iteration, **kwargs)
    return {name: value.item() for name, value in parts.items()}


# --- the regimes ------------------------------------------------------------------------------------------------------


@pytest.mark.numeric
def test_equation_6():
    poses, label = windows()
    model = Leaky()
    opened = follow(model, poses[:, :-1], label, own=())
    closed = follow(model, poses[:, :-1], label, own=range(S, S + K))[:, S:]
    of_open = np.mean((opened - poses[:, 1:]) ** 2)
    of_closed = np.mean((closed - poses[:, S + 1 :]) ** 2)
    chosen = recipe("eq6", closed_weight=((10, 0.25), (20, 1.0)))
    for iteration, weight in ((0, 0), (9, 0), (10, 0.25), (19, 0.25), (20, 1), (10**6, 1)):
        parts = measure(model, poses, label, chosen, iteration)
        assert parts == pytest.approx({"loss": of_open + weight * of_closed, "open": of_open, "closed": of_closed})


@pytest.mark.numeric
def test_open_loop():
    poses, label = windows()
    expected = np.mean((follow(Leaky(), poses[:, :-1], label, own=()) - poses[:, 1:]) ** 2)
    assert measure(Leaky(), poses, label, recipe("open")) == pytest.approx({"loss": expected, "open": expected})


def test_sampling_is_of_the_frames_after_the_seed_alone():
    """Step S - 1 reads the last seed frame and predicts the first target; the last frame is unused."""
    poses, label = windows()
    outputs = follow(Leaky(), poses[:, : S + K - 1], label, own=range(S, S + K - 1))[:, S - 1 :]
    expected = np.mean((outputs - poses[:, S : S + K]) ** 2)
    assert measure(Leaky(), poses, label, recipe("sampling")) == pytest.approx({"loss": expected, "closed": expected})
    poses[:, -1] = 1e6
    assert measure(Leaky(), poses, label, recipe("sampling"))["loss"] == pytest.approx(expected)


@pytest.mark.numeric
@pytest.mark.parametrize("length", [1, 2, 4, 6, 7])
def test_auto_conditioning_reads_true_frames_and_outputs_in_turn(length):
    poses, label = windows()
    own = [t for t in range(S, S + K) if (t - S) // length % 2 == 1]
    outputs = follow(Leaky(), poses[:, :-1], label, own)
    expected = np.mean((outputs - poses[:, 1:]) ** 2)
    parts = measure(Leaky(), poses, label, recipe("auto-conditioning", conditioning=length))
    assert parts == pytest.approx({"loss": expected, "conditioned": expected})
    with torch.no_grad():
        found = conditioned(Leaky(), torch.tensor(poses[:, :-1]), torch.tensor(label), S, length)
    np.testing.assert_allclose(found.numpy(), outputs)


@pytest.mark.numeric
def test_noise_is_in_half_of_the_input_frames_and_in_no_target():
    poses, label = windows()
    chosen = recipe("noise", noise_std=((100, 0.5),))
    assert measure(Leaky(), poses, label, chosen, 99) == measure(Leaky(), poses, label, recipe("open"))
    torch.manual_seed(3)
    parts = measure(Leaky(), poses, label, chosen, 100)
    torch.manual_seed(3)
    read = noisy(torch.tensor(poses[:, :-1]), 0.5).numpy()
    expected = np.mean((follow(Leaky(), read, label, own=()) - poses[:, 1:]) ** 2)
    assert parts == pytest.approx({"loss": expected, "open": expected})
    torch.manual_seed(4)
    assert measure(Leaky(), poses, label, chosen, 100) != parts


@pytest.mark.numeric
def test_noise_has_the_right_share_and_standard_deviation():
    torch.manual_seed(0)
    poses = torch.zeros(50, 40, POSE, dtype=torch.float64)
    noise = noisy(poses, 0.3)
    chosen = noise.abs().sum(-1) > 0  # all columns of a frame, or none
    assert torch.equal(chosen, (noise != 0).all(-1))
    assert chosen.double().mean().item() == pytest.approx(0.5, abs=0.04)
    assert noise[chosen].std().item() == pytest.approx(0.3, rel=0.02)
    assert noise[chosen].mean().item() == pytest.approx(0, abs=0.01)
    assert noisy(poses, 0.0) is poses


@pytest.mark.numeric
def test_the_label_that_mbr_predicts_is_measured():
    torch.manual_seed(0)
    poses, label = (torch.tensor(array, dtype=torch.float32) for array in windows())
    model = MBR(MBRConfig(size=5, label=True), n_actions=2)
    hidden = torch.zeros(B, 5)
    outputs = []
    for t in range(S + K - 1):
        frame = torch.cat([poses[:, t], label], 1) if t < S else outputs[-1]
        hidden = model.cell(frame, hidden)
        outputs.append(frame + model.decoder(hidden))
    truth = torch.cat([poses[:, S : S + K], label[:, None].expand(-1, K, -1)], 2)
    expected = ((torch.stack(outputs[S - 1 :], 1) - truth) ** 2).mean()
    assert loss(model, poses, label, recipe("sampling"), 0)["loss"].item() == pytest.approx(expected.item(), rel=1e-5)


# --- NPSS -------------------------------------------------------------------------------------------------------------

OWN_INPUTS = {
    "eq6": range(S, S + K),
    "open": (),
    "noise": (),
    "auto-conditioning": [t for t in range(S, S + K) if (t - S) // 5 % 2 == 1],
}


@pytest.mark.numeric
@pytest.mark.parametrize("convention", ["paper", "released"])
@pytest.mark.parametrize("regime", REGIMES)
def test_npss_is_of_the_joints_in_radians_after_the_seed(regime, convention):
    poses, label = windows()
    mean, std = np.linspace(-1, 1, POSE), np.linspace(0.5, 2, POSE)
    if regime == "sampling":
        future = follow(Leaky(), poses[:, : S + K - 1], label, range(S, S + K))[:, S - 1 :]
        truth = poses[:, S : S + K]
    else:
        future, truth = follow(Leaky(), poses[:, :-1], label, OWN_INPUTS[regime])[:, S:], poses[:, S + 1 :]
    expected = npss.score((truth * std + mean)[..., 6:], (future * std + mean)[..., 6:], convention=convention)
    statistics = Statistics(torch.tensor(mean), torch.tensor(std))
    plain = recipe(regime, closed_weight=EQ6)
    weighted = dataclasses.replace(plain, npss_weight=0.7, npss_convention=convention)
    before = measure(Leaky(), poses, label, plain)
    parts = measure(Leaky(), poses, label, weighted, statistics=statistics)
    assert parts.pop("npss") == pytest.approx(expected)
    assert parts.pop("loss") == pytest.approx(before.pop("loss") + 0.7 * expected)
    assert parts == pytest.approx(before)


@pytest.mark.numeric
def test_npss_has_a_gradient_for_every_parameter():
    poses, label = (torch.tensor(array) for array in windows())
    statistics = Statistics(torch.zeros(POSE).double(), torch.ones(POSE).double())
    model = Leaky()
    parts = loss(model, poses, label, recipe("eq6", npss_weight=1.0), 0, statistics=statistics)
    (gradient,) = torch.autograd.grad(parts["npss"], model.leak)
    assert gradient.isfinite()
    assert gradient != 0


def test_npss_needs_statistics():
    poses, label = windows()
    with pytest.raises(ValueError, match="statistics: "):
        measure(Leaky(), poses, label, recipe("eq6", npss_weight=0.1))


@pytest.mark.parametrize(
    ("poses", "label", "message"),
    [
        ((B, S + K, POSE), (B, 2), "poses: expected shape \\(B, 11, 54\\)"),
        ((B, S + K + 1, 99), (B, 2), "poses: "),
        ((S + K + 1, POSE), (B, 2), "poses: "),
        ((B, S + K + 1, POSE), (B, 3), "label: expected shape \\(3, 2\\)"),
        ((B, S + K + 1, POSE), (B,), "label: "),
    ],
)
def test_wrong_shapes_are_refused(poses, label, message):
    with pytest.raises(ValueError, match=message):
        measure(Leaky(), np.zeros(poses), np.zeros(label), recipe("open"))


# --- recipes ----------------------------------------------------------------------------------------------------------


def test_the_schedules_of_the_paper():
    long = MODELS["vgru-d"].recipe
    for start, value in ((500, 0.2), (1000, 0.4), (2000, 0.6), (4000, 0.8), (7000, 1.0)):
        assert long.lambda_at(start) == value
        assert long.lambda_at(start - 1) == pytest.approx(value - 0.2)
    for k in range(5):
        assert long.learning_rate(2000 * k) == pytest.approx(2e-4 * 0.6**k)
        assert long.learning_rate(2000 * k + 1999) == pytest.approx(2e-4 * 0.6**k)
    short = MODELS["vgru-r1"].recipe
    assert short.learning_rate(4999) == 1e-4
    assert short.learning_rate(5000) == pytest.approx(8e-5)
    assert short.learning_rate(59_999) == pytest.approx(1e-4 * 0.8**11)
    assert short.learning_rate(60_000) == short.learning_rate(99_999) == pytest.approx(1e-4 * 0.8**12)
    noise = MODELS["srnn"].recipe
    assert [noise.noise_at(i) for i in (249, 250, 499, 500, 1000, 1300, 2000, 2500, 3299, 3300, 5000)] == [
        0, 0.01, 0.01, 0.05, 0.1, 0.2, 0.3, 0.5, 0.5, 0.7, 0.7,
    ]  # fmt: skip
    assert [noise.learning_rate(i) for i in (1499, 1500, 4499, 4500)] == pytest.approx([1e-3, 1e-4, 1e-4, 1e-5])
    assert MODELS["mbr-long"].recipe.learning_rate(20_000) == pytest.approx(0.005 * 0.95**2)


@pytest.mark.parametrize("name", MODELS)
@pytest.mark.parametrize("n", [1, 37, 500, 20_000])
def test_a_compressed_recipe_has_the_same_values_at_the_same_share(name, n):
    whole = MODELS[name].recipe
    short = whole.compressed(n)
    assert short.iterations == n
    starts = {
        "learning_rate": whole.lr_milestones,
        "lambda_at": [start for start, _ in whole.closed_weight],
        "noise_at": [start for start, _ in whole.noise_std],
    }
    for share in np.linspace(0, 0.999, 200):
        early, late = share * n, share * whole.iterations
        for schedule, steps in starts.items():
            # Steps are rounded to whole iterations: compare only where no step is within one iteration.
            if all(abs(step * n / whole.iterations - early) > 1 for step in steps):
                assert getattr(short, schedule)(int(early)) == pytest.approx(getattr(whole, schedule)(int(late)))
    rest = ("iterations", "lr_milestones", "closed_weight", "noise_std")
    assert all(
        getattr(short, field.name) == getattr(whole, field.name)
        for field in dataclasses.fields(Recipe)
        if field.name not in rest
    )


def test_a_cosine_falls_from_the_rate_to_zero():
    chosen = Recipe(lr=1e-3, lr_schedule="cosine", iterations=500)
    assert [chosen.learning_rate(i) for i in (0, 125, 250, 500)] == pytest.approx(
        [1e-3, 1e-3 * (2 + 2**0.5) / 4, 5e-4, 0], abs=1e-12
    )
    assert chosen.compressed(50).learning_rate(25) == pytest.approx(5e-4)


def test_a_recipe_survives_json():
    for spec in MODELS.values():
        assert Recipe(**json.loads(json.dumps(dataclasses.asdict(spec.recipe)))) == spec.recipe


def test_a_window_has_a_target_for_every_step():
    assert Recipe(n_seed=50, n_target=100).window == 151


@pytest.mark.parametrize(
    ("fields", "error"),
    [
        ({"regime": "closed"}, ValueError),
        ({"regime": None}, TypeError),
        ({"optimizer": "adamw"}, ValueError),
        ({"lr_schedule": "linear"}, ValueError),
        ({"iterations": 0}, ValueError),
        ({"batch": 2.0}, TypeError),
        ({"n_seed": -1}, ValueError),
        ({"n_target": True}, TypeError),
        ({"conditioning": 0}, ValueError),
        ({"lr": 0}, ValueError),
        ({"lr": float("inf")}, ValueError),
        ({"lr_decay": 1.5}, ValueError),
        ({"lr_decay": 0}, ValueError),
        ({"lr_milestones": (5, 3)}, ValueError),
        ({"lr_milestones": (-1,)}, ValueError),
        ({"lr_milestones": (0.5,)}, TypeError),
        ({"lr_milestones": 5}, TypeError),
        ({"momentum": 1}, ValueError),
        ({"momentum": -0.1}, ValueError),
        ({"momentum": "0.9"}, TypeError),
        ({"clip_norm": 0}, ValueError),
        ({"closed_weight": ((1, 2, 3),)}, ValueError),
        ({"closed_weight": ((5, 0.1), (4, 0.2))}, ValueError),
        ({"closed_weight": ((5, -0.1),)}, ValueError),
        ({"closed_weight": (5, 0.1)}, TypeError),
        ({"noise_std": ((5, float("nan")),)}, ValueError),
        ({"noise_std": ((5.5, 0.1),)}, TypeError),
        ({"npss_weight": -1}, ValueError),
        ({"npss_weight": 0.1, "n_target": 1}, ValueError),
        ({"npss_convention": "mine"}, ValueError),
    ],
    ids=str,
)
def test_bad_fields_are_refused_by_name(fields, error):
    with pytest.raises(error, match=f"^{next(iter(fields))}"):
        Recipe(**fields)


def test_clipping_is_optional():
    assert Recipe(clip_norm=None).clip_norm is None


def test_a_recipe_is_compressed_to_some_iterations_at_least():
    with pytest.raises(ValueError, match="iterations: "):
        Recipe().compressed(0)
