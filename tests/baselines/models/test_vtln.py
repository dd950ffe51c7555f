"""The VTLN-RNN: step by step and by hand-written backpropagation; its random numbers."""

import dataclasses
import itertools

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch")

from torch.autograd import gradcheck  # noqa: E402
from torch.nn import functional  # noqa: E402

from npss_baselines.models import _bptt  # noqa: E402
from npss_baselines.models.base import POSE  # noqa: E402
from npss_baselines.models.cells import CodeCell, GRUCell  # noqa: E402
from npss_baselines.models.derivatives import derivatives  # noqa: E402
from npss_baselines.models.vtln import VGRU_AC, VGRU_D, VGRU_R1, VTLN, VTLNConfig  # noqa: E402

B, T, S, A = 3, 9, 4, 2
SMALL = {"n_units": 7, "n_guides": T, "dropout": 0.0}
CELLS = ("code", "text")
#: Every field that changes what is computed, in both cells.
VARIANTS = [
    {"cell": cell, **others}
    for cell, others in itertools.product(
        CELLS,
        (
            {},
            {"dropout": 0.3},
            {"n_derivatives": 0, "residual": True},
            {"n_derivatives": 2, "derivative_step": 3, "residual": True, "dropout": 0.2},
            {"restart_derivatives": True, "noise": "text"},
            {"restart_derivatives": True, "derivative_step": 2, "dropout": 0.5},
            {"own_past": True, "dropout": 0.3},
            {"own_past": True, "n_derivatives": 2, "derivative_step": 3, "residual": True},
            {"own_past": True, "n_derivatives": 1, "derivative_step": 2, "restart_derivatives": True},
            {"top_rnn": False, "n_derivatives": 1},
            {"n_guides": T + 3},
            {"n_guides": 2},
        ),
    )
]


pytestmark = pytest.mark.usefixtures("one_thread_and_a_seed")


def make(**fields):
    return VTLN(VTLNConfig(**SMALL | fields), A).double()


@pytest.fixture
def poses():
    return torch.randn(B, T, POSE, dtype=torch.float64)


@pytest.fixture
def label():
    return torch.eye(A, dtype=torch.float64)[[0, 1, 1]]


def by_seed(call, *arguments, seed=5):
    torch.manual_seed(seed)
    return call(*arguments)


def step_by_step(model, poses, label, n_seed):
    """Call `open_and_closed` without hand-written backpropagation, which has no gradient of the poses."""
    return model.open_and_closed(poses.detach().clone().requires_grad_(), label, n_seed)


def loss_and_gradients(model, outputs):
    model.zero_grad()
    loss = sum((output.sin() * torch.linspace(-1, 2, output.numel()).view_as(output)).sum() for output in outputs)
    loss.backward()
    return [loss.detach(), *(parameter.grad.clone() for parameter in model.parameters())]


# --- sizes ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("cell", "count"), [("code", 3_359_798), ("text", 2_724_406)])
def test_number_of_parameters(cell, count):
    model = VTLN(dataclasses.replace(VGRU_D, cell=cell), 1)
    assert sum(parameter.numel() for parameter in model.parameters()) == count


def test_members_of_the_family():
    assert VTLNConfig() == VGRU_D == VGRU_AC
    r1 = VTLN(VGRU_R1, 15)
    assert (r1.n_inputs, r1.top.n_inputs, VGRU_R1.residual) == (54, 15, True)
    assert isinstance(r1.body, CodeCell)
    assert isinstance(make(cell="text").body, GRUCell)
    without = make(top_rnn=False)
    assert {name.split(".")[0] for name, _ in without.named_parameters()} == {"body", "decoder"}


def test_initial_parameters_are_those_of_the_released_code():
    model = VTLN(VTLNConfig(), 1)
    for value, bound in ((model.mu, 6 / 1024), (model.s, 6 / 1024), (model.decoder.weight, 6 / 566)):
        assert 0.95 * bound**0.5 < value.abs().max() <= bound**0.5
    assert model.decoder.bias.abs().max() <= (6 / 108) ** 0.5
    assert model.top.gates_bias.unique() == torch.tensor(0.1)


