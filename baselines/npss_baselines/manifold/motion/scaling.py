"""How networks see features: without their mean pose, and to a scale."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.validation import Array, Float64, one_of

#: What is of one scale: nothing is scaled, as in the paper; all features have one number; the positions have one, and
#: each of the three velocities; each feature has its own.
SCALES = ("none", "global", "kind", "feature")
_VELOCITIES = 3  # the last features of a frame: about Y, and along X and Z


@dataclass(frozen=True, eq=False)
class Scaling:
    """Mean and scale of features, which are float64.

    Attributes
    ----------
    mean, scale : (F,) ndarray
        What is subtracted, and what then is divided by.
    """

    mean: Float64
    scale: Float64

    def normalize(self, features: npt.ArrayLike) -> Array:
        """Return features (..., F) as networks see them, float64."""
        normalized: Array = (np.asarray(features) - self.mean) / self.scale
        return normalized

    def unnormalize(self, values: npt.ArrayLike) -> Array:
        """Return features (..., F) as they are, float64."""
        features: Array = np.asarray(values) * self.scale + self.mean
        return features


def fit_scaling(windows: npt.ArrayLike, mask: npt.ArrayLike, scale: str, size: float = 1.0) -> Scaling:
    """Compute the statistics of all frames that are not masked.

    Parameters
    ----------
    windows : (n, T, F) array_like
        Features of motion.
    mask : (n, T) array_like of bool
        False where a window is padded.
    scale : {'none', 'global', 'kind', 'feature'}
        What the standard deviation is taken over: the root mean square of the deviations from the mean pose, of all
        features, of the positions and of each velocity, or of each feature. One that does not vary counts as 1.
    size : float, optional
        What the standard deviation becomes, or by what features are multiplied if nothing is scaled.

    Raises
    ------
    ValueError
        If there is no such scale, or no frame.

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
        raise ValueError("windows: there is no frame to take the mean pose of")
    mean = frames.mean(axis=0)
    power = frames.var(axis=0)
    if scale == "none":
        power = np.ones_like(power)
    elif scale == "global":
        power = np.full_like(power, power.mean())
    elif scale == "kind":
        power[:-_VELOCITIES] = power[:-_VELOCITIES].mean()
    return Scaling(mean, np.where(power > 0, np.sqrt(power), 1.0) / size)
