"""Compare a set of sampled motion with a set of real motion: NPSS to the nearest, precision and recall."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64, positive_integer
from npss_baselines.manifold.applications.retrieval import distances_between
from npss_baselines.manifold.motion.features import VELOCITIES
from npss_baselines.manifold.motion.scaling import Scaling

#: Motions beside a motion that decide how large its neighbourhood is, as in the paper of precision and recall.
NEIGHBOURS = 3


def nearest_npss(real: npt.ArrayLike, sampled: npt.ArrayLike) -> Float64:
    """Compute the NPSS of each sampled motion to the real motion that it resembles most.

    The least NPSS of the sampled motion, as the prediction, over all real motions, each as the ground truth: convention
    ``paper``, one sequence, whose features are coordinates.

    Parameters
    ----------
    real : (N, T, D) array_like
        Coordinates of real motions.
    sampled : (n, T, D) array_like
        Coordinates of sampled motions.

    Returns
    -------
    (n,) ndarray of float64
        0 for a copy. Real motions that were left out show what is small.

    Raises
    ------
    ValueError
        If the shapes do not fit, or a real motion does not move and is everywhere zero.

    Examples
    --------
    >>> time = np.arange(8)[:, np.newaxis]
    >>> slow, fast = np.cos(np.pi * time / 4), np.cos(np.pi * time / 2)
    >>> nearest_npss([slow, fast], [fast, slow]).round(12) + 0
    array([0., 0.])
    """
    gt, pred = np.asarray(real, np.float64), np.asarray(sampled, np.float64)
    if gt.ndim != 3 or pred.ndim != 3 or gt.shape[1:] != pred.shape[1:] or 0 in gt.shape:
        raise ValueError(f"sampled: expected shape (n, T, D) with T and D of real, {gt.shape}, got {pred.shape}")
    (power, true), (_, drawn) = _spectra(gt), _spectra(pred)
    total = power.sum(axis=1, keepdims=True)
    if not total.all():
        raise ValueError(f"real: the motion at index {int(total.argmin())} has no power, so no NPSS")
    weight = power / total  # of features
    distance = [np.einsum("nd,nd->n", weight, np.abs(true - spectrum).sum(axis=1)).min() for spectrum in drawn]
    return np.array(distance)


def precision_and_recall(real: npt.ArrayLike, sampled: npt.ArrayLike, *, k: int = NEIGHBOURS) -> tuple[float, float]:
    """Compute the precision and recall of a set of samples.

    Around each vector of a set lies a ball that reaches to its k-th nearest vector of the same set. Precision is the
    share of sampled vectors in a ball of the real set, recall the share of real vectors in a ball of the sampled set.

    Parameters
    ----------
    real, sampled : (N, D), (n, D) array_like
        Vectors of real and of sampled motion, such as `descriptors`; more than k of each. Compare sets of equal size.
    k : int, optional
        The neighbour that decides the size of a ball.

    Returns
    -------
    (float, float)
        Precision and recall, from 0 to 1. Two random halves of one set have less than 1.

    Raises
    ------
    TypeError, ValueError
        If k is not a positive integer, or a set has too few vectors.

    References
    ----------
    T. Kynkäänniemi, T. Karras, S. Laine, J. Lehtinen and T. Aila, "Improved Precision and Recall Metric for Assessing
    Generative Models", NeurIPS 2019, with k = 3.

    Examples
    --------
    Samples of one of two kinds of motion are precise, but half of the real motion is missing:

    >>> kinds = np.array([[0.0], [1.0], [2.0], [50.0], [51.0], [52.0]])
    >>> precision_and_recall(kinds, kinds[:3] + 0.1, k=1)
    (1.0, 0.5)
    """
    sets = [np.asarray(values, np.float64) for values in (real, sampled)]
    positive_integer("k", k)
    for name, values in zip(("real", "sampled"), sets, strict=True):
        if values.ndim != 2 or len(values) <= k:
            raise ValueError(f"{name}: expected shape (n, D) with more than {k} vectors, got {values.shape}")
    radii = [np.sort(distances_between(values, values), axis=1)[:, k] for values in sets]  # the first is its own
    across = distances_between(*sets)
    return float((across <= radii[0][:, np.newaxis]).any(axis=0).mean()), float((across <= radii[1]).any(axis=1).mean())


def descriptors(features: npt.ArrayLike, scaling: Scaling) -> Float64:
    """Describe motions by the mean, the deviation and the deviation of the change of each coordinate over time.

    Like the motions that they describe, these do not say when something happens.

    Parameters
    ----------
    features : (n, T, 3 J + 3) array_like
        Motions.
    scaling : Scaling
        The scaling of coordinates.

    Returns
    -------
    (n, 3 * 3 J) ndarray of float64
        The descriptors, for `precision_and_recall`.
    """
    scaled: Array = scaling.normalize(features)[..., :-VELOCITIES]
    return np.concatenate([scaled.mean(axis=1), scaled.std(axis=1), np.diff(scaled, axis=1).std(axis=1)], axis=1)


def _spectra(motions: Float64) -> tuple[Float64, Float64]:
    """Return the power ``(n, D)`` of each coordinate, and its normalised, summed up spectrum ``(n, T, D)``."""
    power = np.abs(np.fft.fft(motions, axis=1)) ** 2
    total = power.sum(axis=1)
    share = np.divide(power, total[:, np.newaxis], out=np.zeros_like(power), where=total[:, np.newaxis] > 0)
    return total, np.cumsum(share, axis=1)
