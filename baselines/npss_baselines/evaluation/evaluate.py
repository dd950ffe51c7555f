"""The record of a predictor on a task."""

from __future__ import annotations

from collections.abc import Sequence

from npss import poses_to_euler, protocol
from npss.predictors import Predictor
from npss.records import Record, Unwrapped, measure
from npss_baselines.data.tasks import Task

__all__ = ["EDGES_MS", "evaluate"]

EDGES_MS = (0, 1000, 2000, 4000)  # of table 5 of the NPSS paper


def evaluate(
    name: str,
    predictor: Predictor,
    task: Task,
    *,
    metrics: Sequence[str] = (),
    unwrapped: Unwrapped = "off",
    sequences: bool = False,
) -> Record:
    """Measure a predictor on a task: NPSS under every convention, and the Euler error.

    Parameters
    ----------
    name : str
        The name of the model in the record.
    predictor : callable
        ``predictor(seed_frames, n_target)``.
    task : Task
        The windows.
    metrics : sequence of str, optional
        Names of other registered metrics: see `npss.metrics`.
    unwrapped : {'off', 'target', 'seed'}, optional
        Jumps of 2 pi to remove before NPSS: none, within the target frames, or from the seed frames on.
    sequences : bool, optional
        Whether to measure each sequence, too.

    Returns
    -------
    dict
        ``model``, ``action``, ``euler_error``, ``npss``, ``npss_windows``, ``signature`` and ``signatures``;
        ``metrics`` and ``sequences`` if requested.
    """
    gt = poses_to_euler(task.target)
    pred = predictor(task.seed_frames, task.target.shape[1])
    measured = measure(
        gt,
        poses_to_euler(pred),
        fps=protocol.FPS,
        at_ms=protocol.SLICES_MS,
        edges_ms=EDGES_MS,
        metrics=metrics,
        poses=(task.target, pred),
        unwrapped=unwrapped,
        seed_frames=poses_to_euler(task.seed_frames),
        sequences=sequences,
        groups=task.groups,
        representation="euler",
        frames=gt.shape[1],
        protocol=task.protocol,
    )
    return {"model": name, "action": task.action, **measured}
