"""Say what a function computes: what of the choices that fit differs from the named conventions."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from npss._identify import no_power, search
from npss._identify.calling import Subject, readings, sum_of_weights
from npss._identify.choices import NOT_PART, TITLES, Choices
from npss._identify.compute import Numbers, columns, size_of, spectra
from npss._identify.finding import Found, advice
from npss._identify.identification import Identification
from npss._identify.no_power import Rule
from npss._identify.probes import Probe, batches, unusual
from npss._identify.wording import text_of
from npss._metric.convention import ConventionName
from npss._metric.score import score

_FIELDS = ("power", "bins", "distance", "weight")  # of `npss.Convention`, beside its rule for zeros
_BATCHES = (8, 16, 32, 50, 64, 100, 128)  # usual sizes


def identification(subject: Subject, found: Found) -> Identification:
    """Say what a function computes, given the choices that fit."""
    choices = found.fits[0]
    rule, scale = _rules(subject, found, choices)
    batched = False
    if found.form.of_one:
        choices = choices._replace(aggregation="unknown")
    elif subject.is_class and not found.form.single and found.level == "set":
        choices = choices._replace(aggregation=_over_updates(subject, found))
        batched = choices.aggregation != found.fits[0].aggregation
    on_unusual = _on_unusual(subject, found)
    many = "aggregation" in on_unusual
    choices = choices._replace(aggregation=on_unusual.pop("aggregation", choices.aggregation))
    nearest = choices.nearest()
    example = _example(subject, found, nearest, batched=batched, many=many)
    differences = choices.differences(nearest) | on_unusual
    if scale:
        differences["scale"] = scale
    if len(found.fits) > 1:
        first, *others = found.fits
        changes = [
            ", ".join(f"{TITLES[axis]}: {other.words(axis)}" for axis in other._fields if _differ(axis, other, first))
            for other in others
        ]
        differences["precision"] = f"the function is too coarse to tell, or else {'; or '.join(changes)}"
    own = {axis for axis in differences if axis not in _FIELDS}
    custom = None if own or choices.weight in ("pred", NOT_PART) else choices.convention(rule.zero)
    result = Identification(
        convention=None if differences else nearest,
        nearest=nearest,
        differences=differences,
        choices={axis: choices.words(axis) for axis in choices._fields},
        no_power=rule.words,
        order=subject.order,
        custom=custom,
        call=None if {"scale", "motion", "precision"} & differences.keys() else choices.call(rule.zero),
        example=(example.own, example.named),
    )
    merges = not _normalises_weights(subject, found)
    return replace(result, text=text_of(result, found, choices, example.words, rule, merges=merges))


def _differ(axis: str, choices: Choices, other: Choices) -> bool:
    return bool(getattr(choices, axis) != getattr(other, axis))


def _over_updates(subject: Subject, found: Found) -> str:
    """Return how a class combines batches."""
    whole, sizes = batches(found.form.frame)
    try:
        value = _values(subject, found, whole, sizes)
    except Exception:  # pragma: no cover - a class that refuses batches of other sizes
        return "batches"
    return _aggregation(value, whole, sizes, found) or "batches"


def _on_unusual(subject: Subject, found: Found) -> dict[str, str]:
    """Return what differs for unusual motion, in words, by choice."""
    choices = found.fits[0]
    differences: dict[str, str] = {}
    for what, probe in unusual(found.form.frame, found.form.wider).items():
        expected = _expected(probe, choices)
        # Motion that is constant has no power without its mean.
        if (what == "many sequences" and found.form.single) or not np.isfinite(expected).all():
            continue
        try:
            value = _values(subject, found, probe)
            most = _tolerance(subject, found, probe, value)
        except Exception:  # it may refuse it
            continue
        if search.close(value, expected, most):
            continue
        if what == "many sequences" and found.level == "set":
            sizes = (_equal(len(probe.gt), size) for size in _BATCHES)
            fitting = (_aggregation(value, probe, each, found) for each in sizes)
            differences["aggregation"] = next(filter(None, fitting), "unknown")
        else:
            differences["motion"] = f"{what} get another score: {_both(value, expected)}"
    return differences


def _tolerance(subject: Subject, found: Found, probe: Probe, value: Numbers) -> float:
    """Return the relative difference that rounding explains on a large probe, where sums have more terms."""
    if found.tolerance <= search.LEAST:
        return found.tolerance
    again = [_values(subject, found, other) for other in search.scaled([probe])]
    own = search.tolerances([value], again)
    return found.tolerance if own is None else max(found.tolerance, float(own[0]))


def _equal(total: int, size: int) -> tuple[int, ...]:
    """Return the sizes of batches of equal size, but for the last."""
    return (*[size] * (total // size), *[total % size] * (total % size > 0))


def _aggregation(value: Numbers, whole: Probe, sizes: Sequence[int], found: Found) -> str | None:
    """Return how the scores of batches are combined, or None if in no known way."""
    choices = found.fits[0]
    edges = np.cumsum([0, *sizes])
    of_parts = [
        _expected(whole._replace(gt=whole.gt[start:stop], pred=whole.pred[start:stop]), choices)
        for start, stop in pairwise(edges)
    ]
    of_batch = "" if choices.aggregation == "set" else f"{choices.aggregation}-"  # means of ratios, no ratio
    candidates = {
        choices.aggregation: _expected(whole, choices),
        f"{of_batch}batch": np.mean(of_parts, axis=0),
        f"{of_batch}batch-size": np.average(of_parts, axis=0, weights=sizes),
        f"{of_batch}last": of_parts[-1],
    }
    fitting = (name for name, expected in candidates.items() if search.close(value, expected, found.tolerance))
    return next(fitting, None)


def _values(subject: Subject, found: Found, probe: Probe, sizes: Sequence[int] = ()) -> Numbers:
    """Return the function's values of a probe, as they were read."""
    outputs = subject(probe, found.form, sizes)
    single = found.form.single and not subject.is_class
    return readings([outputs], [probe], single=single)[found.level, found.returns][0]


