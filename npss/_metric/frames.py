"""Convert times to frames: a time that is not a whole number of frames is an error, which names the nearest."""

from __future__ import annotations

import math

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
    nearest = round(frames)
    # Decimal times are not exact in binary, so ignore a billionth of a frame.
    whole = abs(frames - nearest) <= 1e-9 * max(1.0, abs(frames))
    if whole and first <= nearest <= last:
        return nearest
    candidates = {nearest} if whole else {math.floor(frames), math.ceil(frames)}
    allowed = sorted({min(max(count, first), last) for count in candidates})
    nearby = " and ".join(f"{count * 1000 / fps:.10g}" for count in allowed)
    reason = "is out of range" if whole else "is not a whole number of frames"
    raise ValueError(f"{name}: {time:.12g} ms {reason} at {fps:g} frames per second; nearest: {nearby} ms")
