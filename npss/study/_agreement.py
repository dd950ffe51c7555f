"""Agreement of metrics with the majority of participants."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from npss.study._design import CHOICES, Choice
from npss.validation import one_of

#: The treatment of questions with a tie: left out, or counted as half agreed.
Ties = Literal["exclude", "half"]


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """How often a metric and the majority preferred the same model.

    Attributes
    ----------
    agreed, disagreed : int
        Questions on which they preferred the same model, and different ones.
    tied_votes : int
        Questions without a majority, for any prediction of the metric.
    tied_metric : int
        Questions with a majority on which the metric predicted a tie.

    Examples
    --------
    >>> from npss import study
    >>> counted = study.Agreement(agreed=14, disagreed=4, tied_votes=2, tied_metric=0)
    >>> counted.n, counted.rate(), counted.rate(ties="half")
    (18, 0.7777777777777778, 0.75)
    """

    agreed: int
    disagreed: int
    tied_votes: int
    tied_metric: int

    @property
    def n(self) -> int:
        """Questions without a tie, which tests and intervals cover."""
        return self.agreed + self.disagreed

    def rate(self, *, ties: Ties = "exclude") -> float:
        """Return the share of questions agreed on; NaN if there are no questions.

        Parameters
        ----------
        ties : {'exclude', 'half'}, optional
            Leave questions with a tie out, or count each as half agreed.
        """
        one_of("ties", ties, get_args(Ties))
        tied = self.tied_votes + self.tied_metric if ties == "half" else 0
        n = self.n + tied
        return (self.agreed + tied / 2) / n if n else math.nan


def agreement(predictions: Sequence[Choice], majorities: Sequence[Choice]) -> Agreement:
    """Count how often predictions and majorities agree.

    Parameters
    ----------
    predictions : sequence of {'A', 'B', 'tie'}
        A metric's prediction for each question, as from `predict`.
    majorities : sequence of {'A', 'B', 'tie'}
        The majority on each question: `Count.majority`.

    Returns
    -------
    Agreement
        The counts; ties are counted separately, as neither agreed nor disagreed.

    Raises
    ------
    ValueError
        If the two differ in length, or an entry is not A, B or tie.

    Examples
    --------
    >>> from npss import study
    >>> study.agreement(["A", "A", "B", "tie"], ["A", "B", "tie", "A"])
    Agreement(agreed=1, disagreed=1, tied_votes=1, tied_metric=1)
    """
    _check_choices(predictions=predictions, majorities=majorities)
    pairs = list(zip(predictions, majorities, strict=True))
    decided = [(prediction, majority) for prediction, majority in pairs if majority != "tie"]
    tied_metric = sum(prediction == "tie" for prediction, _ in decided)
    agreed = sum(prediction == majority for prediction, majority in decided)
    return Agreement(
        agreed=agreed,
        disagreed=len(decided) - tied_metric - agreed,
        tied_votes=len(pairs) - len(decided),
        tied_metric=tied_metric,
    )


@dataclass(frozen=True, kw_only=True)
class JointAgreement:
    """How often two metrics agreed with the majority on the same questions, for `mcnemar_test`.

    Attributes
    ----------
    both, only_a, only_b, neither : int
        Questions on which both metrics agreed with the majority, only the first, only the second, and neither.
    tied : int
        Questions left out: without a majority, or with a tie predicted by a metric.

    Examples
    --------
    >>> from npss import study
    >>> joint = study.joint_agreement(["A", "A"], ["A", "B"], ["A", "A"])
    >>> joint.both, joint.only_a
    (1, 1)
    """

    both: int
    only_a: int
    only_b: int
    neither: int
    tied: int


def joint_agreement(
    predictions_a: Sequence[Choice], predictions_b: Sequence[Choice], majorities: Sequence[Choice]
) -> JointAgreement:
    """Count on which questions two metrics agree with the majority.

    Parameters
    ----------
    predictions_a, predictions_b : sequence of {'A', 'B', 'tie'}
        Each metric's prediction for each question, as from `predict`.
    majorities : sequence of {'A', 'B', 'tie'}
        The majority on each question: `Count.majority`.

    Returns
    -------
    JointAgreement
        The two-by-two table, and the ties.

    Raises
    ------
    ValueError
        If the three differ in length, or an entry is not A, B or tie.

    Examples
    --------
    >>> from npss import study
    >>> study.joint_agreement(["A", "A", "A"], ["A", "B", "tie"], ["A", "B", "A"])
    JointAgreement(both=1, only_a=0, only_b=1, neither=0, tied=1)
    """
    _check_choices(predictions_a=predictions_a, predictions_b=predictions_b, majorities=majorities)
    answers = list(zip(predictions_a, predictions_b, majorities, strict=True))
    right = [(a == majority, b == majority) for a, b, majority in answers if "tie" not in (a, b, majority)]
    return JointAgreement(
        both=right.count((True, True)),
        only_a=right.count((True, False)),
        only_b=right.count((False, True)),
        neither=right.count((False, False)),
        tied=len(answers) - len(right),
    )


def _check_choices(**answers: Sequence[Choice]) -> None:
    lengths = {name: len(choices) for name, choices in answers.items()}
    if len(set(lengths.values())) > 1:
        raise ValueError(f"{' and '.join(answers)}: their lengths differ: {lengths}")
    for name, choices in answers.items():
        for number, choice in enumerate(choices, 1):
            if choice not in CHOICES:
                raise ValueError(f"{name}: expected {', '.join(CHOICES)} for question {number}, got {choice!r}")
