"""The results of votes, as text."""

from __future__ import annotations

from typing import Any

from npss._metric.registry import score_heading
from npss.console._tables import table
from npss.ranking._names import one_line
from npss.study._summary import LEVEL, MEANINGS


def text(results: dict[str, Any]) -> str:
    """Return the results of `npss.study._summary.summary` as tables, with the meanings of their numbers."""
    parts = [_participants(results), _pairs(results["pairs"])]
    if "attention" in results:
        parts.insert(0, _attention(results["attention"]))
    if "metrics" in results:
        parts += [_rankings(results["metrics"]), _agreements(results["metrics"])]
    if results.get("comparisons"):
        notes = _notes("alternative", "binomial_test", "mcnemar_test")
        parts += [*map(_comparison, results["comparisons"]), notes]
    if "not_compared" in results:
        parts.append(f"no comparison of metrics: {results['not_compared']}")
    return "\n\n".join(parts)


def _notes(*names: str) -> str:
    return "\n".join(f"    {name}: {MEANINGS[name]}" for name in names)


def _attention(attention: dict[str, Any]) -> str:
    """Return who failed an attention check."""
    failed, counted = attention["failed"], "left out" if attention["excluded"] else "counted"
    lines = [f"attention checks: {len(failed)} of {attention['participants']} participants failed"]
    lines += [f"    {one_line(who)}: {of['right']} of {of['checks']} right; {counted}" for who, of in failed.items()]
    return "\n".join([*lines, _notes("attention")])


def _participants(results: dict[str, Any]) -> str:
    rows, undefined = [], []
    for name, votes in (*results["actions"].items(), ("all", results["overall"])):
        kappa = votes["fleiss_kappa"]
        if kappa is None:
            undefined.append(one_line(f"fleiss_kappa of {name} is not defined: {votes['fleiss_kappa_undefined']}"))
        numbers = [votes["questions"], votes["participants"], votes["votes"], *votes["majorities"].values()]
        rows.append([one_line(name), *map(str, numbers), "-" if kappa is None else f"{kappa:.3f}"])
    sides = results["overall"]["sides"]
    header = ["action", "questions", "participants", "votes", "majority A", "majority B", "tie", "fleiss_kappa"]
    return "\n".join(
        [
            table(header, rows, "lrrrrrrr"),
            f"    sides: left {sides['A']}, right {sides['B']}, tie {sides['tie']}; {MEANINGS['sides']}",
            _notes("majorities", "fleiss_kappa"),
            *(f"    {line}" for line in undefined),
            *(
                f"    {one_line(who)}: {n} of {results['overall']['questions']} questions; counted"
                for who, n in results["incomplete"].items()
            ),
        ]
    )


def _pairs(pairs: list[dict[str, Any]]) -> str:
    rows = [
        [*map(one_line, pair["models"]), str(pair["questions"])]
        + [str(number) for number in (*pair["votes"], pair["tied_votes"])]
        + [str(number) for number in (*pair["majorities"], pair["tied_majorities"])]
        + _preference(pair["preference"])
        for pair in pairs
    ]
    header = ["first", "second", "questions", "votes first", "second", "tie", "majorities first", "second", "tie"]
    header += ["participants", "share first", "from", "to", "p", "corrected"]
    of_wilson = [
        " and ".join(map(one_line, pair["models"]))
        for pair in pairs
        if pair["preference"]["interval_method"] == "Wilson"
    ]
    lines = [table(header, rows, "ll" + "r" * 13), _notes("share", "preference_test")]
    return "\n".join([*lines, *([f"    Wilson's interval: {'; '.join(of_wilson)}"] if of_wilson else [])])


def _preference(preference: dict[str, Any]) -> list[str]:
    shares = [preference["share"], *(preference["interval"] or (None, None))]
    p_values = [preference["p_value"], preference["corrected"]]
    return [
        str(preference["participants"]),
        *("-" if share is None else f"{share:.3f}" for share in shares),
        *("-" if p_value is None else f"{p_value:.3g}" for p_value in p_values),
    ]


def _rankings(metrics: dict[str, Any]) -> str:
    rows = []
    for action, ranking in next(iter(metrics.values()))["rankings"].items():
        for model in (place["model"] for place in ranking):
            rows.append([one_line(action), one_line(model)])
            for ranked in metrics.values():
                place = next(place for place in ranked["rankings"][action] if place["model"] == model)
                rows[-1] += [f"{place['score']:.3f}", str(place["rank"])]
    header = ["action", "model", *(cell for metric in metrics for cell in (score_heading(metric), "rank"))]
    signatures = {
        f"    {score_heading(metric)}: {signature or 'signature not stated'}": None
        for metric, ranked in metrics.items()
        for signature in ranked["signatures"].values()
    }
    return "\n".join([table(header, rows, "ll" + "rr" * len(metrics)), _notes("score", "rank"), *signatures])


def _agreements(metrics: dict[str, Any]) -> str:
    rows = []
    for metric, agreements in metrics.items():
        for action, agreement in (*agreements["actions"].items(), ("all", agreements["overall"])):
            agreed, questions = agreement["agreed"], agreement["agreed"] + agreement["disagreed"]
            shares = [agreement["rate"], *agreement["interval"]] if questions else []
            rates = [f"{share:.3f}" for share in shares] or ["-"] * 3
            ties = [str(agreement["tied_votes"]), str(agreement["tied_metric"])]
            rows.append([score_heading(metric), one_line(action), f"{agreed}/{questions}", *rates, *ties])
    header = ["metric", "action", "agreed", "rate", "from", "to", "no majority", "metric tied"]
    return "\n".join([table(header, rows, "llrrrrrr"), _notes("rate")])


def _comparison(comparison: dict[str, Any]) -> str:
    joint, mcnemar, independent = (comparison[name] for name in ("joint", "mcnemar_test", "binomial_test"))
    a, b = score_heading(comparison["a"]), score_heading(comparison["b"])
    side = {"greater": "one-sided, greater", "less": "one-sided, less"}.get(mcnemar["alternative"], "two-sided")
    lines = [
        f"{a} against {b}",
        f"  {comparison['questions']} questions are about {comparison['pairs']} pairs of models on an action",
    ]
    if independent:
        low, high = independent["interval_difference"]
        lines += [
            f"  {independent['method']}, {side}: z = {independent['statistic']:.3f}, p = {independent['p_value']:.5g}",
            f"  difference of the rates: {independent['difference']:.3f}, from {low:.3f} to {high:.3f} "
            f"(Newcombe's interval of level {LEVEL:g})",
        ]
    lines += [
        f"  {mcnemar['method']}, {side}: p = {mcnemar['p_value']:.5g}; both are right on {joint['both']} questions, "
        f"only {a} on {joint['only_a']}, only {b} on {joint['only_b']}, neither on {joint['neither']}; "
        f"{joint['tied']} questions with a tie are left out",
    ]
    return "\n".join(lines)
