"""Votes: count them, or simulate them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, get_args

from npss.study._design import Question
from npss.validation import Seed, generator, is_real, positive_integer, renamed

#: The answers to a question: the motion on the left, the motion on the right, or neither.
Choice = Literal["A", "B", "tie"]
CHOICES: tuple[Choice, ...] = get_args(Choice)


@dataclass(frozen=True)
class Vote:
    """The answer of one participant to one question.

    Attributes
    ----------
    action : str
        The action of the survey.
    question : Question
        The question.
    participant : str
        Who answered.
    choice : {'A', 'B', 'tie'}
        The answer.

    Examples
    --------
    >>> from npss import study
    >>> study.Vote("walking", study.Question(1, 4, "GRU-d", "VGRU-d"), "p07", "B").choice
    'B'
    """

    action: str
    question: Question
    participant: str
    choice: Choice


@dataclass(frozen=True)
class Count:
    """The votes on one question, counted.

    Attributes
    ----------
    action : str
        The action of the survey.
    question : Question
        The question.
    a, b, tie : int
        The number of votes for A, for B, and for neither.

    Examples
    --------
    >>> from npss import study
    >>> study.Count("walking", study.Question(1, 4, "GRU-d", "VGRU-d"), a=7, b=12, tie=1).majority
    'B'
    """

    action: str
    question: Question
    a: int
    b: int
    tie: int

    @property
    def majority(self) -> Choice:
        """``'A'`` or ``'B'``, whichever has more votes, or ``'tie'``; votes for neither count for neither."""
        return "tie" if self.a == self.b else "A" if self.a > self.b else "B"


@renamed(rng="seed")
def simulate_votes(
    questions: Sequence[Question],
    strengths: Mapping[str, float],
    n_participants: int,
    *,
    action: str,
    seed: Seed,
) -> list[Vote]:
    """Simulate the votes of a study, to try the analysis without participants.

    In the model of Bradley and Terry, A is chosen with probability 1 / (1 + exp(strength of B - strength of A)),
    independently in each vote.

    Parameters
    ----------
    questions : sequence of Question
        Questions from `design`.
    strengths : mapping of str to float
        The strength of each model; between equal strengths, either answer has probability 1/2.
    n_participants : int
        The number of participants, who answer all questions.
    action : str
        The action of the votes.
    seed : int or numpy.random.Generator
        The seed of the generator; the same number gives the same votes.

    Returns
    -------
    list of Vote
        The votes of participants ``'p1'``, ``'p2'``, ...; all answers are A or B.

    Raises
    ------
    TypeError, ValueError
        If a model has no finite strength, or an argument is not as described.

    References
    ----------
    R. A. Bradley and M. E. Terry, "Rank Analysis of Incomplete Block Designs", Biometrika 39, 1952.

    Examples
    --------
    >>> from npss import study
    >>> survey = study.design(["GRU-d", "VGRU-d"], range(8), 3, seed=0)
    >>> votes = study.simulate_votes(survey, {"GRU-d": 0.0, "VGRU-d": 1.0}, 20, action="walking", seed=1)
    >>> len(votes), votes[0].participant
    (60, 'p1')
    """
    participants = [f"p{i}" for i in range(1, positive_integer("n_participants", n_participants) + 1)]
    rng = generator(seed)
    for question in questions:
        for model in (question.model_a, question.model_b):
            if not is_real(strengths.get(model)) or not math.isfinite(strengths[model]):
                raise ValueError(f"strengths: no finite number for {model!r}, got {strengths.get(model)!r}")
    votes = []
    for participant in participants:
        for question in questions:
            ahead = strengths[question.model_a] - strengths[question.model_b]
            prefers_a = rng.random() < (1 + math.tanh(ahead / 2)) / 2
            votes.append(Vote(action, question, participant, "A" if prefers_a else "B"))
    return votes


def count_votes(votes: Sequence[Vote]) -> list[Count]:
    """Count the votes on every question.

    Parameters
    ----------
    votes : sequence of Vote
        Votes from `read_votes`.

    Returns
    -------
    list of Count
        A count for each question of each action, in the order of first appearance.

    Raises
    ------
    ValueError
        If a choice is not A, B or tie.

    Examples
    --------
    >>> from npss import study
    >>> question = study.Question(1, 4, "GRU-d", "VGRU-d")
    >>> (count,) = study.count_votes([study.Vote("walking", question, who, "B") for who in ("p1", "p2")])
    >>> count.a, count.b, count.majority
    (0, 2, 'B')
    """
    counts: dict[tuple[str, Question], dict[str, int]] = {}
    for vote in votes:
        if vote.choice not in CHOICES:
            raise ValueError(f"votes: expected a choice of {', '.join(CHOICES)}, got {vote.choice!r}")
        counts.setdefault((vote.action, vote.question), dict.fromkeys(CHOICES, 0))[vote.choice] += 1
    return [Count(action, question, *numbers.values()) for (action, question), numbers in counts.items()]
