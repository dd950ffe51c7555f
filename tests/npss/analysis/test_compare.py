"""Comparisons: the test against scipy and brute force, error rates by simulation, and invalid input."""

import copy
import pickle
import tracemalloc
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

import npss
import oracles
from npss._analysis import sign_flip as _sign_flip
from npss._analysis.blocks import INFERRED
from npss._analysis.sign_flip import EXACT_UP_TO, SAMPLES, sign_flips
from npss._metric.euler_error import sequence_errors
from refused import REFUSED_TYPES, REFUSED_VALUES


def motions(n=8, n_frames=25, d=3, seed=0):
    """Return a ground truth and two predictions of it."""
    return np.random.default_rng(seed).normal(size=(3, n, n_frames, d)).cumsum(axis=2)


def differences(n, seed=0, mean=0.0):
    """Return differences of sequences, symmetric about `mean` times their weights, which are unequal."""
    rng = np.random.default_rng(seed)
    weight = np.exp(rng.normal(size=n))
    return weight * (mean + rng.normal(size=n)), weight


def brute_force(difference):
    """Return the share of all exchanges that are as extreme, two-sided."""
    signs = np.array(list(product((1, -1), repeat=len(difference))))
    sums = np.abs(signs @ difference)
    return np.mean(sums >= np.abs(difference.sum()) - 1e-13 * np.abs(difference).sum())


def simulated(n, count, mean=0.0, levels=(0.95,)):
    """Return p-values and intervals of many comparisons with symmetric differences."""
    flips = [sign_flips(*differences(n, seed, mean)) for seed in range(count)]
    return np.array([flip.p_value() for flip in flips]), [[f.interval(level) for level in levels] for f in flips]


# --- the p-value ------------------------------------------------------------------------------------------------------


@settings(max_examples=25)
@given(
    differences=st.lists(st.integers(-6, 6), min_size=2, max_size=9),  # ties, zeros
    factor=st.sampled_from([1.0, 0.1, 1e-8, 1e200, 1 / 3]),
)
def test_p_value_equals_scipy_s(differences, factor):
    difference = np.array(differences) * factor
    weight = np.full(len(difference), factor)
    expected = stats.permutation_test(
        (np.array(differences, float), np.zeros(len(difference))),
        lambda x, y, axis: (x - y).sum(axis=axis),
        permutation_type="samples",
        n_resamples=np.inf,
        vectorized=True,
    )
    flips = sign_flips(difference, weight)
    assert flips.exact
    assert flips.p_value() == pytest.approx(expected.pvalue)


@settings(max_examples=40)
@given(n=st.integers(2, 10), seed=st.integers(0, 10_000), spread=st.sampled_from([0.0, 1.0, 5.0]))
def test_p_is_that_of_all_exchanges_whatever_the_weights(n, seed, spread):
    rng = np.random.default_rng(seed)
    weight = np.exp(spread * rng.normal(size=n))
    difference = weight * (rng.normal(size=n) + 0.5)
    assert sign_flips(difference, weight).p_value() == pytest.approx(brute_force(difference))


@pytest.mark.parametrize("convention", npss.CONVENTIONS)
def test_p_of_motion_is_that_of_all_exchanges(convention):
    gt, one, other = motions()
    gt *= np.exp(np.random.default_rng(1).normal(size=(8, 1, 1)))
    comparison = npss.compare(gt, one, other, convention=convention)
    scores = []
    for swapped in product((False, True), repeat=8):  # of whole predictions, not of sums
        where = np.array(swapped)[:, np.newaxis, np.newaxis]
        pair = np.where(where, other, one), np.where(where, one, other)
        first, second = (npss.score(gt, pred, convention=convention) for pred in pair)
        scores.append(abs(first - second))
    assert comparison.p_value == pytest.approx(np.mean(np.array(scores) >= scores[0] * (1 - 1e-9)))
    assert 0.02 < comparison.p_value < 1


