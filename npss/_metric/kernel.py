"""Compute the distance and weight of every feature of every sequence, block by block.

Notation. A *column* is one feature of one sequence over T frames, F its discrete Fourier transform, P[k] the power of
bin k (``abs(F)**2`` or ``F.real**2``). The input is real, so P[k] = P[T - k], and the first K = T//2 + 1 bins hold all
information. In a *folded* spectrum, bins with a twin (all except DC and, for even T, the Nyquist bin) count double.

The two-sided earth mover's distance from folded spectra. Let F_k, G_k be the cumulative distributions of the two
normalised *two-sided* spectra, d_k = G_k - F_k, and D_k the same difference for the *folded* spectra. By symmetry,
D_k = 2 d_k - d_0, and the upper half of the two-sided sum mirrors the lower one: bin T - 1 - k holds d_0 - d_k. A bin
and its mirror add ``abs(d_k) + abs(d_k - d_0) = max(abs(d_0), abs(2 d_k - d_0))``, therefore

    sum_k abs(d_k)  =  sum_{k < T//2} max(abs(d_0), abs(D_k))  +  abs(d_0) / 2 for odd T, whose middle bin has d_0 / 2.

A distribution of zeros (``zero='empty'``) against one that sums to 1 breaks the symmetry: F_k + F_{T-1-k} is 1 + F_0
for the latter, so the distance is (1 + F_0) T / 2.

Layout. Columns are side by side, in pieces that fit the processor's cache, and every step runs down the bins of all
columns at once. No step mixes columns, and each sums a column's bins in an order that is independent of its place. So
the bits of its distance and weight depend only on its values, T and the convention.

Range. Power is squared, so values beyond 1e150 would overflow and below 1e-150 underflow. Columns whose total power
leaves a safe range are computed again after exact scaling by powers of two; the exponent of their power is returned
separately.
"""

from __future__ import annotations

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from npss._metric.convention import Convention
from npss._metric.power import COLUMNS, Int64, PowerSpectrum, padded
from npss.validation import Array, Float64, check_finite

_BLOCK = 2**20  # values of one array in one block: a thread's unit of work
_BLOCK_COLUMNS = 2**15  # columns in one block, at most
_MEMORY = 2**18  # working values: two megabytes, a processor core's cache
_BUFFER = 1024  # numpy's buffer: at its default of 8192, broadcasting a row over a piece takes twice as long
_SAFE = (1e-150, 1e150)  # total powers for which no relevant bin and no ratio over- or underflows

#: Slices of sequences and features.
Block = tuple[slice, slice]


class Tile(NamedTuple):
    """The statistics of a block of sequences and features."""

    sequences: slice
    features: slice
    distance: Float64  # (n, d)
    weight: Float64  # (n, d); zero where the ground truth has no power
    exponent: Int64 | None  # (n, d); multiply the weight by 2**exponent


def blocks(motion: Array) -> list[Block]:
    """Cut an ``(N, T, D)`` or ``(T, D)`` array into blocks for `tile`, in any order or in parallel."""
    n_sequences, n_frames, n_features = motion.shape if motion.ndim == 3 else (1, *motion.shape)
    return _cut(n_sequences, n_features, min(_BLOCK_COLUMNS, max(COLUMNS, _BLOCK // n_frames)))


def tile(gt: Array, pred: Array, convention: Convention, block: Block) -> Tile:
    """Compute the distances and weights of one block of two ``(N, T, D)`` or ``(T, D)`` arrays.

    Raises
    ------
    ValueError
        If a value of the block is NaN or infinite. The message names the first such index of the whole argument.
    """
    rows, columns = block
    gt_block, pred_block = ((array if array.ndim == 3 else array[np.newaxis])[rows, :, columns] for array in (gt, pred))
    try:
        with np.errstate(all="ignore"):
            np.setbufsize(_BUFFER)  # errstate restores it
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
    memory = np.empty(height * width)  # one allocation, which the allocator reuses for the next block
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
    exponent: Int64 | None  # (n * d,); multiply the total by 2**exponent
    norm: Float64  # (m,); the total, or 1 for a column without power
    empty: bool  # whether columns without power are possible


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
    # All distances below are multiplied by the norm of the second; the last line divides by it.
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
