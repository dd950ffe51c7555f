"""Tests of two proportions from independent samples: the NPSS paper's, and two exact ones."""

from __future__ import annotations

import math
from dataclasses import dataclass

from npss._analysis.interval import Interval
from npss.study._input import ALTERNATIVES, Alternative, count_of, fraction, scipy_stats
from npss.study._intervals import newcombe_interval, wilson_interval
from npss.validation import one_of


@dataclass(frozen=True, kw_only=True)
class ProportionTest:
    """The result of a test of two proportions from independent samples.

    Attributes
    ----------
    method : str
        The name of the test.
    alternative : {'greater', 'less', 'two-sided'}
        The alternative to equal proportions: a's is greater than b's, less, or either.
    statistic : float
        The test statistic. Of the z test: z, positive if a's proportion is greater; of Fisher's: the odds ratio; of
        Boschloo's: Fisher's p-value.
    p_value : float
        The p-value.
    proportion_a, proportion_b, difference : float
        The two proportions, and the first minus the second.
    interval_a, interval_b : Interval
        Wilson's intervals of the proportions.
    interval_difference : Interval
        Newcombe's interval of the difference.
    level : float
        Confidence level of the three intervals. They are two-sided under any alternative.

    Examples
    --------
    >>> from npss import study
    >>> test = study.binomial_test(65, 80, 39, 80)
    >>> test.method
    "two-proportion z test, pooled variance, Yates' correction"
    >>> test.proportion_a, test.difference
    (0.8125, 0.325)
    """

    method: str
    alternative: Alternative
    statistic: float
    p_value: float
    proportion_a: float
    proportion_b: float
    difference: float
    interval_a: Interval
    interval_b: Interval
    interval_difference: Interval
    level: float


def binomial_test(
    a: int,
    n_a: int,
    b: int,
    n_b: int,
    *,
    alternative: Alternative = "greater",
    correction: bool = True,
    level: float = 0.95,
) -> ProportionTest:
    """Test two proportions by the z test with pooled variance, as in the NPSS paper's user study.

    One-sided and corrected, the default, it gives the paper's p-value. The test assumes independent samples. Two
    metrics that answer the same questions do not give independent samples: use `mcnemar_test` for them.

    Parameters
    ----------
    a, n_a : int
        Successes and trials of the first sample.
    b, n_b : int
        Successes and trials of the second sample.
    alternative : {'greater', 'less', 'two-sided'}, optional
        Whether the first proportion is greater than the second, less, or either.
    correction : bool, optional
        Yates' continuity correction: move the difference towards zero by half of 1 / n_a + 1 / n_b, but not beyond
        zero (as R's ``prop.test``, under any alternative).
    level : float, optional
        Confidence level of the intervals, which are not corrected.

    Returns
    -------
    ProportionTest
        The result, with the z statistic. If all trials succeed, or none, there is no variance and no difference: the
        statistic is 0, and the p-value is 1 under any alternative, as in the exact tests.

    Raises
    ------
    TypeError, ValueError
        If the counts are invalid, or an option is not one of its values.

    See Also
    --------
    fisher_test, boschloo_test : exact tests of the same hypothesis.
    mcnemar_test : the test for paired answers.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019.
    R. G. Newcombe, "Interval Estimation for the Difference Between Independent Proportions", Statistics in Medicine
    17, 1998.

    Examples
    --------
    >>> from npss import study
    >>> f"{study.binomial_test(65, 80, 39, 80).p_value:.5g}"
    '1.7087e-05'
    """
    a, n_a, b, n_b = _counts(a, n_a, b, n_b)
    one_of("alternative", alternative, ALTERNATIVES)
    if not isinstance(correction, bool):
        raise TypeError(f"correction: expected True or False, got {correction!r}")
    method = "two-proportion z test, pooled variance, " + ("Yates' correction" if correction else "no correction")
    total, trials = a + b, n_a + n_b
    if total in (0, trials):
        return _result(method, alternative, 0.0, 1.0, a, n_a, b, n_b, level)
    per_trial = 1 / n_a + 1 / n_b
    difference = (a * n_b - b * n_a) / (n_a * n_b)  # whole numbers: equal proportions differ by 0 exactly
    shift = min(per_trial / 2, abs(difference)) if correction else 0.0
    error = math.sqrt(total * (trials - total) / trials**2 * per_trial)
    z = math.copysign(abs(difference) - shift, difference) / error
    # erfc, and not 1 - cdf, keeps its digits far out in the tail.
    if alternative == "two-sided":
        p = math.erfc(abs(z) / math.sqrt(2))
    else:
        p = math.erfc((z if alternative == "greater" else -z) / math.sqrt(2)) / 2
    return _result(method, alternative, z, p, a, n_a, b, n_b, level)


