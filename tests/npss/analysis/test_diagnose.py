"""Pitfalls: each is found where it was planted, with place and count; sound motion has none."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss
from npss import gait
from npss._analysis import diagnose as _diagnose
from npss._analysis.pitfalls import PITFALLS
from npss.commands import main
from npss.files._samples import converted, read_poses
from npss.rotations import (
    continuous,
    continuous_euler,
    euler_to_matrix,
    expmap_to_matrix,
    matrix_to_euler,
    matrix_to_quaternion,
)
from npss.skeleton import poses_to_positions
from npss_baselines.data import h36m
from npss_baselines.data.h36m_source import Human36M

NAMES = (
    *(
        "wrap",
        "gimbal-flip",
        "quaternion-sign",
        "hemisphere",
        "component-order",
        "constant",
        "shift",
        "context",
        "padding",
    ),
    *("poses", "degrees", "axes", "joints", "powerless", "weight", "no-real-power", "share"),
)


def find(gt, pred, pitfall=None):
    """Return all findings but the note on shares, which sound motion has, too; or the findings of one pitfall."""
    found = npss.diagnose(gt, pred)
    assert isinstance(found, tuple)
    for finding in found:
        assert finding.pitfall in NAMES
        assert finding.argument in ("gt", "pred")
        assert type(finding.count) is int
        assert all(type(i) is int for i in finding.where)
        line = str(finding)
        assert finding.severity in ("warning", "note")
        assert line.startswith("note: " * (finding.severity == "note") + f"{finding.argument}: ")
        assert "\n" not in line
    return [
        finding for finding in found if (finding.pitfall != "share" if pitfall is None else finding.pitfall == pitfall)
    ]


def pitfalls(gt, pred):
    return [(finding.pitfall, finding.argument) for finding in find(gt, pred)]


def warned(gt, pred):
    """Return the pitfalls that need action."""
    return [(finding.pitfall, finding.argument) for finding in find(gt, pred) if finding.severity == "warning"]


@cache
def walks(n=4, n_frames=150, seed=0):
    """Return generated gait, as the Euler angles that move; to be copied before it is changed."""
    angles = npss.poses_to_euler(gait.gait(n, n_frames, seed=seed))
    angles = angles[..., angles.any(axis=(0, 1))]
    angles.flags.writeable = False
    return angles


@pytest.fixture
def motion():
    """Ground truth and a prediction, without pitfalls."""
    both = walks()[:, 50:], walks()[:, 50:] + 0.05 * np.random.default_rng(1).normal(size=(4, 100, 48))
    assert find(*both) == []
    return [array.copy() for array in both]


# --- motion that is well ----------------------------------------------------------------------------------------------


def test_names_are_those_of_the_documentation():
    assert tuple(dict.fromkeys(pitfall.name for pitfall in PITFALLS)) == NAMES
    for name in NAMES:
        assert f"- ``{name}``: " in npss.diagnose.__doc__
        assert f"``'{name}'``" in npss.Finding.__doc__


@pytest.mark.parametrize("n_frames", [1, 2, 3, 4, 5, 6, 9, 10, 25, 100])
@pytest.mark.parametrize("seed", range(3))
def test_gait_has_no_pitfall(n_frames, seed):
    angles = walks(seed=seed)
    gt, seen = angles[:, 50 : 50 + n_frames], angles[:, 50 - n_frames : 50] if n_frames <= 50 else angles[:, :n_frames]
    noisy = gt + 0.02 * np.random.default_rng(seed).normal(size=gt.shape)
    for pred in (gt, noisy, 0.7 * gt, seen, gt[:, ::-1], gt[::-1]):
        assert find(gt, pred) == []
        assert find(gt.astype(np.float32), pred.astype(np.float32)) == []
    assert find(gt[0], noisy[0]) == []


@given(
    seed=st.integers(0, 1000),
    n=st.integers(1, 3),
    n_frames=st.integers(25, 60),  # in fewer, one feature may come close to another's past by chance
    scale=st.sampled_from([1e-200, 1e-3, 1.0]),
)
def test_random_walks_of_one_feature_have_no_pitfall(seed, n, n_frames, scale):
    gt, pred = 0.2 * scale * np.random.default_rng(seed).normal(size=(2, n, n_frames, 1)).cumsum(axis=2)
    assert find(gt, pred) == []


@pytest.mark.parametrize("dtype", [np.int8, np.int32, np.uint8, np.float16, np.float32, ">f8"])
def test_any_precision(dtype):
    gt, pred = (np.round(4 + walks(seed=seed)).astype(dtype) for seed in (0, 1))
    assert find(gt, pred) == find(gt.astype(np.float64), pred.astype(np.float64))


@pytest.mark.parametrize("size", [1e150, 1e200, 1.7e308])
def test_huge_values_have_no_pitfall_and_do_not_overflow(size):
    gt, pred = size * np.random.default_rng(0).uniform(-1, 1, size=(2, 3, 40, 8))
    assert find(gt, pred) == []
    assert pitfalls(gt[:, :-1], gt[:, 1:]) == [("shift", "pred")]
    assert pitfalls(gt, np.zeros_like(gt)) == [("constant", "pred")]
    assert find(gt, 1e-5 * pred) == find(1e-5 * gt, pred) == []


@pytest.mark.parametrize("action", ["walking", "eating"])
def test_human36m(h36m_root, action):
    (task,) = Human36M().tasks(h36m_root, (action,))
    gt = npss.poses_to_euler(task.target)
    (finding,) = find(gt, gt)
    assert (finding.pitfall, finding.argument, finding.count) == ("powerless", "gt", 51)
    assert finding.where == tuple(np.flatnonzero(~gt.any(axis=(0, 1))))
    assert str(finding) == "note: gt: 51 features (of 99) are zero throughout, so they do not count"
    assert str(find(gt, gt + 1)[-1]).endswith("do not count, though the prediction is not zero in 51 of them")
    assert warned(gt, gt + 1) == [("powerless", "gt")]
    poses = find(task.target, task.target)[0]
    assert str(poses).startswith("gt: 99 columns, the first 6 not zero: Human3.6M poses?")
    still = np.repeat(npss.poses_to_euler(task.seed_frames)[:, -1:], 100, axis=1)
    for n_frames in (10, 25, 100):
        found = pitfalls(gt[:, :n_frames], still[:, :n_frames])
        assert found == [("constant", "pred"), ("powerless", "gt")]


def test_human36m_smoking_wraps(h36m_root):
    (task,) = Human36M().tasks(h36m_root, ("smoking",))
    gt = npss.poses_to_euler(task.target)
    found = {f"{finding.argument} {finding.pitfall}": finding for finding in find(gt, npss.unwrap(gt))}
    assert set(found) - {"pred context"} == {"gt wrap", "gt gimbal-flip", "pred gimbal-flip", "gt powerless"}
    wrap, flip = found["gt wrap"], found["pred gimbal-flip"]
    assert (wrap.count, wrap.where) == (4, (3, 90, 60))
    assert str(wrap).startswith(
        "note: gt: 4 jumps of about 2 pi between frames, as in the published tables; npss.unwrap"
    )
    assert flip.count == found["gt gimbal-flip"].count
    joints = gt.reshape(*gt.shape[:2], 33, 3)
    mended = continuous_euler(joints, seq="h36m", axis=1).reshape(gt.shape)
    assert pitfalls(mended, mended) == [("powerless", "gt")]


def test_human36m_in_other_units_and_axes(h36m_root):
    (task,) = Human36M().tasks(h36m_root, ["walking"])
    gt = npss.poses_to_euler(task.target)
    assert ("axes", "gt") in pitfalls(gt.swapaxes(1, 2), gt.swapaxes(1, 2))
    assert [one for one in pitfalls(np.degrees(gt), gt) if one[0] == "degrees"] == [
        ("degrees", "gt"),
        ("degrees", "gt"),
    ]


@pytest.mark.parametrize(("action", "clip"), [("walking", 2), ("eating", 1), ("smoking", 2)])  # all have jumps
def test_no_finding_on_human36m_asks_for_action(h36m_root, action, clip):
    """Whole clips of the test subject and windows of them, as angles, positions and quaternions, beside predictions."""
    poses = h36m.load(h36m.open_root(h36m_root), 5, action, clip, fps=25).astype(np.float64)
    angles = npss.poses_to_euler(poses)
    rotations = expmap_to_matrix(poses[:, 3:69].reshape(-1, 22, 3))
    forms = {
        "angles": angles,
        "positions": poses_to_positions(poses).reshape(len(poses), -1),
        "quaternions": continuous(matrix_to_quaternion(rotations), axis=0).reshape(len(poses), -1),
        "two columns": rotations[..., :2].reshape(len(poses), -1),
    }
    for form, motion in forms.items():
        for n_frames in (5, 100, len(motion)):
            count = len(motion) // n_frames
            gt = motion[: count * n_frames].reshape(count, n_frames, -1)
            noise = 0.05 * gt.std(axis=(0, 1)) * np.random.default_rng(0).normal(size=gt.shape)
            seen = np.concatenate([gt[:1], gt[:-1]])[:, ::-1]
            for pred in (gt + noise, 0.98 * gt if form == "quaternions" else seen):
                assert warned(gt, pred.astype(np.float32)) == [], form


def lafan1(n_frames, seed=0):
    """Return past and future quaternions (6, T, 22, 4) of people who turn, continuous over both."""
    rng = np.random.default_rng(seed)
    n, length = 6, 10 + n_frames
    local = gait.gait(n, length, seed=rng)[..., 3:69].reshape(n, length, 22, 3) + rng.normal(size=(n, 1, 22, 3)) / 3
    turn = np.zeros((n, length, 1, 3))
    turn[..., 1] = (rng.uniform(-3, 3, size=(n, 1)) + rng.uniform(-0.3, 0.3, size=(n, 1)) * np.arange(length))[
        ..., np.newaxis
    ]
    q = matrix_to_quaternion(expmap_to_matrix(turn) @ expmap_to_matrix(local))
    whole = continuous(rng.choice([-1.0, 1.0], size=(n, 1, 22, 1)) * q, axis=1)
    return whole[:, :10], whole[:, 10:]


@pytest.mark.parametrize("n_frames", [5, 15, 30, 45])
def test_no_finding_on_quaternions_as_lafan1_s_asks_for_action(n_frames):
    past, gt = lafan1(n_frames)
    assert (gt[..., 0] < -0.5).any()
    noisy = gt + 0.02 * np.random.default_rng(1).normal(size=gt.shape)
    noisy /= np.linalg.norm(noisy, axis=-1, keepdims=True)
    predicted = continuous(np.abs(noisy[..., :1]) / noisy[..., :1] * noisy, axis=1, start=past[:, -1])  # w > 0, mended
    for pred in (gt, noisy, predicted):
        assert warned(gt.reshape(6, n_frames, 88), pred.reshape(6, n_frames, 88)) == []


@pytest.mark.parametrize("file", ["wookay_walking_10000.h5", "wookay_eating_1000.h5"])
def test_published_predictions(capsys, samples_root, file):
    for pair in map(converted, read_poses(samples_root / file)):
        assert pitfalls(pair.gt, pair.pred) == [("powerless", "gt")]
        assert warned(pair.gt, pair.pred) == []
    assert main(["score", str(samples_root / file)]) == 0
    text = capsys.readouterr().out
    assert "Diagnosis:\n- note: gt: 51 features (of 99) are zero throughout" in text


# --- wraps ------------------------------------------------------------------------------------------------------------


@given(data=st.data())
def test_every_wrap_is_counted_and_the_first_named(data):
    gt = walks(n=3, n_frames=40)[..., :5].clip(-1, 1)
    both = {"gt": gt, "pred": gt.copy()}
    argument = data.draw(st.sampled_from(["gt", "pred"]))
    places = data.draw(
        st.sets(st.tuples(st.integers(0, 2), st.integers(0, 38), st.integers(0, 4)), min_size=1, max_size=12)
    )
    steps = np.zeros_like(gt)
    for n, t, d in sorted(places):  # up and down again, as an angle that swings about pi
        turns = steps[n, t + 1, d]
        steps[n, t + 1 :, d] = 0 if turns else 2 * np.pi
    both[argument] = gt + steps - np.pi * steps.any(axis=1, keepdims=True)
    (finding,) = find(**both, pitfall="wrap")
    assert (finding.argument, finding.count, finding.where) == (argument, len(places), min(places))
    assert f"the first at sequence, frame, feature {min(places)}" in str(finding)


def test_wraps_of_one_sequence(motion):
    gt, pred = (array[0] for array in motion)
    gt[31:, 7] += 2 * np.pi - 0.3
    gt[:, 7] -= np.pi
    (finding,) = find(gt, pred)
    assert (finding.pitfall, finding.count, finding.where) == ("wrap", 1, (0, 30, 7))


def test_unwrapping_removes_the_findings(motion):
    gt = motion[0] + 3.0
    wrapped = (gt + np.pi) % (2 * np.pi) - np.pi
    assert pitfalls(wrapped, motion[1]) == [("wrap", "gt")]
    assert find(npss.unwrap(wrapped), motion[1]) == []


@pytest.mark.parametrize("jump", [0.5, 3.0, 5.2, 7.4])
def test_other_jumps_are_no_wraps(motion, jump):
    motion[0][2, 50:, 3] = motion[0][2, 49, 3] + jump - 3.6
    motion[0][2, :50, 3] = motion[0][2, 49, 3] - 3.6
    assert find(*motion, pitfall="wrap") == []


def test_positions_do_not_wrap(motion):
    for array in motion:
        array[..., 0] = 500 + 300 * np.cumsum(array[..., 0], axis=1)  # millimetres: some step of 6.28 is no wrap
    assert find(*motion, pitfall="wrap") == []


# --- quaternions ------------------------------------------------------------------------------------------------------


def quaternions(n=3, n_frames=60, joints=4, seed=0):
    """Return smooth unit quaternions, ``(n, T, 4 * joints)``."""
    steps = np.random.default_rng(seed).normal(size=(n, n_frames, joints, 4)).cumsum(axis=1)
    smooth = 3 * np.array([1, 0.5, 0.3, 0.1]) + 0.05 * steps
    return (smooth / np.linalg.norm(smooth, axis=-1, keepdims=True)).reshape(n, n_frames, 4 * joints)


@given(data=st.data())
def test_every_sign_flip_is_counted_and_the_first_named(data):
    both = {"gt": quaternions(), "pred": quaternions(seed=1)}
    assert find(**both) == []
    argument = data.draw(st.sampled_from(["gt", "pred"]))
    places = data.draw(
        st.sets(st.tuples(st.integers(0, 2), st.integers(0, 58), st.integers(0, 3)), min_size=1, max_size=12)
    )
    for n, t, joint in places:
        both[argument][n, t + 1 :, 4 * joint : 4 * joint + 4] *= -1
    (finding,) = find(**both)
    assert (finding.pitfall, finding.argument) == ("quaternion-sign", argument)
    assert (finding.count, finding.where) == (len(places), min(places))
    assert str(finding).endswith(f"the first at sequence, frame, quaternion {min(places)}")


def test_not_a_sign_flip():
    turned = quaternions()
    turned[..., :4] *= -1  # throughout: no flip
    assert find(turned, quaternions(), pitfall="quaternion-sign") == []
    angles = np.random.default_rng(0).normal(size=(3, 60, 16))  # 16 features, but no unit quaternions
    assert find(angles, -angles, pitfall="quaternion-sign") == []
    flipped = quaternions()
    flipped[:, 30:] *= -1
    assert find(1.1 * flipped, quaternions(), pitfall="quaternion-sign") == []
    assert find(flipped[..., :15], quaternions()[..., :15], pitfall="quaternion-sign") == []
    turn = 1.2 * np.arange(60)[:, np.newaxis]  # radians, half of the rotation between frames: quaternions far apart
    fast = np.concatenate([np.cos(turn), np.sin(turn), 0 * turn, 0 * turn], axis=1)
    assert find(fast, quaternions(joints=1)[0], pitfall="quaternion-sign") == []
    zeros = np.zeros((2, 60, 8))
    assert find(zeros, zeros, pitfall="quaternion-sign") == []


@pytest.mark.parametrize("opposite", [{(0, 0)}, {(1, 2), (2, 0)}, {(n, q) for n in range(3) for q in range(4)}])
def test_the_other_hemisphere(opposite):
    gt = quaternions()
    pred = quaternions(seed=1).reshape(3, 60, 4, 4)
    for n, q in opposite:
        pred[n, :, q] *= -1
    pred = pred.reshape(gt.shape)
    (finding,) = find(gt, pred)
    assert (finding.pitfall, finding.argument, finding.severity) == ("hemisphere", "pred", "warning")
    assert (finding.count, finding.where) == (len(opposite), min(opposite))
    assert str(finding).endswith(f"the first at sequence, quaternion {min(opposite)}")
    start = gt[:, 0].reshape(3, 4, 4)
    mended = continuous(pred.reshape(3, 60, 4, 4), axis=1, start=start).reshape(gt.shape)
    assert find(gt, mended) == []
    assert npss.score(gt, mended) == pytest.approx(npss.score(gt, pred), rel=1e-12)  # as the message says
    assert npss.mse(gt, mended) < npss.mse(gt, pred) / 2
    assert find(1.1 * gt, pred) == find(gt, 1.1 * pred) == []
    pred[:, 50:] *= -1  # not throughout: a flip is what is to be mended
    assert find(gt, pred, pitfall="hemisphere") == []


@pytest.mark.parametrize("size", [0, 0.05, 0.3])
def test_components_in_another_order(size):
    """x, y, z, w beside w, x, y, z, in either motion; not in both, and not for any other prediction."""
    rng = np.random.default_rng(0)
    gt = npss.rotations.expmap_to_quaternion(walks(n=4)[..., :60].reshape(4, -1, 20, 3))
    pred = gt + size * rng.normal(size=gt.shape)
    pred /= np.linalg.norm(pred, axis=-1, keepdims=True)
    (finding,) = find(gt, np.roll(pred, -1, axis=-1), pitfall="component-order")
    assert (finding.argument, finding.severity, finding.count, finding.where) == ("pred", "warning", 4, ())
    assert str(finding).endswith("closer to the ground truth as w, x, y, z: x, y, z, w beside w, x, y, z?")
    (finding,) = find(np.roll(gt, -1, axis=-1), pred, pitfall="component-order")
    assert str(finding).endswith("to the ground truth as x, y, z, w: w, x, y, z beside x, y, z, w?")
    for first, second in ((gt, pred), (np.roll(gt, -1, axis=-1), np.roll(pred, -1, axis=-1)), (gt, -pred)):
        assert find(first, second, pitfall="component-order") == []


def test_components_in_order_give_no_alarm():
    """Whatever the prediction: rotations at random, turned far away, standing still, another person's motion."""
    rng = np.random.default_rng(1)
    gt = npss.rotations.expmap_to_quaternion(walks(n=4)[..., :60].reshape(4, -1, 20, 3))
    still = np.repeat(gt[:, :1], gt.shape[1], axis=1)
    none = np.broadcast_to([1.0, 0, 0, 0], gt.shape)
    for pred in (still, gt[::-1], gt[:, ::-1], none, gt[..., [0, 2, 1, 3]]):
        assert find(gt, pred, pitfall="component-order") == find(pred, gt, pitfall="component-order") == []
    for seed in range(200):
        rng = np.random.default_rng(seed)
        random = rng.normal(size=(2, 1, 5, 2, 4))
        random /= np.linalg.norm(random, axis=-1, keepdims=True)
        assert find(*random, pitfall="component-order") == []
    assert find(rng.normal(size=(2, 9, 8)), rng.normal(size=(2, 9, 8)), pitfall="component-order") == []


