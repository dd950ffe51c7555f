"""Reference implementations of the metrics, from their definitions and without npss."""

import cmath
import math

import numpy as np


def transform(series):
    """Return the discrete Fourier transform, as a sum."""
    n = len(series)
    return [sum(x * cmath.exp(-2j * cmath.pi * ((f * t) % n) / n) for t, x in enumerate(series)) for f in range(n)]


def npss(gt, pred, convention):
    """Return the NPSS of ``(N, T, D)`` arrays by a convention; None if the ground truth has no power."""
    return {"paper": _paper, "released": _released, "literal": _literal}[convention](gt, pred)


def _paper(gt, pred):
    numerator = denominator = 0.0
    for x, y in _columns(gt, pred):
        power_x = [abs(c) ** 2 for c in transform(x)]
        power_y = [abs(c) ** 2 for c in transform(y)]
        if sum(power_x) == 0:
            continue
        if sum(power_y) == 0:
            power_y[0] = 1.0
        emd = _l1(_cumulative(_normalised(power_x)), _cumulative(_normalised(power_y)))
        numerator += sum(power_x) * emd
        denominator += sum(power_x)
    return numerator / denominator if denominator else None


def _released(gt, pred):
    numerator = denominator = 0.0
    for x, y in _columns(gt, pred):
        power_x = [c.real**2 for c in transform(x)]
        power_y = [c.real**2 for c in transform(y)]
        if sum(power_x) == 0:
            continue
        cdf_y = _cumulative(_normalised(power_y)) if sum(power_y) > 0 else [0.0] * len(power_y)
        numerator += sum(power_x) * _l1(_cumulative(_normalised(power_x)), cdf_y)
        denominator += sum(power_x)
    return numerator / denominator if denominator else None


def _literal(gt, pred):
    distances = []
    for x, y in _columns(gt, pred):
        power_x = [abs(c) ** 2 for c in transform(x)]
        power_y = [abs(c) ** 2 for c in transform(y)]
        if sum(power_x) == 0:
            continue
        if sum(power_y) == 0:
            power_y[0] = 1.0
        distances.append(_l1(_normalised(power_x), _normalised(power_y)))
    return sum(distances) / len(distances) if distances else None


def euler_curve(gt, pred, columns="gt", threshold=1e-4):
    """Return the Euler error of every frame."""
    n, frames, features = gt.shape
    curve = []
    for t in range(frames):
        norms = []
        for i in range(n):
            chosen = {"gt": gt, "pred": pred, "all": None}[columns]
            counted = [d for d in range(features) if chosen is None or np.std(chosen[i, :, d]) > threshold]
            norms.append(math.sqrt(sum((gt[i, t, d] - pred[i, t, d]) ** 2 for d in counted)))
        curve.append(sum(norms) / n)
    return curve


def _columns(gt, pred):
    for i in range(gt.shape[0]):
        for d in range(gt.shape[2]):
            yield gt[i, :, d].tolist(), pred[i, :, d].tolist()


def _normalised(power):
    total = sum(power)
    return [p / total for p in power]


def _cumulative(values):
    sums, total = [], 0.0
    for value in values:
        total += value
        sums.append(total)
    return sums


def _l1(first, second):
    return sum(abs(a - b) for a, b in zip(first, second, strict=True))


def sigmoid(x):
    """Return the logistic function."""
    return 1 / (1 + np.exp(-x))
