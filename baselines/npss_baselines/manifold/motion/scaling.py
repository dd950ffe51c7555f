"""Scale features for networks: subtract the mean pose, divide by a scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64, one_of

#: Features that share a scale: none are scaled, as in the paper; all features; the positions, with a scale for each
#: velocity; each feature alone.
SCALES = ("none", "global", "kind", "feature")
_VELOCITIES = 3  # the last features of a frame: about y, along x and along z


@dataclass(frozen=True, eq=False)
class Scaling:
    """Mean and scale of features, in float64.

    Attributes
    ----------
    mean, scale : (F,) ndarray
        Subtracted from features; then they are divided by the scale.
    """

    mean: Float64
    scale: Float64

    def normalize(self, features: npt.ArrayLike) -> Array:
        """Scale features (..., F) for networks, in float64."""
        normalized: Array = (np.asarray(features) - self.mean) / self.scale
        return normalized

    def unnormalize(self, values: npt.ArrayLike) -> Array:
        """Undo the scaling of features (..., F), in float64."""
        features: Array = np.asarray(values) * self.scale + self.mean
        return features


def fit_scaling(windows: npt.ArrayLike, mask: npt.ArrayLike, scale: str, size: float = 1.0) -> Scaling:
    """Compute the mean and scale of all frames in the mask.

    Parameters
    ----------
    windows : (n, T, F) array_like
        Features of motion.
    mask : (n, T) array_like of bool
        False where a window is padded.
    scale : {'none', 'global', 'kind', 'feature'}
        Features that share a standard deviation, the root mean square of deviations from the mean pose: all features,
        the positions (each velocity has its own), or each feature alone. A zero deviation is replaced by 1.
    size : float, optional
        Standard deviation of the scaled features, or the factor they are multiplied by for ``'none'``.

    Raises
    ------
    ValueError
        If the scale is unknown, or there are no frames.

    Examples
    --------
    >>> import numpy as np
    >>> windows = np.random.default_rng(0).normal(3, [2, 2, 2, 4, 5, 6], (10, 160, 6))
    >>> fit_scaling(windows, np.full((10, 160), True), "kind").scale.round()
    array([2., 2., 2., 4., 5., 6.])
    """
    one_of("scale", scale, SCALES)
    frames = np.asarray(windows)[np.asarray(mask)].astype(np.float64)  # (N, F)
    if not len(frames):
        raise ValueError("windows: no frames to compute the mean pose from")
    mean = frames.mean(axis=0)
    power = frames.var(axis=0)
    if scale == "none":
        power = np.ones_like(power)
    elif scale == "global":
        power = np.full_like(power, power.mean())
    elif scale == "kind":
        power[:-_VELOCITIES] = power[:-_VELOCITIES].mean()
    return Scaling(mean, np.where(power > 0, np.sqrt(power), 1.0) / size)