def test_a_few_columns_that_look_like_quaternions_are_none():
    gt = np.concatenate([walks()[..., :12], quaternions(n=4, n_frames=150, joints=1)], axis=2)
    assert find(gt, -gt, pitfall="hemisphere") == []
    gt[:, 75:, 12:] *= -1
    assert find(gt, gt, pitfall="quaternion-sign") == []
    assert [one.count for one in find(gt[..., 8:], gt[..., 8:], pitfall="quaternion-sign")] == [4, 4]


# --- gimbal lock ------------------------------------------------------------------------------------------------------


def bending(seq, n_frames=60):
    """Return smooth angles (2, T, 6) of two joints, of which the second passes gimbal lock five times."""
    t = np.arange(n_frames) / 25
    lock = 0.0 if seq[0].lower() == seq[2].lower() else np.pi / 2
    still = np.stack([0.2 * np.sin(t), 0.7 + 0.1 * np.cos(t), 0.3 * t], axis=1)
    bent = np.stack([0.3 + 0.1 * t, lock + 0.4 * np.cos(2 * np.pi * t + 0.1), -0.2 + 0.05 * t], axis=1)
    one = np.concatenate([still, bent], axis=1)
    return np.stack([one, one + 0.01 * np.sin(3 * t)[:, np.newaxis]])


