"""Untrained predictors against their descriptions."""

import math
import statistics

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss.predictors import PREDICTORS, gated_periodic, periodic, repeat, running_average, zero_velocity


def poses(n, n_seed, n_features, random_seed):
    return np.random.default_rng(random_seed).normal(size=(n, n_seed, n_features)) * 100


SEEDS = st.builds(poses, st.integers(1, 3), st.integers(50, 60), st.integers(1, 3), st.integers(0, 2**32 - 1))
COUNTS = st.integers(1, 120)


def test_names():
    assert list(PREDICTORS) == [
        "zero-velocity",
        "running-average-2",
        "running-average-4",
        "repeat-50",
        "periodic",
        "gated-periodic",
    ]


@pytest.mark.parametrize("name", PREDICTORS)
class TestAll:
    @given(seed=SEEDS, n_target=COUNTS)
    def test_shape_and_unchanged_seed_frames(self, name, seed, n_target):
        copy = seed.copy()
        predicted = PREDICTORS[name](seed, n_target)
        assert predicted.shape == (len(seed), n_target, seed.shape[2])
        predicted[...] = np.nan
        assert np.array_equal(seed, copy)

    @given(seed=SEEDS, n_target=COUNTS)
    def test_a_still_seed_stays_still(self, name, seed, n_target):
        still = np.repeat(seed[:, :1], 50, axis=1)
        predicted = PREDICTORS[name](still, n_target)
        np.testing.assert_allclose(predicted, np.repeat(still[:, :1], n_target, axis=1), rtol=1e-15)

    @given(seed=SEEDS, n_target=COUNTS)
    def test_a_shorter_prediction_is_the_beginning_of_a_longer_one(self, name, seed, n_target):
        longer = PREDICTORS[name](seed, n_target + 7)
        assert np.array_equal(PREDICTORS[name](seed, n_target), longer[:, :n_target])

    @given(seed=SEEDS, n_target=COUNTS)
    def test_only_the_last_50_frames_matter(self, name, seed, n_target):
        assert np.array_equal(PREDICTORS[name](seed, n_target), PREDICTORS[name](seed[:, -50:], n_target))

    @pytest.mark.parametrize(
        ("dtype", "result"),
        [(np.float32, np.float32), (np.float64, np.float64), (np.float16, np.float64), (np.int64, np.float64)],
    )
    def test_precision(self, name, dtype, result):
        seed = np.ones((2, 50, 3), dtype)
        predicted = PREDICTORS[name](seed, 4)
        assert predicted.dtype == result
        assert (predicted == 1).all()

    @pytest.mark.parametrize(
        ("error", "seed", "message"),
        [
            (ValueError, np.zeros((50, 3)), r"seed_frames: expected shape \(N, S, D\).* got \(50, 3\)"),
            (ValueError, np.zeros((2, 50, 0)), r"seed_frames: expected shape \(N, S, D\).* got \(2, 50, 0\)"),
            (ValueError, np.full((1, 50, 1), np.nan), r"seed_frames: nan at index \(0, 0, 0\)"),
            (TypeError, np.zeros((1, 50, 1), bool), "seed_frames: expected real numbers, got booleans"),
            (TypeError, np.ma.zeros((1, 50, 1)), "seed_frames: masked arrays are refused"),
        ],
    )
    def test_bad_seeds(self, name, error, seed, message):
        with pytest.raises(error, match=message):
            PREDICTORS[name](seed, 10)

    @pytest.mark.parametrize(("error", "n_target"), [(ValueError, 0), (ValueError, -3), (TypeError, 2.0)])
    def test_bad_numbers_of_frames(self, name, error, n_target):
        with pytest.raises(error, match=r"^n_target: expected a positive integer"):
            PREDICTORS[name](np.zeros((1, 50, 1)), n_target)


@pytest.mark.parametrize(
    ("name", "frames"),
    [
        ("running-average-2", 2),
        ("running-average-4", 4),
        ("repeat-50", 50),
        ("periodic", 50),
        ("gated-periodic", 50),
    ],
)
def test_the_shortest_seed(name, frames):
    PREDICTORS[name](np.zeros((1, frames, 1)), 1)
    with pytest.raises(ValueError, match=f"seed_frames: {frames - 1} frames, but the predictor uses the last {frames}"):
        PREDICTORS[name](np.zeros((1, frames - 1, 1)), 1)


@given(SEEDS, COUNTS)
def test_zero_velocity_holds_the_last_frame(seed, n_target):
    assert np.array_equal(zero_velocity(seed, n_target), np.repeat(seed[:, -1:], n_target, axis=1))


@given(SEEDS, COUNTS, st.integers(1, 5))
def test_running_average_holds_the_mean(seed, n_target, frames):
    mean = sum(seed[:, -k] for k in range(1, frames + 1)) / frames
    predicted = running_average(seed, n_target, frames=frames)
    np.testing.assert_allclose(predicted, np.repeat(mean[:, np.newaxis], n_target, axis=1), rtol=1e-12, atol=1e-9)


def test_running_average_of_float32_is_rounded_once():
    seed = np.array([1, 1 + 2**-23, 1 + 2**-23, 1 + 2**-23], np.float32).reshape(1, 4, 1)
    assert running_average(seed, 1, frames=4)[0, 0, 0] == np.float32(1 + 2**-23)


@given(SEEDS, st.integers(1, 50), st.integers(1, 3))
def test_a_periodic_motion_is_predicted_by_repeating_it(seed, period, times):
    motion = np.tile(seed[:, -period:], (1, times + 1, 1))
    seen, future = motion[:, :period], motion[:, period:]
    assert np.array_equal(repeat(seen, period * times, frames=period), future)


