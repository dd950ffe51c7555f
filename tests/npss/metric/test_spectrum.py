"""Entropy and divergence of power spectra: definitions in loops, properties, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss

pytestmark = pytest.mark.numeric

seeds = st.integers(0, 2**32 - 1)
shapes = st.tuples(st.integers(1, 3), st.integers(1, 12), st.integers(1, 3))
both_spectra = pytest.mark.parametrize("spectra", ["set", "sequence"])


def distributions(motion, spectra, epsilon):
    """Return the shares of power, one list for each feature of the set or of each sequence."""
    n, _, d = motion.shape
    power = [[np.abs(np.fft.fft(motion[i, :, j])) ** 2 for j in range(d)] for i in range(n)]
    if spectra == "set":
        power = [[sum(power[i][j] for i in range(n)) for j in range(d)]]
    return [(row + epsilon) / (row + epsilon).sum() for rows in power for row in rows]


def entropy(motion, spectra, epsilon=1e-8):
    entropies = [-sum(p * math.log(p) for p in shares) for shares in distributions(motion, spectra, epsilon)]
    return sum(entropies) / len(entropies)


def divergence(of, by, spectra, epsilon=1e-8):
    pairs = zip(distributions(of, spectra, epsilon), distributions(by, spectra, epsilon), strict=True)
    sums = [sum(p * math.log(p / q) for p, q in zip(*pair, strict=True)) for pair in pairs]
    return sum(sums) / len(sums)


@both_spectra
@given(seeds, shapes, st.sampled_from([1e-8, 1e-3]))
def test_equals_the_definition(spectra, seed, shape, epsilon):
    gt, pred = np.random.default_rng(seed).normal(size=(2, *shape))
    options = {"spectra": spectra, "epsilon": epsilon}
    assert npss.spectrum_entropy(gt, **options) == pytest.approx(entropy(gt, **options), abs=1e-11)
    forwards = npss.spectrum_divergence(gt, pred, **options)
    assert forwards == pytest.approx(divergence(gt, pred, **options), abs=1e-10)
    backwards = npss.spectrum_divergence(gt, pred, direction="pred-gt", **options)
    assert backwards == pytest.approx(divergence(pred, gt, **options), abs=1e-10)
    assert npss.spectrum_divergence(pred, gt, **options) == backwards


@both_spectra
@pytest.mark.parametrize("n_frames", [100, 997, 2048])
def test_lengths_that_are_transformed_in_other_ways(spectra, n_frames):
    gt, pred = np.random.default_rng(0).normal(size=(2, 3, n_frames, 2))
    assert npss.spectrum_entropy(gt, spectra=spectra) == pytest.approx(entropy(gt, spectra), rel=1e-10)
    expected = divergence(gt, pred, spectra)
    assert npss.spectrum_divergence(gt, pred, spectra=spectra) == pytest.approx(expected, rel=1e-9)


@both_spectra
@given(seeds, shapes)
def test_bounds_and_what_is_ignored(spectra, seed, shape):
    gt, pred = np.random.default_rng(seed).normal(size=(2, *shape))
    value = npss.spectrum_entropy(gt, spectra=spectra)
    assert -1e-12 <= value <= math.log(shape[1]) + 1e-12
    assert npss.spectrum_divergence(gt, gt, spectra=spectra) == 0
    between = npss.spectrum_divergence(gt, pred, spectra=spectra)
    assert between >= 0
    backwards = npss.spectrum_divergence(gt, pred[:, ::-1], spectra=spectra)
    assert backwards == pytest.approx(between, abs=1e-9)
    shifted = npss.spectrum_divergence(gt, np.roll(pred, 3, axis=1), spectra=spectra)
    assert shifted == pytest.approx(between, abs=1e-9)
    if spectra == "set":
        order = npss.spectrum_divergence(gt, pred[::-1], spectra=spectra)
        assert order == pytest.approx(between, abs=1e-9)


def test_negative_examples():
    t = np.arange(50)
    tones = np.stack([np.cos(2 * np.pi * k * t / 50) for k in (2, 5)])[..., np.newaxis]
    # Order matters for single sequences, not for the set.
    assert npss.spectrum_divergence(tones, tones[::-1], spectra="sequence") > 1
    assert npss.spectrum_divergence(tones, tones[::-1]) < 1e-12
    # An offset is a frequency, too.
    assert npss.spectrum_divergence(tones, tones + 1) > 0.1
    # It is not symmetric.
    one, other = tones[:1], tones[:1] + 0.5 * tones[1:]
    assert abs(npss.spectrum_divergence(one, other) - npss.spectrum_divergence(other, one)) > 0.1
    # The loudest sequence decides the spectrum of the set.
    assert npss.spectrum_entropy(tones * [[[1]], [[100]]]) < npss.spectrum_entropy(tones) - 0.5


def test_known_entropies():
    t = np.arange(64)[:, np.newaxis]
    assert npss.spectrum_entropy(np.ones((64, 1))) == pytest.approx(0, abs=1e-6)
    assert npss.spectrum_entropy(np.cos(2 * np.pi * t / 8)) == pytest.approx(math.log(2), abs=1e-6)
    assert npss.spectrum_entropy((t == 0).astype(float)) == pytest.approx(math.log(64), abs=1e-6)
    assert npss.spectrum_entropy(np.zeros((64, 1))) == pytest.approx(math.log(64), rel=1e-12)


def test_features_that_move():
    gt, pred = np.random.default_rng(0).normal(size=(2, 2, 10, 3))
    gt[..., 1] = 0.3
    moving = {"gt": gt[..., [0, 2]], "pred": pred[..., [0, 2]]}
    assert npss.spectrum_divergence(gt, pred, features="set") == npss.spectrum_divergence(**moving)
    assert npss.spectrum_entropy(gt, features="set") == npss.spectrum_entropy(moving["gt"])
    with pytest.raises(ValueError, match=r"^gt: no feature moves"):
        npss.spectrum_divergence(gt[..., [1]], pred[..., [1]], features="set")
    with pytest.raises(ValueError, match=r"^motion: no feature moves"):
        npss.spectrum_entropy(gt[..., [1]], features="set")


def test_sets_of_different_size():
    gt, pred = np.random.default_rng(0).normal(size=(2, 4, 10, 3))
    assert npss.spectrum_divergence(gt, pred[:2]) == pytest.approx(divergence(gt, pred[:2], "set"), rel=1e-12)
    with pytest.raises(ValueError, match=r"^pred: its shape .* nothing is broadcast"):
        npss.spectrum_divergence(gt, pred[:2], spectra="sequence")
    with pytest.raises(ValueError, match=r"^pred: its frames and features \(9, 3\) differ from those of gt, \(10, 3\)"):
        npss.spectrum_divergence(gt, pred[:, 1:])


def test_blocks_do_not_matter():
    motion = np.random.default_rng(0).normal(size=(500, 20, 30))
    assert npss.spectrum_entropy(motion) == pytest.approx(entropy(motion, "set"), rel=1e-12)


def test_golden_values_with_their_signatures():
    """An impulse has the same power at each of 4 frequencies, a constant all of it at one."""
    impulse, constant = np.eye(4)[:1, :, np.newaxis], np.full((1, 4, 1), 0.5)
    context = {"frames": 4, "extra": {"spectra": "set", "features": "all", "epsilon": 1.0}}
    text = "spectrum_entropy|version:1|frames:4|epsilon:1|features:all|spectra:set"
    assert npss.signature(None, metric="spectrum_entropy", **context) == text
    assert npss.spectrum_entropy(impulse, epsilon=1.0) == pytest.approx(math.log(4), rel=1e-12)
    context["extra"]["direction"] = "gt-pred"
    text = "spectrum_divergence|version:1|frames:4|direction:gt-pred|epsilon:1|features:all|spectra:set"
    assert npss.signature(None, metric="spectrum_divergence", **context) == text
    # Powers with epsilon: 2 2 2 2, and 5 1 1 1.
    expected = (math.log(2 / 5) + 3 * math.log(2)) / 4
    assert npss.spectrum_divergence(impulse, constant, epsilon=1.0) == pytest.approx(expected, rel=1e-12)
    measured = npss.metrics.METRICS["spectrum_divergence"].measure(impulse, constant)
    assert measured.value == npss.spectrum_divergence(impulse, constant)
    assert measured.by_sequence() is None


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"spectra": "sets"}, ValueError, "spectra: expected one of set, sequence"),
        ({"features": "gt"}, ValueError, "features: expected one of all, set"),
        ({"epsilon": 0}, ValueError, "epsilon: expected a positive, finite number"),
        ({"epsilon": "tiny"}, TypeError, "epsilon: expected a positive number"),
        ({"direction": "both"}, ValueError, "direction: expected one of gt-pred, pred-gt"),
    ],
)
def test_invalid_options(options, error, message):
    motion = np.ones((2, 4, 3))
    with pytest.raises(error, match=f"^{message}"):
        npss.spectrum_divergence(motion, motion, **options)
    if "direction" not in options:
        with pytest.raises(error, match=f"^{message}"):
            npss.spectrum_entropy(motion, **options)


def test_invalid_motion():
    motion = np.ones((2, 4, 3))
    broken = motion.copy()
    broken[1, 2, 0] = np.inf
    with pytest.raises(ValueError, match=r"^pred: inf at index \(1, 2, 0\)"):
        npss.spectrum_divergence(motion, broken)
    with pytest.raises(ValueError, match=r"^motion: inf at index \(1, 2, 0\)"):
        npss.spectrum_entropy(broken)
    with pytest.raises(TypeError, match=r"^pred: expected real numbers"):
        npss.spectrum_divergence(motion, motion > 0)
    with pytest.raises(ValueError, match=r"^gt: its power is out of the range of float64"):
        npss.spectrum_divergence(1e200 * motion, motion)
