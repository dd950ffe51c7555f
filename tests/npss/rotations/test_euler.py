"""The Euler sequences: their definition, another implementation, and gimbal lock."""

import warnings

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from npss.rotations import (
    euler_to_expmap,
    euler_to_matrix,
    euler_to_quaternion,
    expmap_to_euler,
    expmap_to_matrix,
    geodesic_angle,
    matrix_to_euler,
    quaternion_to_euler,
)
from rotation_strategies import LETTERS, euler_angles, expmaps, is_proper, sample

pytestmark = pytest.mark.numeric


def elementary(letter, angle):
    """Return the rotation about a coordinate axis, by definition."""
    c, s = np.cos(angle), np.sin(angle)
    i = "XYZ".index(letter)
    j, k = (i + 1) % 3, (i + 2) % 3
    R = np.eye(3)
    R[j, j] = R[k, k] = c
    R[k, j], R[j, k] = s, -s
    return R


@pytest.mark.parametrize("seq", LETTERS)
def test_definition(seq):
    """Upper case multiplies from left to right, lower case from right to left."""
    angles = np.random.default_rng(2).uniform(-3, 3, 3)
    factors = [elementary(letter, angle) for letter, angle in zip(seq.upper(), angles, strict=True)]
    a, b, c = factors if seq.isupper() else factors[::-1]
    np.testing.assert_allclose(euler_to_matrix(angles, seq=seq), a @ b @ c, rtol=0, atol=4e-15)


@pytest.mark.parametrize("seq", LETTERS)
def test_against_scipy(seq):
    v = sample("expmap", (2000,))
    other = Rotation.from_rotvec(v)
    expected = other.as_euler(seq)
    well = np.abs(np.sin(expected[:, 1]) if is_proper(seq) else np.cos(expected[:, 1]))
    for got in (
        expmap_to_euler(v, seq=seq),
        matrix_to_euler(other.as_matrix(), seq=seq),
        quaternion_to_euler(np.roll(other.as_quat(), 1, axis=-1), seq=seq),
    ):
        error = np.abs((got - expected + np.pi) % (2 * np.pi) - np.pi).max(1) * well
        assert error.max() < 1e-14
        assert error.mean() < 1e-15
    back = Rotation.from_euler(seq, expected)
    assert np.abs(euler_to_matrix(expected, seq=seq) - back.as_matrix()).max() < 3e-15
    quaternion = np.roll(back.as_quat(canonical=True), 1, axis=-1)
    assert np.abs(euler_to_quaternion(expected, seq=seq) - quaternion).max() < 3e-15
    assert np.abs(euler_to_expmap(expected, seq=seq) - back.as_rotvec()).max() < 1e-14


def test_h36m_by_its_formula():
    """The formula of the NPSS paper's code, on the exact rotation matrix."""
    v = sample("expmap", (2000,))
    R = Rotation.from_rotvec(v).as_matrix()
    E2 = -np.arcsin(R[:, 0, 2])
    E1 = np.arctan2(R[:, 1, 2] / np.cos(E2), R[:, 2, 2] / np.cos(E2))
    E3 = np.arctan2(R[:, 0, 1] / np.cos(E2), R[:, 0, 0] / np.cos(E2))
    well = np.cos(E2) > 0.05
    assert np.abs(expmap_to_euler(v) - np.stack([E1, E2, E3], 1))[well].max() < 1e-13


@given(v=expmaps())
def test_h36m_is_xyz_negated(v):
    h36m, xyz = expmap_to_euler(v), expmap_to_euler(v, seq="XYZ")
    assert np.array_equal(h36m, np.where(h36m == np.pi, h36m, -xyz))  # half a turn is pi, not -pi, in both
    assert np.array_equal(euler_to_matrix(v), euler_to_matrix(-v, seq="XYZ"))


