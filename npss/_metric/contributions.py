"""Compute a score together with what contributes to it: the statistics of every feature of every sequence."""

from __future__ import annotations

from collections.abc import Callable
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from npss._metric.bound import largest_distance, normalised, unit_of_weight
from npss._metric.convention import Convention
from npss._metric.kernel import Tile
from npss._metric.parts import Parts, parts_of
from npss._metric.score import quotient, weighted_sums
from npss._metric.sequences import Group
from npss.validation import Array, Float64


class Contributions(NamedTuple):
    """The NPSS of a set of motions, and of every feature of every sequence."""

    score: float  # as `npss.score` returns it
    emd: Float64  # (N, D); 0 where the weight is 0
    weight: Float64  # (N, D)
    form: Float64  # (N, D); the part of `emd` that is left with the true shares of DC
    floor: Float64 | None  # (N, D); the least `emd` with these shares of DC; None for one-sided conventions

    def by_sequence(self) -> tuple[Float64, Float64]:
        """Return each sequence's share of the score's numerator and denominator, both ``(N,)``."""
        return (self.weight * self.emd).sum(axis=1), self.weight.sum(axis=1)

    def parts(self) -> Parts:
        """Return what the score is made of."""
        return parts_of(self.score, self.weight, self.form, self.floor, float(self.weight.sum()))


class _Columns(NamedTuple):
    """The statistics of all columns, ``(N, D)`` each: distance, weight, form and floor."""

    emd: Float64
    weight: Float64
    form: Float64
    floor: Float64


def contributions(
    gt: Array,
    pred: Array,
    convention: Convention,
    *,
    workers: int = 1,
    where: str = "",
    progress: Callable[[float], None] = lambda share: None,
) -> Contributions:
    """Score a set of motions and keep the statistics of every feature of every sequence.

    Raises
    ------
    ValueError
        As for `npss.score`, or if the weights leave the range of float64.
    """
    sums, columns = _columns(gt, pred, convention, workers=workers, progress=progress)
    return _checked(sums, columns, convention, where)


def normalised_contributions(groups: list[Group], convention: Convention) -> Contributions:
    """Score motions of different lengths in units of their bounds; see `npss._metric.bound`.

    Raises
    ------
    ValueError
        As for `contributions`.
    """
    sums, parts = {}, []
    for group in groups:
        n_frames = group.n_frames
        both, columns = _columns(group.gt, group.pred, convention)
        sums[n_frames] = both
        bound, unit = float(largest_distance(convention, n_frames)), unit_of_weight(convention, n_frames)
        parts.append([columns.emd / bound, columns.weight / unit, columns.form / bound, columns.floor / bound])
    order = np.argsort([row for group in groups for row in group.rows])
    joined = _Columns(*(np.concatenate(values)[order] for values in zip(*parts, strict=True)))
    return _checked(normalised(sums, convention), joined, convention)


def _columns(
    gt: Array,
    pred: Array,
    convention: Convention,
    *,
    workers: int = 1,
    progress: Callable[[float], None] = lambda share: None,
) -> tuple[tuple[int, int], _Columns]:
    """Return the exact sums and the statistics of all columns."""
    shape = (len(gt) if gt.ndim == 3 else 1, gt.shape[-1])
    columns = _Columns(*(np.empty(shape) for _ in range(4)))

    def keep(part: Tile) -> None:
        block = part.sequences, part.features
        columns.emd[block] = part.distance
        assert part.parts is not None
        columns.form[block], columns.floor[block] = part.parts
        with np.errstate(over="ignore", under="ignore"):
            columns.weight[block] = part.weight if part.exponent is None else np.ldexp(part.weight, part.exponent)

    sums = weighted_sums(gt, pred, convention, workers=workers, progress=progress, keep=keep, parts=True)
    return sums, columns


def _checked(
    sums: tuple[int | Fraction, int | Fraction], columns: _Columns, convention: Convention, where: str = ""
) -> Contributions:
    """Divide the sums, and check the range of the weights."""
    score = quotient(*sums, where)
    emd, weight, form, floor = columns
    with np.errstate(over="ignore"):
        total = float(weight.sum())
    if not 1e-280 < total < 1e290:  # keeps sums of weighted distances in range, and their bits
        raise ValueError("gt: its power is beyond float64; scale it (a power of two keeps every bit of the score)")
    emd, form, floor = (np.where(weight > 0, column, 0.0) for column in (emd, form, floor))
    return Contributions(score, emd, weight, form, floor if convention.bins == "two-sided" else None)
