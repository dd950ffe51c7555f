"""Remove the noise of a depth camera, and fill what it did not see.

Networks correct the mean of a Gaussian of 12 frames, given noisy values.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from npss.skeleton import Skeleton
from npss.validation import Array, Float64
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.simple import interpolated
from npss_baselines.manifold.motion.features import VELOCITIES
from npss_baselines.manifold.motion.mirror import exchange_sides, mirror_image
from npss_baselines.manifold.motion.scaling import Scaling
from npss_baselines.manifold.restorers.net import Float32, Net, mean_of
from npss_baselines.manifold.restorers.restorer import with_bones

#: The frames that the networks see, from the one to restore: the Gaussian's mean, the camera's values, and what it saw.
OFFSETS = np.array([-12, -7, -4, -2, 0, 2, 4, 7, 12])
CLOSE = np.array([-6, -3, -1, 0, 1, 3, 6])
SEEN = np.array([-12, -6, -2, 0, 2, 6, 12])


@dataclass(frozen=True, eq=False)
class Camera:
    """Networks that correct the mean of a Gaussian.

    Attributes
    ----------
    scaling : Scaling
        The scaling of the features.
    nets : tuple of Net
        Networks, whose mean corrects the Gaussian's; without any, it stays.
    """

    scaling: Scaling
    nets: tuple[Net, ...]

    def restore(self, left: Corrupted, mean: Float64, skeleton: Skeleton) -> Float64:
        """Correct the ``mean`` (n, T, F) of motion, given what is left of it."""
        if not self.nets:
            return with_bones(mean, left, skeleton)
        first = self._restored(left, mean)
        image = Corrupted(mirror_image(left.features, skeleton), exchange_sides(left.known, skeleton), left.noise)
        second = mirror_image(self._restored(image, mirror_image(mean, skeleton)), skeleton)
        return with_bones((first + second) / 2, left, skeleton)

    def _restored(self, left: Corrupted, mean: Float64) -> Float64:
        scaled = self.scaling.normalize(mean)
        observed = self.scaling.normalize(interpolated(left))
        for motion, seen, known in zip(scaled, observed, left.known, strict=True):
            frames = np.arange(len(motion))
            motion += mean_of(self.nets, inputs_of(motion, seen, known, frames, (0, len(frames) - 1)))
        return self.scaling.unnormalize(scaled)


def inputs_of(
    mean: Array, observed: Array, known: Array, frames: Array, ends: tuple[Array | int, Array | int]
) -> Float32:
    """Return what the networks see of scaled motion ``(T, F)`` at some frames ``(n,)``.

    Parameters
    ----------
    mean : (T, F) ndarray
        The Gaussian's mean.
    observed : (T, F) ndarray
        What the camera saw, interpolated in time.
    known : (T, F) ndarray of bool
        What it saw.
    frames : (n,) ndarray of int
        The frames to restore.
    ends : two (n,) ndarrays of int, or two ints
        The first and the last frame of the motion that each frame belongs to.
    """
    first, last = (np.broadcast_to(end, frames.shape)[:, np.newaxis] for end in ends)

    def around(values: Array, offsets: Array) -> Array:
        taken: Array = values[np.clip(frames[:, np.newaxis] + offsets, first, last)].reshape(len(frames), -1)
        return taken

    parts = [around(mean, OFFSETS), around(observed, CLOSE), around(known[:, :-VELOCITIES:3], SEEN)]
    return np.concatenate(parts, axis=1).astype(np.float32)
