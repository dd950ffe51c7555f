"""One table of in-betweening: models by metric and by length of the transition."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import NamedTuple

import numpy as np

from npss import published as published_rows
from npss._metric.metric import Metric
from npss._metric.registry import L2P, L2Q, NPSS
from npss._metric.signature import differences, parse_signature
from npss.console._tables import markdown_code, markdown_text
from npss.console._tables import table as write
from npss.records import Record
from npss.validation import each, is_real, positive_integer, real_array

_METRICS = (L2Q, L2P, NPSS)


class _Number(NamedTuple):
    model: str
    metric: Metric
    frames: int
    signature: str
    text: str

    @property
    def column(self) -> tuple[Metric, int]:
        return self.metric, self.frames


def table(records: Iterable[Record], *, published: bool = False, digits: int = 4, markdown: bool = False) -> str:
    """Write in-betweening records as one table: L2Q, L2P and NPSS, each with a column for each length.

    Parameters
    ----------
    records : iterable of dict
        Records from `measure`, with ``model``, or from `npss.published.records`. The records of a model, one for each
        length, are one row.
    published : bool, optional
        Also show the published rows of LaFAN1's benchmark, with their own digits; refuse if they mean anything else.
    digits : int, optional
        Decimal places of your numbers; published NPSS needs four to tell .0011 from .0014.
    markdown : bool, optional
        Write a Markdown table.

    Returns
    -------
    str
        The table, the signatures of its numbers, and the sources of published ones.

    Raises
    ------
    TypeError
        If the records are not an iterable of dicts, or `digits` is not an integer.
    ValueError
        If there are no records; a record lacks ``model`` or a signature, or is a duplicate; or two numbers of one
        column differ in meaning: the message says in one line which field differs.

    Examples
    --------
    >>> from npss import published
    >>> text = table(published.records("Oreshkin et al. 2022"))
    >>> for row in text.splitlines()[:3]:
    ...     print(row)
    model                           L2Q 5      15      30   L2P 5      15      30  NPSS 5      15      30
    ------------------------------  ------  ------  ------  ------  ------  ------  ------  ------  ------
    Delta-interpolator (published)  0.1138  0.3175  0.5723  0.1290  0.4670  0.9954  0.0014  0.0217  0.1217
    """
    positive_integer("digits", digits)
    own = each("records", records, "records")
    numbers = [number for record in own for number in _numbers(record, digits)]
    _check_deviations(own)
    if not numbers:
        raise ValueError("records: expected at least one, with numbers of in-betweening")
    if published:
        theirs = published_rows.records(protocol="lafan1")
        numbers += _beside(numbers, [number for record in theirs for number in _numbers(record, digits)])
        own = own + theirs
    meanings = _meanings(numbers)
    columns = sorted(meanings, key=lambda column: (_METRICS.index(column[0]), column[1]))
    cells: dict[tuple[str, Metric, int], str] = {}
    for number in numbers:
        if (place := (number.model, *number.column)) in cells:
            raise ValueError(
                f"records: duplicate {number.metric.heading} of {number.model!r} at {number.frames} frames"
            )
        cells[place] = number.text
    escaped = markdown_text if markdown else str
    rows = [
        [escaped(model), *(cells.get((model, *column), "") for column in columns)]
        for model in dict.fromkeys(number.model for number in numbers)
    ]
    lines = [write(["model", *_headings(columns)], rows, "l" + "r" * len(columns), markdown=markdown), ""]
    for metric in dict.fromkeys(metric for metric, _ in columns):
        lengths = [frames for other, frames in columns if other is metric]
        text = meanings[metric, lengths[0]].signature
        text = text.replace(f"|frames:{lengths[0]}|", f"|frames:{' '.join(map(str, lengths))}|")
        lines.append(f"{markdown_code(text)}  " if markdown else f"    {text}")
    sources = dict.fromkeys(f"{_name(record)}: {record['source']}" for record in own if record.get("published") is True)
    lines += ["", *(f"- {escaped(source)}" for source in sources)] if sources else []
    return "\n".join(lines)


def _check_deviations(records: Iterable[Record]) -> None:
    """Refuse numbers of positions that are divided by different standard deviations."""
    first: Record | None = None
    for record in (record for record in records if "std" in record):
        first = first or record
        own, other = (real_array("records: std", one["std"]) for one in (record, first))
        if own.shape != other.shape or not np.allclose(own, other, rtol=1e-3, atol=0):
            raise ValueError(
                f"records: {_name(record)!r} and {_name(first)!r} differ in L2P: their positions are standardised by "
                f"other standard deviations"
            )


def _numbers(record: Record, digits: int) -> Iterator[_Number]:
    """Yield the numbers of a record, with the digits of published ones."""
    if not isinstance(record, Mapping):
        raise TypeError(f"records: expected dicts, got {record!r:.100}")
    printed, signatures = record.get("printed", {}), record.get("signatures", {})
    for metric in _METRICS:
        section, name = ("npss", "released") if metric is NPSS else ("metrics", metric.heading)
        values = record.get(section, {})
        if not isinstance(values, Mapping):
            raise ValueError(f"records: expected an object as {section!r} of {_name(record)!r}, got {values!r:.100}")
        value = values.get(name)
        if value is None:
            continue
        if not (is_real(value) and math.isfinite(value)):
            raise ValueError(f"records: expected a finite {metric.heading} of {_name(record)!r}, got {value!r:.100}")
        if not isinstance(signatures.get(name), str):
            raise ValueError(f"records: {_name(record)!r} has {metric.heading} without a signature")
        frames = parse_signature(signatures[name]).get("frames")
        if frames is None:
            raise ValueError(f"records: {_name(record)!r}: its signature does not state frames: {signatures[name]}")
        text = printed.get(metric.heading, f"{value:.{digits}f}")
        yield _Number(_name(record), metric, frames, signatures[name], text)


def _name(record: Record) -> str:
    """Return the name of the row of a record."""
    if not isinstance(record.get("model"), str):
        raise ValueError(f"records: expected text as 'model' in each, got {record.get('model')!r}")
    return f"{record['model']} (published)" if record.get("published") is True else record["model"]


def _beside(own: Iterable[_Number], published: list[_Number]) -> list[_Number]:
    """Return published numbers, unless one of `own` means anything else."""
    for number in own:
        rows = [row for row in published if row.metric is number.metric]
        row = next((row for row in rows if row.frames == number.frames), rows[0])
        if row.signature != number.signature:
            difference = differences(number.signature, row.signature)[0]
            raise ValueError(f"published: {number.model!r} differs in {number.metric.heading}: {difference}")
    return published


def _meanings(numbers: Iterable[_Number]) -> dict[tuple[Metric, int], _Number]:
    """Return the first number of each column, after checking that the others mean the same."""
    meanings: dict[tuple[Metric, int], _Number] = {}
    for number in numbers:
        first = meanings.setdefault(number.column, number)
        if number.signature != first.signature:
            difference = differences(number.signature, first.signature)[0]
            raise ValueError(
                f"records: {number.model!r} and {first.model!r} differ in {number.metric.heading}: {difference}"
            )
    return meanings


def _headings(columns: Iterable[tuple[Metric, int]]) -> list[str]:
    """Return the headings of columns: the metric is named at its first length."""
    named: set[str] = set()
    headings = []
    for metric, frames in columns:
        headings.append(str(frames) if metric.heading in named else f"{metric.heading} {frames}")
        named.add(metric.heading)
    return headings
