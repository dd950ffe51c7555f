"""Published numbers, and those that this project measured, as records like those of this library."""

from __future__ import annotations

import csv
from collections.abc import Mapping
from importlib.resources import files
from typing import Any, Literal, get_args

from npss._metric.convention import ConventionName
from npss._metric.metric import Metric
from npss._metric.registry import EULER_ERROR, L2P, L2Q, METRICS, NPSS
from npss._metric.signature import signature
from npss.protocol import lafan1
from npss.protocol._in_betweening import MetricName
from npss.records import Record, signature_of
from npss.validation import one_of

__all__ = ["records", "reference"]

_LAFAN1 = "in-betweening"
_OTHERS: Mapping[MetricName, Metric] = {"l2q": L2Q, "l2p": L2P}
_COPIED = ("6", "zero-velocity")  # the NPSS paper copied it from Martinez et al. 2017, so it has their windows
Published = Literal["srnn-8", "srnn-8-late", "lafan1"]  # protocols of published numbers


def records(source: str | None = None, *, protocol: Published | None = None) -> list[Record]:
    """Return published numbers as records, to print, rank or plot beside your own.

    They are tables 4 to 7 of the NPSS paper, and rows of LaFAN1's in-betweening benchmark (L2Q, L2P and NPSS). Their
    NPSS is that of the released code, so it is comparable with your own by ``'released'`` and no other convention.

    Parameters
    ----------
    source : str, optional
        Only the rows of one paper: ``'Gopalakrishnan et al. 2019'`` (Human3.6M), ``'Harvey et al. 2020'``,
        ``'Oreshkin et al. 2022'`` or ``'Qin et al. 2022'`` (LaFAN1). By default all.
    protocol : {'srnn-8', 'srnn-8-late', 'lafan1'}, optional
        Only the rows that are comparable with numbers of these test windows. By default those of ``'srnn-8'`` and
        ``'lafan1'``.

    Returns
    -------
    list of dict
        A record for each model and action; LaFAN1's actions are ``'in-betweening, 5 frames'`` and so on. Keys:
        ``model``, ``action``; as far as published, ``euler_error`` (radians, by milliseconds), ``npss`` (by
        convention), ``npss_windows`` (by convention and window) and ``metrics`` (``L2Q``, ``L2P``); ``signature``,
        ``signatures``; ``source`` (the paper, and its tables or where else the numbers are) and ``published``, which is
        True; ``printed``, for LaFAN1: the numbers by metric, with their published digits. Numbers that were not
        published are absent.

    Raises
    ------
    TypeError, ValueError
        If `source` is not one of the papers, `protocol` is not one of these, or no row matches both.

    Notes
    -----
    The frame at which the NPSS paper cuts its windows is unknown. So its rows count for both ``'srnn-8'`` and
    ``'srnn-8-late'``, except the zero-velocity row of its Table 6: that was copied from Martinez et al. and counts for
    ``'srnn-8'``.

    "(SA)" in the name of a model means that it was trained on one action, "(MA)" on several, if the paper has both.
    Tables 5 and 7 sometimes omit "(SA)"; the models are those of table 4.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, tables 4 to 7.
    F. Harvey et al., "Robust Motion In-betweening", ACM Transactions on Graphics 39 (4), 2020.
    B. Oreshkin et al., "Motion In-betweening via Deep Delta-Interpolator", 2022.
    J. Qin et al., "Motion In-betweening via Two-stage Transformers", ACM Transactions on Graphics 41 (6), 2022.

    Examples
    --------
    >>> from npss import published
    >>> record = published.records("Gopalakrishnan et al. 2019")[0]
    >>> record["model"], record["action"], record["npss"], record["source"]
    ('VGRU-r1 (SA)', 'walking', {'released': 1.217}, 'Gopalakrishnan et al. 2019, Tables 4, 5, 7')
    """
    rows = _rows("published.csv")
    if source is not None:
        one_of("source", source, tuple(dict.fromkeys(row["source"] for row in rows)))
    if protocol is not None:
        one_of("protocol", protocol, get_args(Published))
    models: dict[tuple[str, ...], list[dict[str, str]]] = {}
    for row in rows:
        if source in (None, row["source"]) and _is_of(row, protocol):
            key = tuple(row[name] for name in ("source", "model", "action", "frames"))
            models.setdefault(key, []).append(row)
    if not models:
        raise ValueError(f"protocol: {source} has no rows for {protocol}")
    return [_record(of_model, protocol or "srnn-8") for of_model in models.values()]


