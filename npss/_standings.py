"""Who is better than whom: scores of models side by side, with what chance alone may have done."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from npss._bootstrap import METHOD, RESAMPLES, bootstrap_interval, checked_level
from npss._fingerprint import differing
from npss._results import EULER, Result
from npss._sign_flip import EXACT_UP_TO, SAMPLES, sign_flips
from npss._ties import tied

#: What marks a number that is worse than the best by more than chance.
MARK = "†"
#: How it is told, in words that a table can print.
TEST = "paired sign-flip test over sequences, Holm's correction over all pairs of a column"


@dataclass(frozen=True, kw_only=True)
class Standing:
    """A result among the others of its action and column."""

    result: Result
    low: float | None = None  # confidence interval
    high: float | None = None
    rank: int | None = None  # 1 + how many models are better; None for published numbers
    best: bool = False
    worse: bool = False  # than the best, by more than chance
    p_value: float | None = None  # of the difference from the best, corrected for how many models there are


def standings(results: Sequence[Result], *, level: float = 0.95, seed: int = 0) -> list[Standing]:
    """Rank results among those of the same action and column, each with its interval.

    Raises
    ------
    ValueError
        If two of them are numbers of different meaning, of different ground truth, or of the same model.
    """
    checked_level(level)
    published = {result.label for result in results if result.source}
    if alike := [result.model for result in results if not result.source and result.model in published]:
        raise ValueError(f"{alike[0]!r} is what a published model is called; call your own something else")
    _check_truths(results)
    columns: dict[tuple[str, str], list[Result]] = {}
    for result in results:
        columns.setdefault((result.action, result.column), []).append(result)
    return [standing for column in columns.values() for standing in _column(column, level, seed)]


def _column(results: list[Result], level: float, seed: int) -> list[Standing]:
    first = results[0]
    where = f"{first.action or 'all'}, {first.column}"
    for other in results[1:]:
        if other.signature != first.signature:
            raise ValueError(
                f"{where}: {first.model!r} and {other.model!r} are different numbers, which cannot be ranked together: "
                f"{first.signature} and {other.signature}"
            )
    ranked = [result for result in results if not result.source]
    names = [result.label for result in results]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"{where}: {twice[0]!r} is there twice")
    ends = _intervals(ranked, level, seed)
    p_values = _p_values(ranked, seed)
    leader = min(ranked, key=lambda result: result.value, default=None)

    def differ(one: Result, other: Result) -> bool:
        """Say whether two values differ by more than chance; by more than rounding, where chance is not known."""
        p_value = p_values.get(frozenset((one.model, other.model)))
        if p_value is None:
            return not tied(one.value, other.value)
        return p_value <= 1 - level

    found = []
    for result in results:
        if result.source or leader is None:
            found.append(Standing(result=result))
            continue
        better = [other for other in ranked if other.value < result.value and differ(other, result)]
        p_value = p_values.get(frozenset((result.model, leader.model)))
        low, high = ends.get(result.model, (None, None))
        found.append(
            Standing(
                result=result,
                low=low,
                high=high,
                rank=1 + len(better),
                best=len(ranked) > 1 and tied(result.value, leader.value),
                worse=p_value is not None and leader in better,
                p_value=p_value,
            )
        )
    return found


def _intervals(results: Sequence[Result], level: float, seed: int) -> dict[str, tuple[float, float]]:
    """Return the interval of each model of which the sequences are known; the same sequences are drawn for all."""
    known = [result for result in results if result.numerator is not None]
    if not known:
        return {}
    numerators = np.stack([np.asarray(result.numerator) for result in known])
    weights = np.stack([np.asarray(result.weight) for result in known])
    low, high = bootstrap_interval(numerators, weights, level=level, seed=seed)
    return {result.model: (float(low[i]), float(high[i])) for i, result in enumerate(known)}


def _p_values(results: Sequence[Result], seed: int) -> dict[frozenset[str], float]:
    """Return the p-value of every two results of which the sequences are known, by Holm's correction."""
    found = {}
    for one, other in combinations(results, 2):
        if one.numerator is None or other.numerator is None or one.weight is None:
            continue
        counts = one.weight > 0
        difference = (one.numerator - other.numerator)[counts]
        p_value = sign_flips(difference, one.weight[counts], seed=seed).p_value() if counts.sum() > 1 else 1.0
        found[frozenset((one.model, other.model))] = p_value
    return dict(zip(found, holm(list(found.values())), strict=True))


