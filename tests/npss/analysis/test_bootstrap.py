"""The studentised bootstrap of a quotient of sums, against plain loops, all draws, and its coverage."""

from itertools import product

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss._analysis import bootstrap as _bootstrap
from npss._analysis.bootstrap import bootstrap_interval, checked_level


def sequences(n, seed=0):
    """Return what each sequence adds to numerator and denominator: quotients around 2, unequal weights."""
    rng = np.random.default_rng(seed)
    weight = np.exp(rng.normal(size=n))
    return weight * (2 + 0.3 * rng.normal(size=n)), weight


def plain_ratio(numerator, denominator):
    """Return a quotient of sums and its standard error, by the delta method."""
    value = sum(numerator) / sum(denominator)
    squares = sum((a - value * b) ** 2 for a, b in zip(numerator, denominator, strict=True))
    return value, squares**0.5 / sum(denominator)


def plain_studentised(numerator, denominator, draws):
    """Return the studentised errors of draws, each a list of sequences."""
    value, _ = plain_ratio(numerator, denominator)
    errors = []
    for draw in draws:
        again, error = plain_ratio(numerator[list(draw)], denominator[list(draw)])
        of_one_sequence = len(set(draw)) == 1
        errors.append(np.sign(again - value) * np.inf if of_one_sequence else (again - value) / error)
    return np.array(errors)


def quantiles_behind(numerator, denominator, **options):
    """Return the two quantiles of studentised errors that an interval was made with."""
    value, error = plain_ratio(numerator, denominator)
    low, high = bootstrap_interval(numerator, denominator, **options)
    assert 0 < low < value < high
    return (value - high) / error, (value - low) / error


TAIL = 0.025  # beyond each quantile, at the usual level


def check_tails(errors, lower, upper, slack):
    rounding = 1e-9
    assert np.mean(errors < lower - rounding) - slack < TAIL < np.mean(errors <= lower + rounding) + slack
    assert np.mean(errors > upper + rounding) - slack < TAIL < np.mean(errors >= upper - rounding) + slack


@pytest.mark.parametrize("n", [8, 13, 30])
def test_quantiles_equal_those_of_plain_loops(n):
    numerator, denominator = sequences(n)
    rng = np.random.default_rng(100)
    errors = plain_studentised(numerator, denominator, rng.integers(n, size=(2500, n)))
    # Four standard errors of a share of 0.025, in 2500 draws here and 9999 there.
    check_tails(errors, *quantiles_behind(numerator, denominator), 4 * np.sqrt(TAIL * (1 - TAIL) * (1 / 2500 + 1e-4)))


@pytest.mark.parametrize(("n", "seed"), [(4, 2), (5, 0), (5, 1)])
def test_quantiles_equal_those_of_all_draws(n, seed):
    numerator, denominator = sequences(n, seed)
    errors = plain_studentised(numerator, denominator, list(product(range(n), repeat=n)))
    check_tails(errors, *quantiles_behind(numerator, denominator), 4 * np.sqrt(TAIL * (1 - TAIL) * 1e-4))


def percentiles(numerator, denominator, resamples=999):
    """Return the plain percentile interval, which is what one would try first."""
    rng = np.random.default_rng(1)
    n = numerator.shape[-1]
    counts = np.stack([np.bincount(draw, minlength=n) for draw in rng.integers(n, size=(resamples, n))]).T
    return np.quantile((numerator @ counts) / (denominator @ counts), [0.025, 0.975], axis=-1)


def mild(rng, shape):
    """Quotients independent of mildly unequal weights; the true value is 2."""
    weight = np.exp(0.5 * rng.normal(size=shape))
    return weight * (2 + 0.5 * rng.normal(size=shape)), weight, 2.0


def strong(rng, shape):
    """Log-normal weights, with larger quotients where the weight is larger: few sequences decide."""
    first, second = rng.normal(size=(2, *shape))
    a, b = 0.35, 0.35
    return np.exp(first + a * first + b * second), np.exp(first), np.exp(((1 + a) ** 2 + b**2 - 1) / 2)


# How many of 2000 intervals of 95 % hold the true value. Measured here: mild .939 and .951, strong .81 and .87, where
# percentiles hold it in .87 and .93, .57 and .73.
@pytest.mark.parametrize(
    ("kind", "n", "range_", "gain"),
    [(mild, 8, (0.93, 0.965), 0.04), (mild, 32, (0.93, 0.965), 0.005), (strong, 8, (0.78, 0.85), 0.2),
     (strong, 32, (0.84, 0.9), 0.1)],
)  # fmt: skip
def test_coverage(kind, n, range_, gain):
    numerator, denominator, true = kind(np.random.default_rng(n), (2000, n))
    low, high = bootstrap_interval(np.abs(numerator), denominator, resamples=999)
    covered = np.mean((low <= true) & (true <= high))
    assert range_[0] <= covered <= range_[1]
    plain_low, plain_high = percentiles(numerator, denominator)
    assert covered > np.mean((plain_low <= true) & (true <= plain_high)) + gain


def test_coverage_of_other_levels():
    numerator, denominator, true = mild(np.random.default_rng(5), (2000, 16))
    for level, range_ in ((0.5, (0.47, 0.53)), (0.8, (0.77, 0.83)), (0.99, (0.975, 0.997))):
        low, high = bootstrap_interval(numerator, denominator, level=level, resamples=999)
        assert range_[0] < np.mean((low <= true) & (true <= high)) < range_[1]


