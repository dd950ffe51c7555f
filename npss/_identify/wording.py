"""Put into words what a function computes."""

from __future__ import annotations

from npss._identify.choices import NOT_PART, TITLES, Choices
from npss._identify.finding import Found
from npss._identify.identification import Identification
from npss._identify.no_power import Rule
from npss._metric.explain import explain
from npss._metric.signature import signature

#: What must be otherwise, by axis, for a number that differs from `released` to be comparable with published tables.
_MUST = {
    "weight": "its weights must be the ground truth's total power",
    "aggregation": "it must average over the whole set",
    "factor": "it must have no constant factor",
    "mean": "it must keep the mean of a feature",
    "axis": "it must transform over frames",
}
_RELEASED = "the convention must be released"


def _differences(result: Identification) -> str:
    """Return what differs from the nearest named convention in one line."""
    words = [f"{TITLES[axis]}: {text}" if axis in TITLES else text for axis, text in result.differences.items()]
    return f"What differs: {'; '.join(words)}."


def _of_tables(result: Identification) -> list[str]:
    """Say whether the numbers are comparable with published tables."""
    convention = result.convention or result.custom or "paper"  # anything but `released` is as far from the tables
    lines = [line for line in explain(signature(convention)).splitlines() if line.startswith("NPSS: ")]
    if result.convention is None and result.nearest == "released":
        must = dict.fromkeys(_MUST.get(axis, _RELEASED) for axis in result.differences)
        lines = [line.replace(_RELEASED, "; ".join(must)) for line in lines]
    return lines


def text_of(result: Identification, found: Found, choices: Choices, example: str, rule: Rule, *, merges: bool) -> str:
    """Say what a function computes.

    `example`: what the example is. `rule`: that for features without power. `merges`: its batches can be merged.
    """
    nearest = result.nearest
    if result.convention:
        lines = [f"It computes `{result.convention}`."]
    else:
        lines = [f"It computes none of the named conventions; nearest: `{nearest}`.", _differences(result)]
    if result.no_power:
        lines.append(f"Without power: {result.no_power}.")
    order = f"({result.order.replace(',', ', ')})" if result.order else "two motions in any order"
    lines.append(f"It takes {order}, {found.form.words()}, and returns {found.returns}.")
    if not merges:
        lines.append("Its weights are normalised in each call, so batches cannot be merged.")
    left_out = [TITLES[axis] for axis in ("weight", "aggregation") if getattr(choices, axis) == NOT_PART]
    if left_out:
        lines.append(f"Not part of this function: {', '.join(left_out)}.")
    if result.example:  # pragma: no branch - every named function has one
        own, by_name = result.example
        lines.append(f"On one example ({example}): {own:.6g}; npss by `{nearest}`: {by_name:.6g}.")
    if result.call:
        but = "" if rule.usual else f", but for features without power{' and small motion' * rule.small}"
        lines.append(f"The same in npss{but}: {result.call}")
    else:
        lines.append("npss has no call for it.")
    if result.custom and not result.convention:
        lines.append(f"Its convention: {result.custom!r}")
    lines += _of_tables(result)
    if found.level != "set":
        lines.append("Published tables hold one score of a whole set, which the mean of these numbers is not.")
    return "\n".join(lines)
