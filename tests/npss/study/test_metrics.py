"""Metrics in a study: rankings, including the paper's, predictions, and agreement with the majority."""

import math
from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from npss import published, study
from studies import MODELS

CHOICE = st.sampled_from(("A", "B", "tie"))
# Table 2 of the paper, best first.
TABLE_2 = {
    ("euler_error", "walking"): "VGRU-r1 MBR-unsup VGRU-d MBR-long VGRU-ac GRU-d",
    ("euler_error", "eating"): "VGRU-r1 VGRU-d MBR-unsup VGRU-ac GRU-d MBR-long",
    ("euler_error", "smoking"): "VGRU-r1 MBR-unsup VGRU-d VGRU-ac GRU-d MBR-long",
    ("euler_error", "discussion"): "VGRU-r1 VGRU-d GRU-d VGRU-ac MBR-unsup MBR-long",
    ("released", "walking"): "VGRU-d GRU-d VGRU-ac VGRU-r1 MBR-long MBR-unsup",
    ("released", "eating"): "GRU-d VGRU-ac VGRU-d VGRU-r1 MBR-unsup MBR-long",
    ("released", "smoking"): "VGRU-d GRU-d VGRU-ac VGRU-r1 MBR-unsup MBR-long",
    ("released", "discussion"): "VGRU-ac GRU-d VGRU-d MBR-unsup MBR-long VGRU-r1",
}
# What follows from tables 4 and 7: the same, but for one.
ORDERS = {
    key: [f"{model} (SA)" if model in ("VGRU-r1", "MBR-unsup") else model for model in order.split()]
    for key, order in TABLE_2.items()
}
ORDERS["euler_error", "discussion"] = ["VGRU-r1 (SA)", "VGRU-ac", "VGRU-d", "GRU-d", "MBR-unsup (SA)", "MBR-long"]


def record(model, action="walking", signature="s", **numbers):
    return {
        "model": model,
        "action": action,
        "signatures": dict.fromkeys(("paper", "euler_error"), signature),
        **numbers,
    }


class TestThePaper:
    @pytest.mark.parametrize(("metric", "action"), TABLE_2)
    def test_table_2_follows_from_tables_4_and_7_but_for_one_ranking(self, metric, action):
        ranking = study.rank(study.model_scores(published.records(), MODELS, action=action, metric=metric))
        assert list(ranking.items()) == list(zip(ORDERS[metric, action], range(1, 7), strict=True))
        as_printed = " ".join(ranking).replace(" (SA)", "") == TABLE_2[metric, action]
        assert as_printed == ((metric, action) != ("euler_error", "discussion"))

    def test_the_sums_for_discussion(self):
        scores = study.model_scores(published.records(), MODELS, action="discussion", metric="euler_error")
        assert {model: f"{score:.3f}" for model, score in scores.items()} == {
            "VGRU-r1 (SA)": "7.590",
            "VGRU-ac": "11.687",
            "VGRU-d": "12.071",
            "GRU-d": "12.130",
            "MBR-unsup (SA)": "12.540",
            "MBR-long": "14.850",
        }

    def test_the_p_value(self):
        assert f"{study.binomial_test(65, 80, 39, 80).p_value:.4e}" == "1.7087e-05"

    def test_what_the_counts_alone_leave_open(self):
        """65 and 39 of 80: on how many NPSS alone can be right, and what McNemar's test says then."""
        tables = [(65 - both, 39 - both) for both in range(40) if 65 + 39 - both <= 80]
        assert (min(tables), max(tables)) == ((26, 0), (41, 15))
        p_values = [study.mcnemar_test(*table).p_value for table in tables]
        assert (f"{min(p_values):.1e}", f"{max(p_values):.1e}") == ("1.5e-08", "3.4e-04")


