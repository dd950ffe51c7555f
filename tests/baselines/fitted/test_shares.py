"""Predictors that impose shares of power outside DC: their parts against definitions, and the whole on few walkers."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

import npss
from npss.gait import gait
from npss.predictors import gated_periodic, periodic
from npss_baselines.data.synthetic import Synthetic, synthetic_task
from npss_baselines.fitted import FITTED
from npss_baselines.fitted.angles import SWAPPED, angles_of, mirrored
from npss_baselines.fitted.base import FittedPredictor, inside
from npss_baselines.fitted.blend import Blend, BlendSettings
from npss_baselines.fitted.calibrated_blend import CalibratedBlend, CalibratedSettings, calibrated
from npss_baselines.fitted.dc_share import DCShare, MedianShare, ShareSettings, with_shares
from npss_baselines.fitted.descriptors import SPANS, descriptors, span_moments, speeds_of, statistics_of
from npss_baselines.fitted.motion import read_motion
from npss_baselines.fitted.network import Ensemble, NetworkSettings, train, weighted_median
from npss_baselines.fitted.shares import halves, moments

SMALL = {"networks": 2, "hidden": 8, "epochs": 1, "folds": 2, "neighbours": 3}
MOTIONS = st.builds(
    lambda n, frames, seed: np.random.default_rng(seed).normal(size=(n, frames, 3)).cumsum(axis=1),
    st.integers(1, 3),
    st.integers(2, 40),
    st.integers(0, 2**32 - 1),
)


@pytest.fixture(scope="module", autouse=True)
def _one_thread(one_thread):
    """Small tensors."""


@pytest.fixture(scope="module")
def walkers():
    """Six walkers: 216 windows."""
    motion, _ = read_motion(Synthetic(), Path(), ["gait"])
    return motion.of(without=motion.groups[6:])


@pytest.fixture(scope="module")
def trained(walkers):
    """The weights of two small networks."""
    return train(walkers, NetworkSettings(2, 8, 1), seed=0, progress=lambda share: None).arrays()


class TestShares:
    @given(motion=MOTIONS)
    def test_against_spectra(self, motion):
        spectrum = np.fft.fft(motion, axis=1)
        for power, share in zip((np.abs(spectrum) ** 2, spectrum.real**2), moments(motion).shares, strict=True):
            np.testing.assert_allclose(share, 1 - power[:, 0] / power.sum(axis=1), rtol=1e-9, atol=1e-12)

    @given(motion=MOTIONS)
    def test_halves(self, motion):
        even, odd = halves(motion)
        np.testing.assert_allclose(even + odd, motion, atol=1e-12)
        np.testing.assert_allclose(np.fft.fft(even, axis=1), np.fft.fft(motion, axis=1).real, atol=1e-9)

    def test_without_power(self):
        assert all((share == 0).all() for share in moments(np.zeros((1, 5, 2))).shares)

    @given(st.lists(st.tuples(st.integers(-9, 9), st.integers(1, 5)), min_size=1, max_size=12))
    def test_weighted_median(self, pairs):
        values, weights = (torch.tensor(column, dtype=torch.float64)[:, None] for column in zip(*pairs, strict=True))
        median = weighted_median(values, weights).item()
        cost = {v: sum(w * abs(v - x) for x, w in pairs) for v, _ in pairs}
        assert cost[median] == min(cost.values())


class TestDescriptors:
    seed = angles_of(gait(4, 50, seed=3)).astype(np.float32)
    target = angles_of(gait(4, 100, seed=4)).astype(np.float32)

    def test_moments_of_spans(self):
        level = self.seed.mean(axis=1)
        found = span_moments(self.target, level).numpy()
        for i, (first, end) in enumerate(SPANS):
            expected = moments(self.target[:, first:end].astype(float))
            np.testing.assert_allclose(found[:, :, i, 0] + level, expected.mean, atol=1e-5)
            np.testing.assert_allclose(found[:, :, i, 1], expected.variance, atol=1e-5)
            np.testing.assert_allclose(found[:, :, i, 2], expected.even, atol=1e-5)

    def test_speed(self):
        steps = np.abs(np.diff(self.target.astype(float), axis=1))[:, 24:]
        np.testing.assert_allclose(speeds_of(self.target), steps.mean(axis=1), rtol=1e-5)

    def test_periodic_continuation(self):
        found = statistics_of(self.seed).periodic.numpy()
        expected = moments(periodic(self.seed.astype(float), 100))
        np.testing.assert_allclose(found[:, :, 0, 1], expected.variance, rtol=1e-3, atol=1e-6)

    def test_statistics_of_a_changed_motion(self):
        """To shift and scale the statistics is to shift and scale the motion about its mean."""
        shift, scale = 0.3 * torch.randn(4, 48), torch.exp(0.2 * torch.randn(4, 48))
        level = self.seed.mean(axis=1, keepdims=True)
        motion = level + shift.numpy()[:, None] + scale.numpy()[:, None] * (self.seed - level)
        # The period is that of the motion before: scales that differ between angles may change it.
        uniform = torch.full((4, 48), 1.2)
        changed = statistics_of(self.seed).changed(shift, uniform)
        again = statistics_of(level + shift.numpy()[:, None] + 1.2 * (self.seed - level))
        for before, after in zip(changed._replace(ratio=again.ratio), again, strict=True):
            np.testing.assert_allclose(before, after, rtol=2e-3, atol=2e-5)
        np.testing.assert_allclose(changed.ratio, again.ratio, rtol=0.05)  # up to the smallest spread
        different = statistics_of(self.seed).changed(shift, scale)
        np.testing.assert_allclose(different.spread[..., 0], motion.std(axis=1), rtol=1e-3)

    def test_statistics_of_a_mirror_image(self):
        chosen = torch.tensor([True, False, True, False])
        found = statistics_of(self.seed).mirrored(chosen)
        motion = np.where(chosen.numpy()[:, None, None], mirrored(self.seed), self.seed)
        for before, after in zip(found, statistics_of(motion), strict=True):
            np.testing.assert_allclose(before, after, rtol=1e-4, atol=1e-6)

    def test_descriptors_are_finite_for_a_still_motion(self):
        assert torch.isfinite(descriptors(statistics_of(np.zeros((1, 50, 48), np.float32)))).all()


class TestNetwork:
    def test_it_learns(self, walkers):
        """The error of its shares is below that of the best constant shares of each angle."""
        ensemble = train(walkers, NetworkSettings(1, 16, 4), seed=0, progress=lambda share: None)
        task = synthetic_task(32)
        shares, speed = ensemble.answers(angles_of(task.seed_frames), 0)
        truth = moments(angles_of(task.target))
        weight = truth.mean**2 + truth.variance
        median = np.median(truth.shares[0], axis=0)

        def error(predicted):
            return (weight * np.abs(predicted - truth.shares[0])).sum()

        assert error(shares[:, :, 0, 0]) < error(median)
        true_speed = speeds_of(angles_of(task.target).astype(np.float32)).numpy()
        assert 0.8 < speed.sum() / true_speed.sum() < 1.25

    def test_the_seed_decides(self, walkers):
        small = NetworkSettings(1, 8, 1)
        torch.manual_seed(0)
        expected = torch.rand(3)
        torch.manual_seed(0)
        first, again, other = (train(walkers, small, seed=s, progress=lambda share: None).arrays() for s in (1, 1, 2))
        assert torch.equal(torch.rand(3), expected)  # of the global generator
        assert all(np.array_equal(first[name], again[name]) for name in first)
        assert any(not np.array_equal(first[name], other[name]) for name in first)

    def test_a_mirror_image_has_the_same_answers(self, trained):
        ensemble = Ensemble.restore(2, 8, trained)
        seed = angles_of(synthetic_task(3).seed_frames)
        shares, speed = ensemble.answers(seed, 0)
        other_shares, other_speed = ensemble.answers(mirrored(seed), 0)
        np.testing.assert_allclose(other_speed, speed[:, SWAPPED], rtol=1e-3)
        np.testing.assert_allclose(other_shares, shares[:, SWAPPED], rtol=1e-3)
        assert shares.shape == (3, 48, 4, 2)

    def test_weights_of_another_size(self, trained):
        with pytest.raises(ValueError, match="network 0"):
            Ensemble.restore(2, 9, trained)


class TestBlend:
    def test_weights_are_convex_and_fitted(self, walkers):
        blend = Blend.fit(walkers, BlendSettings(folds=2, neighbours=3), progress=lambda share: None)
        task = synthetic_task(24)
        seed, target = angles_of(task.seed_frames), angles_of(task.target)
        predicted = blend.predict(seed, 0)
        parts = [np.repeat(seed[:, -1:], 100, axis=1), gated_periodic(seed, 100)]
        parts += [part.predict(seed, 0) for part in (blend._ridge, blend._nearest)]
        assert (predicted >= np.min(parts, axis=0) - 1e-9).all()
        assert (predicted <= np.max(parts, axis=0) + 1e-9).all()
        errors = [np.linalg.norm(part - target, axis=2)[:, [1, 9, 24]].mean() for part in (predicted, *parts)]
        assert errors[0] < 1.02 * min(errors[1:])

    def test_parts_of_names(self):
        arrays = {"a.x": np.zeros(1), "ab.x": np.ones(1), "a": np.ones(2)}
        assert list(inside(arrays, "a")) == ["x"]


class TestSynthesis:
    base = 1 + 0.2 * np.random.default_rng(0).normal(size=(3, 100, 5)).cumsum(axis=1) / 10

    @settings(max_examples=10)
    @given(paper=st.floats(0.02, 0.3), part=st.floats(0.1, 0.9))
    def test_alternation_reaches_shares(self, paper, part):
        asked = np.full((3, 5), paper), np.full((3, 5), paper * part)
        result = with_shares(self.base, *asked)
        for found, wanted in zip(moments(result).shares, asked, strict=True):
            assert np.abs(found - wanted).mean() < 0.15 * wanted.mean()
        assert np.abs(result - self.base)[:, 0].mean() < 1e-9

    def test_descent_reaches_shares_and_speeds_that_exist(self):
        walks = angles_of(gait(6, 100, seed=11))
        truth = np.stack([np.stack(moments(walks[:, first:end]).shares, -1) for first, end in SPANS], 2)
        speed = np.abs(np.diff(walks[:, 24:], axis=1)).mean(axis=1)
        mean = walks.mean(axis=1, keepdims=True)
        start = mean + 0.5 * np.roll(walks - mean, 9, axis=1)  # smaller, and out of phase
        result = calibrated(start, truth, speed, replace(CalibratedSettings(), near=0.0))
        before, after = (npss.score(walks, motion) for motion in (start, result))
        assert after < 0.35 * before
        ratio = np.abs(np.diff(result[:, 24:], axis=1)).mean() / speed.mean()
        assert 0.95 < ratio < 1.05

    def test_descent_stays_near_the_blend_at_first(self):
        walks = angles_of(gait(2, 100, seed=12))
        shares = np.stack([np.stack(moments(walks[:, first:end]).shares, -1) for first, end in SPANS], 2)
        speed = np.abs(np.diff(walks[:, 24:], axis=1)).mean(axis=1)
        result = calibrated(walks, 2 * shares, 2 * speed, CalibratedSettings())
        change = np.abs(result - walks).mean(axis=(0, 2))
        assert change[:5].mean() < 0.25 * change[50:].mean()

    def test_sequences_do_not_depend_on_each_other(self):
        walks = angles_of(gait(3, 100, seed=13))
        shares, speed = np.full((3, 48, 4, 2), 0.1), np.full((3, 48), 0.01)
        few = replace(CalibratedSettings(), steps=5)
        whole = calibrated(walks, shares, speed, few)
        np.testing.assert_allclose(calibrated(walks[1:2], shares[1:2], speed[1:2], few), whole[1:2], atol=1e-3)


@pytest.mark.parametrize("kind", [MedianShare, DCShare, CalibratedBlend])
class TestPredictors:
    def test_fitted_and_restored(self, walkers, kind):
        small = {name: value for name, value in SMALL.items() if hasattr(kind.Settings(), name)}
        if kind is CalibratedBlend:
            small["steps"] = 30
        chosen = kind.Settings(**small)
        shares = []
        fitted = kind.fit(walkers, chosen, seed=1, progress=shares.append)
        assert shares == sorted(shares)
        assert shares[-1] <= 1
        task = synthetic_task(8)
        predicted = FittedPredictor(fitted, 0)(task.seed_frames, 100)
        assert np.isfinite(predicted).all()
        restored = kind.restore(1, chosen, fitted.arrays())
        assert np.array_equal(FittedPredictor(restored, 0)(task.seed_frames, 100), predicted)
        zero = np.repeat(task.seed_frames[:, -1:], 100, axis=1)
        gt = npss.poses_to_euler(task.target)
        scores = [npss.score(gt, npss.poses_to_euler(poses), convention="released") for poses in (predicted, zero)]
        assert scores[0] < scores[1]

    def test_missing_and_other_arrays(self, walkers, kind):
        small = {name: value for name, value in SMALL.items() if hasattr(kind.Settings(), name)}
        chosen = kind.Settings(**small)
        arrays = kind.fit(walkers, chosen, seed=1, progress=lambda share: None).arrays()
        for name in ("blend.blend", "blend.ridge.weights", next(iter(arrays))):
            with pytest.raises((KeyError, ValueError)):
                kind.restore(1, chosen, {other: value for other, value in arrays.items() if other != name})
        with pytest.raises((KeyError, ValueError)):
            kind.restore(2, chosen, arrays)


def test_settings_of_the_registry_are_the_defaults():
    assert all(spec.settings == spec.kind.Settings() for spec in FITTED.values())
    assert math.isclose(ShareSettings().scale, 0.18)
