"""Questions: pairs, sides, and reproducibility by the seed."""

from collections import Counter
from itertools import combinations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from npss import study

MODELS = ["VGRU-r1", "MBR-unsup", "MBR-long", "VGRU-ac", "GRU-d", "VGRU-d"]


def pair(question):
    return frozenset((question.model_a, question.model_b))


@given(st.integers(2, 7), st.integers(1, 60), st.integers(0, 2**32))
def test_every_deal_holds_every_pair_once(n_models, n_questions, seed):
    models = [f"model {i}" for i in range(n_models)]
    pairs = {frozenset(two) for two in combinations(models, 2)}
    questions = study.design(models, [3, 5, 8], n_questions, seed=seed)
    assert [question.number for question in questions] == list(range(1, n_questions + 1))
    for start in range(0, n_questions, len(pairs)):
        deal = [pair(question) for question in questions[start : start + len(pairs)]]
        assert len(set(deal)) == len(deal)
        assert set(deal) <= pairs
        assert len(deal) < len(pairs) or set(deal) == pairs
    assert {question.sequence for question in questions} <= {3, 5, 8}
    assert questions == study.design(models, [3, 5, 8], n_questions, seed=seed)


def test_the_papers_survey_has_five_pairs_twice():
    questions = study.design(MODELS, range(8), 20, seed=0)
    assert sorted(Counter(map(pair, questions)).values()) == [1] * 10 + [2] * 5


def test_sides_sequences_and_order_are_by_chance():
    rng = np.random.default_rng(1)
    surveys = [study.design(MODELS, range(8), 20, seed=rng) for _ in range(300)]
    questions = [question for survey in surveys for question in survey]
    left = sum(question.model_a < question.model_b for question in questions)
    assert stats.binomtest(left, len(questions)).pvalue > 0.001
    sequences = np.bincount([question.sequence for question in questions], minlength=8)
    assert stats.chisquare(sequences).pvalue > 0.001
    first = Counter(pair(survey[0]) for survey in surveys)
    assert len(first) == 15
    assert stats.chisquare(list(first.values())).pvalue > 0.001
    # With replacement: of 20 draws among 8, some sequence comes again in every survey, and seldom all are there.
    assert 0 < sum(len({question.sequence for question in survey}) < 8 for survey in surveys) < 300


def test_attention_checks_come_last_and_change_no_question():
    plain, checked = (study.design(MODELS, range(8), 20, seed=3, attention_checks=n) for n in (0, 200))
    assert checked[:20] == plain
    assert [question.number for question in checked] == list(range(1, 221))
    assert {question.expected for question in plain} == {None}
    for check in checked[20:]:
        right, wrong = (check.model_a, check.model_b) if check.expected == "A" else (check.model_b, check.model_a)
        assert (right, wrong) == ("ground truth", "ground truth, upside down")
    left = sum(check.expected == "A" for check in checked[20:])
    assert stats.binomtest(left, 200).pvalue > 0.001
    assert stats.chisquare(np.bincount([check.sequence for check in checked[20:]], minlength=8)).pvalue > 0.001


def test_mirrored():
    question = study.Question(3, 1, "x", "y", "A")
    assert question.mirrored() == study.Question(3, 1, "y", "x", "B")
    assert question.mirrored().mirrored() == question
    assert study.Question(3, 1, "x", "y").mirrored().expected is None


def test_other_seeds_ask_other_questions():
    first, second = (study.design(MODELS, range(8), 20, seed=seed) for seed in (0, 1))
    assert first != second


def test_arrays_of_sequences():
    questions = study.design(MODELS, np.arange(8), 3, seed=0)
    assert all(type(question.sequence) is int for question in questions)
    assert questions == study.design(tuple(MODELS), range(8), 3, seed=0)


@pytest.mark.parametrize(
    ("changed", "error", "message"),
    [
        ({"models": ["one"]}, ValueError, r"models: expected 2 or more without duplicates, got \['one'\]"),
        ({"models": ["one", "two", "one"]}, ValueError, "models: expected 2 or more without duplicates"),
        ({"models": "one two"}, TypeError, "models: expected a sequence of names"),
        ({"models": ["one", 2]}, TypeError, "models: expected names, got 2"),
        ({"sequences": []}, ValueError, "sequences: expected 1 or more without duplicates"),
        ({"sequences": [1, 1]}, ValueError, "sequences: expected 1 or more without duplicates"),
        ({"sequences": 8}, TypeError, "sequences: expected a sequence of whole numbers, got 8"),
        ({"sequences": [0.5]}, TypeError, r"sequences: expected whole numbers, got 0\.5"),
        ({"n_questions": 0}, ValueError, "n_questions: expected a positive integer, got 0"),
        ({"attention_checks": -1}, ValueError, "attention_checks: expected 0 or more, got -1"),
        ({"attention_checks": 0.5}, TypeError, r"attention_checks: expected a whole number, got 0\.5"),
        (
            {"models": ["one", "ground truth"], "attention_checks": 1},
            ValueError,
            "models: 'ground truth' is what an attention check shows; expected another name",
        ),
        ({"seed": "0"}, TypeError, r"seed: expected a whole number or a numpy\.random\.Generator, got '0'"),
    ],
)
def test_errors(changed, error, message):
    arguments = {"models": MODELS, "sequences": range(8), "n_questions": 20, "seed": 0, **changed}
    with pytest.raises(error, match=message):
        study.design(**arguments)
