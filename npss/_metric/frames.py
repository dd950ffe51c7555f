"""Times and frames: a time is a whole number of frames, or an error that names the nearest that are."""

from __future__ import annotations

import math

from npss.validation import is_real

_MOST = 2**53  # frames; beyond, floats skip some


def whole_frames(name: str, time: float, fps: float, *, first: int = 0, last: int = _MOST) -> int:
    """Return how many frames a time is.

    Parameters
    ----------
    name : str
        What the caller calls this argument; errors begin with it.
    time : float
        In milliseconds.
    fps : float
        Frames per second.
    first, last : int, optional
        The fewest and the most frames that are allowed.

    Raises
    ------
    TypeError
        If the time is not a real number.
    ValueError
        If it is not a whole number of frames, or is out of range: names the nearest times that are allowed.
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
    # Decimal times are not exact in binary; a billionth of a frame is not meant.
    whole = abs(frames - nearest) <= 1e-9 * max(1.0, abs(frames))
    if whole and first <= nearest <= last:
        return nearest
    candidates = {nearest} if whole else {math.floor(frames), math.ceil(frames)}
    allowed = sorted({min(max(count, first), last) for count in candidates})
    nearby = " and ".join(f"{count * 1000 / fps:.10g}" for count in allowed)
    why = "is out of range" if whole else "is not a whole number of frames"
    raise ValueError(f"{name}: {time:.12g} ms {why} at {fps:g} frames per second; nearest: {nearby} ms")
