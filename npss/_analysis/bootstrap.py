"""Confidence intervals of quotients of two sums over blocks, by the bootstrap."""

from __future__ import annotations

import numpy as np

from npss.validation import Float64, Seed, generator, is_real

#: How an interval was made, in words that a table can print.
METHOD = "studentised bootstrap over blocks"
RESAMPLES = 9999
_BLOCK = 2**20  # draws at once


def bootstrap_interval(
    numerator: Float64, denominator: Float64, *, level: float = 0.95, seed: Seed = 0, resamples: int = RESAMPLES
) -> tuple[Float64, Float64]:
    """Return where the quotient of two sums over blocks lies, as far as the blocks tell.

    Blocks are drawn with replacement; each draw's quotient is divided by its own standard error before quantiles are
    taken. With few blocks of skewed weights, plain percentiles of the quotients miss far more often than
    they say; this interval misses less often, for being wider (the documentation has the simulation).

    Parameters
    ----------
    numerator : (..., N) ndarray of float64
        What each of the N blocks adds to the numerator; none is negative.
    denominator : (..., N) ndarray of float64
        Of the same shape. Blocks with 0 in every row do not count, and are not drawn.
    level : float, optional
        Share of such intervals that should hold the true value.
    seed : int or numpy.random.Generator, optional
        Of the generator that draws.
    resamples : int, optional
        How often is drawn.

    Returns
    -------
    low, high : (...) ndarray of float64
        ``high`` is infinite where there are too few blocks to tell: at the usual level, fewer than four.

    Raises
    ------
    TypeError, ValueError
        If the level is not between 0 and 1, or the seed is neither a whole number from 0 on nor a generator.

    References
    ----------
    B. Efron and R. J. Tibshirani, "An Introduction to the Bootstrap", 1993, section 12.5.
    """
    tail = (1 - checked_level(level)) / 2
    rng = generator(seed)
    counts = denominator.any(axis=tuple(range(denominator.ndim - 1)))
    numerator, denominator = numerator[..., counts], denominator[..., counts]
    n = numerator.shape[-1]
    whole, base = numerator.sum(axis=-1), denominator.sum(axis=-1)
    value = whole / base
    if n == 1:
        return np.zeros_like(value), np.full_like(value, np.inf)
    # In units of the two sums, so that no square leaves the range of float64; where all is 0, so is every part.
    numerator = numerator / np.where(whole == 0, 1.0, whole)[..., np.newaxis]
    denominator = denominator / base[..., np.newaxis]
    residual = numerator - denominator * numerator.sum(axis=-1, keepdims=True)
    residual[np.abs(residual) <= 1e-13 * numerator] = 0.0  # rounding
    # Of the blocks drawn, so many times each, the sums of what a quotient and its standard error are made of.
    terms = [residual, denominator, residual**2, residual * denominator, denominator**2]
    parts = []
    for top in range(0, resamples, rows := max(1, _BLOCK // n)):
        drawn = rng.integers(n, size=(min(rows, resamples - top), n))
        drawn += n * np.arange(len(drawn))[:, np.newaxis]
        times = np.bincount(drawn.ravel(), minlength=drawn.size).reshape(drawn.shape).astype(np.float64)
        parts.append([term @ times.T for term in terms])
    r, d, rr, rd, dd = (np.concatenate(sums, axis=-1) for sums in zip(*parts, strict=True))  # (..., resamples)
    with np.errstate(all="ignore"):
        shift = r / d  # of the quotient
        squares = rr - 2 * shift * rd + shift**2 * dd
        squares[squares <= 1e-12 * rr] = 0.0  # a draw of one block only has no spread, and knows of no error
        studentised = np.where(shift == 0, 0.0, r / np.sqrt(squares))
    error = value * np.sqrt(np.square(residual).sum(axis=-1))
    most, least = (
        np.quantile(studentised, share, axis=-1, method="inverted_cdf") for share in (1 - tail, tail)
    )  # a method that does not average: some may be infinite
    with np.errstate(invalid="ignore"):
        low, high = value - most * error, value - least * error
    certain = error == 0
    return np.where(certain, value, np.maximum(low, 0.0)), np.where(certain, value, high)


def checked_level(level: object) -> float:
    """Read a confidence level, between 0 and 1."""
    if not is_real(level):
        raise TypeError(f"level: expected a number between 0 and 1, got {level!r}")
    if not 0 < level < 1:
        raise ValueError(f"level: expected a number between 0 and 1, got {level}")
    return float(level)


def seed_text(seed: Seed) -> str:
    """Say what seeded a generator, in words that a table can print."""
    return "a generator of your own" if isinstance(seed, np.random.Generator) else f"seed {seed}"
