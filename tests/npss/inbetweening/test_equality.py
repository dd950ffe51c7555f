"""In-betweening of generated motion, against definitions that share no code with npss."""

import numpy as np
import pytest

import lafan1 as oracle
import npss
from npss.inbetweening import (
    BASELINES,
    Local,
    forward,
    l2p,
    l2q,
    lafan1,
    measure,
    train_statistics,
    transition,
    windows,
)
from npss.rotations import euler_to_quaternion
from npss.skeleton import Skeleton

SKELETON = Skeleton(oracle.NAMES, oracle.PARENTS, oracle.OFFSETS)
TRAIN, TEST = [(1, 96), (2, 51)], [(3, 146), (4, 66), (5, 65)]  # seeds and lengths; the last is too short for a window


def local(angles, root):
    return Local(euler_to_quaternion(np.radians(angles), seq="ZYX"), root)


@pytest.fixture(scope="module")
def train_clips():
    return [oracle.clip(*what) for what in TRAIN]


@pytest.fixture(scope="module")
def test_clips():
    return [oracle.clip(*what) for what in TEST]


@pytest.fixture(scope="module")
def expected_windows(test_clips):
    return [w for angles, root in test_clips for w in oracle.windows_of(oracle.local_of(angles), root, 65, 40)]


@pytest.fixture(scope="module")
def expected_statistics(train_clips):
    return oracle.statistics(
        [w for angles, root in train_clips for w in oracle.windows_of(oracle.local_of(angles), root, 50, 20)]
    )


def test_motion_passes_half_a_turn(test_clips):
    """Otherwise signs would be right by chance."""
    w = np.array([joint[0] for pose in oracle.local_of(test_clips[0][0]) for joint in pose])
    assert (w < 0).any()
    assert (w > 0).any()


def test_windows(test_clips, expected_windows):
    cut = windows([local(*clip) for clip in test_clips])
    assert cut.quaternions.shape == (4, 65, 22, 4)
    assert len(expected_windows) == 4  # 146 frames: starts 0, 40 and 80, since 80 + 65 < 146; 66: 0; 65: none
    for i, (quaternions, root) in enumerate(expected_windows):
        np.testing.assert_allclose(cut.root[i], root, atol=1e-9)
        signs = np.sign((cut.quaternions[i] * quaternions).sum(axis=-1))
        assert (signs == signs[0]).all()  # a sign for each joint, from the first frame of its clip
        np.testing.assert_allclose(cut.quaternions[i] * signs[..., np.newaxis], quaternions, atol=1e-12)


def test_statistics(train_clips, expected_statistics):
    computed = train_statistics((local(*clip) for clip in train_clips), SKELETON)
    for one, other in zip(computed, expected_statistics, strict=True):
        np.testing.assert_allclose(one.ravel(), other, atol=1e-9)


@pytest.mark.parametrize("n", oracle.LENGTHS)
@pytest.mark.parametrize("name", BASELINES)
def test_rows(test_clips, expected_windows, expected_statistics, name, n):
    predictor = {"zero-velocity": oracle.zero_velocity, "interpolation": oracle.interpolation}[name]
    expected = oracle.row(expected_windows, predictor, n, *expected_statistics)
    parts = transition(windows([local(*clip) for clip in test_clips]), n)
    gt, pred = forward(parts.truth, SKELETON), forward(BASELINES[name](parts), SKELETON)
    mean, std = expected_statistics
    record = measure(gt, pred, mean=mean, std=std, protocol=lafan1, model=name)
    numbers = record["metrics"]["L2Q"], record["metrics"]["L2P"], record["npss"]["released"]
    np.testing.assert_allclose(numbers, expected, rtol=1e-9)
    alone = l2q(gt.quaternions, pred.quaternions), l2p(gt.positions, pred.positions, mean=mean, std=std)
    assert alone == numbers[:2]
    flat = (motion.quaternions.reshape(4, n, 88) for motion in (gt, pred))
    assert npss.score(*flat, convention="released") == pytest.approx(numbers[2], rel=1e-12)
    past = forward(parts.past, SKELETON).quaternions[:, -1]
    anchored = measure(gt, pred, mean=mean, std=std, past=past, hemisphere="anchored")
    np.testing.assert_allclose(anchored["metrics"]["L2Q"], expected[0], rtol=1e-9)


def test_forward_is_that_of_skeletons(test_clips):
    """Global rotations and positions agree with those from matrices; signs follow from products."""
    from npss.rotations import quaternion_to_matrix

    motion = local(*test_clips[1])
    computed = forward(motion, SKELETON)
    expected = SKELETON.forward(quaternion_to_matrix(motion.quaternions), root=motion.root)
    np.testing.assert_allclose(computed.positions, expected.positions, atol=1e-9)
    np.testing.assert_allclose(quaternion_to_matrix(computed.quaternions), expected.rotations, atol=1e-12)
    q, _ = oracle.world(motion.quaternions[7], motion.root[7])
    np.testing.assert_allclose(computed.quaternions[7], q, atol=1e-12)
