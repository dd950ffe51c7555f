"""L2Q and L2P: variants against loops, signs, and refused input."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss
from npss.inbetweening import Global, Statistics, l2p, l2q, measure

HEMISPHERES, NORMS = ("anchored", "nearest", "given"), ("pose", "joint", "rmse")


def turning(seed, shape=(2, 6, 3)):
    """Return smooth unit quaternions ``(N, T, J, 4)``, some of which pass half a turn."""
    rng = np.random.default_rng(seed)
    axis = rng.normal(size=(shape[0], 1, shape[2], 3))
    axis /= np.linalg.norm(axis, axis=-1, keepdims=True)
    angle = rng.uniform(-3, 3, (shape[0], 1, shape[2], 1)) + rng.uniform(-0.9, 0.9, axis.shape[:-1] + (1,)) * np.arange(
        shape[1]
    ).reshape(1, -1, 1, 1)
    return np.concatenate([np.cos(angle / 2), np.sin(angle / 2) * axis], axis=-1)


def near(gt, seed, size=0.2):
    pred = gt + np.random.default_rng(seed).normal(0, size, gt.shape)
    return pred / np.linalg.norm(pred, axis=-1, keepdims=True)


def by_loops(gt, pred, norm):
    """Return the distance by its definition, without choosing signs."""
    windows = []
    for truth, prediction in zip(gt, pred, strict=True):
        frames, squares = [], []
        for pose, other in zip(truth, prediction, strict=True):
            joints = [math.dist(a, b) for a, b in zip(pose, other, strict=True)]
            frames.append(math.hypot(*joints) if norm == "pose" else sum(joints) / len(joints))
            squares += [(a - b) ** 2 for a, b in zip(pose.ravel(), other.ravel(), strict=True)]
        windows.append(math.sqrt(sum(squares) / len(squares)) if norm == "rmse" else sum(frames) / len(frames))
    return sum(windows) / len(windows)


@pytest.mark.parametrize("norm", NORMS)
@given(seed=st.integers(0, 2**32 - 1))
def test_variants_are_their_definitions(norm, seed):
    gt = turning(seed)
    pred = near(gt, seed)
    assert l2q(gt, pred, hemisphere="given", norm=norm) == pytest.approx(by_loops(gt, pred, norm), rel=1e-12)
    gt, pred = 50 * gt[..., 1:], 50 * pred[..., 1:]
    assert l2p(gt, pred, unit="cm", norm=norm) == pytest.approx(by_loops(gt, pred, norm), rel=1e-12)
    mean, std = np.random.default_rng(seed).uniform(1, 9, (2, 3, 3))
    expected = by_loops((gt - mean) / std, (pred - mean) / std, norm)
    assert l2p(gt, pred, mean=mean, std=std, norm=norm) == pytest.approx(expected, rel=1e-12)


@given(seed=st.integers(0, 2**32 - 1))
def test_signs(seed):
    """Signs change nothing, where a prediction is nearer than half a turn; as given, they do."""
    gt = turning(seed)
    pred = near(gt, seed)
    flips = np.random.default_rng(seed).choice([-1, 1], (2, *gt.shape[:3], 1))
    expected = l2q(gt, pred, hemisphere="given")
    for hemisphere in ("anchored", "nearest"):
        assert l2q(gt, pred, hemisphere=hemisphere) == expected
        assert l2q(gt * flips[0], pred * flips[1], hemisphere=hemisphere) == pytest.approx(expected, rel=1e-12)
        assert l2q(gt * flips[0], pred, past=-gt[:, 0], hemisphere=hemisphere) == pytest.approx(expected, rel=1e-12)
    assert l2q(gt, pred * flips[0], hemisphere="given") >= expected
    nearest = np.minimum(np.linalg.norm(gt - pred, axis=-1), np.linalg.norm(gt + pred, axis=-1))
    assert l2q(gt * flips[0], pred, hemisphere="nearest", norm="joint") == pytest.approx(nearest.mean(), rel=1e-12)


def test_anchored_is_continuous_in_time():
    """A prediction that turns away through half a turn keeps its hemisphere; the nearest sign does not."""
    gt = np.tile([1.0, 0, 0, 0], (1, 8, 1, 1))
    half = np.linspace(0, np.pi * 0.9, 8)  # turns by 324 degrees
    pred = np.stack([np.cos(half), np.sin(half), 0 * half, 0 * half], axis=-1).reshape(1, 8, 1, 4)
    assert l2q(gt, pred) == l2q(gt, pred, hemisphere="given") == pytest.approx(2 * np.sin(half / 2).mean())
    assert l2q(gt, pred, hemisphere="nearest") < l2q(gt, pred)


def test_five_joints_in_the_other_hemisphere():
    gt = turning(0, (3, 5, 22))
    pred = gt.copy()
    pred[:, :, 3:8] *= -1
    assert l2q(gt, pred) == l2q(gt, pred, hemisphere="nearest") == 0
    assert l2q(gt, pred, hemisphere="given") == pytest.approx(math.sqrt(4 * 5)) == pytest.approx(4.472, abs=5e-4)


def test_the_euler_error_of_all_columns_is_the_same():
    gt = turning(1)
    pred = near(gt, 2)
    flat = (q.reshape(2, 6, 12) for q in (gt, pred))
    curve = npss.euler_error_curve(*flat, columns="all")
    assert l2q(gt, pred, hemisphere="given") == pytest.approx(curve.mean(), rel=1e-12)


def test_precision_of_the_input():
    gt = turning(3)
    pred = near(gt, 4)
    single = l2q(gt.astype(np.float32), pred.astype(np.float32))
    assert single == pytest.approx(l2q(gt, pred), rel=1e-6)
    half = l2q(gt.astype(np.float16), pred.astype(np.float16))
    assert half == pytest.approx(l2q(gt, pred), rel=1e-2)


def test_statistics(tmp_path):
    rng = np.random.default_rng(5)
    gt, pred = rng.normal(size=(2, 3, 4, 5, 3))
    stats = Statistics(rng.normal(size=(5, 3)), rng.uniform(1, 2, (5, 3)))
    expected = l2p(gt, pred, stats=stats)
    assert l2p(gt, pred, mean=stats.mean, std=stats.std) == expected
    for shape in ((15,), (1, 15, 1)):
        assert l2p(gt, pred, mean=stats.mean.reshape(shape), std=stats.std.reshape(shape)) == expected
    path = tmp_path / "stats.npz"
    np.savez(path, **stats._asdict())
    assert l2p(gt, pred, stats=path) == l2p(gt, pred, stats=str(path)) == expected
    np.savez(path, mean=stats.mean)
    with pytest.raises(ValueError, match=rf"{re.escape(str(path))}: no array 'std' in it"):
        l2p(gt, pred, stats=path)
    with pytest.raises(ValueError, match=r"none.npz: No such file"):
        l2p(gt, pred, stats=tmp_path / "none.npz")
    with pytest.raises(ValueError, match=r"stats: .*mean.pkl: expected a \.npz file"):
        l2p(gt, pred, stats=tmp_path / "mean.pkl")


GT, PRED = turning(6), near(turning(6), 7)
X, Y = GT[..., 1:], PRED[..., 1:]


@pytest.mark.parametrize(
    ("arguments", "options", "message"),
    [
        ((GT[0], PRED[0]), {}, r"gt: expected shape \(N, T, J, 4\).*got \(6, 3, 4\); pass one sequence as x\[None\]"),
        ((GT[..., 0], PRED[..., 0]), {}, r"gt: expected shape \(N, T, J, 4\) or \(N, T, 4 J\), got \(2, 6, 3\)"),
        ((GT[0, :, 0], PRED[0, :, 0]), {}, r"gt: expected shape \(N, T, J, 4\) or \(N, T, 4 J\), got \(6, 4\)"),
        ((GT.reshape(2, 6, 12), PRED), {}, r"pred: its shape \(2, 6, 3, 4\) differs from that of gt, \(2, 6, 12\)"),
        ((GT, PRED[:1]), {}, r"pred: its shape .* differs from that of gt"),
        ((GT, PRED * 1.2), {}, r"pred: expected unit quaternions, got one of length 1\.2 at index \(0, 0, 0\)"),
        ((GT * 0, PRED), {}, r"gt: expected unit quaternions, got one of length 0 "),
        ((GT, np.where(GT > 2, 0, np.nan)), {}, r"pred: nan at index"),
        ((GT, PRED), {"hemisphere": "north"}, r"hemisphere: expected one of anchored, nearest, given"),
        ((GT, PRED), {"norm": "l2"}, r"norm: expected one of pose, joint, rmse, got 'l2'"),
        (
            (GT, PRED),
            {"past": GT},
            r"past: expected the quaternions of the last past frame, \(2, 3, 4\) or \(2, 12\), got",
        ),
        ((GT, PRED), {"past": GT[:, 0], "hemisphere": "given"}, r"past: only for hemisphere='anchored'"),
    ],
)
def test_l2q_refuses(arguments, options, message):
    with pytest.raises(ValueError, match=message):
        l2q(*arguments, **options)


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({}, ValueError, "stats: expected one of mean and std, stats, unit; got none"),
        ({"unit": "m", "mean": np.ones((3, 3))}, ValueError, "got mean, std and unit"),
        ({"mean": np.ones((3, 3))}, ValueError, "std: expected both mean and std"),
        ({"unit": "feet"}, ValueError, "unit: expected one of m, cm, mm"),
        (
            {"mean": np.ones((3, 3)), "std": np.eye(3)},
            ValueError,
            r"std: expected positive numbers, got 0\.0 for joint 0, y",
        ),
        (
            {"mean": np.ones((3, 3)), "std": np.ones(3)},
            ValueError,
            r"std: expected shape \(3, 3\), \(9,\) or \(1, 9, 1\)",
        ),
        ({"mean": np.full((3, 3), np.inf), "std": np.ones((3, 3))}, ValueError, r"mean: inf at index \(0, 0\)"),
        ({"stats": np.ones((2, 3, 3))}, TypeError, r"stats: expected Statistics\(mean, std\) or a path, got ndarray"),
    ],
)
def test_l2p_refuses(options, error, message):
    with pytest.raises(error, match=message):
        l2p(X, Y, **options)


@pytest.mark.parametrize("norm", NORMS)
def test_layouts(norm):
    """Joints or features; lists, and frames that count, of unequal length: the mean over sequences."""
    flat = [q.reshape(2, 6, 12) for q in (GT, PRED)]
    assert l2q(*flat, norm=norm) == l2q(GT, PRED, norm=norm)
    assert l2q(*flat, past=-GT[:, 0], norm=norm) == l2q(GT, PRED, past=-GT[:, 0].reshape(2, 12), norm=norm)
    assert l2p(X.reshape(2, 6, 9), Y.reshape(2, 6, 9), unit="m", norm=norm) == l2p(X, Y, unit="m", norm=norm)
    lists = [[q[0], q[1, :4]] for q in (GT, PRED)]
    expected = (l2q(GT[:1], PRED[:1], norm=norm) + l2q(GT[1:, :4], PRED[1:, :4], norm=norm)) / 2
    assert l2q(*lists, norm=norm) == pytest.approx(expected, rel=1e-12)
    padded = [np.where(np.arange(6)[:, np.newaxis, np.newaxis] < 4, q, np.nan) for q in (GT[1], PRED[1])]
    arrays = [np.stack([q[0], rest]) for q, rest in zip((GT, PRED), padded, strict=True)]
    assert l2q(*arrays, lengths=[6, 4], norm=norm) == pytest.approx(expected, rel=1e-12)
    arrays = [q[..., 1:] for q in arrays]
    expected = (l2p(X[:1], Y[:1], unit="m", norm=norm) + l2p(X[1:, :4], Y[1:, :4], unit="m", norm=norm)) / 2
    assert l2p(*arrays, lengths=[6, 4], unit="m", norm=norm) == pytest.approx(expected, rel=1e-12)


def test_past_of_unequal_lengths():
    lists = [[q[1, :4], q[0]] for q in (GT, -PRED)]
    past = GT[::-1, 0]
    assert l2q(*lists, past=past) == pytest.approx(l2q(*([q[0], q[1, :4]] for q in (GT, PRED))), rel=1e-12)


def test_tensors():
    """Gradients are detached, and precision is widened."""
    torch = pytest.importorskip("torch")
    gt, pred = torch.tensor(GT), torch.tensor(PRED, requires_grad=True)
    assert l2q(gt, pred, past=gt[:, 0].requires_grad_()) == l2q(GT, PRED)
    assert l2p(gt[..., 1:], pred[..., 1:], unit="m") == l2p(X, Y, unit="m")
    assert l2q(gt.bfloat16(), pred.bfloat16()) == pytest.approx(l2q(GT, PRED), rel=0.02)
    one, other = Global(gt, gt[..., 1:]), Global(pred, pred[..., 1:])
    assert measure(one, other, unit="m", past=gt[:, 0])["metrics"] == {"L2Q": l2q(GT, PRED), "L2P": l2p(X, Y, unit="m")}


def test_they_are_registered():
    """Records and commands measure them, of features flattened joint by joint, positions as they are."""
    flat = (q.reshape(2, 6, 12) for q in (GT, PRED))
    record = npss.records.measure(*flat, metrics=["l2q", "L2P"], frames=6, conventions=["released"])
    assert record["metrics"]["L2Q"] == l2q(GT, PRED)
    assert record["metrics"]["L2P"] == pytest.approx(l2q(GT, PRED, hemisphere="given"))
    assert record["signatures"]["L2Q"] == "l2q|version:1|frames:6|unwrap:off|hemisphere:anchored|norm:pose"
    assert record["signatures"]["L2P"] == "l2p|version:1|frames:6|unwrap:off|norm:pose"
    with pytest.raises(ValueError, match="gt: expected quaternions, four features for each joint, got 9 features"):
        npss.records.measure(X.reshape(2, 6, 9), Y.reshape(2, 6, 9), metrics=["l2q"])
