"""All models: inputs and predictions, steps, and numbers of parameters."""

import argparse
import json
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch")

import npss_baselines.models  # noqa: E402
from npss.protocol import COLUMNS  # noqa: E402
from npss_baselines.commands import params  # noqa: E402
from npss_baselines.models import MODELS  # noqa: E402
from npss_baselines.models._gru import read_gru  # noqa: E402
from npss_baselines.models._lstm import LSTM  # noqa: E402
from npss_baselines.models.base import POSE  # noqa: E402
from npss_baselines.models.cells import GRUCell  # noqa: E402
from npss_baselines.models.derivatives import derivatives  # noqa: E402
from npss_baselines.models.erd import ERDConfig  # noqa: E402
from npss_baselines.models.gru_d import GRUd, GRUdConfig  # noqa: E402
from npss_baselines.models.lstm_3lr import LSTM3LRConfig  # noqa: E402
from npss_baselines.models.mbr import MBR, MBRConfig  # noqa: E402
from npss_baselines.models.recipe import REGIMES  # noqa: E402
from npss_baselines.models.srnn import ARMS, LEGS, SRNN, TORSO, SRNNConfig  # noqa: E402
from npss_baselines.models.vtln import VTLNConfig  # noqa: E402
from npss_baselines.training.objectives import loss  # noqa: E402
from oracles import sigmoid  # noqa: E402

B, S, K, A = 3, 5, 7, 2
T = S + K
SMALL = {
    VTLNConfig: {"n_units": 12, "n_guides": 2 * T, "dropout": 0.0},
    GRUdConfig: {"size": 12, "dropout": 0.0},
    MBRConfig: {"size": 12},
    ERDConfig: {"fc": 10, "size": 9, "fc_last": 8},
    LSTM3LRConfig: {"size": 9},
    SRNNConfig: {"fc": 7, "edge": 5, "node": 6, "fc_last": 8},
}
FEEDS_ITS_LABEL_BACK = "mbr-sup"  # in closed loop; `step` reads the true one
pytestmark = pytest.mark.usefixtures("one_thread")
every_model = pytest.mark.parametrize("name", MODELS)


def small(name, n_actions=A, seed=0, **fields):
    """Return a small model of the kind, in double precision and without dropout."""
    torch.manual_seed(seed)
    spec = MODELS[name]
    return spec.build(replace(spec.config, **SMALL[type(spec.config)] | fields), n_actions).double()


def windows(n_frames=T, seed=0, n=B):
    rng = np.random.default_rng(seed)
    label = torch.tensor(np.eye(A)[rng.integers(A, size=n)])
    return torch.tensor(rng.normal(size=(n, n_frames, POSE))), label


def begin(model, label, n_steps=T):
    """Return the initial state, with the same noise each time."""
    torch.manual_seed(1)
    return model.begin(label, n_steps)


def tensors(state):
    return [state] if isinstance(state, torch.Tensor) else [tensor for part in state for tensor in tensors(part)]


def rows(state, chosen):
    """Return some sequences of a batch."""
    if isinstance(state, torch.Tensor):
        return state[chosen]
    parts = [rows(part, chosen) for part in state]
    return type(state)(*parts) if hasattr(state, "_fields") else tuple(parts)


def by_steps(model, poses, state, n=0):
    """Return the predictions after each frame, and of n more steps in closed loop."""
    predictions = []
    for pose in poses.unbind(1):
        prediction, state = model.step(pose, state)
        predictions.append(prediction)
    for _ in range(n):
        prediction, state = model.step(predictions[-1], state)
        predictions.append(prediction)
    return torch.stack(predictions, 1), state


# --- behaviour of all models ----------------------------------------------------------------------------------------


@every_model
@pytest.mark.parametrize("training", [False, True])
def test_shapes(name, training):
    model = small(name).train(training)
    poses, label = windows()
    assert model.read(poses, model.begin(label, T))[0].shape == (B, T, POSE)
    assert model.step(poses[:, 0], model.begin(label, T))[0].shape == (B, POSE)
    for n in (1, K):
        assert model.predict(poses[:, :S], label, n).shape == (B, n, POSE)
    opened, closed = model.open_and_closed(poses, label, S)
    assert opened.shape == (B, T, POSE)
    assert closed.shape == (B, K, POSE)


