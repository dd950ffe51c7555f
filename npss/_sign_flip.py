"""The paired test over sequences: what if the names of two models were exchanged in some of them."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from npss._bootstrap import checked_level
from npss._checks import Float64

EXACT_UP_TO = 16  # sequences; beyond, exchanges are drawn
SAMPLES = 9999


class SignFlips(NamedTuple):
    """What the quotient of sums would be, over the exchanged and the other sequences, for every exchange.

    Under exchange of a set S of sequences, the sum of the differences d is at least as extreme as it is if and only if
    0 lies between the quotients sum d / sum w over S and over its complement. Hence all that the test needs, and the
    interval of the values that it would not reject, is a pair of numbers for each exchange.
    """

    low: Float64  # (K,); the smaller of the two quotients, -inf where S is empty or all
    high: Float64  # (K,)
    exact: bool  # whether all exchanges are there (those of S and of its complement are the same)

    def p_value(self) -> float:
        """Return the share of exchanges that are at least as extreme, in either direction, as what was seen."""
        finite = np.isfinite(self.low)
        # Sums in another order differ by rounding, which must not break ties.
        slack = 1e-12 * max(np.abs(self.low[finite]).max(initial=0), np.abs(self.high[finite]).max(initial=0))
        return float(np.mean((self.low <= slack) & (self.high >= -slack)))

    def interval(self, level: float) -> tuple[float, float]:
        """Return the smallest and largest difference that the test at ``1 - level`` would not reject."""
        rank = math.floor((1 - checked_level(level)) * len(self.low) + 1e-9)
        return float(np.sort(self.low)[rank]), float(np.sort(self.high)[::-1][rank])


def sign_flips(difference: Float64, weight: Float64, *, seed: int = 0) -> SignFlips:
    """Exchange the models in every set of sequences, or, if they are many, in sets drawn at random.

    Parameters
    ----------
    difference : (N,) ndarray of float64
        What each sequence adds to the difference of the two numerators.
    weight : (N,) ndarray of float64
        What each adds to the denominator, which they share; positive.
    seed : int, optional
        Of the generator that draws the sets.

    References
    ----------
    J. A. Hartigan, "Using Subsample Values as Typical Values", JASA 64, 1969: the interval is exact, whatever the
    distribution, if differences are independent and symmetric about the true one.
    """
    n = len(difference)
    exact = n <= EXACT_UP_TO
    if exact:  # the last sequence stays: a set and its complement are the same exchange
        chosen = np.arange(2 ** (n - 1))[:, np.newaxis] >> np.arange(n) & 1
    else:
        chosen = np.random.default_rng(seed).integers(2, size=(SAMPLES + 1, n))
        chosen[0] = 0  # what was seen is one of the exchanges: without it, p could be zero
    sets = chosen.astype(np.float64)
    with np.errstate(invalid="ignore"):
        inside = (sets @ difference) / (sets @ weight)
        outside = ((1 - sets) @ difference) / ((1 - sets) @ weight)
    whole = np.isnan(inside) | np.isnan(outside)
    low, high = np.minimum(inside, outside), np.maximum(inside, outside)
    return SignFlips(np.where(whole, -np.inf, low), np.where(whole, np.inf, high), exact)
