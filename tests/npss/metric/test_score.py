"""The score against its definitions, its golden values, and its range."""

import numpy as np
import pytest
from hypothesis import given

import npss
import oracles
from npss._metric.golden import GOLDEN, golden_pair
from strategies import pairs

pytestmark = pytest.mark.numeric

NAMES = tuple(npss.CONVENTIONS)


@pytest.mark.parametrize("name", NAMES)
@given(pair=pairs())
def test_equals_the_definition(name, pair):
    gt, pred = pair
    assert npss.score(gt, pred, convention=name) == pytest.approx(oracles.npss(gt, pred, name), rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("name", NAMES)
@given(pair=pairs(max_n=1))
def test_two_axes_are_one_sequence(name, pair):
    gt, pred = pair
    assert npss.score(gt[0], pred[0], convention=name) == npss.score(gt, pred, convention=name)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        # Two-sided power moved by one bin: d = 1/2 in each of the bins between, on both sides.
        ({"power": "magnitude"}, 1.0),
        ({"bins": "one-sided"}, 1.0),
        ({"distance": "spectrum"}, 2.0),
        ({"bins": "one-sided", "distance": "spectrum"}, 2.0),
    ],
)
def test_a_tone_one_bin_off(change, expected):
    t = np.arange(8)[:, np.newaxis]
    one, two = np.cos(2 * np.pi * t / 8), np.cos(2 * np.pi * 2 * t / 8)
    assert npss.score(one, two, convention=npss.Convention(**change)) == pytest.approx(expected)


def test_weights():
    t = np.arange(8)[:, np.newaxis]
    one, two = np.cos(2 * np.pi * t / 8), np.cos(2 * np.pi * 2 * t / 8)
    gt, pred = np.hstack([3 * one, one]), np.hstack([two, one])  # powers 9 : 1, distances 1 and 0
    assert npss.score(gt, pred) == pytest.approx(0.9)
    assert npss.score(gt, pred, convention=npss.Convention(weight="uniform")) == pytest.approx(0.5)


def test_a_prediction_of_zeros():
    t = np.arange(8)[:, np.newaxis]
    gt = 1 + np.cos(2 * np.pi * t / 8)  # two thirds of the power are DC
    zeros = np.zeros_like(gt)
    assert npss.score(gt, zeros) == pytest.approx(npss.score(gt, zeros + 1))
    assert npss.score(gt, zeros) == pytest.approx(8 / 2 * (1 / 3))
    assert npss.score(gt, zeros, convention="released") == pytest.approx(8 / 2 * (1 + 2 / 3))