@pytest.mark.parametrize("mean", [0.0, 0.3, 0.6])
def test_p_of_drawn_exchanges_is_close_to_that_of_all(mean):
    difference, weight = differences(20, seed=5, mean=mean)
    signs = np.array(list(product((1, -1), repeat=10)))
    halves = signs @ difference[:10], signs @ difference[10:]
    sums = np.abs(np.add.outer(*halves))  # all 2**20 exchanges
    expected = np.mean(sums >= np.abs(difference.sum()) * (1 - 1e-12))
    flips = sign_flips(difference, weight)
    assert not flips.exact
    assert len(flips.low) == SAMPLES + 1
    assert abs(flips.p_value() - expected) < 4 * np.sqrt(expected * (1 - expected) / SAMPLES) + 1 / SAMPLES
    assert sign_flips(difference, weight, seed=0).p_value() == flips.p_value()
    others = {sign_flips(difference, weight, seed=seed).p_value() for seed in range(4)}
    assert len(others) > 1


def test_exchanges_drawn_at_random_have_the_distribution_of_all(monkeypatch):
    difference, weight = np.array([0.5, -0.2, 0.9, 0.3]), np.ones(4)
    exact = sign_flips(difference, weight)
    monkeypatch.setattr(_sign_flip, "EXACT_UP_TO", 1)
    drawn = sign_flips(difference, weight)  # one in eight exchanges all blocks or none
    assert not drawn.exact
    assert np.isinf(drawn.low).mean() == pytest.approx(1 / 8, abs=4 * (7 / 64 / SAMPLES) ** 0.5)
    p = exact.p_value()
    assert drawn.p_value() == pytest.approx(p, abs=4 * (p * (1 - p) / SAMPLES) ** 0.5)


@pytest.mark.parametrize("n", [EXACT_UP_TO, EXACT_UP_TO + 1, 60])
def test_p_is_never_zero(n):
    flips = sign_flips(np.ones(n), np.ones(n))
    assert flips.exact == (n <= EXACT_UP_TO)
    if flips.exact:
        assert flips.p_value() == 2 / 2**n
    else:  # what was seen is one of the exchanges
        assert flips.p_value() == pytest.approx(2 / 2**n + 1 / (SAMPLES + 1), abs=2 / SAMPLES)
        assert flips.p_value() >= 1 / (SAMPLES + 1)


def test_drawn_exchanges_in_blocks(monkeypatch):
    both = differences(40, seed=2, mean=0.2)
    expected = sign_flips(*both)
    expected_exact = sign_flips(*differences(9))
    monkeypatch.setattr(_sign_flip, "_BLOCK", 333)
    again = sign_flips(*both)  # other draws
    assert len(again.low) == len(expected.low)
    assert again.p_value() == pytest.approx(expected.p_value(), abs=0.03)
    np.testing.assert_allclose(again.interval(0.8), expected.interval(0.8), rtol=0, atol=0.05)
    exact = sign_flips(*differences(9))
    np.testing.assert_allclose(exact.low, expected_exact.low)
    assert exact.p_value() == expected_exact.p_value()


def test_many_sequences_take_little_memory():
    tracemalloc.start()
    try:
        sign_flips(*differences(2000))
        assert tracemalloc.get_traced_memory()[1] < 50e6  # all choices at once would take 160 MB, and again
    finally:
        tracemalloc.stop()


def test_rounding_does_not_decide():
    # By any scale of a prediction, NPSS is the same: what differs is rounding.
    gt, pred, _ = motions()
    for other in (3 * pred, -0.1 * pred, pred.astype(np.longdouble) * 7):
        comparison = npss.compare(gt, pred, other)
        assert (comparison.p_value, comparison.interval()) == (1.0, (0.0, 0.0))
    # Sums that are zero but for rounding are ties.
    tied = np.array([0.1, 0.2, -0.3, 0.7, -0.7, 1.1])
    assert sign_flips(tied, np.ones(6)).p_value() == brute_force(np.round(10 * tied)) == 18 / 32


# --- what it promises -------------------------------------------------------------------------------------------------


