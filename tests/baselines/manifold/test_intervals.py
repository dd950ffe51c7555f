"""Tests of paired intervals."""

import numpy as np
import pytest

from npss_baselines.manifold.evaluation.intervals import difference_interval


def test_of_means_as_by_the_normal_distribution():
    """With equal denominators and many blocks, the interval is the mean difference and 1.96 standard errors."""
    rng = np.random.default_rng(0)
    first, change = rng.normal(5, 3, 400), rng.normal(0.5, 0.2, 400)
    low, high = difference_interval((first, np.ones(400)), (first + change, np.ones(400)), seed=0)
    error = 1.96 * change.std() / 20
    # Percentiles of 9999 draws: their own errors are some hundredths of the width.
    assert low == pytest.approx(change.mean() - error, abs=0.1 * error)
    assert high == pytest.approx(change.mean() + error, abs=0.1 * error)


def test_resampled_by_loops():
    rng = np.random.default_rng(1)
    sums = rng.uniform(1, 2, (4, 6))
    draws = np.random.default_rng(7).multinomial(6, np.full(6, 1 / 6), size=500)
    expected = []
    for counts in draws:
        a, b, c, d = ((counts * row).sum() for row in sums)
        expected.append(c / d - a / b)
    ends = difference_interval(sums[:2], sums[2:], level=0.5, resamples=500, seed=np.random.default_rng(7))
    assert ends == pytest.approx(tuple(np.quantile(expected, [0.25, 0.75])))


def test_a_method_is_not_different_from_itself():
    pair = np.random.default_rng(0).uniform(1, 2, (2, 5))
    assert difference_interval(pair, pair, seed=0) == (0, 0)


@pytest.mark.parametrize(
    ("second", "options", "error", "message"),
    [
        (([1, 2], [1]), {}, ValueError, "second: expected sums over the same blocks"),
        (([1, 2, 3], [1, 1, 1]), {}, ValueError, "second: expected sums over the same blocks"),
        (([1, 2],), {}, ValueError, "first, second: expected a numerator and a denominator each"),
        (([1, 2], [1, 1]), {"level": 1}, ValueError, "level: expected a number between 0 and 1"),
        (([1, 2], [1, 1]), {"level": "high"}, TypeError, "level: expected a number between 0 and 1"),
        (([1, 2], [1, 1]), {"resamples": 0}, ValueError, "resamples: "),
    ],
)
def test_refused(second, options, error, message):
    with pytest.raises(error, match=f"^{message}"):
        difference_interval(([1, 2], [1, 1]), second, seed=0, **options)