def reference() -> list[Record]:
    """Return this project's own numbers as records, to print, rank or plot beside your own.

    ``npss-baselines reproduce`` measured them on the eight test windows of Human3.6M, by the conventions ``'paper'``
    and ``'released'``: untrained and fitted predictors, and models of the NPSS paper. The documentation has the same
    numbers with intervals.

    Returns
    -------
    list of dict
        A record for each model and action. Keys: ``model``, ``action``, ``euler_error`` (radians, by milliseconds),
        ``npss`` (by convention) and ``npss_windows`` (by convention and window), averaged over seeds of training and
        over draws; ``spread``, the sample standard deviations over seeds of the same numbers, if there are several;
        ``signature``, ``signatures``; ``recipe``, ``seeds`` (how many), ``draws``; ``source``; and ``reference``, which
        is True.

    Raises
    ------
    OSError
        If the table of the package cannot be read.

    Examples
    --------
    >>> from npss import published
    >>> record = published.reference()[0]
    >>> record["model"], record["action"], record["npss"]
    ('zero-velocity', 'walking', {'paper': 2.33413, 'released': 1.14128})
    >>> record["signatures"]["paper"]
    'npss|version:1|convention:paper|representation:euler|frames:100|fps:25|protocol:srnn-8|unwrap:off'
    """
    models: dict[tuple[str, str], list[dict[str, str]]] = {}
    for row in _rows("measured.csv"):
        models.setdefault((row["model"], row["action"]), []).append(row)
    return [_reference(rows) for rows in models.values()]


def _rows(name: str) -> list[dict[str, str]]:
    """Read a table of the package."""
    return list(csv.DictReader(files("npss").joinpath(name).read_text(encoding="utf-8").splitlines()))


def _is_of(row: dict[str, str], protocol: str | None) -> bool:
    """Return whether a row is comparable with numbers of a protocol."""
    if protocol == "srnn-8-late" and (row["table"], row["model"]) == _COPIED:
        return False
    return protocol is None or (row["action"] == _LAFAN1) == (protocol == "lafan1")


def _record(rows: list[dict[str, str]], protocol: str) -> Record:
    """Return the record of the rows of one model, action and number of frames."""
    first = rows[0]
    record: dict[str, Any] = {"model": first["model"], "action": first["action"]}
    errors = {row["at"]: float(row["value"]) for row in rows if row["metric"] == EULER_ERROR.name}
    scores = {row["at"]: float(row["value"]) for row in rows if row["metric"] == NPSS.name}
    fields: dict[str, Any] = {
        "fps": 25,
        "frames": 100,
        "representation": "euler",
        "protocol": protocol,
        "unwrap": "off",
    }
    if first["action"] == _LAFAN1:
        record["action"] = lafan1.action(int(first["frames"]))
        fields = {"frames": int(first["frames"]), **lafan1.fields()}
    if errors:
        record["euler_error"] = errors
        fields |= EULER_ERROR.stated()
    if scores:
        record["npss"] = {"released": scores[""]}
    if windows := {window: score for window, score in scores.items() if window}:
        record["npss_windows"] = {"released": windows}
    _state(record, fields)
    for name, metric in _OTHERS.items():
        for row in (row for row in rows if row["metric"] == name):
            record.setdefault("metrics", {})[metric.heading] = float(row["value"])
            meaning = signature(None, metric=name, frames=fields["frames"], **lafan1.fields(name))
            record["signatures"][metric.heading] = meaning
    places = list(dict.fromkeys(row["table"] for row in rows))
    numbered = f"Table{'s' if len(places) > 1 else ''} {', '.join(places)}"
    record["source"] = f"{first['source']}, {numbered if places[0].isdecimal() else ' and '.join(places)}"
    record["published"] = True
    if first["action"] == _LAFAN1:
        record["printed"] = {METRICS[row["metric"]].heading: row["value"] for row in rows}
    return record


def _reference(rows: list[dict[str, str]]) -> Record:
    """Return the record of the measured rows of one model and action."""
    first = rows[0]
    seeds, draws = int(first["seeds"]), int(first["draws"])
    record: dict[str, Any] = {"model": first["model"], "action": first["action"], **_numbers(rows, "value")}
    fields: dict[str, Any] = {"fps": 25, "frames": int(first["frames"]), "representation": "euler"}
    fields |= {"protocol": "srnn-8", "unwrap": "off", **EULER_ERROR.stated()} | ({"draws": draws} if draws > 1 else {})
    _state(record, fields)
    if seeds > 1:
        record["spread"] = _numbers(rows, "spread")
    record |= {"recipe": first["recipe"], "seeds": seeds, "draws": draws}
    return record | {"source": f"npss-baselines, recipe {first['recipe']}", "reference": True}


def _numbers(rows: list[dict[str, str]], column: str) -> Record:
    """Return the numbers of one column, in the sections of a record."""
    found: dict[str, Any] = {"euler_error": {}, "npss": {}, "npss_windows": {}}
    for row in rows:
        if row["metric"] == EULER_ERROR.name:
            found["euler_error"][row["at"]] = float(row[column])
        elif row["at"]:
            found["npss_windows"].setdefault(row["convention"], {})[row["at"]] = float(row[column])
        else:
            found["npss"][row["convention"]] = float(row[column])
    return found


def _state(record: Record, fields: Mapping[str, Any]) -> None:
    """Add the signatures of the numbers of a record."""
    conventions: list[ConventionName] = list(record.get("npss", {}))
    convention = None if not conventions else conventions[0] if len(conventions) == 1 else tuple(conventions)
    metrics = [metric for metric in (NPSS.name, EULER_ERROR.name) if metric in record]
    record["signature"] = signature(convention, metric="+".join(metrics), **fields)
    record["signatures"] = {name: signature_of(record, NPSS.name, name) for name in conventions}
    if EULER_ERROR.name in record:
        record["signatures"][EULER_ERROR.name] = signature_of(record, EULER_ERROR.name)
