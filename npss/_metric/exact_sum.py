"""Sums without rounding, so that a score does not depend on the order or the grouping of its parts.

A float64 is a whole number times a power of two. Held as one Python integer in units of ``2**-UNIT``, a sum of them
is exact, whatever their sizes: adding in another order, or merging partial sums, gives the same integer, and the
quotient of two such integers, which Python rounds correctly, the same float.

The terms are taken apart from their leading bits down: adding a large power of two to each of them, and
subtracting it again, rounds them all to one grid, so coarse that float64 sums of them are exact and so fine that about
forty bits are gone at each turn. What the rounding took off is exact, too, and is the next turn's term.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from npss.validation import Float64

# The smallest term: a subnormal weight (2**-1074, with 53 bits below it) of a feature whose values were scaled
# by up to 2**1074 (and a little more where they cancel), which scales its power by up to twice that power of two.
UNIT = 3400

_MOST_TERMS = 2**26
_LARGE = 900  # larger powers of two are scaled down first, lest the grid overflow


def exact_sum(values: Float64, exponents: npt.NDArray[np.int64] | None = None) -> int:
    """Return the sum of ``values * 2.0**exponents``, exactly, in units of ``2**-UNIT``.

    Parameters
    ----------
    values : ndarray of float64
        Finite; any shape.
    exponents : ndarray of int64, optional
        Of the same shape, at least -2200; zero where it is left out.

    Returns
    -------
    int
    """
    if values.size > _MOST_TERMS:
        raise ValueError(f"values: {values.size} terms at once, at most {_MOST_TERMS} are summed exactly")
    if exponents is None:
        return _sum(values, 0)
    return sum(_sum(values[exponents == exponent], exponent) for exponent in np.unique(exponents).tolist())


def _sum(values: Float64, exponent: int) -> int:
    rest = values.ravel()
    room = rest.size.bit_length() + 1  # for the carries
    total = 0
    while peak := float(np.abs(rest).max(initial=0.0)):
        power = math.frexp(peak)[1]
        if power > _LARGE:
            large = np.abs(rest) >= 1.0
            total += _sum(np.ldexp(rest[large], -_LARGE), exponent + _LARGE)
            rest = rest[~large]
            continue
        grid = math.ldexp(1.0, power + room)
        high = rest + grid
        high -= grid
        mantissa, power = math.frexp(float(high.sum()))
        total += int(math.ldexp(mantissa, 53)) << (power - 53 + exponent + UNIT)
        rest = rest - high
    return total
