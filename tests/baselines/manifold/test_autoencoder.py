"""Tests of the autoencoder, as a network and as a projector of motion."""

import copy
from dataclasses import replace

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from npss_baselines.manifold.model.autoencoder import Autoencoder, AutoencoderConfig, TiedLayer, convolve, spread
from npss_baselines.manifold.model.matrix_products import MatrixProducts
from npss_baselines.manifold.model.projector import Manifold, mirrored
from npss_baselines.manifold.motion.scaling import SCALES, Scaling, fit_scaling

SMALL = AutoencoderConfig(n_features=9, widths=(5, 7, 6), kernel=5)


def network(config=SMALL, seed=0, dtype=torch.float64):
    """Return a layer or network with large weights and non-zero biases."""
    torch.manual_seed(seed)
    made = Autoencoder(config).to(dtype)
    for layer in made.first():
        torch.nn.init.uniform_(layer.bias, -0.1, 0.1)
    return made


def motion(n, n_frames, n_features=9, seed=1):
    return torch.from_numpy(np.random.default_rng(seed).normal(0, 0.5, (n, n_frames, n_features)))


# --- against the paper's formulas, written out ---


def by_hand(x, layers, config):
    """Encode and decode one window (T, F) by loops."""
    around = config.kernel // 2
    weights = [(layer.weight.detach().numpy(), layer.bias.detach().numpy()) for layer in layers]
    for weight, bias in weights:
        filtered = np.zeros((len(x), len(bias)))
        for t in range(len(x)):
            for k in range(config.kernel):
                if 0 <= t + k - around < len(x):
                    filtered[t] += weight[..., k] @ x[t + k - around]
        x = np.tanh([np.max(filtered[t : t + config.pool] + bias, axis=0) for t in range(0, len(x), config.pool)])
    code = x
    for weight, bias in reversed(weights):
        values = np.arctanh(np.clip(x, config.eps - 1, 1 - config.eps))
        if config.unpool == "half":
            values = values / config.pool
        values = np.repeat(values, config.pool, axis=0) - bias
        flipped = weight[..., ::-1].swapaxes(0, 1)  # W~
        x = np.zeros((len(values), weight.shape[1]))
        for t in range(len(x)):
            for k in range(config.kernel):
                if 0 <= t + k - around < len(x):
                    x[t] += flipped[..., k] @ values[t + k - around]
    return code, x


@pytest.mark.numeric
@pytest.mark.parametrize("unpool", ["both", "half"])
@pytest.mark.parametrize("pool", [1, 2, 3])
@pytest.mark.parametrize("depth", [1, 2, 3])
def test_network_follows_the_paper(unpool, pool, depth):
    config = replace(SMALL, pool=pool, unpool=unpool, widths=SMALL.widths[:depth], eps=0.05)
    made, x = network(config), motion(2, 3 * config.stride)
    with torch.no_grad():
        code, projected = made.encode(x), made.project(x)
    assert code.shape == (2, 3, SMALL.widths[depth - 1])
    for window, code_of_window, back in zip(x, code, projected, strict=True):
        expected_code, expected = by_hand(window.numpy(), made.first(), config)
        np.testing.assert_allclose(code_of_window, expected_code, atol=1e-12)
        np.testing.assert_allclose(back, expected, atol=1e-10)


@pytest.mark.numeric
@pytest.mark.parametrize("unpool", ["both", "half"])
@pytest.mark.parametrize("pool", [1, 2, 3])
@pytest.mark.parametrize("kernel", [1, 3, 5, 15])
def test_matrix_products_are_the_network(kernel, pool, unpool):
    config = replace(SMALL, pool=pool, unpool=unpool, kernel=kernel, eps=0.05)
    made, x = network(config), motion(2, 3 * config.stride)
    products = MatrixProducts(made)
    with torch.no_grad():
        torch.testing.assert_close(products.encode(x), made.encode(x), rtol=0, atol=1e-12)
        # Values beyond the range of tanh are clipped, and a single step has no neighbours.
        for code in (motion(2, 3, 6), motion(1, 1, 6)):
            torch.testing.assert_close(products.decode(code), made.decode(code), rtol=0, atol=1e-10)