@pytest.mark.parametrize("seq", ["XYZ", "h36m", "zxy", "ZXZ", "yzy"])
def test_gimbal_flips(seq):
    smooth = bending(seq)
    assert find(smooth, smooth, pitfall="gimbal-flip") == []
    joints = smooth.reshape(2, 60, 2, 3)
    flipped = matrix_to_euler(euler_to_matrix(joints, seq=seq), seq=seq).reshape(smooth.shape)
    jumps = np.abs(np.diff(flipped[..., 3], axis=1)) > 1
    jumps |= np.abs(np.diff(flipped[..., 5], axis=1)) > 1
    assert jumps.sum() == 10
    first = (0, int(np.argmax(jumps[0])), 3)
    for argument, pair in (("gt", (flipped, smooth)), ("pred", (smooth, flipped))):
        (finding,) = find(*pair, pitfall="gimbal-flip")
        assert (finding.argument, finding.severity, finding.count) == (argument, "warning", 10)
        assert finding.where == first
        assert f"; the first at sequence, frame, feature {first}" in str(finding)
        assert "npss.rotations.continuous_euler removes them" in str(finding)
    mended = continuous_euler(flipped.reshape(joints.shape), seq=seq, axis=1).reshape(smooth.shape)
    assert find(mended, mended, pitfall="gimbal-flip") == []


