"""Restorers: each against an oracle, and what all have in common."""

import json
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications import corrupt
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.restore import FILLS, Windows, corrupted
from npss_baselines.manifold.motion.features import local_positions
from npss_baselines.manifold.motion.mirror import exchange_sides, mirror_image
from npss_baselines.manifold.motion.scaling import Scaling
from npss_baselines.manifold.motion.split import split
from npss_baselines.manifold.restorers import by_case, file, keys
from npss_baselines.manifold.restorers.alternating import Alternating
from npss_baselines.manifold.restorers.interpolation import Interpolation
from npss_baselines.manifold.restorers.kernel_ridge import KernelRidge
from npss_baselines.manifold.restorers.key_ridge import fit_key_ridge
from npss_baselines.manifold.restorers.net import Net
from npss_baselines.manifold.restorers.simple_baselines import NAMES, SimpleBaselines
from npss_baselines.manifold.restorers.smoothing import Smoothing

APPLICATIONS = ("repair", "kinect", "fill", "inbetween")


@pytest.fixture(scope="module")
def sets(motions):
    return split(motions)


@pytest.fixture(scope="module")
def simple(sets):
    return SimpleBaselines(sets.training)


@pytest.fixture(scope="module")
def trained(sets):
    """A restorer of few steps."""
    pytest.importorskip("torch")
    from npss_baselines.manifold.restorers.training import QUICK, train_restorer

    return train_restorer(sets.training, settings=QUICK, report=lambda line: None)


@pytest.fixture(scope="module")
def windows(sets):
    return Windows(sets.test.windows[:2].astype(np.float64), sets.test.mask[:2])


def lost(application, windows, simple, **options):
    return corrupted(application, windows, simple.scaling.mean, seed=0, **options)


class TestAll:
    @pytest.mark.parametrize("application", APPLICATIONS)
    def test_what_was_seen_exactly_stays_and_the_rest_is_finite(self, application, windows, simple, trained):
        left = lost(application, windows, simple)
        found = simple.of(left) | {"restorer": trained}
        assert len(found) > 2
        for name, restorer in found.items():
            restored = restorer.restore(left)
            assert restored.shape == windows.features.shape, name
            assert np.isfinite(restored).all(), name
            assert np.array_equal(restored[left.exact], left.features[left.exact]), name
            assert restorer.signature == restorer.signature

    @pytest.mark.parametrize("joints", FILLS)
    def test_bones_of_missing_joints_get_their_lengths(self, joints, windows, simple, trained):
        left = lost("fill", windows, simple, joints=joints)
        missing = {below for joint in joints for below in corrupt.branch(JOINTS, joint)}
        for restorer in (trained, *simple.of(left).values()):
            positions = local_positions(restorer.restore(left))
            for joint in missing:
                bones = np.linalg.norm(positions[:, :, joint] - positions[:, :, JOINTS.parents[joint]], axis=-1)
                np.testing.assert_allclose(bones, np.linalg.norm(JOINTS.offsets[joint]), atol=1e-9)

    def test_every_simple_baseline_is_used_and_named(self, windows, simple):
        names = {name for application in APPLICATIONS for name in simple.of(lost(application, windows, simple))}
        assert names == set(NAMES)

    @pytest.mark.parametrize("application", APPLICATIONS)
    def test_values_that_are_lost_do_not_count(self, application, windows, simple, trained):
        left = lost(application, windows, simple)
        other = replace(left, features=np.where(left.known, left.features, 0.123))
        for name, restorer in {**simple.of(left), "restorer": trained}.items():
            if name in ("linear", "pchip", "hermite", "smoothing") and application == "fill":
                continue
            np.testing.assert_allclose(restorer.restore(left), restorer.restore(other), atol=1e-9, err_msg=name)


class TestInterpolation:
    def test_lines(self):
        motion = np.linspace(0, 1, 11)[np.newaxis, :, np.newaxis] * np.ones(63)
        left = Corrupted(
            np.where(np.arange(11)[:, np.newaxis] % 5, 9.0, motion), np.arange(11)[:, np.newaxis] % 5 == np.zeros(63)
        )
        left = Corrupted(left.features, np.broadcast_to(left.known, motion.shape))
        restored = Interpolation("linear").restore(left)
        assert restored[..., -3:] == pytest.approx(motion[..., -3:])


class TestSmoothing:
    def test_it_keeps_lines_and_removes_noise(self):
        rng = np.random.default_rng(0)
        noise = rng.normal(0, 0.1, (1, 400, 63))
        left = Corrupted(noise, np.ones(noise.shape, bool), 0.1)
        smooth = Smoothing(2.0).restore(left)[0, 20:-20, -3:]
        # The variance of white noise falls by the sum of squared weights, 1 / (2 sqrt(pi) width).
        assert smooth.std() == pytest.approx(0.1 / np.sqrt(2 * np.sqrt(np.pi) * 2.0), rel=0.1)


