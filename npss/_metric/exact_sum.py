"""Sum without rounding, so that a score does not depend on the order or grouping of its parts.

A float64 is an integer times a power of two. As one Python integer in units of ``2**-UNIT``, a sum of float64 is exact.
Adding in another order or merging partial sums gives the same integer, and the quotient of two such integers, which
Python rounds correctly, gives the same float.

Terms are split from their leading bits down. Adding a large power of two to each and subtracting it rounds them all to
one grid. The grid is coarse enough for exact float64 sums, and fine enough to remove about forty bits in each turn. The
remainders are exact, too, and are the terms of the next turn.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from npss.validation import Float64

# The smallest term is a subnormal weight (2**-1074, with 53 bits below it) of a feature scaled by up to 2**1074 (a
# little more where values cancel), which scales its power by up to the square of that.
UNIT = 3400

_MOST_TERMS = 2**26
_LARGE = 900  # scale larger powers of two down first: the grid would overflow


def exact_sum(values: Float64, exponents: npt.NDArray[np.int64] | None = None) -> int:
    """Return the exact sum of ``values * 2.0**exponents`` in units of ``2**-UNIT``.

    Parameters
    ----------
    values : ndarray of float64
        Finite; any shape.
    exponents : ndarray of int64, optional
        Same shape, at least -2200 (default: zeros).

    Returns
    -------
    int
    """
    if values.size > _MOST_TERMS:
        raise ValueError(f"values: expected at most {_MOST_TERMS} terms, got {values.size}")
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
