"""The selection of weights by scores on validation windows."""

from __future__ import annotations

import math
from collections.abc import Sequence

import npss
from npss.predictors import Predictor
from npss.protocol import FPS, SLICES_MS
from npss_baselines.data.tasks import Task

_CONVENTIONS: tuple[npss.ConventionName, ...] = ("released", "paper")

#: Numbers by name: ``npss_released``, ``npss_paper``, ``euler_80`` and so on.
Row = dict[str, float]


def measure(predictors: Sequence[Predictor], tasks: Sequence[Task]) -> Row:
    """Measure predictors, each on its task: NPSS and the Euler error at the field's times, averaged over tasks."""
    rows = []
    for predictor, task in zip(predictors, tasks, strict=True):
        gt = npss.poses_to_euler(task.target)
        pred = npss.poses_to_euler(predictor(task.seed_frames, task.target.shape[1]))
        row = {f"npss_{name}": npss.score(gt, pred, convention=name) for name in _CONVENTIONS}
        row |= {f"euler_{time}": error for time, error in npss.euler_error(gt, pred, at_ms=SLICES_MS).items()}
        rows.append(row)
    return {name: math.fsum(row[name] for row in rows) / len(rows) for name in rows[0]}


def criterion(row: Row, select: str) -> float:
    """Return the value to minimise: NPSS for ``'released'`` or ``'paper'``; the average Euler error for ``'euler'``."""
    if select == "euler":
        return math.fsum(row[f"euler_{time}"] for time in SLICES_MS) / len(SLICES_MS)
    return row[f"npss_{select}"]


def best(rows: Sequence[Row], select: str) -> Row:
    """Return the row of the weights to keep; of equal ones, the first."""
    return rows[-1] if select == "last" else min(rows, key=lambda row: criterion(row, select))


def signature(tasks: Sequence[Task]) -> str:
    """Return the signature of the numbers in a row."""
    return npss.signature(
        _CONVENTIONS,
        metric="npss+euler_error",
        representation="euler",
        frames=tasks[0].target.shape[1],
        fps=FPS,
        protocol=tasks[0].protocol,
        actions=",".join(task.action for task in tasks),
        columns="gt",
        average="at",
        unwrap="off",
    )