class TestKernelRidge:
    def test_against_the_definition(self):
        rng = np.random.default_rng(0)
        frames = rng.normal(size=(30, 63))
        restorer = KernelRidge(frames, Scaling(np.zeros(63), np.ones(63)), width=0.7, ridge=0.1)
        motion = rng.normal(size=(1, 3, 63))
        known = np.ones(63, bool)
        known[57:60] = False  # the last joint; its bone keeps its direction
        restored = restorer.restore(Corrupted(motion, np.broadcast_to(known, motion.shape)))
        pairs = [[np.sum((a[known] - b[known]) ** 2) for b in frames] for a in frames]
        width = 0.7**2 * np.median(pairs)
        kernel = np.exp(-np.array(pairs) / width) + 0.1 * np.eye(30)
        mean = frames[:, 57:60].mean(axis=0)
        for frame, found in zip(motion[0], restored[0], strict=True):
            similar = np.exp(-np.array([np.sum((frame[known] - b[known]) ** 2) for b in frames]) / width)
            expected = mean + similar @ np.linalg.inv(kernel) @ (frames[:, 57:60] - mean)
            bone, given = found[57:60] - frame[54:57], expected - frame[54:57]
            np.testing.assert_allclose(bone / np.linalg.norm(bone), given / np.linalg.norm(given), atol=1e-8)

    def test_many_sets_of_known_values_are_refused(self, windows, simple):
        restorer = simple["kernel-ridge"]
        with pytest.raises(ValueError, match=r"^left: frames have .* different sets"):
            restorer.restore(lost("repair", windows, simple))


class TestKeyRidge:
    def test_it_finds_an_exact_law(self):
        """Frames that are a fixed mixture of their four keys are restored exactly."""
        rng = np.random.default_rng(0)
        features = np.zeros((40, 41, 63))
        features[:, ::10] = rng.normal(size=(40, 5, 63))
        mixture = rng.normal(size=(9, 4))
        for key in (10, 20):
            around = features[:, [key - 10, key, key + 10, key + 20]]
            features[:, key + 1 : key + 10] = np.einsum("ok,nkf->nof", mixture, around)
        scaling = Scaling(np.zeros(63), np.ones(63))
        # Only the windows from the second key on have this law: fit to them alone.
        first, second = features[:, 0:31], features[:, 10:41]
        restorer = fit_key_ridge(
            np.concatenate([first, second]), np.ones((80, 31), bool), scaling, every=10, ridge=1e-9
        )
        left = corrupt.stepped_keys(first, every=10)
        assert restorer.restore(left)[:, 11:20, -3:] == pytest.approx(first[:, 11:20, -3:], abs=1e-3)

    def test_between_other_keys_it_is_linear(self, windows, simple):
        left = corrupt.stepped_keys(windows.features, every=7)
        linear = Interpolation("linear").restore(left)
        np.testing.assert_allclose(simple["key-ridge"].restore(left), linear, atol=1e-12)


class TestAlternating:
    class Halving:
        """Projects onto zero by halves."""

        signature = "halving"

        def project(self, features):
            return np.asarray(features) / 2

    def test_rounds(self):
        motion = np.full((1, 2, 63), 8.0)
        known = np.ones(motion.shape, bool)
        known[0, 1, -1] = False
        left = Corrupted(motion, known)
        restored = Alternating(self.Halving(), rounds=3).restore(left)
        assert restored[0, 1, -1] == 1.0
        assert np.array_equal(restored[known], motion[known])


class TestMirror:
    def test_it_is_an_involution_that_reverses_x(self, windows):
        image = mirror_image(windows.features, JOINTS)
        assert np.array_equal(mirror_image(image, JOINTS), windows.features)
        left, right = (JOINTS.names.index(f"{side}Hand") for side in ("Left", "Right"))
        positions, mirrored = local_positions(windows.features), local_positions(image)
        np.testing.assert_array_equal(mirrored[:, :, left], positions[:, :, right] * (-1, 1, 1))
        flags = np.arange(63) == 3 * left
        assert np.flatnonzero(exchange_sides(flags, JOINTS)) == 3 * right

    def test_the_mirror_image_of_a_path_is_the_path_of_the_mirror_image(self, windows):
        from npss_baselines.manifold.motion.features import to_features, to_positions
        from npss_baselines.manifold.motion.mirror import mirrored_joints

        positions = to_positions(windows.features)
        image = positions[:, :, mirrored_joints(JOINTS)] * (-1, 1, 1)
        np.testing.assert_allclose(
            to_features(image, JOINTS), mirror_image(to_features(positions, JOINTS), JOINTS), atol=1e-9
        )


