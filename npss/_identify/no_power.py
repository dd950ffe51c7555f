"""What a function does where a feature has no power: it is zero, or as small as an epsilon in a denominator."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import NamedTuple

import numpy as np

from npss._identify.choices import Choices, Factor
from npss._identify.compute import Columns, Numbers, Spectra, distances, size_of, spectra
from npss._identify.probes import Probe
from npss._identify.search import close, value_of
from npss.validation import Float64

_COARSE = 1e-3  # the tolerance of functions that may compute in float16, which has a small range
_EPSILONS = (
    *(10.0**-exponent for exponent in range(3, 17)),
    float(np.finfo(np.float32).eps),
    float(np.finfo(float).eps),
)
_COLUMN = 1  # without power

_DISTANCES = {
    "empty": "an empty distribution (0/0 -> 0)",
    "dc": "a constant pose",
    "zero": "a perfect prediction",
    "skipped": "",
}
_NONE = "does not count"


class Rule(NamedTuple):
    """A rule in words, and as a choice of `npss.Convention`, if the rule for predictions is one."""

    words: str
    zero: str | None = None
    usual: bool = False  # whether `zero` says it all, as npss scores
    small: bool = False  # whether small motion counts as such, too


class _Case(NamedTuple):
    """Which motions have no power, and that in words."""

    motions: tuple[str, ...]
    subject: str


_CASES = (
    _Case(("pred",), "a prediction without power"),
    _Case(("gt",), "a ground truth without power"),
    _Case(("gt", "pred"), "a feature without power in both"),
)


def small(most: float) -> list[float]:
    """Return scales, for a tolerance, that are so small that epsilons of public code show: powers of 1/4, exact."""
    return [2.0**-exponent for exponent in range(4, 10 if most > _COARSE else 28, 2)]


def large(most: float) -> list[float]:
    """Return large scales of motion for a tolerance."""
    return [2.0**8] if most > _COARSE else [2.0**8, 2.0**20]


def silent(probe: Probe, choices: Choices) -> list[Probe]:
    """Return the probes of all cases: a column is zero in the prediction, in the ground truth, in both."""
    place = (slice(None), slice(None), _COLUMN) if choices.axis == "time" else (slice(None), _COLUMN)
    probes = []
    for case in _CASES:
        motions = {"gt": probe.gt.copy(), "pred": probe.pred.copy()}
        for name in case.motions:
            motions[name][place] = 0.0
        probes.append(Probe(motions["gt"], motions["pred"], probe.frame))
    return probes


def rule_of(values: Sequence[Numbers | str], probe: Probe, choices: Choices, most: float) -> Rule:
    """Say what a function does in each case; `values` are its numbers, or the name of an error."""
    if choices.axis not in ("time", "features"):
        return Rule("")  # hardly any column is without power
    found = [
        _explained(value, case, each, choices, most)
        for value, case, each in zip(values, _CASES, silent(probe, choices), strict=True)
    ]
    words = [each.words for each in found]
    if len(set(words)) == 1 and words[0] in ("nan", *(value for value in values if isinstance(value, str))):
        return Rule(f"{words[0]} where a feature has no power")
    if words[1] == words[2] == _NONE:
        return Rule(f"{_CASES[0].subject} {words[0]}", found[0].zero, usual=found[0].zero is not None)
    return Rule("; ".join(f"{case.subject} {text}" for case, text in zip(_CASES, words, strict=True)), found[0].zero)


def _explained(value: Numbers | str, case: _Case, probe: Probe, choices: Choices, most: float) -> Rule:
    if isinstance(value, str):
        return Rule(value)
    if np.isnan(value).any():
        return Rule("nan")
    factor = _factor(choices, probe)
    for words, zero, expected in _treatments(case, probe, choices):
        if expected.size == value.size and close(value, np.ravel(expected) * factor, most):
            return Rule(words, zero)
    return Rule("counts in an unknown way")  # pragma: no cover - none of the treatments that were ever seen


def _treatments(case: _Case, probe: Probe, choices: Choices) -> Iterator[tuple[str, str | None, Float64]]:
    """Yield ways to treat columns without power: words, the choice of `npss.Convention`, and the score."""
    powers = spectra(probe.gt, probe.pred, probe.frame, choices)
    totals = [power.sum(axis=-1) for power in powers]
    normalised = [
        np.divide(power, total[..., np.newaxis], out=np.zeros_like(power), where=total[..., np.newaxis] != 0)
        for power, total in zip(powers, totals, strict=True)
    ]
    at_dc = [spectrum.copy() for spectrum in normalised]
    for spectrum, total in zip(at_dc, totals, strict=True):
        spectrum[..., 0] = np.where(total == 0, 1.0, spectrum[..., 0])
    column = np.zeros(totals[0].shape, bool)
    column[:, _COLUMN] = True
    both = len(case.motions) == 2
    for name in ("skipped", "empty", "dc", "zero"):  # pragma: no branch - a caller stops at the first that fits
        first, second = at_dc if name == "dc" else normalised
        distance = distances(first, second, choices.distance)
        if name == "zero":
            distance[column] = 0.0
        own = Columns(distance, *totals)
        if name == "skipped":
            if choices.weight != "not part":  # pragma: no branch - then no column is left out
                kept = [part[:, ~column[0]] for part in own]
                yield _NONE, None, value_of(Columns(*kept), choices)
            continue
        counts = "counts" if both else f"counts as {_DISTANCES[name]}"
        yield counts, name if name in ("empty", "dc") else None, value_of(own, choices)
        if choices.weight not in ("uniform", "not part"):  # a total of 0 replaced by 1, in the weights too
            of_one = [np.where(total == 0, 1.0, total) for total in totals]
            yield f"{counts}, with the weight 1", None, value_of(Columns(distance, *of_one), choices)


def epsilon_of(values: Sequence[Numbers], probes: Sequence[Probe], choices: Choices, most: float) -> str | None:
    """Return the epsilon that explains a function's numbers for small probes, in words, or None."""
    powers = [spectra(probe.gt, probe.pred, probe.frame, choices) for probe in probes]
    factor = _factor(choices, probes[0])
    for words, model in _MODELS.items():
        for epsilon in _EPSILONS:
            expected = (
                value_of(own, choices, plus) for own, plus in (model(each, epsilon, choices) for each in powers)
            )
            if all(close(value, np.ravel(own) * factor, most) for value, own in zip(values, expected, strict=True)):
                return f"an epsilon of {epsilon:.3g} {words}"
    return None


