"""Tests of corruptions against independent computations."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications import corrupt

F = 3 * len(JOINTS.names) + 3
MEAN = np.linspace(-1, 1, F)


def windows(n=4, frames=160, features=F, seed=0):
    return np.random.default_rng(seed).normal(size=(n, frames, features))


class TestZeros:
    def test_lost_values_are_the_mean_and_the_others_are_kept(self):
        motion = windows()
        corrupted = corrupt.zeros(motion, MEAN, seed=0)
        for (i, t, f), known in np.ndenumerate(corrupted.known):
            assert corrupted.features[i, t, f] == (motion[i, t, f] if known else MEAN[f])

    @pytest.mark.parametrize("lost", [0, 0.1, 0.5, 1])
    def test_share_of_lost_values(self, lost):
        known = corrupt.zeros(windows(40), MEAN, lost=lost, seed=1).known
        assert np.mean(known) == pytest.approx(1 - lost, abs=0.005)
        for axes in ((0, 1), (0, 2), (1, 2)):  # each feature, frame and window alike
            assert np.abs(known.mean(axis=axes) - (1 - lost)).max() < 0.05

    def test_values_are_lost_independently(self):
        known = corrupt.zeros(windows(40), MEAN, seed=2).known.astype(float)
        neighbours = [(known[:, 1:], known[:, :-1]), (known[..., 1:], known[..., :-1])]
        assert all(abs(np.corrcoef(a.ravel(), b.ravel())[0, 1]) < 0.01 for a, b in neighbours)

    def test_same_seed_same_result(self):
        first, again, other = (corrupt.zeros(windows(), MEAN, seed=seed).known for seed in (3, 3, 4))
        assert np.array_equal(first, again)
        assert not np.array_equal(first, other)

    @pytest.mark.parametrize("lost", [-0.1, 1.1, np.nan, "half"])
    def test_invalid_probability(self, lost):
        with pytest.raises(ValueError, match="lost: expected a probability"):
            corrupt.zeros(windows(), MEAN, lost=lost, seed=0)


class TestMissing:
    def test_missing_joints_are_at_their_mean(self):
        joints = corrupt.branch(JOINTS, "RightHand")
        assert [JOINTS.names[j] for j in joints] == ["RightHand", "RightHandIndex"]
        motion = windows()
        corrupted = corrupt.missing(motion, MEAN, joints=joints)
        at = [3 * j + axis for j in joints for axis in range(3)]
        others = np.setdiff1d(np.arange(F), at)
        assert np.array_equal(corrupted.features[..., at], np.broadcast_to(MEAN[at], (4, 160, len(at))))
        assert np.array_equal(corrupted.features[..., others], motion[..., others])
        assert not corrupted.known[..., at].any()
        assert corrupted.known[..., others].all()

    @pytest.mark.parametrize("joints", [[], [-1], [20]])
    def test_unknown_joint(self, joints):
        with pytest.raises(ValueError, match="joints: expected indices from 0 to 19"):
            corrupt.missing(windows(), MEAN, joints=joints)

    def test_unknown_name(self):
        with pytest.raises(ValueError, match="joint: 'Tail' is not one of Hips"):
            corrupt.branch(JOINTS, "Tail")

    def test_branch_of_the_root_is_the_skeleton(self):
        assert corrupt.branch(JOINTS, "Hips") == list(range(20))


class TestSteppedKeys:
    @given(frames=st.integers(1, 50), every=st.integers(1, 60))
    def test_each_frame_is_the_key_before_it(self, frames, every):
        motion = windows(2, frames, 3)
        corrupted = corrupt.stepped_keys(motion, every=every)
        for t in range(frames):
            key = max(k for k in range(0, frames, every) if k <= t)
            assert np.array_equal(corrupted.features[:, t], motion[:, key])
            assert corrupted.known[:, t].all() == corrupted.known[:, t].any() == (t == key)

    def test_the_paper_keeps_every_fifteenth(self):
        known = corrupt.stepped_keys(windows()).known[0, :, 0]
        assert list(np.flatnonzero(known)) == list(range(0, 160, 15))


@pytest.fixture(scope="module")
def seen():
    """Windows, what the camera saw, and where: (n, T, J, 3) and (n, T, J, 3)."""
    motion = windows(60)
    corrupted = corrupt.kinect(motion, JOINTS, seed=0)
    shape = (60, 160, 20, 3)
    return motion, corrupted, corrupted.features[..., :-3].reshape(shape), corrupted.known[..., :-3].reshape(shape)


class TestKinect:
    def test_a_joint_is_seen_whole_or_not_at_all(self, seen):
        known = seen[3]
        assert np.array_equal(known.any(axis=-1), known.all(axis=-1))
        assert known[:, :, 0].all()
        assert seen[1].known[..., -3:].all()

    def test_seen_values_jitter(self, seen):
        motion, corrupted, positions, known = seen
        noise = (positions - motion[..., :-3].reshape(positions.shape))[:, :, 1:][known[:, :, 1:]]
        assert noise.mean() == pytest.approx(0, abs=1e-4)
        assert noise.std() == pytest.approx(corrupt.JITTER, rel=0.01)
        path = np.cumsum(corrupted.features[..., -3:] - motion[..., -3:], axis=1)  # it does not drift
        assert path[:, 5:].std(axis=(0, 1)) == pytest.approx(path[:, 100:].std(axis=(0, 1)), rel=0.1)
        expected = np.sqrt(2) * np.array([corrupt.TURN_JITTER, corrupt.JITTER, corrupt.JITTER])
        assert path.std(axis=(0, 1)) == pytest.approx(expected, rel=0.05)

    def test_the_root_stays_over_the_origin(self, seen):
        motion, _, positions, _ = seen
        assert np.array_equal(positions[:, :, 0, [0, 2]], np.zeros((60, 160, 2)))
        assert (positions[:, :, 0, 1] - motion[:, :, 1]).std() == pytest.approx(corrupt.JITTER, rel=0.03)

    def test_hidden_values_are_held(self, seen):
        _, _, positions, known = seen
        hidden, n_checked = ~known[..., 0], 0
        for i, j in np.ndindex(20, 20):
            if not hidden[i, :, j].any():
                continue
            for t in np.flatnonzero(hidden[i, :, j]):
                before = np.flatnonzero(~hidden[i, :t, j])
                source = before[-1] if len(before) else np.flatnonzero(~hidden[i, :, j])[0]
                assert np.array_equal(positions[i, t, j], positions[i, source, j])
                n_checked += 1
        assert n_checked > 1000

    def test_occlusion_lasts_as_documented(self, seen):
        hidden = ~seen[3][..., 0]
        limbs = [corrupt.branch(JOINTS, name) for name in ("LeftForeArm", "RightForeArm", "LeftLeg", "RightLeg")]
        chosen = []
        for window in hidden:
            together = [window[:, limb].all(axis=1) for limb in limbs]
            longest = [max(map(len, "".join(map(str, each.astype(int))).split("0"))) for each in together]
            assert max(longest) >= 64
            assert sorted(longest)[-2] < 64
            chosen.append(int(np.argmax(longest)))
        assert min(np.bincount(chosen, minlength=4)) >= 6

    def test_drop_outs_are_as_frequent_as_documented(self):
        hidden = ~corrupt.kinect(windows(60, 400), JOINTS, seed=5).known[..., 3:-3:3]
        trunk = hidden[..., [j - 1 for j in range(1, 20) if JOINTS.names[j] in ("Spine1", "Neck", "Head")]]
        # Seen for 1 / DROP frames on average, then not for SPELL; the window begins with all seen.
        expected = corrupt.SPELL / (corrupt.SPELL + 1 / corrupt.DROP - 1)
        assert trunk[:, 50:].mean() == pytest.approx(expected, rel=0.1)

    def test_another_skeleton(self):
        with pytest.raises(ValueError, match="features: expected 63 for 20 joints, got 9"):
            corrupt.kinect(windows(features=9), JOINTS, seed=0)


class TestNoise:
    def test_it_is_the_deviation_of_what_the_camera_sees(self):
        still = np.zeros((200, 160, F))
        left = corrupt.kinect(still, JOINTS, seed=0)
        fresh = left.known & np.roll(left.known, 1, axis=1)  # a held value repeats
        deviation = np.sqrt(np.where(fresh, left.features**2, 0).sum(axis=(0, 1)) / fresh.sum(axis=(0, 1)))
        np.testing.assert_allclose(left.noise, deviation, rtol=0.05)

    def test_noisy_values_are_not_exact(self):
        left = corrupt.kinect(windows(), JOINTS, seed=0)
        assert not left.exact[..., 3:].any()
        exact = corrupt.zeros(windows(), MEAN, seed=0)
        assert np.array_equal(exact.exact, exact.known)


class TestStructured:
    @pytest.fixture
    def left(self):
        return corrupt.structured(windows(400), MEAN, JOINTS, seed=0)

    def test_known_values_are_the_motion_and_lost_ones_the_mean(self, left):
        exact = ~self.of_camera(left)
        motion = windows(400)
        assert np.array_equal(left.features[exact], np.where(left.known, motion, MEAN)[exact])

    def of_camera(self, left):
        """Only the camera changes values that it sees."""
        return (np.where(left.known, left.features - windows(400), 0) != 0).any(axis=(1, 2))

    def test_each_way_is_as_frequent(self, left):
        whole = ~left.known.any(axis=2)  # frames
        at_random = (left.known.any(axis=2) & ~left.known.all(axis=2)).all(axis=1)
        camera = self.of_camera(left)
        period = np.array([len(set(np.diff(np.flatnonzero(~frames)))) == 1 and frames.any() for frames in whole])
        keys, spans = period & whole[:, :26].any(axis=1), whole.any(axis=1) & ~period
        limbs = ~left.known.all(axis=(1, 2)) & ~whole.any(axis=1) & ~camera
        for share in (keys.mean(), spans.mean(), camera.mean(), (limbs | at_random).mean() / 2):
            assert share == pytest.approx(0.2, abs=0.06)

    def test_limbs_are_whole(self, left):
        """Where single joints are lost, their coordinates are lost together, with all joints below."""
        joints = left.known[..., :-3].reshape(400, 160, 20, 3)
        whole = (joints.all(axis=3) == joints.any(axis=3)).all(axis=(1, 2)) & ~self.of_camera(left)
        seen = joints[whole].all(axis=3)
        for joint, parent in enumerate(JOINTS.parents):
            if JOINTS.names[joint] in ("LeftHandIndex", "RightHandIndex", "LeftToeBase", "RightToeBase"):
                assert not (seen[..., joint] & ~seen[..., parent]).any()

    def test_same_seed_same_result(self):
        first, again = (corrupt.structured(windows(10), MEAN, JOINTS, seed=5) for _ in range(2))
        assert np.array_equal(first.features, again.features)


@pytest.mark.parametrize("name", ["zeros", "missing", "stepped_keys", "kinect", "structured"])
def test_bad_input(name):
    rng = np.random.default_rng(0)
    function = {
        "zeros": lambda features, mean=MEAN: corrupt.zeros(features, mean, seed=rng),
        "missing": lambda features, mean=MEAN: corrupt.missing(features, mean, joints=[1]),
        "stepped_keys": lambda features: corrupt.stepped_keys(features),
        "kinect": lambda features: corrupt.kinect(features, JOINTS, seed=rng),
        "structured": lambda features, mean=MEAN: corrupt.structured(features, mean, JOINTS, seed=rng),
    }[name]
    with pytest.raises(ValueError, match=r"features: expected shape \(n, T, F\)"):
        function(np.zeros((160, F)))
    with pytest.raises(ValueError, match=r"features: nan at index \(0, 0, 0\)"):
        function(np.full((1, 2, F), np.nan))
    with pytest.raises(TypeError, match="features: expected real numbers"):
        function(np.zeros((1, 2, F), bool))
    if name in ("zeros", "missing", "structured"):
        with pytest.raises(ValueError, match=r"mean: expected shape \(F,\) = \(63,\)"):
            function(windows(), MEAN[1:])
    motion = windows()
    before = motion.copy()
    function(motion)
    assert np.array_equal(motion, before)
