"""Who is better than whom: scores of models side by side, with what chance alone may have done."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np

from npss._bootstrap import METHOD, RESAMPLES, bootstrap_interval, checked_level
from npss._checks import Float64
from npss._records import Record, signature_of
from npss._report import Report
from npss._sign_flip import EXACT_UP_TO, SAMPLES, sign_flips
from npss._signature import parse_signature

#: What marks a number that is worse than the best by more than chance.
MARK = "†"

_SAME_TRUTH = 1e-3  # relative difference of the power of two copies of a ground truth, one of them rounded


@dataclass(frozen=True, kw_only=True)
class Result:
    """One number of one model: a row of a tidy leaderboard."""

    model: str
    action: str
    column: str  # such as "NPSS paper" or "Euler error 80 ms"
    value: float
    signature: str
    numerator: Float64 | None = None  # (N,); what each sequence adds to the weighted mean that the value is
    weight: Float64 | None = None  # (N,)
    source: str = ""  # where a published number is from; empty for one's own


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


def results_of_record(record: Record) -> list[Result]:
    """Read the numbers of a record, as `npss._records.measure` returns it, with ``model`` and ``action``."""
    for field in ("model", "action", "signature"):
        if not isinstance(record.get(field), str):
            raise ValueError(f"records: expected a text {field!r} in each, got {record.get(field)!r}")
    named: dict[str, Any] = {"model": record["model"], "action": record["action"], "source": record.get("source", "")}
    alone = record.get("sequences", {})
    weights = {name: np.array(weight, np.float64) for name, weight in alone.get("weight", {}).items()}
    found = []
    for name, value in record.get("npss", {}).items():
        weight = weights.get(name)
        numerator = None if weight is None else weight * np.array(alone["npss"][name])
        which = signature_of(record, "npss", name)
        found.append(
            Result(column=f"NPSS {name}", value=value, signature=which, numerator=numerator, weight=weight, **named)
        )
    for name, windows in record.get("npss_windows", {}).items():
        for window, value in windows.items():
            which = signature_of(record, "npss", name, window=window)
            found.append(Result(column=f"NPSS {name} {window} s", value=value, signature=which, **named))
    for time, value in record.get("euler_error", {}).items():
        errors = alone.get("euler_error", {}).get(time)
        numerator = None if errors is None else np.array(errors, np.float64)
        weight = None if numerator is None else np.ones_like(numerator)
        which = signature_of(record, "euler_error")
        column = f"Euler error {time} ms"
        found.append(Result(column=column, value=value, signature=which, numerator=numerator, weight=weight, **named))
    return found


def result_of_report(model: str, action: str, report: Report) -> Result:
    """Read the score of a report."""
    convention = parse_signature(report.signature)["convention"]
    name = convention if isinstance(convention, str) else report.signature.split("convention:")[1].split("|")[0]
    return Result(
        model=model,
        action=action,
        column=f"NPSS {name}",
        value=report.score,
        signature=report.signature,
        numerator=(report.weight * report.emd).sum(axis=1),
        weight=report.weight.sum(axis=1),
    )


def standings(results: Sequence[Result], *, level: float = 0.95, seed: int = 0) -> list[Standing]:
    """Rank results among those of the same action and column, each with its interval.

    Raises
    ------
    ValueError
        If two of them are numbers of different meaning, of different ground truth, or of the same model.
    """
    checked_level(level)
    _check_truths(results)
    columns: dict[tuple[str, str], list[Result]] = {}
    for result in results:
        columns.setdefault((result.action, result.column), []).append(result)
    return [standing for column in columns.values() for standing in _column(column, level, seed)]


def _column(results: list[Result], level: float, seed: int) -> list[Standing]:
    first = results[0]
    for other in results[1:]:
        if other.signature != first.signature:
            raise ValueError(
                f"{first.action}, {first.column}: {first.model!r} and {other.model!r} are different numbers, which "
                f"cannot be ranked together: {first.signature} and {other.signature}"
            )
    ranked = [result for result in results if not result.source]
    names = [result.model for result in ranked]
    if twice := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"{first.action}, {first.column}: {twice[0]!r} is there twice")
    p_values = _p_values(ranked, seed)
    leader = min(ranked, key=lambda result: result.value, default=None)

    def differ(one: Result, other: Result) -> bool:
        """Say whether two values differ by more than chance; by more than rounding, where chance is not known."""
        p_value = p_values.get(frozenset((one.model, other.model)))
        if p_value is None:
            return not math.isclose(one.value, other.value, rel_tol=1e-12)
        return p_value <= 1 - level

    found = []
    for result in results:
        low = high = None
        if result.numerator is not None and result.weight is not None:
            ends = bootstrap_interval(result.numerator, result.weight, level=level, seed=seed)
            low, high = (float(end) for end in ends)
        if result.source or leader is None:
            found.append(Standing(result=result, low=low, high=high))
            continue
        better = [other for other in ranked if other.value < result.value and differ(other, result)]
        p_value = p_values.get(frozenset((result.model, leader.model)))
        found.append(
            Standing(
                result=result,
                low=low,
                high=high,
                rank=1 + len(better),
                best=len(ranked) > 1 and math.isclose(result.value, leader.value, rel_tol=1e-12),
                worse=p_value is not None and leader in better,
                p_value=p_value,
            )
        )
    return found


def _p_values(results: Sequence[Result], seed: int) -> dict[frozenset[str], float]:
    """Return the p-value of every two results of which the sequences are known, by Holm's correction."""
    found = {}
    for one, other in combinations(results, 2):
        if one.numerator is not None and other.numerator is not None and one.weight is not None:
            counts = one.weight > 0
            if counts.sum() > 1:
                difference = (one.numerator - other.numerator)[counts]
                found[frozenset((one.model, other.model))] = sign_flips(
                    difference, one.weight[counts], seed=seed
                ).p_value()
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
    seen: dict[tuple[str, str], Result] = {}
    for result in results:
        if result.weight is None or result.numerator is None:
            continue
        first = seen.setdefault((result.action, result.column), result)
        assert first.weight is not None
        if len(first.weight) != len(result.weight):
            what = f"{len(first.weight)} and {len(result.weight)} sequences"
        elif not np.allclose(first.weight, result.weight, rtol=_SAME_TRUTH, atol=_SAME_TRUTH * first.weight.mean()):
            differing = np.abs(first.weight - result.weight)
            what = f"sequence {int(np.argmax(differing))} differs in power"
        else:
            continue
        raise ValueError(
            f"{result.action}: {first.model!r} and {result.model!r} were scored on different ground truth ({what}), so "
            f"they cannot be compared"
        )


