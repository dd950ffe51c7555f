"""Confidence intervals of differences between methods, measured on the same blocks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from npss import Interval
from npss.validation import Float64, Seed, generator, is_real, positive_integer

RESAMPLES = 9999


def difference_interval(
    first: Sequence[npt.ArrayLike] | Float64,
    second: Sequence[npt.ArrayLike] | Float64,
    *,
    level: float = 0.95,
    resamples: int = RESAMPLES,
    seed: Seed,
) -> Interval:
    """Compute an interval of the difference of two averages over the same blocks, by the paired bootstrap.

    Both averages are quotients of sums over blocks. Blocks are drawn with replacement, the same for both, and the ends
    are percentiles of the difference.

    Parameters
    ----------
    first, second : ((B,) array_like, (B,) array_like)
        What each block adds to the numerator and to the denominator of the average.
    level : float, optional
        The confidence level.
    resamples : int, optional
        The number of draws.
    seed : int or numpy.random.Generator
        Source of randomness.

    Returns
    -------
    npss.Interval
        The ends of the interval of ``second - first``.

    Raises
    ------
    TypeError, ValueError
        If the shapes differ, there are fewer than two blocks, or an argument is invalid.

    Notes
    -----
    The blocks stand for others of their kind. With few of them, or rare large ones, percentiles miss more often than
    their level says.

    References
    ----------
    B. Efron and R. J. Tibshirani, "An Introduction to the Bootstrap", 1993, section 13.3.

    Examples
    --------
    >>> low, high = difference_interval(([1, 2, 3], [1, 1, 1]), ([2, 3, 4], [1, 1, 1]), seed=0)
    >>> f"{low:.3f} to {high:.3f}"  # each block is worse by 1
    '1.000 to 1.000'
    """
    sums = [np.asarray(values, np.float64) for pair in (first, second) for values in pair]
    if len(sums) != 4:
        raise ValueError(f"first, second: expected a numerator and a denominator each, got {len(sums)} arrays")
    if sums[0].ndim != 1 or len({each.shape for each in sums}) > 1 or len(sums[0]) < 2:
        shapes = ", ".join(str(each.shape) for each in sums)
        raise ValueError(f"second: expected sums over the same blocks, two or more, got shapes {shapes}")
    if not is_real(level):
        raise TypeError(f"level: expected a number between 0 and 1, got {level!r}")
    if not 0 < level < 1:
        raise ValueError(f"level: expected a number between 0 and 1, got {level!r}")
    n = len(sums[0])
    drawn = generator(seed).multinomial(n, np.full(n, 1 / n), size=positive_integer("resamples", resamples))
    over, under, other_over, other_under = (drawn @ each for each in sums)
    differences = other_over / other_under - over / under
    low, high = np.quantile(differences, [(1 - level) / 2, (1 + level) / 2])
    return Interval(float(low), float(high))
