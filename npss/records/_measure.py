"""Measure a prediction: all its numbers, with their signatures."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any, Literal

import numpy as np
import numpy.typing as npt

from npss._analysis.blocks import STATISTICS_VERSION, Label, read_groups
from npss._analysis.fingerprint import fingerprint
from npss._metric.contributions import contributions
from npss._metric.convention import CONVENTIONS, ConventionName, as_convention
from npss._metric.euler_error import euler_error, moving_pair, sequence_errors
from npss._metric.fields import Value
from npss._metric.metric import Metric
from npss._metric.registry import EULER_ERROR, NPSS, metric_called
from npss._metric.score import quotient, score_windows, weighted_sums
from npss._metric.signature import parse_signature, signature, stated_of, stated_with, with_fields_of
from npss.console._progress import Progress
from npss.protocol._claims import check_claims
from npss.rotations._unwrap import unwrap
from npss.skeleton import poses_to_positions
from npss.validation import Float64, each, motion_pair, positive_number, renamed

#: A record as `measure` returns it, or as JSON holds it.
Record = dict[str, Any]
#: The frames in which jumps of 2 pi are removed.
Unwrapped = Literal["off", "target", "seed"]

#: The entries of a record that hold numbers.
NUMBERS = ("npss", "npss_windows", "euler_error", "metrics")


@renamed(seed="seed_frames", edges_s="edges_ms")
def measure(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    conventions: Sequence[ConventionName] = tuple(CONVENTIONS),
    fps: float | None = None,
    at_ms: Sequence[int] = (),
    angles: bool = True,
    edges_ms: Sequence[float] = (),
    metrics: Sequence[str] = (),
    poses: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    positions: tuple[npt.ArrayLike, npt.ArrayLike] | None = None,
    unwrapped: Unwrapped = "off",
    seed_frames: npt.ArrayLike | None = None,
    workers: int = 1,
    sequences: bool = False,
    groups: Iterable[Label | None] | None = None,
    extra: Mapping[str, Value] | None = None,
    **context: Value,
) -> Record:
    """Measure a prediction by several metrics.

    Parameters
    ----------
    gt, pred : (N, T, D) or (T, D) array_like
        As for `score`.
    conventions : sequence of str, optional
        Conventions to score by.
    fps : float, optional
        Frames per second; needed for `at_ms` and `edges_ms`.
    at_ms : sequence of int, optional
        Times of the Euler error and of other metrics with times, in milliseconds (default: no Euler error).
    angles : bool, optional
        Whether the features are angles, which have an Euler error.
    edges_ms : sequence of float, optional
        Edges of windows to score, in milliseconds (default: no windows).
    metrics : sequence of str, optional
        Names or headings of other registered metrics; see `npss.metrics`. Metrics with times are measured at `at_ms`.
    poses : pair of (N, T, 99) array_like, optional
        Ground truth and prediction as Human3.6M poses, exponential maps, for metrics that take poses or positions.
    positions : pair of (N, T, J, 3) array_like, optional
        Ground truth and prediction as positions of any joints in millimetres, for metrics that take positions.
    unwrapped : {'off', 'target', 'seed'}, optional
        Remove jumps of 2 pi before NPSS (never for other metrics): in the target only, or from the seed on.
    seed_frames : array_like, optional
        The seed frames, for ``unwrapped='seed'``.
    workers : int, optional
        As for `score`.
    sequences : bool, optional
        Also measure single sequences, from which intervals and comparisons are made.
    groups : sequence of str, int or None, optional
        The blocks of the sequences, as for `npss.report`; stored with the single sequences.
    extra : mapping of str to str, int, float or bool; optional
        Fields of your own for the signature.
    **context
        Known fields for the signature, checked as by `npss.report`.

    Returns
    -------
    dict
        The numbers: ``npss`` by convention, ``npss_windows`` by convention and window, ``euler_error`` by time, and
        ``metrics`` by column, as far as requested. ``still``, if any: the indices of sequences without an Euler error,
        since nothing moves in their ground truth. ``signature``, of NPSS and the Euler error together, and
        ``signatures``, of each number by convention, metric or column. ``sequences``, if requested, has lists with a
        value for each sequence: ``npss`` by convention and its ``weight`` (the score is the weighted mean),
        ``euler_error`` by time (None for a still sequence), ``metrics`` by column (with any weights in ``weight``), the
        ground truth's ``fingerprint``, any ``groups``, and ``statistics``, the version of the rules for them.

    Raises
    ------
    TypeError, ValueError
        As `npss.score`, `npss.euler_error` and `npss.signature`. If a metric is unknown, lacks the motion or the times
        that it takes, or its function returns an invalid value.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.records import measure
    >>> gt = np.linspace(0, 1, 25)[:, np.newaxis] * [1.0, 2.0]
    >>> record = measure(gt, gt, fps=25, at_ms=[80], metrics=["mse"], conventions=["paper"])
    >>> record["npss"], record["euler_error"], record["metrics"]
    ({'paper': 0.0}, {'80': 0.0}, {'MSE': 0.0})
    """
    others = _others(metrics, at_ms, poses, positions)
    gt, pred = features = motion_pair(gt, pred, context.get("representation"))
    record: Record = {}
    by_sequence: Record = {}  # values of single sequences
    if sequences:
        by_sequence["statistics"] = STATISTICS_VERSION
        truth = motion_pair(gt, pred)[0]
        by_sequence["fingerprint"] = fingerprint(truth).tolist()
        labels = read_groups("groups", groups, len(truth) if truth.ndim == 3 else 1)
        if labels is not None:
            by_sequence["groups"] = list(labels)
    fields = stated_with(measure, context, extra, unwrap=unwrapped)
    if fps is not None:
        fields["fps"] = positive_number("fps", fps)
    truth, prediction = motion_pair(gt, pred)
    if (verification := check_claims(fields, truth, pred=prediction)) is not None:
        fields |= verification.stated
    joint = NPSS.name
    if at_ms and angles:
        moving, predicted, still = moving_pair(gt, pred)
        record["euler_error"] = {}
        if still.any():
            record["still"] = np.flatnonzero(still).tolist()
        if not still.all():
            errors = euler_error(moving, predicted, fps=_needed(fps), at_ms=at_ms)
            record["euler_error"] = {str(time): error for time, error in errors.items()}
            if sequences:
                frames = {str(time): round(time * _needed(fps) / 1000) for time in errors}
                by_sequence["euler_error"] = _by_time(sequence_errors(moving, predicted), still, frames)
            fields |= EULER_ERROR.stated() | ({"still": int(still.sum())} if still.any() else {})
            joint = f"{NPSS.name}+{EULER_ERROR.name}"
    if unwrapped != "off":
        start = seed_frames if unwrapped == "seed" else None
        gt, pred = unwrap(gt, seed_frames=start), unwrap(pred, seed_frames=start)
    record["npss"] = {}
    if sequences:
        by_sequence |= {"npss": {}, "weight": {}}
        record["sequences"] = by_sequence
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
        by_sequence["npss"][name] = np.divide(numerator, weight, out=np.zeros(len(weight)), where=weight > 0).tolist()
        by_sequence["weight"][name] = weight.tolist()
    if edges_ms:
        record["npss_windows"] = {
            name: score_windows(gt, pred, fps=_needed(fps), edges_ms=edges_ms, convention=name, workers=workers)
            for name in conventions
        }
    named = conventions[0] if len(conventions) == 1 else tuple(conventions)
    record["signature"] = signature(named, metric=joint, **fields)
    record["signatures"] = {name: signature_of(record, NPSS.name, name) for name in conventions}
    if record.get("euler_error"):
        record["signatures"][EULER_ERROR.name] = signature_of(record, EULER_ERROR.name)
    for other in others:
        _add(record, other, features, poses, positions, fps, at_ms)
    return record


def signature_of(record: Record, metric: str, convention: str | None = None, **context: Value) -> str:
    """Return the signature of one number of a record.

    Parameters
    ----------
    record : dict
        A record from `measure`.
    metric : str
        The name of the metric: ``'npss'``, ``'euler_error'``, or another registered one.
    convention : str, optional
        The convention, for ``'npss'``.
    **context
        Further fields of this number, such as ``window='0-1'``.

    Returns
    -------
    str
        The signature.

    Raises
    ------
    TypeError, ValueError
        As `npss.signature`; if the metric is unknown.

    Examples
    --------
    >>> from npss.records import signature_of
    >>> record = {"signature": "npss+euler_error|version:1|convention:paper+released|frames:100|average:at|columns:gt"}
    >>> signature_of(record, "npss", "released", window="0-1")
    'npss|version:1|convention:released|frames:100|window:0-1'
    """
    fields = stated_of(metric, parse_signature(record["signature"]))
    return signature(**{**fields, "convention": convention, **context})


def _others(metrics: Sequence[str], at_ms: Sequence[float], poses: object, positions: object) -> list[Metric]:
    """Return the metrics of these names, and check that their inputs are given."""
    others: list[Metric] = []
    for name in each("metrics", metrics, "names"):
        metric = metric_called(name, "metrics")
        if metric is NPSS or metric is EULER_ERROR:
            how = "at the times of at_ms" if metric.has_times else "by each of the conventions"
            raise ValueError(f"metrics: {metric.name!r} is always measured, {how}; leave it out")
        if metric in others:
            raise ValueError(f"metrics: {name!r} is a duplicate")
        if metric.takes != "angles" and poses is None and not (metric.takes == "positions" and positions is not None):
            raise ValueError(f"metrics: {name!r} takes {metric.takes}; give poses, exponential maps of Human3.6M")
        if metric.has_times and not at_ms:
            raise ValueError(f"metrics: {name!r} is measured at the times of at_ms; give at_ms")
        if metric.has_conventions:
            raise ValueError(f"metrics: {name!r} has conventions, which only NPSS can have here")
        others.append(metric)
    return others


def _add(
    record: Record,
    metric: Metric,
    features: Any,
    poses: Any,
    positions: Any,
    fps: float | None,
    at_ms: Sequence[float],
) -> None:
    """Add the numbers of another metric to a record."""
    of_poses = metric.takes == "positions" and positions is None
    gt, pred = features if metric.takes == "angles" else poses if metric.takes == "poses" or of_poses else positions
    if of_poses:
        gt, pred = poses_to_positions(gt), poses_to_positions(pred)
    fields = with_fields_of(metric, stated_of(metric.name, parse_signature(record["signature"])))
    if metric.takes == "positions" and metric.fields.get("root", "") is None:
        fields["extra"] = {**fields["extra"], "root": "fixed" if of_poses else "given"}
    for time in at_ms if metric.has_times else (None,):
        measured = metric.measure(gt, pred, fps=fps, at_ms=time)
        column = metric.column(at_ms=time)
        record.setdefault("metrics", {})[column] = measured.value
        record["signatures"][column] = signature(**fields | ({} if time is None else {"at_ms": time}))
        by_sequence, values = record.get("sequences"), measured.by_sequence()
        if by_sequence is None or values is None:
            continue
        by_sequence.setdefault("metrics", {})[column] = values.tolist()
        if metric.aggregation == "weighted mean":
            by_sequence["weight"][column] = np.asarray(measured.weight).tolist()


def _by_time(errors: Float64, still: npt.NDArray[np.bool_], frames: Mapping[str, int]) -> dict[str, list[float | None]]:
    """Return the error of each sequence at some frames, counted from 1: None for still sequences."""
    by_frame = np.full((len(still), errors.shape[1]), np.nan)
    by_frame[~still] = errors
    return {
        time: [None if np.isnan(error) else error for error in by_frame[:, frame - 1].tolist()]
        for time, frame in frames.items()
    }


def _needed(fps: float | None) -> float:
    if fps is None:
        raise ValueError("fps: expected the frames per second, which times in milliseconds need, got None")
    return fps