_Model = Callable[[Spectra, float, Choices], tuple[Columns, float]]


def _normalised(powers: Spectra, denominators: Sequence[Numbers], choices: Choices) -> Float64:
    first, second = (power / below[..., np.newaxis] for power, below in zip(powers, denominators, strict=True))
    return distances(first, second, choices.distance)


def _model(
    denominator: Callable[[Numbers, float], Numbers], *, weighted: bool = False, plus: bool = False, bins: bool = False
) -> _Model:
    def model(powers: Spectra, epsilon: float, choices: Choices) -> tuple[Columns, float]:
        if bins:
            powers = Spectra(powers.gt + epsilon, powers.pred + epsilon)
        totals = [power.sum(axis=-1) for power in powers]
        denominators = [denominator(total, epsilon) for total in totals]
        distance = _normalised(powers, denominators, choices)
        return Columns(distance, *(denominators if weighted else totals)), epsilon if plus else 0.0

    return model


def _plain(total: Numbers, epsilon: float) -> Numbers:
    return total


def _added(total: Numbers, epsilon: float) -> Numbers:
    return total + epsilon


def _floored(total: Numbers, epsilon: float) -> Numbers:
    return np.where(np.abs(total) > epsilon, total, epsilon)


def _replaced(total: Numbers, epsilon: float) -> Numbers:
    return np.where(np.abs(total) > epsilon, total, 1.0)


_MODELS: dict[str, _Model] = {
    "added to total powers": _model(_added),
    "added to total powers, in the weights too": _model(_added, weighted=True),
    "added to total powers and to the sum of weights": _model(_added, plus=True),
    "added to total powers, in the weights too, and to the sum of weights": _model(_added, weighted=True, plus=True),
    "added to the sum of weights": _model(_plain, plus=True),
    "as the least total power": _model(_floored),
    "as the least total power, in the weights too": _model(_floored, weighted=True),
    "below which a total power counts as 1": _model(_replaced),
    "below which a total power counts as 1, in the weights too": _model(_replaced, weighted=True),
    "added to each bin": _model(_plain, bins=True, weighted=True),
}


def _factor(choices: Choices, probe: Probe) -> float:
    factor: Factor = choices.factor
    return factor.of(*size_of(probe.gt.shape))
