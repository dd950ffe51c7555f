"""Error rates of tests of user studies: the numbers of docs/study.md.

``python benchmarks/user_study.py [STUDIES]``

No model is preferred to another, and no metric is better than another; how often does a test at 5 % say otherwise? It
takes about a minute.
"""

import math
import sys

import numpy as np

from npss import study

LEVEL = 0.05
TASTE = 1.41  # standard deviation of the logit of a participant's taste for one model of a pair
NOISE = 1.0  # of a metric's scores, as large as the spread of the models' strengths


def main():
    studies = int(sys.argv[1]) if len(sys.argv) > 1 else 2000
    print(f"{studies} studies each; standard error at {LEVEL:.0%}: {math.sqrt(LEVEL * (1 - LEVEL) / studies):.1%}")
    for participants, answers in ((12, 4), (28, 4), (28, 20)):
        rates = preferences(participants, answers, studies, np.random.default_rng(0))
        print(f"{participants} participants, {answers} answers each on a pair: " + ", ".join(rates))
    for models, actions, questions in ((6, 4, 20), (4, 1, 24), (6, 15, 15)):
        rates = metrics(models, actions, questions, studies, np.random.default_rng(0))
        print(f"{models} models, {actions} actions, {questions} questions each: " + ", ".join(rates))


def preferences(participants, answers, studies, rng):
    """Return how often a preference is found where each participant has a taste, but all together have none."""
    wrong = pooled = 0
    questions = [study.Question(number, 0, "A", "B") for number in range(answers)]
    for _ in range(studies):
        taste = 1 / (1 + np.exp(-TASTE * rng.standard_normal(participants)))
        chose_a = rng.random((participants, answers)) < taste[:, np.newaxis]
        votes = [
            study.Vote("walking", question, f"p{i}", "A" if chose_a[i, j] else "B")
            for i in range(participants)
            for j, question in enumerate(questions)
        ]
        (preference,) = study.preference_tests(votes)
        wrong += preference.p_value <= LEVEL
        a = int(chose_a.sum())
        pooled += study.mcnemar_test(a, chose_a.size - a, alternative="two-sided").p_value <= LEVEL  # a binomial test
    return [f"preference_tests {wrong / studies:.1%}", f"binomial test of pooled votes {pooled / studies:.1%}"]


def metrics(models, actions, questions, studies, rng):
    """Return how often McNemar's test finds one of two equally good metrics better."""
    names = [f"model {i}" for i in range(models)]
    found = dict.fromkeys(("greater", "two-sided"), 0)
    for _ in range(studies):
        first, second, majorities = [], [], []
        for _ in range(actions):
            strength = dict(zip(names, rng.standard_normal(models), strict=True))
            ranks = [
                study.rank({name: -strength[name] + NOISE * rng.standard_normal() for name in names}) for _ in range(2)
            ]
            for question in study.design(names, range(8), questions, seed=rng):
                ahead = strength[question.model_a] - strength[question.model_b]
                votes = rng.binomial(20, 1 / (1 + math.exp(-ahead)))
                majorities.append("tie" if votes == 10 else "A" if votes > 10 else "B")
                for answers, of_one in zip((first, second), ranks, strict=True):
                    answers.append(study.predict(question, of_one))
        joint = study.joint_agreement(first, second, majorities)
        for alternative in found:
            p_value = study.mcnemar_test(joint.only_a, joint.only_b, alternative=alternative).p_value
            found[alternative] += p_value <= LEVEL
    return [f"McNemar's test, {alternative}: {count / studies:.1%}" for alternative, count in found.items()]


if __name__ == "__main__":
    main()
