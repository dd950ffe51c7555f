"""Continuous quaternions and Euler angles: equal rotations without jumps between frames."""

from functools import partial
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import npss
from npss.rotations import (
    continuous,
    continuous_euler,
    euler_to_matrix,
    expmap_to_quaternion,
    geodesic_angle,
    matrix_to_euler,
    quaternion_to_matrix,
)
from npss_baselines.data import h36m
from rotation_strategies import LETTERS, is_proper, sample

SEQUENCES = ["h36m", *LETTERS]
PI = np.pi


# --- quaternions ------------------------------------------------------------------------------------------------------


def loop(q, start=None):
    """Choose the signs of quaternions (T, 4) with a loop."""
    out = []
    for row in q:
        before = out[-1] if out else start
        out.append(-row if before is not None and np.dot(before, row) < 0 else row)
    return np.array(out)


def turning():
    """Return exponential maps (1, 60, 1, 3) that pass half a turn and return, at 30 frames per second."""
    t = np.arange(60) / 30
    v = np.stack([2.6 + 0.8 * np.sin(2 * PI * t), 0.6 * np.cos(2 * PI * t), 0.3 * t], axis=1)
    return v[np.newaxis, :, np.newaxis]


def test_equal_rotations_score_zero():
    q = expmap_to_quaternion(turning())
    by_hand = loop(q[0, :, 0])
    flat = q.reshape(1, 60, 4)
    assert npss.score(by_hand[np.newaxis], flat, convention="released") > 1  # the pitfall
    assert "quaternion-sign" in [finding.pitfall for finding in npss.diagnose(by_hand[np.newaxis], flat)]
    mended = continuous(q, axis=1)
    assert np.array_equal(mended[0, :, 0], by_hand)
    assert npss.score(by_hand[np.newaxis], mended.reshape(1, 60, 4), convention="released") == 0
    assert npss.diagnose(by_hand[np.newaxis], mended.reshape(1, 60, 4)) == ()


@given(seed=st.integers(0, 1000), n=st.integers(1, 12), first=st.booleans())
def test_signs_equal_the_loop(seed, n, first):
    q = np.random.default_rng(seed).normal(size=(n + 1, 4))
    start = q[0] if first else None
    got = continuous(q[1:], axis=0, start=start)
    assert np.array_equal(got, loop(q[1:], start))
    assert np.array_equal(np.abs(got), np.abs(q[1:]))
    whole = got if start is None else np.concatenate([[start], got])
    assert ((whole[1:] * whole[:-1]).sum(axis=-1) >= 0).all()
    assert np.array_equal(continuous(got, axis=0, start=start), got)


@settings(max_examples=30)
@given(seed=st.integers(0, 1000), signs=st.lists(st.sampled_from([-1, 1]), min_size=20, max_size=20))
def test_only_the_first_sign_of_the_input_matters(seed, signs):
    q = np.random.default_rng(seed).normal(size=(20, 3, 4))
    flipped = q * np.array(signs)[:, np.newaxis, np.newaxis]
    assert np.array_equal(continuous(flipped, axis=0), signs[0] * continuous(q, axis=0))
    start = np.random.default_rng(seed + 1).normal(size=(3, 4))
    assert np.array_equal(continuous(flipped, axis=0, start=start), continuous(q, axis=0, start=start))
    assert np.array_equal(continuous(q, axis=0, start=-start), -continuous(q, axis=0, start=start))


@pytest.mark.parametrize("axis", [0, 1, 2, -2, -3, -4])
def test_any_axis_of_frames(axis):
    q = np.random.default_rng(0).normal(size=(5, 6, 7, 4))
    start = np.random.default_rng(1).normal(size=np.delete(q.shape, axis))
    expected = continuous(np.moveaxis(q, axis, 0), axis=0, start=start)
    got = continuous(q, axis=axis, start=start)
    assert got.flags.c_contiguous
    assert np.array_equal(np.moveaxis(got, axis, 0), expected)
    assert np.array_equal(expected[:, 2, 3], loop(np.moveaxis(q, axis, 0)[:, 2, 3], start[2, 3]))