@every_model
def test_reading_equals_steps(name):
    model = small(name).eval()
    poses, label = windows()
    at_once, state = model.read(poses, begin(model, label))
    one_by_one, expected = by_steps(model, poses, begin(model, label))
    torch.testing.assert_close(at_once, one_by_one)
    for found, true in zip(tensors(state), tensors(expected), strict=True):
        torch.testing.assert_close(found, true)
    in_parts, state = model.read(poses[:, :S], begin(model, label))
    torch.testing.assert_close(torch.cat([in_parts, model.read(poses[:, S:], state)[0]], 1), one_by_one)


@every_model
def test_no_prediction_knows_the_future(name):
    model = small(name).eval()
    poses, label = windows()
    before, _ = model.read(poses, begin(model, label))
    changed = poses.clone()
    changed[:, S] += 1
    after, _ = model.read(changed, begin(model, label))
    assert torch.equal(after[:, :S], before[:, :S])
    assert (after[:, S:] != before[:, S:]).flatten(2).any(2).all()


@every_model
def test_a_prediction_reads_the_seed_and_then_itself(name):
    model = small(name).eval()
    poses, label = windows(S)
    torch.manual_seed(1)
    predicted = model.predict(poses, label, K)
    expected, _ = by_steps(model, poses, begin(model, label, S + K - 1), K - 1)
    torch.testing.assert_close(predicted[:, 0], expected[:, S - 1])
    if name != FEEDS_ITS_LABEL_BACK:
        torch.testing.assert_close(predicted, expected[:, S - 1 :])


@pytest.mark.numeric
@every_model
@pytest.mark.parametrize("training", [False, True])
def test_open_and_closed_loop_are_those_of_steps(name, training):
    model = small(name).train(training)
    poses, label = windows()
    torch.manual_seed(1)
    opened, closed = model.open_and_closed(poses, label, S)
    torch.testing.assert_close(opened, by_steps(model, poses, begin(model, label))[0])
    expected = by_steps(model, poses[:, :S], begin(model, label), K)[0][:, S:]
    torch.testing.assert_close(closed[:, :1], expected[:, :1])
    if name != FEEDS_ITS_LABEL_BACK:
        torch.testing.assert_close(closed, expected)


@every_model
def test_a_state_has_the_batch_first(name):
    """Some sequences of a batch can continue without the others."""
    model = small(name).eval()
    poses, label = windows()
    _, state = model.read(poses[:, :S], begin(model, label))
    assert all(len(tensor) == B for tensor in tensors(state))
    torch.testing.assert_close(
        model.read(poses[1:, S:], rows(state, slice(1, None)))[0], model.read(poses[:, S:], state)[0][1:]
    )


@every_model
def test_the_same_seed_gives_the_same_prediction(name):
    def run(seed):
        model = small(name, seed=seed)
        torch.manual_seed(seed)
        poses, label = windows()
        model.open_and_closed(poses, label, S)[1].square().mean().backward()
        gradients = [parameter.grad for parameter in model.parameters() if parameter.grad is not None]
        return [*gradients, *model.state_dict().values(), model.eval().predict(poses, label, K)]

    assert all(torch.equal(first, second) for first, second in zip(run(0), run(0), strict=True))
    assert not torch.equal(run(0)[-1], run(1)[-1])


@every_model
def test_one_window_is_learnt(name):
    model = small(name)
    spec = MODELS[name]
    recipe = replace(spec.recipe, n_seed=S, n_target=K, closed_weight=((0, 1.0),), noise_std=())
    steps = torch.arange(recipe.window)[:, None] / 4 + torch.linspace(0, 6, POSE)
    poses, label = steps.sin().double()[None], windows(n=1)[1]
    optimizer = torch.optim.Adam(model.parameters(), lr=0.02)
    losses = []
    for iteration in range(60):
        optimizer.zero_grad()
        losses.append(loss(model, poses, label, recipe, iteration)["loss"])
        losses[-1].backward()
        optimizer.step()
    assert losses[-1] < losses[0] / 10


