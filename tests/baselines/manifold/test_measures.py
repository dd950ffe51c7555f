"""Tests of measures: loops over frames and joints, and motions with measure zero."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import npss
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.motion import measures

pytestmark = pytest.mark.numeric

SHAPE = (3, 12, 20, 3)
ANKLE = JOINTS.names.index("LeftFoot")


def motions(seed=0):
    return np.random.default_rng(seed).normal(size=SHAPE)


@pytest.fixture
def mask():
    mask = np.ones(SHAPE[:2], bool)
    mask[1, 7:] = mask[2, 2:] = False
    return mask


@pytest.fixture
def rest():
    """Return motion that stands still."""
    return np.broadcast_to(JOINTS.positions(np.tile(np.eye(3), (20, 1, 1))), SHAPE).copy()


class TestJointError:
    def test_the_mean_distance_of_frames_that_count(self, mask):
        gt, pred = motions(0), motions(1)
        distances = [
            np.sqrt(sum((gt[i, t, j, axis] - pred[i, t, j, axis]) ** 2 for axis in range(3)))
            for i, t in zip(*np.nonzero(mask), strict=True)
            for j in range(20)
        ]
        assert measures.joint_error(gt, pred, mask) == pytest.approx(np.mean(distances))

    def test_padding_does_not_count(self, mask):
        gt, pred = motions(0), motions(1)
        before = measures.joint_error(gt, pred, mask)
        pred[~mask] = 1e9
        assert measures.joint_error(gt, pred, mask) == before

    def test_bad_input(self, mask):
        with pytest.raises(ValueError, match="pred: its shape"):
            measures.joint_error(motions(), motions()[1:], mask)
        with pytest.raises(ValueError, match=r"mask: its shape \(2, 12\) does not fit"):
            measures.joint_error(motions(), motions(), mask[1:])
        with pytest.raises(ValueError, match="mask: no frame counts"):
            measures.joint_error(motions(), motions(), ~np.ones_like(mask))


class TestBoneError:
    def test_valid_skeleton_has_no_error(self, rest, mask):
        assert measures.bone_error(rest, JOINTS, mask) == pytest.approx(0, abs=1e-12)
        turns = Rotation.random(3 * 12 * 20, random_state=np.random.default_rng(0)).as_matrix()
        moving = JOINTS.positions(turns.reshape(*SHAPE, 3))
        assert measures.bone_error(moving, JOINTS, mask) == pytest.approx(0, abs=1e-12)

    def test_the_mean_over_bones_and_frames_that_count(self, mask):
        positions, errors = motions(), []
        for i, t in zip(*np.nonzero(mask), strict=True):
            for j, parent in enumerate(JOINTS.parents):
                if parent >= 0:
                    length = np.linalg.norm(positions[i, t, j] - positions[i, t, parent])
                    right = np.linalg.norm(JOINTS.offsets[j])
                    errors.append(abs(length - right) / right)
        assert measures.bone_error(positions, JOINTS, mask) == pytest.approx(np.mean(errors))

    def test_twice_the_size_is_an_error_of_one(self, rest, mask):
        assert measures.bone_error(2 * rest, JOINTS, mask) == pytest.approx(1)

    def test_a_constant_wrong_length_is_an_error_too(self, rest, mask):
        rest[:, :, ANKLE] += [0.1, 0, 0]
        assert measures.bone_error(rest, JOINTS, mask) > 0.01


class TestFootSpeed:
    def test_standing(self, rest, mask):
        assert measures.foot_speed(rest, JOINTS, mask, fps=30) == 0

    def test_sliding_on_the_ground(self, rest, mask):
        rest += np.arange(12)[:, np.newaxis, np.newaxis] * [0.03, 0, 0.04]
        assert measures.foot_speed(rest, JOINTS, mask, fps=30) == pytest.approx(0.05 * 30)

    def test_feet_in_the_air_do_not_count(self, rest, mask):
        feet = [JOINTS.names.index(name) for name in measures.FEET if name.startswith("Left")]
        moving = rest.copy()
        moving[:, :, feet, 0] += np.arange(12)[:, np.newaxis]
        moving[:, :, feet, 1] += 2 * measures.NEAR
        assert measures.foot_speed(moving, JOINTS, mask, fps=30) == 0
        moving[:, :, feet, 1] = rest[:, :, feet, 1]
        assert measures.foot_speed(moving, JOINTS, mask, fps=30) > 1

    def test_vertical_motion_does_not_count(self, rest, mask):
        rest[..., 1] += 0.01 * (np.arange(12) % 2)[:, np.newaxis]
        assert measures.foot_speed(rest, JOINTS, mask, fps=30) == 0

    def test_by_a_loop(self, mask):
        positions = motions() * [1, 0.015, 1]
        speeds = []
        feet = [JOINTS.names.index(name) for name in measures.FEET]
        for i in range(3):
            lowest = min(positions[i, t, j, 1] for t in np.flatnonzero(mask[i]) for j in feet)
            for t in range(1, 12):
                for j in feet:
                    pair = positions[i, [t - 1, t], j]
                    if mask[i, t] and mask[i, t - 1] and (pair[:, 1] - lowest < measures.NEAR).all():
                        speeds.append(np.hypot(*(pair[1] - pair[0])[[0, 2]]) * 30)
        assert 10 < len(speeds) < 100
        assert measures.foot_speed(positions, JOINTS, mask, fps=30) == pytest.approx(np.mean(speeds))

    def test_never_on_the_ground_twice(self, rest):
        rest[:, ::2, :, 1] += 1
        assert np.isnan(measures.foot_speed(rest, JOINTS, np.ones(SHAPE[:2], bool), fps=30))

    def test_a_skeleton_without_feet(self):
        from npss.skeleton import Skeleton

        stick = Skeleton(["a", "b"], [-1, 0], [[0, 0, 0], [0, 1, 0]])
        with pytest.raises(ValueError, match="skeleton: missing joints LeftFoot"):
            measures.foot_speed(np.zeros((1, 2, 2, 3)), stick, np.ones((1, 2), bool), fps=30)


class TestPowerError:
    def test_whole_windows(self, mask):
        gt, pred = motions(0), motions(1)
        assert measures.power_error(gt, pred, mask) == npss.score(gt[0].reshape(12, 60), pred[0].reshape(12, 60))

    def test_no_whole_window(self, mask):
        assert np.isnan(measures.power_error(motions(), motions(1), mask & (np.arange(12) > 0)))