@pytest.mark.parametrize("sizes", [(1e-300, 1e300), (5e-324, 1.7e308), (1e-30, 1.0)])
def test_lengths_do_not_matter(sizes):
    q = np.array([[sizes[0], 0, sizes[0], 0], [-sizes[1], 0, 0, 0], [-sizes[0], 0, 0, 0]])
    got = continuous(q, axis=0)
    assert np.array_equal(got, [q[0], -q[1], -q[2]])
    assert not np.signbit(got).any()


@pytest.mark.parametrize(
    ("size", "function"), [(4, continuous), (3, partial(continuous_euler, seq="zyx"))], ids=["quaternions", "angles"]
)
def test_precisions_and_empty_arrays(size, function):
    q = sample("quaternion" if size == 4 else "euler", (8, 2), dtype=np.float32)
    assert function(q, axis=0).dtype == np.float32
    assert function(q.astype(">f4"), axis=0).tobytes() == function(q, axis=0).tobytes()
    for dtype in (np.float64, ">f8", np.float16, np.longdouble):
        assert function(q.astype(dtype), axis=0).dtype == np.float64
    whole = np.array([[1, 0, 0, 1], [-1, 0, 0, -1]])[:, :size]
    assert function(whole, axis=0).dtype == np.float64
    assert function(np.empty((0, 3, size)), axis=0, start=np.ones((3, size))).shape[:2] == (0, 3)
    assert function(np.empty((3, 0, size)), axis=0).shape[:2] == (3, 0)
    before = q.copy()
    q.flags.writeable = False
    assert not np.shares_memory(function(q, axis=0), q)
    assert np.array_equal(q, before)


def test_zero_quaternions():
    q = np.ones((3, 4, 4))
    q[2, 1] = 0
    with pytest.raises(ValueError, match=r"^q: a zero quaternion, not a rotation, at index \(2, 1\)$"):
        continuous(q, axis=0)
    with pytest.raises(ValueError, match=r"^start: a zero quaternion, not a rotation, at index \(1,\)$"):
        continuous(np.ones((3, 4, 4)), axis=0, start=q[2])


# --- Euler angles -----------------------------------------------------------------------------------------------------


def same_rotation(a, b, seq):
    return geodesic_angle(euler_to_matrix(a, seq=seq), euler_to_matrix(b, seq=seq))


def representations(angles, seq):
    """Return the angles of the same rotation up to six turns away, (2 * 13**3, 3)."""
    a, b, c = angles
    other = [a + PI, -b if is_proper(seq) else PI - b, c + PI]
    turns = 2 * PI * np.array(list(product(range(-6, 7), repeat=3)))
    return np.concatenate([angles + turns, other + turns])


def converted(path, seq):
    """Return the angles (T, 3) that conversions return."""
    return matrix_to_euler(euler_to_matrix(path, seq=seq), seq=seq)


def through_the_lock(seq, *, steps=41):
    """Return a smooth path (steps, 3) whose middle angle swings through gimbal lock; the outer ones are constant.

    In every tenth frame it is at the lock itself, to rounding.
    """
    lock = 0 if is_proper(seq) else PI / 2
    middle = lock + 0.4 * np.sin(PI * np.arange(steps) / 10)
    return np.stack([np.full(steps, 0.3), middle, np.full(steps, -0.2)], axis=1)


@pytest.mark.parametrize("seq", SEQUENCES)
@pytest.mark.parametrize("side", [1, -1])
def test_a_path_through_gimbal_lock_is_recovered(seq, side):
    path = through_the_lock(seq)
    path[:, 1] += PI * (side < 0)  # the other gimbal lock
    got = converted(path, seq)
    assert np.abs(np.diff(npss.unwrap(got), axis=0)).max() > 2.5
    mended = continuous_euler(got, seq=seq, axis=0, start=path[0])
    np.testing.assert_allclose(mended, path, atol=1e-13)
    # A path whose first frame is at gimbal lock starts elsewhere on the line of equal rotations.
    own = continuous_euler(got, seq=seq, axis=0)
    assert np.array_equal(own[0], got[0])
    assert same_rotation(own, path, seq).max() < 1e-14
    assert np.abs(np.diff(own[1:], axis=0)).max() < 0.15