class TestScores:
    def test_sums_and_conventions(self):
        errors = {str(time): time / 1000 for time in (80, 160, 320, 400, 560, 1000)}
        records = [record("one", euler_error=errors, npss={"paper": 2.0}), record("two", npss={"paper": 1})]
        assert study.model_scores(records, ["two", "one"], action="walking", metric="paper") == {"two": 1, "one": 2}
        assert study.model_scores(records, ["one"], action="walking", metric="euler_error") == {
            "one": pytest.approx(2.52)
        }

    @pytest.mark.parametrize(
        ("records", "message"),
        [
            ([], "expected one with paper of 'one' on 'walking', got 0; .* this score: none$"),
            ([record("one", "eating", npss={"paper": 1.0})], "got 0"),
            ([record("one", npss={"released": 1.0})], "got 0"),
            (
                [record(name, npss={"paper": 1.0}) for name in ("two", "three")],
                "got 0; models with this score: 'two', 'three'$",
            ),
            ([record("one", npss={"paper": 1.0})] * 2, "got 2"),
        ],
    )
    def test_each_model_has_one(self, records, message):
        with pytest.raises(ValueError, match=f"records: .*{message}"):
            study.model_scores(records, ["one"], action="walking", metric="paper")

    def test_a_sum_of_other_times_is_no_sum(self):
        with pytest.raises(ValueError, match="records: expected one with euler_error of 'zero-velocity'"):
            study.model_scores(published.records(), ["zero-velocity"], action="walking", metric="euler_error")

    def test_they_must_be_comparable(self):
        records = [record("one", npss={"paper": 1.0}), record("two", signature="t", npss={"paper": 1.0})]
        with pytest.raises(ValueError, match=r"records: scores by paper have different signatures.*one: s; two: t"):
            study.model_scores(records, ["one", "two"], action="walking", metric="paper")
        assert study.model_scores(records, ["two"], action="walking", metric="paper") == {"two": 1.0}

    def test_a_signature_that_is_not_stated_is_another_one(self):
        records = [record("one", npss={"paper": 1.0}), {"model": "two", "action": "walking", "npss": {"paper": 1.0}}]
        with pytest.raises(ValueError, match=r"different signatures.*: one: s; two: not stated$"):
            study.model_scores(records, ["one", "two"], action="walking", metric="paper")
        assert study.model_scores(records, ["two"], action="walking", metric="paper") == {"two": 1.0}

    def test_records_of_other_actions_are_not_looked_at(self):
        records = [record("one", npss={"paper": 1.0}), record("one", "eating", npss={"paper": "broken"})]
        assert study.model_scores(records, ["one"], action="walking", metric="paper") == {"one": 1.0}

    @pytest.mark.parametrize("huge", [10**400, 1e308, math.inf, math.nan])
    def test_they_must_be_finite(self, huge):
        errors = dict.fromkeys(map(str, (80, 160, 320, 400, 560, 1000)), huge)
        with pytest.raises(ValueError, match="records: expected finite numbers as euler_error of 'one', got"):
            study.model_scores([record("one", euler_error=errors)], ["one"], action="walking", metric="euler_error")

    def test_they_must_be_numbers(self):
        with pytest.raises(TypeError, match=r"records: expected numbers as paper of 'one', got '1\.0'"):
            study.model_scores([record("one", npss={"paper": "1.0"})], ["one"], action="walking", metric="paper")
        with pytest.raises(TypeError, match="models: expected a sequence of names, got"):
            study.model_scores([], "one", action="walking", metric="paper")


class TestRank:
    @given(st.dictionaries(st.text(), st.integers(-5, 5), min_size=1))
    def test_is_competition_ranking(self, scores):
        expected = dict(zip(scores, stats.rankdata(list(scores.values()), method="min"), strict=True))
        assert study.rank(scores) == expected

    @given(st.dictionaries(st.text(), st.floats(allow_nan=False, allow_infinity=False) | st.floats(1, 1 + 1e-8)))
    def test_by_definition(self, scores):
        ranking = study.rank(scores)
        assert list(ranking.values()) == sorted(ranking.values())
        for model, score in scores.items():
            rounding = [max(1e-9 * max(abs(score), abs(other)), 1e-12) for other in scores.values()]
            better = [score - other > least for other, least in zip(scores.values(), rounding, strict=True)]
            assert ranking[model] == 1 + sum(better)

    def test_ties(self):
        assert study.rank({"a": 2, "b": 1, "c": 2.0, "d": 3}) == {"b": 1, "a": 2, "c": 2, "d": 4}

    def test_errors(self):
        for score in (math.nan, math.inf):
            with pytest.raises(ValueError, match="scores: expected a finite number for 'a', got"):
                study.rank({"a": score})
        with pytest.raises(TypeError, match="scores: expected a number for 'a', got None"):
            study.rank({"a": None})


