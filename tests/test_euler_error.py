"""The Euler error and the true mean of squares."""

import numpy as np
import oracles
import pytest
from hypothesis import given
from hypothesis import strategies as st
from strategies import pairs

import npss


@pytest.mark.parametrize("columns", ["gt", "pred", "all"])
@given(pair=pairs())
def test_equals_the_definition(columns, pair):
    gt, pred = pair
    gt = gt + np.cumsum(np.ones_like(gt), axis=1)  # something always moves
    curve = npss.euler_error_curve(gt, pred, columns=columns)
    np.testing.assert_allclose(curve, oracles.euler_curve(gt, pred, columns), rtol=1e-12, atol=1e-12)
    at = npss.euler_error(gt, pred, fps=10, at_ms=(100, 200), columns=columns)
    assert at == pytest.approx({100: curve[0], 200: curve[1]}, rel=1e-15)
    up_to = npss.euler_error(gt, pred, fps=10, at_ms=(100, 200), columns=columns, average="up-to")
    assert up_to == pytest.approx({100: curve[0], 200: curve[:2].mean()}, rel=1e-14)


def test_the_slices_of_the_field_are_these_frames():
    gt = np.arange(1.0, 26)[:, np.newaxis]  # the error at frame k, counted from 0, is k + 1
    assert npss.euler_error(gt, np.zeros_like(gt)) == {80: 2, 160: 4, 320: 8, 400: 10, 560: 14, 1000: 25}


def test_features_are_chosen_in_each_sequence_alone():
    gt = np.zeros((2, 4, 2))
    gt[0, :, 0] = gt[1, :, 1] = [1.0, 2.0, 3.0, 4.0]
    pred = gt + [3.0, 4.0]
    np.testing.assert_allclose(npss.euler_error_curve(gt, pred), np.full(4, 3.5))
    np.testing.assert_allclose(npss.euler_error_curve(gt, pred, columns="all"), np.full(4, 5.0))


def test_a_constant_prediction_has_no_error_by_the_predictions_mask():
    gt = np.arange(8.0).reshape(4, 2)
    assert not npss.euler_error_curve(gt, np.ones_like(gt), columns="pred").any()


def test_a_ground_truth_that_does_not_move_is_an_error():
    gt = np.ones((3, 4, 2))
    gt[:2] += np.arange(4.0)[:, np.newaxis]
    with pytest.raises(ValueError, match="gt: no feature of sequence 2 moves"):
        npss.euler_error_curve(gt, gt)
    many = np.concatenate([np.tile(gt[:1], (60_000, 1, 1)), gt])  # in a later block
    with pytest.raises(ValueError, match="gt: no feature of sequence 60002 moves"):
        npss.euler_error_curve(many, many)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"at_ms": (90,)}, ValueError, "90 ms is not a whole number of frames at 25 .*nearest: 80 and 120 ms"),
        ({"at_ms": (10,)}, ValueError, "10 ms is not a whole number of frames .*nearest: 40 ms"),
        ({"at_ms": (0,)}, ValueError, "0 ms is out of range .*nearest: 40 ms"),
        ({"at_ms": (1000,)}, ValueError, "1000 ms is out of range .*nearest: 400 ms"),
        ({"at_ms": (395,)}, ValueError, "395 ms is not a whole .*nearest: 360 and 400 ms"),
        ({"at_ms": (500,), "fps": 30}, ValueError, "500 ms is out of range .*nearest: 333.3333333 ms"),
        ({"at_ms": (80.0,)}, TypeError, "at_ms: expected whole milliseconds"),
        ({"at_ms": (True,)}, TypeError, "at_ms: expected whole milliseconds"),
        ({"at_ms": (80,), "columns": "std"}, ValueError, "columns: expected one of gt, pred, all"),
        ({"at_ms": (80,), "average": "mean"}, ValueError, "average: expected one of at, up-to"),
    ],
)
def test_options_that_cannot_be_had(options, error, message):
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


@pytest.mark.parametrize(("scale", "expected"), [(1e150, 1e300), (1e-100, 1e-200), (1e-200, 0.0)])
def test_mse_of_huge_and_tiny_values(scale, expected):
    assert npss.mse(np.full((30, 40), scale), np.zeros((30, 40))) == pytest.approx(expected)


def test_mse_is_not_the_field_s_mse():
    gt = np.linspace(0, 1, 25)[:, np.newaxis] * [1.0, 2.0]
    assert npss.mse(gt, 0 * gt) != pytest.approx(npss.euler_error(gt, 0 * gt)[1000])


@given(seed=st.integers(0, 1000), shift=st.integers(-3, 3))
def test_whole_turns_do_count(seed, shift):
    gt, pred = np.random.default_rng(seed).normal(size=(2, 4, 2))
    turned = npss.euler_error_curve(gt, pred + 2 * np.pi * shift)
    assert np.allclose(turned, npss.euler_error_curve(gt, pred)) == (shift == 0)
