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

Form. Scale all bins of the prediction but DC by one factor, so that its share of DC is that of the ground truth. Then
DC does not differ, and the other bins differ as the normalised spectra without DC do, times the ground truth's share of
power outside DC. So the distance that is left is this share times the distance of the spectra whose DC is set to 0.

The floor. In the sum above each of the T bins adds at least ``abs(d_0) / 2``, so a distance of two-sided cumulative
distributions is at least T / 2 times the difference of the shares of DC. That of two spectra that sum to 1 is at least
twice this difference, since the other bins differ by as much in total. Both are reached if the spectra outside DC have
the same form.

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
_NOTHING = 1e-20  # a share of the power that is rounding noise
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
    parts: PartsOfTile | None  # if asked for


class PartsOfTile(NamedTuple):
    """What the distances of a block are made of; see *Form* and *The floor*."""

    form: Float64  # (n, d); the distance if the prediction had the ground truth's share of DC
    floor: Float64  # (n, d); the least distance with these shares of DC, for two-sided conventions


def blocks(motion: Array) -> list[Block]:
    """Cut an ``(N, T, D)`` or ``(T, D)`` array into blocks for `tile`, in any order or in parallel."""
    n_sequences, n_frames, n_features = motion.shape if motion.ndim == 3 else (1, *motion.shape)
    return _cut(n_sequences, n_features, min(_BLOCK_COLUMNS, max(COLUMNS, _BLOCK // n_frames)))


def tile(gt: Array, pred: Array, convention: Convention, block: Block, *, parts: bool = False) -> Tile:
    """Compute distances and weights, and perhaps parts, of one block of two ``(N, T, D)`` or ``(T, D)`` arrays.

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
            return Tile(rows, columns, *_statistics(gt_block, pred_block, convention, parts))
    except _NotFiniteError:
        check_finite("gt", gt)
        check_finite("pred", pred)
        raise  # pragma: no cover - one of the two has raised


def _statistics(
    gt: Array, pred: Array, convention: Convention, with_parts: bool
) -> tuple[Float64, Float64, Int64 | None, PartsOfTile | None]:
    """Return distance, weight, exponent and parts of every column of two ``(n, T, d)`` arrays."""
    n, n_frames, d = gt.shape
    spectrum = PowerSpectrum(n_frames, convention.power, twins=convention.bins == "two-sided")
    n_bins = spectrum.n_bins
    height = 2 * n_bins + spectrum.n_scratch
    width = max(COLUMNS, min(padded(n * d), _MEMORY // height // COLUMNS * COLUMNS))
    memory = np.empty(height * width)  # one allocation, which the allocator reuses for the next block
    distance, weight = np.empty((2, n, d))
    exponent: Int64 | None = None
    parts = PartsOfTile(*np.empty((2, n, d))) if with_parts else None
    for rows, columns in _cut(n, d, width):
        gt_piece, pred_piece = gt[rows, :, columns], pred[rows, :, columns]
        shape = gt_piece[:, 0].shape
        size = math.prod(shape)
        arrays = memory[: height * padded(size)].reshape(height, -1)
        gt_power, pred_power, scratch = arrays[:n_bins], arrays[n_bins : 2 * n_bins], arrays[2 * n_bins :]
        first = _spectra(gt_piece, spectrum, gt_power, scratch, convention)
        second = _spectra(pred_piece, spectrum, pred_power, scratch, convention)
        kept = first.power.copy() if parts else first.power  # _distances overwrites the first power
        distances = _distances(first, second, n_frames, convention)
        distance[rows, columns] = distances[:size].reshape(shape)
        if parts:
            split = _parts(first._replace(power=kept), second, distances, n_frames, convention)
            for whole, part in zip(parts, split, strict=True):
                whole[rows, columns] = part[:size].reshape(shape)
        weight[rows, columns] = first.total[:size].reshape(shape)
        if first.exponent is not None:
            exponent = np.zeros((n, d), np.int64) if exponent is None else exponent
            exponent[rows, columns] = first.exponent.reshape(shape)
    if convention.weight == "uniform":
        return distance, (weight > 0).astype(np.float64), None, parts
    return distance, weight, exponent, parts


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


def _parts(
    first: _Spectra, second: _Spectra, distances: Float64, n_frames: int, convention: Convention
) -> tuple[Float64, Float64]:
    """Return form and floor of the distances, ``(m,)`` each; both powers are overwritten."""
    truth, prediction = _without_dc(first), _without_dc(second)
    # The shares of power outside DC: more precise than 1 minus the share of DC.
    moving, predicted = truth.total / first.norm, prediction.total / second.norm
    # A prediction without power outside DC has no form.
    form = np.where(predicted > _NOTHING, moving * _distances(truth, prediction, n_frames, convention), 0.0)
    floor = (n_frames / 2 if convention.distance == "cdf" else 2.0) * np.abs(moving - predicted)
    if convention.zero == "empty":
        floor = np.where(second.total > 0, floor, distances)  # an empty distribution has one distance only
    return form, floor


def _without_dc(spectra: _Spectra) -> _Spectra:
    """Set DC to 0 and scale the rest, whose sum is the new total, to a sum of 1; the power is overwritten."""
    power = spectra.power
    power[0] = 0.0
    total: Float64 = power.sum(axis=0)
    power /= np.where(total > 0, total, 1.0)
    return _Spectra(power, total, None, np.ones_like(total), empty=False)
