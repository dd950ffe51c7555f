"""NPSS, the normalised power spectrum similarity: one number for a set of motions."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from fractions import Fraction
from typing import Literal, overload

import numpy.typing as npt

from npss._metric.bound import Normalize, check_normalize, normalised
from npss._metric.convention import Convention, ConventionName, as_convention
from npss._metric.exact_sum import exact_sum
from npss._metric.frames import whole_frames
from npss._metric.kernel import Block, Tile, blocks, tile
from npss._metric.sequences import Lengths, Motions, read_motions
from npss.validation import Array, check_finite, each, is_integer, motion_pair, positive_number, renamed


@overload
def score(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    convention: ConventionName | Convention = ...,
    lengths: None = ...,
    normalize: Normalize = ...,
    representation: str | None = ...,
    workers: int = ...,
) -> float: ...
@overload
def score(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    convention: ConventionName | Convention = ...,
    lengths: npt.ArrayLike,
    normalize: Literal["bound"],
    representation: str | None = ...,
    workers: int = ...,
) -> float: ...
@overload
def score(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    convention: ConventionName | Convention = ...,
    lengths: npt.ArrayLike,
    normalize: None = ...,
    representation: str | None = ...,
    workers: int = ...,
) -> dict[int, float]: ...
def score(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    convention: ConventionName | Convention = "paper",
    lengths: Lengths = None,
    normalize: Normalize = None,
    representation: str | None = None,
    workers: int = 1,
) -> float | dict[int, float]:
    """Return the NPSS: the power-weighted mean distance between the power spectra of prediction and ground truth.

    Lower is better; 0 means that the power spectra are equal, not the motions. A score without its convention,
    representation and number of frames is not comparable: print `signature` with it.

    Parameters
    ----------
    gt : (N, T, D), (T, D) or (N, T, J, C) array_like
        Ground truth: N sequences of T >= 2 frames of D features (angles in radians, usually), or of J joints with C
        coordinates, which are flattened joint by joint. Arrays and tensors of numpy, torch, jax, ..., in any precision.
        Pass a single sequence of joints as ``x[None]``: three axes are always ``(N, T, D)``. Or a list of N sequences
        ``(T, D)`` or ``(T, J, C)``, which may differ in length.
    pred : array_like
        Prediction, of the same shape as `gt`.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        The definition of the metric: the paper's text (default), its released code (used in published tables), its
        equations as printed, or choices of your own.
    lengths : (N,) array_like of int, optional
        The number of frames of each sequence that count, of gt and prediction: later ones are padding, and may be NaN.
    normalize : {'bound'}, optional
        Give one number for sequences of different lengths: distances are divided by their largest value, T / 2
        (``'literal'``: 2), and weights by T^2 (``'literal'``: 1). The signature states it.
    representation : str, optional
        What the features are. For ``'matrix'``, rotation matrices, an array with joints is ``(N, T, J, 3, 3)``; other
        representations do not change how an array is read.
    workers : int, optional
        Number of threads; -1 for all CPUs, as in scipy. Several threads pay off for more than some ten thousand
        features of sequences, and give the same bits.

    Returns
    -------
    float, or dict of int to float
        At least 0; at most T / 2 (`'paper'`) or 2 (`'literal'`), and 1 if normalised. Scores at different T are not
        comparable: with `lengths`, or for lists of sequences that differ in length, a dict of scores by T, unless
        normalised.

    Raises
    ------
    TypeError
        If `gt` or `pred` does not hold real numbers, the convention is neither a name nor a `Convention`, or `workers`
        is not a whole number.
    ValueError
        If the shapes are wrong, ambiguous or differ, a value is NaN or infinite (the message names its index), there
        are fewer than two frames, the ground truth has no power, the convention is unknown, or `workers` is out of
        range.

    See Also
    --------
    score_windows : the short, medium and long-term scores.
    signature : the line to print beside the score.

    Notes
    -----
    Computed in float64 for any precision of the input. The mean is a quotient of two exact sums, so the order of
    sequences and features does not change its bits. Inputs may be memory maps; they are read once, in small blocks.

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
    >>> short, long = np.cos(2 * np.pi * 1.25 * t[:40]), np.cos(2 * np.pi * 2 * t)
    >>> npss.score([short, long], [short, long])
    {40: 0.0, 100: 0.0}
    >>> npss.score([short, long], [short, 0 * long], normalize="bound")
    0.5
    """
    choices = as_convention(convention)
    check_normalize(normalize)
    motions = read_motions(gt, pred, lengths=lengths, representation=representation)
    sums = sums_by_length(motions, choices, workers=workers)
    if normalize is not None:
        return quotient(*normalised(sums, choices))
    if not motions.by_length:
        return quotient(*next(iter(sums.values())))
    return {n_frames: quotient(*both, f" of {n_frames} frames") for n_frames, both in sums.items()}


@renamed(edges_s="edges_ms")
def score_windows(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    fps: float,
    edges_ms: Sequence[float] = (0, 1000, 2000, 4000),
    convention: ConventionName | Convention = "paper",
    representation: str | None = None,
    workers: int = 1,
) -> dict[str, float]:
    """Return the NPSS of consecutive time windows: the short, medium and long term.

    Each window is scored separately: its spectrum uses only its frames, without padding. Windows differ in length, so
    their scores are comparable between models, not with each other.

    Parameters
    ----------
    gt, pred : (N, T, D), (T, D) or (N, T, J, C) array_like
        As for `score`.
    fps : float
        Frames per second.
    edges_ms : sequence of float, optional
        Edges of the windows in milliseconds from the first predicted frame, increasing.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `score`.
    representation : str, optional
        As for `score`.
    workers : int, optional
        As for `score`.

    Returns
    -------
    dict of str to float
        The score of each window by its name in seconds: ``'0-1'`` is the window from 0 to 1000 ms.

    Raises
    ------
    TypeError, ValueError
        As for `score`; also if an edge is not on a frame or is beyond the last one, or edges do not increase.

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
    truth, prediction = motion_pair(gt, pred, representation)
    choices = as_convention(convention)
    n_frames = truth.shape[-2]
    rate = positive_number("fps", fps)
    edges = each("edges_ms", edges_ms)
    if len(edges) < 2:
        raise ValueError(f"edges_ms: expected at least two edges, got {edges_ms!r}")
    frames = [whole_frames("edges_ms", edge, rate, last=n_frames) for edge in edges]
    check_finite("gt", truth)  # here, so that errors give the index in the whole motion, not in a window
    check_finite("pred", prediction)
    scores: dict[str, float] = {}
    for begin, end, start, stop in zip(edges, edges[1:], frames, frames[1:], strict=False):
        name = f"{begin / 1000:g}-{end / 1000:g}"
        if stop <= start:
            raise ValueError(f"edges_ms: {end:g} ms is not after {begin:g} ms")
        where = f" in the window {name} s"
        sums = weighted_sums(
            truth[..., start:stop, :], prediction[..., start:stop, :], choices, workers=workers, where=where
        )
        scores[name] = quotient(*sums, where)
    return scores


