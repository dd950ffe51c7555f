"""Tests of the prior on codes, its file, and of motion decoded from it."""

import numpy as np
import pytest

from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.sample import PRIORS, motion_of, sample_codes
from npss_baselines.manifold.model.prior import fit_prior
from npss_baselines.manifold.motion.features import local_positions
from npss_baselines.manifold.motion.smooth import smoothed


@pytest.fixture(scope="module")
def codes():
    """Return two groups of codes, far apart."""
    rng = np.random.default_rng(0)
    groups = rng.normal(0, 0.1, (30, 4, 3)), rng.normal(0.6, 0.02, (30, 4, 3))
    return np.concatenate(groups)


@pytest.mark.numeric
def test_a_gaussian_has_the_moments_of_a_code_and_its_neighbours(codes):
    """Draw around each code in turn: mean and covariance are those of its five nearest, found by sorting."""
    prior = fit_prior(codes, neighbours=4)

    class Chosen(np.random.Generator):
        def integers(self, *_, size):
            return np.full(size, 7)

    drawn = prior.draw(40_000, seed=Chosen(np.random.PCG64(0))).reshape(-1, 12)
    rows = codes.reshape(60, 12)
    near = rows[np.argsort(np.linalg.norm(rows - rows[7], axis=1))[:5]]
    expected = np.cov(near.T)
    deviation = np.sqrt(np.diag(expected))
    # Five standard errors; places are rounded to float32.
    assert (np.abs(drawn.mean(axis=0) - near.mean(axis=0)) < 5 * deviation / 200 + 1e-6).all()
    error = np.sqrt((expected**2 + np.outer(deviation, deviation) ** 2) / 40_000)
    assert (np.abs(np.cov(drawn.T) - expected) < 5 * error + 1e-9).all()


def test_groups_do_not_mix(codes):
    drawn = fit_prior(codes).draw(200, seed=1).mean(axis=(1, 2))
    assert ((np.abs(drawn) < 0.2) | (np.abs(drawn - 0.6) < 0.1)).all()
    assert 0.3 < (drawn > 0.3).mean() < 0.7


def test_components_limit_what_is_kept(codes):
    assert fit_prior(codes).components.shape == (12, 4, 3)  # of 12 numbers
    few = fit_prior(codes, components=2)
    assert (few.components.shape, few.places.shape) == ((2, 4, 3), (60, 2))
    axes = few.components.reshape(2, 12)
    np.testing.assert_allclose(axes @ axes.T, np.eye(2), atol=1e-6)
    wide = np.random.default_rng(0).normal(size=(9, 20, 8))  # more numbers than codes
    again = fit_prior(wide)
    assert len(again.components) == 8
    restored = again.mean + np.tensordot(again.places, again.components, 1)
    np.testing.assert_allclose(restored, wide, atol=1e-5)


def test_signature(codes):
    assert fit_prior(codes).signature == fit_prior(codes).signature != fit_prior(codes, neighbours=3).signature


@pytest.mark.parametrize(
    ("shape", "options", "error", "message"),
    [
        ((5, 4), {}, ValueError, r"codes: expected shape \(N, T', H\)"),
        ((4, 4, 3), {}, ValueError, "codes: 4 neighbours need more than as many codes, got 4"),
        ((9, 4, 3), {"neighbours": 0}, ValueError, "neighbours: "),
        ((9, 4, 3), {"components": 1.5}, TypeError, "components: "),
    ],
)
def test_refused(shape, options, error, message):
    with pytest.raises(error, match=f"^{message}"):
        fit_prior(np.random.default_rng(0).normal(size=shape), **options)


def test_the_default_prior_is_local(codes):
    np.testing.assert_array_equal(sample_codes(codes, 3, seed=5), fit_prior(codes).draw(3, seed=5))
    assert PRIORS[0] == "local"


def test_decoded_motion_is_possible(testbed):
    manifold = testbed.manifolds["manifold"]
    codes = sample_codes(manifold.encode(testbed.training.windows), 2, seed=0)
    motion = motion_of(manifold, codes, 100)
    assert motion.shape == (2, 100, 63)
    local = local_positions(motion)
    for child, parent in JOINTS.bones:
        length = np.linalg.norm(local[..., child, :] - local[..., parent, :], axis=-1)
        np.testing.assert_allclose(length, np.linalg.norm(JOINTS.offsets[child]), atol=1e-9)


def test_smoothing():
    rng = np.random.default_rng(0)
    motion = rng.normal(size=(2, 30, 3))
    lags = np.arange(-8, 9)
    weights = np.exp(-(lags**2) / (2 * 2.0**2))
    expected = [
        sum(w * motion[1, min(max(t + lag, 0), 29), 2] for lag, w in zip(lags, weights, strict=True)) / weights.sum()
        for t in range(30)
    ]
    np.testing.assert_allclose(smoothed(motion, deviation=2.0)[1, :, 2], expected)
    np.testing.assert_allclose(smoothed(np.ones((5, 2))), 1)
    with pytest.raises(ValueError, match=r"^deviation: "):
        smoothed(motion, deviation=0)
    with pytest.raises(ValueError, match=r"^features: expected shape \(\.\.\., T, F\)"):
        smoothed(np.ones(3))
