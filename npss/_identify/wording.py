"""Put into words what a function computes."""

from __future__ import annotations

from typing import cast

from npss._identify.choices import NOT_PART, TITLES, Choices
from npss._identify.finding import Found
from npss._identify.identification import Identification
from npss._metric.convention import ConventionName
from npss._metric.explain import explain
from npss._metric.signature import signature


def _line(choices: Choices, nearest: ConventionName, extra: dict[str, str] | None = None) -> str:
    """Return what differs in one line."""
    differences = choices.differences(nearest) | (extra or {})
    if not differences:
        return f"`{nearest}`"
    words = [f"power: {choices.words('power')}"]
    for axis, text in differences.items():
        if axis != "power":
            words.append(text if axis not in TITLES or axis == "aggregation" else f"{TITLES[axis]}: {text}")
    return f"{'; '.join(words)}: none of the named conventions; nearest `{nearest}`"


def text_of(result: Identification, found: Found, choices: Choices, example: str, *, usual: bool, merges: bool) -> str:
    """Say what a function computes.

    `example`: what the example is. `usual`: the rule for features without power is among the choices. `merges`: its
    batches can be merged.
    """
    nearest = cast(ConventionName, result.nearest)
    extra = {axis: text for axis, text in result.differences.items() if axis not in TITLES}
    lines = [_line(choices, nearest, extra)]
    if result.convention:
        lines[0] += f"; {result.no_power}"
    elif result.no_power:
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
        but = "" if usual else ", but for features without power"
        lines.append(f"The same in npss{but}: {result.call}")
    else:
        lines.append("npss has no call for it.")
    if result.custom and not result.convention:
        lines.append(f"Its convention: {result.custom!r}")
    of_tables = result.convention or result.custom or "paper"  # anything but `released` is as far from the tables
    lines += [line for line in explain(signature(of_tables)).splitlines() if line.startswith("NPSS: ")]
    if found.level != "set":
        lines.append("Published tables hold one score of a whole set, which the mean of these numbers is not.")
    return "\n".join(lines)
