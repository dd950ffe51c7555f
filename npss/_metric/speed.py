"""The speed of a prediction, as a ratio to that of the ground truth."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from npss._metric.euler_error import moving, pair_blocks
from npss.validation import BeyondFloat64Error, Float64, check_finite, is_integer, motion_pair


def speed_ratio(gt: npt.ArrayLike, pred: npt.ArrayLike, *, start: int = 1, wrap: bool = True) -> float:
    """Return how fast a prediction moves: its mean speed divided by that of the ground truth.

    The speed of a feature is the absolute difference of two successive frames. The mean is over sequences, the features
    that move in the ground truth, and frames. Neither more nor less is better: 1 is right. NPSS hardly depends on it,
    so print it beside the score.

    Parameters
    ----------
    gt, pred : (N, T, D), (T, D) or (N, T, J, C) array_like
        Ground truth and prediction: Euler angles in radians, or other features with ``wrap=False``.
    start : int, optional
        The first frame t whose difference from the frame before it counts, from 0: at 25 frames per second, 25 leaves
        out the first second.
    wrap : bool, optional
        Whether to wrap differences to -pi to pi, so that a jump of 2 pi, which is no motion, does not count.

    Returns
    -------
    float
        At least 0; 0 for a prediction that stands still.

    Raises
    ------
    TypeError
        If `gt` or `pred` does not hold real numbers, `start` is not a whole number, or `wrap` is not a truth value.
    ValueError
        If the shapes are wrong or differ, a value is NaN or infinite, `start` is not from 1 to T - 1, or nothing moves
        in the ground truth. A feature of a sequence moves if its standard deviation over the T frames exceeds 1e-4.

    See Also
    --------
    euler_error : compares the same features.

    Notes
    -----
    State `start` where you print the number, and that differences are wrapped.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt = np.linspace(0, 1, 25)[:, np.newaxis] * [1.0, 2.0]
    >>> npss.speed_ratio(gt, 0.5 * gt)
    0.5
    """
    truth, prediction = motion_pair(gt, pred)
    n_frames = truth.shape[-2]
    if not is_integer(start):
        raise TypeError(f"start: expected a whole number, got {start!r}")
    if not 1 <= start < n_frames:
        raise ValueError(f"start: expected a frame from 1 to {n_frames - 1}, got {start}")
    if not isinstance(wrap, bool):
        raise TypeError(f"wrap: expected True or False, got {wrap!r}")
    check_finite("gt", truth)
    check_finite("pred", prediction)
    paths = np.zeros(2)  # the lengths of the paths of all features
    with np.errstate(over="ignore", invalid="ignore"):
        for _, *both in pair_blocks(truth, prediction):
            moves = moving(both[0])
            paths += [_path(motion[:, start - 1 :], wrap)[moves].sum() for motion in both]
    for name, path in zip(("gt", "pred"), paths, strict=True):
        if not np.isfinite(path):
            raise BeyondFloat64Error(name, "its speed is beyond the largest float64")
    if paths[0] == 0:
        raise ValueError(f"gt: nothing moves from frame {start} on, so there is no speed to compare with")
    return float(paths[1] / paths[0])


def _path(motion: Float64, wrap: bool) -> Float64:
    """Return the length of the path of each feature, ``(n, D)``."""
    steps = np.diff(motion, axis=1)
    if wrap:
        steps -= 2 * math.pi * np.rint(steps / (2 * math.pi))
    path: Float64 = np.abs(steps).sum(axis=1)
    return path
