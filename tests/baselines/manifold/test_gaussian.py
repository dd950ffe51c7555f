"""The Gaussian of a few frames: conditional means by definition, and motion that it must restore."""

import numpy as np
import pytest

from npss_baselines.manifold.model.gaussian import SpanGaussian, fit_gaussian
from npss_baselines.manifold.motion.scaling import Scaling, fit_scaling

F = 3


@pytest.fixture(scope="module")
def windows():
    """Windows of smooth random motion, whose features depend on each other."""
    rng = np.random.default_rng(0)
    waves = rng.normal(size=(40, 5, F)) / np.arange(1, 6)[:, np.newaxis]
    t = np.arange(48)[:, np.newaxis] / 48 * 2 * np.pi
    motion = np.einsum("tk,nkf->ntf", np.cos(t * np.arange(1, 6)), waves)
    motion[..., 2] = motion[..., 0] + 0.5 * motion[..., 1] + 3
    return motion


def fitted(windows, **options):
    mask = np.ones(windows.shape[:2], bool)
    return fit_gaussian(windows, mask, fit_scaling(windows, mask, "feature"), **options)


def test_it_has_the_mean_and_covariance_of_all_spans(windows):
    model = fitted(windows, span=8, ridge=1e-9, offset=0, sway=0)
    scaled = model.scaling.normalize(windows)
    rows = np.concatenate([scaled[:, start : start + 8].reshape(len(windows), -1) for start in range(0, 41, 2)])
    np.testing.assert_allclose(model.mean, rows.mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(model.covariance, np.cov(rows.T, bias=True), atol=1e-8)


def test_padding_is_left_out(windows):
    mask = np.ones(windows.shape[:2], bool)
    mask[:5, 20:] = False
    spoilt = windows.copy()
    spoilt[:5, 20:] = 1e6
    scaling = Scaling(np.zeros(F), np.ones(F))
    one, other = (fit_gaussian(motion, mask, scaling) for motion in (windows, spoilt))
    assert np.array_equal(one.covariance, other.covariance)


@pytest.mark.parametrize("noise", [0.0, 0.3])
def test_means_are_those_of_the_definition(windows, noise):
    """One span: the mean of a normal variable, given noisy values of some of its components, as a joint precision."""
    model = fitted(windows, span=8, ridge=1e-3)
    rng = np.random.default_rng(1)
    motion = windows[:2, :8]
    known = rng.random(motion.shape) < 0.5
    restored = model.restore(motion, known, noise=noise * model.scaling.scale)
    for values, seen, found in zip(
        model.scaling.normalize(motion), known, model.scaling.normalize(restored), strict=True
    ):
        precision = np.linalg.inv(model.covariance)
        certainty = np.diag(seen.reshape(-1) / max(noise, 1e-5) ** 2)
        expected = np.linalg.solve(
            precision + certainty, precision @ model.mean + certainty @ np.where(seen, values, 0).reshape(-1)
        )
        np.testing.assert_allclose(found.reshape(-1), expected, rtol=0, atol=1e-5)


def test_systems_too_ill_conditioned_for_single_precision():
    """Two features that are lost nearly repeat each other: by hand, each is -.1 times the sum of the others over 2."""
    precision = np.eye(4)
    precision[0, 1] = precision[1, 0] = 1 - 1e-7
    precision[:2, 2:] = precision[2:, :2] = 0.1
    model = SpanGaussian(1, np.zeros(4), np.linalg.inv(precision), Scaling(np.zeros(4), np.ones(4)))
    motion = np.array([[[0.0, 0.0, 3.0, -1.0]]])
    restored = model.restore(motion, np.array([[[False, False, True, True]]]))
    np.testing.assert_allclose(restored[0, 0, :2], -0.1 * 2 / (2 - 1e-7), rtol=0, atol=1e-6)


def test_known_values_stay_and_unknown_ones_do_not_count(windows):
    model = fitted(windows)
    rng = np.random.default_rng(2)
    known = rng.random(windows.shape) < 0.5
    spoilt = np.where(known, windows, rng.normal(size=windows.shape) * 100)
    restored = model.restore(spoilt, known)
    assert np.array_equal(restored[known], windows[known])
    assert np.array_equal(restored, model.restore(windows, known))
    assert np.array_equal(model.restore(windows, np.ones_like(known)), windows)


def test_smooth_motion_is_restored(windows):
    """What its features and frames determine comes back; with nothing known, the mean does."""
    model = fitted(windows)
    rng = np.random.default_rng(3)
    known = rng.random(windows.shape) < 0.5
    error = np.abs(model.restore(windows, known) - windows)[~known].mean()
    assert error < 0.02 * np.abs(windows - windows.mean(axis=(0, 1))).mean()
    nothing = model.restore(windows[:1], np.zeros_like(known[:1]))
    np.testing.assert_allclose(nothing, np.broadcast_to(windows.mean(axis=(0, 1)), nothing.shape), atol=0.3)


def test_noise_is_smoothed(windows):
    model = fitted(windows)
    noisy = windows + 0.1 * np.random.default_rng(4).normal(size=windows.shape)
    restored = model.restore(noisy, np.ones(windows.shape, bool), noise=0.1)
    assert np.abs(restored - windows).mean() < 0.6 * np.abs(noisy - windows).mean()


def test_signatures_tell_distributions_apart(windows):
    model, other = fitted(windows), fitted(windows[:-1])
    assert model.signature == fitted(windows).signature != other.signature


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"features": np.zeros((1, 11, F))}, r"^features: expected shape \(n, T, 3\) with at least 12 frames, got"),
        ({"features": np.zeros((1, 12, 4))}, "^features: expected shape"),
        ({"known": np.ones((1, 13, F), bool)}, "^known: expected the shape of features"),
        ({"noise": -1.0}, "^noise: expected a standard deviation"),
        ({"step": 0}, "^step: "),
    ],
)
def test_what_is_refused(windows, options, message):
    given = {"features": windows[:1, :12], "known": np.ones((1, 12, F), bool)} | options
    with pytest.raises(ValueError, match=message):
        fitted(windows).restore(given.pop("features"), given.pop("known"), **given)


def test_what_cannot_be_fitted_is_refused(windows):
    with pytest.raises(ValueError, match=r"^windows: expected at least two spans of 12 frames, got 0"):
        fit_gaussian(windows, np.zeros(windows.shape[:2]), Scaling(np.zeros(F), np.ones(F)))
    with pytest.raises(ValueError, match=r"^ridge: expected a positive number, got 0"):
        fitted(windows, ridge=0)


def test_motion_at_another_place_is_restored_almost_as_well(windows):
    """Without the offset, the covariance of training motion forbids other places."""
    other = windows + np.array([3.0, 0.0, 0.0])
    known = np.random.default_rng(3).random(other.shape) < 0.5
    errors = []
    for offset in (0.0, 0.02):
        restored = fitted(windows, span=8, offset=offset, sway=0).restore(other, known)
        errors.append(np.abs(restored - other)[~known].mean())
    assert errors[1] < errors[0] / 2
