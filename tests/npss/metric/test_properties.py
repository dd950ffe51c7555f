"""Every metric against every property, with or without it.

A property is a check that raises AssertionError. A metric with the property passes on all examples of hypothesis; a
metric without it fails on at least one example. So the checks are tested, too: each fails for some metric.
"""

from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given

import npss
from strategies import pairs

RNG_SEEDS = range(6)


def same(a, b, tolerance=1e-9):
    assert a == pytest.approx(b, rel=tolerance, abs=tolerance), (a, b)


# --- properties: check(metric, gt, pred) ----------------------------------------------------------------------------


def identity_is_zero(metric, gt, pred):
    same(metric(gt, gt), 0.0)


def non_negative(metric, gt, pred):
    assert metric(gt, pred) >= 0


def prediction_scale_and_sign(metric, gt, pred):
    factors = np.random.default_rng(1).choice([-3.0, -1.0, 0.25, 7.0], size=(pred.shape[0], 1, pred.shape[2]))
    same(metric(gt, pred), metric(gt, pred * factors))


def ground_truth_global_scale(metric, gt, pred):
    same(metric(gt, pred), metric(-2.7 * gt, pred))


def ground_truth_scale_per_feature(metric, gt, pred):
    factors = np.random.default_rng(1).choice([-3.0, 0.25, 7.0], size=(gt.shape[0], 1, gt.shape[2]))
    same(metric(gt, pred), metric(gt * factors, pred))


def order_of_sequences(metric, gt, pred):
    order = np.random.default_rng(2).permutation(len(gt))
    same(metric(gt, pred), metric(gt[order], pred[order]))


def order_of_features(metric, gt, pred):
    order = np.random.default_rng(3).permutation(gt.shape[2])
    same(metric(gt, pred), metric(gt[..., order], pred[..., order]))


def circular_shift(metric, gt, pred):
    for shift in (1, 3):
        same(metric(gt, pred), metric(gt, np.roll(pred, shift, axis=1)))
        same(metric(gt, pred), metric(np.roll(gt, shift, axis=1), pred))


def time_reversal(metric, gt, pred):
    same(metric(gt, pred), metric(gt, pred[:, ::-1]))
    same(metric(gt, pred), metric(gt[:, ::-1], pred))


def index_reversal(metric, gt, pred):
    reversed_index = -np.arange(gt.shape[1]) % gt.shape[1]
    same(metric(gt, pred), metric(gt, pred[:, reversed_index]))
    same(metric(gt, pred), metric(gt[:, reversed_index], pred))


def at_most_half_of_the_frames(metric, gt, pred):
    assert metric(gt, pred) <= gt.shape[1] / 2 + 1e-9
    assert metric(gt, np.zeros_like(pred)) <= gt.shape[1] / 2 + 1e-9


def at_most_half_of_the_frames_but_for_zeros(metric, gt, pred):
    pred = np.where((pred == 0).all(axis=1, keepdims=True), 1.0, pred)
    assert metric(gt, pred) <= gt.shape[1] / 2 + 1e-9


def at_most_two(metric, gt, pred):
    assert metric(gt, pred) <= 2 + 1e-9


def symmetric(metric, gt, pred):
    same(metric(gt, pred), metric(pred, gt))


def symmetric_where_all_have_power(metric, gt, pred):
    gt = np.where((gt == 0).all(axis=1, keepdims=True), 1.0, gt)
    pred = np.where((pred == 0).all(axis=1, keepdims=True), 1.0, pred)
    symmetric(metric, gt, pred)


def constant_predictions_are_equal(metric, gt, pred):
    last = np.broadcast_to(pred[:, -1:], pred.shape)
    same(metric(gt, np.where(last == 0, 1.0, last)), metric(gt, np.full_like(pred, -0.3)))


def zero_is_a_constant_prediction(metric, gt, pred):
    same(metric(gt, np.ones_like(pred)), metric(gt, np.zeros_like(pred)))


def prediction_offset(metric, gt, pred):
    same(metric(gt, pred), metric(gt, pred + 5.0))


def common_offset(metric, gt, pred):
    same(metric(gt, pred), metric(gt + 5.0, pred + 5.0))


def repeating_the_set(metric, gt, pred):
    same(metric(gt, pred), metric(np.concatenate([gt, gt]), np.concatenate([pred, pred])))