class TestKeys:
    def test_the_cubic_is_that_of_interpolation(self, windows):
        """Between two keys that have neighbours, it is the cubic with the parabolas' slopes."""
        left = corrupt.stepped_keys(windows.features[:1, :46], every=15)
        restored = Interpolation("hermite").restore(left)[0, :, -3:]
        asked = np.arange(1, 45)
        asked = asked[asked % 15 > 0]
        numbers = asked[:, np.newaxis] // 15 + np.array([-1, 0, 1, 2])
        there = (numbers >= 0) & (numbers < 4)
        frames = 15 * np.clip(numbers, 0, 3)
        curve = keys.cubic(left.features[0][frames], (frames - asked[:, np.newaxis]).astype(float), there)
        np.testing.assert_allclose(curve[:, -3:], restored[asked], atol=1e-12)

    def test_without_networks_output_it_is_the_cubic_held_at_ends(self, simple, windows):
        nothing = Net((np.zeros((391, 63), np.float32),), (np.zeros(63, np.float32),))
        known = np.zeros(160, bool)
        known[[20, 40]] = True
        motion = windows.features[0]
        restored = keys.Keys(simple.scaling, (nothing,)).restore(motion, known, JOINTS)
        np.testing.assert_allclose(restored[:20, -3:], motion[[20] * 20, -3:])
        np.testing.assert_allclose(restored[30, -3:], motion[[20, 40], -3:].mean(axis=0), atol=1e-12)


class TestByCase:
    def test_spells(self):
        flags = np.array([1, 1, 0, 1, 0, 0, 1], bool)
        assert by_case._spells(flags).tolist() == [2, 2, 0, 1, 0, 0, 1]

    def test_short_gaps_and_spells_are_the_gaussians(self, windows, trained):
        known = np.ones(windows.features.shape, bool)
        known[:, 50:53] = False
        known[:, 80:85, 54:60] = False
        left = Corrupted(windows.features, known)
        expected = trained.gaussian.restore(left.features, known)
        np.testing.assert_allclose(trained.restore(left)[~known][..., -3:], expected[~known][..., -3:], atol=0.02)

    @settings(max_examples=30)
    @given(st.data(), st.integers(1, 30))
    def test_an_error_that_is_linear_in_time_is_bridged(self, data, frames):
        """Where the guess is wrong by a line between the ends, or by a constant at a single end, the truth is found."""
        start = data.draw(st.integers(0, 40 - frames))
        truth = np.random.default_rng(frames).normal(size=(40, 3))
        both = start > 0 and start + frames < 40
        wrong = np.linspace(1, 3, 40)[:, np.newaxis] if both else np.ones((40, 1))
        seen = truth.copy()
        seen[start : start + frames] = np.nan
        spell = by_case.bridged(seen, truth + wrong, truth, start, start + frames)
        np.testing.assert_allclose(spell, truth[start : start + frames], atol=1e-12)

    def test_short_spells_follow_the_curve_and_long_ones_the_guess(self):
        motion, curve = np.zeros((100, 1)), np.ones((100, 1))
        shares = [by_case.bridged(motion, motion, curve, 20, 20 + n).max() for n in (1, 12, 24, 60)]
        assert shares == [1, 1, 0.25, 0.04000000000000001]
        assert by_case.bridged(motion, motion, curve, 70, 100).max() == 0
        assert by_case.bridged(motion, curve, motion, 0, 100).min() == 1

    def test_guesses_continue_where_other_joints_go_missing(self):
        """A guess that is wrong by another amount for each set of joints keeps the amount of the first."""
        truth = np.random.default_rng(0).normal(size=(60, 3))
        missing = np.zeros((60, 20), bool)
        missing[10:50, 2] = missing[20:40, 5] = missing[30:60, 7] = True
        guesses = {joints.tobytes(): truth + number for number, joints in enumerate(np.unique(missing[10:], axis=0))}
        wrong = (by_case._chained(guesses, missing, 10, 50) - truth)[10:50]
        np.testing.assert_allclose(wrong - wrong[0], 0, atol=1e-12)

    def test_joints_whose_spells_overlap(self, windows, trained):
        """Each joint meets the motion at the ends of its own spell."""
        known = np.ones(windows.features.shape, bool)
        known[:, 40:80, 42:45] = False
        known[:, 60:120, 54:57] = False
        restored = trained.restore(Corrupted(np.where(known, windows.features, np.nan), known))
        assert np.array_equal(restored[known], windows.features[known])
        for joint in (14, 18):  # where either goes missing or returns, neither leaps
            paths = (local_positions(motion)[:, :, joint] for motion in (restored, windows.features))
            steps, true = (np.linalg.norm(np.diff(path, axis=1), axis=-1) for path in paths)
            assert steps[:, [39, 59, 79, 119]].max() < 1.5 * true.max()

    def test_a_long_spell_meets_the_motion_around_it(self, windows, trained):
        known = np.ones(windows.features.shape, bool)
        known[:, 40:120, 54:60] = False
        restored = trained.restore(Corrupted(windows.features, known))
        paths = (local_positions(motion)[:, :, 18:] for motion in (restored, windows.features))
        steps, true = (np.linalg.norm(np.diff(path, axis=1), axis=-1) for path in paths)
        assert steps[:, [39, 119]].max() < 1.5 * true.max()

    def test_motion_shorter_than_a_span(self, windows, trained):
        known = np.ones((1, 5, 63), bool)
        known[0, 2] = False
        assert np.isfinite(trained.restore(Corrupted(windows.features[:1, :5], known))).all()

    def test_motion_of_which_nothing_is_known(self, windows, trained):
        known = np.zeros(windows.features.shape, bool)
        assert np.isfinite(trained.restore(Corrupted(windows.features, known))).all()

    def test_networks_leave_sets_that_they_have_not_learned_to_the_gaussian(self, windows, trained):
        motion = windows.features[0]
        missing = np.isin(np.arange(20), [3, 11, 14])
        plain = replace(trained.fill, sets=trained.fill.sets[:0]).restore(motion, missing, JOINTS)
        assert np.array_equal(trained.fill.restore(motion, missing, JOINTS), plain)
        hand = np.isin(np.arange(20), [18, 19])
        plain = replace(trained.fill, sets=trained.fill.sets[:0]).restore(motion, hand, JOINTS)
        assert not np.array_equal(trained.fill.restore(motion, hand, JOINTS), plain)

    def test_it_commutes_with_mirror_images(self, windows, trained, simple):
        """Networks see a motion and its mirror image; only the Gaussian of 12 frames is not symmetric."""
        left = lost("fill", windows, simple)
        image = Corrupted(mirror_image(left.features, JOINTS), exchange_sides(left.known, JOINTS))
        missing = np.isin(np.arange(20), [18, 19])
        other = np.isin(np.arange(20), [14, 15])
        first = trained.fill.restore(left.features[0], missing, JOINTS)
        second = trained.fill.restore(image.features[0], other, JOINTS)
        np.testing.assert_allclose(mirror_image(second, JOINTS), first, atol=1e-5)