def _expected(probe: Probe, choices: Choices) -> Numbers:
    """Return the numbers of a combination of choices for a probe."""
    of = columns(spectra(probe.gt, probe.pred, probe.frame, choices), choices)
    return np.ravel(search.value_of(of, choices)) * choices.factor.of(*size_of(probe.gt.shape))


def _normalises_weights(subject: Subject, found: Found) -> bool:
    """Return whether a function returns distances and weights that do not grow with the motion."""
    if "weights" not in found.returns or found.fits[0].weight == "uniform":
        return False
    probe = found.probes[0]
    sums = [sum_of_weights(subject(each, found.form)[0]) for each in (probe, probe.scaled(2, 2))]
    return search.close(sums[1], sums[0], found.tolerance)


def _rules(subject: Subject, found: Found, choices: Choices) -> tuple[Rule, str | None]:
    """Return the rule for features without power, and how scores depend on the scale of the motion if they do."""
    probe = found.probes[0]

    def value_of(other: Probe) -> Numbers | str:
        try:
            return _values(subject, found, other)
        except Exception as error:
            return f"raises {type(error).__name__}"

    rule = no_power.rule_of(
        [value_of(each) for each in no_power.silent(probe, choices)], probe, choices, found.tolerance
    )
    small = [probe.scaled(size, size) for size in no_power.small(found.tolerance)]
    loud = [probe.scaled(size, size) for size in no_power.large(found.tolerance)]
    of_small, of_large = ([value_of(each) for each in probes] for probes in (small, loud))
    if (other := _other(of_small, found)) is not None:
        numbers = [value for value in of_small if not isinstance(value, str)]
        epsilon = None
        if len(numbers) == len(small):  # pragma: no branch - else it fails for some small motion
            epsilon = no_power.epsilon_of(numbers, small, choices, found.tolerance)
        if epsilon is None:
            return rule, f"small motion gets another score: {other}"
        rule = Rule(f"{rule.words}; {epsilon}, so small motion gets another score", rule.zero, small=True)
    if (other := _other(of_large, found)) is not None:
        return rule, f"large motion gets another score: {other}"
    return rule, None


