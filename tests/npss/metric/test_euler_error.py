"""The Euler error and the mean squared error."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss
import oracles
from npss._metric import euler_error as _euler_error
from npss._metric.euler_error import moving_pair
from npss._metric.golden import GOLDEN, golden_pair
from strategies import pairs

pytestmark = pytest.mark.numeric


@pytest.mark.parametrize("columns", ["gt", "pred", "all"])
@given(pair=pairs())
def test_equals_the_definition(columns, pair):
    gt, pred = pair
    gt = gt + np.cumsum(np.ones_like(gt), axis=1)  # every feature moves
    curve = npss.euler_error_curve(gt, pred, columns=columns)
    np.testing.assert_allclose(curve, oracles.euler_curve(gt, pred, columns), rtol=1e-12, atol=1e-12)
    at = npss.euler_error(gt, pred, fps=10, at_ms=(100, 200), columns=columns)
    assert at == pytest.approx({100: curve[0], 200: curve[1]}, rel=1e-15)
    up_to = npss.euler_error(gt, pred, fps=10, at_ms=(100, 200), columns=columns, average="up-to")
    assert up_to == pytest.approx({100: curve[0], 200: curve[:2].mean()}, rel=1e-14)


def test_the_times_of_the_field():
    gt = np.arange(1.0, 26)[:, np.newaxis]  # the error at frame k, counted from 0, is k + 1
    assert npss.euler_error(gt, np.zeros_like(gt)) == {80: 2, 160: 4, 320: 8, 400: 10, 560: 14, 1000: 25}


def test_features_are_selected_per_sequence():
    gt = np.zeros((2, 4, 2))
    gt[0, :, 0] = gt[1, :, 1] = [1.0, 2.0, 3.0, 4.0]
    pred = gt + [3.0, 4.0]
    np.testing.assert_allclose(npss.euler_error_curve(gt, pred), np.full(4, 3.5))
    np.testing.assert_allclose(npss.euler_error_curve(gt, pred, columns="all"), np.full(4, 5.0))


def test_a_constant_prediction_has_no_error_by_the_predictions_mask():
    gt = np.arange(8.0).reshape(4, 2)
    assert not npss.euler_error_curve(gt, np.ones_like(gt), columns="pred").any()


def test_a_still_ground_truth_is_an_error():
    gt = np.ones((3, 4, 2))
    gt[:2] += np.arange(4.0)[:, np.newaxis]
    with pytest.raises(ValueError, match="gt: no feature of sequence 2 moves"):
        npss.euler_error_curve(gt, gt)
    many = np.concatenate([np.tile(gt[:1], (60_000, 1, 1)), gt])  # in a later block
    with pytest.raises(ValueError, match="gt: no feature of sequence 60002 moves"):
        npss.euler_error_curve(many, many)


def shapes(n_frames):
    """Motions of one feature, with a standard deviation of 1 over the frames: from the smallest range to the largest.

    A range of 2 (half of the frames here, half there), or up to sqrt(2 T) (one frame up, one down), and in between.
    """
    half, third, spike, pair = np.zeros((4, n_frames))
    half[: n_frames // 2] = 1.0
    third[:: max(3, n_frames // 3)] = 1.0
    spike[n_frames // 3] = 1.0
    pair[0], pair[-1] = 1.0, -1.0
    return np.stack([motion / motion.std() for motion in (half, third, spike, pair)], axis=-1)


def compared(gt, pred, columns):
    """Return the mask of features in the Euler error, ``(N, D)``; feature d of `pred` differs by ``2**d``."""
    n_features = gt.shape[-1]
    rows = []
    for x, y in zip(gt, pred, strict=True):
        squares = round(npss.euler_error_curve(x, y, columns=columns)[0] ** 2)
        rows.append([bool(squares >> 2 * d & 1) for d in range(n_features)])
    return rows


# Features whose range does not decide, only the standard deviation.
@pytest.mark.parametrize("columns", ["gt", "pred"])
@pytest.mark.parametrize("n_frames", [4, 7, 25, 100])
@pytest.mark.parametrize("offset", [0.0, -2.0])
@pytest.mark.parametrize(("std", "counts"), [(0.3e-4, False), (0.9999e-4, False), (1.0001e-4, True)])
def test_moving_features_by_standard_deviation(columns, n_frames, offset, std, counts):
    borderline = shapes(n_frames) * std + offset
    spans = np.ptp(borderline, axis=0)
    if std > 0.9e-4:
        assert ((spans > 1e-4) & (spans < 1.415e-4 * np.sqrt(n_frames))).all()
    n_features = borderline.shape[1] + 1  # and one that clearly moves
    moving = np.column_stack([borderline, np.arange(n_frames)])[np.newaxis]
    other = moving + 2.0 ** np.arange(n_features)
    if columns == "pred":
        gt, pred = np.array(other), moving
        gt[:, 1:, :-1] += np.arange(1, n_frames)[:, np.newaxis]  # the ground truth moves, and is not used
    else:
        gt, pred = moving, np.array(other)
        pred[:, 1:] += np.arange(1, n_frames)[:, np.newaxis]
    assert compared(gt, pred, columns) == [[counts] * 4 + [True]]
    expected = oracles.euler_curve(gt, pred, columns)
    np.testing.assert_allclose(npss.euler_error_curve(gt, pred, columns=columns), expected, rtol=1e-12)


@pytest.mark.parametrize("columns", ["gt", "pred"])
def test_moving_features_are_found_per_sequence(columns):
    counts = np.array([[1, 0, 0, 1, 1], [0, 1, 0, 0, 1], [0, 0, 0, 0, 1], [1, 1, 1, 0, 0]], bool)
    unit = np.column_stack([shapes(20), shapes(20)[:, 0]])
    moving = unit * np.where(counts, 1.0001e-4, 0.9999e-4)[:, np.newaxis]
    other = moving + 2.0 ** np.arange(5)
    gt, pred = (moving, other) if columns == "gt" else (other, moving)
    assert compared(gt, pred, columns) == counts.tolist()
    expected = oracles.euler_curve(gt, pred, columns)
    np.testing.assert_allclose(npss.euler_error_curve(gt, pred, columns=columns), expected, rtol=1e-12)


@pytest.mark.parametrize("std", [0.3e-4, 0.9999e-4])
def test_a_nearly_still_ground_truth_is_an_error(std):
    gt = shapes(100)[np.newaxis] * std
    with pytest.raises(ValueError, match="gt: no feature of sequence 0 moves"):
        npss.euler_error_curve(gt, gt + 1)
    assert npss.euler_error_curve(gt, gt + 1, columns="pred").tolist() == [0.0] * 100


def of_amass(gt, pred):
    """Return the error of every frame of every sequence: columns by the set, still sequences zero, not averaged."""
    columns = [j for j in range(gt.shape[-1]) if np.std(gt.reshape(-1, gt.shape[-1])[:, j]) > 1e-4]
    return np.array(
        [
            [math.dist(x[columns], y[columns]) for x, y in zip(*pair, strict=True)]
            for pair in zip(gt, pred, strict=False)
        ]
    )


@given(pair=pairs())
def test_tables_of_amass(pair):
    gt, pred = pair
    curve = of_amass(gt, pred).mean(axis=0)
    options = {"columns": "set", "still": "zero"}
    np.testing.assert_allclose(npss.euler_error_curve(gt, pred, **options), curve, rtol=1e-12, atol=1e-12)
    summed = npss.euler_error(gt, pred, fps=10, at_ms=(100, 200), average="sum", **options)
    assert summed == pytest.approx({100: curve[0], 200: curve[:2].sum()}, rel=1e-12, abs=1e-12)


def test_columns_of_the_set_differ_from_those_of_each_sequence():
    gt = np.zeros((2, 4, 2))
    gt[0, :, 0] = [1.0, 2.0, 3.0, 4.0]
    gt[1, :, 1] = 5  # still, but not what it is in the other sequence
    pred = gt + [3.0, 4.0]
    assert npss.euler_error_curve(gt, pred, columns="set").tolist() == [5.0] * 4
    assert npss.euler_error_curve(gt, pred, still="zero").tolist() == [1.5] * 4  # 3 of one, 0 of the other
    with pytest.raises(ValueError, match=r"^gt: no feature of sequence 1 moves"):
        npss.euler_error_curve(gt, pred)
    still = np.ones((2, 4, 2))
    assert npss.euler_error_curve(still, pred, columns="set", still="zero").tolist() == [0.0] * 4
    with pytest.raises(ValueError, match=r"^gt: no feature of the set moves"):
        npss.euler_error_curve(still, pred, columns="set")
    with pytest.raises(ValueError, match=r"^still: expected one of error, zero, got 'skip'"):
        npss.euler_error_curve(gt, pred, still="skip")


def test_tables_of_amass_of_unequal_lengths():
    """The set are the frames that count, of all sequences."""
    gt, pred = np.random.default_rng(0).normal(size=(2, 3, 4, 3))
    lengths = [4, 2, 4]
    gt[:, :, 1] = 1
    gt[1, 2:, 1] = np.nan  # beyond its length
    kept = [0, 2]
    norms = [[math.dist(x[kept], y[kept]) for x, y in zip(*pair, strict=True)] for pair in zip(gt, pred, strict=True)]
    got = npss.euler_error(gt, pred, fps=10, at_ms=(200, 400), columns="set", average="sum", lengths=lengths)
    assert got[200] == pytest.approx((sum(sum(row[:2]) for row in norms) / 3, 3))
    assert got[400] == pytest.approx(((sum(norms[0]) + sum(norms[2])) / 2, 2))
    gt[1] = 1
    with pytest.raises(ValueError, match=r"^gt: no feature of sequence 1 moves"):
        npss.euler_error(gt, pred, fps=10, at_ms=[100], lengths=lengths)
    counted = npss.euler_error(gt, pred, fps=10, at_ms=[100], lengths=lengths, still="zero")
    assert counted[100] == pytest.approx(((norms[0][0] + norms[2][0]) / 3, 3))


@pytest.mark.parametrize(("std", "counts"), [(0.9999e-4, False), (1.0001e-4, True)])
@pytest.mark.parametrize("offset", [0.0, 1e3])
def test_moving_features_of_the_set_by_standard_deviation(std, counts, offset):
    motion = np.random.default_rng(0).normal(size=(700, 10, 10))  # of several blocks
    motion = (motion - motion.mean(axis=(0, 1))) / motion.std(axis=(0, 1)) * std + offset
    assert _euler_error.moving_in_set(motion).tolist() == [counts] * 10
    assert _euler_error.moving_in_set(motion[0] * 0).tolist() == [False] * 10
    assert _euler_error.moving_in_set(np.array([[1e308], [-1e308]])).tolist() == [True]


def test_signature_of_still_sequences():
    context = {"columns": "set", "average": "sum", "still": "zero"}
    text = npss.signature(None, metric="euler_error", **context)
    assert text == "euler_error|version:1|average:sum|columns:set|still:zero"
    assert npss.parse_signature(text) == {"metric": "euler_error", "version": 1, "convention": None, **context}
    assert "none, their error counts as zero" in npss.explain(text)
    assert "not comparable with tables 6 and 7" in npss.explain(text)
    with pytest.raises(TypeError, match=r"^still: expected a whole number, 0 or more or 'zero', got 'none'"):
        npss.signature(None, metric="euler_error", still="none")


# Means of norms of `golden_pair` at 80 ms, computed once with tests/helpers/oracles.py.
AT_80_MS = {
    ("at", "gt"): 6.75,
    ("at", "pred"): 5.25,
    ("at", "all"): 6.8717082451262845,
    ("up-to", "gt"): 7.5,
    ("up-to", "pred"): 6.0,
    ("up-to", "all"): 7.696234869262463,
}


@pytest.mark.parametrize(("average", "columns"), AT_80_MS)
def test_golden_values(average, columns):
    gt, pred = golden_pair()
    signature = npss.signature(None, metric="euler_error", frames=12, fps=25, average=average, columns=columns)
    errors = npss.euler_error(gt, pred, fps=25, at_ms=(80, 480), columns=columns, average=average)
    assert errors == pytest.approx({80: AT_80_MS[average, columns], 480: GOLDEN[signature]}, rel=1e-14)
    curve = oracles.euler_curve(gt, pred, columns)
    expected = {80: curve[1], 480: curve[11]} if average == "at" else {80: sum(curve[:2]) / 2, 480: sum(curve) / 12}
    assert errors == pytest.approx(expected, rel=1e-13)


def test_golden_value_of_the_mean_of_squares():
    gt, pred = golden_pair()
    squares = [
        (Fraction(x) - Fraction(y)) ** 2 for x, y in zip(gt.ravel().tolist(), pred.ravel().tolist(), strict=True)
    ]
    assert sum(squares) / len(squares) == Fraction(139, 9)
    assert npss.signature(None, metric="mse", frames=12) == "mse|version:1|frames:12"
    assert npss.mse(gt, pred) == 139 / 9  # sums of integers and halves: rounded once


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"at_ms": (90,)}, ValueError, "90 ms is not a whole number of frames at 25 .*nearest: 80 and 120 ms"),
        ({"at_ms": (10,)}, ValueError, "10 ms is not a whole number of frames .*nearest: 40 ms"),
        ({"at_ms": (0,)}, ValueError, "0 ms is out of range .*nearest: 40 ms"),
        ({"at_ms": (1000,)}, ValueError, "1000 ms is out of range .*nearest: 400 ms"),
        ({"at_ms": (395,)}, ValueError, "395 ms is not a whole .*nearest: 360 and 400 ms"),
        ({"at_ms": (500,), "fps": 30}, ValueError, "500 ms is out of range .*nearest: 333.3333333 ms"),
        ({"at_ms": ("80",)}, TypeError, "at_ms: expected a time in ms, got '80'"),
        ({"at_ms": (True,)}, TypeError, "at_ms: expected a time in ms, got True"),
        ({"at_ms": 80}, TypeError, "at_ms: expected a sequence of .*, got 80"),
        ({"at_ms": (80,), "columns": "std"}, ValueError, "columns: expected one of gt, pred, set, all"),
        ({"at_ms": (80,), "average": "mean"}, ValueError, "average: expected one of at, up-to"),
    ],
)
def test_invalid_options(options, error, message):
    motion = np.random.default_rng(0).normal(size=(10, 2))
    with pytest.raises(error, match=message):
        npss.euler_error(motion, motion, **options)


@pytest.mark.parametrize("scale", [1e-300, 1e-200, 1e-100, 1e100, 1e200, 1e300])
def test_huge_and_tiny_values(scale):
    gt, pred = np.random.default_rng(1).normal(size=(2, 3, 5, 2))
    expected = npss.euler_error_curve(gt, pred, columns="all")
    np.testing.assert_allclose(npss.euler_error_curve(gt * scale, pred * scale, columns="all") / scale, expected)
    if scale > 1:
        np.testing.assert_allclose(npss.euler_error_curve(gt * scale, pred * scale) / scale, expected)


def test_one_tiny_difference_among_ordinary_ones():
    gt, pred = np.ones((2, 3, 2))
    pred[0] = 1 + 1e-15
    gt[1], pred[1] = 0, [3e-200, 4e-200]
    assert npss.euler_error_curve(gt, pred, columns="all")[1] == pytest.approx(5e-200)


def test_a_huge_sequence_does_not_hide_a_barely_moving_one():
    gt = np.zeros((2, 4, 1))
    gt[0, :, 0] = [0, 2.4e-4] * 2  # a standard deviation of 1.2e-4
    gt[1, :, 0] = [0, 1e200] * 2
    np.testing.assert_allclose(npss.euler_error_curve(gt, -gt), [0, 1e200] * 2)


def test_differences_beyond_float64_are_an_error():
    huge = np.full((2, 2), 1.5e308)
    with pytest.raises(ValueError, match="pred: its difference from gt is beyond"):
        npss.euler_error_curve(huge, -huge, columns="all")
    with pytest.raises(ValueError, match="pred: its mean squared difference from gt is beyond"):
        npss.mse(huge, -huge)


@given(pair=pairs())
def test_mse_is_the_mean_of_squares(pair):
    gt, pred = pair
    assert npss.mse(gt, pred) == pytest.approx(np.mean((gt - pred) ** 2), rel=1e-12)


@pytest.mark.parametrize(("scale", "expected"), [(1e150, 1e300), (1e153, 1e306), (1e-100, 1e-200), (1e-200, 0.0)])
def test_mse_of_huge_and_tiny_values(scale, expected):
    assert npss.mse(np.full((30, 40), scale), np.zeros((30, 40))) == pytest.approx(expected, rel=1e-12, abs=0)


def test_mse_of_squares_below_the_smallest_number():
    """Squares of 0.4 and 1.4 times the smallest float64 would round to 0 and 1 of it, with a mean of 0."""
    least = 5e-324
    small, large = (math.sqrt(part) * math.sqrt(least) for part in (0.4, 1.4))
    assert (small * small, large * large) == (0, least)
    assert npss.mse([[small, large]], [[0.0, 0.0]]) == least


def test_mse_is_not_the_field_s_mse():
    gt = np.linspace(0, 1, 25)[:, np.newaxis] * [1.0, 2.0]
    assert npss.mse(gt, 0 * gt) != pytest.approx(npss.euler_error(gt, 0 * gt)[1000])


@given(seed=st.integers(0, 1000), shift=st.integers(-3, 3))
def test_whole_turns_count(seed, shift):
    gt, pred = np.random.default_rng(seed).normal(size=(2, 4, 2))
    turned = npss.euler_error_curve(gt, pred + 2 * np.pi * shift)
    assert np.allclose(turned, npss.euler_error_curve(gt, pred), rtol=1e-12, atol=0) == (shift == 0)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("metric", [npss.euler_error_curve, npss.mse])
def test_values_that_are_not_finite_are_named(metric, bad):
    motions = dict(zip(("gt", "pred"), np.random.default_rng(0).normal(size=(2, 3, 4, 2)), strict=True))
    for name in motions:
        broken = {**motions, name: motions[name].copy()}
        broken[name][1, 2, 0] = bad
        with pytest.raises(ValueError, match=rf"^{name}: {bad} at index \(1, 2, 0\)"):
            metric(**broken)


@pytest.mark.parametrize("still", [[0, 0, 0], [0, 1, 0], [1, 1, 0], [1, 1, 1]])
def test_still_sequences_are_dropped_unless_all_are_still(still):
    moving, pred = np.random.default_rng(0).normal(size=(2, 3, 6, 2))
    gt = np.where(np.array(still, bool)[:, np.newaxis, np.newaxis], moving[:, :1], moving)
    kept = np.arange(3) if all(still) else np.flatnonzero(np.array(still) == 0)
    truth, prediction, mask = moving_pair(gt, pred)
    assert mask.tolist() == [bool(value) for value in still]
    assert np.array_equal(truth, gt[kept])
    assert np.array_equal(prediction, pred[kept])
    one, _, alone = moving_pair(gt[1], pred[1])
    assert np.array_equal(one, gt[1])
    assert alone.tolist() == [bool(still[1])]


def test_small_sequences_share_a_block():
    gt = np.broadcast_to(0.0, (400, 100, 99))
    assert len(list(_euler_error.pair_blocks(gt, gt))) == 67  # 6 sequences are 2**16 values
    assert len(list(_euler_error.pair_blocks(gt[:2, :, :1], gt[:2, :, :1]))) == 1
