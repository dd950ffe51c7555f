"""Fingerprints of ground truths: a few numbers of each sequence, by which copies of it are told from anything else."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64

#: How many projections a fingerprint has, beside the norm.
PROJECTIONS = 8
#: How far two copies of a sequence may be apart, in units of its norm: float32 rounds each value to 6e-8 of itself.
TOLERANCE = 1e-5
_OLD_TOLERANCE = 1e-3  # of the mean absolute values of statistics version 1


def fingerprint(gt: Array) -> Float64:
    """Return the norm of every sequence, and its projections over time and features: ``(N, 1 + PROJECTIONS)``.

    Projection k is the sum over frames t and features d, both counted from 1, of ``cos(t (t + k)) cos(d (d + k + 8))``
    times the value. The multiples are whole numbers, of which no two cosines are equal; so each frame and each feature
    has coefficients of its own, and motion that is smooth is not orthogonal to them.
    """
    sequences = gt if gt.ndim == 3 else gt[np.newaxis]
    frames, features = _coefficients(gt.shape[-2], 0), _coefficients(gt.shape[-1], PROJECTIONS)
    found = np.empty((len(sequences), 1 + PROJECTIONS))
    for numbers, sequence in zip(found, sequences, strict=True):
        values = sequence.astype(np.float64)
        with np.errstate(over="ignore", invalid="ignore"):  # the score says what is wrong with such values
            numbers[0] = np.linalg.norm(values)
            numbers[1:] = ((frames @ values) * features).sum(axis=1)
    return found


def _coefficients(length: int, first: int) -> Float64:
    """Return ``cos(n (n + k))`` for each k from `first` on and each n from 1 to `length`, ``(PROJECTIONS, length)``."""
    n = np.arange(1, length + 1)
    k = np.arange(first, first + PROJECTIONS)[:, np.newaxis]
    coefficients: Float64 = np.cos(n * (n + k))
    return coefficients


def differing(one: Float64, other: Float64) -> npt.NDArray[np.bool_]:
    """Return which sequences of two ground truths are no copies of each other, ``(N,)``, by their fingerprints.

    Those of statistics version 1 are mean absolute values, ``(N,)``; both are of the same version and of N sequences.
    """
    if one.ndim == 1:
        return ~np.isclose(one, other, rtol=_OLD_TOLERANCE, atol=0)
    apart: npt.NDArray[np.bool_] = np.abs(one - other).max(axis=1) > TOLERANCE * np.maximum(one[:, 0], other[:, 0])
    return apart
