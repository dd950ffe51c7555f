"""NPSS functions by the axes on which public ones differ, written from their descriptions and without npss."""

from itertools import product

import numpy as np

#: The choices of each axis.
AXES = {
    "power": ("real", "magnitude", "complex", "amplitude"),
    "bins": ("two-sided", "one-sided"),
    "distance": ("cdf", "spectrum"),
    "weight": ("gt", "pred", "uniform"),
    "aggregation": ("set", "sequence"),
    "factor": ("none", "/ N", "/ T", "* 10"),
    "mean": ("kept", "removed"),
    "axis": ("time", "features", "mixed"),
}
RELEASED = {axis: choices[0] for axis, choices in AXES.items()}
NAMED = {
    "released": RELEASED,
    "paper": {**RELEASED, "power": "magnitude"},
    "literal": {**RELEASED, "power": "magnitude", "distance": "spectrum", "weight": "uniform"},
}


def combinations(**fixed):
    """Yield all combinations with some choices fixed; those that are the same function once."""
    axes = {axis: (fixed[axis],) if axis in fixed else choices for axis, choices in AXES.items()}
    for values in product(*axes.values()):
        choices = dict(zip(axes, values, strict=True))
        if choices["weight"] == "uniform" and choices["aggregation"] == "sequence":
            continue  # a mean of means of as many features
        yield choices


def distances_and_totals(gt, pred, *, power, bins, distance, mean, axis, empty=None, epsilon=0.0, **_):
    """Return arrays ``(N, M)``: the distance of each column, and the total powers of both motions."""
    spectra = []
    for motion in (gt, pred):
        if axis == "features":
            motion = np.transpose(motion, (0, 2, 1))
        if mean == "removed":
            motion = motion - np.mean(motion, axis=1)[:, None, :]
        along = 2 if axis == "mixed" else 1
        bin_values = np.fft.rfft(motion, axis=along) if bins == "one-sided" else np.fft.fft(motion, axis=along)
        if power == "real":
            spectra.append(np.real(bin_values) ** 2)
        elif power == "magnitude":
            spectra.append(np.real(bin_values) ** 2 + np.imag(bin_values) ** 2)
        elif power == "complex":
            spectra.append(bin_values * bin_values)
        else:
            spectra.append(np.abs(bin_values))
    totals = [np.sum(spectrum, axis=1) for spectrum in spectra]
    shares = []
    for spectrum, total in zip(spectra, totals, strict=True):
        share = spectrum / (total + epsilon)[:, None, :]
        if empty is not None:
            share = np.where((total == 0)[:, None, :], 0.0, share)
            if empty == "dc":
                share[:, 0][total == 0] = 1.0
        shares.append(share)
    first, second = (np.cumsum(share, axis=1) for share in shares) if distance == "cdf" else shares
    return np.sum(np.abs(first - second), axis=1), *totals


def score(gt, pred, choices):
    """Return the score by a combination of choices."""
    distance, of_gt, of_pred = distances_and_totals(gt, pred, **choices)
    weight = {"gt": of_gt, "pred": of_pred, "uniform": np.ones(distance.shape)}[choices["weight"]]
    if choices.get("empty") and choices["weight"] == "uniform":
        weight = np.where(of_gt == 0, 0.0, weight)
    if choices["aggregation"] == "sequence":
        value = np.mean([np.sum(d * w) / np.sum(w) for d, w in zip(distance, weight, strict=True)])
    else:
        value = np.sum(distance * weight) / np.sum(weight)
    factor = {"none": 1, "/ N": 1 / gt.shape[0], "/ T": 1 / gt.shape[1], "* 10": 10}[choices["factor"]]
    return float(np.real(value) * factor)


def function_of(choices):
    """Return the function of a combination of choices."""

    def npss(gt, pred):
        return score(gt, pred, choices)

    return npss
