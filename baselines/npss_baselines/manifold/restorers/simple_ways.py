"""The simple ways to restore motion, fitted to training motion."""

from __future__ import annotations

from collections.abc import Iterator
from functools import lru_cache

import numpy as np

from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.model.gaussian import fit_gaussian
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.scaling import fit_scaling
from npss_baselines.manifold.restorers.conditional import Conditional
from npss_baselines.manifold.restorers.interpolation import Interpolation
from npss_baselines.manifold.restorers.kernel_ridge import fit_kernel_ridge
from npss_baselines.manifold.restorers.key_ridge import fit_key_ridge
from npss_baselines.manifold.restorers.restorer import Restorer
from npss_baselines.manifold.restorers.smoothing import Smoothing

#: The names of the simple ways.
NAMES = ("linear", "pchip", "hermite", "smoothing", "pose-gaussian", "kernel-ridge", "key-ridge", "gaussian")
#: The ridge of the pose's Gaussian, as a share of the mean variance: the best on validation subjects.
POSE_RIDGE = 1e-3


class SimpleWays:
    """Simple ways, each fitted when it is first needed.

    Parameters
    ----------
    training : MotionSet
        The training motion.
    """

    def __init__(self, training: MotionSet) -> None:
        self._training = training
        self.scaling = fit_scaling(training.windows, training.mask, "kind")
        self._fitted = lru_cache(maxsize=None)(self._fit)

    def of(self, left: Corrupted) -> Iterator[tuple[str, Restorer]]:
        """Yield the name and the restorer of each simple way that fits what is lost."""
        if np.any(left.noise):
            yield "linear", Interpolation("linear")
            yield "smoothing", Smoothing()
        elif (~left.known).all(axis=1).any():  # features are lost throughout a window
            yield "pose-gaussian", self._fitted("pose-gaussian")
            yield "kernel-ridge", self._fitted("kernel-ridge")
        else:
            yield "linear", Interpolation("linear")
            yield "pchip", Interpolation("pchip")
            yield "hermite", Interpolation("hermite")
            if (left.known == left.known[..., :1]).all():  # whole frames are
                yield "key-ridge", self._fitted("key-ridge")
        yield "gaussian", self._fitted("gaussian")

    def _fit(self, name: str) -> Restorer:
        windows, mask = self._training.windows, self._training.mask
        if name == "pose-gaussian":
            return Conditional(fit_gaussian(windows, mask, self.scaling, span=1, ridge=POSE_RIDGE))
        if name == "kernel-ridge":
            return fit_kernel_ridge(windows, mask, self.scaling)
        if name == "key-ridge":
            return fit_key_ridge(windows, mask, self.scaling)
        return Conditional(fit_gaussian(windows, mask, self.scaling))