def test_p_values_are_uniform_for_equally_good_models():
    n, count = 8, 2000
    p_values, _ = simulated(n, count)
    steps = np.arange(1, 2 ** (n - 1) + 1) / 2 ** (n - 1)
    share = (p_values[:, np.newaxis] <= steps + 1e-12).mean(axis=0)
    assert (np.abs(share - steps) <= 4.5 * np.sqrt(steps * (1 - steps) / count)).all()


def test_p_values_of_motion_are_never_too_small():
    rng = np.random.default_rng(8)
    p_values = []
    for _ in range(300):
        gt = rng.normal(size=(6, 10, 2)).cumsum(axis=1)
        good, bad = gt + 0.1 * rng.normal(size=gt.shape), rng.normal(size=gt.shape)
        deal = rng.random((6, 1, 1)) < 0.5  # which model is which, sequence by sequence
        p_values.append(npss.compare(gt, np.where(deal, good, bad), np.where(deal, bad, good)).p_value)
    for step in np.arange(1, 32) / 32:
        assert np.mean(np.array(p_values) <= step) < step + 4 * np.sqrt(step * (1 - step) / 300)


@pytest.mark.parametrize(("n", "covers"), [(6, 1 - 1 / 32), (8, 1 - 6 / 128), (12, 1 - 102 / 2048)])
def test_intervals_cover_at_their_level_for_any_weights(n, covers):
    _, intervals = simulated(n, 1500, mean=0.7)
    low, high = np.array(intervals)[:, 0].T
    covered = np.mean((low <= 0.7) & (high >= 0.7))
    assert covers >= 0.95
    assert abs(covered - covers) < 4 * np.sqrt(covers * (1 - covers) / 1500)
    assert abs(np.mean(low > 0.7) - np.mean(high < 0.7)) < 0.02


def test_intervals_from_drawn_exchanges_cover_as_often(monkeypatch):
    monkeypatch.setattr(_sign_flip, "SAMPLES", 199)
    _, intervals = simulated(20, 1500, mean=-2.0, levels=(0.8, 0.95))
    for level, (low, high) in zip((0.8, 0.95), np.array(intervals).transpose(1, 2, 0), strict=True):
        assert abs(np.mean((low <= -2) & (high >= -2)) - level) < 4 * np.sqrt(level * (1 - level) / 1500)


def test_equal_scores_are_not_enough():
    """Differences that sum to zero, but are skewed or go with the weight, are called different too often."""
    rng = np.random.default_rng(4)
    count = 1000

    def too_often(difference, weight):
        return np.mean([sign_flips(*one).p_value() <= 0.05 for one in zip(difference, weight, strict=True)])

    skewed = np.exp(rng.normal(size=(count, 8))) - np.exp(0.5)
    assert 0.1 < too_often(skewed, np.ones_like(skewed)) < 0.2  # measured: 0.16
    size = rng.normal(size=(count, 8))
    weight = np.exp(size)
    assert 0.3 < too_often(weight * (size - 1), weight) < 0.5  # measured: 0.37; E[weight * (size - 1)] = 0


# --- the interval -----------------------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(n=st.integers(2, 9), seed=st.integers(0, 10_000), level=st.sampled_from([0.5, 0.9, 0.95, 0.99]))
def test_the_interval_holds_the_differences_not_rejected(n, seed, level):
    difference, weight = differences(n, seed, mean=0.5)
    low, high = sign_flips(difference, weight).interval(level)
    for delta in [*np.linspace(-4, 5, 37), low - 1e-6, low + 1e-6, high - 1e-6, high + 1e-6]:
        if np.isfinite(delta):
            kept = brute_force(difference - delta * weight) > 1 - level + 1e-9
            assert kept == (low <= delta <= high)


@given(
    n=st.integers(2, 12),
    seed=st.integers(0, 10_000),
    ties=st.booleans(),
    level=st.one_of(st.sampled_from([0.5, 0.8, 0.9, 0.95, 0.99]), st.floats(0.01, 0.99)),
)
def test_zero_is_excluded_if_and_only_if_p_is_small(n, seed, ties, level):
    difference, weight = differences(n, seed, mean=1.0)
    if ties:
        difference, weight = np.round(2 * difference) / 10, np.ones(n)
    flips = sign_flips(difference, weight)
    low, high = flips.interval(level)
    assert (low > 0 or high < 0) == (flips.p_value() <= 1 - level + 1e-12)