@pytest.mark.parametrize(
    "jump",
    [(3.1, 0.0, 0.0), (0, 0, 3.1), (3.1, 0, 1.5), (2.0, 0, 3.1), (3.1, 1.6, 3.1), (4.3, 0, 3.1), (6.28, 0, 6.28)],
)
def test_other_jumps_are_no_gimbal_flips(jump):
    gt = np.tile([0.1, 1.4, 0.2], (1, 60, 1)) + 0.01 * np.sin(np.arange(60))[:, np.newaxis]
    gt[:, 30:] += jump
    assert find(gt, gt, pitfall="gimbal-flip") == []
    gt[:, 30:] += np.array([3.1, 0, 3.1]) - jump
    assert [finding.where for finding in find(gt, gt, pitfall="gimbal-flip")] == [(0, 29, 0), (0, 29, 0)]
    for scale in (0.5, 5):  # no angles
        assert find(scale * gt, scale * gt, pitfall="gimbal-flip") == []
    assert find(gt[..., :2], gt[..., :2], pitfall="gimbal-flip") == []


def test_jumps_of_angles_as_published_are_notes():
    """In 99 columns, the first six zero in both: then published tables have them, too."""
    gt, pred = np.zeros((2, 4, 100, 99))
    gt[..., 50:98], pred[..., 50:98] = walks()[:, 50:], walks(seed=1)[:, 50:]
    gt[1, 40:, 60] += 2 * np.pi
    gt[1, :, 60] -= np.pi
    pred[2, 30:, 70:73] = [np.pi, np.pi, np.pi] + pred[2, 30:, 70:73] * [1, -1, 1]
    pred[2, :, 71] = np.pi / 2
    found = [finding for finding in find(gt, pred) if finding.pitfall in ("wrap", "gimbal-flip")]
    assert [(one.pitfall, one.argument, one.severity, one.where) for one in found] == [
        ("wrap", "gt", "note", (1, 39, 60)), ("gimbal-flip", "pred", "note", (2, 29, 70)),
    ]  # fmt: skip
    assert "as in the published tables; npss.unwrap removes them and changes the score" in str(found[0])
    for moved in (gt, pred):
        moved[0, 0, 5] = 1e-3
        assert {one.severity for one in find(gt, pred) if one.pitfall in ("wrap", "gimbal-flip")} == {"warning"}
        moved[0, 0, 5] = 0


def test_noise_flips_nothing():
    noise = np.random.default_rng(0).uniform(-np.pi, np.pi, size=(2, 4, 200, 30))
    assert find(*noise, pitfall="gimbal-flip") == []


# --- constant predictions ---------------------------------------------------------------------------------------------


@given(still=st.sets(st.integers(0, 3)), pose=st.sampled_from(["zero", "last", "any"]))
def test_constant_predictions(still, pose):
    gt = walks()[:, 50:]
    pred = gt[:, ::-1].copy()
    for i in still:
        pred[i] = {"zero": 0.0, "last": walks()[i, 49], "any": 0.3}[pose]
    if not still:
        assert find(gt, pred) == []
        return
    (finding,) = find(gt, pred)
    assert (finding.pitfall, finding.argument) == ("constant", "pred")
    assert (finding.count, finding.where) == (len(still), (min(still),))
    assert f"{len(still)} constant predictions (of 4 sequences)" in str(finding)
    assert str(finding).endswith(f"the first at sequence {min(still)}")


