"""Sums without rounding, so that a score does not depend on the order or the grouping of its parts.

A float64 is a whole number times a power of two. Held as one Python integer in units of ``2**-UNIT``, a sum of them
is exact, whatever their sizes: adding in another order, or merging partial sums, gives the same integer, and the
quotient of two such integers, which Python rounds correctly, the same float.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss._checks import Float64

# The smallest term: a subnormal weight (2**-1074, with 53 bits below it) of a feature whose values were scaled
# by up to 2**1074, which scales its power by up to 2**2148.
UNIT = 3328

_HALF = 27  # bits; both halves of a 53-bit mantissa stay exact in float64 sums of up to 2**26 terms
_MOST_TERMS = 2**26


def exact_sum(values: Float64, exponents: npt.NDArray[np.int64] | None = None) -> int:
    """Return the sum of ``values * 2.0**exponents``, exactly, in units of ``2**-UNIT``.

    Parameters
    ----------
    values : ndarray of float64
        Finite; any shape.
    exponents : ndarray of int64, optional
        Of the same shape, at least -2148; zero where it is left out.

    Returns
    -------
    int
    """
    if values.size > _MOST_TERMS:
        raise ValueError(f"values: {values.size} terms at once, at most {_MOST_TERMS} are summed exactly")
    mantissas, powers = np.frexp(values.ravel())
    shifts = powers.astype(np.int64)
    if exponents is not None:
        shifts += exponents.ravel()
    lowest = int(shifts.min(initial=0))
    shifts -= lowest
    whole = np.ldexp(mantissas, 53)  # integers below 2**53 in magnitude
    high = np.floor(np.ldexp(whole, -_HALF))
    low = whole - np.ldexp(high, _HALF)
    highs = np.bincount(shifts, weights=high)
    lows = np.bincount(shifts, weights=low)
    total = 0
    for shift in np.flatnonzero((highs != 0) | (lows != 0)):
        total += ((int(highs[shift]) << _HALF) + int(lows[shift])) << (int(shift) + lowest - 53 + UNIT)
    return total
