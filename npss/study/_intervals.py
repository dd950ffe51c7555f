"""Confidence intervals of a proportion, and of the difference of two."""

from __future__ import annotations

import math
from statistics import NormalDist

from npss._analysis.interval import Interval
from npss.study._input import count_of, fraction, scipy_stats


def wilson_interval(successes: int, n: int, *, level: float = 0.95) -> Interval:
    """Return Wilson's score interval of a proportion, without continuity correction.

    On average over proportions, its coverage is the level; for a single proportion it is slightly higher or lower.

    Parameters
    ----------
    successes : int
        Successes, 0 to `n`.
    n : int
        Trials.
    level : float, optional
        Confidence level.

    Returns
    -------
    Interval
        ``(low, high)``, within 0 and 1.

    Raises
    ------
    TypeError, ValueError
        If the counts are invalid, or the level is not between 0 and 1.

    References
    ----------
    E. B. Wilson, "Probable Inference, the Law of Succession, and Statistical Inference", JASA 22, 1927.

    Examples
    --------
    >>> from npss import study
    >>> low, high = study.wilson_interval(65, 80)
    >>> round(low, 4), round(high, 4)
    (0.7134, 0.8829)
    """
    return wilson_of_sum(*count_of("successes", successes, "n", n), level=level)


def wilson_of_sum(k: float, n: int, *, level: float) -> Interval:
    """Return Wilson's interval of the mean of `n` values between 0 and 1 with the sum `k`.

    Their variance is at most that of successes and failures with the same mean, so it covers at least as much.
    """
    z = normal_quantile(level)
    centre, half = (k + z * z / 2) / (n + z * z), z / (n + z * z) * math.sqrt(k * (n - k) / n + z * z / 4)
    # At the ends the exact value is known; rounding must not change it.
    return Interval(0.0 if k == 0 else centre - half, 1.0 if k == n else centre + half)


def clopper_pearson_interval(successes: int, n: int, *, level: float = 0.95) -> Interval:
    """Return Clopper and Pearson's exact interval of a proportion, which covers at least the level. Needs scipy.

    Parameters
    ----------
    successes : int
        Successes, 0 to `n`.
    n : int
        Trials.
    level : float, optional
        Confidence level.

    Returns
    -------
    Interval
        ``(low, high)``, within 0 and 1.

    Raises
    ------
    TypeError, ValueError
        If the counts are invalid, or the level is not between 0 and 1.
    ImportError
        If scipy is not installed.

    References
    ----------
    C. J. Clopper and E. S. Pearson, "The Use of Confidence or Fiducial Limits", Biometrika 26, 1934.

    Examples
    --------
    >>> from npss import study
    >>> low, high = study.clopper_pearson_interval(65, 80)
    >>> round(low, 4), round(high, 4)
    (0.7097, 0.8911)
    """
    k, n = count_of("successes", successes, "n", n)
    tail = (1 - fraction("level", level)) / 2
    beta = scipy_stats("clopper_pearson_interval").beta
    low = 0.0 if k == 0 else float(beta.ppf(tail, k, n - k + 1))
    high = 1.0 if k == n else float(beta.isf(tail, k + 1, n - k))
    return Interval(low, high)


def newcombe_interval(a: int, n_a: int, b: int, n_b: int, level: float) -> Interval:
    """Return Newcombe's interval of ``a / n_a - b / n_b`` from Wilson's two (method 10); counts must be checked."""
    p, q = a / n_a, b / n_b
    of_a, of_b = wilson_interval(a, n_a, level=level), wilson_interval(b, n_b, level=level)
    return Interval(
        p - q - math.hypot(p - of_a.low, of_b.high - q),
        p - q + math.hypot(of_a.high - p, q - of_b.low),
    )


def normal_quantile(level: float) -> float:
    """Return the number of standard deviations within which a normal distribution has probability `level`."""
    return -NormalDist().inv_cdf((1 - fraction("level", level)) / 2)