def sums_by_length(motions: Motions, convention: Convention, *, workers: int = 1) -> dict[int, tuple[int, int]]:
    """Return the exact sums of the sequences of each length, by T."""
    return {
        group.n_frames: weighted_sums(group.gt, group.pred, convention, workers=workers) for group in motions.groups
    }


def weighted_sums(
    gt: Array,
    pred: Array,
    convention: Convention,
    *,
    workers: int = 1,
    where: str = "",
    progress: Callable[[float], None] = lambda share: None,
    keep: Callable[[Tile], None] = lambda part: None,
    parts: bool = False,
) -> tuple[int, int]:
    """Return the exact sums of weight times distance and of the weights, in units of ``2**-UNIT``.

    Call `keep` with the statistics of each block, and their parts if asked for, from several threads if there are
    several.
    """
    threads = n_workers(workers)
    if gt.shape[-2] < 2:
        raise ValueError(f"gt: one frame{where}; a power spectrum needs at least two")
    cut = blocks(gt)

    def sums(block: Block) -> tuple[int, int]:
        part = tile(gt, pred, convention, block, parts=parts)
        keep(part)
        return exact_sum(part.weight * part.distance, part.exponent), exact_sum(part.weight, part.exponent)

    numerator = denominator = 0
    with ExitStack() as stack:
        sums_of_blocks: Iterable[tuple[int, int]] = map(sums, cut)
        if threads > 1 and len(cut) > 1:
            from concurrent.futures import ThreadPoolExecutor  # here, because its import is slow and rarely needed

            pool = ThreadPoolExecutor(min(threads, len(cut)))
            stack.callback(pool.shutdown, cancel_futures=True)
            sums_of_blocks = pool.map(sums, cut)
        for done, (weighted, weight) in enumerate(sums_of_blocks, 1):
            numerator += weighted
            denominator += weight
            progress(done / len(cut))
    return numerator, denominator


def n_workers(workers: object) -> int:
    """Return the number of threads: -1 means all CPUs, -2 all but one."""
    if not is_integer(workers):
        raise TypeError(f"workers: expected a whole number, got {workers!r}")
    cpus = os.cpu_count() or 1
    threads = int(workers) if workers >= 0 else cpus + 1 + int(workers)
    if threads < 1:
        raise ValueError(f"workers: expected a positive number, or -1 (all CPUs) to -{cpus}, got {workers}")
    return threads


def quotient(numerator: int | Fraction, denominator: int | Fraction, where: str = "") -> float:
    """Return the weighted mean, correctly rounded, or raise a ValueError if the weights are 0."""
    if denominator == 0:
        raise ValueError(f"gt: no power in any feature of any sequence{where}, so there is nothing to score")
    return float(numerator / denominator)
