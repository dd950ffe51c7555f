"""What blocks tell of where a score lies: a confidence interval, or, where they are too few, their range."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from npss._analysis.blocks import Blocks, counted
from npss._analysis.bootstrap import METHOD, RESAMPLES, bootstrap_interval, checked_level, seed_text
from npss.validation import Float64, Seed, generator

#: Blocks from which on there is an interval.
MIN_BLOCKS_OF_INTERVAL = 10
#: What was found of them, by ``benchmarks/significance.py``.
FOUND = "on real motion, intervals of 95 % held the score in 75 to 97 % of cases, by action and metric"
#: What there is of fewer, in words that a table can print.
RANGE = "range of blocks"


class Interval(NamedTuple):
    """A confidence interval.

    Attributes
    ----------
    low, high : float
        Its ends.

    Examples
    --------
    >>> import npss
    >>> npss.Interval(0.25, 0.75).high
    0.75
    """

    low: float
    high: float


class Range(NamedTuple):
    """The lowest and the highest score of a block: of so few that they support no confidence interval.

    Attributes
    ----------
    low, high : float
        Its ends.

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
    """Return the ends of intervals of quotients of two sums, or of ranges where blocks are too few for intervals.

    Parameters
    ----------
    numerator, denominator : (..., N) ndarray of float64
        What each of the N sequences adds to the two sums.
    blocks : Blocks
        Of the sequences; those that are in none do not count.
    level, seed : float, int or numpy.random.Generator
        As for `bootstrap_interval`; a range has none.

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
    """Return the interval of one quotient, or its range."""
    low, high = ends(numerator, denominator, blocks, level=level, seed=seed)
    kind = Interval if blocks.n >= MIN_BLOCKS_OF_INTERVAL else Range
    return kind(float(low), float(high))


def method(blocks: Blocks, *, level: float = 0.95, seed: Seed = 0) -> str:
    """Say how the ends were made."""
    if blocks.n >= MIN_BLOCKS_OF_INTERVAL:
        return f"{100 * level:.4g} %, {METHOD}, {RESAMPLES} resamples, {seed_text(seed)}"
    return f"range of {counted(blocks.n, 'block')}, too few for an interval"
