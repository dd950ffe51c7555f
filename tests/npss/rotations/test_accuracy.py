"""Accuracy against fifty digits: statistics of the error in units of the machine epsilon."""

import mpmath as mp
import numpy as np
import pytest

from npss.rotations import (
    euler_to_matrix,
    expmap_to_euler,
    expmap_to_matrix,
    expmap_to_quaternion,
    geodesic_angle,
    matrix_to_expmap,
    quaternion_to_matrix,
)
from rotation_strategies import around, both_precisions

pytestmark = pytest.mark.numeric

COUNT = 150


def turns(name):
    """Random axes with angles of one kind."""
    rng = np.random.default_rng(7)
    axis = rng.normal(size=(COUNT, 3))
    axis /= np.linalg.norm(axis, axis=1, keepdims=True)
    sign, distance = rng.choice([-1, 1], COUNT), 10 ** rng.uniform(-17, -1, COUNT)
    angle = {
        "up to pi": rng.uniform(0, np.pi, COUNT),
        "pi to 2 pi": rng.uniform(np.pi, 2 * np.pi, COUNT),
        "near 0": 10 ** rng.uniform(-37, -1, COUNT),
        "near pi": np.pi + sign * distance,
        "near 2 pi": 2 * np.pi + sign * distance,
        "near 8": rng.uniform(7, 9, COUNT),
    }[name]
    return axis * angle[:, np.newaxis]


KINDS = ["up to pi", "pi to 2 pi", "near 0", "near pi", "near 2 pi", "near 8"]


