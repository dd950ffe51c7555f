"""Tests of initial weights."""

import numpy as np
import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from npss_baselines.manifold.model.autoencoder import Autoencoder, AutoencoderConfig
from npss_baselines.manifold.model.initialization import initialize


def made(how="orthonormal", seed=0, **fields):
    torch.manual_seed(seed)
    network = Autoencoder(AutoencoderConfig(**fields))
    initialize(network, how)
    return network


def small_motion(n_frames, n_features, seed):
    """Return motion small enough for tanh(x) to equal x to 1e-12 in float64."""
    return torch.from_numpy(np.random.default_rng(seed).normal(0, 1e-4, (2, n_frames, n_features)))


@given(
    n_features=st.integers(1, 9),
    factors=st.lists(st.integers(2, 3), min_size=1, max_size=3),
    unpool=st.sampled_from(["both", "half"]),
    seed=st.integers(0, 99),
)
def test_motion_is_reconstructed_as_the_average_of_a_step(n_features, factors, unpool, seed):
    """With at least twice as many filters as inputs, pooling keeps the maximum and minimum of two frames."""
    widths = tuple(int(width) for width in n_features * np.cumprod(factors))
    network = made(seed=seed, n_features=n_features, widths=widths, kernel=3, unpool=unpool).double()
    steps = 2 ** len(widths)
    motion = small_motion(5 * steps, n_features, seed)
    mean = motion.view(2, 5, steps, n_features).mean(2).repeat_interleave(steps, 1)
    torch.testing.assert_close(network.project(motion), mean, atol=1e-9, rtol=0)


@pytest.mark.parametrize("widths", [(7,), (9, 9)])
def test_without_pooling_small_motion_is_unchanged(widths):
    network = made(n_features=6, widths=widths, kernel=5, pool=1).double()
    motion = small_motion(12, 6, 1)
    torch.testing.assert_close(network.project(motion), motion, atol=1e-9, rtol=0)


def test_fewer_filters_than_inputs_project():
    """They project onto as many dimensions; projecting again changes nothing."""
    network = made(n_features=6, widths=(4,), kernel=5, pool=1).double()
    motion = small_motion(12, 6, 1)
    once = network.project(motion)
    torch.testing.assert_close(network.project(once), once, atol=1e-9, rtol=0)
    assert torch.linalg.matrix_rank(once.reshape(-1, 6), rtol=1e-6) == 4


def test_the_odd_filter_is_zero():
    weight = made(n_features=3, widths=(7,), kernel=3).first()[0].weight
    assert not weight[6].any()
    assert torch.equal(weight[:3], -weight[3:6])


def test_glorot_changes_nothing():
    expected = made("glorot", seed=4)
    torch.manual_seed(4)
    network = Autoencoder(AutoencoderConfig())
    assert all(torch.equal(*pair) for pair in zip(network.parameters(), expected.parameters(), strict=True))


def test_same_seed_same_weights():
    first, same, other = made(seed=1), made(seed=1), made(seed=2)
    assert all(torch.equal(*pair) for pair in zip(first.parameters(), same.parameters(), strict=True))
    assert not torch.equal(first.first()[0].weight, other.first()[0].weight)


def test_unknown_initialization():
    with pytest.raises(ValueError, match=r"^how: expected one of glorot, orthonormal, got 'zero'"):
        made("zero")
