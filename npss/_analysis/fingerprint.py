"""Fingerprints of ground truths: a few numbers per sequence that identify its copies."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64

#: The number of projections in a fingerprint, beside the norm.
PROJECTIONS = 8
#: The largest difference between copies of a sequence, in units of its norm: float32 rounds each value to 6e-8 of it.
TOLERANCE = 1e-5
_OLD_TOLERANCE = 1e-3  # for the mean absolute values of statistics version 1


def fingerprint(gt: Array) -> Float64:
    """Return the norm of each sequence, and its projections over time and features: ``(N, 1 + PROJECTIONS)``.

    Projection k is the sum over frames t and features d, both counted from 1, of ``cos(t (t + k)) cos(d (d + k + 8))``
    times the value. The arguments are whole numbers, and no two of them have equal cosines. So each frame and each
    feature has its own coefficients, and smooth motion is not orthogonal to them.
    """
    sequences = gt if gt.ndim == 3 else gt[np.newaxis]
    frames, features = _coefficients(gt.shape[-2], 0), _coefficients(gt.shape[-1], PROJECTIONS)
    fingerprints = np.empty((len(sequences), 1 + PROJECTIONS))
    for numbers, sequence in zip(fingerprints, sequences, strict=True):
        values = sequence.astype(np.float64)
        with np.errstate(over="ignore", invalid="ignore"):  # the score refuses such values
            numbers[0] = np.linalg.norm(values)
            numbers[1:] = ((frames @ values) * features).sum(axis=1)
    return fingerprints


def _coefficients(length: int, first: int) -> Float64:
    """Return ``cos(n (n + k))`` for each k from `first` on and each n from 1 to `length`, ``(PROJECTIONS, length)``."""
    n = np.arange(1, length + 1)
    k = np.arange(first, first + PROJECTIONS)[:, np.newaxis]
    coefficients: Float64 = np.cos(n * (n + k))
    return coefficients


def differing(one: Float64, other: Float64) -> npt.NDArray[np.bool_]:
    """Return which sequences of two ground truths differ, ``(N,)``, by their fingerprints.

    Both fingerprints are of the same version and of N sequences. In statistics version 1, they are mean absolute values
    ``(N,)``.
    """
    if one.ndim == 1:
        return ~np.isclose(one, other, rtol=_OLD_TOLERANCE, atol=0)
    apart: npt.NDArray[np.bool_] = np.abs(one - other).max(axis=1) > TOLERANCE * np.maximum(one[:, 0], other[:, 0])
    return apart
