"""The entropy of power spectra, and their divergence from those of the ground truth (Ruiz et al., ICCV 2019)."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.euler_error import MOVES, moving_in_set, pair_blocks
from npss._metric.power import PowerSpectrum, padded
from npss.validation import (
    Array,
    BeyondFloat64Error,
    Float64,
    check_finite,
    motion_array,
    motion_pair,
    one_of,
    positive_number,
)

#: One spectrum for the set, the sum of the power of all sequences; or one for each sequence.
Spectra = Literal["set", "sequence"]
#: Which spectrum is the reference.
Direction = Literal["gt-pred", "pred-gt"]
#: Which features count.
Features = Literal["all", "set"]
#: Added to every power, so that the logarithm of a share is finite.
EPSILON = 1e-8


def spectrum_entropy(
    motion: npt.ArrayLike, *, spectra: Spectra = "set", features: Features = "all", epsilon: float = EPSILON
) -> float:
    """Return the entropy of the power spectra of a motion: 0 for one frequency, log T for noise.

    The power of a feature at its T frequencies, ``abs(F)**2``, is divided by its sum. The entropy of these shares, in
    nats, is averaged over features.

    Parameters
    ----------
    motion : (N, T, D) or (T, D) array_like
        N sequences of T frames of D features. Published tables use positions or Euler angles, second by second.
    spectra : {'set', 'sequence'}, optional
        Add up the power of all sequences first, as released code does, so that the entropy is that of the set; or
        average the entropies of single sequences.
    features : {'all', 'set'}, optional
        All features, or those that move in the set (standard deviation over all frames > 1e-4). A feature that is
        always zero has the entropy log T.
    epsilon : float, optional
        Added to the power at every frequency.

    Returns
    -------
    float
        In nats. Neither more nor less is better: that of the ground truth is right.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, a value is not finite, or no feature moves.

    See Also
    --------
    spectrum_divergence : compares the spectra themselves.

    Notes
    -----
    Sign it with ``npss.signature(None, metric="spectrum_entropy", frames=T, extra={"spectra": ..., "features": ...,
    "epsilon": ...})``. The maximum, log T, depends on T: compare equal lengths only.

    References
    ----------
    A. Hernandez Ruiz, J. Gall, F. Moreno-Noguer, "Human Motion Prediction via Spatio-Temporal Inpainting", ICCV 2019.
    The set's spectra and the epsilon: E. Aksan, M. Kaufmann, P. Cao, O. Hilliges, "A Spatio-temporal Transformer for 3D
    Human Motion Prediction", 3DV 2021, released code.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> t = np.arange(100)[:, np.newaxis]
    >>> round(npss.spectrum_entropy(np.cos(2 * np.pi * t / 20)), 4)  # two bins of equal power, of a tone and its twin
    0.6931
    """
    array = motion_array("motion", motion)
    check_finite("motion", array)
    shares = _shares("motion", array, spectra, _counting("motion", array, features), epsilon)
    return float(-(shares * np.log(shares)).sum(axis=0).mean())


def spectrum_divergence(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    direction: Direction = "gt-pred",
    spectra: Spectra = "set",
    features: Features = "all",
    epsilon: float = EPSILON,
) -> float:
    """Return the Kullback-Leibler divergence of power spectra.

    The power of a feature at its T frequencies, ``abs(F)**2``, is divided by its sum, and the divergence of these
    shares, in nats, is averaged over features.

    Parameters
    ----------
    gt, pred : (N, T, D) or (T, D) array_like
        Ground truth and prediction. For ``spectra="set"``, N may differ: published tables compare predictions with
        the training set, too.
    direction : {'gt-pred', 'pred-gt'}, optional
        KL(gt || pred), or KL(pred || gt); tables print both.
    spectra : {'set', 'sequence'}, optional
        Add up the power of all sequences first, as released code does; or average the divergences of pairs of
        sequences.
    features : {'all', 'set'}, optional
        All features, or those that move in the ground truth (standard deviation over all frames > 1e-4).
    epsilon : float, optional
        Added to the power at every frequency.

    Returns
    -------
    float
        In nats, at least 0.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, the shapes differ, a value is not finite, or no feature moves.

    Notes
    -----
    Sign it with ``npss.signature(None, metric="spectrum_divergence", frames=T, extra={"direction": ..., "spectra": ...,
    "features": ..., "epsilon": ...})``.

    References
    ----------
    As for `spectrum_entropy`.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt = np.random.default_rng(0).normal(size=(8, 25, 3))
    >>> npss.spectrum_divergence(gt, gt[:, ::-1])  # ignores the direction of time
    0.0
    """
    one_of("direction", direction, get_args(Direction))
    if spectra == "set":
        truth, prediction = motion_array("gt", gt), motion_array("pred", pred)
        if truth.shape[-2:] != prediction.shape[-2:]:
            sizes = f"its frames and features {prediction.shape[-2:]} differ from those of gt, {truth.shape[-2:]}"
            raise ValueError(f"pred: {sizes}")
    else:
        truth, prediction = motion_pair(gt, pred)
    check_finite("gt", truth)
    check_finite("pred", prediction)
    counting = _counting("gt", truth, features)
    p, q = (_shares(name, x, spectra, counting, epsilon) for name, x in (("gt", truth), ("pred", prediction)))
    if direction == "pred-gt":
        p, q = q, p
    # p log(p / q) - p + q is the same sum, but each term is at least 0, whatever the rounding.
    terms = p * np.log(p / q) - p + q
    return max(0.0, float(terms.sum(axis=0).mean()))


def _counting(name: str, motion: Array, features: str) -> npt.NDArray[np.bool_]:
    """Return which features count, ``(D,)``."""
    one_of("features", features, get_args(Features))
    if features == "all":
        return np.ones(motion.shape[-1], bool)
    moves = moving_in_set(motion)
    if not moves.any():
        raise ValueError(f"{name}: no feature moves (standard deviation over all frames > {MOVES:g})")
    return moves


def _shares(name: str, motion: Array, spectra: str, counting: npt.NDArray[np.bool_], epsilon: float) -> Float64:
    """Return the shares of power, ``(T, D)`` for the set, ``(T, N * D)`` for sequences; only of features that count."""
    one_of("spectra", spectra, get_args(Spectra))
    floor = positive_number("epsilon", epsilon)
    n_frames = motion.shape[-2]
    transform = PowerSpectrum(n_frames, "magnitude", twins=False)
    parts = []
    for _, block, _ in pair_blocks(motion, motion):
        moving = block[:, :, counting]
        n, _, d = moving.shape
        width = padded(n * d)
        power = np.empty((transform.n_bins, width))
        with np.errstate(all="ignore"):
            transform(moving, power, np.empty((transform.n_scratch, width)))
            bins = power[:, : n * d]
            parts.append(bins.reshape(-1, n, d).sum(axis=1) if spectra == "set" else bins)
    one_sided = np.sum(parts, axis=0) if spectra == "set" else np.concatenate(parts, axis=1)
    with np.errstate(all="ignore"):
        two_sided = np.concatenate([one_sided, one_sided[1 : (n_frames + 1) // 2][::-1]]) + floor
        shares: Float64 = two_sided / two_sided.sum(axis=0)
    if not np.isfinite(shares).all() or not shares.all():
        raise BeyondFloat64Error(name, "its power is out of the range of float64")
    return shares