def _other(values: Sequence[Numbers | str], found: Found) -> str | None:
    """Return the last of the values that differs from that of the first probe, in words, or None."""
    expected = found.values[0]
    for value in values[::-1]:
        if isinstance(value, str):
            return value
        if not search.close(value, expected, found.tolerance):
            return _both(value, expected)
    return None


def _both(value: Numbers, expected: Numbers) -> str:
    return f"{value.flat[0]:.4g} instead of {expected.flat[0]:.4g}"


class _Example(NamedTuple):
    """The function's value of one example, the score by a named convention, and what the example is."""

    own: float
    named: float
    words: str


def _example(subject: Subject, found: Found, name: ConventionName, *, batched: bool, many: bool) -> _Example:
    """Return the first example; of a function that averages batches, one with several."""
    probe, value = found.probes[0], found.values[0]
    sizes: Sequence[int] = ()
    if batched or many:
        whole, of_batches = batches(found.form.frame)
        other = whole if batched else unusual(found.form.frame, found.form.wider)["many sequences"]
        try:
            value = _values(subject, found, other, of_batches if batched else ())
            probe, sizes = other, of_batches if batched else ()
        except Exception:  # pragma: no cover - a class that refuses batches of other sizes
            pass
    gt, pred, _ = probe
    n, t, d = gt.shape
    words = f"{n} sequences{f' in batches of {sizes[0]} and {sizes[1]}' if sizes else ''}, {t} frames of {d} features"
    if found.level == "sequence":
        gt, pred, words = gt[:1], pred[:1], f"1 sequence, {t} frames of {d} features"
    if found.level == "column":
        gt, pred, words = gt[:1, :, :1], pred[:1, :, :1], f"1 feature of 1 sequence, {t} frames"
    return _Example(float(value.flat[0]), score(gt, pred, convention=name), words)


def _digits(values: Sequence[Numbers]) -> int | None:
    """Return the decimal places to which all values are rounded, or None if they have more than five."""
    numbers = np.concatenate([np.ravel(value) for value in values])
    return next((n for n in range(6) if np.array_equal(numbers, np.round(numbers, n))), None)


def no_npss(subject: Subject, found: Found) -> Identification:
    """Say why a function is no NPSS."""
    probe = found.probes[0]
    value = found.values[0]
    faults = []
    if not np.isfinite(np.concatenate([np.ravel(value) for value in found.values])).all():
        faults.append("it is not finite for ordinary motion")
    elif not any(value.any() for value in found.values):
        faults.append("it is 0 for all motions")
    else:
        changed = {
            "it is not 0 for equal motions": (probe._replace(pred=probe.gt), 0.0 * value),
            "it changes with the scale of both motions": (probe.scaled(2, 2), value),
            "it changes with the scale of the prediction": (probe.scaled(1, 2), value),
        }
        size = float(np.abs(value).mean()) or 1.0
        for fault, (other, expected) in changed.items():
            try:
                of = _values(subject, found, other)
            except Exception:  # pragma: no cover - it refuses such motion
                continue
            change = float(np.abs(of - expected).max()) / size
            if not change <= found.tolerance:
                faults.append(f"{fault}, by {change:.2g} of its value")
        if not faults and (digits := _digits(found.values)) is not None:
            faults.append(
                f"its numbers are rounded to {digits} decimal places; pass a function that returns all digits"
            )
    reasons = (
        "; ".join(faults) or "it is 0 for equal motions and ignores scale, as an NPSS does, but its numbers differ"
    )
    axes = ", ".join(TITLES.values())
    text = (
        f"It computes no NPSS: the values of {subject.name} fit no combination of the choices of public functions "
        f"({reasons}).\n"
        f"The choices tried are of {axes}. It was called with {found.form.words()}."
    )
    if found.refused:
        text += f"\nIt does not take {found.refused}; {advice(None)}."
    return Identification(convention=None, nearest=None, order=subject.order, text=text)
