"""The generated gait: repeatable, plausible, and in the layout of Human3.6M."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss import poses_to_euler
from npss.gait import gait
from npss.protocol import COLUMNS, normalization


@pytest.fixture(scope="module")
def walks():
    return gait(64, 250, seed=0)


@given(st.integers(1, 3), st.integers(1, 40), st.sampled_from([25, 29.97, 50, 120]), st.integers(0, 100))
def test_layout(n, n_frames, fps, seed):
    walks = gait(n, n_frames, fps=fps, seed=seed)
    assert walks.shape == (n, n_frames, 99)
    assert walks.dtype == np.float64
    assert np.isfinite(walks).all()
    assert np.flatnonzero(walks.any(axis=(0, 1))).tolist() == list(COLUMNS)


def test_same_seed_same_walks():
    first, second, other = (gait(2, 50, seed=seed) for seed in (3, 3, 4))
    assert np.array_equal(first, second)
    assert not np.array_equal(first, other)
    assert not np.allclose(first[0], first[1])


def test_rotations_are_smooth_and_small(walks):
    rotations = walks[..., 3:]
    angles = np.linalg.norm(rotations.reshape(*rotations.shape[:2], 32, 3), axis=-1)
    assert angles.max() < np.pi
    assert np.abs(np.diff(rotations, axis=1)).max() < 0.5


def test_walkers_go_forward_at_a_walking_pace(walks):
    speed = walks[..., 2].mean(axis=1) * 25 / 1000  # m/s
    assert 0.5 < speed.min() < speed.max() < 2


def test_legs_swing_in_antiphase_at_the_cadence(walks):
    right, left = (walks[..., column] - walks[..., column].mean(axis=1, keepdims=True) for column in (6, 21))
    for a, b in zip(right, left, strict=True):
        assert np.corrcoef(a, b)[0, 1] < -0.7
    power = np.abs(np.fft.rfft(right, axis=1)) ** 2
    strides_per_second = power.argmax(axis=1) * 25 / 250
    assert 0.6 < strides_per_second.min() < strides_per_second.max() < 1.3


def test_frame_rate_changes_only_the_sampling():
    slow, fast = (gait(3, count, fps=fps, seed=5) for count, fps in ((50, 25), (100, 50)))
    assert np.abs(slow - fast[:, ::2])[..., 3:].max() < 1e-3


def test_columns_that_models_see_are_those_of_human36m(walks):
    assert normalization(walks).columns == COLUMNS


def test_it_is_scored_as_poses(walks):
    euler = poses_to_euler(walks)
    assert not euler[..., :6].any()
    assert (euler.std(axis=1) > 1e-4).sum(axis=1).min() >= 48


@pytest.mark.parametrize(
    ("error", "change", "message"),
    [
        (ValueError, {"n": 0}, "n: expected a positive integer, got 0"),
        (TypeError, {"n": 1.5}, "n: expected a positive integer, got 1.5"),
        (ValueError, {"n_frames": -1}, "n_frames: expected a positive integer, got -1"),
        (ValueError, {"fps": 0}, "fps: expected a positive, finite number, got 0"),
        (TypeError, {"seed": 0.5}, "seed: expected a whole number or a numpy.random.Generator, got 0.5"),
    ],
)
def test_bad_arguments(error, change, message):
    with pytest.raises(error, match=f"^{message}$"):
        gait(**{"n": 1, "n_frames": 10, "seed": 0} | change)
