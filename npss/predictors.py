"""Untrained predictors: the baselines that every model has to beat."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt

from npss.rotations._forms import result_dtype
from npss.validation import (
    Array,
    Float64,
    check_finite,
    each,
    positive_integer,
    positive_number,
    real_array,
    renamed,
)

__all__ = [
    "PREDICTORS",
    "Predictor",
    "gated_periodic",
    "periodic",
    "repeat",
    "running_average",
    "zero_velocity",
]

#: ``predictor(seed_frames, n_target)``: maps poses ``(N, S, D)`` to the next `n_target` poses ``(N, n_target, D)``.
Predictor = Callable[[npt.ArrayLike, int], Array]


@renamed(seed="seed_frames")
def zero_velocity(seed_frames: npt.ArrayLike, n_target: int) -> Array:
    """Hold the last seed frame.

    Parameters
    ----------
    seed_frames : (N, S, D) array_like
        The seed frames, in any representation.
    n_target : int
        Frames to predict.

    Returns
    -------
    (N, n_target, D) ndarray
        float32 for float32, float64 otherwise.

    Raises
    ------
    TypeError
        If `seed_frames` does not hold real numbers, or `n_target` is not an integer.
    ValueError
        If the shape of `seed_frames` is not ``(N, S, D)``, a value is NaN or infinite, or `n_target` is not positive.

    References
    ----------
    J. Martinez et al., "On Human Motion Prediction Using Recurrent Neural Networks", CVPR 2017.

    Examples
    --------
    >>> zero_velocity([[[1.0], [2.0]]], 3).tolist()
    [[[2.0], [2.0], [2.0]]]
    """
    return running_average(seed_frames, n_target, frames=1)


@renamed(seed="seed_frames")
def running_average(seed_frames: npt.ArrayLike, n_target: int, *, frames: int) -> Array:
    """Hold the average of the last seed frames.

    Parameters
    ----------
    seed_frames : (N, S, D) array_like
        The seed frames, in a representation that can be averaged.
    n_target : int
        Frames to predict.
    frames : int
        Number of seed frames to average; the paper uses 2 and 4.

    Returns
    -------
    (N, n_target, D) ndarray
        float32 for float32, float64 otherwise.

    Raises
    ------
    TypeError, ValueError
        As for `zero_velocity`; also if there are fewer seed frames.

    References
    ----------
    J. Martinez et al., "On Human Motion Prediction Using Recurrent Neural Networks", CVPR 2017.

    Examples
    --------
    >>> running_average([[[1.0], [2.0]]], 3, frames=2).tolist()
    [[[1.5], [1.5], [1.5]]]
    """
    last = _last(seed_frames, frames)
    mean = last.mean(axis=1, dtype=np.float64, keepdims=True).astype(last.dtype)
    return np.repeat(mean, positive_integer("n_target", n_target), axis=1)


@renamed(seed="seed_frames")
def repeat(seed_frames: npt.ArrayLike, n_target: int, *, frames: int = 50) -> Array:
    """Repeat the last seed frames in a loop.

    Parameters
    ----------
    seed_frames : (N, S, D) array_like
        The seed frames, in any representation.
    n_target : int
        Frames to predict.
    frames : int, optional
        Number of seed frames to repeat.

    Returns
    -------
    (N, n_target, D) ndarray
        float32 for float32, float64 otherwise.

    Raises
    ------
    TypeError, ValueError
        As for `zero_velocity`; also if there are fewer seed frames.

    Examples
    --------
    >>> repeat([[[1.0], [2.0], [3.0]]], 5, frames=2).tolist()
    [[[2.0], [3.0], [2.0], [3.0], [2.0]]]
    """
    last = _last(seed_frames, frames)
    return last[:, np.arange(positive_integer("n_target", n_target)) % last.shape[1]]


@renamed(seed="seed_frames")
def periodic(
    seed_frames: npt.ArrayLike,
    n_target: int,
    *,
    lags: tuple[int, int] = (15, 40),
    frames: int = 10,
    decay: float = 5.0,
) -> Array:
    """Repeat the last period of the motion, joined smoothly to the last seed frame.

    The period of a sequence is the lag at which its last frames are nearest to those before, by the Euclidean distance
    over frames and features; the shortest such lag. The repeated frames start with the difference between the last
    seed frame and the frame a period before, which then decays.

    Parameters
    ----------
    seed_frames : (N, S, D) array_like
        The seed frames, in a representation that can be averaged. The period depends on the units of the features.
    n_target : int
        Frames to predict.
    lags : (int, int), optional
        The shortest and the longest period, in frames.
    frames : int, optional
        Number of last frames to compare with those a period before.
    decay : float, optional
        Frames until the difference has shrunk to 1/e.

    Returns
    -------
    (N, n_target, D) ndarray
        float32 for float32, float64 otherwise.

    Raises
    ------
    TypeError, ValueError
        As for `zero_velocity`; also if there are fewer than ``lags[1] + frames`` seed frames, or an option is invalid.

    Examples
    --------
    >>> seed_frames = [[[0.0], [1.0], [2.0], [0.0], [1.0], [2.0]]]
    >>> periodic(seed_frames, 4, lags=(2, 4), frames=2).tolist()
    [[[0.0], [1.0], [2.0], [0.0]]]
    """
    seen, period = _period(seed_frames, lags, frames)
    return _periodic(seen, period, n_target, decay).astype(seen.dtype)


@renamed(seed="seed_frames")
def gated_periodic(
    seed_frames: npt.ArrayLike,
    n_target: int,
    *,
    lags: tuple[int, int] = (15, 40),
    frames: int = 10,
    decay: float = 5.0,
) -> Array:
    """Repeat the last period of the motion as far as the seed frames repeat themselves.

    The deviation of `periodic` from the last seed frame is scaled by a gate for each sequence and feature,
    min(1, max(.15, 1.5 - r)). r is the root mean square of the difference between the last frames and those a period
    before, over the standard deviation of the feature in the frames that are compared. So the prediction lies between
    `zero_velocity` and `periodic`. The constants were fitted on training subjects of Human3.6M.

    Parameters
    ----------
    seed_frames : (N, S, D) array_like
        The seed frames, in a representation that can be averaged. The period depends on the units of the features.
    n_target : int
        Frames to predict.
    lags, frames, decay : optional
        As for `periodic`.

    Returns
    -------
    (N, n_target, D) ndarray
        float32 for float32, float64 otherwise.

    Raises
    ------
    TypeError, ValueError
        As for `periodic`.

    Examples
    --------
    >>> seed_frames = [[[0.0], [1.0], [2.0], [0.0], [1.0], [2.0]]]
    >>> gated_periodic(seed_frames, 4, lags=(2, 4), frames=2).tolist()
    [[[0.0], [1.0], [2.0], [0.0]]]
    """
    seen, period = _period(seed_frames, lags, frames)
    last = seen[:, -1:].astype(np.float64)
    gate = _gate(seen.astype(np.float64), period, frames)
    return (last + gate * (_periodic(seen, period, n_target, decay) - last)).astype(seen.dtype)


def _period(seed_frames: npt.ArrayLike, lags: tuple[int, int], frames: int) -> tuple[Array, npt.NDArray[np.intp]]:
    """Read the seed frames (N, S, D) that are compared, and find the period of each sequence (N,)."""
    frames = positive_integer("frames", frames)
    if len(each("lags", lags, "integers")) != 2:
        raise ValueError(f"lags: expected two integers, the shortest and the longest, got {lags!r}")
    shortest, longest = (positive_integer("lags", lag) for lag in lags)
    if shortest > longest:
        raise ValueError(f"lags: expected the shortest and the longest, got {shortest} and {longest}")
    seen = _last(seed_frames, longest + frames)
    wide = seen.astype(np.float64)
    end = wide.shape[1]
    distances = [
        np.square(wide[:, -frames:] - wide[:, end - frames - lag : end - lag]).sum(axis=(1, 2))
        for lag in range(shortest, longest + 1)
    ]
    return seen, shortest + np.argmin(distances, axis=0)


def _periodic(seen: Array, period: npt.NDArray[np.intp], n_target: int, decay: float) -> Float64:
    """Repeat the last period of each sequence; the difference from the last frame decays."""
    time = np.arange(positive_integer("n_target", n_target))
    first = seen.shape[1] - period[:, np.newaxis]
    wide = seen.astype(np.float64)
    repeated = np.take_along_axis(wide, (first + time % period[:, np.newaxis])[..., np.newaxis], axis=1)
    step = wide[:, -1:] - np.take_along_axis(wide, first[..., np.newaxis] - 1, axis=1)
    result: Float64 = repeated + step * np.exp(-time / positive_number("decay", decay))[:, np.newaxis]
    return result


def _gate(seen: Float64, period: npt.NDArray[np.intp], frames: int) -> Float64:
    """Return how far each feature is trusted to repeat itself, (N, 1, D)."""
    late = np.arange(seen.shape[1] - frames, seen.shape[1])
    early = np.take_along_axis(seen, (late - period[:, np.newaxis])[..., np.newaxis], axis=1)
    misfit = np.sqrt(np.square(seen[:, late] - early).mean(axis=1, keepdims=True))
    spread = seen.std(axis=1, keepdims=True)
    ratio = np.divide(misfit, spread, out=np.full_like(misfit, np.inf), where=spread > 0)
    gate: Float64 = np.clip(1.5 - ratio, 0.15, 1)
    return gate


def _last(seed_frames: npt.ArrayLike, frames: int) -> Array:
    """Read the last seed frames."""
    frames = positive_integer("frames", frames)
    array = real_array("seed_frames", seed_frames)
    if array.ndim != 3 or array.size == 0:
        raise ValueError(f"seed_frames: expected shape (N, S, D) = (sequences, frames, features), got {array.shape}")
    if array.shape[1] < frames:
        raise ValueError(f"seed_frames: {array.shape[1]} frames, but the predictor uses the last {frames}")
    check_finite("seed_frames", array)
    return array[:, -frames:].astype(result_dtype(array))


#: The predictors by their names on the command line and in records.
PREDICTORS: dict[str, Predictor] = {
    "zero-velocity": zero_velocity,
    "running-average-2": partial(running_average, frames=2),
    "running-average-4": partial(running_average, frames=4),
    "repeat-50": partial(repeat, frames=50),
    "periodic": periodic,
    "gated-periodic": gated_periodic,
}
