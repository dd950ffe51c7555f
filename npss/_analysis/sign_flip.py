"""The sign-flip test: a paired test that exchanges two models in some blocks."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from npss._analysis.bootstrap import checked_level
from npss._analysis.interval import Interval
from npss.validation import Float64, Seed, generator

EXACT_UP_TO = 16  # blocks; for more, exchanges are drawn
#: The least number of blocks for a p-value: with fewer, the smallest possible one is above .05.
MIN_BLOCKS_OF_TEST = 6
SAMPLES = 9999
_BLOCK = 2**18  # choices in memory at once


class SignFlips(NamedTuple):
    """The quotients of sums over the exchanged blocks and over the others, for every exchange.

    Exchanging a set S of blocks makes the sum of the differences d at least as extreme as observed if and only if 0
    lies between the quotients sum d / sum w over S and over its complement. So a pair of numbers for each exchange
    gives both the p-value and the interval of values that the test does not reject.
    """

    low: Float64  # (K,); the smaller of the two quotients, -inf where S is empty or all
    high: Float64  # (K,)
    observed: float  # the quotient of the whole sums
    exact: bool  # whether all exchanges are included (a set and its complement are the same exchange)

    def p_value(self) -> float:
        """Return the share of exchanges at least as extreme as the observed one, in either direction."""
        return float(np.mean((self.low <= 0) & (self.high >= 0)))

    def one_sided(self, sign: int) -> float:
        """Return the share of exchanges that make a difference at least as far to the side of `sign`, 1 or -1."""
        # To exchange S does so if the sum over S is not to that side: 0 of the empty set, all of its complement.
        low, high = np.where(np.isinf(self.low), 0.0, self.low), np.where(np.isinf(self.high), self.observed, self.high)
        return float(np.mean([sign * low <= 0, sign * high <= 0]))

    def interval(self, level: float) -> Interval:
        """Return the smallest and largest difference that the test at ``1 - level`` does not reject."""
        last = len(self.low) - 1
        rank = min(last, math.floor((1 - checked_level(level)) * len(self.low) + 1e-9))
        return Interval(float(np.sort(self.low)[rank]), float(np.sort(self.high)[::-1][rank]))


def sign_flips(difference: Float64, weight: Float64, *, seed: Seed = 0) -> SignFlips:
    """Exchange the models in every set of blocks, or in random sets if there are many blocks.

    Parameters
    ----------
    difference : (N,) ndarray of float64
        What each block adds to the difference of the two numerators; rounding counts as 0, see `settled`.
    weight : (N,) ndarray of float64
        What each block adds to the common denominator; positive.
    seed : int or numpy.random.Generator, optional
        The seed of the generator that draws the sets.

    Raises
    ------
    TypeError, ValueError
        If the seed is neither a whole number from 0 on nor a generator.

    References
    ----------
    J. A. Hartigan, "Using Subsample Values as Typical Values", JASA 64, 1969: the interval is exact for any
    distribution, if differences are independent and symmetric about the true one.
    """
    n = len(difference)
    exact = n <= EXACT_UP_TO
    rng = generator(seed)
    difference = settled(difference, weight)
    n_sets = 2 ** (n - 1) if exact else SAMPLES + 1
    terms = np.stack([difference, np.abs(difference), weight], axis=1)
    inside, outside = np.empty((2, n_sets))
    for top in range(0, n_sets, rows := max(1, _BLOCK // n)):
        some = np.arange(top, min(top + rows, n_sets))
        if exact:  # the last block stays: a set and its complement are the same exchange
            chosen = some[:, np.newaxis] >> np.arange(n) & 1
        else:
            chosen = rng.integers(2, size=(len(some), n), dtype=np.uint8)
            chosen[some == 0] = 0  # the observed exchange is included: otherwise p could be zero
        sets = chosen.astype(np.float64)
        inside[some] = _quotients(sets @ terms)
        outside[some] = _quotients((1 - sets) @ terms)
    whole = np.isnan(inside) | np.isnan(outside)
    low, high = np.minimum(inside, outside), np.maximum(inside, outside)
    observed = float(_quotients(terms.sum(axis=0, keepdims=True))[0])
    return SignFlips(np.where(whole, -np.inf, low), np.where(whole, np.inf, high), observed, exact)


def settled(difference: Float64, weight: Float64) -> Float64:
    """Set differences that are rounding, below 1e-10 of the weight, to 0, so that they do not decide."""
    return np.where(np.abs(difference) <= 1e-10 * weight, 0.0, difference)


def _quotients(sums: Float64) -> Float64:
    """Return the quotients of differences and weights from sums ``(k, 3)`` of terms; NaN for an empty set."""
    difference, size, weight = sums.T
    with np.errstate(invalid="ignore"):  # rounding must not break ties
        quotients: Float64 = np.where(np.abs(difference) <= 1e-12 * size, 0.0, difference) / weight
    return quotients