def test_the_message_on_constant_predictions_is_true(motion):
    gt = motion[0]
    power = np.abs(np.fft.fft(gt, axis=1)) ** 2
    expected = 100 / 2 * (1 - power[:, 0].sum() / power.sum())
    for pose in (0.0, 0.4, gt[:, :1]):
        assert npss.score(gt, np.broadcast_to(pose, gt.shape)) == pytest.approx(expected)


def test_where_nothing_moves_nothing_need_be_predicted(motion):
    gt, pred = motion
    gt[2] = pred[2] = 0.7
    assert find(gt, pred) == []
    assert find(gt[:, :1], pred[:, :1]) == []  # in one frame, nothing can move


# --- shifts -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("lag", [-2, -1, 1, 2])
@pytest.mark.parametrize("noise", [0.0, 1e-6, 0.002])
@pytest.mark.parametrize("n_frames", [10, 100])
def test_shifts(lag, noise, n_frames):
    angles = walks()
    gt = angles[:, 20 : 20 + n_frames]
    pred = angles[:, 20 + lag : 20 + lag + n_frames] + noise * np.random.default_rng(0).normal(size=gt.shape)
    (finding,) = find(gt, pred)
    assert (finding.pitfall, finding.argument, finding.where) == ("shift", "pred", ())
    frames = f"{abs(lag)} frame{'s' if abs(lag) > 1 else ''} {'later' if lag > 0 else 'earlier'}"
    if noise == 0:
        assert str(finding) == f"pred: is the ground truth {frames}"
    else:
        assert str(finding).endswith(f"times closer to the ground truth {frames}")
        cut = np.s_[:, 2:-2]
        error = np.sqrt(np.square((pred - gt)[cut]).sum() / np.square((pred - np.roll(gt, -lag, axis=1))[cut]).sum())
        assert f"is {error:.3g} times closer" in str(finding)
    assert pitfalls(gt[0], pred[0]) == [("shift", "pred")]


@pytest.mark.parametrize("lag", [-2, -1, 1, 2])
def test_shifts_of_some_sequences(lag):
    angles = walks()
    gt = angles[:, 20:70]
    pred = gt + 0.3 * np.random.default_rng(0).normal(size=gt.shape)
    pred[[1, 3]] = angles[[1, 3], 20 + lag : 70 + lag]
    (finding,) = find(gt, pred)
    assert (finding.pitfall, finding.count, finding.where) == ("shift", 2, (1,))
    assert str(finding).startswith("pred: is the ground truth ")
    assert str(finding).endswith(", in 2 of 4 sequences; the first is sequence 1")


def test_what_is_not_by_a_factor_of_two_closer_is_not_shifted():
    angles = walks()
    gt, later = angles[:, 20:120], angles[:, 21:121]
    step = np.sqrt(np.square(later - gt).mean())
    noise = np.random.default_rng(0).normal(size=gt.shape)
    assert pitfalls(gt, later + 0.48 * step * noise) == [("shift", "pred")]
    assert find(gt, later + 0.62 * step * noise) == []  # closer by sqrt(1 + 0.62**2) / 0.62 = 1.9
    assert find(gt, (gt + later) / 2) == []
    assert find(gt, angles[:, 24:124]) == []  # by four frames: not a pitfall


@pytest.mark.parametrize("n_frames", range(1, 10))
def test_short_motions_are_not_looked_at_for_shifts(n_frames):
    angles = walks()
    gt, later = angles[:, 60 : 60 + n_frames], angles[:, 61 : 61 + n_frames]
    assert find(gt, later) == []
    # What stays behind at once is closer to what has been, which is no shift.
    still = np.repeat(angles[:, 59:60], n_frames, axis=1)
    assert find(gt, still, pitfall="shift") == []


def test_periodic_motion_without_a_shift():
    tone = np.cos(2 * np.pi * np.arange(100) / 4)[:, np.newaxis] + [[0.1, 0.2]]
    assert find(tone, tone) == []
    assert pitfalls(tone, np.roll(tone, 1, axis=0)) == [("shift", "pred")]


# --- frames that were given -------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("first", "last"), [(1, 0), (10, 0), (0, 1), (0, 3), (10, 1)])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_context_left_in(motion, first, last, dtype):
    gt, pred = motion
    pred[:, :first] = gt[:, :first].astype(dtype)
    pred[:, 100 - last :] = gt[:, 100 - last :].astype(dtype)
    found = find(gt, pred)
    assert [(one.pitfall, one.argument, one.severity, one.where) for one in found] == [
        ("context", "pred", "warning", ()) for count in (first, last) if count
    ]
    assert [one.count for one in found] == [count for count in (first, last) if count]
    text = " ".join(map(str, found))
    for count, end, what in ((first, "first", "context"), (last, "last", "target")):
        frames = "frame equals" if count == 1 else f"{count} frames equal"
        assert (f"the {end} {frames} the ground truth's in all sequences: is the {what} left in?" in text) == bool(
            count
        )
    pred[2, :10] += 1e-5
    pred[2, -10:] += 1e-5
    assert find(gt, pred) == []  # in all sequences but one


def test_equal_frames_that_were_not_given(motion):
    gt, pred = motion
    assert find(gt, gt) == find(gt[:, :1], gt[:, :1]) == []
    gt[:, 0] = pred[:, 0] = 0  # where both begin at the origin
    assert find(gt, pred) == []


@pytest.mark.parametrize("length", [3, 40])
@pytest.mark.parametrize("fill", ["zero", "last"])
def test_padding(motion, length, fill):
    gt, pred = motion
    for array in (gt, pred):
        for n in (1, 3):
            array[n, 100 - length :] = 0 if fill == "zero" else array[n, 99 - length]
    count = length + (fill == "last")
    (finding,) = find(gt, pred)
    assert (finding.pitfall, finding.argument, finding.severity) == ("padding", "gt", "warning")
    assert (finding.count, finding.where) == (2, (1,))
    assert f"2 sequences, and their predictions, end in {count} or more equal frames: padding?" in str(finding)
    assert str(finding).endswith("; the first at sequence 1")
    still = np.repeat(pred[:, :1], 100, axis=1)
    assert {one.pitfall for one in find(gt, still)} == {"padding", "constant"}
    pred[:, 99] += 1e-3
    assert find(gt, pred) == []  # in one of the two it may be what happened