@given(
    seed=st.integers(0, 100),
    n=st.integers(4, 12),
    scales=st.tuples(st.floats(-140, 140), st.floats(-140, 140)),
)
def test_units_do_not_matter(seed, n, scales):
    numerator, denominator = sequences(n, seed)
    one, other = (10.0**scale for scale in scales)
    expected = bootstrap_interval(numerator, denominator, resamples=499)
    scaled = bootstrap_interval(numerator * one, denominator * other, resamples=499)
    np.testing.assert_allclose(np.array(scaled) * (other / one), expected, rtol=1e-9)


@given(seed=st.integers(0, 100), n=st.integers(2, 12))
def test_levels_are_nested_and_never_negative(seed, n):
    numerator, denominator = sequences(n, seed)
    ends = [
        bootstrap_interval(numerator, denominator, level=level, resamples=499)
        for level in (1e-300, 0.1, 0.5, 0.8, 0.95, 0.999, np.nextafter(1, 0))
    ]
    low, high = np.array(ends).T
    assert (low[1:] <= low[:-1]).all()
    assert (high[1:] >= high[:-1]).all()
    assert (low >= 0).all()
    assert not np.isnan(ends).any()


def test_the_seed_decides():
    numerator, denominator = sequences(8)
    assert bootstrap_interval(numerator, denominator) == bootstrap_interval(numerator, denominator, seed=0)
    assert bootstrap_interval(numerator, denominator) != bootstrap_interval(numerator, denominator, seed=1)


@pytest.mark.parametrize("n", [1, 2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_too_few_sequences_tell_nothing(n, seed):
    assert bootstrap_interval(*sequences(n, seed)) == (0.0, np.inf)


@pytest.mark.parametrize("seed", range(5))
def test_four_sequences_tell_something(seed):
    assert np.isfinite(bootstrap_interval(*sequences(4, seed))).all()


@given(weights=st.lists(st.floats(0.01, 100), min_size=2, max_size=20), value=st.floats(0, 1e3))
def test_equal_quotients_leave_no_doubt(weights, value):
    weights = np.array(weights)
    np.testing.assert_allclose(bootstrap_interval(value * weights, weights), (value, value), rtol=1e-12, atol=1e-300)


@pytest.mark.parametrize("spread", [1e-9, 1e-6, 1e-3])
def test_quotients_that_differ_little_leave_little_doubt(spread):
    numerator, denominator = sequences(8)
    low, high = bootstrap_interval(numerator, denominator)
    closer = 2 * denominator + spread * (numerator - 2 * denominator)
    expected = 2 + spread * (low - 2), 2 + spread * (high - 2)
    np.testing.assert_allclose(bootstrap_interval(closer, denominator), expected, rtol=0, atol=1e-5 * spread)


@given(seed=st.integers(0, 100), n=st.integers(1, 8), data=st.data())
def test_sequences_without_weight_do_not_count(seed, n, data):
    numerator, denominator = sequences(n, seed)
    places = data.draw(st.lists(st.integers(0, n), min_size=1, max_size=6))
    with_empty = [np.insert(array, places, 0.0) for array in (numerator, denominator)]
    assert bootstrap_interval(*with_empty, resamples=199) == bootstrap_interval(numerator, denominator, resamples=199)


@pytest.mark.parametrize("n", [1, 3, 9])
def test_many_at_once_equal_one_by_one(n):
    numerator, denominator = (np.stack(some).reshape(2, 3, n) for some in zip(*map(sequences, [n] * 6), strict=True))
    numerator *= np.arange(1, 7).reshape(2, 3, 1)
    numerator[0, 1] = 0.0
    low, high = bootstrap_interval(numerator, denominator, resamples=499)
    assert low.shape == high.shape == (2, 3)
    for index in np.ndindex(2, 3):
        alone = bootstrap_interval(numerator[index], denominator[index], resamples=499)
        np.testing.assert_allclose((low[index], high[index]), alone, rtol=1e-9)
    assert (low[0, 1], high[0, 1]) == ((0.0, 0.0) if n > 1 else (0.0, np.inf))


def test_blocks_change_nothing(monkeypatch):
    numerator, denominator = sequences(9)
    expected = bootstrap_interval(numerator, denominator, resamples=1000)
    monkeypatch.setattr(_bootstrap, "_BLOCK", 100)
    np.testing.assert_allclose(bootstrap_interval(numerator, denominator, resamples=1000), expected, rtol=1e-9)


def test_inputs_are_not_modified():
    both = sequences(8)
    copies = [array.copy() for array in both]
    bootstrap_interval(*both)
    np.testing.assert_array_equal(both, copies)


@pytest.mark.parametrize("level", [0, 1, -0.5, 95, float("nan"), float("inf")])
def test_invalid_levels(level):
    with pytest.raises(ValueError, match=r"^level: expected a number between 0 and 1, got"):
        checked_level(level)


@pytest.mark.parametrize("level", [None, "0.95", True, 0.5j, [0.95]])
def test_levels_of_another_type(level):
    with pytest.raises(TypeError, match=r"^level: expected a number between 0 and 1, got"):
        checked_level(level)


def test_invalid_seeds():
    for seed in (None, 1.0, "1", True, [1]):
        with pytest.raises(TypeError, match=r"^seed: expected a whole number or a numpy\.random\.Generator, got"):
            bootstrap_interval(*sequences(4), seed=seed)
    with pytest.raises(ValueError, match=r"^seed: expected a whole number >= 0, got -1"):
        bootstrap_interval(*sequences(4), seed=-1)
