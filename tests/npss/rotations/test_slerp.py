"""Spherical interpolation: against scipy, the linear part of LaFAN1's, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation
from scipy.spatial.transform import Slerp as Reference

from npss.rotations import expmap_to_quaternion, quaternion_to_expmap, relative_angle, slerp
from rotation_strategies import both_precisions, expmaps, sample

fractions = st.lists(st.floats(0, 1), min_size=1, max_size=4)


def turn(q):
    """Return rotations of scipy, whose quaternions have the order x, y, z, w."""
    return Rotation.from_quat(np.roll(q, -1, axis=-1))


def angle(a, b):
    return relative_angle(a, b, representation="quaternion")


@pytest.mark.numeric
@given(expmaps(max_count=3), expmaps(max_count=3), fractions)
def test_against_scipy(v, w, t):
    n = min(len(v), len(w))
    a, b = expmap_to_quaternion(v[:n]), expmap_to_quaternion(w[:n])
    got = slerp(a, b, t)
    assert got.shape == (len(t), n, 4)
    for i in range(n):
        if angle(a[i], b[i]) > np.pi - 1e-6:
            continue  # both arcs are equally short
        ends = turn([a[i], b[i]])
        expected = np.roll(Reference([0, 1], ends)(t).as_quat(), 1, axis=-1)
        assert angle(got[:, i], expected).max() < 1e-7  # the reference's own error for small angles
        travelled = angle(np.broadcast_to(a[i], (len(t), 4)), got[:, i])
        np.testing.assert_allclose(travelled, np.multiply(t, angle(a[i], b[i])), rtol=0, atol=3e-14)


@pytest.mark.numeric
@given(expmaps(max_count=1), expmaps(max_count=1), st.floats(0, 1), st.sampled_from([1, -1]), st.sampled_from([1, -1]))
def test_ends_signs_and_reversal(v, w, t, first, second):
    a, b = first * expmap_to_quaternion(v[0]), second * expmap_to_quaternion(w[0])
    # Components are at most 1, and each goes through about ten roundings.
    np.testing.assert_allclose(slerp(a, b, 0), a, rtol=0, atol=1e-14)
    assert angle(slerp(a, b, 1), b) < 1e-14
    between = slerp(a, b, t)
    assert between @ a > -1e-14  # in the hemisphere of a
    assert abs(np.linalg.norm(between) - 1) < 1e-14
    if angle(a, b) < np.pi - 1e-6:
        assert angle(slerp(b, a, 1 - t), between) < 1e-14
        assert angle(slerp(-a, b, t), between) < 1e-14
        for length in (1e-300, 1e300):  # half a digit of tiny components may underflow
            np.testing.assert_allclose(slerp(length * a, b, t), between, rtol=0, atol=1e-14)


def test_signs_of_the_smallest_quaternions():
    for a in ([5e-324, 0, 0, 0], [-5e-324, 0, 0, 0], [0, -1e-320, 0, 0]):
        np.testing.assert_array_equal(slerp(a, [1, 1, 0, 0], 0), np.sign(a))


@pytest.mark.numeric
def test_tiny_angles_keep_their_digits():
    v = np.array([1e-12, 2e-12, -3e-12])
    a, b = expmap_to_quaternion(np.zeros(3)), expmap_to_quaternion(v)
    np.testing.assert_allclose(quaternion_to_expmap(slerp(a, b, 0.25)), v / 4, rtol=1e-14)


def by_description(a, b, t, limit):
    """Return one quaternion: linear where the dot product exceeds the limit, normalised."""
    dot = a @ b
    if dot < 0:
        b, dot = -b, -dot
    if dot > limit:
        before, after = 1 - t, t
    else:
        omega = np.arccos(dot)
        before, after = np.sin((1 - t) * omega) / np.sin(omega), np.sin(t * omega) / np.sin(omega)
    between = before * a + after * b
    return between / np.linalg.norm(between)


@pytest.mark.numeric
def test_linear_where_close():
    """The released baseline of in-betweening: linear above a dot product of 0.99."""
    a = sample("quaternion", (40,))
    further = sample("expmap", (40,), seed=1) * np.geomspace(1e-3, 1, 40)[:, np.newaxis]
    b = np.roll((turn(a) * Rotation.from_rotvec(further)).as_quat(), 1, axis=-1)
    t = np.linspace(0, 1, 7)
    expected = [[by_description(p, q, x, 0.99) for p, q in zip(a, b, strict=True)] for x in t]
    np.testing.assert_allclose(slerp(a, b, t, linear_above=0.99), expected, rtol=0, atol=1e-14)
    close = np.abs((a * b).sum(-1)) > 0.99
    assert 10 < close.sum() < 30
    apart = angle(slerp(a, b, t, linear_above=0.99), slerp(a, b, t)).max(axis=0)
    assert not apart[~close].any()
    assert apart[close].max() > 1e-5


@both_precisions
@pytest.mark.parametrize("axis", [0, 1, 2, -2, -3, -4])
def test_shapes_axes_and_precisions(axis, dtype):
    a, b = (sample("quaternion", (2, 3), seed=s, dtype=dtype) for s in (0, 1))
    t = np.array([0.0, 0.25, 1.0])
    got = slerp(a, b, t, axis=axis)
    assert got.dtype == dtype
    assert got.flags.c_contiguous
    for k, x in enumerate(t):
        np.testing.assert_array_equal(np.take(got, k, axis), slerp(a, b, x))
    assert slerp(a[:0], b[:0], t, axis=axis).size == 0
    assert slerp(a, b, [], axis=axis).size == 0
    assert slerp(a[0, 0], b[0, 0].astype(np.float64), 0.5).dtype == np.float64


@pytest.mark.parametrize(
    ("arguments", "options", "error", "message"),
    [
        ((np.ones((2, 4)), np.ones(4), 0.5), {}, ValueError, r"b: its shape \(4,\) differs from that of a, \(2, 4\)"),
        ((np.ones(3), np.ones(3), 0.5), {}, ValueError, r"a: expected shape \(..., 4\)"),
        ((np.ones(4), np.zeros(4), 0.5), {}, ValueError, "b: a zero quaternion"),
        ((np.ones(4), np.ones(4), 1.5), {}, ValueError, "t: expected numbers from 0 to 1, got 1.5"),
        ((np.ones(4), np.ones(4), [0, -0.1]), {}, ValueError, "t: expected numbers from 0 to 1, got -0.1"),
        ((np.ones(4), np.ones(4), np.nan), {}, ValueError, "t: nan"),
        ((np.ones(4), np.ones(4), np.ones((2, 2))), {}, ValueError, r"t: expected a number or shape \(K,\)"),
        ((np.ones(4), np.ones(4), "0.5"), {}, TypeError, "t: expected real numbers"),
        ((np.ones(4), np.ones(4), [0.5]), {"axis": 1}, ValueError, "axis: expected an axis before the last of 2"),
        ((np.ones(4), np.ones(4), [0.5]), {"axis": 2}, ValueError, "axis: expected an axis before the last of 2"),
        ((np.ones(4), np.ones(4), [0.5]), {"axis": 0.0}, TypeError, "axis: expected a whole number"),
        ((np.ones(4), np.ones(4), 0.5), {"linear_above": 2}, ValueError, "linear_above: expected a number from 0 to 1"),
        ((np.ones(4), np.ones(4), 0.5), {"linear_above": "x"}, TypeError, "linear_above: expected a number"),
    ],
)
def test_what_is_refused(arguments, options, error, message):
    with pytest.raises(error, match=f"^{message}"):
        slerp(*arguments, **options)


# ---- the angle between rotations in any representation


@pytest.mark.numeric
@pytest.mark.parametrize("representation", ["expmap", "matrix", "quaternion", "sixd", "euler"])
def test_relative_angles_against_scipy(representation):
    a, b = sample(representation, (9, 2)), sample(representation, (9, 2), seed=1)
    v, w = (sample("expmap", (9, 2), seed=s).reshape(-1, 3) for s in (0, 1))
    expected = (Rotation.from_rotvec(v).inv() * Rotation.from_rotvec(w)).magnitude().reshape(9, 2)
    np.testing.assert_allclose(relative_angle(a, b, representation=representation), expected, rtol=0, atol=1e-13)


@pytest.mark.numeric
def test_relative_angles_of_sequences_and_layouts():
    a, b = ([0.1, 0.2, 0.3], [0.3, 0.2, 0.1])
    expected = (Rotation.from_euler("zyx", a).inv() * Rotation.from_euler("zyx", b)).magnitude()
    assert abs(relative_angle(a, b, representation="euler", seq="zyx") - expected) < 1e-14
    quarter = relative_angle([1, 0, 0, 1, 0, 0], [0, -1, 1, 0, 0, 0], representation="sixd", layout="rows")
    assert abs(quarter - np.pi / 2) < 1e-14


def test_relative_angles_refuse_guesses():
    for options, error, message in [
        ({"representation": "quat"}, ValueError, "representation: expected one of expmap, matrix"),
        ({"representation": None}, TypeError, "representation: expected one of"),
        ({"representation": "matrix", "seq": "abc"}, ValueError, "seq"),
        ({"representation": "matrix", "layout": "abc"}, ValueError, "layout"),
    ]:
        with pytest.raises(error, match=f"^{message}"):
            relative_angle(np.eye(3), np.eye(3), **options)
    with pytest.raises(ValueError, match=r"^b: its shape \(4,\)"):
        relative_angle(np.ones((2, 4)), np.ones(4), representation="quaternion")