def fisher_test(
    a: int, n_a: int, b: int, n_b: int, *, alternative: Alternative = "greater", level: float = 0.95
) -> ProportionTest:
    """Test two proportions by Fisher's exact test: conditional on the total of successes, conservative. Needs scipy.

    Parameters
    ----------
    a, n_a : int
        Successes and trials of the first sample.
    b, n_b : int
        Successes and trials of the second sample.
    alternative : {'greater', 'less', 'two-sided'}, optional
        Whether the first proportion is greater than the second, less, or either.
    level : float, optional
        Confidence level of the intervals.

    Returns
    -------
    ProportionTest
        The result. Its statistic is the odds ratio of the sample, infinite or NaN if that divides by zero.

    Raises
    ------
    TypeError, ValueError
        If the counts are invalid, or an option is not one of its values.
    ImportError
        If scipy is not installed.

    See Also
    --------
    boschloo_test : also exact, and never less powerful.

    References
    ----------
    R. A. Fisher, "On the Interpretation of chi-squared from Contingency Tables", JRSS 85, 1922.

    Examples
    --------
    >>> from npss import study
    >>> f"{study.fisher_test(65, 80, 39, 80).p_value:.3g}"
    '1.36e-05'
    """
    a, n_a, b, n_b = _counts(a, n_a, b, n_b)
    one_of("alternative", alternative, ALTERNATIVES)
    stats = scipy_stats("fisher_test")
    ratio, p = stats.fisher_exact([[a, n_a - a], [b, n_b - b]], alternative=alternative)
    return _result("Fisher's exact test", alternative, float(ratio), float(p), a, n_a, b, n_b, level)


def boschloo_test(
    a: int, n_a: int, b: int, n_b: int, *, alternative: Alternative = "greater", level: float = 0.95
) -> ProportionTest:
    """Test two proportions by Boschloo's exact test: unconditional, never less powerful than Fisher's. Needs scipy.

    Parameters
    ----------
    a, n_a : int
        Successes and trials of the first sample.
    b, n_b : int
        Successes and trials of the second sample.
    alternative : {'greater', 'less', 'two-sided'}, optional
        Whether the first proportion is greater than the second, less, or either (twice the smaller one-sided
        p-value).
    level : float, optional
        Confidence level of the intervals.

    Returns
    -------
    ProportionTest
        The result. Its statistic is the p-value of Fisher's test. If all trials succeed, or none, both are 1.

    Raises
    ------
    TypeError, ValueError
        If the counts are invalid, or an option is not one of its values.
    ImportError
        If scipy is not installed.

    References
    ----------
    R. D. Boschloo, "Raised Conditional Level of Significance for the 2 x 2-Table", Statistica Neerlandica 24, 1970.

    Examples
    --------
    >>> from npss import study
    >>> f"{study.boschloo_test(65, 80, 39, 80).p_value:.2g}"
    '7.3e-06'
    """
    a, n_a, b, n_b = _counts(a, n_a, b, n_b)
    one_of("alternative", alternative, ALTERNATIVES)
    statistic = p = 1.0
    if a + b not in (0, n_a + n_b):
        result = scipy_stats("boschloo_test").boschloo_exact([[a, b], [n_a - a, n_b - b]], alternative=alternative)
        statistic, p = float(result.statistic), float(result.pvalue)
    return _result("Boschloo's exact test", alternative, statistic, p, a, n_a, b, n_b, level)


def _counts(a: int, n_a: int, b: int, n_b: int) -> tuple[int, int, int, int]:
    return (*count_of("a", a, "n_a", n_a), *count_of("b", b, "n_b", n_b))


def _result(
    method: str, alternative: Alternative, statistic: float, p: float, a: int, n_a: int, b: int, n_b: int, level: float
) -> ProportionTest:
    return ProportionTest(
        method=method,
        alternative=alternative,
        statistic=statistic,
        p_value=p,
        proportion_a=a / n_a,
        proportion_b=b / n_b,
        difference=(a * n_b - b * n_a) / (n_a * n_b),
        interval_a=wilson_interval(a, n_a, level=level),
        interval_b=wilson_interval(b, n_b, level=level),
        interval_difference=newcombe_interval(a, n_a, b, n_b, level),
        level=fraction("level", level),
    )