@given(n=st.integers(2, 20), seed=st.integers(0, 10_000))
def test_intervals_are_nested_about_the_difference(n, seed):
    difference, weight = differences(n, seed)
    flips = sign_flips(difference, weight)
    levels = (1e-300, 1e-13, 0.1, 0.5, 0.9, 0.95, 0.99, np.nextafter(1, 0))
    low, high = np.array([flips.interval(level) for level in levels]).T
    assert (low[1:] <= low[:-1]).all()
    assert (high[1:] >= high[:-1]).all()
    value = difference.sum() / weight.sum()
    assert low[0] - 1e-9 <= value <= high[0] + 1e-9
    assert (low[-1], high[-1]) == (-np.inf, np.inf)


def test_intervals_need_six_sequences():
    for n in range(2, 9):
        low, high = sign_flips(*differences(n)).interval(0.95)
        assert np.isfinite(low) == np.isfinite(high) == (n >= 6)


# --- of motion --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("convention", [*npss.CONVENTIONS, npss.Convention(bins="one-sided")])
def test_scores_are_those_of_score(convention):
    gt, one, other = motions()
    comparison = npss.compare(gt, one, other, convention=convention)
    assert comparison.a == npss.score(gt, one, convention=convention)
    assert comparison.b == npss.score(gt, other, convention=convention)
    assert comparison.difference == comparison.a - comparison.b
    assert (comparison.n, comparison.exact) == (8, True)
    low, high = comparison.interval()
    assert low < comparison.difference < high
    assert comparison.signature == npss.signature(convention, frames=25)
    for value in (comparison.a, comparison.b, comparison.difference, comparison.p_value, low, high):
        assert type(value) is float


def test_euler_errors_are_those_of_euler_error():
    gt, one, other = motions()
    for time in (80, 1000, 40.0):
        comparison = npss.compare(gt, one, other, metric="euler_error", fps=25, at_ms=time)
        assert comparison.a == pytest.approx(npss.euler_error(gt, one, at_ms=(time,))[time], rel=1e-14)
        assert comparison.b == pytest.approx(npss.euler_error(gt, other, at_ms=(time,))[time], rel=1e-14)
    errors = [sequence_errors(gt, pred)[:, 0] for pred in (one, other)]
    assert comparison.p_value == pytest.approx(brute_force(errors[0] - errors[1]))
    assert npss.parse_signature(comparison.signature) == {
        "metric": "euler_error", "version": npss.METRIC_VERSION, "convention": None, "frames": 25, "fps": 25,
        "at_ms": 40, "columns": "gt", "average": "at",
    }  # fmt: skip


@pytest.mark.parametrize("columns", ["gt", "pred", "all"])
def test_sequence_errors_are_those_of_each_sequence(columns):
    gt, pred, _ = motions(n=4, n_frames=6)
    gt[1, :, 0] = 0.3  # does not move
    pred[2] = 0.0
    errors = sequence_errors(gt, pred, columns=columns)
    expected = [oracles.euler_curve(gt[i : i + 1], pred[i : i + 1], columns) for i in range(4)]
    np.testing.assert_allclose(errors, expected, rtol=1e-12)
    np.testing.assert_allclose(errors.mean(axis=0), npss.euler_error_curve(gt, pred, columns=columns), rtol=1e-12)
    np.testing.assert_array_equal(errors[3:], sequence_errors(gt[3], pred[3], columns=columns))


def test_sequence_errors_of_many_and_of_large_values():
    gt, pred, _ = motions(n=300, n_frames=100)  # more than one block
    errors = sequence_errors(gt, pred)
    np.testing.assert_allclose(errors.mean(axis=0), npss.euler_error_curve(gt, pred), rtol=1e-12)
    np.testing.assert_array_equal(errors[250], npss.euler_error_curve(gt[250], pred[250]))
    np.testing.assert_allclose(sequence_errors(gt * 1e200, pred * 1e200), errors * 1e200, rtol=1e-12)
    with pytest.raises(ValueError, match=r"^pred: its difference from gt is beyond"):
        sequence_errors(gt, np.full_like(gt, 1.7e308))
    with pytest.raises(ValueError, match=r"^columns: "):
        sequence_errors(gt, pred, columns="none")