@settings(max_examples=150)
@given(seq=st.sampled_from(SEQUENCES), rows=st.lists(st.tuples(*[st.floats(-9, 9)] * 3), min_size=2, max_size=4))
def test_the_nearest_of_all_representations(seq, rows):
    triples = np.array(rows)
    got = continuous_euler(triples[1:], seq=seq, axis=0, start=triples[0])
    assert same_rotation(got, triples[1:], seq).max() < 1e-13
    near = triples[0]
    for given_, chosen in zip(triples[1:], got, strict=True):
        nearest = np.linalg.norm(representations(given_, seq) - near, axis=1).min()
        assert np.linalg.norm(chosen - near) <= nearest + 1e-13
        off = np.sin(given_[1]) if is_proper(seq) else np.cos(given_[1])
        if abs(off) > 1e-10:  # at gimbal lock, there are more
            assert np.linalg.norm(chosen - near) >= nearest - 1e-13
        near = chosen


@pytest.mark.parametrize("seq", SEQUENCES)
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_at_gimbal_lock_both_outer_angles_move_by_the_same(seq, dtype):
    near = np.array([0.4, 1.5, 0.9], dtype)
    for quarters in (-3, -2, -1, 0, 1, 2, 3):
        middle = quarters * PI / 2 if bool(quarters % 2) != is_proper(seq) else quarters * PI / 2 + PI / 2
        given_ = np.array([[2.0, middle, -0.7]], dtype)
        got = continuous_euler(given_, seq=seq, axis=0, start=near)[0]
        assert got.dtype == dtype
        assert same_rotation(got, given_[0], seq) < 8 * np.finfo(dtype).eps
        moved = got - near
        assert abs(abs(moved[0]) - abs(moved[2])) < 8 * np.finfo(dtype).eps
        assert np.linalg.norm(moved) <= np.linalg.norm(representations(given_[0], seq) - near, axis=1).min() + 1e-6


def test_a_jump_that_diagnose_and_unwrap_miss():
    t = np.arange(100) / 25
    smooth = np.stack([0.3 + 0 * t, PI / 2 + 0.4 * np.sin(PI * t), -0.2 + 0 * t], axis=1)[np.newaxis]
    flipped = converted(smooth, "XYZ")
    assert same_rotation(smooth, flipped, "XYZ").max() < 1e-15
    assert npss.score(npss.unwrap(flipped), npss.unwrap(smooth)) > 10
    mended = continuous_euler(flipped, seq="XYZ", axis=1, start=smooth[:, 0])
    assert npss.score(mended, smooth) < 1e-12


@settings(max_examples=20)
@given(seed=st.integers(0, 1000))
def test_away_from_gimbal_lock_it_unwraps(seed):
    path = 0.3 * np.random.default_rng(seed).normal(size=(30, 5, 3)).cumsum(axis=0)
    path[..., 1] = np.clip(path[..., 1], -0.5, 0.5)
    wrapped = np.remainder(path + PI, 2 * PI) - PI
    got = continuous_euler(wrapped, seq="h36m", axis=0)
    np.testing.assert_allclose(got, npss.unwrap(wrapped.reshape(30, 15)).reshape(30, 5, 3), atol=1e-13)
    np.testing.assert_allclose(continuous_euler(wrapped, seq="h36m", axis=0, start=path[0]), path, atol=1e-13)
    assert np.array_equal(continuous_euler(got, seq="h36m", axis=0), got)


def test_a_swing_near_gimbal_lock_is_not_a_jump():
    """Passing gimbal lock at a distance of 0.01 rad, the outer angles must swing by about pi."""
    t = np.linspace(-0.3, 0.3, 32)
    path = np.stack([0.01 + 0 * t, PI / 2 + t, 0 * t], axis=1)  # about z by a little, then about y
    angles = matrix_to_euler(euler_to_matrix(path, seq="ZYX"), seq="XYZ")
    assert np.abs(np.diff(angles, axis=0)).max() > 0.5
    assert np.array_equal(continuous_euler(angles, seq="XYZ", axis=0), angles)


