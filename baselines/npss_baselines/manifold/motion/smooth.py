"""Smooth motion in time."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.validation import Float64, check_finite, positive_number, real_array

__all__ = ["smoothed"]

#: The standard deviation of the filter in frames. A manifold's steps of eight frames leave jitter, by which decoded
#: motion has ten times the jerk of real motion; with this filter, it has about the same.
DEVIATION = 1.25


def smoothed(features: npt.ArrayLike, *, deviation: float = DEVIATION) -> Float64:
    """Smooth each feature in time by a Gaussian filter; the first and last frames are repeated beyond the ends.

    Parameters
    ----------
    features : (..., T, F) array_like
        Motions.
    deviation : float, optional
        Standard deviation of the filter in frames; the filter is cut at four of them.

    Returns
    -------
    (..., T, F) ndarray of float64
        The smoothed motions.

    Raises
    ------
    TypeError, ValueError
        If the features are invalid, or the deviation is not positive.

    Examples
    --------
    A single jump spreads, and keeps its sum:

    >>> spread = smoothed([[0.0]] * 9 + [[1.0]] + [[0.0]] * 9)
    >>> float(spread[9, 0].round(3)), float(spread.sum().round(9))
    (0.319, 1.0)
    """
    array = real_array("features", features)
    if array.ndim < 2 or 0 in array.shape:
        raise ValueError(f"features: expected shape (..., T, F) = (..., frames, features), got {array.shape}")
    check_finite("features", array)
    reach = int(np.ceil(4 * positive_number("deviation", deviation)))
    weights = np.exp(-np.square(np.arange(-reach, reach + 1) / deviation) / 2)
    beyond = [(0, 0)] * (array.ndim - 2) + [(reach, reach), (0, 0)]
    padded = np.pad(array.astype(np.float64), beyond, mode="edge")
    near = np.lib.stride_tricks.sliding_window_view(padded, 2 * reach + 1, axis=-2)  # (..., T, F, lags)
    smooth: Float64 = near @ (weights / weights.sum())
    return smooth