@pytest.mark.numeric
def test_single_precision_products_are_the_network():
    """Compare one layer, of the paper's size.

    A sum of n products in single precision, in any order, is within n eps of the products' magnitudes. tanh does not
    enlarge errors; atanh enlarges them by 1 / (1 - y^2).
    """
    torch.manual_seed(0)
    made = Autoencoder(AutoencoderConfig(widths=(64,)))
    products, x = MatrixProducts(made), motion(2, 32, 63).float()
    eps, n_terms = np.finfo(np.float32).eps, 15 * 64
    with torch.no_grad():
        layer = made.first()[0]
        magnitude = convolve(x.abs(), layer.weight.abs()).max().item()
        code = products.encode(x)
        torch.testing.assert_close(code, made.encode(x), rtol=0, atol=n_terms * eps * magnitude)
        values = code.clamp(-0.999, 0.999)
        magnitude = spread(torch.atanh(values).abs().repeat_interleave(2, 1), layer.weight.abs()).max().item()
        error = (n_terms + 4 / (1 - 0.999**2)) * eps * magnitude
        torch.testing.assert_close(products.decode(code), made.decode(code), rtol=0, atol=error)


@pytest.mark.numeric
def test_without_pooling_the_inverse_of_identity_filters_inverts():
    config = AutoencoderConfig(n_features=6, widths=(6, 6, 6), pool=1, eps=1e-9)
    made = network(config)
    for layer in made.first():
        with torch.no_grad():
            layer.weight.zero_()
            layer.weight[..., 7] = torch.eye(6)
    x = motion(3, 20, 6)
    torch.testing.assert_close(made.project(x), x, rtol=0, atol=1e-12)
    for layer in made.first():
        with torch.no_grad():
            layer.weight[..., 7] *= 2  # no longer an inverse: W~ is W transposed
    assert (made.project(x) - x).abs().max() > 0.1


@pytest.mark.numeric
def test_encoder_and_decoder_share_storage():
    made = network()
    assert sum(parameter.numel() for parameter in made.parameters()) == 5 * (9 * 5 + 5 * 7 + 7 * 6) + 5 + 7 + 6
    layer, x, y = made.first()[0], motion(1, 8), motion(1, 4, 5) / 2
    before = layer(x), layer.inverse(y)
    with torch.no_grad():
        layer.weight.mul_(1.5)
    assert not torch.allclose(layer(x), before[0])
    assert not torch.allclose(layer.inverse(y), before[1])


@pytest.mark.numeric
def test_the_inverse_is_the_adjoint():
    weight = torch.randn(4, 9, 5, dtype=torch.float64)
    x, y = motion(3, 12), motion(3, 12, 4)
    assert ((convolve(x, weight) * y).sum() - (x * spread(y, weight)).sum()).abs() < 1e-12


@pytest.mark.numeric
def test_random_unpooling_is_even_on_average():
    layer = TiedLayer(4, 4, AutoencoderConfig(n_features=4, widths=(4,), kernel=1, eps=1e-6)).double()
    with torch.no_grad():
        layer.weight[..., 0] = torch.eye(4)
    y = torch.tensor([[[0.5, -0.3, 0.9, 0.1]]], dtype=torch.float64).expand(4000, -1, -1)
    values = torch.atanh(y)[:, 0]
    first, second = layer.inverse(y, "random").detach().unbind(1)
    torch.testing.assert_close(first + second, values)
    assert ((first == 0) ^ (second == 0)).all()
    share = (second == 0).double()
    assert (share.mean(0) - 0.5).abs().max() < 4 * 0.5 / 4000**0.5
    assert np.abs(np.corrcoef(share.numpy().T) - np.eye(4)).max() < 4 / 4000**0.5  # each unit by itself
    torch.testing.assert_close(layer.inverse(y, "half").detach(), torch.stack([values, values], 1) / 2)
    torch.testing.assert_close(layer.inverse(y, "both").detach(), torch.stack([values, values], 1))


@pytest.mark.numeric
def test_values_outside_the_range_of_tanh_are_clipped():
    layer = network().first()[0]
    beyond = torch.tensor([-7.0, -1.0, 1.0, 30.0], dtype=torch.float64).view(1, 4, 1).expand(1, 4, 5)
    torch.testing.assert_close(layer.inverse(beyond), layer.inverse(beyond.sign() * (1 - 1e-3)))
    assert layer.inverse(beyond).isfinite().all()


