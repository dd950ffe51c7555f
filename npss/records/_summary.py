"""Summarise records: one table per action."""

from __future__ import annotations

from collections.abc import Sequence

from npss._metric.metric import Metric
from npss._metric.registry import EULER_ERROR, NPSS, direction, metric_of_column
from npss._metric.signature import higher_is_better
from npss.console._tables import markdown_text, table
from npss.records._measure import Record


def summary(records: Sequence[Record], *, markdown: bool = False) -> str:
    r"""Summarise records in one table per action, models sorted by NPSS, the best of each column marked.

    Parameters
    ----------
    records : sequence of dict
        Records from `measure`, with ``model`` and ``action``; records of an action have the same numbers.
    markdown : bool, optional
        Write Markdown.

    Returns
    -------
    str
        The tables, with the signatures below.

    Raises
    ------
    ValueError
        If a record lacks a number that the first record of the action has.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.records import measure, summary
    >>> gt = np.random.default_rng(0).normal(size=(4, 25, 3)).cumsum(axis=1)
    >>> options = {"conventions": ["paper"], "fps": 25, "at_ms": [80]}
    >>> models = {"good": gt, "bad": gt[:, ::-1]}
    >>> records = [{"model": m, "action": "walking", **measure(gt, pred, **options)} for m, pred in models.items()]
    >>> print("\n".join(summary(records).splitlines()[:5]))
    walking (lower is better, * best; under ms: Euler error in rad)
    <BLANKLINE>
    model  NPSS paper   80 ms
    -----  ----------  ------
    good      0.0000*  0.000*
    """
    parts = []
    for action in dict.fromkeys(record["action"] for record in records):
        of_action = [record for record in records if record["action"] == action]
        convention = next(iter(of_action[0]["npss"]))
        of_action.sort(key=lambda record: record["npss"][convention])
        signatures = of_action[0]["signatures"]
        higher = [column for column in of_action[0].get("metrics", {}) if higher_is_better(signatures[column])]
        columns = _columns(of_action, higher)
        escaped = markdown_text if markdown else str
        names = [escaped(record["model"]) for record in of_action]
        rows = [[name, *row] for name, row in zip(names, zip(*columns.values(), strict=True), strict=True)]
        units = f"under ms: {EULER_ERROR.heading} in {EULER_ERROR.unit}"
        heading = escaped(f"{action} ({direction(higher)}, * best; {units})")
        parts.append(f"### {heading}" if markdown else heading)
        parts.append(table(["model", *columns], rows, "l" + "r" * len(columns), markdown=markdown))
        signatures = dict.fromkeys(line for record in of_action for line in record["signatures"].values())
        parts.append("\n".join(f"    {line}" for line in signatures))
    return "\n\n".join(parts)


def _columns(records: Sequence[Record], higher: Sequence[str]) -> dict[str, list[str]]:
    """Return the cells of each column of `summary`; `higher` names the columns in which higher is better."""
    first = records[0]
    numbers: dict[str, tuple[Metric | None, list[float]]]
    numbers = {NPSS.column(convention=name): (NPSS, _numbers(records, "npss", name)) for name in first["npss"]}
    numbers |= {
        f"{time} ms": (EULER_ERROR, _numbers(records, "euler_error", time)) for time in first.get("euler_error", {})
    }
    for column in first.get("metrics", {}):
        numbers[column] = metric_of_column(column), _numbers(records, "metrics", column)
    cells = {}
    for column, (metric, values) in numbers.items():
        digits = 4 if metric is None or metric.digits is None else metric.digits
        best = max(values) if column in higher else min(values)
        cells[column] = [f"{value:.{digits}f}" + ("*" if value == best else " ") for value in values]
    return cells


def _numbers(records: Sequence[Record], section: str, name: str) -> list[float]:
    for record in records:
        if name not in record.get(section, {}):
            raise ValueError(f"records: {record['model']!r} on {record['action']!r} lacks {section} {name}")
    return [record[section][name] for record in records]
