"""Ranks of models by a metric, and its predictions for questions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

from npss._analysis.ties import tied
from npss._metric.convention import CONVENTIONS
from npss._metric.registry import EULER_ERROR
from npss.protocol import SLICES_MS
from npss.study._design import Choice, Question
from npss.validation import each, is_real


def model_scores(
    records: Sequence[Mapping[str, Any]], models: Sequence[str], *, action: str, metric: str
) -> dict[str, float]:
    """Read the scores of models by a metric from records.

    Parameters
    ----------
    records : sequence of dict
        Records as ``npss-baselines evaluate --format json`` prints and `npss.published.records` returns them.
    models : sequence of str
        The models.
    action : str
        The action.
    metric : str
        ``'euler_error'``, the sum of the Euler errors at 80, 160, 320, 400, 560 and 1000 ms, by which the NPSS paper
        ranks ("MSE"); a convention of NPSS over all frames: ``'paper'``, ``'released'``, ``'literal'``; or the column
        of another metric in the records.

    Returns
    -------
    dict of str to float
        The score of each model; lower is better, unless the signature states ``better:higher``.

    Raises
    ------
    TypeError
        If a score is not a number.
    ValueError
        If a model has no such score, or more than one, or the scores have different signatures.

    Examples
    --------
    >>> from npss import published, study
    >>> models = ["VGRU-d", "GRU-d"]
    >>> study.model_scores(published.records(), models, action="walking", metric="released")
    {'VGRU-d': 0.887, 'GRU-d': 0.931}
    """
    scores: dict[str, float] = {}
    signatures: dict[str, str] = {}
    scored = [
        (record, score)
        for record in records
        if record.get("action") == action and (score := score_of(record, metric)) is not None
    ]
    for model in each("models", models, "names"):
        matches = [(record, score) for record, score in scored if record.get("model") == model]
        if len(matches) != 1:
            others = ", ".join(repr(record.get("model")) for record, _ in scored) or "none"
            raise ValueError(
                f"records: expected one with {metric} of {model!r} on {action!r}, got {len(matches)}; models with "
                f"this score: {others}"
            )
        ((record, scores[model]),) = matches
        signatures[model] = record.get("signatures", {}).get(metric, "not stated")
    if len(set(signatures.values())) > 1:
        texts = "; ".join(f"{model}: {signature}" for model, signature in signatures.items())
        raise ValueError(f"records: scores by {metric} have different signatures, so they cannot be ranked: {texts}")
    return scores


def rank(scores: Mapping[str, float], *, lower_is_better: bool = True) -> dict[str, int]:
    """Rank models by their scores, the best first.

    Parameters
    ----------
    scores : mapping of str to float
        The score of each model.
    lower_is_better : bool, optional
        Whether the lowest score is the best, or the highest.

    Returns
    -------
    dict of str to int
        Ranks from 1, the best model first. Equal scores share a rank, and the next ranks are skipped: 1, 2, 2, 4
        ("competition ranking"). Scores are equal if they differ by at most 1e-9 of the larger, or by 1e-12, which is
        rounding.

    Raises
    ------
    TypeError, ValueError
        If a score is not a finite number.

    Examples
    --------
    >>> from npss import study
    >>> study.rank({"GRU-d": 0.9, "VGRU-d": 0.8, "VGRU-ac": 0.9})
    {'VGRU-d': 1, 'GRU-d': 2, 'VGRU-ac': 2}
    """
    for model, score in scores.items():
        if not is_real(score):
            raise TypeError(f"scores: expected a number for {model!r}, got {score!r}")
        if not math.isfinite(score):
            raise ValueError(f"scores: expected a finite number for {model!r}, got {score!r}")
    losses = {model: score if lower_is_better else -score for model, score in scores.items()}
    return {
        model: 1 + sum(other < losses[model] and not tied(other, losses[model]) for other in losses.values())
        for model in sorted(losses, key=lambda model: losses[model])
    }


def predict(question: Question, ranking: Mapping[str, int]) -> Choice:
    """Predict the answer to a question: the model with the better rank.

    Parameters
    ----------
    question : Question
        The question.
    ranking : mapping of str to int
        Ranks of the models, as from `rank`.

    Returns
    -------
    {'A', 'B', 'tie'}
        The prediction; ``'tie'`` if both models have the same rank.

    Raises
    ------
    ValueError
        If a model has no rank.

    Examples
    --------
    >>> from npss import study
    >>> study.predict(study.Question(1, 4, "GRU-d", "VGRU-d"), {"VGRU-d": 1, "GRU-d": 2})
    'B'
    """
    for model in (question.model_a, question.model_b):
        if model not in ranking:
            raise ValueError(f"ranking: {model!r}, of question {question.number}, has no rank")
    a, b = ranking[question.model_a], ranking[question.model_b]
    return "tie" if a == b else "A" if a < b else "B"


def score_of(record: Mapping[str, Any], metric: str) -> float | None:
    """Return the score of a record by a metric, if it has one."""
    if metric == EULER_ERROR.name:
        parts = [record.get("euler_error", {}).get(str(time)) for time in SLICES_MS]
    elif metric in CONVENTIONS:
        parts = [record.get("npss", {}).get(metric)]
    else:
        parts = [record.get("metrics", {}).get(metric)]
    if None in parts:
        return None
    for part in parts:
        if not is_real(part):
            raise TypeError(f"records: expected numbers as {metric} of {record['model']!r}, got {part!r}")
    try:
        total = math.fsum(parts)
    except OverflowError:
        total = math.inf
    if not math.isfinite(total):
        raise ValueError(f"records: expected finite numbers as {metric} of {record['model']!r}, got {parts!r:.100}")
    return total