@pytest.mark.numeric
@given(st.integers(1, 40), st.integers(0, 2**32 - 1))
def test_a_shift_by_a_stride_moves_the_code_by_a_step(shift, seed):
    made = network(seed=3)
    x = motion(1, 48 + 8 * 16, seed=seed)[0]
    # A unit of the last layer sees 2 + 2 * 2 + 4 * 2 frames on either side of its step.
    clear = slice(2, -2)
    with torch.no_grad():
        still, moved = made.encode(torch.stack([x[40:], x[40 - shift : -shift]])).numpy()
    if shift % 8 == 0:
        steps = shift // 8
        np.testing.assert_allclose(moved[steps:][clear], still[: len(still) - steps][clear], rtol=0, atol=1e-12)
    else:
        assert np.abs(moved[1:][clear] - still[:-1][clear]).max() > 1e-3
        assert np.abs(moved[clear] - still[clear]).max() > 1e-3


@pytest.mark.numeric
def test_gradients_by_finite_differences():
    made = network(replace(SMALL, widths=(3, 2), n_features=4, kernel=3))
    x = motion(2, 8, 4)
    parameters = [parameter.detach().requires_grad_() for parameter in made.parameters()]
    names = [name for name, _ in made.named_parameters()]

    def projected(*values):
        made.forward = made.project  # what functional_call calls
        return torch.func.functional_call(made, dict(zip(names, values, strict=True)), x)

    assert torch.autograd.gradcheck(projected, parameters)


# --- configurations ---


@pytest.mark.parametrize(
    ("fields", "error", "message"),
    [
        ({"n_features": 0}, ValueError, "n_features: expected a positive integer"),
        ({"kernel": 4}, ValueError, "kernel: expected an odd number of frames, got 4"),
        ({"kernel": 3.0}, TypeError, "kernel: "),
        ({"pool": 0}, ValueError, "pool: "),
        ({"widths": ()}, ValueError, "widths: expected at least one layer"),
        ({"widths": (4, -1)}, ValueError, r"widths\[1\]: "),
        ({"widths": 4}, TypeError, "widths: expected a sequence"),
        ({"unpool": "random"}, ValueError, "unpool: expected one of both, half, got 'random'"),
        ({"eps": "small"}, TypeError, "eps: expected a number"),
        ({"eps": 0.0}, ValueError, "eps: expected a number between 0 and 1, got 0.0"),
    ],
)
def test_invalid_configuration(fields, error, message):
    with pytest.raises(error, match=f"^{message}"):
        AutoencoderConfig(**fields)


def test_frames_are_multiples_of_the_stride():
    assert AutoencoderConfig(widths=[4, 5]).widths == (4, 5)
    assert AutoencoderConfig().stride == 8
    with pytest.raises(ValueError, match=r"^x: 12 frames are not a multiple of 8"):
        network().encode(motion(1, 12))


# --- projectors ---


def projector(n_joints=2, seed=0, dtype=torch.float32):
    n_features = 3 * n_joints + 3
    rng = np.random.default_rng(seed)
    statistics = Scaling(rng.normal(3, 1, n_features), rng.uniform(1, 9, n_features))
    return Manifold(network(replace(SMALL, n_features=n_features), dtype=dtype), statistics, "some")


@pytest.mark.numeric
@pytest.mark.parametrize("n_joints", [1, 2, 20, 31])
def test_any_skeleton(n_joints):
    manifold, n_features = projector(n_joints), 3 * n_joints + 3
    features = np.random.default_rng(0).normal(size=(2, 16, n_features))
    assert manifold.encode(features).shape == (2, 2, 6)
    assert manifold.project(features).shape == features.shape


