"""Unwrapping."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss

pytestmark = pytest.mark.numeric

SMOOTH = st.integers(0, 2**32 - 1).map(
    lambda seed: np.random.default_rng(seed).uniform(-3, 3, size=(2, 12, 3)).cumsum(axis=1)
)


def wrap(angles):
    return (angles + np.pi) % (2 * np.pi) - np.pi


@given(angles=SMOOTH)
def test_removes_what_wrapping_adds(angles):
    expected = angles - np.round((angles[:, :1] - wrap(angles[:, :1])) / (2 * np.pi)) * 2 * np.pi
    np.testing.assert_allclose(npss.unwrap(wrap(angles)), expected, rtol=0, atol=1e-9)


@given(angles=SMOOTH)
def test_with_seed_frames_equals_the_tail_of_the_whole(angles):
    wrapped = wrap(angles)
    whole = npss.unwrap(wrapped)
    np.testing.assert_array_equal(npss.unwrap(wrapped[:, 5:], seed_frames=wrapped[:, :5]), whole[:, 5:])
    np.testing.assert_array_equal(npss.unwrap(wrapped[0, 5:], seed_frames=wrapped[0, :5]), whole[0, 5:])


@given(angles=SMOOTH)
def test_idempotent_with_steps_of_at_most_half_a_turn(angles):
    once = npss.unwrap(wrap(angles))
    np.testing.assert_array_equal(npss.unwrap(once), once)
    assert np.abs(np.diff(once, axis=1)).max() <= np.pi + 1e-9
    assert once.dtype == np.float64


def test_seed_frames_matter():
    angles, seed = np.array([[-3.0], [-2.9]]), np.array([[3.0]])
    assert npss.unwrap(angles)[0, 0] == -3
    assert npss.unwrap(angles, seed_frames=seed)[0, 0] == pytest.approx(2 * np.pi - 3)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[np.nan]],), r"angles: nan at index \(0, 0\)"),
        (([1.0],), "angles: expected shape"),
        (([[1.0]], [[np.inf]]), r"seed_frames: inf at index \(0, 0\)"),
        (([[1.0]], [[1.0, 2.0]]), "seed_frames: its shape"),
        (([[1.0]], [[[1.0]]]), "seed_frames: its shape"),
        (([[1e300], [1.0]],), r"angles: 1e\+300 at index \(0, 0\) is too large"),
    ],
)
def test_bad_input(arguments, message):
    angles, *seed = arguments
    with pytest.raises(ValueError, match=message):
        npss.unwrap(angles, seed_frames=seed[0] if seed else None)


def test_input_is_not_written():
    angles = np.array([[3.0], [-3.0]])
    npss.unwrap(angles)
    np.testing.assert_array_equal(angles, [[3.0], [-3.0]])
