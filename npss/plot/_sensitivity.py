"""How the Euler error and NPSS answer to distortions of the ground truth."""

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
    """Draw how metrics answer to distortions: a column for each distortion, a row for each metric.

    Panels of a row share their axis, so distortions can be compared. A distortion of which there is one record only is
    a yardstick: a dashed line across its row.

    Parameters
    ----------
    rows : sequence of mapping
        Records as ``npss-baselines sensitivity --format json`` prints them: ``distortion``, ``strength``,
        ``unit``, ``euler_error``, ``npss`` by convention, and ``signatures`` by metric or convention.

    Returns
    -------
    matplotlib.figure.Figure
        With one axes for each metric and distortion, row by row.

    Raises
    ------
    ImportError
        Without matplotlib.
    TypeError
        If a record is no mapping.
    ValueError
        If there is no distortion of several strengths, or a record lacks an entry or has other conventions than the
        first one.

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
        raise ValueError("rows: no distortion of several strengths")

    figure = new_figure(0.8 + 1.8 * len(distortions), 0.8 + 1.5 * len(metrics))
    panels = figure.subplots(len(metrics), len(distortions), squeeze=False, sharex="col", sharey="row")
    for row, (metric, what) in enumerate(metrics.items()):
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
        panels[row, 0].set_ylabel(what, fontsize=SMALL)
    if yardsticks:
        panels[0, 0].legend(frameon=False, fontsize=TINY)
    footnote(figure, *dict.fromkeys(records[0]["signatures"][metric] for metric in metrics))
    return figure


def _metrics(records: Sequence[Mapping[str, Any]]) -> dict[str, str]:
    """Return what to call the metrics that every record has."""
    if not records:
        raise ValueError("rows: no records to draw")
    for i, record in enumerate(records):
        if not isinstance(record, Mapping):
            raise TypeError(f"rows: expected records, got {record!r} at index {i}")
        if absent := [name for name in _NEEDED if name not in record]:
            raise ValueError(f"rows: the record at index {i} lacks {', '.join(absent)}")
        if set(record["npss"]) != set(records[0]["npss"]):
            raise ValueError(f"rows: the record at index {i} has other conventions than the first one")
    return {
        EULER_ERROR.name: EULER_ERROR.labelled,
        **{name: NPSS.column(convention=name) for name in records[0]["npss"]},
    }


def _value(record: Mapping[str, Any], metric: str) -> float:
    return float(record["euler_error"] if metric == EULER_ERROR.name else record["npss"][metric])