class TestFile:
    def test_round_trip(self, trained, tmp_path, windows, simple):
        path = tmp_path / "restorer.npz"
        file.save(path, trained)
        once = file.load(path)
        file.save(path, once)
        assert file.load(path).signature == once.signature
        assert once.seen == trained.seen
        for application in APPLICATIONS:
            left = lost(application, windows, simple)
            np.testing.assert_allclose(once.restore(left), trained.restore(left), atol=5e-3)

    def test_a_changed_number_changes_the_signature(self, trained):
        nets = (replace(trained.keys.nets[0], biases=tuple(b + 1 for b in trained.keys.nets[0].biases)),)
        assert replace(trained, keys=replace(trained.keys, nets=nets)).signature != trained.signature

    @pytest.mark.parametrize("change", ["cut", "version", "header", "nan", "shape", "missing", "pickle"])
    def test_broken_files_are_refused(self, change, trained, tmp_path):
        path = tmp_path / "restorer.npz"
        file.save(path, trained)
        with np.load(path) as stored:
            arrays = dict(stored)
        header = json.loads(arrays["header"].item())
        if change == "version":
            arrays["header"] = np.array(json.dumps(header | {"version": 99}))
        elif change == "header":
            arrays["header"] = np.array("no JSON")
        elif change == "nan":
            arrays["pose.mean"] = np.full(63, np.nan)
        elif change == "shape":
            arrays["pose.mean"] = np.zeros(62)
        elif change == "missing":
            del arrays["fill.0.0.weight"]
        elif change == "pickle":
            arrays["pose.mean"] = np.array([{}], dtype=object)
        np.savez(path, **arrays)
        if change == "cut":
            path.write_bytes(path.read_bytes()[:1000])
        with pytest.raises(ValueError, match=r"restorer\.npz: not a trained restorer"):
            file.load(path)

    def test_no_file(self, tmp_path):
        with pytest.raises(FileNotFoundError):
            file.load(tmp_path / "none.npz")

    def test_other_skeletons_are_not_stored(self, trained, tmp_path):
        with pytest.raises(ValueError, match=r"^restorer: only restorers of the skeleton JOINTS"):
            file.save(tmp_path / "restorer.npz", replace(trained, skeleton=replace_skeleton()))


def replace_skeleton():
    from npss.skeleton import Skeleton

    return Skeleton(JOINTS.names, JOINTS.parents, JOINTS.offsets)
