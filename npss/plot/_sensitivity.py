"""Draw the response of the Euler error and NPSS to distortions of the ground truth."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from npss._metric.registry import EULER_ERROR, NPSS
from npss.plot.style import COLOURS, SMALL, TINY, by_defaults, footnote, label, new_figure, tidy
from npss.validation import each

if TYPE_CHECKING:
    from matplotlib.figure import Figure


_NEEDED = ("distortion", "strength", "unit", "euler_error", "npss", "signatures")


@by_defaults
def sensitivity(rows: Sequence[Mapping[str, Any]]) -> Figure:
    """Draw the response of metrics to distortions: a column per distortion, a row per metric.

    Panels of a row share their axis, so that distortions can be compared. A distortion with a single record is a
    yardstick: a dashed line across the row.

    Parameters
    ----------
    rows : sequence of mapping
        Records as ``npss-baselines sensitivity --format json`` prints them: ``distortion``, ``strength``,
        ``unit``, ``euler_error``, ``npss`` by convention, and ``signatures`` by metric or convention.

    Returns
    -------
    matplotlib.figure.Figure
        A figure with one axes for each metric and distortion, row by row.

    Raises
    ------
    ImportError
        If matplotlib is missing.
    TypeError
        If a record is not a mapping.
    ValueError
        If no distortion has several strengths, a record lacks an entry, or its conventions differ from those of the
        first.

    Examples
    --------
    >>> import npss.plot
    >>> rows = [
    ...     {"distortion": "noise", "strength": x, "unit": "rad", "euler_error": 7 * x, "npss": {"paper": 20 * x**2}}
    ...     for x in (0, 0.1, 0.2)
    ... ]
    >>> signatures = {"euler_error": "euler_error|version:1", "paper": "npss|version:1|convention:paper"}
    >>> figure = npss.plot.sensitivity([row | {"signatures": signatures} for row in rows])
    >>> len(figure.axes)
    2
    """
    records = each("rows", rows, "records")
    metrics = _metrics(records)
    groups: dict[str, list[Mapping[str, Any]]] = {}
    for record in records:
        groups.setdefault(record["distortion"], []).append(record)
    distortions = {name: group for name, group in groups.items() if len(group) > 1}
    yardsticks = {name: group[0] for name, group in groups.items() if len(group) == 1}
    if not distortions:
        raise ValueError("rows: no distortion has several strengths")

    figure = new_figure(0.8 + 1.8 * len(distortions), 0.8 + 1.5 * len(metrics))
    panels = figure.subplots(len(metrics), len(distortions), squeeze=False, sharex="col", sharey="row")
    for row, (metric, heading) in enumerate(metrics.items()):
        for axes, (name, group) in zip(panels[row], distortions.items(), strict=True):
            ordered = sorted(group, key=lambda record: float(record["strength"]))
            strengths = [record["strength"] for record in ordered]
            values = [_value(record, metric) for record in ordered]
            axes.plot(strengths, values, color=COLOURS[0], linewidth=1.5, marker="o", markersize=3)
            for i, (yardstick, record) in enumerate(yardsticks.items(), 1):
                style = {"color": COLOURS[i % len(COLOURS)], "linewidth": 1, "linestyle": "--"}
                axes.axhline(_value(record, metric), **style, label=label(yardstick))
            if row == 0:
                axes.set_title(label(name), fontsize=SMALL + 1)
            if row == len(metrics) - 1:
                axes.set_xlabel(label(group[0]["unit"]), fontsize=SMALL)
            tidy(axes)
        panels[row, 0].set_ylim(bottom=0)
        panels[row, 0].set_ylabel(heading, fontsize=SMALL)
    if yardsticks:
        panels[0, 0].legend(frameon=False, fontsize=TINY)
    footnote(figure, *dict.fromkeys(records[0]["signatures"][metric] for metric in metrics))
    return figure


def _metrics(records: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Return the headings of the metrics in the records."""
    if not records:
        raise ValueError("rows: no records to draw")
    for i, record in enumerate(records):
        if not isinstance(record, Mapping):
            raise TypeError(f"rows: expected records, got {record!r} at index {i}")
        if missing := [name for name in _NEEDED if name not in record]:
            raise ValueError(f"rows: the record at index {i} lacks {', '.join(missing)}")
        if set(record["npss"]) != set(records[0]["npss"]):
            raise ValueError(f"rows: the conventions of the record at index {i} differ from those of the first")
    return {
        EULER_ERROR.name: EULER_ERROR.labelled,
        **{name: NPSS.column(convention=name) for name in records[0]["npss"]},
    }


def _value(record: Mapping[str, Any], metric: str) -> float:
    return float(record["euler_error"] if metric == EULER_ERROR.name else record["npss"][metric])