def notes(found: Sequence[Standing], *, level: float = 0.95, seed: int = 0) -> list[str]:
    """Say in words how intervals, marks and ranks were made, and where chance cannot be told from difference."""
    own = [standing for standing in found if not standing.result.source]
    tested = [standing for standing in own if standing.result.weight is not None]
    lines = ["Lower is better."]
    if any(standing.result.column.startswith("Euler error") for standing in found):
        lines.append("Under ms: Euler error, in radians.")
    if tested:
        lines.append(f"Intervals: {100 * level:g} %, {METHOD}, {RESAMPLES} resamples, seed {seed}.")
        lines.append(
            f"{MARK} worse than the best by more than chance ({1 - level:.2g}; paired sign-flip test over sequences, "
            f"exact up to {EXACT_UP_TO} of them, else {SAMPLES} draws; Holm's correction over all pairs of a column). "
            f"Rank: 1 + the models that are better by more than chance."
        )
        for action in dict.fromkeys(standing.result.action for standing in tested):
            lines += _too_few([s for s in tested if s.result.action == action], level)
    if any(standing.result.weight is None for standing in own):
        lines.append("Without intervals: numbers of which the single sequences are not known; ranked by value.")
    if sources := dict.fromkeys(standing.result.source for standing in found if standing.result.source):
        lines.append(f"Published numbers, not ranked: {'; '.join(sources)}.")
    return lines


def _too_few(standings_: Sequence[Standing], level: float) -> list[str]:
    """Say so if there are too few sequences to show any difference between so many models."""
    first = standings_[0].result
    assert first.weight is not None
    models = sum(standing.result.column == first.column for standing in standings_)
    pairs = math.comb(models, 2)
    n = int((first.weight > 0).sum())
    smallest = 2.0 ** (1 - n)
    if pairs and pairs * smallest > 1 - level:
        return [
            f"{first.action}: {n} sequences cannot show any difference between {models} models: the smallest possible "
            f"p-value is {smallest:.2g}, and the {pairs} pairs ask for {(1 - level) / pairs:.2g}."
        ]
    return []
