"""Order and sides of a survey: balanced over a block of participants and over every pair of them."""

import math
from collections import Counter
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss import study

MODELS = ["one", "two", "three", "four"]


def surveys(numbers, seed=0):
    """Return surveys of these numbers of questions, the last of each an attention check."""
    return {
        f"action {i}": study.design(MODELS, range(5), n, seed=seed + i, attention_checks=1)
        for i, n in enumerate(numbers)
    }


def square(n):
    return n if n % 2 == 0 else 2 * n


sizes = st.lists(st.integers(1, 6), min_size=1, max_size=4)


@given(sizes, st.integers(0, 2**32))
def test_a_block_is_balanced(numbers, seed):
    asked = surveys(numbers)
    block = study.counterbalance(asked, seed=seed)
    assert len(block) == math.lcm(square(len(asked)), *(square(len(questions)) for questions in asked.values()))
    places, sides, after, actions, after_actions = Counter(), Counter(), Counter(), Counter(), Counter()
    for shown in block:
        # Everybody sees every question once, and the questions of an action together.
        original = {(action, question) for action, questions in asked.items() for question in questions}
        assert {(a, q if (a, q) in original else q.mirrored()) for a, q in shown} == original
        order = list(dict.fromkeys(action for action, _ in shown))
        assert [action for action, _ in shown] == [action for action in order for _ in asked[action]]
        first = {action: [a for a, _ in shown].index(action) for action in order}
        for place, (action, question) in enumerate(shown):
            places[action, question.number, place - first[action]] += 1
            sides[action, question.number, question.model_a] += 1
        after.update(((a, one.number), (b, two.number)) for (a, one), (b, two) in pairwise(shown) if a == b)
        actions.update((action, place) for place, action in enumerate(order))
        after_actions.update(pairwise(order))
        for action, questions in asked.items():
            kept = sum(question in questions for a, question in shown if a == action)
            assert abs(2 * kept - len(questions)) <= len(questions) % 2
    for action, questions in asked.items():
        n = len(questions)
        for question in questions:
            assert {places[action, question.number, place] for place in range(n)} == {len(block) // n}
            for model in (question.model_a, question.model_b):
                assert sides[action, question.number, model] == len(block) // 2
        follows = [after[(action, a.number), (action, b.number)] for a in questions for b in questions if a is not b]
        assert len(set(follows)) <= 1
    assert set(actions.values()) == {len(block) // len(asked)}
    assert len(actions) == len(asked) ** 2
    assert len(set(after_actions.values())) <= 1
    assert len(after_actions) == len(asked) * (len(asked) - 1)


@given(sizes, st.integers(0, 2**32))
def test_every_pair_is_balanced(numbers, seed):
    block = study.counterbalance(surveys(numbers), seed=seed)
    for one, other in zip(block[::2], block[1::2], strict=True):
        assert other == [(action, question.mirrored()) for action, question in reversed(one)]
    assert block == study.counterbalance(surveys(numbers), seed=seed)


def test_the_answer_to_a_check_moves_with_its_side():
    for shown in study.counterbalance(surveys([3]), seed=0):
        (check,) = (question for _, question in shown if question.expected)
        assert (check.model_a if check.expected == "A" else check.model_b) == "ground truth"


def test_seeds_and_chance():
    asked = surveys([5, 5])
    assert study.counterbalance(asked, seed=0) != study.counterbalance(asked, seed=1)
    first = Counter(study.counterbalance(asked, seed=seed)[0][0][1].number for seed in range(400))
    assert set(first) == {1, 2, 3, 4, 5, 6}
    assert min(first.values()) > 400 / 6 - 5 * np.sqrt(400 / 6)


@pytest.mark.parametrize(
    ("asked", "error", "message"),
    [
        ([], TypeError, "surveys: expected a mapping of actions to questions, got list"),
        ({}, ValueError, "surveys: expected one action or more"),
        ({"a": []}, ValueError, r"surveys\['a'\]: expected one question or more, each with a number of its own"),
        ({"a": [study.Question(1, 0, "x", "y")] * 2}, ValueError, r"surveys\['a'\]: expected one question or more"),
    ],
)
def test_errors(asked, error, message):
    with pytest.raises(error, match=f"^{message}"):
        study.counterbalance(asked, seed=0)
    with pytest.raises(TypeError, match=r"^seed: expected"):
        study.counterbalance(surveys([1]), seed=None)


def test_a_preference_for_a_side_changes_no_majority_and_no_p_value():
    """Participants who mostly take what is on the left, and have no other preference, agree with no metric.

    Over the null, McNemar's exact test rejects at most as often as its level; without counterbalancing, the sides of
    the design decide every majority.
    """
    rng = np.random.default_rng(0)
    truth = {"a": {model: place for place, model in enumerate(MODELS, 1)}}
    other = {model: place for place, model in enumerate(reversed(MODELS), 1)}
    rejected, left, n = 0, [], 400
    for _ in range(n):
        asked = {"a": study.design(MODELS, range(5), 12, seed=rng)}
        votes = [
            study.Vote("a", question, f"p{who}", "A" if rng.random() < 0.8 else "B")
            for who, shown in enumerate(study.counterbalance(asked, seed=rng)[:6])
            for _, question in shown
        ]
        counts = study.count_votes(votes)
        assert len(counts) == 12
        majorities = [count.majority for count in counts]
        predictions = [[study.predict(count.question, ranks) for count in counts] for ranks in (truth["a"], other)]
        joint = study.joint_agreement(*predictions, majorities)
        rejected += study.mcnemar_test(joint.only_a, joint.only_b).p_value <= 0.05
        agreed = study.agreement(predictions[0], majorities)
        left += [agreed.agreed - agreed.disagreed]
    assert rejected / n < 0.05 + 4 * np.sqrt(0.05 * 0.95 / n)
    assert abs(np.mean(left)) < 4 * np.std(left) / np.sqrt(n)