@every_model
@pytest.mark.parametrize("regime", REGIMES)
def test_every_regime_trains_every_parameter(name, regime):
    model = small(name)
    poses, label = windows(T + 1)
    recipe = replace(
        MODELS[name].recipe, regime=regime, n_seed=S, n_target=K, closed_weight=((0, 1.0),), conditioning=2
    )
    parts = loss(model, poses, label, recipe, 10**6)
    assert all(part.isfinite() for part in parts.values())
    parts["loss"].backward()
    for parameter_name, parameter in model.named_parameters():
        if not parameter.requires_grad:
            assert "bias_hh" in parameter_name  # torch's second bias, which the model does not have
            continue
        assert parameter.grad is not None, parameter_name
        assert parameter.grad.isfinite().all()
        assert (parameter.grad != 0).any(), parameter_name
        if name == "mbr-sup" and parameter_name.startswith("decoder"):
            # The predicted label matters only where it is measured or read.
            taught = (parameter.grad[POSE:] != 0).all()
            assert taught == (regime in ("sampling", "eq6"))


# --- numbers of parameters -------------------------------------------------------------------------------------------

COUNTS = {
    ("vgru-d", "code"): 3_359_798,
    ("vgru-d", "text"): 2_724_406,
    ("gru-d", "gru"): 2_721_846,
    ("mbr-unsup", "gru"): 3_370_038,
    ("mbr-long", "gru"): 3_370_038,
    ("erd", "lstm"): 14_842_054,
    ("lstm-3lr", "lstm"): 20_282_054,
    ("srnn", "lstm"): 18_285_152,
}


@pytest.fixture(scope="module")
def counted():
    return params.records()


def test_the_structure_gives_the_number_of_parameters(counted):
    found = {(record["model"], record["cell"]): record["parameters"] for record in counted}
    assert {key: found[key] for key in COUNTS} == COUNTS
    assert {record["model"] for record in counted} == set(MODELS)
    assert found["vgru-ac", "code"] == found["vgru-d", "code"]


def test_sup_has_a_label_of_fifteen_in_and_out(counted):
    (record,) = (record for record in counted if record["model"] == "mbr-sup")
    width = POSE + 15
    assert record["actions"] == 15
    assert record["parameters"] == 3 * 1024 * (width + 1024 + 1) + (1024 + 1) * width


def test_published_counts(counted):
    exact = {record["model"] for record in counted if record["parameters"] == record["published"]}
    assert exact == {"erd", "lstm-3lr"}
    assert {record["model"] for record in counted if record["published"]} == {
        "lstm-3lr",
        "erd",
        "srnn",
        "mbr-long",
        "gru-d",
        "vgru-d",
    }


def test_srnn_may_be_full_width():
    model = SRNN(SRNNConfig(full_width=True), 1)
    assert sum(parameter.numel() for parameter in model.parameters() if parameter.requires_grad) == 18_362_390


def test_gru_of_torch_would_have_more_parameters():
    layers = torch.nn.GRU(4 * POSE, 512, num_layers=2)
    n = sum(parameter.numel() for parameter in layers.parameters()) + 513 * POSE
    assert n == COUNTS["gru-d", "gru"] + 2 * 3 * 512 == 2_724_918


def command(*arguments):
    parser = argparse.ArgumentParser()
    params.add_parser(parser.add_subparsers())
    options = parser.parse_args(["params", *arguments])
    options.run(options)


def test_the_command_prints_them(capsys, counted, monkeypatch):
    monkeypatch.setattr(params, "records", lambda: counted)
    command()  # not a terminal
    assert json.loads(capsys.readouterr().out) == counted
    command("--format", "table")
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) == 2 + len(counted)
    assert lines[2].split() == ["vgru-d", "code", "1", "3,359,798", "3,413,047", "-53,249"]
    assert lines[-2].split() == ["lstm-3lr", "lstm", "1", "20,282,054", "20,282,054", "+0"]


# --- layers -----------------------------------------------------------------------------------------------------------


def test_lstm_is_the_textbook_one_with_one_bias():
    torch.manual_seed(0)
    model = LSTM(3, 4, 2).double()
    inputs = torch.randn(B, T, 3, dtype=torch.float64)
    outputs, (h_last, c_last) = model(inputs, model.begin(inputs, B))
    values = {name: value.detach().numpy() for name, value in model.layers.named_parameters()}
    read = inputs.numpy()
    for layer in range(2):
        h, c, written = np.zeros((B, 4)), np.zeros((B, 4)), []
        for t in range(T):
            sums = read[:, t] @ values[f"weight_ih_l{layer}"].T + h @ values[f"weight_hh_l{layer}"].T
            i, f, g, o = np.split(sums + values[f"bias_ih_l{layer}"], 4, axis=1)
            c = sigmoid(f) * c + sigmoid(i) * np.tanh(g)
            h = sigmoid(o) * np.tanh(c)
            written.append(h)
        read = np.stack(written, 1)
        np.testing.assert_allclose(h_last[:, layer].detach(), h)
        np.testing.assert_allclose(c_last[:, layer].detach(), c)
    np.testing.assert_allclose(outputs.detach(), read)


