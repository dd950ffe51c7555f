"""Evaluate trained models, over several draws of their noise."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

import npss
from npss.records import NUMBERS, Record
from npss.validation import Seed, positive_integer
from npss_baselines.data.tasks import Task
from npss_baselines.evaluation.evaluate import evaluate
from npss_baselines.runs import folder

__all__ = ["evaluate_run", "over_draws"]


def evaluate_run(
    path: Path,
    task: Task,
    *,
    name: str | None = None,
    draws: int = 1,
    seed: Seed = 0,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> Record:
    """Measure a trained model on a task.

    Parameters
    ----------
    path : Path
        The folder of the run.
    task : Task
        The windows.
    name : str, optional
        The name of the model in the record; by default, the name of the folder.
    draws : int, optional
        Number of predictions, each with new noise; the NPSS paper's tables use 30.
    seed : int or numpy.random.Generator, optional
        Source of the noise.
    progress : callable, optional
        Called with the share of draws done.
    **options
        Options of `evaluate`.

    Returns
    -------
    dict
        As for `evaluate`. With several draws, numbers are averages over draws, ``std`` holds the standard deviations
        (divided by the number of draws, not one less), and signatures have a field ``draws``.

    Raises
    ------
    FileNotFoundError, ValueError
        If the run is broken, or was not trained on the action.
    """
    positive_integer("draws", draws)
    predictor = folder.predictor_of(path, task.action, seed=seed)
    name = path.resolve().name if name is None else name
    records = []
    for done in range(1, draws + 1):
        records.append(evaluate(name, predictor, task, **options))
        if progress is not None:
            progress(done / draws)
    return records[0] if draws == 1 else over_draws(records)


def over_draws(records: Sequence[Record]) -> Record:
    """Average records of the same model and task over draws.

    Parameters
    ----------
    records : sequence of dict
        A record of `evaluate` for each draw.

    Returns
    -------
    dict
        A record as of `evaluate_run`, with several draws.

    Examples
    --------
    >>> draws = [{"model": "m", "npss": {"paper": value}, "signature": "npss|version:1"} for value in (1.0, 2.0)]
    >>> over_draws(draws)["npss"], over_draws(draws)["std"]["npss"]
    ({'paper': 1.5}, {'paper': 0.5})
    >>> over_draws(draws)["signature"]
    'npss|version:1|draws:2'
    """
    mean: Record = averaged(records)
    std = averaged([{name: record[name] for name in NUMBERS if name in record} for record in records], np.std)
    mean["signature"] = _with_draws(mean["signature"], len(records))
    if "signatures" in mean:
        mean["signatures"] = {name: _with_draws(line, len(records)) for name, line in mean["signatures"].items()}
    return mean | {"draws": len(records), "std": std}


def averaged(values: Sequence[Any], statistic: Any = np.mean) -> Any:
    """Average the numbers in nested dictionaries and lists, or apply another statistic; keep equal text and integers.

    Examples
    --------
    >>> averaged([{"model": "m", "npss": {"paper": value}} for value in (1.0, 2.0)])
    {'model': 'm', 'npss': {'paper': 1.5}}
    """
    first = values[0]
    if isinstance(first, dict):
        return {name: averaged([value[name] for value in values], statistic) for name in first}
    if isinstance(first, list):
        return [averaged(each, statistic) for each in zip(*values, strict=True)]
    if not isinstance(first, float) and all(value == first for value in values):
        return first
    return float(statistic(values))


def _with_draws(line: str, draws: int) -> str:
    return npss.signature(**npss.parse_signature(line), draws=draws)
