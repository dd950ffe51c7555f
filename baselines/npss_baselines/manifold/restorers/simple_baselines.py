"""The simple baselines to restore motion, fitted to training motion."""

from __future__ import annotations

from typing import cast, get_args

import numpy as np

from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.simple import Way
from npss_baselines.manifold.model.gaussian import POSE_RIDGE, fit_gaussian
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.scaling import fit_scaling
from npss_baselines.manifold.restorers.conditional import Conditional
from npss_baselines.manifold.restorers.interpolation import Interpolation
from npss_baselines.manifold.restorers.kernel_ridge import FRAMES, fit_kernel_ridge
from npss_baselines.manifold.restorers.key_ridge import fit_key_ridge
from npss_baselines.manifold.restorers.restorer import Restorer
from npss_baselines.manifold.restorers.smoothing import Smoothing

#: The names of the simple baselines. The second kernel ridge regression scales each feature by itself.
NAMES = (
    *("linear", "pchip", "hermite", "smoothing"),
    *("pose-gaussian", "kernel-ridge", "kernel-ridge-2", "key-ridge", "gaussian"),
)


class SimpleBaselines:
    """Simple baselines, each fitted when it is first needed.

    Parameters
    ----------
    training : MotionSet
        The training motion.
    """

    def __init__(self, training: MotionSet) -> None:
        self._training = training
        self.scaling = fit_scaling(training.windows, training.mask, "kind")
        self._restorers: dict[str, Restorer] = {}

    def __getitem__(self, name: str) -> Restorer:
        """Return a simple baseline by name."""
        if name not in self._restorers:
            self._restorers[name] = self._fit(name)
        return self._restorers[name]

    def of(self, left: Corrupted) -> dict[str, Restorer]:
        """Return the simple baselines that fit what is lost, by name."""
        return {name: self[name] for name in names_for(left)}

    def _fit(self, name: str) -> Restorer:
        windows, mask = self._training.windows, self._training.mask
        if name in get_args(Way):
            return Interpolation(cast(Way, name))
        if name == "smoothing":
            return Smoothing()
        if name == "pose-gaussian":
            return Conditional(fit_gaussian(windows, mask, self.scaling, span=1, ridge=POSE_RIDGE))
        if name in ("kernel-ridge", "kernel-ridge-2"):
            frames = min(FRAMES, mask.sum() // 4)  # neighbours are nearly equal, and its time grows with the cube
            return fit_kernel_ridge(windows, mask, scale="kind" if name == "kernel-ridge" else "feature", frames=frames)
        if name == "key-ridge":
            return fit_key_ridge(windows, mask, self.scaling)
        return Conditional(fit_gaussian(windows, mask, self.scaling))


def names_for(left: Corrupted) -> list[str]:
    """Return the names of the simple baselines that fit what is lost."""
    if np.any(left.noise):
        return ["linear", "smoothing", "gaussian"]
    if (~left.known).all(axis=1).any():  # features are lost throughout a window
        return ["pose-gaussian", "kernel-ridge", "kernel-ridge-2", "gaussian"]
    of_keys = ["key-ridge"] if (left.known == left.known[..., :1]).all() else []  # whole frames are
    return ["linear", "pchip", "hermite", *of_keys, "gaussian"]
