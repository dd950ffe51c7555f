"""Inverse kinematics: unchanged motion returns exactly, reachable targets are reached, bones keep their lengths."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dialects import CHAINS, dialect
from npss_baselines.data import mapping
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.motion import NAMES
from npss_baselines.manifold.motion.onto_skeleton import onto_skeleton


def moving(name, seed=0, n_frames=6, size=0.4):
    """Return random motion on the skeleton of a dialect, and its mapping."""
    skeleton, _ = dialect(name)
    rng = np.random.default_rng(seed)
    turns = Rotation.from_rotvec(size * rng.normal(size=(n_frames * len(skeleton.names), 3))).as_matrix()
    translations = np.tile(skeleton.offsets, (n_frames, 1, 1))
    translations[:, 0] += rng.normal(size=(n_frames, 3))
    channels = tuple(("Zrotation", "Xrotation", "Yrotation") for _ in skeleton.names)
    motion = Bvh(skeleton, channels, turns.reshape(n_frames, -1, 3, 3), translations, 30.0)
    return motion, mapping.guess(skeleton)


@pytest.mark.parametrize("name", CHAINS)
def test_motion_that_did_not_change_returns(name):
    motion, joints = moving(name)
    fitted = onto_skeleton(joints.positions(motion.positions(), motion.skeleton), motion, joints)
    np.testing.assert_allclose(fitted.motion.rotations, motion.rotations, rtol=0, atol=1e-9)
    np.testing.assert_allclose(fitted.motion.translations, motion.translations, rtol=0, atol=1e-9)
    assert fitted.error.max() < 1e-9


@pytest.mark.parametrize("name", CHAINS)
def test_targets_that_a_limb_can_reach_are_reached(name):
    """An elbow and a knee that bend otherwise, and hips elsewhere: rotations of single joints, so there is no error."""
    motion, joints = moving(name)
    other = motion.rotations.copy()
    rng = np.random.default_rng(1)
    for common in ("LeftForeArm", "RightLeg", "LeftUpLeg", "RightHand"):
        index = motion.skeleton.names.index(joints.joints[common])
        other[:, index] = Rotation.from_rotvec(rng.normal(size=(6, 3))).as_matrix()
    moved = motion.translations.copy()
    moved[:, 0] += [1, 2, 3]
    places = motion.skeleton.positions(other, offsets=moved)
    fitted = onto_skeleton(joints.positions(places, motion.skeleton), motion, joints)
    np.testing.assert_allclose(fitted.error, 0, atol=1e-9)
    now, wanted = (joints.positions(p, motion.skeleton) for p in (fitted.motion.positions(), places))
    made = [NAMES.index(joint) for joint, of in joints.joints.items() if of is None]
    kept = [j for j in range(len(NAMES)) if j not in made]
    np.testing.assert_allclose(now[:, kept], wanted[:, kept], rtol=0, atol=1e-9)


def test_bones_keep_their_lengths_and_the_error_is_stated():
    motion, joints = moving("mixamo")
    rng = np.random.default_rng(2)
    targets = joints.positions(motion.positions(), motion.skeleton) + 0.05 * rng.normal(size=(6, 20, 3))
    fitted = onto_skeleton(targets, motion, joints)
    for j, parent in enumerate(motion.skeleton.parents):
        if parent >= 0:
            bone = fitted.motion.positions()[:, j] - fitted.motion.positions()[:, parent]
            np.testing.assert_allclose(
                np.linalg.norm(bone, axis=-1), np.linalg.norm(motion.skeleton.offsets[j]), rtol=1e-9
            )
    assert 0 < fitted.error.mean() < 0.1
    before = np.linalg.norm(joints.positions(motion.positions(), motion.skeleton) - targets, axis=-1)
    assert fitted.error.mean() < before.mean()
    np.testing.assert_allclose(np.linalg.det(fitted.motion.rotations), 1, rtol=1e-9)


def test_a_bone_may_turn_right_round():
    """The smallest rotation to the opposite direction is any half turn; it must be one."""
    motion, joints = moving("lafan1", size=0.0)
    targets = joints.positions(motion.positions(), motion.skeleton)
    elbow, hand = NAMES.index("LeftForeArm"), NAMES.index("LeftHand")
    targets[:, hand] = 2 * targets[:, elbow] - targets[:, hand]
    fitted = onto_skeleton(targets, motion, joints)
    now = joints.positions(fitted.motion.positions(), motion.skeleton)
    np.testing.assert_allclose(now[:, hand], targets[:, hand], rtol=0, atol=1e-6)


def test_frames_must_fit():
    motion, joints = moving("lafan1")
    with pytest.raises(ValueError, match=r"^targets: 5 frames, but the motion has 6"):
        onto_skeleton(np.zeros((5, 20, 3)), motion, joints)
