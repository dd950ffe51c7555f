"""Results: the numbers that leaderboards rank, read from records and reports and checked."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from npss._analysis.blocks import Blocks, Groups, read_groups, statistics_version
from npss._analysis.fingerprint import PROJECTIONS
from npss._analysis.report import Report
from npss._metric.convention import as_convention
from npss._metric.metric import Metric
from npss._metric.registry import EULER_ERROR, NPSS, metric_of_column
from npss._metric.signature import parse_signature, signature
from npss.protocol import lafan1
from npss.protocol._verify import measured_actions
from npss.ranking._names import model_name, one_line
from npss.records import Record, signature_of
from npss.stochastic import SampleReport
from npss.validation import Float64, is_real


@dataclass(frozen=True, kw_only=True)
class Result:
    """One number of one model: a row of a tidy leaderboard."""

    model: str
    action: str
    column: str  # such as "NPSS paper" or "Euler error 80 ms"
    heading: str = NPSS.heading  # heading of the metric
    time: str = ""  # such as "80 ms", for a metric with a column for each time
    unit: str = ""
    digits: int | None = None  # in tables; None: the default of the table
    lower_is_better: bool = True
    value: float
    signature: str
    numerator: Float64 | None = None  # (N,); the terms of the weighted mean
    weight: Float64 | None = None  # (N,)
    fingerprint: Float64 | None = None  # (N, 9), of the ground truth; (N,) in statistics version 1
    groups: Groups = None  # blocks of the sequences; None: each is assumed to be its own
    source: str = ""  # source of a published number or one of this project, otherwise empty
    reference: bool = False  # whether this project measured it
    seeds: tuple[float, ...] = ()  # the number of each run of a method; the value is their mean
    samples: tuple[float, ...] = ()  # the score of each sample of a stochastic model

    @property
    def loss(self) -> float:
        """The value with a sign that makes lower better."""
        return self.value if self.lower_is_better else -self.value

    @property
    def blocks(self) -> Blocks | None:
        """The blocks of the sequences, if known."""
        return None if self.weight is None else Blocks(self.groups, self.weight)

    @property
    def kind(self) -> str:
        """``'published'`` or ``'reference'``, in tables after the name; empty for a user's number."""
        return "" if not self.source else "reference" if self.reference else "published"

    @property
    def label(self) -> str:
        """The name of the model in tables."""
        return f"{self.model} ({self.kind})" if self.source else self.model

    def means_as(self, other: Result) -> bool:
        """Return whether two numbers mean the same; reference numbers may be over other numbers of draws."""
        meanings = [self.signature, other.signature]
        if self.reference or other.reference:
            meanings = [re.sub(r"\|draws:[0-9]+", "", meaning) for meaning in meanings]
        return meanings[0] == meanings[1]


def results_of_record(record: Record) -> list[Result]:
    """Read the numbers of a record from `npss.records.measure`, with ``model`` and ``action``.

    Raises
    ------
    ValueError
        If a field is missing or invalid, a number is negative or not finite, or the weighted mean of the single
        sequences is not the score; names the model, the action and the field.
    """
    for field in ("model", "action", "signature"):
        if not isinstance(record.get(field), str):
            raise ValueError(f"records: expected text as {field!r} in each, got {record.get(field)!r:.100}")
    try:
        return list(_results(record))
    except (TypeError, ValueError) as error:
        raise ValueError(f"records: {record['model']!r} on {record['action']!r}: {error}") from error


def _results(record: Record) -> Iterator[Result]:
    source = record.get("source", "")
    if not isinstance(source, str):
        raise ValueError(f"source: expected text, got {source!r:.100}")
    model, action = model_name(record["model"]), one_line(record["action"])
    named: dict[str, Any] = {"model": model, "action": action, "source": source}
    named["reference"] = record.get("reference") is True
    parse_signature(record["signature"])
    sequences = _object("sequences", record.get("sequences", {}))
    version = statistics_version(sequences)
    scores, weights = (_object(f"sequences: {name}", sequences.get(name, {})) for name in ("npss", "weight"))
    errors = _object("sequences: euler_error", sequences.get("euler_error", {}))
    fingerprint = _fingerprint(sequences["fingerprint"], version) if "fingerprint" in sequences else None

    def result(
        field: str,
        column: str,
        value: object,
        which: str,
        score: object = None,
        weight: object = None,
        **traits: Any,
    ) -> Result:
        number = _number(field, value)
        parts: dict[str, Any] = {} if score is None else _parts(field, number, score, weight, fingerprint)
        if parts:
            parts["groups"] = read_groups("sequences: groups", sequences.get("groups"), len(parts["weight"]))
            Blocks(parts["groups"], parts["weight"])  # checks that a block has power
        return Result(**named, **parts, **traits, column=column, value=number, signature=which)

    for name, value in _object("npss", record.get("npss", {})).items():
        as_convention(name)
        which, column = signature_of(record, NPSS.name, name), NPSS.column(convention=name)
        yield result(f"npss: {name}", column, value, which, scores.get(name), weights.get(name), **_traits(NPSS))
    for name, windows in _object("npss_windows", record.get("npss_windows", {})).items():
        as_convention(name)
        for window, value in _object(f"npss_windows: {name}", windows).items():
            which = signature_of(record, NPSS.name, name, window=window)
            column = NPSS.column(convention=name, window=window)
            yield result(f"npss_windows: {name}: {window}", column, value, which, **_traits(NPSS))
    for time, value in _object("euler_error", record.get("euler_error", {})).items():
        error, weight = errors.get(time), None
        which, column = signature_of(record, EULER_ERROR.name), EULER_ERROR.column(at_ms=time)
        if isinstance(error, list):  # a still sequence is null and does not count
            weight = [float(value is not None) for value in error]
            error = [0.0 if value is None else value for value in error]
        traits = {**_traits(EULER_ERROR), "time": f"{time} ms"}
        yield result(f"euler_error: {time}", column, value, which, error, weight, **traits)
    others, signatures = (_object("sequences: metrics", sequences.get("metrics", {})), record.get("signatures", {}))
    for name, value in _object("metrics", record.get("metrics", {})).items():
        metric = metric_of_column(name)
        if not name or name != one_line(name) or metric in (NPSS, EULER_ERROR):
            raise ValueError(f"metrics: {name!r} is not a valid name for another metric")
        signature = _object("signatures", signatures).get(name)
        if not isinstance(signature, str):
            raise ValueError(f"signatures: expected one for {name!r}, got {signature!r:.100}")
        meaning, other = parse_signature(signature), others.get(name)
        if metric is not None and metric.name != meaning["metric"]:
            raise ValueError(f"metrics: {name!r} is a column of {metric.name!r}, but its signature is {signature}")
        weight = None if other is None else [1.0] * len(_list(f"sequences: metrics: {name}", other))
        traits = _traits(metric) or {"heading": name}
        traits["lower_is_better"] = meaning.get("better") != "higher"
        if name.endswith(suffix := f" {meaning.get('at_ms')} ms"):
            traits |= {"heading": name.removesuffix(suffix), "time": suffix.strip()}
        yield result(f"metrics: {name}", name, value, signature, other, weights.get(name, weight), **traits)


