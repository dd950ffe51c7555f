"""The numbers of a record: every convention, window and time, by sequence or block, and by draw."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

import npss
from npss import poses_to_euler, protocol
from npss.predictors import Predictor
from npss.records import Record, Unwrapped
from npss.records import measure as measure_angles
from npss.validation import Array
from npss_baselines.data.tasks import Task
from npss_baselines.evaluation.draws import over_draws
from npss_baselines.evaluation.evaluate import EDGES_MS, evaluate

#: Draws of a model with noise: the NPSS paper's tables are over 30. Fewer on many windows, which vary less.
DRAWS, DRAWS_OF_MANY = 30, 5
#: More windows than these are recorded by block, not by sequence.
MANY = 64


def measure(
    name: str, predictor_of: Callable[[str], Predictor], task: Task, *, draws: int | None = None, **options: Any
) -> Record:
    """Measure a predictor on a task, over draws if it has noise.

    Parameters
    ----------
    name : str
        The name of the row.
    predictor_of : callable
        Returns the predictor of an action, with its noise at the start.
    task : Task
        The windows.
    draws : int, optional
        The number of draws (default: `DRAWS`, or `DRAWS_OF_MANY` on many windows).
    **options
        Options of `npss_baselines.evaluation.evaluate.evaluate`.

    Returns
    -------
    dict
        A record, averaged over draws, with single sequences; on many windows, ``sequences`` holds blocks instead: the
        weighted mean of each. If the predictor has noise, ``by_draw`` lists the numbers of each draw. On few windows,
        ``amplitude`` holds the mean amplitude by frequency (`amplitude`) of ``truth`` and ``prediction``, ``parts``
        what each score is made of (`npss.Parts`), ``sequences_of_windows`` the ``npss`` and ``weight`` of single
        sequences by window of time, and ``speed_ratio`` that of `npss.speed_ratio` after the first second.
    """
    predictor, many = predictor_of(task.action), len(task.target) > MANY
    n = (DRAWS_OF_MANY if many else DRAWS) if draws is None else draws
    predictions = [predictor(task.seed_frames, task.target.shape[1]) for _ in range(min(n, 2))]
    if len(predictions) == 2 and np.array_equal(predictions[0], predictions[1]):
        n, predictions = 1, predictions[:1]
    records = []
    for i in range(n):
        pred = predictions[i] if i < len(predictions) else predictor(task.seed_frames, task.target.shape[1])
        record = evaluate(name, lambda *_, pred=pred: pred, task, sequences=True, **options)
        records.append(record if many else record | _of_few(task, pred, options.get("unwrapped", "off")))
    record = records[0] if n == 1 else over_draws(records)
    if n > 1:
        record["by_draw"] = {
            section: {key: [one[section][key] for one in records] for key in record[section]}
            for section in ("npss", "euler_error")
        }
    if many and "groups" in record["sequences"]:
        record["sequences"] = in_blocks(record["sequences"])
    return record


def amplitude(motion: Array, moves: Array) -> list[float]:
    """Return the mean amplitude by frequency over the features that move.

    Parameters
    ----------
    motion : (N, T, D) ndarray
        Euler angles in radians; jumps of 2 pi are removed.
    moves : (N, D) ndarray of bool
        The features that count.

    Returns
    -------
    list of float
        For each frequency of k whole cycles in T frames, k = 0 .. T // 2, the amplitude of the cosine in radians,
        rounded to 1e-6.

    Examples
    --------
    >>> t = np.arange(8)
    >>> amplitude((1 + 0.5 * np.cos(2 * np.pi * 2 * t / 8))[np.newaxis, :, np.newaxis], np.array([[True]]))
    [1.0, 0.0, 0.5, 0.0, 0.0]
    """
    n_frames = motion.shape[1]
    heights = np.abs(np.fft.rfft(npss.unwrap(motion), axis=1)) / n_frames  # (N, K, D)
    heights[:, 1 : (n_frames + 1) // 2] *= 2  # these bins have a twin
    return [round(float(value), 6) for value in heights.swapaxes(0, 1)[:, moves].mean(axis=1)]


def _of_few(task: Task, pred: Array, unwrapped: Unwrapped) -> Record:
    """Return what a record of few windows holds besides."""
    gt, angles = poses_to_euler(task.target), poses_to_euler(pred)
    moves = gt.std(axis=1) > protocol.MOVES
    amplitudes = {"truth": amplitude(gt, moves), "prediction": amplitude(angles, moves)}
    if unwrapped != "off":
        start = poses_to_euler(task.seed_frames) if unwrapped == "seed" else None
        gt, angles = (npss.unwrap(motion, seed_frames=start) for motion in (gt, angles))
    windows = {}
    for first, last in itertools.pairwise(EDGES_MS):
        frames = slice(first * protocol.FPS // 1000, last * protocol.FPS // 1000)
        sequences = measure_angles(gt[:, frames], angles[:, frames], sequences=True)["sequences"]
        windows[f"{first // 1000}-{last // 1000}"] = {name: sequences[name] for name in ("npss", "weight")}
    return {
        "amplitude": amplitudes,
        "parts": {name: npss.report(gt, angles, convention=name).parts._asdict() for name in npss.CONVENTIONS},
        "sequences_of_windows": windows,
        "speed_ratio": npss.speed_ratio(gt, angles, start=protocol.FPS),
    }


def in_blocks(sequences: Record) -> Record:
    """Return blocks in place of the single sequences of a record.

    Each number becomes the weighted mean of a block, its weight the sum, and its fingerprint the sum; the sequences in
    no block become one. Intervals and comparisons are made from blocks, so that they stay the same. The Euler error has
    no weights, and is left out.

    Examples
    --------
    >>> sequences = {"npss": {"paper": [1.0, 2.0, 5.0]}, "weight": {"paper": [1.0, 3.0, 2.0]}, "statistics": 2}
    >>> in_blocks({**sequences, "fingerprint": [[1.0], [2.0], [3.0]], "groups": ["a", "a", None]})["npss"]
    {'paper': [1.75, 5.0]}
    """
    labels: list[str | None] = list(dict.fromkeys(sequences["groups"]))
    members = [[i for i, label in enumerate(sequences["groups"]) if label == block] for block in labels]

    def sums(values: Sequence[Any]) -> list[Any]:
        return [np.sum([values[i] for i in of_block], axis=0).tolist() for of_block in members]

    weight = {name: sums(values) for name, values in sequences["weight"].items() if name in sequences["npss"]}
    npss = {}
    for name, values in sequences["npss"].items():
        terms = sums([value * each for value, each in zip(values, sequences["weight"][name], strict=True)])
        npss[name] = [term / total if total else 0.0 for term, total in zip(terms, weight[name], strict=True)]
    return {
        "statistics": sequences["statistics"],
        "fingerprint": sums(sequences["fingerprint"]),
        "groups": labels,
        "npss": npss,
        "weight": weight,
    }