@pytest.mark.parametrize("seq", ["h36m", "ZXZ"])
@pytest.mark.parametrize("axis", [0, 1, -2])
def test_any_axis_of_frames_of_angles(seq, axis):
    angles = np.random.default_rng(0).normal(size=(5, 6, 3)) * 3
    whole = np.moveaxis(continuous_euler(angles, seq=seq, axis=axis), axis, 0)
    for joint in range(whole.shape[1]):
        alone = continuous_euler(np.moveaxis(angles, axis, 0)[:, joint], seq=seq, axis=0)
        assert np.array_equal(whole[:, joint], alone)


# --- errors, and real motion ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"axis": 3}, ValueError, r"^axis: expected an axis of \w+ before the last, got 3 for shape \(4, 5, 6, \d\)$"),
        ({"axis": -1}, ValueError, "^axis: .* before the last, got -1"),
        ({"axis": 4}, ValueError, "^axis: .* got 4"),
        ({"axis": -5}, ValueError, "^axis: .* got -5"),
        ({"axis": 1.0}, TypeError, "^axis: expected a whole number, the axis of the frames, got 1.0"),
        ({"axis": True}, TypeError, "^axis: expected a whole number"),
        ({"axis": None}, TypeError, "^axis: expected a whole number"),
        ({"start": "one"}, ValueError, r"^start: expected the shape of one frame of \w+, \(4, 6, \d\), got \(\d,\)$"),
        ({"start": "nan"}, ValueError, r"^start: nan at index \(3, 5, 0\)"),
    ],
)
def test_what_is_refused(options, error, message):
    for size, call in ((4, continuous), (3, partial(continuous_euler, seq="XYZ"))):
        starts = {"one": np.ones(size), "nan": np.ones((4, 6, size))}
        starts["nan"][3, 5, 0] = np.nan
        with pytest.raises(error, match=message):
            call(np.ones((4, 5, 6, size)), **{"axis": 1, **options, "start": starts.get(options.get("start"))})
        with pytest.raises(ValueError, match="nan at index"):
            call(np.where(np.arange(size) == 1, np.nan, np.ones((4, 5, size))), axis=0)
        with pytest.raises(ValueError, match=r"expected shape \(\.\.\., \d\)"):
            call(np.ones((4, 5)), axis=0)
        with pytest.raises(TypeError, match="complex"):
            call(np.ones((4, size), complex), axis=0)


def test_refused_angles():
    with pytest.raises(ValueError, match=r"^angles: 2000000000000\.0 at index \(1, 0\) is too large an angle"):
        continuous_euler([[0, 0, 0], [2e12, 0, 0]], seq="XYZ", axis=0)
    with pytest.raises(ValueError, match=r"^start: 2000000000000\.0 at index \(2,\) is too large an angle"):
        continuous_euler([[0, 0, 0]], seq="XYZ", axis=0, start=[0, 0, 2e12])
    with pytest.raises(ValueError, match=r"^seq: expected one of h36m"):
        continuous_euler([[0, 0, 0]], seq="XYY", axis=0)


def test_human36m(h36m_root):
    """Both jump in this clip. Continuous ones are the same rotations, and only swings remain."""
    poses = h36m.load(h36m.open_root(h36m_root), 5, "walking", 2, fps=25).astype(np.float64)
    q = expmap_to_quaternion(poses[:, 3:].reshape(-1, 32, 3))
    assert ((q[1:] * q[:-1]).sum(axis=-1) < 0).sum() == 1
    mended = continuous(q, axis=0)
    assert ((mended[1:] * mended[:-1]).sum(axis=-1) >= 0).all()
    assert np.array_equal(quaternion_to_matrix(mended), quaternion_to_matrix(q))

    angles = npss.poses_to_euler(poses).reshape(-1, 33, 3)
    flat = angles.reshape(1, -1, 99)
    steps = np.abs(np.diff(npss.unwrap(flat)[0].reshape(angles.shape), axis=0))
    assert (steps[..., ::2] > PI - 1).all(axis=-1).sum() == 1  # a jump of pi, in both outer angles
    smooth = continuous_euler(angles, seq="h36m", axis=0)
    steps = np.abs(np.diff(smooth, axis=0))
    assert not (steps[..., ::2] > PI - 1).all(axis=-1).any()
    assert same_rotation(smooth, angles, "h36m").max() < 1e-14
