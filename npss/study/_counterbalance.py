"""Order and sides of the questions, balanced over participants."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from npss.study._design import Question
from npss.validation import Seed, generator


def counterbalance(surveys: Mapping[str, Sequence[Question]], *, seed: Seed) -> list[list[tuple[str, Question]]]:
    """Give each participant of a block the questions in another order and with other sides.

    The questions of an action stay together. Over a block of participants,

    - every question is equally often on each side, at each place within its action, and directly after each other
      question of the action;
    - every action is equally often at each place, and directly after each other action.

    Participants come in pairs: the second sees the survey of the first backwards and mirrored. So the sides and the
    mean places of questions are also balanced over the first 2, 4, 6, ... participants. Half of the questions of each
    action are mirrored, drawn for each pair; of an odd number, one more or one less.

    Parameters
    ----------
    surveys : mapping of str to sequence of Question
        The questions on each action, from `design`.
    seed : int or numpy.random.Generator
        The seed of the generator; the same number gives the same orders and sides.

    Returns
    -------
    list of list of (str, Question)
        For each participant, all questions with their actions. The size of the block is the least common multiple of
        the sizes of the squares of the actions and of the questions on each action; that of n is n if n is even, 2 n if
        it is odd.

    Raises
    ------
    TypeError
        If `surveys` is not a mapping.
    ValueError
        If there are no questions, or two questions on an action have the same number.

    References
    ----------
    E. J. Williams, "Experimental Designs Balanced for the Estimation of Residual Effects of Treatments", Australian
    Journal of Scientific Research A 2, 1949.

    Examples
    --------
    >>> from npss import study
    >>> models = ["GRU-d", "VGRU-d", "VGRU-ac"]
    >>> surveys = {action: study.design(models, range(8), 6, seed=0) for action in ("walking", "eating")}
    >>> block = study.counterbalance(surveys, seed=0)
    >>> len(block), len(block[0])
    (6, 12)
    >>> [(action, question.mirrored()) for action, question in reversed(block[0])] == block[1]
    True
    """
    if not isinstance(surveys, Mapping):
        raise TypeError(f"surveys: expected a mapping of actions to questions, got {type(surveys).__name__}")
    if not surveys:
        raise ValueError("surveys: expected one action or more")
    for action, questions in surveys.items():
        if not questions or len({question.number for question in questions}) < len(questions):
            raise ValueError(f"surveys[{action!r}]: expected one question or more, each with a number of its own")
    rng = generator(seed)
    actions = list(surveys)
    orders = {action: _orders(len(questions), rng) for action, questions in surveys.items()}
    of_actions = _orders(len(actions), rng)
    block = []
    for pair in range(block_size(surveys) // 2):
        first = []
        for action in (actions[i] for i in of_actions[pair % len(of_actions)]):
            questions, order = surveys[action], orders[action][pair % len(orders[action])]
            swapped = _half(len(questions), rng)
            first += [(action, questions[i].mirrored() if i in swapped else questions[i]) for i in order]
        block += [first, [(action, question.mirrored()) for action, question in reversed(first)]]
    return block


def block_size(surveys: Mapping[str, Sequence[Question]]) -> int:
    """Return the number of participants in a block."""
    return math.lcm(*(n if n % 2 == 0 else 2 * n for n in (len(surveys), *map(len, surveys.values()))))


def _orders(n: int, rng: np.random.Generator) -> list[list[int]]:
    """Return the rows of Williams' square of size `n`, in random order; of each row and its reverse, only one.

    With the reverse rows, every item is equally often at each place, and directly after each other item.
    """
    # 0, 1, n - 1, 2, n - 2, ...: its steps are all different, so each other item follows an item in one of the rows.
    zigzag = [(step + 1) // 2 * (1 if step % 2 else -1) for step in range(n)]
    names = rng.permutation(n)
    # Of an even number, half of the rows are the reverse of the other half.
    shifts = rng.permutation(n // 2 if n % 2 == 0 else n)
    return [[int(names[(item + shift) % n]) for item in zigzag] for shift in shifts]


def _half(n: int, rng: np.random.Generator) -> set[int]:
    """Draw half of the numbers below `n`; of an odd number, one more or one less at random."""
    return set(rng.permutation(n)[: (n + rng.integers(2)) // 2].tolist())
