"""Read samples: several predictions of every sequence."""

from __future__ import annotations

import numpy.typing as npt

from npss.validation import Array, Float64, check_finite, motion_array, motion_shape, real_array


def read_samples(gt: npt.ArrayLike, samples: npt.ArrayLike, representation: str | None = None) -> tuple[Array, Array]:
    """Read ground truth ``(N, T, D)`` and samples ``(S, N, T, D)``, flattened joint by joint.

    Raises
    ------
    TypeError, ValueError
        If either is invalid, or the shape of the samples is not ``(S,)`` and that of the ground truth.
    """
    truth = motion_array("gt", gt, representation)
    drawn = sample_array("samples", samples, representation)
    flat = truth.shape if truth.ndim == 3 else (1, *truth.shape)
    if drawn.shape[1:] != flat:
        wanted = ", ".join(map(str, ("S", *flat)))
        raise ValueError(f"samples: expected ({wanted}), S predictions of each sequence of gt, got {drawn.shape}")
    check_finite("gt", truth)
    return truth.reshape(flat), drawn


def sample_array(name: str, samples: npt.ArrayLike, representation: str | None = None) -> Array:
    """Read samples ``(S, N, T, D)``, flattened joint by joint; ``(S, T, D)`` is a single sequence."""
    array: Array = real_array(name, samples)
    if array.ndim < 3 or not len(array):
        raise ValueError(f"{name}: expected at least one sample, (S, N, T, D) or (S, T, D), got shape {array.shape}")
    flat = motion_shape(name, array.shape[1:], representation)
    check_finite(name, array)
    return array.reshape(len(array), *(flat if len(flat) == 3 else (1, *flat)))


def of_sequence(samples: Array, i: int) -> Float64:
    """Return the samples of one sequence, ``(S, T, D)``."""
    return samples[:, i].astype("f8")