@pytest.mark.parametrize("name", NAMES)
def test_golden_values(name):
    gt, pred = (motion[:1] for motion in golden_pair())
    score = npss.score(gt, pred, convention=name)
    assert score == pytest.approx(GOLDEN[npss.signature(name, frames=12)], rel=1e-13)
    assert score == pytest.approx(oracles.npss(gt, pred, name), rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_golden_values_of_windows(name):
    gt, pred = golden_pair()
    frames = {"0-1": slice(0, 3), "1-2": slice(3, 6), "2-4": slice(6, 12)}
    scores = npss.score_windows(gt, pred, fps=3, convention=name)
    assert list(scores) == list(frames)
    for window, score in scores.items():
        signature = npss.signature(name, frames=12, fps=3, window=window)
        assert score == pytest.approx(GOLDEN[signature], rel=1e-13)
        part = frames[window]
        assert score == pytest.approx(oracles.npss(gt[:, part], pred[:, part], name), rel=1e-12)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("scale", [1e-320, 1e-300, 1e-160, 1e-80, 1e80, 1e160, 1e300])
def test_huge_and_tiny_values(name, scale):
    rng = np.random.default_rng(7)
    gt, pred = rng.uniform(-1, 1, (2, 3, 20, 2)).cumsum(axis=2) / 20
    expected = npss.score(gt, pred, convention=name)
    tolerance = 1e-2 if scale < 1e-310 else 1e-9  # subnormal numbers have few digits
    for scores in (
        npss.score(gt * scale, pred, convention=name),
        npss.score(gt, pred * scale, convention=name),
        npss.score(gt * scale, pred * scale, convention=name),
    ):
        assert scores == pytest.approx(expected, rel=tolerance)


def test_one_huge_and_one_tiny_feature():
    rng = np.random.default_rng(8)
    gt, pred = rng.normal(size=(2, 1, 16, 2))
    alone = npss.score(gt[..., :1], pred[..., :1])
    assert npss.score(gt * [1e200, 1e-200], pred) == pytest.approx(alone)
    both = npss.score(gt * [1e200, 1e200], pred)
    assert both == pytest.approx(npss.score(gt, pred))


@pytest.mark.parametrize("name", NAMES)
def test_no_power_is_an_error(name):
    with pytest.raises(ValueError, match="gt: no power"):
        npss.score(np.zeros((2, 5, 3)), np.ones((2, 5, 3)), convention=name)


def test_more_features_than_a_block_holds():
    rng = np.random.default_rng(9)
    gt, pred = rng.normal(size=(2, 1, 3, 70_000))
    halves = [npss.score(gt[..., s], pred[..., s], convention="literal") for s in (slice(35_000), slice(35_000, None))]
    assert npss.score(gt, pred, convention="literal") == pytest.approx(np.mean(halves))


class TestWindows:
    def test_equal_the_score_of_the_slices(self):
        rng = np.random.default_rng(3)
        gt, pred = rng.normal(size=(2, 4, 100, 3))
        scores = npss.score_windows(gt, pred, fps=25, convention="released")
        assert list(scores) == ["0-1", "1-2", "2-4"]
        assert scores["1-2"] == npss.score(gt[:, 25:50], pred[:, 25:50], convention="released")
        assert scores["2-4"] == npss.score(gt[:, 50:], pred[:, 50:], convention="released")

    def test_fractions_of_a_second(self):
        rng = np.random.default_rng(3)
        gt, pred = rng.normal(size=(2, 30, 1))
        scores = npss.score_windows(gt, pred, fps=30, edges_ms=(100, 500, 1000))
        assert scores["0.1-0.5"] == npss.score(gt[3:15], pred[3:15])

    @pytest.mark.parametrize(
        ("edges", "message"),
        [
            (
                (0, 500),
                "edges_ms: 500 ms is not a whole number of frames at 25 frames per second; nearest: 480 and 520 ms",
            ),
            ((0, 5000), "edges_ms: 5000 ms is out of range at 25 frames per second; nearest: 4000 ms"),
            ((-1000, 1000), "edges_ms: -1000 ms is out of range at 25 frames per second; nearest: 0 ms"),
            ((0, 2000, 1000), "edges_ms: 1000 ms is not after 2000 ms"),
            ((1000,), "edges_ms: expected at least two edges"),
            ((0, 40), r"gt: one frame in the window 0-0\.04 s"),
        ],
    )
    def test_invalid_edges(self, edges, message):
        motion = np.random.default_rng(0).normal(size=(100, 2))
        with pytest.raises(ValueError, match=message):
            npss.score_windows(motion, motion, fps=25, edges_ms=edges)

    def test_a_window_without_power_is_named(self):
        gt = np.ones((100, 1))
        gt[25:50] = 0
        with pytest.raises(ValueError, match="gt: no power in any feature of any sequence in the window 1-2 s"):
            npss.score_windows(gt, gt, fps=25)

    def test_errors_name_the_index_in_the_whole_motion(self):
        gt = np.ones((2, 100, 1))
        bad = gt.copy()
        bad[1, 60, 0] = np.inf
        with pytest.raises(ValueError, match=r"gt: inf at index \(1, 60, 0\)"):
            npss.score_windows(bad, gt, fps=25)
        with pytest.raises(ValueError, match=r"pred: inf at index \(1, 60, 0\)"):
            npss.score_windows(gt, bad, fps=25)