def test_gru_is_the_original_one():
    torch.manual_seed(0)
    cell = GRUCell(3, 4).double()
    torch.nn.init.normal_(cell.gates_bias)
    inputs, h = torch.randn(B, T, 3, dtype=torch.float64), torch.randn(B, 4, dtype=torch.float64)
    outputs, last = read_gru(cell, inputs, h)
    W, b, W_c, b_c = (v.detach().numpy() for v in (cell.gates, cell.gates_bias, cell.candidate, cell.candidate_bias))
    h = h.numpy()
    for t in range(T):
        x = inputs[:, t].numpy()
        u, r = np.split(sigmoid(np.concatenate([x, h], 1) @ W + b), 2, axis=1)
        h = u * h + (1 - u) * np.tanh(np.concatenate([x, r * h], 1) @ W_c + b_c)
        np.testing.assert_allclose(outputs[:, t].detach(), h)
    assert torch.equal(last, outputs[:, -1])


# --- MBR --------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["mbr-unsup", "mbr-sup", "mbr-long"])
def test_mbr_with_a_zero_decoder_holds_the_last_frame_or_predicts_zeros(name):
    model = small(name)
    for parameter in model.decoder.parameters():
        torch.nn.init.zeros_(parameter)
    poses, label = windows(S)
    expected = poses[:, -1:].expand(-1, K, -1) if model.residual else torch.zeros(B, K, POSE)
    assert torch.equal(model.predict(poses, label, K), expected)


@pytest.mark.parametrize("name", ["mbr-unsup", "mbr-sup", "mbr-long"])
def test_mbr_reads_the_label_only_if_supervised(name):
    model = small(name)
    poses, label = windows(S)
    same = torch.equal(model.predict(poses, label, K), model.predict(poses, 1 - label, K))
    assert same == (name != "mbr-sup")


def test_mbr_reads_the_label_that_it_predicted():
    model = small("mbr-sup")
    poses, label = windows(S)
    outputs = model.predict_labelled(poses, label, K)
    assert outputs.shape == (B, K, POSE + A)
    assert torch.equal(model.predict(poses, label, K), outputs[..., :POSE])
    _, (h, _) = model.read(poses, model.begin(label, T))
    for before, after in zip(outputs.unbind(1), outputs.unbind(1)[1:], strict=False):
        h = model.cell(before, h)
        torch.testing.assert_close(after, before + model.decoder(h))


def test_initial_parameters_of_mbr_are_those_of_the_released_code():
    model = MBR(MBRConfig(size=64), 1)
    assert (model.cell.gates_bias == 1).all()
    assert (model.cell.candidate_bias == 0).all()
    assert 0.03 < model.decoder.weight.abs().max() <= 0.04
    assert model.cell.candidate.std().item() == pytest.approx((2 / (POSE + 2 * 64)) ** 0.5, rel=0.05)


# --- GRU-d ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("order", [0, 1, 3])
def test_gru_d_is_a_stack_on_derivatives(order):
    model = small("gru-d", n_derivatives=order)
    poses, label = windows()
    hidden = derivatives(poses, order)
    for cell in model.layers:
        h, written = torch.zeros(B, 12).double(), []
        for x in hidden.unbind(1):
            h = cell(x, h)
            written.append(h)
        hidden = torch.stack(written, 1)
    torch.testing.assert_close(model.read(poses, model.begin(label, T))[0], model.decoder(hidden))


