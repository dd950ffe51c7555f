"""Motion derivatives and recurrent cells, compared with their definitions in numpy and with torch's."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

torch = pytest.importorskip("torch", reason="needs torch")

from npss_baselines.models.cells import CodeCell, GRUCell  # noqa: E402
from npss_baselines.models.derivatives import derivatives, next_derivatives, no_past, own_past, past_of  # noqa: E402
from oracles import sigmoid  # noqa: E402

pytestmark = [pytest.mark.numeric, pytest.mark.usefixtures("one_thread_and_a_seed")]

B, D, P, H = 3, 5, 4, 6
BODY = {"code": lambda: CodeCell(D, P, H), "text": lambda: GRUCell(D + P, H)}


def draw(*shape):
    return torch.randn(*shape, dtype=torch.float64)


# --- derivatives ------------------------------------------------------------------------------------------------------


def by_equation_5(frames, n, h, t):
    """Return difference n of frame t of frames (T, D), which zeros precede."""
    terms = ((-1) ** i * math.comb(n, i) * frames[t - i * h] for i in range(n + 1) if t >= i * h)
    return sum(terms, np.zeros(frames.shape[1]))


windows = st.tuples(*(st.integers(1, n) for n in (3, 12, 4)), st.integers(0, 4), st.integers(1, 3))


@given(shape=windows)
def test_differences_are_those_of_equation_5(shape):
    *shape, order, h = shape
    poses = np.random.default_rng(sum(shape)).normal(size=shape)
    rows = derivatives(torch.tensor(poses), order, step=h).numpy()
    assert rows.shape == (*shape[:2], (order + 1) * shape[2])
    expected = [
        [np.concatenate([by_equation_5(frames, n, h, t) for n in range(order + 1)]) for t in range(shape[1])]
        for frames in poses
    ]
    np.testing.assert_allclose(rows, expected, rtol=0, atol=1e-13)


def test_all_differences_of_the_first_frame_are_the_frame():
    poses = draw(B, 4, D)
    assert torch.equal(derivatives(poses, 3)[:, 0], poses[:, 0].repeat(1, 4))


@given(shape=windows, cut=st.integers(0, 12))
def test_frame_by_frame_and_in_two_parts_differences_are_the_same(shape, cut):
    *shape, order, h = shape
    poses = torch.tensor(np.random.default_rng(cut).normal(size=shape))
    whole = derivatives(poses, order, step=h)
    past = no_past(poses, order, step=h)
    for t, pose in enumerate(poses.unbind(1)):
        assert past.shape == (shape[0], order * h, shape[2])
        if t == min(cut, shape[1] - 1):
            assert torch.equal(derivatives(poses[:, t:], order, step=h, past=past), whole[:, t:])
        row, past = next_derivatives(pose, past, order, step=h)
        assert torch.equal(row, whole[:, t])


@pytest.mark.parametrize("h", [1, 2])
@pytest.mark.parametrize("restart", [1, 4])
def test_restarted_differences_take_earlier_frames_as_zeros(h, restart):
    poses = draw(1, 9, D).numpy()[0]
    first = np.stack([by_equation_5(poses, 1, h, t) for t in range(9)])
    rows = derivatives(torch.tensor(poses)[None], 3, step=h, restart=restart)[0].numpy()
    np.testing.assert_allclose(
        rows[:, D : 2 * D], first, rtol=0, atol=1e-14
    )  # the first difference uses the previous frame
    anew = np.where(np.arange(9)[:, None] < restart, 0, poses)  # so that the others are as large as a pose
    for n in (2, 3):
        expected = np.stack([by_equation_5(anew, n, h, t) for t in range(restart, 9)])
        np.testing.assert_allclose(rows[restart:, n * D : (n + 1) * D], expected, rtol=0, atol=1e-13)
    before = derivatives(torch.tensor(poses[:restart])[None], 3, step=h)[0].numpy()
    np.testing.assert_allclose(rows[:restart], before, rtol=0, atol=1e-14)


@pytest.mark.parametrize(("n", "order", "step"), [(9, 3, 1), (5, 2, 2), (4, 3, 2), (1, 3, 1), (3, 0, 1)])
def test_an_own_past_is_what_precedes_the_last_prediction(n, order, step):
    outputs = torch.randn(2, n, D)
    past = own_past(outputs, order, step=step)
    assert past.shape == (2, order * step, D)
    row, _ = next_derivatives(outputs[:, -1], past, order, step=step)
    torch.testing.assert_close(row, derivatives(outputs, order, step=step)[:, -1])


def test_restarted_differences_are_as_large_as_a_pose():
    """As in the released code: for a nearly still motion, the second and third difference equal the pose."""
    poses = torch.full((1, 9, D), 5.0, dtype=torch.float64) + 1e-3 * draw(1, 9, D)
    row = derivatives(poses, 3, restart=5)[0, 5].view(4, D)
    torch.testing.assert_close(row[1], poses[0, 5] - poses[0, 4], rtol=0, atol=1e-15)
    assert torch.equal(row[2:], poses[0, 5].expand(2, D))
    assert torch.equal(derivatives(poses, 1, restart=5), derivatives(poses, 1))  # the first difference stays


@given(shape=windows)
def test_the_past_of_the_next_frame(shape):
    *shape, order, h = shape
    poses = torch.tensor(np.random.default_rng(0).normal(size=shape))
    whole, n = derivatives(poses, order, step=h), shape[1] - 1
    assert torch.equal(
        derivatives(poses[:, n:], order, step=h, past=past_of(poses[:, :n], order, step=h)), whole[:, n:]
    )


# --- cells ------------------------------------------------------------------------------------------------------------


def arrays(cell, *tensors):
    parameters = {name: value.detach().numpy() for name, value in cell.named_parameters()}
    return parameters, [tensor.numpy() for tensor in tensors]


def original_gru(x, h, W, U, b):
    """A GRU step with a matrix and a bias for each of r (reset), u (update), c (candidate)."""
    r = sigmoid(x @ W["r"] + h @ U["r"] + b["r"])
    u = sigmoid(x @ W["u"] + h @ U["u"] + b["u"])
    c = np.tanh(x @ W["c"] + (r * h) @ U["c"] + b["c"])
    return u * h + (1 - u) * c


def random_biases(cell):
    with torch.no_grad():
        for name, value in cell.named_parameters():
            if name.endswith("bias"):
                value.normal_()
    return cell.double()


def matrices(parameters):
    """Return the input matrices, state matrices and biases of a `GRUCell`, gate by gate."""
    gates, candidate = parameters["gates"], parameters["candidate"]
    whole = {"u": gates[:, :H], "r": gates[:, H:], "c": candidate}
    biases = parameters["gates_bias"]
    W = {gate: kernel[:-H] for gate, kernel in whole.items()}
    U = {gate: kernel[-H:] for gate, kernel in whole.items()}
    return W, U, {"u": biases[:H], "r": biases[H:], "c": parameters["candidate_bias"]}


def test_gru_cell_is_the_original_gru():
    cell, x, h = random_biases(GRUCell(D, H)), draw(B, D), draw(B, H)
    parameters, (x_array, h_array) = arrays(cell, x, h)
    np.testing.assert_allclose(
        cell(x, h).detach(), original_gru(x_array, h_array, *matrices(parameters)), rtol=1e-12, atol=1e-14
    )


def test_text_body_cell_is_equations_1_to_4():
    cell, x, p, h = random_biases(BODY["text"]()), draw(B, D), draw(B, P), draw(B, H)
    parameters, (x_, p_, h_) = arrays(cell, x, p, h)
    both, U, b = matrices(parameters)
    W, V = ({gate: kernel[part] for gate, kernel in both.items()} for part in (slice(D), slice(D, None)))
    r = sigmoid(x_ @ W["r"] + h_ @ U["r"] + p_ @ V["r"] + b["r"])
    z = sigmoid(x_ @ W["u"] + h_ @ U["u"] + p_ @ V["u"] + b["u"])
    c = np.tanh(x_ @ W["c"] + (r * h_) @ U["c"] + p_ @ V["c"] + b["c"])
    np.testing.assert_allclose(cell(x, h, p).detach(), z * h_ + (1 - z) * c, rtol=1e-12, atol=1e-14)


def test_code_body_cell_is_the_released_one():
    cell, x, p, h = random_biases(BODY["code"]()), draw(B, D), draw(B, P), draw(B, H)
    parameters, (x_, p_, h_) = arrays(cell, x, p, h)
    sums = np.concatenate([x_, h_, p_], 1) @ parameters["gates"] + parameters["gates_bias"]
    u, r, g = (sigmoid(sums[:, k * H : (k + 1) * H]) for k in range(3))
    c = np.tanh(np.concatenate([x_, r * h_, g], 1) @ parameters["candidate"] + parameters["candidate_bias"])
    np.testing.assert_allclose(cell(x, h, p).detach(), u * h_ + (1 - u) * c, rtol=1e-12, atol=1e-14)


def as_torch(cell):
    """torch's GRU cell with the same parameters. It computes c = tanh(x W + r * (h U)), with the same gates."""
    other = torch.nn.GRUCell(D, H).double()
    W, U, b = matrices({name: value.detach() for name, value in cell.named_parameters()})
    with torch.no_grad():
        for gate, rows in {"r": slice(H), "u": slice(H, 2 * H), "c": slice(2 * H, None)}.items():
            other.weight_ih[rows], other.weight_hh[rows], other.bias_ih[rows] = W[gate].T, U[gate].T, b[gate]
            other.bias_hh[rows] = 0
    return other