@given(v=expmaps(), seq=st.sampled_from(LETTERS))
def test_extrinsic_is_intrinsic_reversed(v, seq):
    R = expmap_to_matrix(v)
    assert np.array_equal(euler_to_matrix(v, seq=seq), euler_to_matrix(v[:, ::-1], seq=seq[::-1].swapcase()))
    one, other = matrix_to_euler(R, seq=seq), matrix_to_euler(R, seq=seq[::-1].swapcase())
    free = (one[:, 2] != 0) & (other[:, 2] != 0)  # at gimbal lock the third angle is zero in both
    assert np.array_equal(one[free], other[free, ::-1])


@given(data=st.data(), seq=st.sampled_from(LETTERS))
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_the_rotation_is_reproduced_near_gimbal_lock(data, seq, dtype):
    angles = data.draw(euler_angles(seq)).astype(dtype)
    R = euler_to_matrix(angles, seq=seq)
    got = matrix_to_euler(R, seq=seq)
    pi = dtype(np.pi)
    assert (np.abs(got) <= pi).all()
    low, high = (0, pi) if is_proper(seq) else (-pi / 2, pi / 2)
    assert ((got[:, 1] >= low) & (got[:, 1] <= high)).all()
    assert geodesic_angle(euler_to_matrix(got, seq=seq), R).max() < 50 * np.finfo(dtype).eps


@pytest.mark.parametrize("seq", [*LETTERS, "h36m"])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
@pytest.mark.parametrize("side", [0, 1])
def test_at_gimbal_lock_the_third_angle_is_zero(seq, dtype, side):
    rng = np.random.default_rng(side)
    angles = rng.uniform(-3, 3, (500, 3)).astype(dtype)
    angles[:, 1] = (0, np.pi)[side] if is_proper(seq) else (-np.pi / 2, np.pi / 2)[side]
    R = euler_to_matrix(angles, seq=seq)
    for got in (
        matrix_to_euler(R, seq=seq),
        quaternion_to_euler(euler_to_quaternion(angles, seq=seq), seq=seq),
        expmap_to_euler(euler_to_expmap(angles, seq=seq), seq=seq),
    ):
        assert (got[:, 2] == 0).all()
        assert geodesic_angle(euler_to_matrix(got, seq=seq), R).max() < 50 * np.finfo(dtype).eps


@pytest.mark.parametrize("seq", LETTERS)
def test_at_gimbal_lock_against_scipy(seq):
    """Both give a zero third angle, and the same first one."""
    rng = np.random.default_rng(4)
    angles = rng.uniform(-3, 3, (200, 3))
    angles[:, 1] = np.pi * rng.integers(0, 2, 200) - (0 if is_proper(seq) else np.pi / 2)
    other = Rotation.from_euler(seq, angles)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)  # scipy warns of gimbal lock
        expected = other.as_euler(seq)
    got = expmap_to_euler(other.as_rotvec(), seq=seq)
    assert np.abs((got - expected + np.pi) % (2 * np.pi) - np.pi).max() < 1e-7
    assert np.abs(euler_to_matrix(got, seq=seq) - other.as_matrix()).max() < 1e-14


def test_quarter_turn_about_y():
    for y in (np.pi / 2, -np.pi / 2, 3 * np.pi / 2):
        got = expmap_to_euler([0, y, 0])
        np.testing.assert_allclose(got, [0, -np.arcsin(np.sin(y)), 0], rtol=0, atol=4e-15)


def test_one_component_gives_one_angle():
    """No rounding leaks into the angles of the other axes."""
    for axis in range(3):
        v = np.zeros((200, 3))
        v[:, axis] = np.linspace(-1.5, 1.5, 200)
        got = expmap_to_euler(v)
        others = np.delete(np.arange(3), axis)
        assert np.array_equal(got[:, others], np.zeros((200, 2)))
        assert not np.signbit(got[:, others]).any()
        np.testing.assert_allclose(got[:, axis], -v[:, axis], rtol=4e-16)