def test_gru_d_may_restart_its_derivatives_in_open_loop_alone():
    poses, label = windows()
    plain, restarted = (small("gru-d", restart_derivatives=restart) for restart in (False, True))
    (opened, closed), (opened_anew, closed_anew) = (m.open_and_closed(poses, label, S) for m in (plain, restarted))
    assert torch.equal(closed, closed_anew)
    assert torch.equal(opened[:, :S], opened_anew[:, :S])
    assert (opened[:, S:] != opened_anew[:, S:]).all(2).all()
    hidden = derivatives(poses, 3, restart=S)
    for cell in restarted.layers:
        hidden, _ = read_gru(cell, hidden, torch.zeros(B, 12).double())
    torch.testing.assert_close(opened_anew, restarted.decoder(hidden))


@pytest.mark.parametrize("restart", [False, True])
def test_gru_d_may_start_its_closed_loop_from_predictions(restart):
    poses, label = windows()
    plain, own = (small("gru-d", restart_derivatives=restart, own_past=own) for own in (False, True))
    (opened, _), (same, closed) = (model.open_and_closed(poses, label, S) for model in (plain, own))
    assert torch.equal(opened, same)
    _, (_, h) = own.read(poses[:, :S], own.begin(label, T))
    state = (opened[:, S - 4 : S - 1], h)  # as after reading its predictions
    torch.testing.assert_close(closed, own.continue_closed(opened[:, S - 1], state, K))
    predicted = own.predict(poses[:, :S], label, K + 1)
    torch.testing.assert_close(predicted, torch.cat([opened[:, S - 1 : S], closed], 1))


def test_gru_d_may_be_conditioned_with_own_past():
    """As in the released code: differences of true frames use true frames, those of outputs use outputs."""
    poses, label = windows()
    model = small("gru-d", own_past=True, n_derivatives=2)
    own = [t % 6 in (2, 3, 4) for t in range(T)]
    predictions = model.mixed(poses, label, own)
    outputs = torch.cat([torch.zeros(B, 1, POSE).double(), predictions], 1)  # the prediction of frame 0, 1 and so on
    rows = [(derivatives(outputs, 2) if own[t] else derivatives(poses, 2))[:, t] for t in range(T)]
    hidden = torch.stack(rows, 1)
    for cell in model.layers:
        hidden, _ = read_gru(cell, hidden, torch.zeros(B, 12).double())
    torch.testing.assert_close(predictions, model.decoder(hidden))
    other = small("gru-d", n_derivatives=2)
    other.load_state_dict(model.state_dict())
    as_read = other.mixed(poses, label, own)
    assert torch.equal(as_read[:, :2], predictions[:, :2])
    assert (as_read[:, 2:] != predictions[:, 2:]).all(2).all()


def test_gru_d_drops_inputs_and_outputs_in_training_only(monkeypatch):
    model = GRUd(GRUdConfig(size=12, dropout=0.5), A).double()
    poses, label = windows()

    def predictions():
        return model.read(poses, model.begin(label, T))[0]

    assert not torch.equal(predictions(), predictions())
    dropped = []
    monkeypatch.setattr(
        "npss_baselines.models.gru_d.dropout", lambda x, p, on: dropped.append((x.shape[-1], p, on)) or x
    )
    predictions()
    model.step(poses[:, 0], model.begin(label, T))
    model.eval()
    assert torch.equal(predictions(), predictions())
    assert dropped[:4] == [(4 * POSE, 0.5, True), (12, 0.5, True)] * 2
    assert dropped[4:] == [(4 * POSE, 0.5, False), (12, 0.5, False)] * 2


# --- S-RNN ------------------------------------------------------------------------------------------------------------

PARTS = {"torso": TORSO, "arms": ARMS[0] + ARMS[1], "legs": LEGS[0] + LEGS[1]}


def test_srnn_divides_the_columns_among_the_parts():
    assert sorted([*PARTS["torso"], *PARTS["arms"], *PARTS["legs"]]) == list(range(POSE))
    assert [len(part) for part in (TORSO, *ARMS, *LEGS)] == [18, 10, 10, 8, 8]
    left_arm, right_arm, left_leg, right_leg = ([COLUMNS[i] for i in part] for part in (*ARMS, *LEGS))
    assert [column + 24 for column in left_arm] == right_arm
    assert [column + 15 for column in right_leg] == left_leg


