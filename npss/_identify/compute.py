"""Compute an NPSS by any combination of choices, plainly, on small arrays."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from npss._identify.choices import Choices
from npss.validation import Float64

#: Real or complex numbers.
Numbers = npt.NDArray[Any]

_POWERS: dict[str, Callable[[Numbers], Numbers]] = {
    "real": lambda bins: bins.real**2,
    "magnitude": lambda bins: np.abs(bins) ** 2,
    "complex": lambda bins: bins**2,
    "amplitude": np.abs,
}


class Spectra(NamedTuple):
    """The power spectra of the columns of a pair of motions, ``(N, M, L)`` each: M columns of L bins."""

    gt: Numbers
    pred: Numbers


class Columns(NamedTuple):
    """The distance of each column ``(N, M)``, and the total power of its ground truth and prediction."""

    distance: Float64
    gt: Numbers
    pred: Numbers


def transform(motion: Float64, frame: tuple[int, ...], choices: Choices) -> Numbers:
    """Return the Fourier coefficients of an ``(N, T, D)`` motion, ``(N, columns, bins)``."""
    if choices.mean == "removed-frames" or (choices.mean == "removed" and choices.axis == "time"):
        motion = motion - motion.mean(axis=1, keepdims=True)
    elif choices.mean == "removed":
        motion = motion - motion.mean(axis=2, keepdims=True)
    fourier = np.fft.fft if choices.bins == "two-sided" else np.fft.rfft
    if choices.axis == "time":
        return fourier(motion.swapaxes(1, 2), axis=-1)
    if choices.axis == "features":
        return fourier(motion, axis=-1)
    if choices.axis == "components":
        of_components = fourier(motion.reshape(*motion.shape[:2], -1, frame[-1]), axis=-1)
        return of_components.reshape(*motion.shape[:2], -1).swapaxes(1, 2)
    return fourier(motion, axis=-1).swapaxes(1, 2)


def spectra(gt: Float64, pred: Float64, frame: tuple[int, ...], choices: Choices) -> Spectra:
    """Return the power spectra."""
    power = _POWERS[choices.power]
    return Spectra(power(transform(gt, frame, choices)), power(transform(pred, frame, choices)))


def distances(first: Numbers, second: Numbers, distance: str) -> Float64:
    """Return the distances ``(N, M)`` of normalised spectra ``(N, M, L)``."""
    difference = second - first
    if distance == "cdf":
        difference = np.cumsum(difference, axis=-1)
    return np.asarray(np.abs(difference).sum(axis=-1))


def columns(powers: Spectra, choices: Choices) -> Columns:
    """Return distances and totals of columns that have power."""
    gt, pred = powers.gt.sum(axis=-1), powers.pred.sum(axis=-1)
    distance = distances(powers.gt / gt[..., np.newaxis], powers.pred / pred[..., np.newaxis], choices.distance)
    return Columns(distance, gt, pred)


def weights(of: Columns, choices: Choices) -> Numbers:
    """Return the weights of columns, ``(N, M)``."""
    if choices.weight == "uniform":
        return np.ones_like(of.distance)
    total = of.gt if choices.weight.startswith("gt") else of.pred
    return np.abs(total) if choices.weight.endswith("modulus") else total


def score_of_sequences(distance: Float64, weight: Numbers, plus: float = 0.0) -> Float64:
    """Return the score of each sequence; `plus` is added to the sum of weights."""
    return np.asarray(((weight * distance).sum(axis=1) / (weight.sum(axis=1) + plus)).real)


def score_of_set(distance: Float64, weight: Numbers, aggregation: str, plus: float = 0.0) -> float:
    """Return the score of a set; `plus` is added to the sum of weights."""
    if aggregation == "sequence":
        return float(score_of_sequences(distance, weight, plus).mean())
    if aggregation == "feature":
        return float(score_of_sequences(distance.T, weight.T, plus).mean())
    return float(((weight * distance).sum() / (weight.sum() + plus)).real)


def size_of(shape: tuple[int, ...]) -> tuple[int, int, int, int]:
    """Return N, T, D and the number of one-sided bins of an ``(N, T, D)`` motion."""
    n, t, d = shape
    return n, t, d, t // 2 + 1


def features(frame: tuple[int, ...]) -> int:
    """Return the number of features of a frame."""
    return math.prod(frame)
