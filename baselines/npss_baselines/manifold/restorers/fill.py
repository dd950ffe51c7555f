"""Fill joints that are missing for long, from the other joints in the frames around.

Networks correct the mean of a Gaussian of the pose, given the known joints.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array, Float64
from npss_baselines.manifold.applications.simple import with_lengths
from npss_baselines.manifold.model.gaussian import SpanGaussian
from npss_baselines.manifold.motion.features import VELOCITIES
from npss_baselines.manifold.motion.mirror import mirror_image, mirrored_joints
from npss_baselines.manifold.restorers.net import Float32, Net, mean_of

#: The frames that the networks see, counted from the one to fill.
OFFSETS = np.array([-25, -14, -7, -3, -1, 0, 1, 3, 7, 14, 25])


@dataclass(frozen=True, eq=False)
class Fill:
    """A Gaussian of the pose, and networks that correct it.

    Attributes
    ----------
    pose : SpanGaussian
        The Gaussian of a single frame.
    nets : tuple of Net
        Networks; their mean corrects the Gaussian's mean. See `inputs_of`.
    sets : (S, J) ndarray of bool
        The sets of missing joints that the networks have learned; other sets are left to the Gaussian.
    """

    pose: SpanGaussian
    nets: tuple[Net, ...]
    sets: npt.NDArray[np.bool_]

    def restore(self, motion: Float64, missing: npt.NDArray[np.bool_], skeleton: Skeleton) -> Float64:
        """Fill joints ``missing`` (J,) in all frames of motion ``(T, F)``, where their values do not count."""
        images = (motion, mirror_image(motion, skeleton))
        lost = (missing, missing[mirrored_joints(skeleton)])
        first, second = (self._filled(*image) for image in zip(images, lost, strict=True))
        filled = (first + mirror_image(second, skeleton)) / 2
        known = np.broadcast_to(~columns_of(missing), motion.shape)
        return with_lengths(np.where(known, motion, filled), known, skeleton)

    def _filled(self, motion: Float64, missing: npt.NDArray[np.bool_]) -> Float64:
        completed = complete(self.pose, motion, columns_of(missing))
        around = np.clip(np.arange(len(motion))[:, np.newaxis] + OFFSETS, 0, len(motion) - 1)
        scaled = self.pose.scaling.normalize(completed)
        if (self.sets == missing).all(axis=1).any():
            scaled[:, :-VELOCITIES] += mean_of(self.nets, inputs_of(scaled[around], missing))
        return self.pose.scaling.unnormalize(scaled)


def inputs_of(around: Array, missing: npt.NDArray[np.bool_]) -> Float32:
    """Return what the networks see: completed scaled frames ``(n, offsets, F)``, and which joints are missing."""
    n = len(around)
    flags = np.broadcast_to(missing, (n, missing.shape[-1]))
    return np.concatenate([around.reshape(n, -1), flags], axis=1).astype(np.float32)


def complete(pose: SpanGaussian, motion: Array, lost: npt.NDArray[np.bool_]) -> Float64:
    """Give lost features ``(F,)`` of motion ``(T, F)`` their mean, given the other features of the same frame."""
    frames = motion[:, np.newaxis]
    return pose.restore(frames, np.broadcast_to(~lost, frames.shape))[:, 0]


def columns_of(joints: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the features ``(F,)`` of joints ``(J,)``."""
    return np.concatenate([np.repeat(joints, 3), np.zeros(VELOCITIES, bool)])
