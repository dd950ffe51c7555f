"""The uncertainty of a score: a confidence interval, or the range of blocks if they are too few."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from npss._analysis.blocks import Blocks, counted
from npss._analysis.bootstrap import METHOD, RESAMPLES, bootstrap_interval, checked_level, seed_text
from npss.validation import Float64, Seed, generator

#: The least number of blocks that supports an interval.
MIN_BLOCKS_OF_INTERVAL = 10
#: The coverage of intervals, measured by ``benchmarks/significance.py``.
FOUND = "on real motion, intervals of 95 % held the score in 75 to 97 % of cases, by action and metric"
#: The alternative for fewer blocks, as text for a table.
RANGE = "range of blocks"


class Interval(NamedTuple):
    """A confidence interval.

    Attributes
    ----------
    low, high : float
        The ends.

    Examples
    --------
    >>> import npss
    >>> npss.Interval(0.25, 0.75).high
    0.75
    """

    low: float
    high: float


class Range(NamedTuple):
    """The lowest and the highest score of a block, if there are too few blocks for a confidence interval.

    Attributes
    ----------
    low, high : float
        The ends.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt, pred = np.random.default_rng(0).normal(size=(2, 8, 50, 3)).cumsum(axis=2)
    >>> isinstance(npss.report(gt, pred).interval(), npss.Range)
    True
    """

    low: float
    high: float


def ends(
    numerator: Float64, denominator: Float64, blocks: Blocks, *, level: float = 0.95, seed: Seed = 0
) -> tuple[Float64, Float64]:
    """Return the ends of intervals of quotients of two sums, or of ranges if there are too few blocks.

    Parameters
    ----------
    numerator, denominator : (..., N) ndarray of float64
        What each of the N sequences adds to the two sums.
    blocks : Blocks
        The blocks of the sequences; sequences in no block do not count.
    level, seed : float, int or numpy.random.Generator
        As for `bootstrap_interval`; a range does not use them.

    Returns
    -------
    low, high : (...) ndarray of float64

    Raises
    ------
    TypeError, ValueError
        As `bootstrap_interval`.
    """
    checked_level(level)
    generator(seed)
    numerator, denominator = blocks.sums(numerator), blocks.sums(denominator)
    if blocks.n >= MIN_BLOCKS_OF_INTERVAL:
        return bootstrap_interval(numerator, denominator, level=level, seed=seed)
    counts = denominator > 0
    score = np.divide(numerator, denominator, out=np.full(numerator.shape, np.nan), where=counts)
    return np.nanmin(score, axis=-1), np.nanmax(score, axis=-1)


def interval(
    numerator: Float64, denominator: Float64, blocks: Blocks, *, level: float = 0.95, seed: Seed = 0
) -> Interval | Range:
    """Return the interval or the range of one quotient."""
    low, high = ends(numerator, denominator, blocks, level=level, seed=seed)
    kind = Interval if blocks.n >= MIN_BLOCKS_OF_INTERVAL else Range
    return kind(float(low), float(high))


def method(blocks: Blocks, *, level: float = 0.95, seed: Seed = 0) -> str:
    """Return the method of an interval or a range as text."""
    if blocks.n >= MIN_BLOCKS_OF_INTERVAL:
        return f"{100 * level:.4g} %, {METHOD}, {RESAMPLES} resamples, {seed_text(seed)}"
    return f"range of {counted(blocks.n, 'block')}, too few for an interval"