@pytest.mark.parametrize("options", [{}, {"metric": "euler_error", "fps": 25, "at_ms": 400}])
@pytest.mark.parametrize("n", [7, 18])
def test_exchanging_the_models_changes_only_the_sign(options, n):
    gt, one, other = motions(n=n)
    first, second = npss.compare(gt, one, other, **options), npss.compare(gt, other, one, **options)
    assert (first.a, first.b) == (second.b, second.a)
    assert first.difference == -second.difference
    assert first.p_value == second.p_value
    for level in (0.5, 0.95):
        assert first.interval(level=level) == pytest.approx([-end for end in second.interval(level=level)[::-1]])


@pytest.mark.parametrize("n", [2, 6, 17])
def test_a_model_is_as_good_as_itself(n):
    gt, pred, _ = motions(n=n)
    comparison = npss.compare(gt, pred, pred)
    assert (comparison.difference, comparison.p_value, comparison.better) == (0.0, 1.0 if n >= 6 else None, 0)
    assert comparison.interval() == ((0.0, 0.0) if n >= 6 else (-np.inf, np.inf))


def test_the_better_model_is_found():
    gt, noise, _ = motions()
    comparison = npss.compare(gt, gt + 0.1 * noise, noise)
    assert comparison.difference < 0
    assert comparison.p_value == 2 / 2**8
    assert comparison.interval()[1] < 0


def test_sequences_without_weight_do_not_count():
    gt, one, other = motions(n=10)
    gt[[2, 9]] = 0
    counted = [0, 1, 3, 4, 5, 6, 7, 8]
    comparison, alone = npss.compare(gt, one, other), npss.compare(*(x[counted] for x in (gt, one, other)))
    assert comparison.n == alone.n == 8
    assert (comparison.difference, comparison.p_value) == (alone.difference, alone.p_value)
    assert comparison.interval() == alone.interval()
    assert f"over 8 blocks, all {2**8} exchanges" in str(comparison)
    gt[counted[1:]] = 0
    lonely = npss.compare(gt, one, other)
    assert (lonely.n, lonely.p_value, lonely.interval()) == (1, None, (-np.inf, np.inf))
    assert "fewer than 6 blocks give no p-value" in str(lonely)


@pytest.mark.parametrize("options", [{}, {"metric": "euler_error", "fps": 25, "at_ms": 400}])
def test_blocks_are_exchanged_as_a_whole(options):
    gt, one, other = motions(n=20)
    groups = [*"aabbccddeeffgg", "h", None, None, "a", "b", "h"]
    comparison = npss.compare(gt, one, other, groups=groups, **options)
    values = []
    for swapped in product((False, True), repeat=8):
        where = np.array([label is not None and swapped["abcdefgh".index(label)] for label in groups])
        where = where[:, np.newaxis, np.newaxis]
        inside = [label is not None for label in groups]
        pair = np.where(where, other, one)[inside], np.where(where, one, other)[inside]
        if options:
            values.append([npss.euler_error(gt[inside], pred, at_ms=(400,))[400] for pred in pair])
        else:
            values.append([npss.score(gt[inside], pred) for pred in pair])
    differences_ = np.array([first - second for first, second in values])
    assert comparison.p_value == pytest.approx(np.mean(np.abs(differences_) >= np.abs(differences_[0]) * (1 - 1e-9)))
    assert (comparison.a_in_blocks, comparison.b_in_blocks) == pytest.approx(values[0], rel=1e-9)
    whole = npss.compare(gt, one, other, **options)
    assert (comparison.a, comparison.b, whole.n, comparison.n) == (whole.a, whole.b, 20, 8)
    assert comparison.difference == comparison.a_in_blocks - comparison.b_in_blocks != whole.difference
    low, high = comparison.interval()
    assert low < comparison.difference < high
    text = str(comparison)
    assert text.startswith(f"{whole.a:.4f} and {whole.b:.4f}; in blocks {values[0][0]:.4f} - {values[0][1]:.4f} = ")
    assert "8 blocks, 2 of 20 sequences in none" in text


