"""Votes: count them, or simulate them."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from npss.study._design import CHOICES, MIRRORED, Choice, Question
from npss.validation import Seed, generator, is_real, positive_integer, renamed


@dataclass(frozen=True)
class Vote:
    """The answer of one participant to one question.

    Attributes
    ----------
    action : str
        The action of the survey.
    question : Question
        The question, with its sides as the participant saw them.
    participant : str
        Who answered.
    choice : {'A', 'B', 'tie'}
        The answer.
    position : int, optional
        The place of the question in the participant's survey, from 1, if known.

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
    position: int | None = None


@dataclass(frozen=True)
class Count:
    """The votes on one question, counted.

    Attributes
    ----------
    action : str
        The action of the survey.
    question : Question
        The question. If participants saw it with either side, its models are in alphabetical order for odd numbers, and
        in reverse for even ones: over questions, A is no model in particular.
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
    independently in each vote. Attention checks are answered as expected.

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
        The votes of participants ``'p1'``, ``'p2'``, ..., who all see the same; all answers are A or B.

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
        for model in () if question.expected else (question.model_a, question.model_b):
            if not is_real(strengths.get(model)) or not math.isfinite(strengths[model]):
                raise ValueError(f"strengths: no finite number for {model!r}, got {strengths.get(model)!r}")
    votes = []
    for participant in participants:
        for question in questions:
            if question.expected:
                votes.append(Vote(action, question, participant, question.expected))
                continue
            ahead = strengths[question.model_a] - strengths[question.model_b]
            prefers_a = rng.random() < (1 + math.tanh(ahead / 2)) / 2
            votes.append(Vote(action, question, participant, "A" if prefers_a else "B"))
    return votes


def count_votes(votes: Sequence[Vote]) -> list[Count]:
    """Count the votes on every question, whatever its position and side in the survey of each participant.

    Votes belong to the same question if its action, number, sequence and models are the same; the models may have
    changed sides. Attention checks are not counted: see `attention`.

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
    of_question: dict[tuple[str, Question], list[Vote]] = {}
    for vote in votes:
        check_choice(vote)
        if not vote.question.expected:
            of_question.setdefault((vote.action, _in_order(vote.question)), []).append(vote)
    counts = []
    for (action, question), same in of_question.items():
        # Sides that are the same for everybody are kept.
        if len({vote.question for vote in same}) == 1:
            question = same[0].question
        choices = [vote.choice if vote.question == question else MIRRORED[vote.choice] for vote in same]
        counts.append(Count(action, question, *map(choices.count, CHOICES)))
    return counts


def _in_order(question: Question) -> Question:
    """Return a question with its models in alphabetical order, in reverse for an even number.

    If A were always the model whose name comes first, kappa would take a preference for it for chance.
    """
    in_order = question.model_a <= question.model_b
    return question if in_order == bool(question.number % 2) else question.mirrored()


def check_choice(vote: Vote) -> None:
    """Check that the answer is one of those to a question."""
    if vote.choice not in CHOICES:
        raise ValueError(f"votes: expected a choice of {', '.join(CHOICES)}, got {vote.choice!r}")


@dataclass(frozen=True)
class Attention:
    """The answers of one participant to the attention checks.

    Attributes
    ----------
    participant : str
        Who answered.
    checks, right : int
        The number of attention checks answered, and how many of them as expected; a tie is not.

    Examples
    --------
    >>> from npss import study
    >>> study.Attention("p07", checks=2, right=1).passed
    False
    """

    participant: str
    checks: int
    right: int

    @property
    def passed(self) -> bool:
        """Whether all checks were answered as expected."""
        return self.right == self.checks


def attention(votes: Sequence[Vote]) -> list[Attention]:
    """Find who answered the attention checks as expected.

    By chance alone, a participant passes ``n`` checks with probability ``2 ** -n``.

    Parameters
    ----------
    votes : sequence of Vote
        Votes from `read_votes`.

    Returns
    -------
    list of Attention
        An entry for each participant, in the order of first appearance, also for those without a check.

    Raises
    ------
    ValueError
        If a choice is not A, B or tie.

    Examples
    --------
    >>> from npss import study
    >>> check = study.Question(21, 4, "ground truth", "ground truth, upside down", expected="A")
    >>> votes = [study.Vote("walking", check, "p1", "A"), study.Vote("walking", check.mirrored(), "p2", "A")]
    >>> [of.participant for of in study.attention(votes) if not of.passed]
    ['p2']
    """
    answered: dict[str, list[bool]] = {}
    for vote in votes:
        check_choice(vote)
        checks = answered.setdefault(vote.participant, [])
        if vote.question.expected:
            checks.append(vote.choice == vote.question.expected)
    return [Attention(who, len(checks), sum(checks)) for who, checks in answered.items()]
