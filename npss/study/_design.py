"""Design of a survey: questions about pairs of models, drawn as in the NPSS paper."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Literal, get_args

from npss.validation import Seed, each, generator, is_integer, positive_integer, renamed

#: The answers to a question: the motion on the left, the motion on the right, or neither.
Choice = Literal["A", "B", "tie"]
CHOICES: tuple[Choice, ...] = get_args(Choice)
Side = Literal["A", "B"]
SIDES: tuple[Side, ...] = get_args(Side)

#: What an attention check shows in place of two models: the recording itself, and the recording upside down.
RIGHT, WRONG = "ground truth", "ground truth, upside down"

#: The choice of the same motion where the sides are swapped.
MIRRORED: dict[Choice, Choice] = {"A": "B", "B": "A", "tie": "tie"}
_OTHER: dict[Side, Side] = {"A": "B", "B": "A"}


@dataclass(frozen=True)
class Question:
    """A question: which of two models predicts a sequence better.

    Attributes
    ----------
    number : int
        The number of the question, from 1.
    sequence : int
        The index of the predicted sequence.
    model_a, model_b : str
        The two models: A is shown on the left, B on the right.
    expected : {'A', 'B'}, optional
        The answer of an attentive participant, which makes the question an attention check.

    Examples
    --------
    >>> from npss import study
    >>> question = study.Question(number=1, sequence=4, model_a="GRU-d", model_b="VGRU-d")
    >>> question.model_b
    'VGRU-d'
    >>> question.mirrored().model_b
    'GRU-d'
    """

    number: int
    sequence: int
    model_a: str
    model_b: str
    expected: Side | None = None

    def mirrored(self) -> Question:
        """Return the same question with its sides swapped."""
        expected = self.expected and _OTHER[self.expected]
        return Question(self.number, self.sequence, self.model_b, self.model_a, expected)


@renamed(rng="seed")
def design(
    models: Sequence[str], sequences: Sequence[int], n_questions: int, *, seed: Seed, attention_checks: int = 0
) -> list[Question]:
    """Draw the questions of a survey about one action, as in the NPSS paper.

    All unordered pairs of models are drawn in random order without replacement; when they are used up, a case that the
    paper does not mention, all are drawn again. Left and right are random. Sequences are drawn with replacement.
    `counterbalance` then varies order and sides from participant to participant.

    Parameters
    ----------
    models : sequence of str
        Names of two models or more.
    sequences : sequence of int
        The sequences to choose from, such as ``range(8)``.
    n_questions : int
        The number of questions; 20 in the paper.
    seed : int or numpy.random.Generator
        The seed of the generator; the same number gives the same questions.
    attention_checks : int, optional
        The number of attention checks: one motion is the recording itself, the other is the recording upside down.
        They are drawn last, so the questions do not depend on their number.

    Returns
    -------
    list of Question
        The questions, numbered from 1, and after them the attention checks.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described, or a model or a sequence is a duplicate.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019.

    Examples
    --------
    >>> from npss import study
    >>> survey = study.design(["GRU-d", "VGRU-d", "VGRU-ac"], range(8), 20, seed=0)
    >>> survey[0]
    Question(number=1, sequence=6, model_a='VGRU-d', model_b='VGRU-ac', expected=None)
    """
    names = [_name(name) for name in each("models", models, "names")]
    shown = each("sequences", sequences, "whole numbers")
    for sequence in shown:
        if not is_integer(sequence):
            raise TypeError(f"sequences: expected whole numbers, got {sequence!r}")
    for argument, values, least in (("models", names, 2), ("sequences", shown, 1)):
        if len(values) < least or len(set(values)) < len(values):
            raise ValueError(f"{argument}: expected {least} or more without duplicates, got {values}")
    count = positive_integer("n_questions", n_questions)
    if not is_integer(attention_checks):
        raise TypeError(f"attention_checks: expected a whole number, got {attention_checks!r}")
    if attention_checks < 0:
        raise ValueError(f"attention_checks: expected 0 or more, got {attention_checks}")
    if attention_checks and (reserved := {RIGHT, WRONG}.intersection(names)):
        raise ValueError(f"models: {min(reserved)!r} is what an attention check shows; expected another name")
    rng = generator(seed)
    pairs = list(combinations(names, 2))
    dealt: list[tuple[str, str]] = []
    while len(dealt) < count:
        dealt += [pairs[i] for i in rng.permutation(len(pairs))]
    questions = []
    for number, pair in enumerate(dealt[:count] + [(RIGHT, WRONG)] * int(attention_checks), start=1):
        left = int(rng.integers(2))
        sequence = int(shown[rng.integers(len(shown))])
        expected = None if number <= count else SIDES[left]
        questions.append(Question(number, sequence, pair[left], pair[1 - left], expected))
    return questions


def _name(name: object) -> str:
    if not isinstance(name, str):
        raise TypeError(f"models: expected names, got {name!r}")
    return name
