"""The distances of stochastic prediction: of the best sample, between samples, and of similar futures."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from npss.stochastic._samples import of_sequence, read_samples, sample_array
from npss.validation import Array, BeyondFloat64Error, Float64, check_finite, positive_number, real_array

_VALUES = 2**22  # of one block of differences


def ade(gt: npt.ArrayLike, samples: npt.ArrayLike) -> float:
    """Return the average displacement error of the best sample of each sequence.

    The distance of two poses is the Euclidean norm of the difference of all their coordinates. It is averaged over
    frames, the smallest of the samples counts, and the mean is over sequences.

    Parameters
    ----------
    gt : (N, T, D), (T, D) or (N, T, J, 3) array_like
        Ground truth, usually positions in metres without the root.
    samples : (S,) + gt.shape array_like
        S predictions of each sequence.

    Returns
    -------
    float
        In the unit of the motion.

    Raises
    ------
    TypeError
        If an argument does not hold real numbers.
    ValueError
        If a shape is wrong, or a value is not finite.

    Notes
    -----
    It never grows with more samples, so state S: ``npss.signature(None, metric="ade", frames=T, draws=S)``.

    References
    ----------
    Y. Yuan, K. Kitani, "DLow: Diversifying Latent Flows for Diverse Human Motion Prediction", ECCV 2020, section 5.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.stochastic import ade
    >>> gt = np.zeros((1, 2, 3))
    >>> samples = np.stack([gt + [3, 4, 0], gt + [0, 0, 2]])
    >>> ade(gt, samples)
    2.0
    """
    return _mean_of_best(gt, samples, lambda distances: distances.mean(axis=-1))


def fde(gt: npt.ArrayLike, samples: npt.ArrayLike) -> float:
    """Return the final displacement error: `ade` of the last frame alone, whose best sample may be another.

    Parameters
    ----------
    gt, samples : array_like
        As for `ade`.

    Returns
    -------
    float
        In the unit of the motion.

    Raises
    ------
    TypeError, ValueError
        As for `ade`.

    References
    ----------
    As for `ade`.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.stochastic import fde
    >>> gt = np.zeros((1, 2, 3))
    >>> samples = gt + np.array([[[5, 0, 0], [1, 0, 0]], [[0, 0, 0], [2, 0, 0]]])[:, np.newaxis]
    >>> fde(gt, samples)
    1.0
    """
    return _mean_of_best(gt, samples, lambda distances: distances[..., -1])


def apd(samples: npt.ArrayLike) -> float:
    """Return the average pairwise distance of the samples of a sequence: their diversity.

    The distance of two samples is the Euclidean norm of the difference of all their coordinates in all frames. The mean
    is over pairs and sequences. More is not better by itself: noise is diverse, too.

    Parameters
    ----------
    samples : (S, N, T, D), (S, T, D) or (S, N, T, J, 3) array_like
        S >= 2 predictions of each sequence.

    Returns
    -------
    float
        In the unit of the motion; it grows with the square root of T.

    Raises
    ------
    TypeError, ValueError
        As for `ade`; also if there are fewer than two samples, which have no distance.

    References
    ----------
    As for `ade`.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.stochastic import apd
    >>> apd(np.stack([np.zeros((1, 4, 1)), np.ones((1, 4, 1))]))
    2.0
    """
    drawn = sample_array("samples", samples)
    n_samples, n_sequences = drawn.shape[:2]
    if n_samples < 2:
        raise ValueError(f"samples: expected at least two, which have a distance, got shape {drawn.shape}")
    total = 0.0
    with np.errstate(over="ignore"):
        for i in range(n_sequences):
            flat = of_sequence(drawn, i).reshape(n_samples, -1)
            pairs = sum(_norms(flat[k + 1 :] - flat[k]).sum() for k in range(n_samples - 1))
            total += float(pairs) / (n_samples * (n_samples - 1) / 2)
    return _in_range(total / n_sequences)


def mmade(gt: npt.ArrayLike, samples: npt.ArrayLike, contexts: npt.ArrayLike, *, threshold: float) -> float:
    """Return the multi-modal average displacement error: `ade` to the futures of all similar contexts.

    The futures of a sequence are the ground truths of all sequences whose context is nearer than a threshold, its own
    included. For each future the best sample counts; the mean is over the futures of a sequence, then over sequences.

    Parameters
    ----------
    gt, samples : array_like
        As for `ade`.
    contexts : (N, D) or (N, J, 3) array_like
        The last observed pose of each sequence.
    threshold : float
        The Euclidean distance of two contexts below which they are similar: usually 0.5 for Human3.6M and 0.1 for
        HumanEva-I, in metres.

    Returns
    -------
    float
        In the unit of the motion.

    Raises
    ------
    TypeError, ValueError
        As for `ade`; also if there is not a context for each sequence, or the threshold is not positive.

    Notes
    -----
    The similar sequences are those of `gt`, so it depends on the whole set. State the threshold:
    ``npss.signature(None, metric="mmade", frames=T, draws=S, extra={"threshold": 0.5})``.

    References
    ----------
    As for `ade`.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.stochastic import mmade
    >>> gt = np.array([[[0.0]], [[4.0]]])  # two sequences that begin alike
    >>> samples = np.array([[[[0.0]], [[0.0]]], [[[3.0]], [[3.0]]]])
    >>> mmade(gt, samples, [[0.0], [0.1]], threshold=0.5)  # to 0: 0, to 4: 1
    0.5
    """
    return _multimodal(gt, samples, contexts, threshold, lambda distances: distances.mean(axis=-1))


def mmfde(gt: npt.ArrayLike, samples: npt.ArrayLike, contexts: npt.ArrayLike, *, threshold: float) -> float:
    """Return the multi-modal final displacement error: `mmade` of the last frame alone.

    Parameters
    ----------
    gt, samples, contexts, threshold
        As for `mmade`.

    Returns
    -------
    float
        In the unit of the motion.

    Raises
    ------
    TypeError, ValueError
        As for `mmade`.

    References
    ----------
    As for `ade`.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.stochastic import mmfde
    >>> gt = np.array([[[9.0], [0.0]], [[9.0], [4.0]]])
    >>> samples = np.zeros((1, 2, 2, 1))
    >>> mmfde(gt, samples, [[0.0], [0.1]], threshold=0.5)
    2.0
    """
    return _multimodal(gt, samples, contexts, threshold, lambda distances: distances[..., -1])


#: Reduces the distances of frames ``(..., T)`` to one.
_OverFrames = Callable[[Float64], Float64]


def _mean_of_best(gt: npt.ArrayLike, samples: npt.ArrayLike, over_frames: _OverFrames) -> float:
    truth, drawn = read_samples(gt, samples)
    with np.errstate(over="ignore"):
        best = [_best(of_sequence(drawn, i), truth[i : i + 1], over_frames)[0] for i in range(len(truth))]
    return _in_range(float(np.mean(best)))


def _multimodal(
    gt: npt.ArrayLike, samples: npt.ArrayLike, contexts: npt.ArrayLike, threshold: float, over_frames: _OverFrames
) -> float:
    truth, drawn = read_samples(gt, samples)
    observed: Array = real_array("contexts", contexts)
    if observed.ndim < 2 or len(observed) != len(truth) or not observed.size:
        raise ValueError(
            f"contexts: expected a pose for each of {len(truth)} sequences, (N, D) or (N, J, 3), got {observed.shape}"
        )
    check_finite("contexts", observed)
    limit = positive_number("threshold", threshold)
    poses = observed.reshape(len(observed), -1).astype(np.float64)
    means = []
    with np.errstate(over="ignore"):
        for i in range(len(truth)):
            similar = np.flatnonzero(_norms(poses - poses[i]) < limit)
            means.append(_best(of_sequence(drawn, i), truth[similar], over_frames).mean())
    return _in_range(float(np.mean(means)))


def _best(samples: Float64, futures: Array, over_frames: _OverFrames) -> Float64:
    """Return the distance of the best of the samples ``(S, T, D)`` to each of the futures ``(M, T, D)``."""
    at_once = max(1, _VALUES // samples.size)
    best = []
    for top in range(0, len(futures), at_once):
        differences = samples - futures[top : top + at_once, np.newaxis]
        best.append(over_frames(_norms(differences)).min(axis=1))
    return np.concatenate(best)


def _norms(differences: Float64) -> Float64:
    """Return Euclidean norms over the last axis."""
    norms: Float64 = np.sqrt(np.einsum("...d,...d->...", differences, differences))
    return norms


def _in_range(value: float) -> float:
    if not np.isfinite(value):
        raise BeyondFloat64Error("samples", "their distance is beyond float64")
    return value