def repeating_the_features(metric, gt, pred):
    same(metric(gt, pred), metric(np.concatenate([gt, gt], axis=2), np.concatenate([pred, pred], axis=2)))


def mean_of_batches(metric, gt, pred):
    same(metric(gt, pred), np.mean([metric(gt[i : i + 1], pred[i : i + 1]) for i in range(len(gt))]))


def appending_powerless_features(metric, gt, pred):
    zeros = np.zeros_like(gt[..., :1])
    same(metric(gt, pred), metric(np.concatenate([gt, zeros], axis=2), np.concatenate([pred, zeros + 1], axis=2)))


PROPERTIES = {check.__name__: check for check in (
    identity_is_zero, non_negative, prediction_scale_and_sign, ground_truth_global_scale,
    ground_truth_scale_per_feature, order_of_sequences, order_of_features, circular_shift, time_reversal,
    index_reversal, at_most_half_of_the_frames, at_most_half_of_the_frames_but_for_zeros,
    at_most_two, symmetric, symmetric_where_all_have_power,
    constant_predictions_are_equal, zero_is_a_constant_prediction, prediction_offset, common_offset, repeating_the_set,
    repeating_the_features, mean_of_batches, appending_powerless_features,
)}  # fmt: skip


# --- metrics --------------------------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Metric:
    name: str
    function: object
    has: frozenset

    def __call__(self, gt, pred):
        return self.function(gt, pred)


def _npss(convention):
    return lambda gt, pred: npss.score(gt, pred, convention=convention)