@pytest.mark.parametrize("predictor", [running_average, repeat])
@pytest.mark.parametrize(("error", "frames"), [(ValueError, 0), (TypeError, 1.0)])
def test_bad_options(predictor, error, frames):
    with pytest.raises(error, match=r"^frames: expected a positive integer"):
        predictor(np.zeros((1, 50, 1)), 1, frames=frames)


def periodic_oracle(seed, n_target, shortest=15, longest=40, frames=10, decay=5.0, gated=False):
    """Predict one sequence (S, D), from the definition."""
    n = len(seed)
    distance = {}
    for lag in range(shortest, longest + 1):
        pairs = [(seed[n - 1 - i], seed[n - 1 - i - lag]) for i in range(frames)]
        distance[lag] = math.fsum((x - y) ** 2 for late, early in pairs for x, y in zip(late, early, strict=True))
    period = min(distance, key=distance.get)  # the first of equal ones
    predicted = np.empty((n_target, seed.shape[1]))
    for t in range(n_target):
        for d in range(seed.shape[1]):
            step = seed[n - 1, d] - seed[n - 1 - period, d]
            value = seed[n - period + t % period, d] + step * math.exp(-t / decay)
            if gated:
                squares = [(seed[n - 1 - i, d] - seed[n - 1 - i - period, d]) ** 2 for i in range(frames)]
                spread = statistics.pstdev(seed[n - longest - frames :, d].tolist())
                gate = min(1, max(0.15, 1.5 - math.sqrt(math.fsum(squares) / frames) / spread)) if spread else 0.15
                value = seed[n - 1, d] + gate * (value - seed[n - 1, d])
            predicted[t, d] = value
    return predicted


class TestPeriodic:
    @pytest.mark.parametrize("gated", [False, True])
    @given(seed=SEEDS, n_target=COUNTS)
    def test_against_the_definition(self, gated, seed, n_target):
        predictor = gated_periodic if gated else periodic
        expected = [periodic_oracle(sequence, n_target, gated=gated) for sequence in seed]
        np.testing.assert_allclose(predictor(seed, n_target), expected, rtol=1e-12, atol=1e-10)

    @pytest.mark.parametrize("gated", [False, True])
    @given(seed=SEEDS, shortest=st.integers(1, 9), more=st.integers(0, 5), frames=st.integers(1, 5))
    def test_options(self, gated, seed, shortest, more, frames):
        predictor = gated_periodic if gated else periodic
        predicted = predictor(seed, 20, lags=(shortest, shortest + more), frames=frames, decay=2.5)
        expected = [periodic_oracle(s, 20, shortest, shortest + more, frames, 2.5, gated) for s in seed]
        np.testing.assert_allclose(predicted, expected, rtol=1e-12, atol=1e-10)

    @pytest.mark.parametrize("predictor", [periodic, gated_periodic])
    @given(seed=SEEDS, period=st.integers(15, 40))
    def test_a_periodic_motion_continues(self, predictor, seed, period):
        motion = np.tile(seed[:, -period:], (1, 14, 1))[:, :200]
        np.testing.assert_allclose(predictor(motion[:, :80], 120), motion[:, 80:], rtol=1e-12, atol=1e-9)

    @given(seed=SEEDS, n_target=COUNTS)
    def test_the_gate_is_between_zero_velocity_and_periodic(self, seed, n_target):
        held, free = zero_velocity(seed, n_target), periodic(seed, n_target)
        gated = gated_periodic(seed, n_target)
        slack = 1e-9
        assert (gated >= np.minimum(held, free) - slack).all()
        assert (gated <= np.maximum(held, free) + slack).all()

    @given(seed=SEEDS, scale=st.sampled_from([0.25, 2.0, 8.0]))
    def test_the_unit_of_all_features_does_not_matter(self, seed, scale):
        for predictor in (periodic, gated_periodic):
            np.testing.assert_allclose(predictor(seed * scale, 30), predictor(seed, 30) * scale, rtol=1e-12, atol=1e-9)

    def test_the_first_frame_follows_the_last_by_the_recorded_step(self):
        seed = poses(2, 50, 3, 0)
        predicted, period = periodic(seed, 1, lags=(20, 20)), 20
        step = seed[:, 50 - period] - seed[:, 49 - period]
        np.testing.assert_allclose(predicted[:, 0], seed[:, -1] + step, rtol=1e-12, atol=1e-10)

    @pytest.mark.parametrize(
        ("error", "options", "message"),
        [
            (ValueError, {"lags": (5, 4)}, "^lags: expected the shortest and the longest, got 5 and 4"),
            (ValueError, {"lags": (0, 4)}, "^lags: expected a positive integer, got 0"),
            (TypeError, {"lags": (1.5, 4)}, "^lags: expected a positive integer, got 1.5"),
            (TypeError, {"lags": 4}, "^lags: expected a sequence of integers, got 4"),
            (ValueError, {"lags": (1, 2, 3)}, "^lags: expected two integers, the shortest and the longest, got"),
            (ValueError, {"frames": 0}, "^frames: expected a positive integer, got 0"),
            (ValueError, {"frames": 11}, "^seed_frames: 50 frames, but the predictor uses the last 51"),
            (ValueError, {"decay": 0}, "^decay: expected a positive, finite number, got 0"),
            (ValueError, {"decay": np.nan}, "^decay: expected a positive, finite number, got nan"),
        ],
    )
    @pytest.mark.parametrize("predictor", [periodic, gated_periodic])
    def test_bad_options(self, predictor, error, options, message):
        with pytest.raises(error, match=message):
            predictor(np.zeros((1, 50, 1)), 1, **options)
