"""How often metrics and the majority of participants preferred the same model."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from npss.study._votes import CHOICES, Choice
from npss.validation import one_of

#: What becomes of questions with a tie: left out, or each counted as half agreed.
Ties = Literal["exclude", "half"]


@dataclass(frozen=True, kw_only=True)
class Agreement:
    """How often a metric and the majority preferred the same model.

    Attributes
    ----------
    agreed, disagreed : int
        Questions on which they preferred the same model, and different ones.
    tied_votes : int
        Questions without a majority, whatever the metric said.
    tied_metric : int
        Questions with a majority on which the metric predicted nothing.

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
        """Questions without a tie: those that tests and intervals are about."""
        return self.agreed + self.disagreed

    def rate(self, *, ties: Ties = "exclude") -> float:
        """Return the share of questions agreed on; NaN of none.

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
        What a metric said of each question, as from `predict`.
    majorities : sequence of {'A', 'B', 'tie'}
        What the participants said of it: `Count.majority`.

    Returns
    -------
    Agreement
        With ties counted apart: they neither agree nor disagree.

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
    decided = [(said, voted) for said, voted in pairs if voted != "tie"]
    tied_metric = sum(said == "tie" for said, _ in decided)
    agreed = sum(said == voted for said, voted in decided)
    return Agreement(
        agreed=agreed,
        disagreed=len(decided) - tied_metric - agreed,
        tied_votes=len(pairs) - len(decided),
        tied_metric=tied_metric,
    )


@dataclass(frozen=True, kw_only=True)
class JointAgreement:
    """How often two metrics agreed with the majority on the same questions: what `mcnemar_test` needs.

    Attributes
    ----------
    both, only_a, only_b, neither : int
        Questions on which both metrics agreed with the majority, the first alone, the second alone, and neither.
    tied : int
        Questions left out: without a majority, or of which a metric predicted nothing.

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
        What each metric said of each question, as from `predict`.
    majorities : sequence of {'A', 'B', 'tie'}
        What the participants said of it: `Count.majority`.

    Returns
    -------
    JointAgreement
        The two by two table, and the ties.

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
    right = [(a == voted, b == voted) for a, b, voted in answers if "tie" not in (a, b, voted)]
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
