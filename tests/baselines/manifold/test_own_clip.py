"""Clips of one's own: features that did not change give the file back, and changes arrive on the skeleton."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dialects import CHAINS, swaying
from npss_baselines.data import mapping
from npss_baselines.data.motion import NAMES
from npss_baselines.manifold.motion.own_clip import prepare_clip


def clip_of(name, **options):
    motion = swaying(name, **options)
    return prepare_clip(motion, mapping.guess(motion.skeleton))


@pytest.mark.parametrize("name", CHAINS)
def test_unchanged_features_give_the_clip_back(name):
    clip = clip_of(name)
    fitted = clip.back(clip.features)
    np.testing.assert_allclose(fitted.motion.rotations, clip.motion.rotations, rtol=0, atol=1e-9)
    np.testing.assert_allclose(fitted.motion.translations, clip.motion.translations, rtol=0, atol=1e-7)
    assert fitted.error.max() < 1e-7


@pytest.mark.parametrize("fps", [24.0, 30.0, 60.0, 120.0])
@pytest.mark.parametrize("name", ["lafan1", "bandai"])
def test_a_change_arrives_on_the_skeleton(name, fps):
    """A raised hand and a longer stride: prepared again, the clip has the changed features."""
    clip = clip_of(name, fps=fps)
    changed = clip.features.copy()
    hill = np.sin(np.linspace(0, np.pi, len(changed))) ** 2
    elbow, hand = (3 * NAMES.index(joint) for joint in ("LeftForeArm", "LeftHand"))
    bone = clip.features[:, hand : hand + 3] - clip.features[:, elbow : elbow + 3]
    raised = Rotation.from_rotvec(np.outer(0.5 * hill, [0, 0, 1])).apply(bone)
    tip = 3 * NAMES.index("LeftHandIndex")
    changed[:, hand : hand + 3] += raised - bone
    changed[:, tip : tip + 3] += raised - bone
    changed[:, -1] *= 1.2
    fitted = clip.back(changed)
    again = prepare_clip(fitted.motion, clip.mapping).features
    kept = [
        i
        for joint in NAMES
        if "HandIndex" not in joint
        for i in range(3 * NAMES.index(joint), 3 * NAMES.index(joint) + 3)
    ]
    before = np.abs(changed - clip.features)[:, kept].max()
    assert before > 0.02
    # What lies between the frames of two rates is not determined.
    assert np.abs(again - changed)[:, kept].max() < 0.1 * before
    path = np.abs(again - changed)[1:-1, -3:].max()
    assert path < 0.05 * np.abs(changed - clip.features)[:, -1].max()


def test_fast_details_stay():
    """A tremor of 20 Hz, which 30 frames per second cannot hold, is still there after a slow change."""
    clip = clip_of("lafan1", fps=120.0)
    hand = clip.motion.skeleton.names.index("LeftForeArm")
    t = np.arange(len(clip.motion.rotations)) / 120
    rotations = clip.motion.rotations.copy()
    rotations[:, hand] = (
        rotations[:, hand] @ Rotation.from_rotvec(np.outer(0.05 * np.sin(2 * np.pi * 20 * t), [0, 1, 0])).as_matrix()
    )
    shaken = type(clip.motion)(clip.motion.skeleton, clip.motion.channels, rotations, clip.motion.translations, 120.0)
    own = prepare_clip(shaken, clip.mapping)
    changed = own.features.copy()
    changed[:, 3 * NAMES.index("Head") + 1] += 0.01
    result = own.back(changed).motion
    np.testing.assert_allclose(result.rotations[:, hand], rotations[:, hand], rtol=0, atol=1e-6)
    assert np.abs(result.positions() - shaken.positions()).max() > 0.1