@pytest.mark.parametrize("variant", VARIANTS)
def test_shapes(variant, poses, label):
    model = make(**variant)
    opened, closed = model.open_and_closed(poses, label, S)
    assert (opened.shape, closed.shape) == ((B, T, POSE), (B, T - S, POSE))
    with torch.no_grad():
        assert model.predict(poses[:, :S], label, 6).shape == (B, 6, POSE)
        assert model.predict(poses[:, :1], label, 1).shape == (B, 1, POSE)


# --- results ----------------------------------------------------------------------------------------------------------


@pytest.mark.numeric
@pytest.mark.parametrize("variant", VARIANTS)
def test_step_by_step_and_by_hand_results_are_the_same(variant, poses, label):
    model = make(**variant)
    slow = by_seed(step_by_step, model, poses, label, S)
    fast = by_seed(model.open_and_closed, poses, label, S)
    for a, b in zip(slow, fast, strict=True):
        assert torch.allclose(a, b, rtol=0, atol=1e-12)
    for a, b in zip(loss_and_gradients(model, slow), loss_and_gradients(model, fast), strict=True):
        assert torch.allclose(a, b, rtol=1e-10, atol=1e-10)
    with torch.no_grad():
        for a, b in zip(slow, by_seed(model.open_and_closed, poses, label, S), strict=True):
            assert torch.allclose(a, b, rtol=0, atol=1e-12)


@pytest.mark.numeric
@pytest.mark.parametrize("cell", CELLS)
def test_in_single_precision_loss_and_gradients_agree(cell, label):
    n_units, n_frames = 64, 40
    model = VTLN(VTLNConfig(n_units=n_units, n_guides=n_frames, cell=cell), A)
    poses = torch.randn(B, n_frames + 1, POSE)

    def equation_6(call):
        model.zero_grad()
        opened, closed = by_seed(call, poses[:, :-1], label.float(), 15)
        loss = functional.mse_loss(opened, poses[:, 1:]) + 0.6 * functional.mse_loss(closed, poses[:, 16:])
        loss.backward()
        return torch.cat([loss.detach()[None], *(parameter.grad.flatten() for parameter in model.parameters())])

    slow, fast = equation_6(lambda *inputs: step_by_step(model, *inputs)), equation_6(model.open_and_closed)
    # A gate rounds a sum over inputs, guide and state, in as many steps of the top RNN as of the Body RNN. Independent
    # rounding errors add up as the square root of their number.
    n_terms = model.n_inputs + 2 * n_units
    tolerance = 2 * n_frames * n_terms**0.5 * torch.finfo(torch.float32).eps / 2
    assert slow[0] == pytest.approx(fast[0].item(), rel=tolerance)
    assert (slow - fast)[1:].norm() <= tolerance * slow[1:].norm()


