"""NPSS, the normalised power spectrum similarity: one number for a set of motions."""

from __future__ import annotations

from collections.abc import Sequence

import numpy.typing as npt

from npss._checks import Array, check_finite, motion_pair, positive_number
from npss._convention import Convention, as_convention
from npss._exact_sum import exact_sum
from npss._frames import whole_frames
from npss._kernel import tiles


def score(gt: npt.ArrayLike, pred: npt.ArrayLike, *, convention: str | Convention = "paper") -> float:
    """NPSS, the power-weighted mean distance between the power spectra of prediction and ground truth.

    Lower is better; 0 says that the power spectra are equal, not that the motions are. A score without its convention,
    representation and number of frames is not comparable: print `signature` with it.

    Parameters
    ----------
    gt : (N, T, D) or (T, D) array_like
        Ground truth: N sequences of T >= 2 frames of D features (angles in radians, usually).
    pred : array_like
        Prediction, of the same shape as `gt`.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        Which of the metric's meanings: what the paper's text defines (the default), what its released code computes
        and published tables hold, its equations as printed, or choices of your own.

    Returns
    -------
    float
        At least 0; at most T / 2 (`'paper'`) or 2 (`'literal'`). Scores at different T are not comparable.

    Raises
    ------
    TypeError
        If `gt` or `pred` does not hold real numbers, or the convention is neither a name nor a `Convention`.
    ValueError
        If the shapes are wrong or differ, a value is NaN or infinite (named with its index), there are fewer than two
        frames, the ground truth has no power at all, or no convention has that name.

    See Also
    --------
    score_windows : the short, medium and long-term scores.
    signature : the line to print beside the score.

    Notes
    -----
    Computed in float64 whatever the input's precision. The mean is a quotient of two exact sums: the order of
    sequences and features does not change one bit of it. Inputs may be memory maps; they are read once, in small
    blocks.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, section 3.5,
    equations 7 to 9.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> t = np.arange(100)[:, np.newaxis] / 25
    >>> gt = np.cos(2 * np.pi * np.array([0.5, 1.0]) * t)
    >>> npss.score(gt, gt)
    0.0
    >>> round(npss.score(gt, np.cos(2 * np.pi * 1.25 * t) * [1, 1]), 3)
    2.0
    """
    truth, prediction = motion_pair(gt, pred)
    return quotient(*weighted_sums(truth, prediction, as_convention(convention)))


def score_windows(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    fps: float,
    edges_s: Sequence[float] = (0, 1, 2, 4),
    convention: str | Convention = "paper",
) -> dict[str, float]:
    """NPSS of consecutive time windows: how good a prediction is in the short, medium and long term.

    Each window is scored alone: its spectrum is that of its own frames, without padding. Since windows
    differ in length, their scores are comparable between models, not with each other.

    Parameters
    ----------
    gt, pred : (N, T, D) or (T, D) array_like
        As for `score`.
    fps : float
        Frames per second.
    edges_s : sequence of float, optional
        Where windows begin and end, in seconds from the first predicted frame; increasing.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `score`.

    Returns
    -------
    dict of str to float
        The score of each window, under the name ``'0-1'`` for that from 0 to 1 s.

    Raises
    ------
    TypeError, ValueError
        As `score`; and where an edge is not on a frame, lies beyond the last one, or does not increase.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, table 5.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> t = np.arange(100)[:, np.newaxis] / 25
    >>> npss.score_windows(np.cos(6 * t), np.cos(6 * t), fps=25)
    {'0-1': 0.0, '1-2': 0.0, '2-4': 0.0}
    """
    truth, prediction = motion_pair(gt, pred)
    chosen = as_convention(convention)
    n_frames = truth.shape[-2]
    rate = positive_number("fps", fps)
    if len(edges_s) < 2:
        raise ValueError(f"edges_s: expected at least two edges, got {edges_s!r}")
    frames = [whole_frames("edges_s", edge, rate, last=n_frames) for edge in edges_s]
    check_finite("gt", truth)  # here, so that the index is that of the whole motion, not of a window
    check_finite("pred", prediction)
    scores: dict[str, float] = {}
    for begin, end, start, stop in zip(edges_s, edges_s[1:], frames, frames[1:], strict=False):
        name = f"{begin:g}-{end:g}"
        if stop <= start:
            raise ValueError(f"edges_s: {end:g} s does not come after {begin:g} s")
        where = f" in the window {name} s"
        sums = weighted_sums(truth[..., start:stop, :], prediction[..., start:stop, :], chosen, where)
        scores[name] = quotient(*sums, where)
    return scores


def weighted_sums(gt: Array, pred: Array, convention: Convention, where: str = "") -> tuple[int, int]:
    """Return the sums of weight times distance and of the weights, exact, in units of ``2**-UNIT``."""
    if gt.shape[-2] < 2:
        raise ValueError(f"gt: one frame{where}; a power spectrum needs at least two")
    numerator = denominator = 0
    for tile in tiles(gt, pred, convention):
        numerator += exact_sum(tile.weight * tile.distance, tile.exponent)
        denominator += exact_sum(tile.weight, tile.exponent)
    return numerator, denominator


def quotient(numerator: int, denominator: int, where: str = "") -> float:
    """Return the weighted mean, correctly rounded, or raise the ValueError that there is none."""
    if denominator == 0:
        raise ValueError(f"gt: no power in any feature of any sequence{where}, so there is nothing to score")
    return numerator / denominator