def test_fewer_than_six_blocks_give_no_p_value():
    gt, one, other = motions(n=10)
    groups = [*"aabbccddee"]
    comparison = npss.compare(gt, one, other, groups=groups)
    better = sum(
        npss.score(gt[i : i + 2], one[i : i + 2]) < npss.score(gt[i : i + 2], other[i : i + 2]) for i in range(0, 10, 2)
    )
    assert (comparison.n, comparison.better, comparison.p_value) == (5, better, None)
    for level in (0.5, 0.8, 0.95):
        assert comparison.interval(level=level) == (-np.inf, np.inf)
    assert str(comparison).splitlines()[:2] == [
        f"{comparison.a:.4f} - {comparison.b:.4f} = {comparison.difference:.4f}, "
        f"the first is better in {better} of 5 blocks",
        "  fewer than 6 blocks give no p-value",
    ]
    with pytest.raises(ValueError, match=r"^level: "):
        comparison.interval(level=95)
    six = npss.compare(gt, one, other, groups=[*"aabbccddef"])
    assert six.p_value >= 2 / 2**6


def test_invalid_groups():
    for groups, error, message in (
        ([1.5] * 8, TypeError, "groups: expected text, a whole number, or None for no block, got 1.5 at 0"),
        (["a"] * 7, ValueError, "groups: expected 8 labels, one for each sequence, got 7"),
        ([None] * 8, ValueError, "groups: no sequence is in a block"),
    ):
        with pytest.raises(error, match=f"^{message}"):
            npss.compare(*motions(), groups=groups)


@pytest.mark.parametrize("scale", [2.0**-400, 2.0**400])
def test_units_do_not_matter(scale):
    expected, scaled = npss.compare(*motions()), npss.compare(*(motions() * scale))
    assert str(scaled) == str(expected)
    assert scaled.interval() == expected.interval()


def test_the_seed_draws_the_exchanges():
    gt, one, other = motions(n=20, seed=3)
    p_values = [npss.compare(gt, one, other, seed=seed).p_value for seed in (0, 0, 1, 2)]
    assert p_values[0] == p_values[1]
    assert len(set(p_values)) > 1
    few = [npss.compare(gt[:8], one[:8], other[:8], seed=seed) for seed in (0, 1)]
    assert few[0].p_value == few[1].p_value


def test_the_text_has_a_verdict():
    gt, one, other = motions(n=12)
    near = gt + 0.01 * (one - gt)
    assert "\n  the first is worse: the difference is more than noise\n" in str(npss.compare(gt, other, near))
    assert "\n  undecided: noise alone makes" in str(npss.compare(gt, one, one))
    assert "\n  the first is better: " in str(npss.compare(gt, near, other, metric="euler_error", at_ms=80, fps=25))


def test_the_text_has_the_numbers_and_their_meaning():
    gt, one, other = motions()
    comparison = npss.compare(gt, one, other, fps=25, representation="euler")
    low, high = comparison.interval()
    assert str(comparison).splitlines() == [
        f"{comparison.a:.4f} - {comparison.b:.4f} = {comparison.difference:.4f}, {low:.4f} to {high:.4f} (95 %), "
        f"p = {comparison.p_value:.3g}, the first is better in {comparison.better} of 8 blocks",
        "  undecided: noise alone makes such a difference in more than 5 % of cases",
        "  two-sided sign-flip test over 8 blocks, all 256 exchanges; interval: the differences not rejected",
        f"  the first: {npss.report(gt, one).parts}",
        f"  the second: {npss.report(gt, other).parts}",
        "  8 sequences, each its own block, assumed independent",
        f"  {INFERRED}",
        f"  {npss.signature(representation='euler', frames=25, fps=25)}",
    ]
    assert repr(comparison).startswith(f"Comparison(a={comparison.a!r}, b={comparison.b!r}, p_value=")
    assert "over 17 blocks, 9999 random exchanges" in str(npss.compare(*motions(n=17)))


