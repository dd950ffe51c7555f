"""NPSS of several samples of each sequence."""

from __future__ import annotations

from typing import Literal, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.contributions import contributions
from npss._metric.convention import Convention, ConventionName, as_convention
from npss.stochastic._samples import read_samples
from npss.validation import Array, Float64, one_of

#: What counts of the samples of a sequence: the mean of their scores, or the sample with the lowest or highest one.
Reduction = Literal["mean", "best", "worst"]


def score(
    gt: npt.ArrayLike,
    samples: npt.ArrayLike,
    *,
    reduction: Reduction = "mean",
    convention: ConventionName | Convention = "paper",
    representation: str | None = None,
    workers: int = 1,
) -> float:
    """Return the NPSS of several samples of each sequence.

    Parameters
    ----------
    gt : array_like
        As for `npss.score`.
    samples : (S,) + gt.shape array_like
        S predictions of each sequence.
    reduction : {'mean', 'best', 'worst'}, optional
        The mean of the scores of the samples; or, for each sequence, the sample with the lowest or the highest NPSS.
    convention, representation, workers
        As for `npss.score`.

    Returns
    -------
    float
        The score.

    Raises
    ------
    TypeError, ValueError
        As for `npss.score`; also if the shape of `samples` is not ``(S,) + gt.shape``, or `reduction` is invalid.

    See Also
    --------
    npss.stochastic.report : the score with its spread over samples and its interval over blocks.

    Notes
    -----
    ``"best"`` uses the ground truth to choose, so it falls with more samples: state their number, as in
    ``npss.signature("paper", frames=T, draws=S, reduction="best")``.

    References
    ----------
    As for `npss.score`.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> t = np.arange(100)[:, np.newaxis]
    >>> gt, other = (np.cos(2 * np.pi * t / period) for period in (20, 25))
    >>> samples = np.stack([gt, other])
    >>> [round(npss.stochastic.score(gt, samples, reduction=which), 3) for which in ("best", "mean", "worst")]
    [0.0, 0.5, 1.0]
    """
    one_of("reduction", reduction, get_args(Reduction))
    truth, drawn = read_samples(gt, samples, representation)
    return scored(truth, drawn, as_convention(convention), workers=workers).reduced(reduction)[0]


class Scored(NamedTuple):
    """The scores of samples, and what each sequence of each adds to their numerators and denominators."""

    scores: Float64  # (S,)
    numerator: Float64  # (S, N)
    weight: Float64  # (N,); of the ground truth, and so equal for all samples

    def reduced(self, reduction: Reduction) -> tuple[float, Float64]:
        """Return the score, and what each sequence adds to its numerator, ``(N,)``."""
        if reduction == "mean":
            return float(self.scores.mean()), self.numerator.mean(axis=0)
        numerator: Float64 = self.numerator.min(axis=0) if reduction == "best" else self.numerator.max(axis=0)
        return float(numerator.sum() / self.weight.sum()), numerator


def scored(gt: Array, samples: Array, convention: Convention, *, workers: int = 1) -> Scored:
    """Score each of the samples ``(S, N, T, D)``."""
    scores, numerators = np.empty(len(samples)), np.empty(samples.shape[:2])
    weight = np.empty(len(gt))
    for s, sample in enumerate(samples):
        parts = contributions(gt, sample, convention, workers=workers)
        scores[s] = parts.score
        numerators[s], weight = parts.by_sequence()
    return Scored(scores, numerators, weight)
