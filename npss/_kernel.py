"""The heart: the distance and the weight of every feature of every sequence, tile by tile.

Notation. Of one feature of one sequence, over T frames: F the discrete Fourier transform, P[k] the power of bin k
(``abs(F)**2`` or ``F.real**2``). The input is real, so P[k] = P[T - k]: the first K = T//2 + 1 bins hold all that there
is. *Folded* means that the bins which have a twin (all but DC and, for even T, the Nyquist bin) count double.

The two-sided earth mover's distance from the folded spectra. Let F_k, G_k be the cumulative distributions of
the two normalised *two-sided* spectra, d_k = G_k - F_k, and D_k the same difference for the *folded* spectra. By the
symmetry, D_k = 2 d_k - d_0, and the upper half of the two-sided sum mirrors the lower one: bin T - 1 - k holds
d_0 - d_k. A bin and its mirror add ``abs(d_k) + abs(d_k - d_0) = max(abs(d_0), abs(2 d_k - d_0))``, therefore

    sum_k abs(d_k)  =  sum_{k < T//2} max(abs(d_0), abs(D_k))  +  abs(d_0) / 2 for odd T, whose middle bin has d_0 / 2.

A distribution of zeros (``zero='empty'``) against one that sums to 1 breaks the symmetry: there F_k + F_{T-1-k} =
1 + F_0 for the latter, so the distance is (1 + F_0) T / 2.

Range. Power is squared, so values beyond 1e150 would overflow and below 1e-150 underflow. Features whose total power
leaves a safe range are computed again after scaling by a power of two, which is exact; the power's own exponent is
returned beside it.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from npss._checks import Array, Float64, check_finite
from npss._convention import Convention

_TILE = 2**16  # values of one array in one tile: half a megabyte as float64, so that a tile's work stays in cache
_SAFE = (1e-240, 1e240)  # total powers in which no bin that matters has overflowed or underflowed


class Tile(NamedTuple):
    """The statistics of a block of sequences and features."""

    sequences: slice
    features: slice
    distance: Float64  # (n, d)
    weight: Float64  # (n, d); zero where the ground truth has no power
    exponent: npt.NDArray[np.int64] | None  # (n, d); the weight is to be multiplied by 2**exponent


def tiles(gt: Array, pred: Array, convention: Convention) -> Iterator[Tile]:
    """Yield the distances and weights of two ``(N, T, D)`` or ``(T, D)`` arrays, every sequence and feature once.

    Raises
    ------
    ValueError
        If a value is NaN or infinite: names the argument and the first such index.
    """
    n_sequences, n_frames, n_features = gt.shape if gt.ndim == 3 else (1, *gt.shape)
    width = max(1, min(n_features, _TILE // n_frames))
    height = max(1, _TILE // (n_frames * width))
    for top in range(0, n_sequences, height):
        rows = slice(top, min(top + height, n_sequences))
        for left in range(0, n_features, width):
            columns = slice(left, min(left + width, n_features))
            with np.errstate(all="ignore"):
                first, weight, exponent = _spectra("gt", gt, rows, columns, convention)
                second, pred_total, _ = _spectra("pred", pred, rows, columns, convention)
                mirrored = convention.zero == "dc" or (weight > 0) == (pred_total > 0)
                distance = _distances(first, second, n_frames, mirrored, convention)
            if convention.weight == "uniform":
                weight = (weight > 0).astype(np.float64)
                exponent = None
            yield Tile(rows, columns, distance, weight, exponent)


def _spectra(
    name: str, motion: Array, rows: slice, columns: slice, convention: Convention
) -> tuple[Float64, Float64, npt.NDArray[np.int64] | None]:
    """Return the normalised spectra ``(n, d, K)``, their totals ``(n, d)`` and the totals' exponents of two."""
    motions = motion if motion.ndim == 3 else motion[np.newaxis]
    block = np.ascontiguousarray(motions[rows, :, columns].transpose(0, 2, 1), dtype=np.float64)  # (n, d, T)
    power, total = _power(block, convention)
    exponent = None
    unsafe = ~((total > _SAFE[0]) & (total < _SAFE[1]))
    if unsafe.any():
        peak = np.abs(block[unsafe]).max(axis=-1)
        if not np.isfinite(peak).all():
            check_finite(name, motion)
        shift = np.frexp(peak)[1].astype(np.int64)
        power[unsafe], total[unsafe] = _power(np.ldexp(block[unsafe], -shift[:, np.newaxis]), convention)
        exponent = np.zeros(total.shape, np.int64)
        exponent[unsafe] = 2 * shift
        empty = total == 0
        power[empty, 0] = 1.0 if convention.zero == "dc" else 0.0  # the other bins are zero already
        power /= np.where(empty, 1.0, total)[..., np.newaxis]
    else:
        power /= total[..., np.newaxis]
    return power, total, exponent


def _power(block: Float64, convention: Convention) -> tuple[Float64, Float64]:
    """Return the power of the bins that the convention counts ``(..., K)``, and its sum ``(...)``."""
    n_frames = block.shape[-1]
    transform = np.fft.rfft(block, axis=-1)
    power = np.square(transform.real)
    if convention.power == "magnitude":
        power += np.square(transform.imag)
    if convention.bins == "two-sided":
        power[..., 1 : (n_frames + 1) // 2] *= 2.0
    return power, power.sum(axis=-1)


def _distances(
    first: Float64,
    second: Float64,
    n_frames: int,
    mirrored: npt.NDArray[np.bool_] | bool,
    convention: Convention,
) -> Float64:
    """Return the distances ``(...)`` of normalised spectra ``(..., K)``, of which the second is overwritten.

    ``mirrored`` says where both distributions have the same sum.
    """
    difference = np.subtract(second, first, out=second)
    if convention.distance == "spectrum":
        return _summed(np.abs(difference, out=difference))
    at_dc = np.abs(difference[..., 0])  # d_0
    cumulative = np.cumsum(difference, axis=-1, out=difference)
    np.abs(cumulative, out=cumulative)
    if convention.bins == "one-sided":
        return _summed(cumulative)
    lower = cumulative[..., : n_frames // 2]
    np.maximum(lower, at_dc[..., np.newaxis], out=lower)
    distance = _summed(lower)
    if n_frames % 2:
        distance += at_dc / 2
    return np.where(mirrored, distance, (1.0 + at_dc) * (n_frames / 2))


def _summed(bins: Float64) -> Float64:
    total: Float64 = bins.sum(axis=-1)
    return total
