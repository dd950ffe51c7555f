"""Compute the power spectra of many columns at once, bins by columns; no column's bits depend on the others.

A *column* is one feature of one sequence, x[t] over T frames, F its discrete Fourier transform. Since x is real, the
first K = T//2 + 1 bins hold all of F. Folding the frames about t = 0,

    e[t] = x[t] + x[T - t],   o[t] = x[t] - x[T - t]   for 0 < t < T/2,   and e[t] = x[t] for t = 0 and t = T/2,

leaves two products with small matrices, K x K and S x S with S = (T - 1)//2:

    Re F[k]  =  sum_t cos(2 pi k t / T) e[t],        -Im F[k]  =  sum_t sin(2 pi k t / T) o[t].

Up to some hundred frames this is faster than an FFT, even for prime T. A factor of sqrt(2) in the rows of bins 1 to S,
which have a twin F[T - k], makes their squares count double.

Bits. The rounding of a matrix product may depend on its shape and on a column's place in it. So every product has
`COLUMNS` columns, padded with zeros, and its shape depends on T alone. Matrices are used for a T only if a trial gives
a column the same bits in every place. Otherwise, and for long T, the FFT transforms one column at a time.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64

COLUMNS = 48  # columns of every matrix product; columns are padded to a multiple of it
_PRODUCT = 250_000  # multiplications in one product: too few for BLAS to start threads
_TERMS = 160  # most terms in the sums for a bin for which matrices are faster than the FFT ...
_TERMS_ROUGH = 512  # ... and if T has a prime factor above 13, on which the FFT is slow
_FFT = 2**15  # values passed to the FFT at once

Int64 = npt.NDArray[np.int64]


class PowerSpectrum:
    """The power spectrum of columns of T frames: ``F.real**2`` or ``abs(F)**2`` of bins 0 to T//2.

    Parameters
    ----------
    n_frames : int
        T.
    power : {'real', 'magnitude'}
        Use the real part of a bin, or both parts.
    twins : bool
        Whether bins with a twin count double.
    """

    def __init__(self, n_frames: int, power: str, *, twins: bool) -> None:
        self.n_bins = n_frames // 2 + 1  # K
        self._n_pairs = (n_frames - 1) // 2  # S
        self._n_sines = self._n_pairs if power == "magnitude" else 0
        self._twins = twins
        fast = self.n_bins + self._n_sines <= (_TERMS if _is_smooth(n_frames) else _TERMS_ROUGH)
        self._matrices = _matrices(n_frames, twins) if fast else None
        #: Rows of scratch memory needed.
        self.n_scratch = self._n_sines + (n_frames if self._matrices else 0)

    def __call__(self, motions: Array, power: Float64, scratch: Float64) -> Float64:
        """Compute the power of the columns of ``(n, T, d)`` motions, of any real dtype.

        Parameters
        ----------
        motions : ndarray
            The motions.
        power : (K, m) ndarray
            Overwritten by the n * d columns, then zeros up to m, a multiple of `COLUMNS`.
        scratch : (n_scratch, m) ndarray
            Scratch memory.

        Returns
        -------
        ndarray
            The sum over the bins, ``(m,)``; not finite where a value is not finite or the power overflows.
        """
        return self._add_up(power, self._transform(motions, power, scratch))

    def rescaled(self, values: Float64) -> tuple[Float64, Float64, Int64]:
        """Compute the power of ``(n, T)`` nonzero columns of any magnitude.

        Scale the values by a power of two, so that their transform cannot overflow, and then the transform, so that
        its square can neither over- nor underflow.

        Returns
        -------
        power, total, exponent : ndarray
            ``(K, n)``, ``(n,)`` and ``(n,)``; multiply `power` and `total` by ``2**exponent``.
        """
        n, m = len(values), padded(len(values))
        real, scratch = np.empty((self.n_bins, m)), np.empty((self.n_scratch, m))
        before = _exponent(np.abs(values).max(axis=1))
        imaginary = self._transform(np.ldexp(values, -before[:, np.newaxis]).T[np.newaxis], real, scratch)
        after = _exponent(np.maximum(np.abs(real).max(axis=0), np.abs(imaginary).max(axis=0, initial=0.0)))
        total = self._add_up(np.ldexp(real, -after, out=real), np.ldexp(imaginary, -after, out=imaginary))
        return real[:, :n], total[:n], 2 * (before + after[:n])

    def _add_up(self, real: Float64, imaginary: Float64) -> Float64:
        """Overwrite the real parts with the power, and return its sum over the bins."""
        np.square(real, out=real)
        if self._n_sines:
            real[1 : self._n_sines + 1] += np.square(imaginary, out=imaginary)
        # There are always several columns: numpy would sum a single one in another order.
        total: Float64 = real.sum(axis=0)
        return total

    def _transform(self, motions: Array, real: Float64, scratch: Float64) -> Float64:
        """Fill `real` with the real parts, and return the imaginary parts of bins 1 to S if they are used."""
        if self._matrices:
            return self._by_matrices(motions, real, scratch, *self._matrices)
        return self._by_fft(motions, real, scratch)

    def _by_matrices(
        self, motions: Array, real: Float64, scratch: Float64, cosines: Float64, sines: Float64
    ) -> Float64:
        n, n_frames, d = motions.shape
        frames, odd = scratch[:n_frames], scratch[n_frames:]
        frames[:, : n * d].reshape(n_frames, n, d)[...] = motions.transpose(1, 0, 2)
        frames[:, n * d :] = 0.0
        even, imaginary = frames[: self.n_bins], frames[self.n_bins :][: self._n_sines]
        after, before = frames[1 : self._n_pairs + 1], frames[: self.n_bins - 1 : -1]
        if self._n_sines:
            np.subtract(after, before, out=odd)
        after += before
        _multiply(cosines, even, real)
        if self._n_sines:
            _multiply(sines, odd, imaginary)
        return imaginary

    def _by_fft(self, motions: Array, real: Float64, imaginary: Float64) -> Float64:
        n, n_frames, d = motions.shape
        at_once = max(1, _FFT // (n_frames * d))
        for top in range(0, n, at_once):
            some = motions[top : top + at_once].transpose(0, 2, 1)
            columns = slice(top * d, (top + len(some)) * d)
            bins = np.fft.rfft(np.ascontiguousarray(some, dtype=np.float64).reshape(-1, n_frames)).T
            real[:, columns] = bins.real
            imaginary[:, columns] = bins.imag[1 : self._n_sines + 1]
        real[:, n * d :] = 0.0
        imaginary[:, n * d :] = 0.0
        if self._twins:
            real[1 : self._n_pairs + 1] *= math.sqrt(2.0)
            imaginary *= math.sqrt(2.0)
        return imaginary


def padded(n_columns: int) -> int:
    """Return the next multiple of `COLUMNS`."""
    return COLUMNS * math.ceil(n_columns / COLUMNS)


def _exponent(magnitudes: Float64) -> Int64:
    """Return the smallest powers of two above the magnitudes."""
    exponent: Int64 = np.frexp(magnitudes)[1].astype(np.int64)
    return exponent


def _is_smooth(number: int) -> bool:
    for prime in (2, 3, 5, 7, 11, 13):
        while number % prime == 0:
            number //= prime
    return number == 1


@lru_cache(maxsize=4)
def _matrices(n_frames: int, twins: bool) -> tuple[Float64, Float64] | None:
    """Return K x K cosines and S x S sines, or None if the bits of their products depend on a column's place."""
    bins = np.arange(n_frames // 2 + 1)
    paired = slice(1, (n_frames + 1) // 2)
    angles = np.arange(n_frames) * (2 * math.pi / n_frames)
    turns = np.outer(bins, bins) % n_frames  # integers, so that no angle exceeds a full turn
    cosines = np.cos(angles)[turns]
    sines = np.sin(angles)[turns[paired, paired]]
    if twins:
        cosines[paired] *= math.sqrt(2.0)
        sines *= math.sqrt(2.0)
    for matrix in (cosines, sines):
        matrix.flags.writeable = False
        column = np.random.default_rng(0).standard_normal((len(matrix), 1))
        product = np.empty((len(matrix), COLUMNS))
        _multiply(matrix, np.repeat(column, COLUMNS, axis=1), product)
        if (product != product[:, :1]).any():
            return None
    return cosines, sines


def _multiply(matrix: Float64, columns: Float64, out: Float64) -> None:
    """Multiply ``(rows, terms)`` by ``(terms, m)``, `COLUMNS` columns and a part of the rows at a time."""
    n_rows = len(matrix)
    n_parts = math.ceil(matrix.size * COLUMNS / _PRODUCT)
    for part in range(n_parts):
        rows = slice(n_rows * part // n_parts, n_rows * (part + 1) // n_parts)
        np.matmul(matrix[rows], _side_by_side(columns), out=_side_by_side(out[rows]))


def _side_by_side(columns: Float64) -> Float64:
    """View ``(rows, m)`` as ``(m / COLUMNS, rows, COLUMNS)``."""
    return columns.reshape(len(columns), -1, COLUMNS).swapaxes(0, 1)