@pytest.mark.numeric
@pytest.mark.parametrize("variant", VARIANTS)
def test_open_loop_is_the_formulas(variant, poses, label):
    model = make(**variant | {"dropout": 0.0})
    opened, _ = by_seed(model.open_and_closed, poses, label, S)
    config = model.config
    guides = torch.zeros(max(T, config.n_guides), B, 0, dtype=torch.float64)
    if config.top_rnn:
        sigma = torch.log(1 + torch.exp(model.s))
        h = model.mu + (sigma if config.noise == "text" else sigma**0.5) * by_seed(
            torch.randn_like, guides.new_ones(B, 7)
        )
        states = []
        for _ in guides:
            h = model.top(label, h)
            states.append(h)
        guides = torch.stack(states).flip(0)  # the last state guides the first step
    restart = S if config.restart_derivatives else None
    x = derivatives(poses, config.n_derivatives, step=config.derivative_step, restart=restart)
    h = torch.zeros(B, 7, dtype=torch.float64)
    for t in range(T):
        h = model.body(x[:, t], h, guides[t])
        expected = h @ model.decoder.weight.T + model.decoder.bias + (poses[:, t] if config.residual else 0)
        assert torch.allclose(opened[:, t], expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("variant", VARIANTS)
def test_closed_loop_is_feeding_back_by_hand(variant, poses, label):
    model = make(**variant).eval()
    _, closed = by_seed(model.open_and_closed, poses, label, S)
    state, outputs = by_seed(model.begin, label, T), []
    for pose in poses[:, :S].unbind(1):
        pose, state = model.step(pose, state)
        outputs.append(pose)
    state = model.switch(torch.stack(outputs, 1), state)
    for expected in closed.unbind(1):
        pose, state = model.step(pose, state)
        assert torch.allclose(pose, expected, rtol=0, atol=1e-12)


def test_prediction_is_the_same_from_a_seed_alone(poses, label):
    model = make().eval()
    opened, closed = by_seed(model.open_and_closed, poses, label, S)
    predicted = by_seed(model.predict, poses[:, :S], label, T - S + 1)
    assert torch.allclose(predicted, torch.cat([opened[:, S - 1 : S], closed], 1), rtol=0, atol=1e-12)
    # One frame less needs one step less, but the number of guides is the same.
    assert torch.allclose(by_seed(model.predict, poses[:, :S], label, T - S), predicted[:, :-1], rtol=0, atol=1e-12)


def test_reading_equals_steps(poses, label):
    model = make().eval()
    read, end = model.read(poses, by_seed(model.begin, label, T))
    state = by_seed(model.begin, label, T)
    for t in range(T):
        prediction, state = model.step(poses[:, t], state)
        assert torch.equal(prediction, read[:, t])
    assert all(torch.equal(a, b) for a, b in zip(end, state, strict=True))


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("k", [1, S, T - 1])
def test_a_later_frame_changes_no_earlier_prediction(variant, k, poses, label):
    model = make(**variant)
    other = poses.clone()
    other[:, k] += 1
    (opened, closed), (changed, closed_too) = (by_seed(model.open_and_closed, x, label, S) for x in (poses, other))
    assert torch.allclose(opened[:, :k], changed[:, :k], rtol=0, atol=1e-13)
    assert (opened[:, k:] - changed[:, k:]).abs().amax((0, 2)).min() > 1e-9
    assert torch.allclose(closed, closed_too, rtol=0, atol=1e-13) == (k >= S)


@pytest.mark.parametrize("cell", CELLS)
def test_restarted_derivatives_matter_in_open_loop_only(cell, poses, label):
    model = make(cell=cell)
    plain = by_seed(model.open_and_closed, poses, label, S)
    model.config = dataclasses.replace(model.config, restart_derivatives=True)
    opened, closed = by_seed(model.open_and_closed, poses, label, S)
    assert torch.equal(plain[0][:, :S], opened[:, :S])
    assert torch.equal(plain[1], closed)
    assert (plain[0][:, S:] - opened[:, S:]).abs().amax((0, 2)).min() > 1e-6


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("step", [1, 2])
def test_an_own_past_is_that_of_the_predictions_of_frames_that_were_read(cell, step, poses, label):
    """As in the released code: the closed loop's first input has the differences of the last outputs of the seed."""
    model = make(cell=cell, own_past=True, derivative_step=step, n_derivatives=2).eval()
    opened, closed = by_seed(model.open_and_closed, poses, label, S)
    state = by_seed(model.begin, label, T)
    seed, state = model.read(poses[:, :S], state)
    o, h = torch.cat([torch.zeros_like(seed), seed, closed], 1), state.h
    for t in range(T - S):
        now, one, two = (o[:, 2 * S - 1 + t - k * step] for k in range(3))
        h = model.body(torch.cat([now, now - one, now - 2 * one + two], 1), h, state.guides[:, t])
        assert torch.allclose(model.decoder(h), closed[:, t], rtol=0, atol=1e-12)
    predicted = by_seed(model.predict, poses[:, :S], label, T - S + 1)
    assert torch.allclose(predicted, torch.cat([opened[:, S - 1 : S], closed], 1), rtol=0, atol=1e-12)
    model.config = dataclasses.replace(model.config, own_past=False)
    others = by_seed(model.open_and_closed, poses, label, S)
    assert torch.equal(others[0], opened)
    assert (others[1] - closed).abs().amax((0, 2)).min() > 1e-6


@pytest.mark.parametrize("variant", VARIANTS)
@pytest.mark.parametrize("own", [(2, 3, 6), (1, 2, 3, 4, 5, 6, 7, 8), (8,), ()])
def test_mixed_reads_frames_and_predictions(variant, own, poses, label):
    model = make(**variant)
    flags = [t in own for t in range(T)]
    fast = by_seed(model.mixed, poses, label, flags)
    state, rows = by_seed(model.begin, label, T), []
    for t in range(T):
        if t in own and t - 1 not in own:
            state = model.switch(torch.stack(rows, 1), state)
        elif t and t not in own and t - 1 in own:
            state = model.switch_back(poses[:, :t], state)
        prediction, state = model.step(rows[-1] if t in own else poses[:, t], state)
        rows.append(prediction)
    assert torch.allclose(torch.stack(rows, 1), fast, rtol=0, atol=1e-12)
    gradients = [loss_and_gradients(model, [rows]) for rows in (torch.stack(rows, 1), fast)]
    for a, b in zip(*gradients, strict=True):
        assert torch.allclose(a, b, rtol=1e-10, atol=1e-10)
    with torch.no_grad():
        assert torch.allclose(by_seed(model.mixed, poses, label, flags), fast, rtol=0, atol=1e-12)


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("step", [1, 2])
@pytest.mark.parametrize("own", [(2, 3, 6), (1, 5, 6), (4, 5, 6, 7, 8)])
def test_conditioned_with_own_past_frames_and_predictions_are_separate(cell, step, own, poses, label):
    """As in the released code: differences of true frames use true frames, those of outputs use outputs."""
    model = make(cell=cell, own_past=True, derivative_step=step, n_derivatives=2)
    predictions = by_seed(model.mixed, poses, label, [t in own for t in range(T)])
    o = torch.cat([torch.zeros(B, 1, POSE).double(), predictions], 1)  # the prediction of frame 0, 1 and so on
    apart = {True: derivatives(o, 2, step=step), False: derivatives(poses, 2, step=step)}
    state = by_seed(model.begin, label, T)
    h = state.h
    for t in range(T):
        h = model.body(apart[t in own][:, t], h, state.guides[:, t])
        torch.testing.assert_close(model.decoder(h), predictions[:, t], rtol=0, atol=1e-12)
    model.config = dataclasses.replace(model.config, own_past=False)
    as_read = by_seed(model.mixed, poses, label, [t in own for t in range(T)])
    assert torch.equal(as_read[:, : own[0]], predictions[:, : own[0]])
    assert (as_read[:, -1] - predictions[:, -1]).abs().max() > 1e-6


# --- gradients --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("variant", VARIANTS)
def test_gradients_are_the_finite_differences(variant, poses, label):
    model = make(**variant)
    weights = torch.randn(2, B, T, POSE, dtype=torch.float64)

    def loss():
        opened, closed = by_seed(model.open_and_closed, poses, label, S)
        return (weights[0] * opened).sum() + (weights[1, :, S:] * closed).sum()

    loss().backward()
    size = 1e-5
    for name, parameter in model.named_parameters():
        direction = functional.normalize(torch.randn_like(parameter), dim=None)
        sides = []
        with torch.no_grad():
            for step in (size, -size):
                parameter += step * direction
                sides.append(loss().item())
                parameter -= step * direction
        slope = (sides[0] - sides[1]) / (2 * size)
        assert slope == pytest.approx((parameter.grad * direction).sum().item(), rel=1e-6, abs=1e-6), name


@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("beside", [False, True])
@pytest.mark.parametrize("dropout", [False, True])
def test_every_entry_of_the_hand_written_jacobian(cell, beside, dropout):
    H, P, order, n_frames = 3, 2, 2, 5
    D = (order + 1) * P
    body = (CodeCell(D, H, H) if cell == "code" else GRUCell(D + H, H)).double()
    decoder = torch.nn.Linear(H, P).double()
    own = (False, True, False, True, True)
    loop = _bptt.Loop(2, own, beside, order, 1, residual=True)
    features = derivatives(torch.randn(2, n_frames, P, dtype=torch.float64), order).transpose(0, 1)
    guides = torch.randn(n_frames, 2, H, dtype=torch.float64, requires_grad=True)
    factors = torch.rand(2 * loop.n_visits, D + H, dtype=torch.float64) if dropout else None

    def call(guides, *parameters):
        return _bptt.predictions(features, guides, body.blocks(H), decoder, factors, loop)

    assert gradcheck(call, (guides, *body.parameters(), *decoder.parameters()), fast_mode=False)


def test_a_graph_can_be_reused(poses, label):
    model = make()
    outputs = model.open_and_closed(poses, label, S)
    loss = outputs[0].square().sum() + outputs[1].sum()
    once = torch.autograd.grad(loss, list(model.parameters()), retain_graph=True)
    model.open_and_closed(poses[:2], label[:2], S)
    again = torch.autograd.grad(loss, list(model.parameters()))
    assert all(torch.equal(a, b) for a, b in zip(once, again, strict=True))


def test_two_graphs_at_once(poses, label):
    model = make(dropout=0.3)
    pair = [by_seed(model.open_and_closed, poses, label, S, seed=seed) for seed in (1, 2)]
    together = [loss_and_gradients(model, outputs) for outputs in pair]
    for seed, gradients in zip((1, 2), together, strict=True):
        alone = loss_and_gradients(model, by_seed(model.open_and_closed, poses, label, S, seed=seed))
        assert all(torch.equal(a, b) for a, b in zip(alone, gradients, strict=True))


# --- randomness -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("cell", CELLS)
def test_noise_is_drawn_for_each_sequence_and_each_time_and_after_training_too(cell):
    model = make(cell=cell).eval()
    poses, label = torch.zeros(4, S, POSE, dtype=torch.float64), torch.eye(A, dtype=torch.float64)[[0, 0, 0, 0]]
    with torch.no_grad():
        first, second = model.predict(poses, label, 3), model.predict(poses, label, 3)
        assert torch.equal(by_seed(model.predict, poses, label, 3), by_seed(model.predict, poses, label, 3))
    rows = torch.cat([first, second]).flatten(1)
    assert torch.pdist(rows).min() > 1e-6
    without = make(cell=cell, top_rnn=False).eval()
    with torch.no_grad():
        assert torch.allclose(
            without.predict(poses, label, 3), without.predict(poses[:1], label[1:2], 3), rtol=0, atol=1e-12
        )


@pytest.mark.parametrize(("noise", "sigma"), [("code", 4**0.5), ("text", 4.0)])
def test_noise_has_the_scale_that_is_learned(noise, sigma):
    model = make(noise=noise, n_guides=3)
    with torch.no_grad():
        model.s[:] = np.log(np.expm1(4))  # softplus(s) = 4
        model.mu[:] = torch.arange(7)
        model.top.gates_bias[:7] = 100  # the top RNN keeps its state
        guides = model.begin(torch.ones(4000, A, dtype=torch.float64), 3).guides
    assert guides.shape == (4000, 3, 7)
    assert torch.equal(guides[:, 0], guides[:, 2])
    assert torch.allclose(guides[:, 0].mean(0), model.mu, rtol=0, atol=0.25)
    assert torch.allclose(guides[:, 0].std(0), torch.full((7,), sigma, dtype=torch.float64), rtol=0.05, atol=0)
    assert (torch.corrcoef(guides[:, 0].T) - torch.eye(7)).abs().max() < 0.06


def test_actions_have_different_predictions(poses):
    model = make().eval()
    one, other = torch.eye(A, dtype=torch.float64)
    with torch.no_grad():
        a, b = (by_seed(model.predict, poses, label.expand(B, A), 3) for label in (one, other))
    assert not torch.allclose(a, b, rtol=0, atol=1e-4)


def test_guides_are_planned_for_longer_windows_too(label):
    model = make(n_guides=5)
    assert [model.begin(label, n).guides.shape[1] for n in (3, 5, 8)] == [5, 5, 8]
    short, long = (by_seed(model.begin, label, n).guides for n in (3, 8))
    assert torch.allclose(long[:, 3:], short, rtol=0, atol=1e-12)  # the last guide is the first state


def test_dropout_is_for_training_only(poses, label):
    model, without = make(dropout=0.5), make(dropout=0.0)
    without.load_state_dict(model.state_dict())
    outputs = {
        (name, mode): torch.cat(by_seed(net.train(mode).open_and_closed, poses, label, S), 1)
        for name, net in (("with", model), ("without", without))
        for mode in (True, False)
    }
    assert torch.equal(outputs["with", False], outputs["without", False])
    assert torch.equal(outputs["without", True], outputs["without", False])
    assert not torch.allclose(outputs["with", True], outputs["with", False], rtol=0, atol=1e-2)


def test_dropout_is_of_the_inputs_of_body_rnn_and_decoder(poses, label):
    model = make(dropout=1 - 2**-16, residual=True)
    start = model.begin(label, T)
    prediction, state = model.step(poses[:, 0], start)
    zeros = torch.zeros(B, model.n_inputs, dtype=torch.float64)
    assert torch.allclose(
        prediction, model.decoder.bias + poses[:, 0], rtol=0, atol=1e-12
    )  # the residual has no dropout
    assert torch.allclose(
        state.h, model.body(zeros, start.h, start.guides[:, 0]), rtol=0, atol=1e-12
    )  # nor has the state


def test_dropout_factors():
    model = make(dropout=0.3)
    factors = model._dropout(20, 50)
    assert factors.shape == (1000, model.n_inputs + 7)
    assert torch.allclose(factors.unique(), torch.tensor([0, 1 / 0.7], dtype=torch.float64), rtol=0, atol=1e-15)
    n = factors.numel()
    assert (factors > 0).sum().item() == pytest.approx(0.7 * n, abs=4 * (0.21 * n) ** 0.5)
    kept = (factors > 0).double() - 0.7
    for a, b in ((kept[1:], kept[:-1]), (kept[:, 1:], kept[:, :-1]), (kept[20:], kept[:-20])):  # neighbours, steps
        assert abs((a * b).mean().item()) < 4 * 0.21 / n**0.5
    whole = by_seed(model._dropout, 20, 6)
    parts = by_seed(lambda: [model._dropout(20) for _ in range(6)])
    assert torch.equal(whole, torch.cat(parts))


# --- errors -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("field", "value", "error"),
    [
        ("n_units", 0, ValueError),
        ("n_units", 1.5, TypeError),
        ("n_guides", -1, ValueError),
        ("derivative_step", 0, ValueError),
        ("cell", "lstm", ValueError),
        ("cell", None, TypeError),
        ("noise", "Text", ValueError),
        ("n_derivatives", 4, ValueError),
        ("n_derivatives", -1, ValueError),
        ("n_derivatives", True, ValueError),
        ("dropout", 1, ValueError),
        ("dropout", -0.1, ValueError),
        ("dropout", "0.3", ValueError),
        ("top_rnn", 1, TypeError),
        ("residual", None, TypeError),
        ("restart_derivatives", "no", TypeError),
        ("own_past", 1, TypeError),
    ],
)
def test_bad_fields_are_refused_by_name(field, value, error):
    with pytest.raises(error, match=f"^{field}: "):
        VTLNConfig(**{field: value})


def test_bad_calls_are_refused(poses, label):
    model = make(n_guides=2)
    for n_seed in (0, T):
        with pytest.raises(ValueError, match=r"^n_seed: expected 1 to 8 of 9 frames"):
            model.open_and_closed(poses, label, n_seed)
    with pytest.raises(ValueError, match=r"^label: expected shape \(B, 2\), got \(3, 3\)"):
        model.begin(torch.ones(B, 3, dtype=torch.float64), T)
    for own in ([True] + [False] * (T - 1), [False] * (T - 1)):
        with pytest.raises(ValueError, match=r"^own: expected 9 flags, the first of them False"):
            model.mixed(poses, label, own)
    state = model.begin(label, 2)
    for _ in range(2):
        _, state = model.step(poses[:, 0], state)
    with pytest.raises(ValueError, match=r"^n_steps: "):
        model.step(poses[:, 0], state)
