"""Times and frames, through the public functions that take times."""

import re

import numpy as np
import pytest

import npss
from npss.protocol import ms_to_frames

N_FRAMES = 100
MOTION = np.random.default_rng(0).normal(size=(N_FRAMES, 2))


def frames(time, fps=25):
    return ms_to_frames([time], fps=fps)[0] + 1


def error_at(time, fps=25):
    return npss.euler_error(MOTION, MOTION + 1, fps=fps, at_ms=(time,))


def window_from(edge, fps=25):
    return npss.score_windows(MOTION, MOTION[::-1], fps=fps, edges_ms=(edge, N_FRAMES * 1000 / fps))


def window_to(edge, fps=25):
    return npss.score_windows(MOTION, MOTION[::-1], fps=fps, edges_ms=(0, edge))


NAMED = [(frames, "at_ms"), (error_at, "at_ms"), (window_from, "edges_ms"), (window_to, "edges_ms")]
HUGE = [10**400, -(10**400), 10**309]  # whole numbers beyond any float


def nearest(message):
    """Return the times named by an error."""
    (times,) = re.search(r"nearest: (.*) ms$", message).groups()
    return [float(time) for time in times.split(" and ")]


@pytest.mark.parametrize(("function", "name"), NAMED)
@pytest.mark.parametrize("time", HUGE, ids=["1e400", "-1e400", "1e309"])
def test_whole_numbers_too_large_for_a_float(function, name, time):
    with pytest.raises(ValueError, match=f"^{name}: .*is not a frame"):
        function(time)


@pytest.mark.parametrize(("function", "name"), NAMED)
@pytest.mark.parametrize("time", [np.nan, np.inf, -np.inf, np.float32("nan"), np.float64("inf")])
def test_times_that_are_not_finite(function, name, time):
    with pytest.raises(ValueError, match=f"^{name}: {float(time)} ms at 25 frames per second is not a frame"):
        function(time)


@pytest.mark.parametrize(("function", "name"), [(frames, "at_ms"), (error_at, "at_ms"), (window_to, "edges_ms")])
def test_a_finite_time_of_more_frames_than_floats_hold(function, name):
    with pytest.raises(ValueError, match=f"^{name}: 1e\\+308 ms at 1e\\+06 frames per second is not a frame"):
        function(1e308, fps=1e6)


@pytest.mark.parametrize(
    ("function", "time", "expected"),
    [
        # Below the first: one frame after the seed for a prediction, the beginning for a window.
        (frames, 0, [40]),
        (frames, -1e300, [40]),
        (error_at, 0, [40]),
        (error_at, -80, [40]),
        (window_from, -40, [0]),
        (window_from, -(10**300), [0]),
        # Beyond the last: that of the motion, or the last integer that floats hold exactly.
        (error_at, 4040, [4000]),
        (error_at, 10**300, [4000]),
        (window_to, 4040, [4000]),
        (window_to, 1e300, [4000]),
        (frames, 2**53 * 40 + 80, [2**53 * 40]),
        (frames, 1e300, [2**53 * 40]),
    ],
)
def test_out_of_range(function, time, expected):
    with pytest.raises(ValueError, match="out of range at 25 frames per second") as error:
        function(time)
    assert nearest(str(error.value)) == pytest.approx(expected, rel=1e-9, abs=0)


@pytest.mark.parametrize("function", [frames, error_at])
@pytest.mark.parametrize("time", [40, 80, 4000])
def test_the_first_and_the_last_are_in_range(function, time):
    assert function(time)


def test_the_last_whole_number_that_floats_hold_is_a_frame():
    assert frames(2**53 * 40) == 2**53


def test_edges_on_the_first_and_the_last_frame():
    assert window_from(0) == window_to(4000) == {"0-4": npss.score(MOTION, MOTION[::-1])}


@pytest.mark.parametrize(
    ("function", "time", "expected"),
    [
        (frames, 100, [80, 120]),
        (frames, 1, [40]),  # there is no frame 0
        (frames, -1, [40]),
        (frames, -100, [40]),
        (frames, 4010, [4000, 4040]),  # without a last frame
        (error_at, 100, [80, 120]),
        (error_at, 1, [40]),
        (error_at, 3999, [3960, 4000]),
        (error_at, 4001, [4000]),
        (error_at, 9999, [4000]),
        (window_to, 500, [480, 520]),
        (window_to, 3990, [3960, 4000]),
        (window_to, 4010, [4000]),
        (window_from, -10, [0]),
        (window_from, 10, [0, 40]),
    ],
)
def test_errors_name_the_nearest_frames(function, time, expected):
    with pytest.raises(ValueError, match="is not a whole number of frames at 25 frames per second") as error:
        function(time)
    named = nearest(str(error.value))
    assert named == expected
    for good in named:
        assert function(good)


@pytest.mark.parametrize("fps", [29.97, 30, 7])
@pytest.mark.parametrize("function", [frames, error_at])
def test_times_named_by_errors_are_frames(function, fps):
    for count in (1, 2, 3, 50, N_FRAMES - 1):
        with pytest.raises(ValueError, match="is not a whole number of frames") as error:
            function((count + 0.5) * 1000 / fps, fps)
        named = nearest(str(error.value))
        assert [frames(time, fps) for time in named] == [count, count + 1]
        assert all(function(time, fps) for time in named)


def test_errors_are_returned_by_time():
    errors = npss.euler_error(MOTION, MOTION * 2, fps=30, at_ms=(np.float64(100.0), 100 / 3, np.int64(500)))
    curve = npss.euler_error_curve(MOTION, MOTION * 2)
    assert errors == {100: curve[2], 100 / 3: curve[0], 500: curve[14]}
    assert [type(time) for time in errors] == [int, float, int]


@pytest.mark.parametrize("off", [1e-9, -1e-9])
def test_the_tolerance_is_a_billionth_of_a_frame(off):
    assert frames(40 * (2 + off / 2)) == 2
    assert window_to(40 * (50 + 25 * off)).popitem()[1] == npss.score(MOTION[:50], MOTION[::-1][:50])
    with pytest.raises(ValueError, match=r"^at_ms: .* is not a whole number of frames"):
        frames(40 * (2 + 10 * off))
    with pytest.raises(ValueError, match=r"^edges_ms: .* is not a whole number of frames"):
        window_to(40 * (50 + 500 * off))


@pytest.mark.parametrize("fps", [29.97, 30, 30000 / 1001, 60, 120])
def test_rates_at_which_no_frame_is_a_whole_time(fps):
    assert [frames(count * 1000 / fps, fps) for count in range(1, 500)] == list(range(1, 500))
    for count in (2, 3, 7, 50, N_FRAMES):
        expected = npss.score(MOTION[:count], MOTION[::-1][:count])
        assert list(window_to(count * 1000 / fps, fps).values()) == [expected]


@pytest.mark.parametrize("time", ["80", None, True, np.True_, 80j, [80]])
def test_invalid_times(time):
    for function, name in NAMED:
        with pytest.raises(TypeError, match=f"^{name}: expected a time in ms"):
            function(time)