def test_two_equal_frames_are_no_padding(motion):
    for array in motion:
        array[:, 98:] = array[:, 98:99]
    assert find(*motion) == []
    for array in motion:
        array[2] = array[2, :1]  # what does not move at all
    assert find(*motion) == []


# --- degrees ----------------------------------------------------------------------------------------------------------


def test_degrees(motion):
    gt, pred = motion
    both, beside = find(np.degrees(gt), np.degrees(pred)), find(gt, np.degrees(gt[:, ::-1]))
    assert [(one.pitfall, one.argument) for one in both] == [("degrees", "gt"), ("degrees", "pred")]
    assert both[0].where == (int(np.abs(gt).max(axis=(0, 1)).argmax()),)
    assert f"values up to {np.degrees(np.abs(gt).max()):.4g}, beyond 4 pi in most features" in str(both[0])
    assert str(both[0]).endswith(f"the largest is in feature {both[0].where[0]}")
    assert [(one.pitfall, one.argument) for one in beside] == [("degrees", "pred"), ("degrees", "pred")]
    assert "moves 57 times as far as the other" in str(beside[1])
    assert pitfalls(np.degrees(gt), pred) == [("degrees", "gt"), ("degrees", "gt")]


@pytest.mark.parametrize("factor", [1e-3, 0.1, 10, 30])
def test_other_factors_are_not_degrees(motion, factor):
    gt, pred = motion
    assert find(gt, pred * factor, pitfall="degrees") == []
    assert find(gt * factor, gt * factor, pitfall="degrees") == []


def test_small_degrees_beside_radians(motion):
    gt, pred = 0.01 * motion[0], 0.01 * motion[1]
    (finding,) = find(gt, np.degrees(pred))
    assert (finding.pitfall, finding.argument, finding.where) == ("degrees", "pred", ())
    for factor in (20, 200):
        assert find(0.1 * gt, 0.1 * factor * pred, pitfall="degrees") == []


def test_positions_in_millimetres_are_not_degrees(motion):
    assert find(3000 + 1000 * motion[0], 3000 + 1000 * motion[1], pitfall="degrees") == []


def test_features_that_are_zero_do_not_hide_degrees(motion):
    wide = [np.concatenate([np.degrees(array), np.zeros((4, 100, 60))], axis=2) for array in motion]
    assert [one.argument for one in find(*wide, pitfall="degrees")] == ["gt", "pred"]


# --- swapped axes -----------------------------------------------------------------------------------------------------


def test_swapped_axes(motion):
    swapped = [array.swapaxes(1, 2) for array in motion]
    (finding,) = find(*swapped, pitfall="axes")
    assert (finding.argument, finding.where) == ("gt", ())
    assert str(finding).endswith("is time last? Expected (sequences, frames, features)")
    assert [one.pitfall for one in find(motion[0][0].T, motion[1][0].T)] == ["axes"]


@pytest.mark.parametrize("size", [3, 4, 6])
def test_exchanged_axes_of_joints(motion, size):
    """(N, J, T, C) and (T, N, J, C) in place of (N, T, J, C)."""
    gt, pred = (array[..., : 8 * size].reshape(*array.shape[:2], 8, size) for array in motion)
    assert find(gt, pred, pitfall="axes") == []
    (finding,) = find(gt.swapaxes(1, 2), pred.swapaxes(1, 2), pitfall="axes")
    assert str(finding).endswith("is time the third of four axes? Expected (sequences, frames, joints, coordinates)")
    more = [np.concatenate([array, array[:, ::-1] * 0.9 + 0.1 * k], axis=0) for k, array in enumerate((gt, pred))]
    (finding,) = find(*(array.swapaxes(0, 1) for array in more), pitfall="axes")
    assert str(finding).endswith("along the second: is time first? Expected (sequences, frames, features)")
    assert find(*more, pitfall="axes") == []


def test_axes_of_real_motion(h36m_root):
    """Windows that overlap or follow each other, in angles, quaternions and positions, are as they should be."""
    poses = np.loadtxt(h36m_root / "dataset/S5/walking_1.txt", delimiter=",", dtype=np.float32)[::2]
    turns = npss.rotations.expmap_to_quaternion(poses[:, 3:].reshape(len(poses), 32, 3))
    places = poses_to_positions(poses)
    for values in (npss.poses_to_euler(poses).reshape(len(poses), 33, 3), turns, places):
        for stride, length in ((1, 50), (5, 10), (20, 100), (40, 30)):
            motion = np.stack([values[i : i + length] for i in range(0, len(values) - length, stride)])
            assert find(motion, motion, pitfall="axes") == []
        apart = motion[::3]
        assert find(apart.swapaxes(0, 1), apart.swapaxes(0, 1), pitfall="axes")


def test_white_noise_and_two_frames_tell_nothing_about_the_axes():
    noise = np.random.default_rng(0).normal(size=(2, 3, 50, 20))
    assert find(*noise, pitfall="axes") == []
    smooth_over_features = 0.1 * noise[:, :, :2].cumsum(axis=3)
    assert find(*smooth_over_features) == []
    constant = np.ones((3, 50, 20))
    assert find(constant, constant) == []
    smooth_over_both = 0.01 * noise.cumsum(axis=2).cumsum(axis=3)
    assert find(*smooth_over_both, pitfall="axes") == []


# --- joints, poses, weights -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n_frames", [5, 100])
@pytest.mark.parametrize("size", [3, 4, 6])
def test_frames_and_joints_taken_for_sequences(monkeypatch, n_frames, size):
    poses = gait.gait(1, n_frames, seed=0)[0]
    if size == 3:
        motion = poses_to_positions(poses)
    else:
        rotations = expmap_to_matrix(poses[:, 3:].reshape(n_frames, 32, 3))
        motion = matrix_to_quaternion(rotations) if size == 4 else rotations[..., :2].reshape(n_frames, 32, 6)
    (finding,) = find(motion, motion, pitfall="joints")
    assert (finding.argument, finding.severity, finding.where) == ("gt", "warning", ())
    assert "(frames, joints, coordinates) of one sequence?" in str(finding)
    assert str(finding).endswith("Expected (sequences, frames, features): array[None]")
    one = motion.reshape(1, n_frames, -1)
    assert find(one, one, pitfall="joints") == []
    monkeypatch.setattr(_diagnose, "_BLOCK", 1)
    assert find(motion, motion, pitfall="joints") == [finding]