def _windows(convention):
    """The sum of the scores of both halves, or the score of the whole if a half has a single frame."""

    def metric(gt, pred):
        n_frames = gt.shape[1]
        edges = (0, n_frames) if n_frames < 4 else (0, n_frames // 2, n_frames)
        edges_ms = [1000 * edge for edge in edges]
        scores = npss.score_windows(gt, pred, fps=1, edges_ms=edges_ms, convention=convention)
        assert list(scores) == [f"{begin}-{end}" for begin, end in pairwise(edges)]
        return sum(scores.values())

    return metric


_ALL_NPSS = frozenset({
    "identity_is_zero", "non_negative", "prediction_scale_and_sign", "ground_truth_global_scale", "order_of_sequences",
    "order_of_features", "index_reversal", "at_most_half_of_the_frames_but_for_zeros", "constant_predictions_are_equal",
    "repeating_the_set", "repeating_the_features", "appending_powerless_features",
})  # fmt: skip
_SHIFTS = {"circular_shift", "time_reversal"}
_DIFFERENCES = frozenset({
    "identity_is_zero", "non_negative", "order_of_sequences", "order_of_features", "repeating_the_set",
    "mean_of_batches",
})  # fmt: skip

METRICS = {metric.name: metric for metric in (
    Metric(
        "paper", _npss("paper"),
        _ALL_NPSS | _SHIFTS | {"at_most_half_of_the_frames", "zero_is_a_constant_prediction"},
    ),
    Metric("released", _npss("released"), _ALL_NPSS),
    Metric(
        "literal", _npss("literal"),
        # Half of the frames does not bound an L1 distance, which can be 2 at T = 2 or 3.
        (_ALL_NPSS | _SHIFTS) - {"at_most_half_of_the_frames_but_for_zeros"}
        | {"at_most_two", "symmetric_where_all_have_power", "zero_is_a_constant_prediction",
           "ground_truth_scale_per_feature"},
    ),
    Metric(
        "one-sided", _npss(npss.Convention(bins="one-sided")),
        # At even T the one-sided distance can be T / 2 and at odd T (T - 1) / 2: never more.
        _ALL_NPSS | _SHIFTS | {"at_most_half_of_the_frames", "zero_is_a_constant_prediction"},
    ),
    Metric(
        "unweighted", _npss(npss.Convention(weight="uniform")),
        _ALL_NPSS | _SHIFTS
        | {"at_most_half_of_the_frames", "zero_is_a_constant_prediction", "ground_truth_scale_per_feature",
           "symmetric_where_all_have_power"},
    ),
    # Shifts and reversals move motion between windows. The bound of the sum is the sum of the bounds.
    Metric(
        "windows, paper", _windows("paper"),
        _ALL_NPSS - {"index_reversal"} | {"at_most_half_of_the_frames", "zero_is_a_constant_prediction"},
    ),
    Metric("windows, released", _windows("released"), _ALL_NPSS - {"index_reversal"}),
    Metric(
        "windows, literal", _windows("literal"),
        _ALL_NPSS - {"index_reversal", "at_most_half_of_the_frames_but_for_zeros"}
        | {"symmetric_where_all_have_power", "zero_is_a_constant_prediction", "ground_truth_scale_per_feature"},
    ),
    Metric(
        "euler_error", lambda gt, pred: npss.euler_error_curve(gt, pred).mean(),
        _DIFFERENCES | {"common_offset", "appending_powerless_features"},
    ),
    Metric(
        "euler_error, all columns", lambda gt, pred: npss.euler_error_curve(gt, pred, columns="all").mean(),
        _DIFFERENCES | {"symmetric", "symmetric_where_all_have_power", "common_offset"},
    ),
    Metric(
        "mse", npss.mse,
        _DIFFERENCES | {"symmetric", "symmetric_where_all_have_power", "common_offset", "repeating_the_features"},
    ),
)}  # fmt: skip

# Mutants: each breaks a property that all metrics of the library have.
MUTANTS = (
    Metric("not zero", lambda gt, pred: npss.score(gt, pred) + 1, frozenset()),
    Metric("negative", lambda gt, pred: -npss.score(gt, pred), frozenset()),
    Metric("first sequence", lambda gt, pred: npss.score(gt[:1], pred[:1]), frozenset()),
    Metric("first feature", lambda gt, pred: npss.mse(gt[..., :1], pred[..., :1]), frozenset()),
    Metric("a sum", lambda gt, pred: npss.mse(gt, pred) * len(gt), frozenset()),
)

CASES = [(metric, name) for metric in METRICS for name in PROPERTIES]


def still_enough(metric, gt):
    """The Euler error refuses sequences in which nothing moves."""
    if metric.name == "euler_error":
        return np.cumsum(np.ones_like(gt), axis=1) + gt
    return gt


def examples():
    for seed in RNG_SEEDS:
        rng = np.random.default_rng(seed)
        shape = (3, 7 + seed, 4)
        gt, pred = rng.normal(size=(2, *shape)).cumsum(axis=2) * 10.0 ** rng.integers(-1, 2, size=(3, 1, 4))
        if seed % 2:
            pred[..., 1] = 0
            gt[..., 2] = 0
            gt[0, :, 3] = 0
        yield gt, pred
    tone = np.cos(np.pi * np.arange(2))[np.newaxis, :, np.newaxis]
    yield np.ones((1, 2, 1)), tone  # literal: a distance of 2 at T = 2
    tone = np.cos(np.pi * np.arange(8))[np.newaxis, :, np.newaxis]
    yield np.ones((1, 8, 1)), tone


@pytest.mark.parametrize(("name", "property_"), [case for case in CASES if case[1] in METRICS[case[0]].has])
@given(pair=pairs(min_t=2))
def test_has(name, property_, pair):
    gt, pred = pair
    metric = METRICS[name]
    PROPERTIES[property_](metric, still_enough(metric, gt), pred)


@pytest.mark.parametrize(("name", "property_"), [case for case in CASES if case[1] not in METRICS[case[0]].has])
def test_has_not(name, property_):
    assert breaks(METRICS[name], property_), f"{name} passes {property_} on every example"


@pytest.mark.parametrize("property_", PROPERTIES)
def test_every_check_can_fail(property_):
    assert any(breaks(metric, property_) for metric in (*METRICS.values(), *MUTANTS))


@pytest.mark.parametrize("property_", sorted(_ALL_NPSS & _DIFFERENCES | {"repeating_the_set"}))
def test_a_mutant_lacks_each_common_property(property_):
    assert any(breaks(mutant, property_) for mutant in MUTANTS)


def test_every_name_is_a_property():
    for metric in METRICS.values():
        assert metric.has <= PROPERTIES.keys()


def breaks(metric, property_):
    for gt, pred in examples():
        try:
            PROPERTIES[property_](metric, still_enough(metric, gt), pred)
        except AssertionError:
            return True
    return False


# --- invariances to the last bit --------------------------------------------------------------------------------------


# Few and many columns; short, prime and long T; several blocks of sequences and of features.
SHAPES = [(4, 2, 3), (7, 9, 5), (60, 30, 13), (5, 100, 54), (3, 257, 20), (6, 1009, 8), (2, 3, 40_000), (700, 25, 60)]


@pytest.mark.numeric
@pytest.mark.parametrize("name", npss.CONVENTIONS)
@pytest.mark.parametrize("huge", [False, True])
@pytest.mark.parametrize("shape", SHAPES)
def test_bitwise_invariances(name, huge, shape):
    rng = np.random.default_rng(shape[1])
    gt, pred = rng.normal(size=(2, *shape)).cumsum(axis=2) * 10.0 ** rng.integers(-3, 4, size=(shape[0], 1, shape[2]))
    gt[0, :, 1] = pred[1, :, 0] = pred[-1, :, 2] = 0
    if huge:
        gt[0, :, 0] *= 1e200
        gt[1, :, 1] *= 1e-200
        gt[-1, :, 0] *= 1e199
        pred[0, :, 2] *= 1e180

    def score(gt, pred):
        return npss.score(gt, pred, convention=name)

    expected = score(gt, pred)
    assert 0 < expected < shape[1]
    for order in (np.arange(shape[0])[::-1], rng.permutation(shape[0])):
        assert score(gt[order], pred[order]) == expected
    for order in (np.arange(shape[2])[::-1], rng.permutation(shape[2])):
        assert score(gt[..., order], pred[..., order]) == expected
    for times in (2, 3):
        assert score(np.tile(gt, (times, 1, 1)), np.tile(pred, (times, 1, 1))) == expected
    still, any_prediction = np.zeros((*shape[:2], 2)), rng.normal(size=(*shape[:2], 2))
    for axis_end in (slice(None), slice(None, None, -1)):  # appended, and prepended
        first, second = ([x, y][axis_end] for x, y in ((gt, still), (pred, any_prediction)))
        assert score(np.concatenate(first, axis=2), np.concatenate(second, axis=2)) == expected


# --- relations between the conventions --------------------------------------------------------------------------------


@given(pair=pairs(special=False))
def test_released_is_paper_of_the_circularly_even_half(pair):
    gt, pred = pair
    index = -np.arange(gt.shape[1]) % gt.shape[1]
    even_gt, even_pred = (x + x[:, index] for x in (gt, pred))
    same(npss.score(gt, pred, convention="released"), npss.score(even_gt, even_pred, convention="paper"))


@given(pair=pairs(special=False))
def test_the_score_of_a_set_is_the_power_weighted_mean_of_its_parts(pair):
    gt, pred = pair
    scores = [npss.score(gt[i], pred[i]) for i in range(len(gt))]
    same(npss.score(gt, pred), np.average(scores, weights=np.square(gt).sum(axis=(1, 2))))


@pytest.mark.parametrize("n_frames", [2, 3, 8, 9, 100])
def test_a_constant_against_a_tone_attains_half_the_frames(n_frames):
    tone = np.cos(2 * np.pi * np.arange(n_frames) / n_frames)[:, np.newaxis]
    same(npss.score(tone, np.ones_like(tone)), n_frames / 2)


@given(pair=pairs())
def test_a_constant_prediction_scores_half_the_frames_times_the_share_that_is_not_dc(pair):
    gt, pred = pair
    power = np.square(np.abs(np.fft.fft(gt, axis=1)))
    share = 1 - power[:, 0].sum() / power.sum()
    same(npss.score(gt, np.ones_like(pred)), gt.shape[1] / 2 * share)
    distinct = power[:, 0] / np.where(power.sum(axis=1) == 0, 1, power.sum(axis=1))
    powered = power.sum(axis=1) > 0
    same(npss.score(gt, np.ones_like(pred), convention="literal"), 2 * np.mean(1 - distinct[powered]))


def test_an_exact_zero_is_beyond_the_bound_of_released_and_almost_zero_is_not():
    gt = np.ones((1, 8, 1))
    assert npss.score(gt, np.zeros_like(gt), convention="released") == 8.0
    same(npss.score(gt, np.full_like(gt, 1e-30), convention="released"), 0.0)


def test_a_wrap_changes_every_convention():
    angle = 3.0 + 0.5 * np.sin(np.arange(50) / 5)[:, np.newaxis]
    wrapped = (angle + np.pi) % (2 * np.pi) - np.pi
    for name in npss.CONVENTIONS:
        assert npss.score(angle, wrapped, convention=name) > 0.01
        same(npss.score(angle, npss.unwrap(wrapped), convention=name), 0.0)