@pytest.mark.numeric
@pytest.mark.parametrize("n_frames", [1, 2, 7, 8, 9, 24, 161])
def test_any_length(n_frames):
    manifold = projector(dtype=torch.float64)  # atanh makes an error up to 500 times as large, in each of three layers
    features = np.random.default_rng(1).normal(3, 5, (70, n_frames, 9))
    code, projected = manifold.encode(features), manifold.project(features)
    assert code.shape == (70, -(-n_frames // 8), 6)
    assert np.array_equal(projected, manifold.decode(code, n_frames))
    # In the units of the features, and of a motion by itself; np.pad's mirroring is that of windows_of.
    padded = np.pad(features[-1:], ((0, 0), (0, -n_frames % 8), (0, 0)), mode="reflect")
    statistics = manifold.scaling
    with torch.no_grad():
        seen = torch.from_numpy((padded - statistics.mean) / statistics.scale)
        expected = manifold.network.project(seen).numpy() * statistics.scale + statistics.mean
    np.testing.assert_allclose(projected[-1], expected[0, :n_frames], rtol=1e-9, atol=1e-9)


@pytest.mark.numeric
def test_single_precision_codes_are_those_of_double_precision():
    features = np.random.default_rng(1).normal(3, 5, (70, 161, 9))
    single = projector()
    double = replace(single, network=copy.deepcopy(single.network).double())
    code = single.encode(features)
    assert (code.dtype, single.project(features).dtype) == (np.float32, np.float64)
    # Three layers, each a sum of 35 products or fewer of values up to 1, whose rounding tanh does not enlarge.
    # The weights enlarge that of the layers below.
    n_terms = SMALL.kernel * max(SMALL.widths)
    gain = [layer.weight.detach().abs().sum((1, 2)).max().item() for layer in double.network.first()]
    tolerance = n_terms * np.finfo(np.float32).eps * (1 + gain[2] * (1 + gain[1]))
    np.testing.assert_allclose(code, double.encode(features), rtol=0, atol=tolerance)


@pytest.mark.numeric
def test_motion_is_mirrored_at_the_last_frame():
    rows = np.arange(3.0).reshape(1, 3, 1)
    assert mirrored(rows, 8).ravel().tolist() == [0, 1, 2, 1, 0, 1, 2, 1]
    assert mirrored(rows, 2, least=6).ravel().tolist() == [0, 1, 2, 1, 0, 1]
    assert mirrored(rows, 3).ravel().tolist() == [0, 1, 2]


def test_invalid_motion():
    manifold = projector()
    for wrong, message in (
        (np.zeros((8, 9)), r"features: expected shape \(n, T, 9\), got \(8, 9\)"),
        (np.zeros((1, 8, 10)), r"features: expected shape \(n, T, 9\)"),
        (np.zeros((1, 0, 9)), r"features: expected shape \(n, T, 9\)"),
        (np.full((1, 8, 9), np.nan), "features: nan at index"),
    ):
        with pytest.raises(ValueError, match=f"^{message}"):
            manifold.project(wrong)
    with pytest.raises(TypeError, match=r"^features: expected real numbers"):
        manifold.encode(np.full((1, 8, 9), "x"))
    with pytest.raises(ValueError, match=r"^code: expected shape \(n, T, 6\)"):
        manifold.decode(np.zeros((1, 2, 9)), 8)
    with pytest.raises(ValueError, match=r"^n_frames: 2 steps have 16 frames"):
        manifold.decode(np.zeros((1, 2, 6)), 17)
    with pytest.raises(ValueError, match=r"^n_frames: expected a positive integer"):
        manifold.decode(np.zeros((1, 2, 6)), 0)


# --- normalisation ---


@pytest.mark.numeric
@pytest.mark.parametrize("scale", SCALES)
def test_statistics_exclude_padding(scale):
    rng = np.random.default_rng(0)
    windows = rng.normal(2, [3, 1, 4, 1, 5, 9, 2], (6, 10, 7)).astype(np.float32)
    windows[..., 1] = 7  # does not vary
    mask = rng.random((6, 10)) < 0.7
    statistics = fit_scaling(windows, mask, scale)
    frames = windows[mask].astype(np.float64)
    deviations = frames - frames.mean(0)
    std = np.sqrt(np.mean(deviations**2, axis=0))
    expected = {
        "none": np.ones(7),
        "global": np.full(7, np.sqrt(np.mean(deviations**2))),
        "kind": np.concatenate([np.full(4, np.sqrt(np.mean(deviations[:, :4] ** 2))), std[4:]]),
        "feature": np.where(std > 0, std, 1),
    }[scale]
    np.testing.assert_allclose(statistics.mean, frames.mean(0))
    np.testing.assert_allclose(statistics.scale, expected)
    again = statistics.unnormalize(statistics.normalize(windows))
    np.testing.assert_allclose(again, windows, rtol=0, atol=1e-12)
    assert np.abs(statistics.normalize(frames).mean(0)).max() < 1e-12
    smaller = fit_scaling(windows, mask, scale, 0.1)
    assert np.array_equal(smaller.mean, statistics.mean)
    np.testing.assert_allclose(smaller.normalize(frames), statistics.normalize(frames) / 10)
    windows[~mask] = 1e9
    assert np.array_equal(fit_scaling(windows, mask, scale).scale, statistics.scale)


def test_invalid_scaling():
    with pytest.raises(ValueError, match=r"^scale: expected one of none, global, kind, feature, got 'unit'"):
        fit_scaling(np.zeros((1, 2, 6)), np.ones((1, 2), bool), "unit")
    with pytest.raises(ValueError, match=r"^windows: no frames"):
        fit_scaling(np.zeros((1, 2, 6)), np.zeros((1, 2), bool), "kind")