def test_srnn_part_by_part():
    model = small("srnn")
    poses, label = windows()
    body = dict(zip(("torso", "arm", "other arm", "leg", "other leg"), (TORSO, *ARMS, *LEGS), strict=True))
    x = {name: poses[..., columns] for name, columns in body.items()}

    def together(*names):
        return torch.cat([x[name] for name in names], -1)

    to_limbs = {limb: together("torso", limb) for limb in body if limb != "torso"}
    edges = {"torso": [
        (model.torso_arm, to_limbs["arm"] + to_limbs["other arm"]),
        (model.torso_leg, to_limbs["leg"] + to_limbs["other leg"]),
    ]}  # fmt: skip
    for one, two in (("arm", "other arm"), ("other arm", "arm")):
        edges[one] = [(model.torso_arm, to_limbs[one]), (model.arm_arm, together(one, two))]
    for one, two in (("leg", "other leg"), ("other leg", "leg")):
        edges[one] = [(model.torso_leg, to_limbs[one]), (model.leg_leg, together(one, two))]
    expected = torch.zeros_like(poses)
    for name, columns in body.items():
        node = {"torso": model.torso, "arm": model.arm, "leg": model.leg}[name.split()[-1]]
        messages = [edge.lstm.layers(edge.encoder(ends))[0] for edge, ends in edges[name]]
        hidden, _ = node.lstm.layers(torch.cat([node.encoder(x[name]), *messages], -1))
        expected[..., columns] = node.decoder(hidden)
    torch.testing.assert_close(model.read(poses, model.begin(label, T))[0], expected)


@pytest.mark.parametrize("full_width", [False, True])
def test_srnn_has_no_edge_between_arms_and_legs(full_width):
    model = small("srnn", full_width=full_width)
    poses, label = windows()
    before, _ = model.read(poses, model.begin(label, T))
    for changed, reached in (("torso", set(PARTS)), ("arms", {"torso", "arms"}), ("legs", {"torso", "legs"})):
        moved = poses.clone()
        moved[:, 0, PARTS[changed]] += 1
        after, _ = model.read(moved, model.begin(label, T))
        different = {part for part, columns in PARTS.items() if (after != before)[..., columns].any()}
        assert different == reached
        assert all((after != before)[..., PARTS[part]].flatten(2).any(2).all() for part in reached)


def test_srnn_shares_weights_between_left_and_right():
    model = small("srnn")
    poses, label = windows()
    mirror = torch.arange(POSE)
    for left, right in (ARMS, LEGS):
        mirror[left + right] = mirror[right + left]
    mirrored, _ = model.read(poses[..., mirror], model.begin(label, T))
    torch.testing.assert_close(mirrored, model.read(poses, model.begin(label, T))[0][..., mirror])


# --- configurations ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("config", "fields", "error"),
    [
        (LSTM3LRConfig, {"size": 0}, ValueError),
        (LSTM3LRConfig, {"n_layers": 1.0}, TypeError),
        (ERDConfig, {"fc": 0}, ValueError),
        (ERDConfig, {"fc_last": None}, TypeError),
        (SRNNConfig, {"edge": -1}, ValueError),
        (SRNNConfig, {"full_width": 54}, TypeError),
        (MBRConfig, {"size": "large"}, TypeError),
        (MBRConfig, {"residual": 1}, TypeError),
        (MBRConfig, {"label": None}, TypeError),
        (GRUdConfig, {"size": 0}, ValueError),
        (GRUdConfig, {"n_layers": 0}, ValueError),
        (GRUdConfig, {"n_derivatives": -1}, ValueError),
        (GRUdConfig, {"n_derivatives": 1.5}, TypeError),
        (GRUdConfig, {"dropout": 1.0}, ValueError),
        (GRUdConfig, {"dropout": "some"}, TypeError),
        (GRUdConfig, {"restart_derivatives": 0}, TypeError),
        (GRUdConfig, {"own_past": None}, TypeError),
    ],
)
def test_bad_fields_are_refused_by_name(config, fields, error):
    with pytest.raises(error, match=f"^{next(iter(fields))}: "):
        config(**fields)


def test_commands_without_models_need_no_torch():
    code = "import sys; from npss_baselines.commands import params; print('torch' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=True)
    assert done.stdout.strip() == "False"
    with pytest.raises(AttributeError, match="no attribute 'MODEL'"):
        _ = npss_baselines.models.MODEL


def test_models_are_named_as_they_are_registered():
    assert all(name == spec.name for name, spec in MODELS.items())
    assert {spec.regime for spec in MODELS.values()} == set(REGIMES) - {"open"}
