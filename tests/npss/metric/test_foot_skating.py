"""Foot skating: the definition in a loop, properties, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss

pytestmark = pytest.mark.numeric

OPTIONS = {"feet": [1, 3], "up": "y", "height": 0.5, "fps": 30}


def by_definition(positions, feet, up, height, fps, floor=0.0):
    vertical = "xyz".index(up)
    flat = [axis for axis in range(3) if axis != vertical]
    skating = []
    for sequence in positions:
        for t in range(1, len(sequence)):
            for foot in feet:
                step = sequence[t, foot] - sequence[t - 1, foot]
                speed = fps * sum(step[axis] ** 2 for axis in flat) ** 0.5
                exponent = min(max((sequence[t, foot, vertical] - floor) / height, 0), 1)
                skating.append(speed * (2 - 2**exponent))
    return sum(skating) / len(skating)


@pytest.mark.parametrize("up", ["x", "y", "z"])
@given(st.integers(0, 2**32 - 1), st.floats(-1, 1))
def test_equals_the_definition(up, seed, floor):
    positions = np.random.default_rng(seed).normal(size=(2, 5, 4, 3))
    options = OPTIONS | {"up": up, "floor": floor}
    expected = by_definition(positions, **options)
    assert npss.height_weighted_foot_skating(positions, **options) == pytest.approx(expected, rel=1e-12, abs=1e-12)
    flat = npss.height_weighted_foot_skating(positions.reshape(2, 5, 12), **options)
    assert flat == pytest.approx(expected, rel=1e-12, abs=1e-12)


@given(st.integers(0, 2**32 - 1))
def test_units_turns_and_other_joints(seed):
    positions = np.random.default_rng(seed).normal(size=(2, 5, 4, 3))
    value = npss.height_weighted_foot_skating(positions, **OPTIONS)
    in_millimetres = npss.height_weighted_foot_skating(1000 * positions, **OPTIONS | {"height": 500})
    assert in_millimetres == pytest.approx(1000 * value, rel=1e-12)
    turned = positions[..., [2, 1, 0]] * [1, 1, -1]
    assert npss.height_weighted_foot_skating(turned, **OPTIONS) == pytest.approx(value, rel=1e-12)
    moved = positions.copy()
    moved[:, :, [0, 2]] += 1
    assert npss.height_weighted_foot_skating(moved, **OPTIONS) == value
    higher = positions + [0, 100, 0]
    assert npss.height_weighted_foot_skating(higher, **OPTIONS) == 0
    lower = npss.height_weighted_foot_skating(positions - [0, 100, 0], **OPTIONS)
    assert lower >= value
    # Only the horizontal speed counts.
    jumping = positions.copy()
    jumping[..., [0, 2]] = 0
    assert npss.height_weighted_foot_skating(jumping, **OPTIONS) == 0


def test_half_height_by_hand():
    """One unit per frame at half the height: 1 * 30 * (2 - sqrt 2)."""
    foot = np.arange(4.0)[:, np.newaxis] * [1, 0, 0] + [0, 0.25, 0]
    got = npss.height_weighted_foot_skating(foot, **OPTIONS | {"feet": [0]})
    assert got == pytest.approx(30 * (2 - np.sqrt(2)), rel=1e-13)
    context = {"fps": 30, "extra": {"height": 0.5, "floor": 0.0, "feet": "0"}}
    text = 'height_weighted_foot_skating|version:1|fps:30|feet:"0"|floor:0|height:0.5'
    assert npss.signature(None, metric="height_weighted_foot_skating", **context) == text


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"up": "Y"}, ValueError, "up: expected one of x, y, z"),
        ({"feet": [4]}, ValueError, "feet: expected indices from 0 to 3, got 4"),
        ({"feet": 1}, TypeError, "feet: expected a sequence of"),
        ({"height": 0}, ValueError, "height: expected a positive"),
        ({"fps": -1}, ValueError, "fps: expected a positive"),
        ({"floor": np.inf}, ValueError, "floor: expected a finite number"),
        ({"floor": "0"}, TypeError, "floor: expected a number"),
    ],
)
def test_what_is_refused(options, error, message):
    with pytest.raises(error, match=f"^{message}"):
        npss.height_weighted_foot_skating(np.ones((2, 5, 4, 3)), **OPTIONS | options)


def test_refused_positions():
    with pytest.raises(ValueError, match=r"^positions: expected at least two frames"):
        npss.height_weighted_foot_skating(np.ones((2, 1, 4, 3)), **OPTIONS)
    with pytest.raises(ValueError, match=r"^positions: shape \(2, 5, 3, 3\) may be"):
        npss.height_weighted_foot_skating(np.ones((2, 5, 3, 3)), **OPTIONS)


def test_a_speed_beyond_float64_is_refused():
    huge = np.zeros((1, 2, 1, 3))
    huge[0, 1] = [1e308, 0, 1e308]
    with pytest.raises(ValueError, match=r"^positions: their speed is beyond float64"):
        npss.height_weighted_foot_skating(huge, fps=30, feet=[0], height=1.0, up="y")
