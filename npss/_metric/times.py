"""Errors at times: the frame of each time, and the error at it, averaged or summed up to it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

from npss._metric.frames import whole_frames
from npss.validation import Float64, each, one_of, positive_number

#: The error at a time, the mean up to it, or the sum up to it.
Average = Literal["at", "up-to", "sum"]


def frames_at(at_ms: Sequence[float], fps: float, n_frames: int) -> dict[float, int]:
    """Return the frame of each time, counted from 1; whole numbers of milliseconds are ints.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, or a time is not that of a frame. The message then names the nearest times.
    """
    rate = positive_number("fps", fps)
    frames: dict[float, int] = {}
    for time in each("at_ms", at_ms):
        frame = whole_frames("at_ms", time, rate, first=1, last=n_frames)
        frames[int(time) if time == int(time) else float(time)] = frame
    return frames


def errors_at(curve: Float64, frames: dict[float, int], average: Average) -> dict[float, float]:
    """Return the error at each time from the curve ``(T,)`` of errors."""
    if average == "at":
        return {time: float(curve[frame - 1]) for time, frame in frames.items()}
    if average == "sum":
        return {time: float(curve[:frame].sum()) for time, frame in frames.items()}
    return {time: float(curve[:frame].mean()) for time, frame in frames.items()}


def check_average(average: str) -> None:
    """Raise a TypeError or ValueError unless it is an `Average`."""
    one_of("average", average, get_args(Average))
