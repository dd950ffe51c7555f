"""L2Q and L2P of public evaluation codes: arrays in their shapes, one call each, and definitions from descriptions."""

import numpy as np
import pytest

from npss.inbetweening import Global, Local, forward, l2p, l2q, measure
from npss.rotations import quaternion_to_sixd, sixd_to_quaternion
from npss.skeleton import Skeleton


def turning(*shape, seed=0):
    """Return smooth unit quaternions ``(N, T, J, 4)``."""
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(shape[0], 1, shape[2], 4)) + 0.1 * rng.normal(size=(*shape, 4)).cumsum(axis=1)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def near(q, seed):
    q = q + 0.1 * np.random.default_rng(seed).normal(size=q.shape)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def places(*shape, seed=0):
    return np.random.default_rng(seed).normal(0, 30, (*shape, 3))


def norm(difference, axis):
    return np.sqrt((difference**2).sum(axis=axis))


@pytest.mark.parametrize("n", [5, 15, 30, 45])
def test_1_the_lafan1_benchmark(n):
    """Numpy arrays (N, T, 22, 4); statistics (1, 66, 1)."""
    gt, x = turning(6, n, 22), places(6, n, 22)
    pred, y = near(gt, 1), places(6, n, 22, seed=1)
    mean, std = np.random.default_rng(2).uniform(1, 9, (2, 1, 66, 1))
    record = measure(Global(gt, x), Global(pred, y), mean=mean, std=std, fps=30)
    assert record["metrics"]["L2Q"] == pytest.approx(norm(gt - pred, (2, 3)).mean(), rel=1e-12)
    first, second = ((p.reshape(6, n, 66).transpose(0, 2, 1) - mean) / std for p in (x, y))
    assert record["metrics"]["L2P"] == pytest.approx(norm(first - second, 1).mean(), rel=1e-12)


def test_2_delta_interpolator_on_the_whole_window():
    """float32 tensors, continuous from the last past frame, with context and key frames."""
    torch = pytest.importorskip("torch")
    gt = turning(70, 30, 22)
    pred = near(gt, 1)
    past = gt[:, 0]
    flips = np.random.default_rng(0).choice([-1.0, 1.0], (70, 30, 22, 1))
    tensors = [torch.tensor(q * s, dtype=torch.float32) for q, s in ((gt, 1), (pred, flips))]
    assert l2q(*tensors, past=torch.tensor(past)) == pytest.approx(norm(gt - pred, (2, 3)).mean(), rel=1e-5)


def test_6_long_in_betweening():
    """*Local* 6D rotations and the root, (N, T, J * 6 + 3)."""
    rng = np.random.default_rng(0)
    skeleton = Skeleton(["a", "b", "c", "d"], [-1, 0, 1, 0], rng.normal(size=(4, 3)))
    motions = []
    for seed in (0, 1):
        local = quaternion_to_sixd(turning(3, 15, 4, seed=seed), layout="rows").reshape(3, 15, 24)
        motions.append(np.concatenate([local, places(3, 15, seed=seed)], axis=-1))
    world = []
    for motion in motions:
        local = sixd_to_quaternion(motion[..., :24].reshape(3, 15, 4, 6), layout="rows")
        world.append(forward(Local(local, motion[..., 24:]), skeleton))
    nearer = np.minimum(*(norm(world[0].quaternions - s * world[1].quaternions, 3) for s in (1, -1)))
    expected = np.sqrt((nearer**2).sum(axis=2)).mean()
    assert l2q(world[0].quaternions, world[1].quaternions, hemisphere="nearest") == pytest.approx(expected, rel=1e-12)


def test_8_metres_and_the_nearer_sign():
    """Positions in metres, mean over joints; quaternions by the minimum over the sign, per joint."""
    torch = pytest.importorskip("torch")
    gt, x = turning(4, 30, 22), places(4, 30, 22) / 100
    pred, y = near(gt, 1) * np.random.default_rng(5).choice([-1, 1], (4, 30, 22, 1)), places(4, 30, 22, seed=1) / 100
    expected = np.minimum(norm(gt - pred, 3), norm(gt + pred, 3)).mean()
    tensors = torch.tensor(gt), torch.tensor(pred).requires_grad_()
    assert l2q(*tensors, hemisphere="nearest", norm="joint") == pytest.approx(expected, rel=1e-12)
    assert l2p(x, y, unit="m", norm="joint") == pytest.approx(norm(x - y, 3).mean(), rel=1e-12)


def test_12_clips_of_unequal_length():
    """(T, 22, 4) for each clip; L2Q and L2P as RMSE for each clip, then the plain mean."""
    gt = [turning(1, n, 22, seed=n)[0] for n in (20, 33, 61)]
    pred = [near(q, 1) for q in gt]
    expected = np.mean([np.sqrt(((a - b) ** 2).mean()) for a, b in zip(gt, pred, strict=True)])
    assert l2q(gt, pred, norm="rmse") == pytest.approx(expected, rel=1e-12)
    x, y = ([places(len(q), 22, seed=len(q) + k) for q in gt] for k in (0, 1))
    expected = np.mean([np.sqrt(((a - b) ** 2).mean()) for a, b in zip(x, y, strict=True)])
    assert l2p(x, y, unit="cm", norm="rmse") == pytest.approx(expected, rel=1e-12)
