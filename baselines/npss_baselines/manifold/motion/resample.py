"""Resample motion without aliasing."""

from __future__ import annotations

from fractions import Fraction
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from npss.extras import install_hint
from npss.validation import Float64, check_finite, positive_number, real_array
from npss_baselines.manifold.motion.features import FPS

#: Share of the lower rate's Nyquist frequency below which all frequencies are kept.
PASS = 0.8
#: Attenuation of frequencies above the Nyquist frequency and, about equally, error below, in decibels.
ATTENUATION = 80
#: Largest relative difference between the ratio of the rates and a fraction of numbers up to `_LARGEST`.
TOLERANCE = 1e-4

_LARGEST = 2000


def resample(positions: npt.ArrayLike, fps: float, to: float = FPS) -> Float64:
    """Resample motion by a linear-phase low-pass filter.

    Frequencies below `PASS` of the lower rate's Nyquist frequency are kept (12 Hz for 30 frames per second). Those
    above the Nyquist frequency (15 Hz) are `ATTENUATION` dB down; taking every n-th frame would alias them. Motion is
    extended by point reflection in its first and last frame, which keeps the first frame and motion at constant speed.

    Parameters
    ----------
    positions : (T, J, 3) array_like
        Positions, or any values ``(T, ...)`` that can be averaged; not angles.
    fps : float
        Frames per second. Since files round rates, the ratio of the two is the nearest fraction of numbers up to 2000,
        if it is correct to one frame in ten thousand.
    to : float, optional
        Frames per second of the result.

    Returns
    -------
    (T', J, 3) ndarray of float64
        The resampled motion, from the first frame to at most the last: ``T' = floor((T - 1) to / fps) + 1``.

    Raises
    ------
    ImportError
        If scipy is not installed.
    TypeError
        If an argument does not hold real numbers.
    ValueError
        If there are no frames, a value is not finite, a rate is not positive, or no such fraction exists.

    Examples
    --------
    >>> resample([[0.0], [1.0], [2.0], [3.0], [4.0], [5.0]], fps=60).ravel().round(9).tolist()
    [0.0, 2.0, 4.0]
    """
    values = real_array("positions", positions)
    if values.ndim == 0 or 0 in values.shape:
        raise ValueError(f"positions: expected shape (T, J, 3), got {values.shape}")
    check_finite("positions", values)
    array = values.astype(np.float64)
    ratio = _ratio(positive_number("fps", fps), positive_number("to", to))
    if ratio == 1 or len(array) == 1:
        return array
    try:
        from scipy.signal import resample_poly
    except ImportError:
        raise ImportError(f"resampling needs scipy; {install_hint('manifold', baselines=True)}") from None
    up, down = ratio.numerator, ratio.denominator
    n_frames = (len(array) - 1) * up // down + 1
    taps = _low_pass(up, down)
    margin = len(taps) // (2 * up * down) + 1  # at least half a filter, in steps of `down` old or `up` new frames
    line = _line(array, np.arange(len(array)))
    widths = ((margin * down, margin * down), *((0, 0),) * (array.ndim - 1))
    extended = np.pad(array - line, widths, mode="reflect", reflect_type="odd")
    filtered: Float64 = resample_poly(extended, up, down, axis=0, window=taps)
    return _line(array, np.arange(n_frames) * down / up) + filtered[margin * up :][:n_frames]


def _line(array: Float64, frames: npt.NDArray[Any]) -> Float64:
    """Return the values at some frames of the straight line from the first to the last frame."""
    slope = (array[-1] - array[0]) / (len(array) - 1)
    line: Float64 = array[0] + slope * frames.reshape(-1, *(1,) * slope.ndim)
    return line


def _ratio(fps: float, to: float) -> Fraction:
    """Return the ratio of two rates as a fraction of small numbers."""
    ratio = to / fps
    fraction = Fraction(ratio).limit_denominator(_LARGEST)
    if not (1 <= fraction.numerator <= _LARGEST and abs(float(fraction) - ratio) <= TOLERANCE * ratio):
        raise ValueError(
            f"fps: {fps:g} to {to:g} frames per second is not within {TOLERANCE:g} of a ratio of two numbers up to "
            f"{_LARGEST}"
        )
    return fraction


@cache
def _low_pass(up: int, down: int) -> Float64:
    """Return a low-pass filter at `up` times the rate; its stop band begins at the lower rate's Nyquist frequency."""
    from scipy.signal import firwin, kaiserord

    width = 1 / max(up, down)  # from zero to that frequency
    n_taps, beta = kaiserord(ATTENUATION, (1 - PASS) * width)
    taps: Float64 = firwin(n_taps // 2 * 2 + 1, (1 + PASS) / 2 * width, window=("kaiser", beta))
    for phase in range(up):  # constants stay constant in each phase
        taps[phase::up] /= taps[phase::up].sum() * up
    return taps