@pytest.mark.parametrize("convention", [*npss.CONVENTIONS, npss.Convention(bins="one-sided")])
def test_the_parts_are_those_of_each_prediction(convention):
    gt, one, other = motions()
    comparison = npss.compare(gt, one, other, convention=convention)
    assert comparison.a_parts == npss.report(gt, one, convention=convention).parts
    assert comparison.b_parts == npss.report(gt, other, convention=convention).parts


def test_only_npss_has_parts():
    comparison = npss.compare(*motions(), metric="euler_error", fps=25, at_ms=80)
    assert comparison.a_parts is comparison.b_parts is None
    assert "share of DC" not in str(comparison)


def test_a_comparison_can_be_pickled_and_is_frozen():
    comparison = npss.compare(*motions())
    with pytest.raises(AttributeError):
        comparison.p_value = 0.0
    for other in (copy.deepcopy(comparison), pickle.loads(pickle.dumps(comparison))):
        assert str(other) == str(comparison)


# --- what it refuses --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("options", [{}, {"metric": "euler_error", "fps": 25, "at_ms": 80}])
class TestRefused:
    @pytest.fixture
    def motion(self):
        return list(motions(n=2, n_frames=4))

    @pytest.mark.parametrize("which", range(3))
    def test_types(self, options, motion, which):
        name = ("gt", "pred_a", "pred_b")[which]
        for bad in REFUSED_TYPES.values():
            motion[which] = bad
            with pytest.raises(TypeError, match=rf"^{name}: "):
                npss.compare(*motion, **options)

    @pytest.mark.parametrize("which", range(3))
    def test_shapes(self, options, motion, which):
        name = ("gt", "pred_a", "pred_b")[which]
        for bad, message in REFUSED_VALUES.values():
            motion[which] = bad
            with pytest.raises(ValueError, match=rf"^{name}: {message}"):
                npss.compare(*motion, **options)

    @pytest.mark.parametrize("which", range(3))
    @pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
    def test_values(self, options, motion, which, bad):
        motion[which][1, 2, 0] = bad
        with pytest.raises(ValueError, match=rf"^{('gt', 'pred_a', 'pred_b')[which]}: {bad} at index \(1, 2, 0\)"):
            npss.compare(*motion, **options)

    @pytest.mark.parametrize("which", [1, 2])
    def test_other_shapes(self, options, motion, which):
        for other in ((2, 4, 1), (1, 4, 3), (3, 4, 3), (2, 5, 3), (4, 3)):
            motion[which] = np.ones(other)
            with pytest.raises(ValueError, match=rf"^pred_{'ab'[which - 1]}: its shape .* differs from that of gt"):
                npss.compare(*motion, **options)

    def test_single_sequences(self, options, motion):
        for cut in (np.s_[0], np.s_[:1]):
            with pytest.raises(ValueError, match=r"^gt: expected shape \(N, T, D\) with N >= 2 sequences to pair"):
                npss.compare(*(x[cut] for x in motion), **options)

    @pytest.mark.parametrize("seed", [None, 1.0, "0", True, (1,)])
    def test_seeds_of_another_type(self, options, motion, seed):
        with pytest.raises(TypeError, match=r"^seed: expected a whole number"):
            npss.compare(*motion, seed=seed, **options)

    def test_negative_seeds(self, options, motion):
        with pytest.raises(ValueError, match=r"^seed: expected a whole number >= 0"):
            npss.compare(*motion, seed=-1, **options)

    @pytest.mark.parametrize("name", ["frames", "version"])
    def test_what_a_signature_states_anyway(self, options, motion, name):
        with pytest.raises(TypeError, match=rf"^{name}: the signature states it anyway"):
            npss.compare(*motion, **{name: 7}, **options)

    def test_invalid_conventions_and_rates(self, options, motion):
        with pytest.raises(ValueError, match=r"^convention: expected one of"):
            npss.compare(*motion, convention="Paper", **options)
        with pytest.raises(TypeError, match=r"^fps: expected a positive number"):
            npss.compare(*motion, **options | {"fps": "25"})
        with pytest.raises(ValueError, match=r"^fps: expected a positive"):
            npss.compare(*motion, **options | {"fps": -25})

    def test_invalid_levels(self, options, motion):
        comparison = npss.compare(*motion, **options)
        with pytest.raises(ValueError, match=r"^level: "):
            comparison.interval(level=95)
        with pytest.raises(TypeError, match=r"^level: "):
            comparison.interval(level="0.95")

    def test_inputs_are_not_modified(self, options, motion):
        copies = [array.copy() for array in motion]
        npss.compare(*motion, **options)
        np.testing.assert_array_equal(motion, copies)


