"""Agreement of participants with each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from npss.validation import real_array


def fleiss_kappa(counts: npt.ArrayLike) -> float:
    """Return Fleiss' kappa: the agreement of participants beyond chance. 1 is full agreement, 0 is chance.

    Parameters
    ----------
    counts : (questions, categories) array_like of int
        The number of participants who gave each answer to each question.

    Returns
    -------
    float
        Kappa; below 0 if they agree less than by chance.

    Raises
    ------
    TypeError
        If the counts are not whole numbers.
    ValueError
        If a count is negative, questions were answered by different numbers of participants or by fewer than two, or
        all answers are the same, so that kappa is 0/0.

    References
    ----------
    J. L. Fleiss, "Measuring Nominal Scale Agreement Among Many Raters", Psychological Bulletin 76, 1971.

    Examples
    --------
    >>> from npss import study
    >>> study.fleiss_kappa([[4, 0], [0, 4], [3, 1]])
    0.6571428571428571
    """
    return kappa(counts)


def kappa(counts: npt.ArrayLike, questions: Sequence[str] | None = None) -> float:
    """Compute `fleiss_kappa`, with names of questions for errors; by default, question 1, question 2, ..."""
    array = real_array("counts", counts)
    if array.dtype.kind not in "iu":
        raise TypeError(f"counts: expected whole numbers, got dtype {array.dtype}")
    if array.ndim != 2 or array.size == 0:
        raise ValueError(f"counts: expected shape (questions, categories), got {array.shape}")
    names = [f"question {i}" for i in range(1, len(array) + 1)] if questions is None else questions
    if (array < 0).any():
        raise ValueError(f"counts: negative in {names[np.argwhere(array < 0)[0][0]]}")
    raters = array.sum(axis=1)
    if (raters != raters[0]).any():
        other = int(np.argmax(raters != raters[0]))
        raise ValueError(
            f"counts: {names[0]} was answered by {raters[0]} participants, {names[other]} by {raters[other]}: "
            f"kappa needs equal numbers"
        )
    n = float(raters[0])
    if n < 2:
        raise ValueError(f"counts: agreement needs two participants or more, got {raters[0]}")
    shares = array.sum(axis=0) / array.sum()
    if shares.max() == 1:
        raise ValueError("counts: all answers are the same, so kappa is 0/0: chance alone gives full agreement")
    by_chance = float(np.square(shares).sum())
    agreeing = float((array * (array - 1.0)).sum(axis=1).mean() / (n * (n - 1)))
    return (agreeing - by_chance) / (1 - by_chance)
