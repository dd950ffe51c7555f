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
from npss._metric.score import quotient, score_windows, weighted_sums
from npss._metric.signature import parse_signature, signature, stated_of, stated_with
from npss.console._progress import Progress
from npss.console._tables import markdown_text, table
from npss.rotations._unwrap import unwrap
from npss.validation import Float64, motion_pair, positive_number, renamed

__all__ = ["Groups", "Record", "measure", "signature_of", "summary"]

Record = dict[str, Any]


@renamed(seed="seed_frames", edges_s="edges_ms")
def measure(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    conventions: Sequence[str] = tuple(CONVENTIONS),
    fps: float | None = None,
    at_ms: Sequence[int] = (),
    edges_ms: Sequence[float] = (),
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
    unwrapped : {'off', 'target', 'seed'}, optional
        Remove jumps of 2 pi before NPSS (never for the Euler error): over the target alone, or from the seed on.
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
        asked for; ``still``, the indices of sequences that the Euler error leaves out, since nothing moves in their
        ground truth, if there are any; the one ``signature`` of them all, and ``signatures``, that of each number by
        metric or convention. In ``sequences``, lists with a value for each sequence: ``npss`` by convention, ``weight``
        by convention (of which the score is the weighted mean), ``euler_error`` by time (None for a still one), and
        the ground truth's ``fingerprint``, and ``groups``, if there are some; and ``statistics``, the version of the
        rules by which they are to be read.
    """
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
    metric = "npss"
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
            stated |= {"columns": "gt", "average": "at"} | ({"still": int(still.sum())} if still.any() else {})
            metric = "npss+euler_error"
    if unwrapped != "off":
        start = seed_frames if unwrapped == "seed" else None
        gt, pred = unwrap(gt, seed_frames=start), unwrap(pred, seed_frames=start)
    record["npss"] = {}
    if sequences:
        alone |= {"npss": {}, "weight": {}}
        record["sequences"] = alone
    for name in conventions:
        truth, prediction = motion_pair(gt, pred)
        with Progress(f"NPSS {name}") as progress:
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
    record["signature"] = signature(named, metric=metric, **stated)
    record["signatures"] = {name: signature_of(record, "npss", name) for name in conventions}
    if record.get("euler_error"):
        record["signatures"]["euler_error"] = signature_of(record, "euler_error")
    return record


def signature_of(record: Record, metric: str, convention: str | None = None, **context: Value) -> str:
    """Return the signature of one number of a record.

    Parameters
    ----------
    record : dict
        As `measure` returns.
    metric : {'npss', 'euler_error'}
        Which of its numbers.
    convention : str, optional
        By which convention, for `'npss'`.
    **context
        What is particular to that number, such as ``window='0-1'``.
    """
    stated = stated_of(metric, parse_signature(record["signature"]))
    return signature(**{**stated, "convention": convention, **context})


def summary(records: Sequence[Record], *, markdown: bool = False) -> str:
    """Lay records out for people: a table an action, models in the order of NPSS, the best of each column marked."""
    parts = []
    for action in dict.fromkeys(record["action"] for record in records):
        of_action = [record for record in records if record["action"] == action]
        convention = next(iter(of_action[0]["npss"]))
        of_action.sort(key=lambda record: record["npss"][convention])
        columns = {f"NPSS {name}": [record["npss"][name] for record in of_action] for name in of_action[0]["npss"]}
        columns |= {
            f"{time} ms": [record["euler_error"][time] for record in of_action] for time in of_action[0]["euler_error"]
        }
        cells = [
            [f"{value:.4f}" + ("*" if value == min(values) else " ") for value in values] for values in columns.values()
        ]
        escaped = markdown_text if markdown else str
        names = [escaped(record["model"]) for record in of_action]
        rows = [[name, *row] for name, row in zip(names, zip(*cells, strict=True), strict=True)]
        heading = escaped(f"{action} (lower is better, * best; under ms: Euler error in radians)")
        parts.append(f"### {heading}" if markdown else heading)
        parts.append(table(["model", *columns], rows, "l" + "r" * len(columns), markdown=markdown))
        signatures = dict.fromkeys(line for record in of_action for line in record["signatures"].values())
        parts.append("\n".join(f"    {line}" for line in signatures))
    return "\n\n".join(parts)


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
