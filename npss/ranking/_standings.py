"""Who is better than whom: scores of models side by side, with what chance alone may have done."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from npss._analysis.blocks import INFERRED, Blocks, counted
from npss._analysis.bootstrap import METHOD, RESAMPLES, checked_level, seed_text
from npss._analysis.fingerprint import differing
from npss._analysis.interval import FOUND, MIN_BLOCKS_OF_INTERVAL, ends
from npss._analysis.sign_flip import EXACT_UP_TO, MIN_BLOCKS_OF_TEST, SAMPLES, settled, sign_flips
from npss._analysis.ties import tied
from npss._metric.registry import EULER_ERROR, direction
from npss.ranking._results import Result
from npss.validation import Float64, Seed

_SAME_WEIGHT = 0.01  # files hold ground truth in various precision
#: What marks a number that is worse than the best by more than chance.
MARK = "†"
#: How it is told, in words that a table can print.
TEST = "paired sign-flip test over blocks, Holm's correction over all pairs of a column"


@dataclass(frozen=True, kw_only=True)
class Standing:
    """A result among the others of its action and column."""

    result: Result
    low: float | None = None  # of a confidence interval; of few blocks, of their range
    high: float | None = None
    is_range: bool = False
    in_blocks: float | None = None  # the score of the sequences that are in blocks, where some are left out
    behind: tuple[int, int] | None = None  # in how many of how many blocks the best is better
    rank: int | None = None  # 1 + how many models are better; None for published numbers
    best: bool = False
    worse: bool = False  # than the best, by more than chance
    p_value: float | None = None  # of the difference from the best, corrected for how many models there are


def standings(results: Sequence[Result], *, level: float = 0.95, seed: Seed = 0) -> list[Standing]:
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
    check_truths(results)
    columns: dict[tuple[str, str], list[Result]] = {}
    for result in results:
        columns.setdefault((result.action, result.column), []).append(result)
    return [standing for column in columns.values() for standing in _column(column, level, seed)]


def _column(results: list[Result], level: float, seed: Seed) -> list[Standing]:
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
    _check_blocks(ranked, where)
    spans = _intervals(ranked, level, seed)
    p_values = _p_values(ranked, seed)
    leader = min(ranked, key=lambda result: result.loss, default=None)
    sign = 1 if first.lower_is_better else -1

    def better(one: Result, other: Result) -> bool:
        """Say whether a value is better by more than chance; by more than rounding, where chance is not known."""
        pair = frozenset((one.model, other.model))
        if pair not in p_values:
            return one.loss < other.loss and not tied(one.value, other.value)
        p_value = p_values[pair]
        if p_value is None or p_value > 1 - level:
            return False
        return sign * _score_in_blocks(one) < sign * _score_in_blocks(other)

    found = []
    for result in results:
        if result.source or leader is None:
            found.append(Standing(result=result))
            continue
        ahead = [other for other in ranked if better(other, result)]
        p_value = p_values.get(frozenset((result.model, leader.model)))
        blocks = result.blocks
        low, high = spans.get(result.model, (None, None))
        found.append(
            Standing(
                result=result,
                low=low,
                high=high,
                is_range=blocks is not None and blocks.n < MIN_BLOCKS_OF_INTERVAL,
                in_blocks=_score_in_blocks(result) if blocks is not None and blocks.left_out else None,
                behind=None if result is leader else _behind(result, leader),
                rank=1 + len(ahead),
                best=len(ranked) > 1 and tied(result.value, leader.value),
                worse=p_value is not None and leader in ahead,
                p_value=p_value,
            )
        )
    return found


def _check_blocks(results: Sequence[Result], where: str) -> None:
    """Raise the ValueError that names two models that differ in the number of sequences, or in their blocks."""
    known = [result for result in results if result.weight is not None]
    sizes = [np.asarray(result.weight).size for result in known]
    for other, size in zip(known[1:], sizes[1:], strict=True):
        if size != sizes[0]:  # of which fingerprints tell, where there are some
            raise ValueError(
                f"{where}: {known[0].model!r} and {other.model!r} are of {sizes[0]} and {size} sequences, so they "
                "cannot be compared"
            )
        weight, expected = np.asarray(other.weight), np.asarray(known[0].weight)
        if not np.allclose(weight, expected, rtol=_SAME_WEIGHT, atol=_SAME_WEIGHT * expected.max()):
            raise ValueError(
                f"{where}: {known[0].model!r} and {other.model!r} have sequences of different weights, so they cannot "
                "be compared: weights may depend on the ground truth alone"
            )
        if other.groups != known[0].groups:
            raise ValueError(
                f"{where}: {known[0].model!r} and {other.model!r} were scored in different blocks ({known[0].blocks}; "
                f"{other.blocks}), so they cannot be compared: measure them again, or give groups"
            )


def _intervals(results: Sequence[Result], level: float, seed: Seed) -> dict[str, tuple[float, float]]:
    """Return the interval of each model of which the sequences are known; the same blocks are drawn for all."""
    known = [result for result in results if result.numerator is not None]
    if not known:
        return {}
    numerators = np.stack([np.asarray(result.numerator) for result in known])
    weights = np.stack([np.asarray(result.weight) for result in known])
    low, high = ends(numerators, weights, Blocks(known[0].groups, weights), level=level, seed=seed)
    return {result.model: (float(low[i]), float(high[i])) for i, result in enumerate(known)}


def _score_in_blocks(result: Result) -> float:
    """Return the value of the sequences that are in blocks."""
    blocks = result.blocks
    if blocks is None or not blocks.left_out:
        return result.value
    return float(blocks.inside(np.asarray(result.numerator)) / blocks.inside(np.asarray(result.weight)))


def _difference(one: Result, other: Result) -> tuple[Float64, Float64] | None:
    """Return what each block adds to the difference, and to the weight; None where the sequences are not known."""
    if one.numerator is None or other.numerator is None or one.weight is None:
        return None
    blocks = Blocks(one.groups, one.weight)
    weight = blocks.sums(one.weight)
    counts = weight > 0
    return blocks.sums(one.numerator - other.numerator)[counts], weight[counts]


def _behind(result: Result, leader: Result) -> tuple[int, int] | None:
    parts = _difference(result, leader)
    if parts is None:
        return None
    sign = 1 if leader.lower_is_better else -1
    return int((sign * settled(*parts) > 0).sum()), len(parts[0])


def _p_values(results: Sequence[Result], seed: Seed) -> dict[frozenset[str], float | None]:
    """Return the p-value of every two results of which the sequences are known, by Holm's correction.

    None, of fewer blocks than can show a difference.
    """
    found: dict[frozenset[str], float | None] = {}
    for one, other in combinations(results, 2):
        if parts := _difference(one, other):
            enough = len(parts[0]) >= MIN_BLOCKS_OF_TEST
            found[frozenset((one.model, other.model))] = sign_flips(*parts, seed=seed).p_value() if enough else None
    tested = {pair: p_value for pair, p_value in found.items() if p_value is not None}
    return found | dict(zip(tested, holm(list(tested.values())), strict=True))


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


def check_truths(results: Iterable[Result]) -> None:
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


def notes(found: Sequence[Standing], *, level: float = 0.95, seed: Seed = 0) -> list[str]:
    """Say in words how intervals, marks and ranks were made, and where chance cannot be told from difference."""
    own = [standing for standing in found if not standing.result.source]
    tested = [standing for standing in own if standing.result.weight is not None]
    sources = dict.fromkeys(standing.result.source for standing in found if standing.result.source)
    aside = " of one's own" if sources else ""
    better = direction(higher_headings(found))
    lines = [f"{better[0].upper()}{better[1:]}. In bold, or with *: the best{aside} of a column."]
    lines += _units(found)
    if tested:
        lines += _of_chance(tested, aside, level, seed)
    lines += _still(tested)
    if any(standing.result.weight is None for standing in own):
        lines.append("Without intervals: numbers of which the single sequences are not known; ranked by value.")
    for method, n in dict.fromkeys((one.result.model, len(one.result.seeds)) for one in own if one.result.seeds):
        lines.append(f"{method}: the mean of {n} seeds; after 'seeds', the lowest and the highest of them.")
    if sources:
        lines.append(f"Published numbers, not ranked: {'; '.join(sources)}.")
    return lines


def higher_headings(found: Iterable[Standing]) -> list[str]:
    """Return the headings of the metrics of which higher is better."""
    return list(dict.fromkeys(one.result.heading for one in found if not one.result.lower_is_better))


def timed_headings(found: Iterable[Standing]) -> list[str]:
    """Return the headings of the metrics that have a column for each time: of a single one, tables print the times."""
    return list(dict.fromkeys(one.result.heading for one in found if one.result.time))


def _units(found: Sequence[Standing]) -> list[str]:
    """Say what is in which unit, and what the times are of."""
    timed, units = timed_headings(found), {one.result.heading: one.result.unit for one in found}
    lines = [f"{heading}: in {unit}." for heading, unit in units.items() if unit and [heading] != timed]
    if len(timed) == 1:
        unit = units[timed[0]]
        lines.insert(0, f"Under ms: {timed[0]}{f', in {unit}' if unit else ''}.")
    return lines


def _still(tested: Sequence[Standing]) -> list[str]:
    """Say of which sequences there is no Euler error."""
    euler = {one.result.action: one.result for one in tested if one.result.heading == EULER_ERROR.heading}
    weights = {action: np.asarray(result.weight) for action, result in euler.items()}
    return [
        f"{action or 'all'}: without an Euler error, since nothing moves in their ground truth: "
        f"{(weight == 0).sum()} of {len(weight)} sequences."
        for action, weight in weights.items()
        if (weight == 0).any()
    ]


def _of_chance(tested: Sequence[Standing], aside: str, level: float, seed: Seed) -> list[str]:
    """Say what the numbers beside values are, of each action, and what is inferred."""
    by_action: dict[str, list[Standing]] = {}
    for standing in tested:
        by_action.setdefault(standing.result.action, []).append(standing)
    lines = []
    if any(not standing.is_range for standing in tested):
        lines.append(f"Intervals: {100 * level:g} %, {METHOD}, {RESAMPLES} resamples, {seed_text(seed)}; {FOUND}.")
    if any(standing.is_range for standing in tested):
        lines.append(
            "Range: the lowest and the highest score of a block, of fewer than "
            f"{MIN_BLOCKS_OF_INTERVAL}, which support no interval."
        )
    if any(standing.in_blocks is not None for standing in tested):
        lines.append("Before a colon: the score of the sequences that are in blocks, which interval or range is about.")
    lines.append(
        f"{MARK} worse than the best{aside} by more than chance ({1 - level:.2g}; {TEST}; exact up to "
        f"{EXACT_UP_TO} blocks, else {SAMPLES} draws). Rank: 1 + the models that are better by more than chance."
    )
    if any(standing.behind and standing.behind[1] < MIN_BLOCKS_OF_TEST for standing in tested):
        lines.append(
            f"4/5, for example: the best{aside} is better in 4 of 5 blocks. Fewer than {MIN_BLOCKS_OF_TEST} blocks "
            "give no p-value and no mark."
        )
    described: dict[str, list[str]] = {}
    for action, found in by_action.items():
        described.setdefault(str(found[0].result.blocks), []).append(action or "all")
    lines += [f"{', '.join(actions)}: {blocks}." for blocks, actions in described.items()]
    for found in by_action.values():
        lines += _too_few(found, level)
    return [*lines, INFERRED]


def _too_few(tested: Sequence[Standing], level: float) -> list[str]:
    """Say so if there are too few blocks to show any difference between so many models."""
    first = tested[0].result
    models = sum(standing.result.column == first.column for standing in tested)
    pairs = math.comb(models, 2)
    n = Blocks(first.groups, np.asarray(first.weight)).n
    smallest = 2.0 ** (1 - n) if n <= EXACT_UP_TO else 1 / (SAMPLES + 1)
    if n < MIN_BLOCKS_OF_TEST or pairs * smallest <= 1 - level:
        return []
    return [
        f"{first.action or 'all'}: {counted(n, 'block')} cannot show any difference between {models} models: the "
        f"smallest possible p-value is {smallest:.2g}, and the {pairs} pairs ask for {(1 - level) / pairs:.2g}."
    ]
