"""The interval of a ratio of two errors."""

import numpy as np
import pytest

import npss


def test_it_is_paired():
    """Errors that vary a lot, but together, have a certain ratio."""
    b = np.random.default_rng(0).lognormal(sigma=2, size=30)
    assert npss.ratio_interval(0.8 * b, b) == pytest.approx((0.8, 0.8))


def test_it_holds_the_ratio_and_shrinks_with_more_blocks():
    rng = np.random.default_rng(1)
    widths = []
    for n in (20, 500):
        b = rng.uniform(1, 2, n)
        a = b * rng.uniform(0.6, 1.0, n)
        low, high = npss.ratio_interval(a, b)
        assert low < a.sum() / b.sum() < high
        widths.append(high - low)
    assert widths[1] < widths[0] / 3


def test_sequences_of_a_block_count_as_one():
    """Copies of a sequence in its block add nothing."""
    rng = np.random.default_rng(2)
    a, b = rng.uniform(1, 2, (2, 15))
    copies = [np.repeat(values / 4, 4) for values in (a, b)]
    once, four_times = npss.ratio_interval(a, b), npss.ratio_interval(*copies, groups=np.repeat(range(15), 4))
    assert once == pytest.approx(four_times)


def test_few_blocks_give_a_range():
    assert npss.ratio_interval([1, 3], [2, 2]) == npss.Range(0.5, 1.5)


@pytest.mark.parametrize(
    ("a", "b", "groups", "message"),
    [
        ([1, 2], [1], None, "b: expected 2 errors"),
        ([1, -2], [1, 1], None, "a: expected errors of at least 0, got -2 at 1"),
        ([1, 2], [1, np.nan], None, "b: "),
        ([[1, 2]], [1, 2], None, "a: expected shape"),
        ([1, 2], [0, 0], None, "groups: no sequence"),
        ([1, 2], [1, 1], ["x"], "groups: expected 2 labels"),
    ],
)
def test_bad_input_is_refused(a, b, groups, message):
    with pytest.raises(ValueError, match=message):
        npss.ratio_interval(a, b, groups=groups)