class TestPredict:
    def test_the_better_rank(self):
        ranking = {"one": 1, "two": 2, "also two": 2}
        for a, b, said in (("one", "two", "A"), ("two", "one", "B"), ("two", "also two", "tie")):
            assert study.predict(study.Question(1, 0, a, b), ranking) == said

    def test_a_missing_rank(self):
        with pytest.raises(ValueError, match="ranking: 'three', of question 7, has no rank"):
            study.predict(study.Question(7, 0, "one", "three"), {"one": 1})


class TestAgreement:
    @given(st.lists(st.tuples(CHOICE, CHOICE)))
    def test_by_brute_force(self, answers):
        predictions, majorities = [said for said, _ in answers], [voted for _, voted in answers]
        found = study.agreement(predictions, majorities)
        cells = Counter(answers)
        assert found.agreed == cells["A", "A"] + cells["B", "B"]
        assert found.disagreed == cells["A", "B"] + cells["B", "A"]
        assert found.tied_votes == cells["A", "tie"] + cells["B", "tie"] + cells["tie", "tie"]
        assert found.tied_metric == cells["tie", "A"] + cells["tie", "B"]
        assert found.n + found.tied_votes + found.tied_metric == len(answers)
        if found.n:
            assert found.rate() == found.agreed / found.n
        else:
            assert math.isnan(found.rate())
        halves = [1.0 if a == b != "tie" else 0.5 if "tie" in (a, b) else 0.0 for a, b in answers]
        if halves:
            assert found.rate(ties="half") == pytest.approx(np.mean(halves))

    @given(st.lists(st.tuples(CHOICE, CHOICE, CHOICE)))
    def test_joint_by_brute_force(self, answers):
        first, second, majorities = ([answer[i] for answer in answers] for i in range(3))
        joint = study.joint_agreement(first, second, majorities)
        clear = [answer for answer in answers if "tie" not in answer]
        assert joint.both == sum(a == b == voted for a, b, voted in clear)
        assert joint.only_a == sum(a == voted != b for a, b, voted in clear)
        assert joint.only_b == sum(b == voted != a for a, b, voted in clear)
        assert joint.neither == sum(a == b != voted for a, b, voted in clear)
        assert joint.tied == len(answers) - len(clear)

    def test_errors(self):
        with pytest.raises(ValueError, match=r"predictions and majorities: their lengths differ: .*1.*2"):
            study.agreement(["A"], ["A", "B"])
        with pytest.raises(ValueError, match="predictions_b and majorities: their lengths differ"):
            study.joint_agreement(["A"], ["A"], ["A", "B"])
        with pytest.raises(ValueError, match="majorities: expected A, B, tie for question 2, got 'C'"):
            study.agreement(["A", "B"], ["A", "C"])
        with pytest.raises(ValueError, match="ties: expected one of exclude, half, got 'drop'"):
            study.agreement(["A"], ["A"]).rate(ties="drop")


def test_from_votes_to_counts():
    """People who follow one ranking: its metric is always right, another one where the two rankings order alike."""
    rng = np.random.default_rng(0)
    npss, mse = ({}, {})
    votes = []
    for action in ("walking", "eating", "smoking", "discussion"):
        for ranks, metric in ((npss, "released"), (mse, "euler_error")):
            ranks[action] = study.rank(study.model_scores(published.records(), MODELS, action=action, metric=metric))
        questions = study.design(MODELS, range(8), 20, seed=rng)
        strengths = {model: -100.0 * place for model, place in npss[action].items()}
        votes += study.simulate_votes(questions, strengths, 20, action=action, seed=rng)
    rng.shuffle(votes)
    counts = study.count_votes(votes)
    majorities = [count.majority for count in counts]
    by_npss = [study.predict(count.question, npss[count.action]) for count in counts]
    by_mse = [study.predict(count.question, mse[count.action]) for count in counts]
    assert study.agreement(by_npss, majorities) == study.Agreement(agreed=80, disagreed=0, tied_votes=0, tied_metric=0)
    alike = 0
    for count in counts:
        a, b = count.question.model_a, count.question.model_b
        orders = [ORDERS[metric, count.action] for metric in ("released", "euler_error")]
        alike += len({order.index(a) < order.index(b) for order in orders}) == 1
    assert 20 < alike < 60
    assert study.agreement(by_mse, majorities).agreed == alike
    joint = study.joint_agreement(by_npss, by_mse, majorities)
    assert (joint.both, joint.only_a, joint.only_b, joint.neither) == (alike, 80 - alike, 0, 0)
    assert study.fleiss_kappa([[count.a, count.b, count.tie] for count in counts]) == 1