def _traits(metric: Metric | None) -> dict[str, Any]:
    """Return the fields of a metric that tables need."""
    return {} if metric is None else {name: getattr(metric, name) for name in ("heading", "unit", "digits")}


def result_of_report(model: str, action: str, report: Report | SampleReport) -> Result:
    """Read the score of a report; without an action, that of an in-betweening protocol follows from its signature.

    If the action has a known checksum, and Euler angles have no known one, they are not those of the protocol.
    """
    meaning = parse_signature(report.signature)
    convention = meaning["convention"]
    if not action and meaning.get("protocol") == lafan1.name and "frames" in meaning:
        action = lafan1.action(meaning["frames"])
    checked = report.verification
    undecided = checked is not None and checked.undecided and action in measured_actions(checked.protocol)
    if undecided and meaning.get("representation") == "euler":  # others have no checksum
        meaning["verified"] = "no"
    name = convention if isinstance(convention, str) else report.signature.split("convention:")[1].split("|")[0]
    samples: tuple[float, ...] = ()
    if isinstance(report, SampleReport):
        numerator, weight, samples = report.numerator, report.weight, tuple(report.scores.tolist())
    else:
        numerator, weight = (report.weight * report.emd).sum(axis=1), report.weight.sum(axis=1)
    return Result(
        model=model_name(model),
        action=one_line(action),
        column=NPSS.column(convention=name),
        **_traits(NPSS),
        value=report.score,
        signature=signature(**meaning),
        numerator=numerator,
        weight=weight,
        fingerprint=report.fingerprint,
        groups=report.groups,
        samples=samples,
    )


def _object(field: str, value: object) -> Mapping[str, Any]:
    if not isinstance(value, Mapping) or not all(isinstance(name, str) for name in value):
        raise ValueError(f"{field}: expected an object, got {value!r:.100}")
    return value


def _number(field: str, value: object, *, least: float = 0) -> float:
    try:
        number = float(value) if is_real(value) else math.nan
    except OverflowError:
        number = math.inf
    if not (math.isfinite(number) and number >= least):
        expected = "a finite number" if least < 0 else "a finite number that is not negative"
        raise ValueError(f"{field}: expected {expected}, got {value!r:.100}")
    return number


def _fingerprint(value: object, version: int) -> Float64:
    """Read the fingerprint of a ground truth: a list for each sequence, or a number in records of version 1."""
    field = "sequences: fingerprint"
    if version == 1:
        return _list(field, value)
    if not isinstance(value, list) or not value:
        raise ValueError(f"{field}: expected a list for each sequence, got {value!r:.100}")
    for row in value:
        if not isinstance(row, list) or len(row) != 1 + PROJECTIONS:
            raise ValueError(f"{field}: expected {1 + PROJECTIONS} numbers for each sequence, got {row!r:.100}")
    numbers = np.array([[_number(field, number, least=-math.inf) for number in row] for row in value])
    if (numbers[:, 0] < 0).any():
        raise ValueError(f"{field}: a norm is negative")
    return numbers


def _list(field: str, values: object) -> Float64:
    if not isinstance(values, list) or not values:
        raise ValueError(f"{field}: expected a list with a number for each sequence, got {values!r:.100}")
    return np.array([_number(field, value) for value in values])


def _parts(field: str, value: float, score: object, weight: object, fingerprint: Float64 | None) -> dict[str, Any]:
    """Read the terms and weights of single sequences, and check that their weighted mean is the number."""
    scores, weights = _list(f"sequences: {field}", score), _list(f"sequences: weight of {field}", weight)
    lengths = {len(scores), len(weights)} | (set() if fingerprint is None else {len(fingerprint)})
    if len(lengths) > 1:
        raise ValueError(f"sequences: lists of {field} differ in length: {sorted(lengths)}")
    with np.errstate(over="ignore"):
        total, numerator = weights.sum(), scores * weights
    if not (
        math.isfinite(total) and total > 0 and math.isclose(numerator.sum() / total, value, rel_tol=1e-6, abs_tol=1e-9)
    ):
        raise ValueError(f"sequences: the weighted mean of {field} is not {value}, which the record states")
    return {"numerator": numerator, "weight": weights, "fingerprint": fingerprint}