def test_gru_cell_is_torchs_only_where_the_reset_gate_does_not_matter():
    cell, x, h = random_biases(GRUCell(D, H)), draw(B, D), draw(B, H)
    assert not torch.allclose(cell(x, h), as_torch(cell)(x, h), rtol=0, atol=1e-3)
    with torch.no_grad():
        cell.gates_bias[H:] = 100  # r = 1
    assert torch.allclose(cell(x, h), as_torch(cell)(x, h), rtol=0, atol=1e-13)
    with torch.no_grad():
        cell.gates_bias[H:] = 0
        cell.candidate[D:] = 0  # the candidate does not depend on h
    assert torch.allclose(cell(x, h), as_torch(cell)(x, h), rtol=0, atol=1e-13)


def test_the_update_gate_keeps_the_state():
    for cell in (BODY["code"]().double(), BODY["text"]().double()):
        with torch.no_grad():
            cell.gates_bias[:H] = 100
        h = draw(B, H)
        assert torch.allclose(cell(draw(B, D), h, draw(B, P)), h, rtol=0, atol=1e-13)


@pytest.mark.parametrize("kind", BODY)
def test_initial_parameters_are_those_of_the_released_code(kind):
    cell = BODY[kind]()
    for kernel in (cell.gates, cell.candidate):
        wide = kernel if len(kernel) <= kernel.shape[1] else kernel.T
        assert torch.allclose(wide @ wide.T, torch.eye(len(wide)), rtol=0, atol=1e-5)
    assert torch.equal(torch.cat([cell.gates_bias, cell.candidate_bias]).unique(), torch.tensor([0.1]))


