"""Records: every number of one comparison, with the signature that says what they are."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import numpy.typing as npt

from npss._analysis.blocks import STATISTICS_VERSION, Groups, Label, read_groups
from npss._analysis.fingerprint import fingerprint
from npss._metric.contributions import contributions
from npss._metric.convention import CONVENTIONS, as_convention
from npss._metric.euler_error import euler_error, moving_pair, sequence_errors
from npss._metric.fields import Value
from npss._metric.metric import Metric
from npss._metric.registry import EULER_ERROR, METRICS, NPSS, metric_called
from npss._metric.score import quotient, score_windows, weighted_sums
from npss._metric.signature import parse_signature, signature, stated_of, stated_with, with_fields_of
from npss.console._progress import Progress
from npss.console._tables import markdown_text, table
from npss.rotations._unwrap import unwrap
from npss.skeleton import poses_to_positions
from npss.validation import Float64, each, motion_pair, positive_number, renamed

__all__ = ["NUMBERS", "Groups", "Record", "measure", "signature_of", "summary"]

Record = dict[str, Any]

#: The entries of a record that hold numbers.
NUMBERS = ("npss", "npss_windows", "euler_error", "metrics")


@renamed(seed="seed_frames", edges_s="edges_ms")
def measure(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    conventions: Sequence[str] = tuple(CONVENTIONS),
    fps: float | None = None,
    at_ms: Sequence[int] = (),
    edges_ms: Sequence[float] = (),
    metrics: Sequence[str] = (),
    poses: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    unwrapped: str = "off",
    seed_frames: npt.ArrayLike | None = None,
    workers: int = 1,
    sequences: bool = False,
    groups: Iterable[Label | None] | None = None,
    extra: Mapping[str, Value] | None = None,
    **context: Value,
) -> Record:
    """Measure a prediction by every metric that is asked for.

    Parameters
    ----------
    gt, pred : (N, T, D) or (T, D) array_like
        As for `score`.
    conventions : sequence of str, optional
        Conventions to score by.
    fps : float, optional
        Frames per second; needed for `at_ms` and `edges_ms`.
    at_ms : sequence of int, optional
        Times of the Euler error, in milliseconds; none, and it is left out.
    edges_ms : sequence of float, optional
        Edges of the windows that are scored too, in milliseconds; none, and they are left out.
    metrics : sequence of str, optional
        Other metrics, by the names or headings under which they are registered: see `npss.metrics`. Those that have
        times are measured at those of `at_ms`.
    poses : pair of (N, T, 99) array_like, optional
        Ground truth and prediction as Human3.6M poses, exponential maps, for metrics that take poses or positions.
    unwrapped : {'off', 'target', 'seed'}, optional
        Remove jumps of 2 pi before NPSS (never for other metrics): over the target alone, or from the seed on.
    seed_frames : array_like, optional
        The seed frames, for ``unwrapped='seed'``.
    workers : int, optional
        As for `score`.
    sequences : bool, optional
        Measure each sequence alone, too: what intervals and comparisons are made from.
    groups : sequence of str, int or None, optional
        The blocks of the sequences, as for `npss.report`; kept with the single sequences.
    extra : mapping of str to str, int, float or bool; optional
        Fields of one's own that the signature states.
    **context
        Known fields that the signature states.

    Returns
    -------
    dict
        ``npss`` by convention, ``npss_windows`` by convention and window, ``euler_error`` by time, as far as they were
        asked for; ``metrics``, the numbers of other metrics by their columns, if there are any; ``still``, the indices
        of sequences that the Euler error leaves out, since nothing moves in their ground truth, if there are any; the
        one ``signature`` of NPSS and the Euler error together, and ``signatures``, that of each number by convention,
        metric or column. In ``sequences``, lists with a value for each sequence: ``npss`` by convention, ``weight``
        by convention (of which the score is the weighted mean), ``euler_error`` by time (None for a still one),
        ``metrics`` by column (with their weights in ``weight``, if they have some), the ground truth's ``fingerprint``,
        and ``groups``, if there are some; and ``statistics``, the version of the rules by which they are to be read.

    Raises
    ------
    TypeError, ValueError
        As `npss.score`, `npss.euler_error` and `npss.signature`; if no metric has one of the names, a metric lacks the
        motion or the times that it takes, or its function returns what it should not.
    """
    others = _others(metrics, at_ms, poses)
    angles = gt, pred
    record: Record = {}
    alone: Record = {}  # of each sequence
    if sequences:
        alone["statistics"] = STATISTICS_VERSION
        truth = motion_pair(gt, pred)[0]
        alone["fingerprint"] = fingerprint(truth).tolist()
        labels = read_groups("groups", groups, len(truth) if truth.ndim == 3 else 1)
        if labels is not None:
            alone["groups"] = list(labels)
    stated = stated_with(measure, context, extra, unwrap=unwrapped)
    if fps is not None:
        stated["fps"] = positive_number("fps", fps)
    joint = NPSS.name
    if at_ms:
        moving, predicted, still = moving_pair(gt, pred)
        record["euler_error"] = {}
        if still.any():
            record["still"] = np.flatnonzero(still).tolist()
        if not still.all():
            errors = euler_error(moving, predicted, fps=_needed(fps), at_ms=at_ms)
            record["euler_error"] = {str(time): error for time, error in errors.items()}
            if sequences:
                frames = {str(time): round(time * _needed(fps) / 1000) for time in errors}
                alone["euler_error"] = _by_time(sequence_errors(moving, predicted), still, frames)
            stated |= EULER_ERROR.stated() | ({"still": int(still.sum())} if still.any() else {})
            joint = f"{NPSS.name}+{EULER_ERROR.name}"
    if unwrapped != "off":
        start = seed_frames if unwrapped == "seed" else None
        gt, pred = unwrap(gt, seed_frames=start), unwrap(pred, seed_frames=start)
    record["npss"] = {}
    if sequences:
        alone |= {"npss": {}, "weight": {}}
        record["sequences"] = alone
    for name in conventions:
        truth, prediction = motion_pair(gt, pred)
        with Progress(NPSS.column(convention=name)) as progress:
            how: dict[str, Any] = {"workers": workers, "progress": progress}
            if not sequences:
                record["npss"][name] = quotient(*weighted_sums(truth, prediction, as_convention(name), **how))
                continue
            parts = contributions(truth, prediction, as_convention(name), **how)
        record["npss"][name] = parts.score
        numerator, weight = parts.by_sequence()
        alone["npss"][name] = np.divide(numerator, weight, out=np.zeros(len(weight)), where=weight > 0).tolist()
        alone["weight"][name] = weight.tolist()
    if edges_ms:
        record["npss_windows"] = {
            name: score_windows(gt, pred, fps=_needed(fps), edges_ms=edges_ms, convention=name, workers=workers)
            for name in conventions
        }
    named = conventions[0] if len(conventions) == 1 else tuple(conventions)
    record["signature"] = signature(named, metric=joint, **stated)
    record["signatures"] = {name: signature_of(record, NPSS.name, name) for name in conventions}
    if record.get("euler_error"):
        record["signatures"][EULER_ERROR.name] = signature_of(record, EULER_ERROR.name)
    for other in others:
        _add(record, other, angles, poses, fps, at_ms)
    return record


def signature_of(record: Record, metric: str, convention: str | None = None, **context: Value) -> str:
    """Return the signature of one number of a record.

    Parameters
    ----------
    record : dict
        As `measure` returns.
    metric : str
        The name of the metric: ``'npss'``, ``'euler_error'``, or one that is registered.
    convention : str, optional
        By which convention, for ``'npss'``.
    **context
        What is particular to that number, such as ``window='0-1'``.
    """
    stated = stated_of(metric, parse_signature(record["signature"]))
    return signature(**{**stated, "convention": convention, **context})


def _others(metrics: Sequence[str], at_ms: Sequence[float], poses: object) -> list[Metric]:
    """Return the metrics of those names, of which all is there that they take."""
    found: list[Metric] = []
    for name in each("metrics", metrics, "names"):
        metric = metric_called(name, "metrics")
        if metric is NPSS or metric is EULER_ERROR:
            how = "at the times of at_ms" if metric.has_times else "by each of the conventions"
            raise ValueError(f"metrics: {metric.name!r} is measured anyway, {how}; leave it out")
        if metric in found:
            raise ValueError(f"metrics: {name!r} is a duplicate")
        if metric.takes != "angles" and poses is None:
            raise ValueError(f"metrics: {name!r} takes {metric.takes}, and there are no poses")
        if metric.has_times and not at_ms:
            raise ValueError(f"metrics: {name!r} is measured at the times of at_ms, and there are none")
        if metric.has_conventions:
            raise ValueError(f"metrics: {name!r} has conventions, which other metrics than NPSS cannot have here")
        found.append(metric)
    return found


def _add(record: Record, metric: Metric, angles: Any, poses: Any, fps: float | None, at_ms: Sequence[float]) -> None:
    """Measure by another metric, and add its numbers to a record."""
    gt, pred = angles if metric.takes == "angles" else poses
    if metric.takes == "positions":
        gt, pred = poses_to_positions(gt), poses_to_positions(pred)
    stated = with_fields_of(metric, stated_of(metric.name, parse_signature(record["signature"])))
    for time in at_ms if metric.has_times else (None,):
        measured = metric.measure(gt, pred, fps=fps, at_ms=time)
        column = metric.column(at_ms=time)
        record.setdefault("metrics", {})[column] = measured.value
        record["signatures"][column] = signature(**stated | ({} if time is None else {"at_ms": time}))
        alone, values = record.get("sequences"), measured.by_sequence()
        if alone is None or values is None:
            continue
        alone.setdefault("metrics", {})[column] = values.tolist()
        if metric.aggregation == "weighted mean":
            alone["weight"][column] = np.asarray(measured.weight).tolist()


def summary(records: Sequence[Record], *, markdown: bool = False) -> str:
    """Lay records out for people: a table an action, models in the order of NPSS, the best of each column marked."""
    parts = []
    for action in dict.fromkeys(record["action"] for record in records):
        of_action = [record for record in records if record["action"] == action]
        convention = next(iter(of_action[0]["npss"]))
        of_action.sort(key=lambda record: record["npss"][convention])
        columns = _columns(of_action)
        escaped = markdown_text if markdown else str
        names = [escaped(record["model"]) for record in of_action]
        rows = [[name, *row] for name, row in zip(names, zip(*columns.values(), strict=True), strict=True)]
        units = f"under ms: {EULER_ERROR.heading} in {EULER_ERROR.unit}"
        heading = escaped(f"{action} (lower is better, * best; {units})")
        parts.append(f"### {heading}" if markdown else heading)
        parts.append(table(["model", *columns], rows, "l" + "r" * len(columns), markdown=markdown))
        signatures = dict.fromkeys(line for record in of_action for line in record["signatures"].values())
        parts.append("\n".join(f"    {line}" for line in signatures))
    return "\n\n".join(parts)


def _columns(records: Sequence[Record]) -> dict[str, list[str]]:
    """Return the cells of each column of `summary`."""
    numbers: dict[str, tuple[Metric | None, list[float]]] = {}
    for name in records[0]["npss"]:
        numbers[NPSS.column(convention=name)] = NPSS, [record["npss"][name] for record in records]
    for time in records[0]["euler_error"]:
        numbers[f"{time} ms"] = EULER_ERROR, [record["euler_error"][time] for record in records]
    for column in records[0].get("metrics", {}):
        metric = METRICS.get(parse_signature(records[0]["signatures"][column])["metric"])
        numbers[column] = metric, [record["metrics"][column] for record in records]
    cells = {}
    for column, (metric, values) in numbers.items():
        digits = 4 if metric is None or metric.digits is None else metric.digits
        best = max(values) if metric is not None and not metric.lower_is_better else min(values)
        cells[column] = [f"{value:.{digits}f}" + ("*" if value == best else " ") for value in values]
    return cells


def _by_time(errors: Float64, still: npt.NDArray[np.bool_], frames: Mapping[str, int]) -> dict[str, list[float | None]]:
    """Return the error of each sequence at some frames, counted from 1: None for those that stand still."""
    found = np.full((len(still), errors.shape[1]), np.nan)
    found[~still] = errors
    return {
        time: [None if np.isnan(error) else error for error in found[:, frame - 1].tolist()]
        for time, frame in frames.items()
    }


def _needed(fps: float | None) -> float:
    if fps is None:
        raise ValueError("fps: times were asked for, so the frames per second are needed")
    return fps