@pytest.mark.parametrize("size", [3, 4, 6])
@pytest.mark.parametrize("stride", [1, 5, 25])
def test_sequences_of_few_features_are_sequences(size, stride):
    angles = walks(n=1)[0]
    for d in range(0, 42, 7):
        gt = np.stack([angles[i : i + 25, d : d + size] for i in range(0, 125, stride)])
        same = np.repeat(gt[:1], 5, axis=0)
        noise = np.random.default_rng(d).normal(size=gt.shape)
        for motion in (gt, same, noise, np.repeat(noise[:1], 5, axis=0)):
            assert find(motion, motion, pitfall="joints") == []


def test_a_last_axis_of_five_holds_no_coordinates():
    motion = np.tile(walks(n=1, n_frames=60)[0, :, :20, np.newaxis], (1, 1, 5))
    assert find(motion, motion, pitfall="joints") == []
    assert find(motion[..., :4], motion[..., :4], pitfall="joints")
    assert find(motion[:, :2, :4], motion[:, :2, :4], pitfall="joints") == []  # two joints, or frames, tell nothing


@pytest.mark.parametrize("root", [0, 2, 3, 5])
def test_poses_that_are_not_converted(root, motion):
    gt, pred = (np.zeros((4, 100, 99)) for _ in range(2))
    gt[..., 20:68], pred[..., 20:68] = motion
    assert warned(gt, pred) == []
    assert [str(finding) for finding in find(gt, pred)] == [
        "note: gt: 51 features (of 99) are zero throughout, so they do not count"
    ]
    gt[3, 50, root] = pred[3, 50, root] = 0.1
    found = find(gt, pred, pitfall="poses")
    assert [(one.argument, one.severity, one.where) for one in found] == [
        ("gt", "warning", ()),
        ("pred", "warning", ()),
    ]
    assert "npss score --expmap" in str(found[0])
    pred[..., root] = 0
    assert [one.argument for one in find(gt, pred, pitfall="poses")] == ["gt"]
    assert find(gt[..., :98], pred[..., :98], pitfall="poses") == []


def test_the_command_line_points_poses_to_expmap(capsys, tmp_path):
    poses = gait.gait(2, 50, seed=0)
    for name, array in (("gt", poses), ("pred", poses + 0.05 * np.random.default_rng(1).normal(size=poses.shape))):
        np.save(tmp_path / f"{name}.npy", array)
    files = ["score", str(tmp_path / "gt.npy"), str(tmp_path / "pred.npy"), "--convention", "paper"]
    assert main(files) == 0
    assert "- gt: 99 columns, the first 6 not zero: Human3.6M poses?" in capsys.readouterr().out
    assert main([*files, "--expmap"]) == 0
    assert "99 columns" not in capsys.readouterr().out


@pytest.mark.parametrize(("few", "heavy"), [(4, True), (5, False)])
def test_a_few_features_that_hold_most_of_the_weight(monkeypatch, motion, few, heavy):
    gt, pred = motion  # 48 features, of which a tenth are 4.8
    gt[..., 7 : 7 + few] = 1000 + gt[..., 7 : 7 + few]
    pred[..., 7 : 7 + few] = 1000 + pred[..., 7 : 7 + few]
    found = find(gt, pred, pitfall="weight")
    if not heavy:
        assert found == []
        return
    (finding,) = found
    assert (finding.argument, finding.severity, finding.count) == ("gt", "warning", few)
    assert finding.where == (7, 8, 9, 10)
    assert str(finding).startswith("gt: 4 features (of 48) hold 100% of the weight, and so of the score")
    power = np.square(gt).sum(axis=(0, 1))
    assert power[7:11].sum() / power.sum() > 0.999
    monkeypatch.setattr(_diagnose, "_BLOCK", 1)
    assert find(gt, pred, pitfall="weight") == [finding]


@pytest.mark.parametrize(("share", "heavy"), [(0.89, False), (0.91, True)])
def test_what_is_most_of_the_weight(share, heavy):
    rest = np.random.default_rng(0).normal(size=(2, 30, 12))
    rest[..., 11] = 0  # which counts for nothing: eleven features
    power = np.square(rest).sum(axis=(0, 1))
    rest[..., 3] *= np.sqrt(share / (1 - share) * (power.sum() - power[3]) / power[3])
    found = find(rest, rest, pitfall="weight")
    assert [(one.count, one.where) for one in found] == ([(1, (3,))] if heavy else [])
    if heavy:
        assert "1 features (of 11) hold 91% of the weight" in str(found[0])
    assert find(rest[..., :9], rest[..., :9], pitfall="weight") == []  # of nine features, one is more than a tenth


def test_no_weight_at_all():
    zero = np.zeros((2, 30, 12))
    assert find(zero, zero, pitfall="weight") == []


# --- powerless features -----------------------------------------------------------------------------------------------


@given(zero=st.sets(st.integers(0, 5)), predicted=st.sets(st.integers(0, 5)))
def test_powerless_features(zero, predicted):
    gt = walks(n=2, n_frames=20)[..., :6].copy()
    pred = gt[:, ::-1].copy()
    gt[..., list(zero)] = 0
    pred[..., [d for d in zero if d not in predicted]] = 0
    found = find(gt, pred, pitfall="powerless")
    if not zero:
        assert found == []
        return
    (finding,) = found
    assert (finding.argument, finding.count, finding.where) == ("gt", len(zero), tuple(sorted(zero)))
    text = "" if zero & predicted else "note: "
    text += f"gt: {len(zero)} features (of 6) are zero throughout, so they do not count"
    if zero & predicted:
        text += f", though the prediction is not zero in {len(zero & predicted)} of them"
    assert str(finding) == text


def test_features_with_power_in_one_sequence_count(motion):
    motion[0][1:, :, 5] = 0
    assert find(*motion) == []


# --- no real power ----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("n_frames", [20, 51, 100])
def test_whole_periods_of_a_sine(dtype, n_frames):
    gt = walks(n=3)[:, :n_frames, :5]
    pred = gt[:, ::-1].copy()
    sine = 0.3 * np.sin((2 * np.pi * 3 * np.arange(n_frames) / n_frames).astype(dtype))
    pred[1, :, 4] = pred[2, :, 0] = sine
    (finding,) = find(gt, pred.astype(dtype))
    assert (finding.pitfall, finding.argument) == ("no-real-power", "pred")
    assert (finding.count, finding.where) == (2, (1, 4))
    assert str(finding).endswith("by 'released' they score rounding errors; the first at sequence, feature (1, 4)")
    pred[1, :, 4] += 0.001  # an offset is real power
    pred[2, :, 0] = np.roll(sine, 1)
    assert find(gt, pred.astype(dtype)) == []


