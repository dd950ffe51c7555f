"""The heart: the distance and the weight of every feature of every sequence, block by block.

Notation. Of one feature of one sequence (a *column*), over T frames: F the discrete Fourier transform, P[k] the
power of bin k (``abs(F)**2`` or ``F.real**2``). The input is real, so P[k] = P[T - k]: the first K = T//2 + 1 bins hold
all that there is. *Folded* means that the bins which have a twin (all but DC and, for even T, the Nyquist bin) count
double.

The two-sided earth mover's distance from the folded spectra. Let F_k, G_k be the cumulative distributions of
the two normalised *two-sided* spectra, d_k = G_k - F_k, and D_k the same difference for the *folded* spectra. By the
symmetry, D_k = 2 d_k - d_0, and the upper half of the two-sided sum mirrors the lower one: bin T - 1 - k holds
d_0 - d_k. A bin and its mirror add ``abs(d_k) + abs(d_k - d_0) = max(abs(d_0), abs(2 d_k - d_0))``, therefore

    sum_k abs(d_k)  =  sum_{k < T//2} max(abs(d_0), abs(D_k))  +  abs(d_0) / 2 for odd T, whose middle bin has d_0 / 2.

A distribution of zeros (``zero='empty'``) against one that sums to 1 breaks the symmetry: there F_k + F_{T-1-k} is
1 + F_0 for the latter, so the distance is (1 + F_0) T / 2.

Layout. Columns stand side by side, in pieces that fit the processor's cache, and every step runs down the bins of
all of them at once. No step mixes columns, and each adds up a column's bins in one order wherever the column stands:
its distance and weight depend on its own values, T and the convention alone, to the last bit.

Range. Power is squared, so values beyond 1e150 would overflow and below 1e-150 underflow. Columns whose total power
leaves a safe range are computed again after scaling by powers of two, which is exact; the power's own exponent is
returned beside it.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from npss._metric.convention import Convention
from npss._metric.power import COLUMNS, Int64, PowerSpectrum, padded
from npss.validation import Array, Float64, check_finite

_BLOCK = 2**20  # values of one array in one block, which is enough work for one thread to be given
_BLOCK_COLUMNS = 2**15  # columns in one block, at most
_MEMORY = 2**18  # values to work in: two megabytes, a processor core's cache
_BUFFER = 1024  # numpy's own: with its usual 8192, it takes twice as long to pair all rows of a piece with one
_SAFE = (1e-150, 1e150)  # total powers of which neither a bin that matters nor a ratio over- or underflows

#: Some sequences, and some of their features.
Block = tuple[slice, slice]


class Tile(NamedTuple):
    """The statistics of a block of sequences and features."""

    sequences: slice
    features: slice
    distance: Float64  # (n, d)
    weight: Float64  # (n, d); zero where the ground truth has no power
    exponent: Int64 | None  # (n, d); the weight is to be multiplied by 2**exponent


def blocks(motion: Array) -> list[Block]:
    """Cut an ``(N, T, D)`` or ``(T, D)`` array into blocks that `tile` may be given in any order, or at once."""
    n_sequences, n_frames, n_features = motion.shape if motion.ndim == 3 else (1, *motion.shape)
    return _cut(n_sequences, n_features, min(_BLOCK_COLUMNS, max(COLUMNS, _BLOCK // n_frames)))


def tile(gt: Array, pred: Array, convention: Convention, block: Block) -> Tile:
    """Compute the distances and weights of one block of two ``(N, T, D)`` or ``(T, D)`` arrays.

    Raises
    ------
    ValueError
        If a value of the block is NaN or infinite: names the argument and the first such index, anywhere in it.
    """
    rows, columns = block
    gt_block, pred_block = ((array if array.ndim == 3 else array[np.newaxis])[rows, :, columns] for array in (gt, pred))
    try:
        with np.errstate(all="ignore"):
            np.setbufsize(_BUFFER)  # as long as errstate lasts
            return Tile(rows, columns, *_statistics(gt_block, pred_block, convention))
    except _NotFiniteError:
        check_finite("gt", gt)
        check_finite("pred", pred)
        raise  # pragma: no cover - one of the two has raised


def _statistics(gt: Array, pred: Array, convention: Convention) -> tuple[Float64, Float64, Int64 | None]:
    """Return distance, weight and exponent of every column of two ``(n, T, d)`` arrays."""
    n, n_frames, d = gt.shape
    spectrum = PowerSpectrum(n_frames, convention.power, twins=convention.bins == "two-sided")
    n_bins = spectrum.n_bins
    height = 2 * n_bins + spectrum.n_scratch
    width = max(COLUMNS, min(padded(n * d), _MEMORY // height // COLUMNS * COLUMNS))
    memory = np.empty(height * width)  # in one piece, which the allocator keeps ready for the next block
    distance, weight = np.empty((2, n, d))
    exponent: Int64 | None = None
    for rows, columns in _cut(n, d, width):
        gt_piece, pred_piece = gt[rows, :, columns], pred[rows, :, columns]
        shape = gt_piece[:, 0].shape
        size = math.prod(shape)
        arrays = memory[: height * padded(size)].reshape(height, -1)
        gt_power, pred_power, scratch = arrays[:n_bins], arrays[n_bins : 2 * n_bins], arrays[2 * n_bins :]
        first = _spectra(gt_piece, spectrum, gt_power, scratch, convention)
        second = _spectra(pred_piece, spectrum, pred_power, scratch, convention)
        distance[rows, columns] = _distances(first, second, n_frames, convention)[:size].reshape(shape)
        weight[rows, columns] = first.total[:size].reshape(shape)
        if first.exponent is not None:
            exponent = np.zeros((n, d), np.int64) if exponent is None else exponent
            exponent[rows, columns] = first.exponent.reshape(shape)
    if convention.weight == "uniform":
        return distance, (weight > 0).astype(np.float64), None
    return distance, weight, exponent


def _cut(n_sequences: int, n_features: int, most: int) -> list[Block]:
    """Cut N sequences by D features into even pieces of at most `most` columns."""
    width = _even(n_features, most)
    height = _even(n_sequences, most // width)
    return [
        (slice(top, min(top + height, n_sequences)), slice(left, min(left + width, n_features)))
        for top in range(0, n_sequences, height)
        for left in range(0, n_features, width)
    ]


def _even(total: int, most: int) -> int:
    return math.ceil(total / math.ceil(total / most))


class _NotFiniteError(ValueError):
    """A value is NaN or infinite."""


class _Spectra(NamedTuple):
    power: Float64  # (K, m); what pads the n * d columns does not matter
    total: Float64  # (m,); the sum of the power over the bins
    exponent: Int64 | None  # (n * d,); the total is to be multiplied by 2**exponent
    norm: Float64  # (m,); the total, but 1 where there is no power
    empty: bool  # whether there may be such a column


def _spectra(
    motions: Array, spectrum: PowerSpectrum, power: Float64, scratch: Float64, convention: Convention
) -> _Spectra:
    """Compute the power spectra of ``(n, T, d)`` motions."""
    total = spectrum(motions, power, scratch)
    n, _, d = motions.shape
    totals = total[: n * d]
    if _SAFE[0] < totals.min() and totals.max() < _SAFE[1]:
        return _Spectra(power, total, None, total, empty=False)
    exponent = None
    safe = (totals > _SAFE[0]) & (totals < _SAFE[1])
    unsafe = np.flatnonzero(~safe & motions.any(axis=1).ravel())
    if unsafe.size:
        values = motions[unsafe // d, :, unsafe % d].astype(np.float64)
        if not np.isfinite(values).all():
            raise _NotFiniteError
        exponent = np.zeros(n * d, np.int64)
        power[:, unsafe], totals[unsafe], exponent[unsafe] = spectrum.rescaled(values)
    if convention.zero == "dc":
        power[0, total == 0] = 1.0
    return _Spectra(power, total, exponent, np.where(total == 0, 1.0, total), empty=True)


def _distances(first: _Spectra, second: _Spectra, n_frames: int, convention: Convention) -> Float64:
    """Return the distances ``(m,)``; the first power is overwritten."""
    # All distances below are times the norm of the second, by which they are divided in the end.
    difference = np.multiply(first.power, second.norm / first.norm, out=first.power)
    difference -= second.power
    at_dc = np.abs(difference[0])
    if convention.distance == "cdf":
        if convention.bins == "two-sided":
            difference = difference[: n_frames // 2]
        for above, row in pairwise(difference):
            row += above
    distances = np.abs(difference, out=difference)
    if convention.distance == "cdf" and convention.bins == "two-sided":
        np.maximum(distances, at_dc, out=distances)
    distance: Float64 = distances.sum(axis=0)
    if convention.distance == "cdf" and convention.bins == "two-sided":
        if n_frames % 2:
            distance += at_dc / 2
        if convention.zero == "empty" and (first.empty or second.empty):
            mirrored = (first.total > 0) == (second.total > 0)
            distance = np.where(mirrored, distance, (second.norm + at_dc) * (n_frames / 2))
    return np.divide(distance, second.norm, out=distance)
