"""Standings: ranks, p-values and ties."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import combinations

import numpy as np

from npss._analysis.blocks import INFERRED, Blocks, counted
from npss._analysis.bootstrap import METHOD, RESAMPLES, checked_level, seed_text
from npss._analysis.fingerprint import differing
from npss._analysis.holm import holm
from npss._analysis.interval import FOUND, MIN_BLOCKS_OF_INTERVAL, ends
from npss._analysis.sign_flip import EXACT_UP_TO, MIN_BLOCKS_OF_TEST, SAMPLES, settled, sign_flips
from npss._analysis.ties import tied
from npss._metric.registry import EULER_ERROR, direction
from npss.ranking._results import Result
from npss.validation import Float64, Seed

_SAME_WEIGHT = 0.01  # files hold ground truth in various precisions
#: The mark of a number significantly worse than the best.
MARK = "†"
#: The test behind it, as text for a table.
TEST = "paired sign-flip test over blocks, Holm's correction over all pairs of a column"


@dataclass(frozen=True, kw_only=True)
class Standing:
    """A result and its rank among those of the same action and column."""

    result: Result
    low: float | None = None  # lower end of the interval, or of the range if there are few blocks
    high: float | None = None
    is_range: bool = False
    in_blocks: float | None = None  # score of the sequences in blocks, if some are in none
    behind: tuple[int, int] | None = None  # number of blocks in which the best is better, and number of blocks
    rank: int | None = None  # 1 + number of better models; None for published and reference numbers
    best: bool = False
    worse: bool = False  # significantly worse than the best
    p_value: float | None = None  # of the difference from the best, corrected for the number of models


def standings(results: Sequence[Result], *, level: float = 0.95, seed: Seed = 0) -> list[Standing]:
    """Rank results within each action and column, each with its interval.

    Raises
    ------
    ValueError
        If two results differ in meaning or ground truth, or belong to the same model.
    """
    checked_level(level)
    kinds = {result.label: result.kind for result in results if result.source}
    if taken := [result.model for result in results if not result.source and result.model in kinds]:
        raise ValueError(f"{taken[0]!r} is the name of a {kinds[taken[0]]} model; rename yours")
    check_truths(results)
    columns: dict[tuple[str, str], list[Result]] = {}
    for result in results:
        columns.setdefault((result.action, result.column), []).append(result)
    return [standing for column in columns.values() for standing in _column(column, level, seed)]


def _column(results: list[Result], level: float, seed: Seed) -> list[Standing]:
    first = results[0]
    where = f"{first.action or 'all'}, {first.column}"
    for other in results[1:]:
        if not other.means_as(first):
            raise ValueError(
                f"{where}: {first.model!r} and {other.model!r} are different numbers, which cannot be ranked together: "
                f"{first.signature} and {other.signature}"
            )
    ranked = [result for result in results if not result.source]
    names = [result.label for result in results]
    if duplicates := [name for name in names if names.count(name) > 1]:
        raise ValueError(f"{where}: duplicate model {duplicates[0]!r}")
    _check_blocks(ranked, where)
    spans = _intervals(ranked, level, seed)
    p_values = _p_values(ranked, seed)
    leader = min(ranked, key=lambda result: result.loss, default=None)
    sign = 1 if first.lower_is_better else -1

    def better(first: Result, second: Result) -> bool:
        """Return whether a value is significantly better; without a test, whether it is better beyond rounding."""
        pair = frozenset((first.model, second.model))
        if pair not in p_values:
            return first.loss < second.loss and not tied(first.value, second.value)
        p_value = p_values[pair]
        if p_value is None or p_value > 1 - level:
            return False
        return sign * _score_in_blocks(first) < sign * _score_in_blocks(second)

    column = []
    for result in results:
        if result.source or leader is None:
            column.append(Standing(result=result))
            continue
        ahead = [other for other in ranked if better(other, result)]
        p_value = p_values.get(frozenset((result.model, leader.model)))
        blocks = result.blocks
        low, high = spans.get(result.model, (None, None))
        column.append(
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
    return column


def _check_blocks(results: Sequence[Result], where: str) -> None:
    """Raise a ValueError that names two models if they differ in the number, weights or blocks of sequences."""
    weighted = [result for result in results if result.weight is not None]
    sizes = [np.asarray(result.weight).size for result in weighted]
    for other, size in zip(weighted[1:], sizes[1:], strict=True):
        first = weighted[0]
        if size != sizes[0]:  # fingerprints show this, if there are any
            raise ValueError(
                f"{where}: {first.model!r} and {other.model!r} have {sizes[0]} and {size} sequences, so they cannot be "
                "compared"
            )
        weight, expected = np.asarray(other.weight), np.asarray(first.weight)
        if not np.allclose(weight, expected, rtol=_SAME_WEIGHT, atol=_SAME_WEIGHT * expected.max()):
            raise ValueError(
                f"{where}: {first.model!r} and {other.model!r} have sequences of different weights, so they cannot be "
                "compared: weights must depend on the ground truth alone"
            )
        if other.groups != first.groups:
            raise ValueError(
                f"{where}: {first.model!r} and {other.model!r} were scored in different blocks ({first.blocks}; "
                f"{other.blocks}), so they cannot be compared: measure them again, or give groups"
            )


def _intervals(results: Sequence[Result], level: float, seed: Seed) -> dict[str, tuple[float, float]]:
    """Return the interval of each model with single sequences; the same blocks are drawn for all."""
    weighted = [result for result in results if result.numerator is not None]
    if not weighted:
        return {}
    numerators = np.stack([np.asarray(result.numerator) for result in weighted])
    weights = np.stack([np.asarray(result.weight) for result in weighted])
    low, high = ends(numerators, weights, Blocks(weighted[0].groups, weights), level=level, seed=seed)
    return {result.model: (float(low[i]), float(high[i])) for i, result in enumerate(weighted)}


def _score_in_blocks(result: Result) -> float:
    """Return the value of the sequences in blocks."""
    blocks = result.blocks
    if blocks is None or not blocks.left_out:
        return result.value
    return float(blocks.inside(np.asarray(result.numerator)) / blocks.inside(np.asarray(result.weight)))


def _difference(one: Result, other: Result) -> tuple[Float64, Float64] | None:
    """Return what each block adds to the difference and to the weight; None without single sequences."""
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
    """Return the p-value of each pair of results with single sequences, by Holm's correction.

    It is None with fewer blocks than can show a difference.
    """
    p_values: dict[frozenset[str], float | None] = {}
    for one, other in combinations(results, 2):
        if parts := _difference(one, other):
            enough = len(parts[0]) >= MIN_BLOCKS_OF_TEST
            p_values[frozenset((one.model, other.model))] = sign_flips(*parts, seed=seed).p_value() if enough else None
    tested = {pair: p_value for pair, p_value in p_values.items() if p_value is not None}
    return p_values | dict(zip(tested, holm(list(tested.values())), strict=True))


def check_truths(results: Iterable[Result]) -> None:
    """Raise a ValueError that names two models if they were scored on different ground truth."""
    seen: dict[str, Result] = {}
    for result in results:
        if result.fingerprint is None:
            continue
        first = seen.setdefault(result.action, result)
        fingerprint = np.asarray(first.fingerprint)
        if len(fingerprint) != len(result.fingerprint):
            difference = f"{len(fingerprint)} and {len(result.fingerprint)} sequences"
        elif fingerprint.ndim != result.fingerprint.ndim:
            raise ValueError(
                f"{result.action or 'all'}: {first.model!r} and {result.model!r} cannot be compared: an older npss "
                "measured one of them, with other fingerprints of ground truths; measure it again"
            )
        elif (other := differing(fingerprint, result.fingerprint)).any():
            difference = f"sequence {int(other.argmax())} differs"
        else:
            continue
        raise ValueError(
            f"{result.action or 'all'}: {first.model!r} and {result.model!r} were scored on different ground truth "
            f"({difference}), so they cannot be compared"
        )


def notes(standings: Sequence[Standing], *, level: float = 0.95, seed: Seed = 0) -> list[str]:
    """Explain intervals, marks and ranks, and say which blocks are too few to show a difference."""
    own = [standing for standing in standings if not standing.result.source]
    tested = [standing for standing in own if standing.result.weight is not None]
    sources: dict[str, dict[str, None]] = {}
    for result in (standing.result for standing in standings if standing.result.source):
        sources.setdefault(result.kind, {})[result.source] = None
    best = "best" if not sources else "best unpublished" if "reference" not in sources else "best ranked"
    better = direction(higher_headings(standings))
    lines = [f"{better[0].upper()}{better[1:]}. In bold, or with *: the {best} number of a column."]
    lines += _units(standings)
    if tested:
        lines += _inference(tested, best, level, seed)
    lines += _still(tested)
    if any(standing.result.weight is None for standing in own):
        lines.append("Without intervals: numbers without single sequences; ranked by value.")
    methods = dict.fromkeys((standing.result.model, len(standing.result.seeds)) for standing in own)
    for method, n in methods:
        if n:
            lines.append(f"{method}: the mean of {n} seeds; after 'seeds', the lowest and the highest of them.")
    if any(standing.result.samples for standing in own):
        lines.append("After 'samples': the lowest and the highest score of one sample; intervals are over blocks.")
    lines += [f"{kind.capitalize()} numbers, not ranked: {'; '.join(of_kind)}." for kind, of_kind in sources.items()]
    return lines


def higher_headings(standings: Iterable[Standing]) -> list[str]:
    """Return the headings of metrics for which higher is better."""
    results = (standing.result for standing in standings)
    return list(dict.fromkeys(result.heading for result in results if not result.lower_is_better))


def timed_headings(standings: Iterable[Standing]) -> list[str]:
    """Return the headings of metrics with a column for each time; if there is only one, tables print the times."""
    return list(dict.fromkeys(standing.result.heading for standing in standings if standing.result.time))


def _units(standings: Sequence[Standing]) -> list[str]:
    """State the unit of each metric, and the metric measured at times."""
    timed, units = timed_headings(standings), {item.result.heading: item.result.unit for item in standings}
    lines = [f"{heading}: in {unit}." for heading, unit in units.items() if unit and [heading] != timed]
    if len(timed) == 1:
        unit = units[timed[0]]
        lines.insert(0, f"Under ms: {timed[0]}{f', in {unit}' if unit else ''}.")
    return lines


def _still(tested: Sequence[Standing]) -> list[str]:
    """State the number of sequences without an Euler error."""
    euler = {one.result.action: one.result for one in tested if one.result.heading == EULER_ERROR.heading}
    weights = {action: np.asarray(result.weight) for action, result in euler.items()}
    return [
        f"{action or 'all'}: no Euler error for {(weight == 0).sum()} of {len(weight)} sequences, "
        "since nothing moves in the ground truth."
        for action, weight in weights.items()
        if (weight == 0).any()
    ]


def _inference(tested: Sequence[Standing], best: str, level: float, seed: Seed) -> list[str]:
    """Explain the numbers beside values, the marks and ranks, and the blocks of each action."""
    by_action: dict[str, list[Standing]] = {}
    for standing in tested:
        by_action.setdefault(standing.result.action, []).append(standing)
    lines = []
    if any(not standing.is_range for standing in tested):
        lines.append(f"Intervals: {100 * level:g} %, {METHOD}, {RESAMPLES} resamples, {seed_text(seed)}; {FOUND}.")
    if any(standing.is_range for standing in tested):
        lines.append(
            f"Range: the lowest and the highest score of a block; fewer than {MIN_BLOCKS_OF_INTERVAL} blocks support "
            "no interval."
        )
    if any(standing.in_blocks is not None for standing in tested):
        lines.append("Before a colon: the score of the sequences in blocks, to which the interval or range applies.")
    lines.append(
        f"{MARK} significantly worse than the {best} ({1 - level:.2g}; {TEST}; exact up to {EXACT_UP_TO} blocks, "
        f"else {SAMPLES} draws). Rank: 1 + the number of significantly better models."
    )
    if any(standing.behind and standing.behind[1] < MIN_BLOCKS_OF_TEST for standing in tested):
        lines.append(
            f"4/5, for example: the {best} is better in 4 of 5 blocks. Fewer than {MIN_BLOCKS_OF_TEST} blocks "
            "give no p-value and no mark."
        )
    actions_of: dict[str, list[str]] = {}
    for action, standings in by_action.items():
        actions_of.setdefault(str(standings[0].result.blocks), []).append(action or "all")
    lines += [f"{', '.join(actions)}: {blocks}." for blocks, actions in actions_of.items()]
    for standings in by_action.values():
        lines += _too_few(standings, level)
    return [*lines, INFERRED]


def _too_few(tested: Sequence[Standing], level: float) -> list[str]:
    """Warn if there are too few blocks to show any difference between the models."""
    first = tested[0].result
    models = sum(standing.result.column == first.column for standing in tested)
    pairs = math.comb(models, 2)
    n = Blocks(first.groups, np.asarray(first.weight)).n
    smallest = 2.0 ** (1 - n) if n <= EXACT_UP_TO else 1 / (SAMPLES + 1)
    if n < MIN_BLOCKS_OF_TEST or pairs * smallest <= 1 - level:
        return []
    return [
        f"{first.action or 'all'}: {counted(n, 'block')} cannot show any difference between {models} models: the "
        f"smallest possible p-value is {smallest:.2g}, and {pairs} pairs require {(1 - level) / pairs:.2g}."
    ]
