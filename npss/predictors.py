"""Untrained predictors: the baselines that every model has to beat."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np
import numpy.typing as npt

from npss.rotations._forms import result_dtype
from npss.validation import Array, check_finite, positive_integer, real_array, renamed

__all__ = ["PREDICTORS", "Predictor", "repeat", "running_average", "zero_velocity"]

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
}
