"""Ridge regression of the frames between keys on the four keys around them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Float64
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.corrupt import EVERY, Corrupted
from npss_baselines.manifold.applications.simple import interpolated
from npss_baselines.manifold.motion.scaling import Scaling
from npss_baselines.manifold.restorers.digest import digest_of
from npss_baselines.manifold.restorers.restorer import with_bones

#: The share of the mean variance of keys that is added to each: the best on validation subjects.
RIDGE = 1e-4


@dataclass(frozen=True, eq=False)
class KeyRidge:
    """Ridge regression on four keys, as a `Restorer` of keys at a fixed distance.

    Attributes
    ----------
    weights : (every - 1, 4 F + 1, F) ndarray
        For each frame after a key, the weights of the two keys before it and of the two after it, and the intercept.
    scaling : Scaling
        The scaling of the features.
    skeleton : Skeleton
        The skeleton, for the lengths of bones that end in joints not seen.
    """

    weights: Float64
    scaling: Scaling
    skeleton: Skeleton = JOINTS

    @property
    def signature(self) -> str:
        """The identity of the weights."""
        return f"key-ridge-{digest_of(self.weights)}"

    def restore(self, left: Corrupted) -> Float64:
        """Restore motion; see `Restorer`.

        Frames between keys at another distance are interpolated linearly; before the first key and after the last, it
        is held.
        """
        every = len(self.weights) + 1
        restored = interpolated(left)
        scaled = self.scaling.normalize(left.features)
        for motion, given, known in zip(restored, scaled, np.all(left.known, axis=2), strict=True):
            keys = np.flatnonzero(known)
            if not len(keys):
                continue
            around = np.concatenate([keys[:1], keys, keys[-1:]])  # the first and the last key count twice
            for number in np.flatnonzero(np.diff(keys) == every):
                beside = given[around[number : number + 4]].reshape(-1)
                between = slice(keys[number] + 1, keys[number + 1])
                motion[between] = self.scaling.unnormalize(beside @ self.weights[:, :-1] + self.weights[:, -1])
        return with_bones(restored, left, self.skeleton)


def fit_key_ridge(
    windows: npt.ArrayLike,
    mask: npt.NDArray[np.bool_],
    scaling: Scaling,
    *,
    every: int = EVERY,
    ridge: float = RIDGE,
) -> KeyRidge:
    """Fit the regression to all frames of windows ``(n, T, F)`` whose four keys are in the mask."""
    scaled, whole = scaling.normalize(windows), np.asarray(mask)
    n_frames = scaled.shape[1]
    if n_frames <= 3 * every:
        raise ValueError(f"every: windows of {n_frames} frames have no four keys {every} frames apart")
    weights = []
    for offset in range(1, every):
        # Frames t whose keys are at t - offset - every, t - offset, and one and two distances later.
        frames = np.arange(offset + every, n_frames - 2 * every + offset)
        at = [frames - offset + shift for shift in (-every, 0, every, 2 * every)]
        chosen = whole[:, at[3]]  # frames before the last one in the mask are in it, too
        given = np.concatenate([scaled[:, where][chosen] for where in at], axis=1)
        asked = scaled[:, frames][chosen]
        mean, target = given.mean(axis=0), asked.mean(axis=0)
        moments = (given - mean).T @ (given - mean)
        moments[np.diag_indices(len(moments))] += ridge * np.trace(moments) / len(moments)
        slopes = np.linalg.solve(moments, (given - mean).T @ (asked - target))
        weights.append(np.concatenate([slopes, (target - mean @ slopes)[np.newaxis]]))
    return KeyRidge(np.stack(weights), scaling)
