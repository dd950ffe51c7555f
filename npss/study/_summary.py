"""Results of a study as values for JSON: votes on models, and with scores, the agreement of metrics."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import Any

from npss._analysis.sign_flip import MIN_BLOCKS_OF_TEST
from npss._metric.convention import CONVENTIONS
from npss._metric.registry import EULER_ERROR
from npss._metric.signature import higher_is_better
from npss.study._agreement import agreement, joint_agreement
from npss.study._design import CHOICES, Choice
from npss.study._input import Alternative
from npss.study._intervals import wilson_interval
from npss.study._kappa import kappa
from npss.study._paired import mcnemar_test
from npss.study._preference import Preference, preference_tests
from npss.study._ranking import model_scores, predict, rank, score_of
from npss.study._two_samples import binomial_test
from npss.study._votes import Count, Vote, attention, count_votes

#: Confidence level of all intervals.
LEVEL = 0.95
#: The meanings of the numbers.
MEANINGS = {
    "majorities": "A or B, whichever has more votes; votes for a tie count for neither; equal numbers are a tie",
    "sides": "votes for the motion on the left (A), on the right (B), and for neither",
    "attention": "a participant who answers an attention check other than expected fails; the votes are counted unless "
    "excluded on request, the checks never are",
    "fleiss_kappa": "Fleiss 1971 with the categories A, B and tie; 1: full agreement of participants, 0: chance",
    "share": "the mean of the participants' shares of answers for the first model, without ties; from, to: the shares "
    f"that the test does not reject, level {LEVEL:g}, or where most participants have a share of 0 or 1, Wilson's "
    "interval with the participants as trials, which does not follow from the test",
    "preference_test": "two-sided sign-flip test of the shares against 1/2, with the participant as the unit: pooled "
    f"votes err where tastes differ; fewer than {MIN_BLOCKS_OF_TEST} participants give no p-value; corrected: by "
    "Holm's correction over all pairs",
    "score": "lower is better, unless the signature says better:higher; euler_error is the sum at 80, 160, 320, 400, "
    "560 and 1000 ms",
    "rank": "scores that are equal up to rounding (1e-9 of them) share a rank, and the next ranks are skipped",
    "rate": f"share of the questions without a tie, with Wilson's interval of level {LEVEL:g}",
    "binomial_test": "treats the metrics' answers as independent samples, as the NPSS paper does; they are not",
    "mcnemar_test": "the test for two metrics that answer the same questions, taken as independent; but a metric gives "
    "all questions about a pair of models on an action one answer, so with few pairs the test errs more often than its "
    "level",
    "alternative": "one-sided, greater, is the default, as in the NPSS paper, which expected NPSS to agree more often; "
    "test two-sided unless you chose a side before you saw the votes",
}


def summary(
    votes: Sequence[Vote],
    records: Sequence[Mapping[str, Any]] | None = None,
    *,
    conventions: Sequence[str] | None = None,
    alternative: Alternative = "greater",
    exclude_failed: bool = False,
) -> dict[str, Any]:
    """Summarise votes on models, and with records of their scores, the agreement of metrics.

    Parameters
    ----------
    votes : sequence of Vote
        The votes.
    records : sequence of dict, optional
        As for `model_scores`.
    conventions : sequence of str, optional
        Conventions of NPSS that the records must have (default: those that they have).
    alternative : {'greater', 'less', 'two-sided'}, optional
        Whether NPSS agrees with the majority more often than the Euler error, less often, or either.
    exclude_failed : bool, optional
        Whether to leave out the votes of participants who fail an attention check.

    Returns
    -------
    dict
        ``overall``, ``actions``, ``incomplete``, ``pairs``; if there are attention checks, ``attention``; with records
        ``metrics`` and ``comparisons``, and if there are none, ``not_compared``, the reason; ``meanings``.

    Raises
    ------
    ValueError
        If participants who fail are to be left out but there are no attention checks, or nobody
        passes them.
    """
    checked = _attention(votes, exclude_failed)
    excluded = checked["failed"] if checked and exclude_failed else {}
    votes = [vote for vote in votes if not vote.question.expected and vote.participant not in excluded]
    counts = count_votes(votes)
    actions = list(dict.fromkeys(count.action for count in counts))
    results: dict[str, Any] = {
        "overall": _participants(votes, counts),
        "actions": {
            action: _participants([vote for vote in votes if vote.action == action], _of(action, counts))
            for action in actions
        },
        "incomplete": _incomplete(votes, len(counts)),
        "pairs": _pairs(counts, preference_tests(votes, level=LEVEL)),
    }
    if checked:
        results["attention"] = checked
    if records is not None:
        results |= _metrics(counts, records, conventions, alternative)
    return results | {"meanings": MEANINGS}


def _attention(votes: Sequence[Vote], exclude: bool) -> dict[str, Any] | None:
    """Return who failed the attention checks; None if there are none."""
    participants = attention(votes)
    checked = [of for of in participants if of.checks]
    failed = {of.participant: {"checks": of.checks, "right": of.right} for of in checked if not of.passed}
    if exclude and not checked:
        raise ValueError("votes: no attention checks in them, so nobody can be left out for failing them")
    if exclude and len(failed) == len(participants):
        raise ValueError("votes: every participant failed an attention check, so no votes are left")
    if not checked:
        return None
    return {"participants": len(checked), "failed": failed, "excluded": exclude}


def _of(action: str, counts: Sequence[Count]) -> list[Count]:
    return [count for count in counts if count.action == action]


def _participants(votes: Sequence[Vote], counts: Sequence[Count]) -> dict[str, Any]:
    """Return the numbers of votes and majorities, and the agreement of participants."""
    majorities = [count.majority for count in counts]
    results: dict[str, Any] = {
        "questions": len(counts),
        "participants": len({vote.participant for vote in votes}),
        "votes": len(votes),
        "sides": {choice: sum(vote.choice == choice for vote in votes) for choice in CHOICES},
        "majorities": {choice: majorities.count(choice) for choice in CHOICES},
        "fleiss_kappa": None,
    }
    try:
        results["fleiss_kappa"] = kappa(
            [[count.a, count.b, count.tie] for count in counts],
            [f"question {count.question.number} of {count.action}" for count in counts],
        )
    except ValueError as error:
        results["fleiss_kappa_undefined"] = str(error).removeprefix("counts: ")
    return results


def _incomplete(votes: Sequence[Vote], n_questions: int) -> dict[str, int]:
    """Return the number of questions of each participant who did not answer all."""
    answered = Counter(vote.participant for vote in votes)
    return {who: n for who, n in answered.items() if n < n_questions}


def _pairs(counts: Sequence[Count], preferences: Sequence[Preference]) -> list[dict[str, Any]]:
    """Return for each pair of models the votes and majorities that each won, and the test of the preference."""
    pairs: dict[tuple[str, str], dict[str, Any]] = {}
    for count in counts:
        models, won = [count.question.model_a, count.question.model_b], [count.a, count.b]
        majority = [count.majority == "A", count.majority == "B"]
        if models[0] > models[1]:
            models, won, majority = models[::-1], won[::-1], majority[::-1]
        empty = {"models": models, "questions": 0, "votes": [0, 0], "tied_votes": 0}
        empty |= {"majorities": [0, 0], "tied_majorities": 0}
        pair = pairs.setdefault((models[0], models[1]), empty)
        pair["questions"] += 1
        pair["votes"] = [x + y for x, y in zip(pair["votes"], won, strict=True)]
        pair["tied_votes"] += count.tie
        pair["majorities"] = [x + y for x, y in zip(pair["majorities"], majority, strict=True)]
        pair["tied_majorities"] += count.majority == "tie"
    return [pairs[of.model_a, of.model_b] | {"preference": _preference(of)} for of in preferences]


def _preference(tested: Preference) -> dict[str, Any]:
    """Return the test of a preference; what it cannot tell is None."""
    known = tested.p_value is not None
    return {
        "participants": tested.participants,
        "share": tested.share if tested.participants else None,
        "interval": tested.interval if known else None,
        "interval_method": tested.interval_method if known else None,
        "p_value": tested.p_value,
        "corrected": tested.corrected,
        "method": tested.method,
        "alternative": tested.alternative,
    }


def _metrics(
    counts: Sequence[Count],
    records: Sequence[Mapping[str, Any]],
    conventions: Sequence[str] | None,
    alternative: Alternative,
) -> dict[str, Any]:
    """Return the rankings of models by each metric, its agreement with the majority, and the tests."""
    models = {
        count.action: list(
            dict.fromkeys(
                model
                for other in _of(count.action, counts)
                for model in (other.question.model_a, other.question.model_b)
            )
        )
        for count in counts
    }
    relevant = [record for record in records if record.get("model") in models.get(record.get("action", ""), ())]
    others = dict.fromkeys(column for record in relevant for column in record.get("metrics", {}))
    candidates = (*(CONVENTIONS if conventions is None else conventions), EULER_ERROR.name, *others)
    names = [
        name
        for name in candidates
        if name in (conventions or ()) or any(score_of(record, name) is not None for record in relevant)
    ]
    if not names:
        voted = "; ".join(f"{action}: {', '.join(of_action)}" for action, of_action in models.items())
        raise ValueError(f"records: neither NPSS nor the Euler error of the models in the votes ({voted})")
    metrics: dict[str, Any] = {}
    predictions: dict[str, list[Choice]] = {}
    for name in names:
        scores = {action: model_scores(relevant, models[action], action=action, metric=name) for action in models}
        signatures = {action: _signature(relevant, action, name) for action in models}
        own = name in CONVENTIONS or name == EULER_ERROR.name
        higher = {action: bool(not own and text and higher_is_better(text)) for action, text in signatures.items()}
        ranks = {action: rank(scores[action], lower_is_better=not higher[action]) for action in models}
        predictions[name] = [predict(count.question, ranks[count.action]) for count in counts]
        metrics[name] = {
            "signatures": signatures,
            "rankings": {
                action: [
                    {"model": model, "score": scores[action][model], "rank": place}
                    for model, place in ranks[action].items()
                ]
                for action in models
            },
            "overall": _agreement(counts, ranks),
            "actions": {action: _agreement(_of(action, counts), ranks) for action in models},
        }
    if EULER_ERROR.name not in names:
        missing = "they have no Euler error of the models in the votes, with which other metrics are compared"
    elif len(names) == 1:
        missing = "they have no other metric of the models in the votes than the Euler error"
    else:
        majorities = [count.majority for count in counts]
        pairs = {(count.action, frozenset((count.question.model_a, count.question.model_b))) for count in counts}
        comparisons = [
            {"a": name, "b": EULER_ERROR.name, "questions": len(counts), "pairs": len(pairs)}
            | _comparison(predictions[name], predictions[EULER_ERROR.name], majorities, alternative)
            for name in names
            if name != EULER_ERROR.name
        ]
        return {"metrics": metrics, "comparisons": comparisons}
    return {"metrics": metrics, "comparisons": [], "not_compared": f"records: {missing}"}


def _signature(records: Sequence[Mapping[str, Any]], action: str, metric: str) -> str | None:
    """Return the signature of the scores of an action; `model_scores` has checked that all models share it."""
    first = next(r for r in records if r["action"] == action and score_of(r, metric) is not None)
    text: str | None = first.get("signatures", {}).get(metric)
    return text


def _agreement(counts: Sequence[Count], ranks: Mapping[str, Mapping[str, int]]) -> dict[str, Any]:
    predictions = [predict(count.question, ranks[count.action]) for count in counts]
    counted = agreement(predictions, [count.majority for count in counts])
    return {
        **asdict(counted),
        "rate": counted.rate() if counted.n else None,
        "interval": wilson_interval(counted.agreed, counted.n, level=LEVEL) if counted.n else None,
    }


def _comparison(
    first: Sequence[Choice], second: Sequence[Choice], majorities: Sequence[Choice], side: Alternative
) -> dict[str, Any]:
    """Return the tests of two metrics, for independent and for paired samples."""
    a, b, joint = (
        agreement(first, majorities),
        agreement(second, majorities),
        joint_agreement(first, second, majorities),
    )
    independent = binomial_test(a.agreed, a.n, b.agreed, b.n, alternative=side, level=LEVEL) if a.n and b.n else None
    return {
        "joint": asdict(joint),
        "binomial_test": asdict(independent) if independent else None,
        "mcnemar_test": asdict(mcnemar_test(joint.only_a, joint.only_b, alternative=side)),
    }
