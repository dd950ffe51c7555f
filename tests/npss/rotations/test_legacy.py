"""``expmap_to_euler(legacy=True)`` against a loop written from the definition."""

import math

import mpmath as mp
import numpy as np
import pytest

from npss.rotations import euler_to_matrix, expmap_to_euler, expmap_to_matrix, geodesic_angle, matrix_to_expmap
from rotation_strategies import around, sample

pytestmark = pytest.mark.numeric

EPSILON = np.finfo(np.float32).eps


def released(v):
    """Convert one rotation, as the released code does."""
    angle = np.linalg.norm(v)
    x, y, z = v / (angle + EPSILON)
    K = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K.dot(K)
    s = R[0, 2]
    if s in (1, -1):
        return math.atan2(R[0, 1], s), -s * math.pi / 2, 0.0
    middle = -np.arcsin(s)
    cosine = np.cos(middle)
    return (
        np.arctan2(R[1, 2] / cosine, R[2, 2] / cosine),
        middle,
        np.arctan2(R[0, 1] / cosine, R[0, 0] / cosine),
    )


@pytest.mark.parametrize("scale", [1e-300, 1e-12, 1e-6, 1e-2, 1, 100])
def test_against_the_loop(scale):
    v = sample("expmap", (3000,)) * scale / 6
    expected = np.array([released(row) for row in v])
    got = expmap_to_euler(v, legacy=True)
    error = around(got - expected)
    assert error.mean() < 1e-15 * max(1, scale / 3)
    # The order of matrix multiplication depends on the machine, and with it the last bit of R[0, 2].
    cosine = np.cos(expected[:, 1:2])
    assert (error[cosine[:, 0] > 0.1] < 1e-14 * max(1, scale / 3)).all()
    assert (error * cosine < 4e-15 * max(1, scale / 3)).all()


def test_identity():
    assert np.array_equal(expmap_to_euler(np.zeros((4, 3)), legacy=True), np.zeros((4, 3)))


def test_it_is_computed_in_double_precision():
    v = sample("expmap", (100,), dtype=np.float32)
    got = expmap_to_euler(v, legacy=True)
    assert got.dtype == np.float32
    assert np.array_equal(got, expmap_to_euler(v.astype(np.float64), legacy=True).astype(np.float32))
    assert expmap_to_euler(v.astype(np.float16), legacy=True).dtype == np.float64


def test_the_flaw_is_usually_small():
    v = sample("expmap", (20_000,))
    error = around(expmap_to_euler(v, legacy=True) - expmap_to_euler(v)).max(1)
    assert 1e-8 < np.median(error) < 2e-7
    assert np.percentile(error, 99) < 1e-5


def test_the_flaw_is_large_near_gimbal_lock():
    """Where the two differ, the released angles are of another rotation."""
    near = [0.3, np.pi / 2 - 1e-4, -0.4]
    R = euler_to_matrix(near)
    v = matrix_to_expmap(R)
    legacy, robust = expmap_to_euler(v, legacy=True), expmap_to_euler(v)
    assert around(legacy - robust).max() > 1e-4
    assert geodesic_angle(euler_to_matrix(robust), R) < 1e-14
    assert geodesic_angle(euler_to_matrix(legacy), R) > 1e-5


@pytest.fixture(scope="module")
def locked():
    """A rotation about y for which even the released code finds R[0, 2] = 1: the angle must be huge."""
    with mp.workdps(40):
        for k in range(10**9, 10**9 + 10**6):
            angle = float(mp.pi / 2 + 2 * mp.pi * k)
            if np.sin(angle) == 1 and angle / (angle + EPSILON) == 1:
                return np.array([0, angle, 0])
    raise AssertionError("none found")


def test_special_case(locked):
    """Reproduced, although the first angle is wrong there: 0 or pi for any rotation."""
    for v, expected in ((locked, [0, -np.pi / 2, 0]), (-locked, [np.pi, np.pi / 2, 0])):
        got = expmap_to_euler(v, legacy=True)
        np.testing.assert_allclose(np.abs(got), np.abs(released(v)), rtol=0, atol=4e-15)
        np.testing.assert_allclose([abs(got[0]), *got[1:]], expected, rtol=0, atol=4e-15)
    R = expmap_to_matrix(-locked)
    assert geodesic_angle(euler_to_matrix(expmap_to_euler(-locked)), R) < 1e-14
    assert geodesic_angle(euler_to_matrix(expmap_to_euler(-locked, legacy=True)), R) > 3


@pytest.mark.parametrize("zero", [0.0, -0.0])
def test_half_turns_have_the_same_sign(zero):
    """Not compared modulo 2 pi: for the Euler error, pi and -pi are different angles."""
    v = np.array(np.meshgrid(*[[-3, -2, -1, zero, 1, 2, 3]] * 3)).reshape(3, -1).T
    expected = np.array([released(row) for row in v])
    assert (np.abs(expected) > 3.14159).sum() == 8
    assert np.abs(expmap_to_euler(v, legacy=True) - expected).max() < 1e-14
    assert np.abs(expmap_to_euler(v) - expected).max() < 1e-6
    assert np.abs(expmap_to_euler(v.astype(np.float32)) - expected).max() < 1e-5
