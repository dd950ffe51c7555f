"""Power and sample size of a study."""

from __future__ import annotations

import math
from bisect import bisect_left
from statistics import NormalDist

from npss.study._input import ALTERNATIVES, Alternative, fraction
from npss.validation import one_of, positive_integer

_Z = NormalDist()
_MOST = 2**40


def power(
    p_a: float,
    p_b: float,
    n_a: int,
    n_b: int | None = None,
    *,
    alternative: Alternative = "greater",
    alpha: float = 0.05,
    correction: bool = True,
) -> float:
    """Return the power of `binomial_test`: the probability that it finds a true difference.

    This is the usual normal approximation: pooled variance under the null hypothesis, separate variances under the
    alternative.

    Parameters
    ----------
    p_a, p_b : float
        The true proportions, between 0 and 1.
    n_a : int
        Trials of the first sample.
    n_b : int, optional
        Trials of the second sample (default: `n_a`).
    alternative : {'greater', 'less', 'two-sided'}, optional
        As for `binomial_test`.
    alpha : float, optional
        Significance level.
    correction : bool, optional
        As for `binomial_test`.

    Returns
    -------
    float
        The probability of a p-value of `alpha` or less.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.

    References
    ----------
    J. L. Fleiss, B. Levin and M. C. Paik, "Statistical Methods for Rates and Proportions", 3rd edition, chapter 4.

    Examples
    --------
    >>> from npss import study
    >>> round(study.power(0.8, 0.65, 80), 3)
    0.621
    """
    size_a = positive_integer("n_a", n_a)
    size_b = size_a if n_b is None else positive_integer("n_b", n_b)
    return _power(*_checked(p_a, p_b, alternative, alpha, correction), size_a, size_b)


def sample_size(
    p_a: float,
    p_b: float,
    *,
    power: float = 0.8,
    alternative: Alternative = "greater",
    alpha: float = 0.05,
    correction: bool = True,
) -> int:
    """Return the number of trials per sample that gives `binomial_test` a power.

    Parameters
    ----------
    p_a, p_b : float
        The true proportions, between 0 and 1.
    power : float, optional
        The probability of finding the difference.
    alternative : {'greater', 'less', 'two-sided'}, optional
        As for `binomial_test`.
    alpha : float, optional
        Significance level.
    correction : bool, optional
        As for `binomial_test`.

    Returns
    -------
    int
        Trials of each of two equal samples: the fewest whose power is at least `power`.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described, or the proportions do not differ in the direction of the alternative.

    References
    ----------
    As `power`.

    Examples
    --------
    >>> from npss import study
    >>> study.sample_size(0.8, 0.65)
    122
    """
    values = _checked(p_a, p_b, alternative, alpha, correction)
    target = fraction("power", power)
    if p_a == p_b or (alternative != "two-sided" and (p_a > p_b) != (alternative == "greater")):
        wanted = {"greater": "more than", "less": "less than", "two-sided": "another share than"}[alternative]
        remedy = "" if p_a == p_b else f"; swap the two, or choose the alternative {'two-sided'!r}"
        raise ValueError(
            f"p_a: expected {wanted} the other share, {p_b}, for the alternative {alternative!r}, got {p_a}{remedy}"
        )
    most = 1
    while _power(*values, most, most) < target:
        most *= 2
        if most > _MOST:
            raise ValueError(f"p_a: {p_a} is too close to p_b = {p_b}: it would take more than {_MOST} trials")
    return 1 + bisect_left(range(1, most + 1), target, key=lambda n: _power(*values, n, n))


def _checked(
    p_a: float, p_b: float, alternative: Alternative, alpha: float, correction: bool
) -> tuple[float, float, Alternative, float, bool]:
    one_of("alternative", alternative, ALTERNATIVES)
    if not isinstance(correction, bool):
        raise TypeError(f"correction: expected True or False, got {correction!r}")
    return fraction("p_a", p_a), fraction("p_b", p_b), alternative, fraction("alpha", alpha), correction


def _power(
    p_a: float, p_b: float, alternative: Alternative, alpha: float, correction: bool, n_a: int, n_b: int
) -> float:
    pooled = (n_a * p_a + n_b * p_b) / (n_a + n_b)
    per_trial = 1 / n_a + 1 / n_b
    under_null = math.sqrt(pooled * (1 - pooled) * per_trial)
    under_alternative = math.sqrt(p_a * (1 - p_a) / n_a + p_b * (1 - p_b) / n_b)
    tail = alpha / 2 if alternative == "two-sided" else alpha
    needed = -_Z.inv_cdf(tail) * under_null + (per_trial / 2 if correction else 0.0)
    difference = p_a - p_b
    greater = _Z.cdf((difference - needed) / under_alternative)
    less = _Z.cdf((-difference - needed) / under_alternative)
    return {"greater": greater, "less": less, "two-sided": greater + less}[alternative]
