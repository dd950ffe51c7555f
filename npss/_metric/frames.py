"""Convert times to frames: a time that is not a whole number of frames is an error, or left out."""

from __future__ import annotations

import math
from collections.abc import Iterable

from npss.validation import is_real

_MOST = 2**53  # frames; float64 skips some integers beyond


def whole_frames(name: str, time: float, fps: float, *, first: int = 0, last: int = _MOST) -> int:
    """Convert a time to a number of frames.

    Parameters
    ----------
    name : str
        Name of the argument, for errors.
    time : float
        In milliseconds.
    fps : float
        Frames per second.
    first, last : int, optional
        The fewest and the most frames allowed.

    Raises
    ------
    TypeError
        If the time is not a real number.
    ValueError
        If it is not a whole number of frames, or out of range. The message names the nearest valid times.
    """
    if not is_real(time):
        raise TypeError(f"{name}: expected a time in ms, got {time!r}")
    try:
        frames = float(time) * fps / 1000
    except OverflowError:
        raise ValueError(f"{name}: a whole number beyond float64 is not a frame") from None
    if not math.isfinite(frames):
        raise ValueError(f"{name}: {time} ms at {fps:g} frames per second is not a frame")
    nearest, whole = round(frames), _is_whole(frames)
    if whole and first <= nearest <= last:
        return nearest
    candidates = {nearest} if whole else {math.floor(frames), math.ceil(frames)}
    allowed = sorted({min(max(count, first), last) for count in candidates})
    nearby = " and ".join(f"{count * 1000 / fps:.10g}" for count in allowed)
    reason = "is out of range" if whole else "is not a whole number of frames"
    raise ValueError(f"{name}: {time:.12g} ms {reason} at {fps:g} frames per second; nearest: {nearby} ms")


def whole_times(times: Iterable[int], fps: float, n_frames: int) -> list[int]:
    """Return the times in milliseconds that are whole frames, up to a number of frames.

    Examples
    --------
    >>> whole_times((80, 400, 1000, 2000), fps=30, n_frames=45)
    [400, 1000]
    """
    frames = {time: time * fps / 1000 for time in times}
    return [time for time, frame in frames.items() if _is_whole(frame) and round(frame) <= n_frames]


def _is_whole(frames: float) -> bool:
    """Return whether a number of frames is whole: decimal times are not exact in binary, so but for a billionth."""
    return abs(frames - round(frames)) <= 1e-9 * max(1.0, abs(frames))