def exact_matrix(v):
    with mp.workdps(50):
        x, y, z = (mp.mpf(float(c)) for c in v)
        angle = mp.sqrt(x * x + y * y + z * z)
        K = mp.matrix([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        if angle == 0:
            return mp.eye(3)
        return mp.eye(3) + mp.sin(angle) / angle * K + (1 - mp.cos(angle)) / angle**2 * K * K


def exact_h36m(R):
    with mp.workdps(50):
        return (
            mp.atan2(R[1, 2], R[2, 2]),
            mp.atan2(-R[0, 2], mp.hypot(R[0, 0], R[0, 1])),
            mp.atan2(R[0, 1], R[0, 0]),
        )


def to_numpy(matrices):
    return np.array([[[float(R[i, j]) for j in range(3)] for i in range(3)] for R in matrices])


def check(error, eps, *, mean, p95, worst):
    error = error / eps
    assert error.mean() < mean
    assert np.percentile(error, 95) < p95
    assert error.max() < worst


@pytest.mark.parametrize("kind", KINDS)
@both_precisions
def test_exponential_map(kind, dtype):
    eps = np.finfo(dtype).eps
    v = turns(kind).astype(dtype)
    exact = [exact_matrix(row) for row in v]
    R = to_numpy(exact)
    check(np.abs(expmap_to_matrix(v) - R).max((1, 2)), eps, mean=1.6, p95=4, worst=8)
    check(np.abs(quaternion_to_matrix(expmap_to_quaternion(v)) - R).max((1, 2)), eps, mean=1.8, p95=4.5, worst=8)

    euler = np.array([[float(a) for a in exact_h36m(m)] for m in exact])
    cosine = np.cos(euler[:, 1])
    error = around(expmap_to_euler(v) - euler)
    check(error.max(1) * cosine, eps, mean=1.8, p95=4.5, worst=8)
    if dtype is np.float32:
        assert error[cosine >= 0.1].max() < 5e-6


def test_single_precision_against_double():
    rng = np.random.default_rng(3)
    v = rng.normal(size=(200_000, 3)).astype(np.float32) * np.float32(1.5)
    double = expmap_to_euler(v.astype(np.float64))
    error = around(expmap_to_euler(v) - double)[np.abs(np.cos(double[:, 1])) >= 0.1]
    assert error.max() < 5e-6
    assert error.mean() < 2e-7
    assert np.percentile(error, 99) < 8e-7


@both_precisions
def test_smallest_vectors(dtype):
    """To first order the angles are the components and the matrix is 1 + [v], at any scale."""
    smallest = np.finfo(dtype).smallest_subnormal
    v = np.array([[1, 0, 0], [0, -1, 0], [0, 0, 3], [1, 2, -3], [2, 0, 0], [0, 0, 0]]) * float(smallest)
    for scale in (1, 2.0**10, 2.0**60):
        w = (v * scale).astype(dtype)
        assert np.array_equal(expmap_to_euler(w), -w)
        assert np.array_equal(expmap_to_matrix(w)[:, [2, 0, 1], [1, 2, 0]], w)
        assert np.array_equal(expmap_to_quaternion(2 * w)[:, 1:], w)


@pytest.mark.parametrize("angle", [1e3, 1e6, 1e9, 1e12, 1e15, 4.5e15])
def test_large_angles_about_an_axis(angle):
    """The length is exact here, so the rotation is exact to the last digits."""
    for axis in range(3):
        v = np.zeros(3)
        v[axis] = angle
        assert np.abs(expmap_to_matrix(v) - to_numpy([exact_matrix(v)])[0]).max() < 1e-15
    v = np.array([angle, 0, 0], np.float32)
    assert np.abs(expmap_to_matrix(v) - to_numpy([exact_matrix(v)])[0]).max() < 2e-7


@pytest.mark.parametrize("size", [50.0, 1e3, 1e6])
def test_large_angles_about_any_axis(size):
    """The error comes from rounding the length: about half an epsilon of the angle."""
    v = turns("up to pi") / np.pi * size
    error = np.abs(expmap_to_matrix(v) - to_numpy([exact_matrix(row) for row in v])).max((1, 2))
    check(error / size, np.finfo(float).eps, mean=0.5, p95=1, worst=2)


@pytest.mark.parametrize("size", [1e3, 1e8, 1e300])
def test_large_euler_angles(size):
    for seq in ("h36m", "zxz"):
        a, b, c = rng_angles = np.random.default_rng(1).uniform(-size, size, 3)
        with mp.workdps(400):
            elementary = {
                "x": lambda t: mp.matrix([[1, 0, 0], [0, mp.cos(t), -mp.sin(t)], [0, mp.sin(t), mp.cos(t)]]),
                "z": lambda t: mp.matrix([[mp.cos(t), -mp.sin(t), 0], [mp.sin(t), mp.cos(t), 0], [0, 0, 1]]),
                "y": lambda t: mp.matrix([[mp.cos(t), 0, mp.sin(t)], [0, 1, 0], [-mp.sin(t), 0, mp.cos(t)]]),
            }
            a, b, c = mp.mpf(a), mp.mpf(b), mp.mpf(c)
            if seq == "h36m":
                exact = elementary["x"](-a) * elementary["y"](-b) * elementary["z"](-c)
            else:
                exact = elementary["z"](c) * elementary["x"](b) * elementary["z"](a)
        assert np.abs(euler_to_matrix(rng_angles, seq=seq) - to_numpy([exact])[0]).max() < 2e-15


@both_precisions
def test_logarithm(dtype):
    """From the matrix; near half a turn the direction is only determined up to its sign."""
    eps = np.finfo(dtype).eps
    for kind in ("up to pi", "near 0"):
        v = turns(kind).astype(dtype)
        check(np.abs(matrix_to_expmap(expmap_to_matrix(v)) - v).max(1), eps, mean=1.5, p95=4, worst=10)
    v = turns("near pi").astype(dtype)
    back = matrix_to_expmap(expmap_to_matrix(v))
    error = geodesic_angle(expmap_to_matrix(back.astype(float)), expmap_to_matrix(v.astype(float)))
    check(error, eps, mean=2, p95=5, worst=10)


@pytest.mark.parametrize("kind", ["up to pi", "near 0", "near pi"])
def test_geodesic_angle(kind):
    """Absolute precision near 0 and near pi, where the arc cosine of the trace loses half the digits."""
    v = turns(kind)
    exact = np.array([float(mp.norm(mp.matrix(list(map(float, row))))) for row in v])
    exact = np.minimum(exact, 2 * np.pi - exact)
    start = expmap_to_matrix(turns("pi to 2 pi"))
    error = np.abs(geodesic_angle(start, start @ expmap_to_matrix(v)) - exact)
    check(error, np.finfo(float).eps, mean=2.5, p95=6, worst=12)
    if kind != "up to pi":
        trace = np.trace(expmap_to_matrix(v), axis1=1, axis2=2)
        assert np.abs(np.arccos(np.clip((trace - 1) / 2, -1, 1)) - exact).max() > 1e-9