@pytest.mark.parametrize("kind", BODY)
def test_blocks_compute_the_same_step(kind):
    cell, x, p, h = random_biases(BODY[kind]()), draw(B, D), draw(B, P), draw(B, H)
    blocks = cell.blocks(P)
    plan = torch.addmm(blocks.plan_bias, p, blocks.plan)
    sums = torch.cat([x, h], 1) @ blocks.gates
    if kind == "code":
        u, r, g = torch.sigmoid(plan + sums).chunk(3, 1)
        c = torch.tanh(torch.cat([g, r * h, x], 1) @ blocks.candidate + blocks.candidate_bias)
    else:
        assert blocks.candidate_bias is None
        u, r = torch.sigmoid(plan[:, H:] + sums).chunk(2, 1)
        c = torch.tanh(plan[:, :H] + torch.cat([r * h, x], 1) @ blocks.candidate)
    assert torch.allclose(cell(x, h, p), torch.lerp(c, h, u), rtol=0, atol=1e-13)


@pytest.mark.parametrize(("kind", "count"), [("code", 2_541_568), ("text", 1_906_176)])
def test_number_of_parameters(kind, count):
    cell = CodeCell(216, 512, 512) if kind == "code" else GRUCell(216 + 512, 512)
    assert sum(value.numel() for value in cell.parameters()) == count
