"""Tests of restoration, interpolation and sampling, on manifolds with known results."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.interpolate import blend, interpolate
from npss_baselines.manifold.applications.restore import RESTORATIONS, Windows, corrupted, keep_known, rescaled
from npss_baselines.manifold.applications.sample import filter_motion, sample_codes
from npss_baselines.manifold.applications.simple import interpolated
from npss_baselines.manifold.model.pca import fit_pca
from npss_baselines.manifold.motion.scaling import Scaling

F = 3 * len(JOINTS.names) + 3
MEAN = np.linspace(-1, 1, F)
FLAT = Scaling(np.zeros(F), np.ones(F))


class Pairs:
    """A manifold whose code is the average of every two frames."""

    signature = "pairs"

    def encode(self, features):
        return np.asarray(features).reshape(len(features), -1, 2, np.shape(features)[-1]).mean(axis=2)

    def decode(self, code, n_frames):
        return np.repeat(code, 2, axis=1)[:, :n_frames]

    def project(self, features):
        return self.decode(self.encode(features), np.shape(features)[1])


@pytest.fixture
def windows():
    """Return a whole window, and a padded one of 60 frames."""
    from npss_baselines.manifold.motion.windows import windows_of

    rng = np.random.default_rng(0)
    parts = [windows_of(rng.normal(size=(frames, F))) for frames in (160, 60)]
    return Windows(*(np.concatenate(each) for each in zip(*parts, strict=True)))


class TestCorrupted:
    @pytest.mark.parametrize("application", list(RESTORATIONS))
    def test_padding_reveals_nothing(self, windows, application):
        left = corrupted(application, windows, MEAN)
        for values in (left.features, left.known):
            assert values.shape == (2, 160, F)
            assert np.array_equal(values[1, 60:119], values[1, 58::-1])  # mirrored at the last frame
            assert np.array_equal(values[1, 118:160], values[1, :42])

    @pytest.mark.parametrize("application", list(RESTORATIONS))
    def test_same_seed_same_result(self, windows, application):
        first, again, other = (corrupted(application, windows, MEAN, seed=seed) for seed in (0, 0, 1))
        assert np.array_equal(first.features, again.features)
        assert np.array_equal(first.features, other.features) == (application not in ("repair", "kinect"))

    def test_project_corrupts_nothing(self, windows):
        left = corrupted("project", windows, MEAN)
        assert np.array_equal(left.features, windows.features)
        assert left.known.all()

    def test_fill_loses_the_wrist_and_the_hand(self, windows):
        lost = ~corrupted("fill", windows, MEAN).known[0, 0, :-3].reshape(20, 3)
        assert [JOINTS.names[j] for j in np.flatnonzero(lost.all(axis=1))] == ["RightHand", "RightHandIndex"]
        assert lost.sum() == 6

    def test_in_between_holds_keys(self, windows):
        left = corrupted("inbetween", windows, MEAN)
        assert np.array_equal(left.features[0, 44], windows.features[0, 30])

    def test_unknown_application(self, windows):
        with pytest.raises(ValueError, match="application: expected one of project, repair"):
            corrupted("mend", windows, MEAN)


class TestLinear:
    @given(st.integers(0, 1000))
    def test_by_hand(self, seed):
        rng = np.random.default_rng(seed)
        features, known = rng.normal(size=(2, 9, 3)), rng.random((2, 9, 3)) < 0.5
        filled = interpolated(Corrupted(features, known))
        for i, t, f in np.ndindex(2, 9, 3):
            at = [s for s in range(9) if known[i, s, f]]
            before, after = [s for s in at if s <= t], [s for s in at if s >= t]
            if known[i, t, f] or not at:
                expected = features[i, t, f]
            elif not before or not after:
                expected = features[i, (before or after[:1])[-1], f]
            else:
                a, b = before[-1], after[0]
                expected = features[i, a, f] + (features[i, b, f] - features[i, a, f]) * (t - a) / (b - a)
            assert filled[i, t, f] == pytest.approx(expected)

    def test_straight_lines_are_restored_from_keys(self):
        line = np.arange(31.0).reshape(1, 31, 1) * np.arange(1, 4)
        left = corrupted("inbetween", Windows(line, np.ones((1, 31), bool)), np.zeros(3))
        assert interpolated(left) == pytest.approx(line)


class TestRescaled:
    def test_unbiased(self):
        motion = np.random.default_rng(0).normal(3, 1, (1, 4, F))
        windows = Windows(np.tile(motion, (4000, 1, 1)), np.ones((4000, 4), bool))
        left = corrupted("repair", windows, MEAN)
        assert rescaled(left, MEAN).mean(axis=0) == pytest.approx(motion[0], abs=0.4)
        assert np.abs(left.features.mean(axis=0) - motion[0]).max() > 1

    def test_nothing_or_everything_known(self):
        motion = np.random.default_rng(0).normal(3, 1, (2, 4, F))
        nothing = Corrupted(np.broadcast_to(MEAN, motion.shape).astype(float), np.zeros(motion.shape, bool))
        assert np.array_equal(rescaled(nothing, MEAN), nothing.features)
        assert rescaled(Corrupted(motion, np.ones(motion.shape, bool)), MEAN) == pytest.approx(motion)


class TestKeepKnown:
    def test_known_values_are_kept_and_others_are_restored(self, windows):
        left = corrupted("repair", windows, MEAN)
        projected = Pairs().project(left.features)
        kept = keep_known(left, projected)
        assert np.array_equal(kept[left.known], windows.features[left.known])
        assert np.array_equal(kept[~left.known], projected[~left.known])


class TestInterpolate:
    def test_the_ends_are_projections(self):
        first, second = np.random.default_rng(0).normal(size=(2, 3, 8, F))
        way = {"way": "manifold", "constrained": False}
        assert interpolate(Pairs(), first, second, 0, **way) == pytest.approx(Pairs().project(first))
        assert interpolate(Pairs(), first, second, 1.0, **way) == pytest.approx(Pairs().project(second))

    def test_on_a_linear_manifold_it_is_the_projected_blend(self):
        rng = np.random.default_rng(2)
        manifold = fit_pca(rng.normal(size=(10, 8, F)), FLAT, n_components=4)
        first, second = rng.normal(size=(2, 3, 8, F))
        expected = manifold.project(blend(first, second, 0.3))
        between = interpolate(manifold, first, second, 0.3, way="manifold", constrained=False)
        assert between == pytest.approx(expected)

    @pytest.mark.parametrize(
        ("share", "error", "message"),
        [(-0.1, ValueError, "share: expected"), (np.nan, ValueError, "share"), ("x", TypeError, "share: expected")],
    )
    def test_invalid_share(self, share, error, message):
        with pytest.raises(error, match=message):
            blend([0.0], [1.0], share)

    def test_shapes_differ(self):
        with pytest.raises(ValueError, match=r"second: shape \(3,\) differs"):
            blend(np.zeros(2), np.zeros(3), 0.5)


class TestSamples:
    CODES = np.random.default_rng(0).normal([0, 5], [0.1, 2], (50, 20, 2))

    def test_the_prior_of_the_paper(self):
        drawn = sample_codes(self.CODES, 100, prior="uniform", seed=1)
        assert drawn.shape == (100, 20, 2)
        assert np.abs(drawn).max() <= 1
        assert np.histogram(drawn, 10, (-1, 1))[0] == pytest.approx(np.full(10, 400), abs=80)

    def test_the_range_of_each_unit(self):
        drawn = sample_codes(self.CODES, 200, prior="range", seed=1)
        assert drawn.min(axis=(0, 1)) == pytest.approx(self.CODES.min(axis=(0, 1)), rel=0.01)
        assert drawn.max(axis=(0, 1)) == pytest.approx(self.CODES.max(axis=(0, 1)), rel=0.01)

    def test_the_values_of_each_unit(self):
        drawn = sample_codes(self.CODES, 200, prior="values", seed=1)
        for unit in range(2):
            assert set(drawn[..., unit].ravel()) <= set(self.CODES[..., unit].ravel())
        assert drawn.std(axis=(0, 1)) == pytest.approx(self.CODES.std(axis=(0, 1)), rel=0.05)
        assert abs(np.corrcoef(drawn.reshape(-1, 2).T)[0, 1]) < 0.05

    def test_bad_input(self):
        with pytest.raises(ValueError, match="prior: expected one of local, uniform, range, values"):
            sample_codes(self.CODES, 1, prior="normal", seed=0)
        with pytest.raises(ValueError, match="codes: expected shape"):
            sample_codes(self.CODES[0], 1, seed=0)
        with pytest.raises(ValueError, match="n: expected a positive integer"):
            sample_codes(self.CODES, 0, seed=0)

    def test_single_unit(self):
        motion = filter_motion(Pairs(), (4, F), 5, 8, largest=0.2)
        expected = np.zeros((2, F))  # the frames that change
        expected[:, 5] = 0.2
        assert motion == pytest.approx(expected)

        class Faint(Pairs):  # beside the two frames, a little changes
            def decode(self, code, n_frames):
                motion = super().decode(code, n_frames)
                return motion + 0.09 * np.roll(motion, 2, axis=1)

        assert len(filter_motion(Faint(), (4, F), 5, 8)) == 2
        with pytest.raises(ValueError, match="unit: expected a number from 0 to 62, got 63"):
            filter_motion(Pairs(), (4, F), 63, 8)
