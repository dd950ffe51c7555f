"""Find the combinations of choices whose numbers are those of a function."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

import numpy as np

from npss._identify import choices as combinations
from npss._identify.choices import FACTORS, Choices, Factor
from npss._identify.compute import (
    Columns,
    Numbers,
    columns,
    features,
    score_of_sequences,
    score_of_set,
    size_of,
    spectra,
    weights,
)
from npss._identify.probes import Probe, ordinary
from npss.validation import Float64

#: Relative differences below it are none: the effect of the small epsilons of public code on ordinary motion.
LEAST = 1e-6
#: A function whose values scatter by more under a change of scale is not one of normalised spectra.
MOST = 0.1
_EXACT = (0.5, 2.0)  # powers of two, by which rounding does not change: other changes are none of rounding
_ROUNDED = (0.7, 1.3, 1.9)
_SPREAD = 6.0  # tolerance, in largest scatters seen
_COARSE = {8: 8e-3, 11: 1e-3, 24: 1e-5}  # tolerance by the binary digits of values: bfloat16, float16, float32


class Match(NamedTuple):
    """A combination of choices that fits, and its largest difference, relative to the tolerance."""

    choices: Choices
    residual: float


class Table(NamedTuple):
    """The numbers of every combination on some probes."""

    choices: list[Choices]
    values: Float64  # (combinations, numbers of all probes)
    probe: list[int]  # of each number


def scaled(probes: Sequence[Probe]) -> list[Probe]:
    """Return probes on other scales, to see the rounding of a function."""
    return [probe.scaled(scale, scale) for scale in (*_EXACT, *_ROUNDED) for probe in probes]


def tolerances(values: Sequence[Numbers], again: Sequence[Numbers]) -> Float64 | None:
    """Return the relative difference that a function's rounding explains, for each probe; None if it depends on scale.

    `again` holds its values for `scaled` probes. Infinite for a probe on which rounding leaves nothing.
    """
    repeated = len(again) // len(values) * [*values]
    changes = [float(_relative(value, other).max()) for value, other in zip(again, repeated, strict=True)]
    by_scale = np.reshape(changes, (-1, len(values)))
    exact, scatter = by_scale[: len(_EXACT)], by_scale[len(_EXACT) :].max(axis=0)
    if exact.max() > MOST or np.median(scatter) > MOST:
        return None
    if exact.max() > LEAST:
        return np.full(len(values), LEAST)
    fractions = np.frexp(np.concatenate([np.ravel(value) for value in values]))[0]
    coarse = (most for digits, most in _COARSE.items() if (fractions * 2.0**digits % 1 == 0).all())
    # A small scatter may be luck, where it is larger on other probes.
    most = np.maximum(_SPREAD * np.maximum(scatter, np.median(scatter)), max(LEAST, next(coarse, 0.0)))
    return np.asarray(np.where(scatter > MOST, np.inf, most))


def _relative(value: Numbers, expected: Numbers) -> Float64:
    size = np.maximum(np.abs(expected), 1e-2 * np.abs(expected).mean())
    difference = np.abs(value - expected) / size
    return np.asarray(np.where(np.isfinite(difference), difference, np.inf))


def matches(values: Sequence[Numbers], table: Table, probes: Sequence[Probe], most: Float64) -> list[Match]:
    """Return the combinations that fit the values of a function, up to a relative difference for each probe."""
    own = np.concatenate([np.ravel(value) for value in values])
    if own.size != table.values.shape[1] or not np.isfinite(own).all():  # pragma: no cover - another form of results
        return []
    at_most = most[table.probe]
    some = np.isfinite(at_most)
    own, at_most = own[some], at_most[some]
    found: list[Match] = []
    for factor in FACTORS:
        sizes = np.array([factor.of(*size_of(probes[index].gt.shape)) for index in table.probe])
        expected = (table.values * sizes)[:, some]
        size = np.maximum(np.abs(expected), 1e-2 * np.abs(expected).mean(axis=1, keepdims=True))
        number = (expected * own / size**2).sum(axis=1) / (expected**2 / size**2).sum(axis=1)
        number = np.where(np.abs(number - 1) <= at_most.max(), 1.0, number)[:, np.newaxis]
        residual = (np.abs(own - number * expected) / (number * size * at_most)).max(axis=1)
        found += [
            Match(
                table.choices[index]._replace(factor=factor._replace(number=float(number[index, 0]))),
                float(residual[index]),
            )
            for index in np.flatnonzero((residual <= 1) & (number[:, 0] > 0))
        ]
    return found


def distinct(found: Sequence[Match]) -> list[Choices]:
    """Return the choices that fit, the simplest factor of each function first."""
    ordered = sorted(found, key=lambda match: (_complexity(match.choices.factor), match.residual))
    if ordered and ordered[0].choices.factor.number == 1:  # others fit only with an odd factor
        ordered = [match for match in ordered if match.choices.factor.number == 1]
    kept: dict[Choices, Choices] = {}
    for match in ordered:
        kept.setdefault(match.choices._replace(factor=Factor()), match.choices)
    return list(kept.values())


def close(value: Numbers, expected: Numbers, most: float) -> bool:
    """Return whether numbers are equal but for rounding."""
    value, expected = np.ravel(value), np.ravel(expected)
    return value.size == expected.size and bool((_relative(value, expected) <= most).all())


def _complexity(factor: Factor) -> int:
    """Count what a factor consists of; a number that is not 1 counts most."""
    return 4 * (factor.number != 1) + sum(map(abs, factor[1:]))


def tables(level: str, frame: tuple[int, ...], wider: tuple[int, ...]) -> Iterator[list[Table]]:
    """Yield the numbers of every combination on the ordinary probes, for one axis of the transform after the other."""
    flat = (features(frame),), (features(wider),)
    yield from (_tables(level, axis, *flat) for axis in ("time", "features", "mixed"))
    if len(frame) > 1:  # the same motion, with components
        yield _tables(level, "components", frame, wider)


@lru_cache(maxsize=24)
def _tables(level: str, axis: str, frame: tuple[int, ...], wider: tuple[int, ...]) -> list[Table]:
    """Return the numbers of every combination; those in one table give as many."""
    rows: dict[tuple[int, ...], list[tuple[Choices, list[Float64]]]] = {}
    for combination, values in _values(level, ordinary(frame, wider), axis):
        rows.setdefault(tuple(value.size for value in values), []).append((combination, values))
    found = []
    for counts, row in rows.items():
        numbers = np.array([np.concatenate([value.ravel() for value in values]) for _, values in row])
        usable = np.isfinite(numbers).all(axis=1)
        kept = [combination for (combination, _), good in zip(row, usable, strict=True) if good]
        found.append(Table(kept, numbers[usable], [i for i, count in enumerate(counts) for _ in range(count)]))
    return found


def _values(level: str, probes: Sequence[Probe], axis: str) -> Iterator[tuple[Choices, list[Float64]]]:
    several = {"column": lambda found: [found], "sequence": combinations.of_sequences, "set": combinations.of_sets}
    for of_columns in combinations.of_columns(axis):
        found = [columns(spectra(probe.gt, probe.pred, probe.frame, of_columns), of_columns) for probe in probes]
        for combination in several[level](of_columns):
            yield combination, [value_of(each, combination) for each in found]


def value_of(of: Columns, combination: Choices, plus: float = 0.0) -> Float64:
    """Return the score of a set, or of each sequence if aggregation is not part of the choices.

    Without weights, return the distances.
    """
    if combination.weight == combinations.NOT_PART:
        return of.distance
    weight = weights(of, combination)
    if combination.aggregation == combinations.NOT_PART:
        return score_of_sequences(of.distance, weight, plus)
    return np.array(score_of_set(of.distance, weight, combination.aggregation, plus))