def test_invalid_metrics():
    with pytest.raises(ValueError, match=r"^metric: unknown metric 'rmse'; known: npss, euler_error, mse"):
        npss.compare(*motions(), metric="rmse")
    with pytest.raises(TypeError, match=r"^metric: expected the name of a metric, got None"):
        npss.compare(*motions(), metric=None)


def test_times_and_metrics_that_do_not_fit():
    with pytest.raises(ValueError, match=r"^at_ms: NPSS covers all frames"):
        npss.compare(*motions(), at_ms=80)
    for given_ in ({}, {"fps": 25}, {"at_ms": 80}):
        with pytest.raises(ValueError, match=r"^at_ms: the Euler error is measured at one time: give fps and at_ms"):
            npss.compare(*motions(), metric="euler_error", **given_)
    for time in (0, 30, 1040, -40):
        with pytest.raises(ValueError, match=rf"^at_ms: {time} ms is .*; nearest: "):
            npss.compare(*motions(), metric="euler_error", fps=25, at_ms=time)
    for time in ("80", (80,), True):
        with pytest.raises(TypeError, match=r"^at_ms: expected a time in ms"):
            npss.compare(*motions(), metric="euler_error", fps=25, at_ms=time)
    for name in ("columns", "average"):
        with pytest.raises(TypeError, match=rf"^{name}: the signature states it anyway"):
            npss.compare(*motions(), metric="euler_error", fps=25, at_ms=80, **{name: "all"})


def test_ground_truth_that_cannot_be_compared_by():
    gt, one, other = motions()
    with pytest.raises(ValueError, match=r"^gt: no power in any feature"):
        npss.compare(np.zeros_like(gt), one, other)
    with pytest.raises(ValueError, match=r"^gt: one frame"):
        npss.compare(gt[:, :1], one[:, :1], other[:, :1])
    for scale in (1e-200, 1e200):
        with pytest.raises(ValueError, match=r"^gt: its power is beyond float64; scale it"):
            npss.compare(gt * scale, one, other)
    gt[3] = 0.5
    with pytest.raises(ValueError, match=r"^gt: no feature of sequence 3 moves"):
        npss.compare(gt, one, other, metric="euler_error", fps=25, at_ms=80)
    with pytest.raises(ValueError, match=r"^pred_b: its difference from gt is beyond"):
        npss.compare(motions()[0], one, np.full_like(gt, 1.7e308), metric="euler_error", fps=25, at_ms=80)


def test_arrays_may_be_named_and_options_have_to_be():
    gt, a, b = np.random.default_rng(0).normal(size=(3, 6, 10, 2))
    assert str(npss.compare(gt=gt, pred_a=a, pred_b=b)) == str(npss.compare(gt, a, b))
    with pytest.raises(TypeError, match="positional"):
        npss.compare(gt, a, b, "npss")


def test_the_default_seed_is_zero():
    gt, a, b = np.random.default_rng(4).normal(size=(3, 20, 10, 2))
    p_values = [npss.compare(gt, a, b, **options).p_value for options in ({}, {"seed": 0}, {"seed": 1})]
    assert p_values[0] == p_values[1] != p_values[2]
