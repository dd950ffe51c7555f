"""A density on codes from which motion can be sampled: a Gaussian around each code of real motion."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64, Seed, check_finite, generator, positive_integer, real_array

__all__ = ["Prior", "fit_prior"]

#: Nearest codes that shape the Gaussian around a code, and numbers that describe a code.
NEIGHBOURS, COMPONENTS = 4, 256
_ARRAYS = ("mean", "components", "places")


@dataclass(frozen=True, eq=False)
class Prior:
    """A mixture of Gaussians on codes, one around each code of training motion.

    Each has the mean and the covariance of the code and its nearest neighbours. It thus mixes only motions that are
    alike: one Gaussian of all codes mixes standing and jumping.

    Attributes
    ----------
    mean : (T', H) ndarray of float32
        The mean code.
    components : (k, T', H) ndarray of float32
        Orthonormal components of the codes.
    places : (N, k) ndarray of float32
        The place of each training code along the components.
    neighbours : int
        Nearest codes, besides the code itself, that a Gaussian is fitted to.
    """

    mean: Array
    components: Array
    places: Array
    neighbours: int

    @property
    def signature(self) -> str:
        """The identity of the prior, to the bit."""
        digest = hashlib.sha256(b"".join(getattr(self, name).tobytes() for name in _ARRAYS)).hexdigest()
        return f"prior-{self.neighbours}-{digest[:12]}"

    def draw(self, n: int, *, seed: Seed) -> Float64:
        """Draw random codes.

        Parameters
        ----------
        n : int
            Number of codes.
        seed : int or numpy.random.Generator
            Source of randomness.

        Returns
        -------
        (n, T', H) ndarray of float64
            Codes, not limited to [-1, 1].

        Raises
        ------
        TypeError, ValueError
            If the number is not positive, or the seed is invalid.
        """
        rng = generator(seed)
        chosen = rng.integers(len(self.places), size=positive_integer("n", n))
        around = self.places[self._nearest[chosen]].astype(np.float64)  # (n, neighbours + 1, k)
        middle = around.mean(axis=1)
        # Weights of variance 1 give the sample covariance.
        weights = rng.normal(size=(n, 1, around.shape[1])) / np.sqrt(self.neighbours)
        places = middle + (weights @ (around - middle[:, np.newaxis]))[:, 0]
        codes: Float64 = self.mean + np.tensordot(places, self.components.astype(np.float64), 1)
        return codes

    @cached_property
    def _nearest(self) -> npt.NDArray[np.intp]:
        """The indices ``(N, neighbours + 1)`` of each code and its nearest ones."""
        places = self.places.astype(np.float64)
        power = np.square(places).sum(axis=1)
        distances = power + power[:, np.newaxis] - 2 * places @ places.T
        np.fill_diagonal(distances, -np.inf)  # each is its own nearest
        return np.argsort(distances, axis=1, kind="stable")[:, : self.neighbours + 1]


def fit_prior(codes: npt.ArrayLike, *, neighbours: int = NEIGHBOURS, components: int = COMPONENTS) -> Prior:
    """Fit the prior to codes of real motion.

    Parameters
    ----------
    codes : (N, T', H) array_like
        Codes of motions of one length, more than `neighbours`.
    neighbours : int, optional
        Nearest codes, besides the code itself, that a Gaussian is fitted to: more mix more, and give less of what is
        rare.
    components : int, optional
        Largest number of principal components to keep of the codes.

    Returns
    -------
    Prior
        The prior.

    Raises
    ------
    TypeError, ValueError
        If the codes are invalid or too few, or a number is not positive.

    Examples
    --------
    >>> codes = np.random.default_rng(0).uniform(-1, 1, (50, 20, 8))
    >>> fit_prior(codes).draw(3, seed=0).shape
    (3, 20, 8)
    """
    real = real_array("codes", codes)
    if real.ndim != 3 or 0 in real.shape:
        raise ValueError(f"codes: expected shape (N, T', H) = (motions, steps, units), got {real.shape}")
    check_finite("codes", real)
    if len(real) <= positive_integer("neighbours", neighbours):
        raise ValueError(f"codes: {neighbours} neighbours need more than as many codes, got {len(real)}")
    rows = real.reshape(len(real), -1).astype(np.float64)
    mean = rows.mean(axis=0)
    rows -= mean
    # Both Gram matrices have the same non-zero eigenvalues; decompose the smaller one.
    few = len(rows) < rows.shape[1]
    power, vectors = np.linalg.eigh(rows @ rows.T if few else rows.T @ rows)
    kept = np.flatnonzero(power > np.finfo(np.float64).eps * max(rows.shape) * power[-1])[::-1]
    kept = kept[: positive_integer("components", components)]
    axes = vectors[:, kept].T
    if few:
        axes = axes @ rows / np.sqrt(power[kept])[:, np.newaxis]
    places = rows @ axes.T
    mean, axes = mean.reshape(real.shape[1:]), axes.reshape(-1, *real.shape[1:])
    return Prior(mean.astype(np.float32), axes.astype(np.float32), places.astype(np.float32), neighbours)