def holm(p_values: Sequence[float]) -> list[float]:
    """Correct p-values of several tests, such that with no true difference, none is found but by chance of the level.

    References
    ----------
    S. Holm, "A Simple Sequentially Rejective Multiple Test Procedure", Scandinavian Journal of Statistics 6, 1979.
    """
    order = sorted(range(len(p_values)), key=lambda i: p_values[i])
    corrected = [0.0] * len(p_values)
    largest = 0.0
    for place, i in enumerate(order):
        largest = max(largest, min(1.0, (len(p_values) - place) * p_values[i]))
        corrected[i] = largest
    return corrected


def _check_truths(results: Iterable[Result]) -> None:
    """Raise the ValueError that names two models which were scored on different ground truth."""
    seen: dict[str, Result] = {}
    for result in results:
        if result.fingerprint is None:
            continue
        first = seen.setdefault(result.action, result)
        known = np.asarray(first.fingerprint)
        if len(known) != len(result.fingerprint):
            what = f"{len(known)} and {len(result.fingerprint)} sequences"
        elif known.ndim != result.fingerprint.ndim:
            raise ValueError(
                f"{result.action or 'all'}: {first.model!r} and {result.model!r} cannot be compared: an older npss "
                "measured one of them, and ground truths have other fingerprints since; measure it anew"
            )
        elif (other := differing(known, result.fingerprint)).any():
            what = f"sequence {int(other.argmax())} differs"
        else:
            continue
        raise ValueError(
            f"{result.action or 'all'}: {first.model!r} and {result.model!r} were scored on different ground truth "
            f"({what}), so they cannot be compared"
        )


def notes(found: Sequence[Standing], *, level: float = 0.95, seed: int = 0) -> list[str]:
    """Say in words how intervals, marks and ranks were made, and where chance cannot be told from difference."""
    own = [standing for standing in found if not standing.result.source]
    tested = [standing for standing in own if standing.result.weight is not None]
    sources = dict.fromkeys(standing.result.source for standing in found if standing.result.source)
    aside = " of one's own" if sources else ""
    lines = [f"Lower is better. In bold, or with *: the best{aside} of a column."]
    if any(standing.result.column.startswith(EULER) for standing in found):
        lines.append("Under ms: Euler error, in radians.")
    if tested:
        lines.append(f"Intervals: {100 * level:g} %, {METHOD}, {RESAMPLES} resamples, seed {seed}.")
        lines.append(
            f"{MARK} worse than the best{aside} by more than chance ({1 - level:.2g}; {TEST}; exact up to "
            f"{EXACT_UP_TO} sequences, else {SAMPLES} draws). Rank: 1 + the models that are better by more than chance."
        )
        for action in dict.fromkeys(standing.result.action for standing in tested):
            lines += _too_few([s for s in tested if s.result.action == action], level)
    lines += _still(tested)
    if any(standing.result.weight is None for standing in own):
        lines.append("Without intervals: numbers of which the single sequences are not known; ranked by value.")
    if sources:
        lines.append(f"Published numbers, not ranked: {'; '.join(sources)}.")
    return lines


def _still(tested: Sequence[Standing]) -> list[str]:
    """Say of which sequences there is no Euler error."""
    euler = {one.result.action: one.result for one in tested if one.result.column.startswith(EULER)}
    weights = {action: np.asarray(result.weight) for action, result in euler.items()}
    return [
        f"{action or 'all'}: without an Euler error, since nothing moves in their ground truth: "
        f"{(weight == 0).sum()} of {len(weight)} sequences."
        for action, weight in weights.items()
        if (weight == 0).any()
    ]


def _too_few(tested: Sequence[Standing], level: float) -> list[str]:
    """Say so if there are too few sequences to show any difference between so many models."""
    first = tested[0].result
    models = sum(standing.result.column == first.column for standing in tested)
    pairs = math.comb(models, 2)
    n = int((np.asarray(first.weight) > 0).sum())
    smallest = 2.0 ** (1 - n) if n <= EXACT_UP_TO else 1 / (SAMPLES + 1)
    if pairs * smallest <= 1 - level:
        return []
    return [
        f"{first.action or 'all'}: {n} sequence{'s' * (n > 1)} cannot show any difference between {models} models: the "
        f"smallest possible p-value is {smallest:.2g}, and the {pairs} pairs ask for {(1 - level) / pairs:.2g}."
    ]
