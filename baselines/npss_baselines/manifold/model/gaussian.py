"""A Gaussian of a few frames, conditioned on the values that are known: restoration without training.

The features of `span` successive frames are one normal variable. Where some of them are known, the others have a
conditional mean, in closed form. Spans overlap, and their means are averaged.

Each set of known values needs a system of equations, which is what takes time. Without noise, there are as many
equations as known values, or as missing ones: the smaller number is taken. Those of missing values are well
conditioned, and solved in single precision. With noise, there are as many as principal components that rise above it.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64, is_real, positive_integer
from npss_baselines.manifold.motion.scaling import Scaling

#: Frames of a span, and frames from the start of one to the next.
SPAN, STEP = 12, 4
#: The share of the mean variance that is added to each variance: the covariance of many features is nearly singular.
RIDGE = 1e-5
#: The same for the pose alone: the best on validation subjects.
POSE_RIDGE = 1e-3
#: Shares of the mean variance that are added to the covariance of a feature's values at two frames: the same for all
#: frames, and one that falls with their distance, as a Gaussian of this width in frames. Other people stand and move in
#: ways that training motion does not show: without this, the Gaussian of CMU alone repairs Human3.6M far worse.
OFFSET, SWAY, SLOW = 0.02, 0.01, 12.0
#: Principal components for noisy values: the others are left to the variances of independent errors.
RANK = 150


#: Known values of a span, and the spans that have them.
Groups = list[tuple[npt.NDArray[np.bool_], npt.NDArray[np.intp]]]


@dataclass(frozen=True, eq=False)
class SpanGaussian:
    """A normal distribution of scaled features of a few frames.

    Attributes
    ----------
    span : int
        The number of frames.
    mean : (span * F,) ndarray
        The mean.
    covariance : (span * F, span * F) ndarray
        The covariance.
    scaling : Scaling
        The scaling of the features.
    """

    span: int
    mean: Float64
    covariance: Float64
    scaling: Scaling

    @property
    def signature(self) -> str:
        """The identity of the distribution, to the bit."""
        arrays = (self.mean, self.covariance, self.scaling.mean, self.scaling.scale)
        digest = hashlib.sha256(b"".join(array.tobytes() for array in arrays)).hexdigest()
        return f"gaussian-{self.span}-{digest[:12]}"

    def restore(
        self, features: npt.ArrayLike, known: npt.ArrayLike, *, noise: npt.ArrayLike = 0.0, step: int = STEP
    ) -> Float64:
        """Return the mean of motion, given its known values.

        Parameters
        ----------
        features : (n, T, F) array_like
            Motion; values that are not known do not count.
        known : (n, T, F) array_like of bool
            Where values are known.
        noise : float or (F,) array_like, optional
            The standard deviation of the error of known values, in the unit of the features. Without noise, known
            values stay as they are.
        step : int, optional
            Frames from the start of one span to the next: fewer are better and slower.

        Returns
        -------
        (n, T, F) ndarray of float64
            The restored motion.

        Raises
        ------
        TypeError, ValueError
            If the shapes differ, motion is shorter than a span, or `noise` is negative.
        """
        motion, seen = np.asarray(features, np.float64), np.asarray(known, bool)
        n_features = len(self.scaling.mean)
        if motion.ndim != 3 or motion.shape[2] != n_features or motion.shape[1] < self.span:
            raise ValueError(
                f"features: expected shape (n, T, {n_features}) with at least {self.span} frames, got {motion.shape}"
            )
        if seen.shape != motion.shape:
            raise ValueError(f"known: expected the shape of features, {motion.shape}, got {seen.shape}")
        error = np.broadcast_to(np.asarray(noise, np.float64) / self.scaling.scale, (n_features,))
        if not (error >= 0).all():
            raise ValueError(f"noise: expected a standard deviation, 0 or more, got {noise!r}")
        last = motion.shape[1] - self.span
        starts = [*range(0, last, min(positive_integer("step", step), self.span)), last]
        scaled = self.scaling.normalize(np.where(seen, motion, self.scaling.mean))
        total, weight = np.zeros_like(scaled), np.zeros((motion.shape[1], 1))
        # Frames in the middle of a span have known values on both sides.
        hill = np.minimum(np.arange(self.span) + 1, np.arange(self.span)[::-1] + 1.0)[:, np.newaxis]
        at = np.asarray(starts)[:, np.newaxis] + np.arange(self.span)  # (starts, span)
        # Spans of all starts together: those of the same known values share their equations.
        shape = (-1, self.span, n_features)
        means = self._means(scaled[:, at].reshape(shape), seen[:, at].reshape(shape), np.tile(error, self.span))
        for number, frames in enumerate(at):
            weight[frames] += hill
            total[:, frames] += hill * means.reshape(len(motion), len(starts), *shape[1:])[:, number]
        restored: Float64 = self.scaling.unnormalize(total / weight)
        return restored if error.any() else np.where(seen, motion, restored)

    @cached_property
    def _precision(self) -> Float64:
        """The inverse of the covariance."""
        inverse = np.linalg.inv(self.covariance)
        precision: Float64 = (inverse + inverse.T) / 2
        return precision

    @cached_property
    def _factors(self) -> tuple[Float64, Float64]:
        """The loadings ``(size, R)`` of principal components of variance 1, and the variances left to errors."""
        power, vectors = np.linalg.eigh(self.covariance)
        loadings = vectors[:, -RANK:] * np.sqrt(power[-RANK:] - power[0])
        return loadings, np.diag(self.covariance) - np.square(loadings).sum(axis=1)

    def _means(self, spans: Float64, known: npt.NDArray[np.bool_], error: Float64) -> Float64:
        """Return the conditional means of spans ``(n, span, F)``; those with the same known values together."""
        seen = known.reshape(len(spans), -1)
        away = np.where(seen, spans.reshape(len(spans), -1) - self.mean, 0)
        _, first, which = np.unique(np.packbits(seen, axis=1), axis=0, return_index=True, return_inverse=True)
        groups = [(seen[example], np.flatnonzero(which.reshape(-1) == i)) for i, example in enumerate(first)]
        means = self._noisy(away, groups, error) if error.any() else self._exact(away, groups)
        return (self.mean + means).reshape(spans.shape)

    def _exact(self, away: Float64, groups: Groups) -> Float64:
        """Return the means of deviations ``(n, size)``, of which those of the groups are known."""
        solve = _solver()
        means, pulled = away.copy(), away @ self._precision
        for known, chosen in groups:
            given, asked = np.flatnonzero(known), np.flatnonzero(~known)
            if len(asked) <= len(given):
                right = pulled[np.ix_(chosen, asked)].T
                means[np.ix_(chosen, asked)] = -solve(self._precision[np.ix_(asked, asked)], right, np.float32).T
            else:
                right = away[np.ix_(chosen, given)].T
                factors = solve(self.covariance[np.ix_(given, given)], right, np.float64)
                means[chosen] = (self.covariance[:, given] @ factors).T
        return means

    def _noisy(self, away: Float64, groups: Groups, error: Float64) -> Float64:
        """Return the means of deviations ``(n, size)``, given noisy values of the groups.

        The features are L z + e, with factors z and errors e of variances D. Of noise N, the mean of z is (1 + L' (D +
        N)^-1 L)^-1 L' (D + N)^-1 y, and that of e is the share D / (D + N) of the rest.
        """
        loadings, variances = self._factors
        weights = 1 / (variances + error**2)
        weighted = (loadings * np.sqrt(weights)[:, np.newaxis]).astype(np.float32)
        everywhere = weighted.T @ weighted
        everywhere[np.diag_indices(len(everywhere))] += 1
        right = (away * weights) @ loadings
        means = np.empty_like(away)
        for known, chosen in groups:
            fewer = weighted[~known] if 2 * known.sum() > len(known) else weighted[known]
            among = fewer.T @ fewer
            if 2 * known.sum() > len(known):
                among = everywhere - among
            else:
                among[np.diag_indices(len(among))] += 1
            common = np.linalg.solve(among.astype(np.float64), right[chosen].T).T @ loadings.T
            means[chosen] = common + known * variances * weights * (away[chosen] - common)
        return means


def _solver() -> Callable[[Float64, Float64, type[np.floating]], Array]:
    """Return the solver of symmetric systems in some precision.

    Cholesky's takes half the time, and is in scipy; systems too ill-conditioned for it are solved by elimination, in
    double precision.
    """
    try:
        from scipy.linalg import get_lapack_funcs
    except ImportError:
        return lambda matrix, right, dtype: np.linalg.solve(matrix.astype(dtype), right.astype(dtype))

    def solved(matrix: Float64, right: Float64, dtype: type[np.floating]) -> Array:
        # scipy.linalg.solve does the same, but before 1.15 compares single precision with the epsilon of double.
        if not len(matrix):
            return right
        rounded = matrix.astype(dtype)
        factorize, condition, substitute = get_lapack_funcs(("potrf", "pocon", "potrs"), dtype=dtype)
        norm = np.abs(rounded).sum(axis=0).max()
        factor, failed = factorize(rounded, clean=False, overwrite_a=True)
        if failed or condition(factor, norm)[0] < np.finfo(dtype).eps:
            return np.linalg.solve(matrix, right)
        found: Array = substitute(factor, right.astype(dtype))[0]
        return found

    return solved


def fit_gaussian(
    windows: npt.ArrayLike,
    mask: npt.ArrayLike,
    scaling: Scaling,
    *,
    span: int = SPAN,
    ridge: float = RIDGE,
    offset: float = OFFSET,
    sway: float = SWAY,
) -> SpanGaussian:
    """Fit the distribution to the spans of windows, one every quarter of a span.

    Parameters
    ----------
    windows : (n, T, F) array_like
        Training windows.
    mask : (n, T) array_like of bool
        False in padding, which is left out.
    scaling : Scaling
        The scaling of the features.
    span : int, optional
        Frames of a span; 1 for the distribution of poses.
    ridge : float, optional
        The share of the mean variance that is added to each variance.
    offset, sway : float, optional
        Shares of the mean variance that are added to the covariances of each feature at different frames, for people
        who stand and move in other ways: a constant, and one that falls with the distance of the frames. Not for a
        single frame.

    Raises
    ------
    TypeError, ValueError
        If there are fewer than two spans, or an argument is invalid.
    """
    if not (is_real(ridge) and ridge > 0):
        raise ValueError(f"ridge: expected a positive number, got {ridge!r}")
    for name, share in (("offset", offset), ("sway", sway)):
        if not (is_real(share) and share >= 0):
            raise ValueError(f"{name}: expected a number of at least 0, got {share!r}")
    motion, whole = np.asarray(windows), np.asarray(mask, bool)
    span = positive_integer("span", span)
    size = span * motion.shape[2]
    total, squares, count = np.zeros(size), np.zeros((size, size)), 0
    for start in range(0, motion.shape[1] - span + 1, max(1, span // 4)):
        frames = slice(start, start + span)
        chosen = scaling.normalize(motion[whole[:, frames].all(axis=1), frames])
        rows = chosen.reshape(len(chosen), size)
        total += rows.sum(axis=0)
        squares += rows.T @ rows
        count += len(rows)
    if count < 2:
        raise ValueError(f"windows: expected at least two spans of {span} frames, got {count}")
    mean = total / count
    covariance = squares / count - np.outer(mean, mean)
    unit = np.trace(covariance) / size
    covariance[np.diag_indices(size)] += ridge * unit
    if span > 1:
        at = np.arange(span)
        near = np.exp(-((at[:, np.newaxis] - at) ** 2) / (2 * SLOW**2))
        covariance += np.kron(unit * (offset + sway * near), np.eye(motion.shape[2]))
    return SpanGaussian(span, mean, covariance, scaling)
