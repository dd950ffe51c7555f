"""A Gaussian of a few frames, conditioned on the values that are known: restoration without training.

The features of `span` successive frames are one normal variable. Where some of them are known, the others have a
conditional mean, in closed form. Spans overlap, and their means are averaged.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.validation import Float64, is_real, positive_integer
from npss_baselines.manifold.motion.scaling import Scaling

#: Frames of a span, and frames from the start of one to the next.
SPAN, STEP = 12, 4
#: The share of the mean variance that is added to each variance: the covariance of many features is nearly singular.
RIDGE = 1e-5


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
        starts = [*range(0, last, positive_integer("step", step)), last]
        scaled = self.scaling.normalize(np.where(seen, motion, self.scaling.mean))
        total, weight = np.zeros_like(scaled), np.zeros((motion.shape[1], 1))
        # Frames in the middle of a span have known values on both sides.
        hill = np.minimum(np.arange(self.span) + 1, np.arange(self.span)[::-1] + 1.0)[:, np.newaxis]
        for start in starts:
            frames = slice(start, start + self.span)
            weight[frames] += hill
            total[:, frames] += hill * self._means(scaled[:, frames], seen[:, frames], np.tile(error, self.span))
        restored: Float64 = self.scaling.unnormalize(total / weight)
        return restored if error.any() else np.where(seen, motion, restored)

    def _means(self, spans: Float64, known: npt.NDArray[np.bool_], error: Float64) -> Float64:
        """Return the conditional means of spans ``(n, span, F)``; those with the same known values together."""
        rows, seen = spans.reshape(len(spans), -1), known.reshape(len(spans), -1)
        means = np.empty_like(rows)
        patterns, which = np.unique(seen, axis=0, return_inverse=True)
        for number, pattern in enumerate(patterns):
            chosen = which.reshape(-1) == number
            given = np.flatnonzero(pattern)
            among = self.covariance[np.ix_(given, given)] + np.diag(error[given] ** 2)
            away = (rows[np.ix_(chosen, given)] - self.mean[given]).T
            means[chosen] = self.mean + (self.covariance[:, given] @ np.linalg.solve(among, away)).T
        return means.reshape(spans.shape)


def fit_gaussian(
    windows: npt.ArrayLike, mask: npt.ArrayLike, scaling: Scaling, *, span: int = SPAN, ridge: float = RIDGE
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

    Raises
    ------
    TypeError, ValueError
        If there are fewer than two spans, or an argument is invalid.
    """
    if not (is_real(ridge) and ridge > 0):
        raise ValueError(f"ridge: expected a positive number, got {ridge!r}")
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
    covariance[np.diag_indices(size)] += ridge * np.trace(covariance) / size
    return SpanGaussian(span, mean, covariance, scaling)