def test_what_has_no_weight_need_have_no_real_power(motion):
    gt, pred = motion
    gt[..., 3] = 0
    pred[..., 3] = np.sin(2 * np.pi * np.arange(100) / 100)
    assert [finding.pitfall for finding in find(gt, pred)] == ["powerless"]


# --- blocks -----------------------------------------------------------------------------------------------------------


def test_places_do_not_depend_on_blocks(monkeypatch):
    gt = np.tile(walks(n=4, n_frames=100)[..., :40], (20, 1, 1))  # 80 * 100 * 40 values: more than one block
    assert gt.size > _diagnose._BLOCK
    pred = gt[:, ::-1].copy()
    gt[:, :, 39] = 0
    gt[79, :, 39] = 1  # power in the last block alone ...
    gt[1:, :, 37] = 0  # ... and in the first one
    gt[77, :, 38] = np.where(np.arange(100) < 60, -3.0, 3.0)
    pred[70] = 0.5
    pred[75] = 0.5
    pred[78, :, 2] = np.sin(2 * np.pi * np.arange(100) / 100)
    whole = find(gt, pred)
    assert {finding.pitfall: (finding.count, finding.where) for finding in whole} == {
        "wrap": (1, (77, 59, 38)), "constant": (2, (70,)), "no-real-power": (1, (78, 2)),
    }  # fmt: skip
    for size in (1, 2**14, 2**30):
        monkeypatch.setattr(_diagnose, "_BLOCK", size)
        assert find(gt, pred) == whole


def test_sums_over_blocks(monkeypatch, motion):
    gt = motion[0]
    swapped = gt.swapaxes(1, 2).copy()
    swapped[3] = 0.5
    cases = (
        (gt[:, :-1], gt[:, 1:] + 1e-9),
        (np.degrees(gt), gt),
        (swapped, swapped),
        (gt * 0, gt),
    )
    whole = [find(*case) for case in cases]
    assert all(whole)
    monkeypatch.setattr(_diagnose, "_BLOCK", 1)
    assert [find(*case) for case in cases] == whole


# --- the command line -------------------------------------------------------------------------------------------------


def test_the_command_line_prints_findings(capsys, tmp_path, motion):
    for name, array in zip(("gt", "pred"), motion, strict=True):
        np.save(tmp_path / f"{name}.npy", array)
    files = [str(tmp_path / "gt.npy"), str(tmp_path / "pred.npy")]
    assert main(["score", *files]) == 0
    _, _, diagnosis = capsys.readouterr().out.partition("Diagnosis:\n")
    assert diagnosis == f"- {find(*motion, pitfall='share')[0]}\n"
    np.save(files[1], np.degrees(motion[0]))
    expected = [f"- {finding}" for finding in find(motion[0], np.degrees(motion[0]))]
    for form in ("text", "markdown"):
        assert main(["score", *files, "--format", form]) == 0
        lines = capsys.readouterr().out.splitlines()
        assert lines[lines.index("Diagnosis:") + 1 :] == expected
    assert len(expected) == 2


# --- share ------------------------------------------------------------------------------------------------------------


def test_a_score_that_is_mostly_share():
    gt = walks()[:, 50:]
    (finding,) = find(gt, gt + 0.1, pitfall="share")
    assert (finding.argument, finding.count, finding.where, finding.severity) == ("pred", 1, (), "note")
    score = f"100% of the score by 'paper', {npss.score(gt, gt + 0.1):.4g}, is the share of DC (npss.Parts)"
    assert str(finding).startswith(f"note: pred: {score}: ")
    assert find(gt[0], gt[0] + 0.1, pitfall="share")


def test_the_share_is_that_of_the_convention():
    gt = walks()[:, 50:]
    pred = gt + 0.1
    for convention, name in (("released", "'released'"), (npss.Convention(weight="uniform"), "this convention")):
        report = npss.report(gt, pred, convention=convention)
        (finding,) = (one for one in npss.diagnose(gt, pred, convention=convention) if one.pitfall == "share")
        share = report.parts.share / report.score
        assert finding.message.startswith(f"{share:.0%} of the score by {name}, {report.score:.4g}, is the share of DC")
    with pytest.raises(ValueError, match=r"^convention: "):
        npss.diagnose(gt, pred, convention="released code")


@pytest.mark.parametrize("mean", [0.5, 0.9, 0.99, 1.0])
def test_shares_of_a_score_on_either_side_of_a_half(mean):
    t = 2 * np.pi * np.arange(100)[:, np.newaxis] / 100
    gt, pred = 1 + np.cos(t), mean + np.cos(4 * t)
    parts = npss.report(gt, pred).parts
    assert bool(find(gt, pred, pitfall="share")) == (parts.share > parts.form)
    assert (parts.share > parts.form) == (mean < 0.95)


def test_what_is_right_has_no_share():
    gt = walks()[:, 50:]
    for pred in (gt, -2 * gt, gt[:, ::-1], np.roll(gt, 9, axis=1)):  # the same spectra, but for rounding
        assert find(gt, pred, pitfall="share") == []
    assert find(gt[:, :1], 1 + gt[:, :1], pitfall="share") == []  # one frame has no spectrum


def test_shares_over_blocks_are_those_of_the_whole(monkeypatch):
    gt, pred = walks()[:, 50:] * np.array([1, 9, 1, 2])[:, np.newaxis, np.newaxis], 0.9 + walks(seed=3)[:, 50:]
    whole = find(gt, pred, pitfall="share")
    monkeypatch.setattr(_diagnose, "_BLOCK", 1)
    assert find(gt, pred, pitfall="share") == whole != []


def test_a_flip_in_the_middle_has_the_maximal_cost():
    """As docs/comparing.md says: the same rotations, and half of the frames' number."""
    still = np.zeros((1, 100, 4))
    still[..., :] = 0.5
    flipped = still.copy()
    flipped[:, 50:] *= -1
    assert ("quaternion-sign", "pred") in pitfalls(still, flipped)
    assert npss.score(still, flipped) == pytest.approx(50)
