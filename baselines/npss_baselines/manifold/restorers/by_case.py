"""The restorer that is trained: a way for each case of missing values."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array, Float64
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.model.gaussian import SpanGaussian
from npss_baselines.manifold.motion.features import VELOCITIES
from npss_baselines.manifold.motion.runs import runs
from npss_baselines.manifold.restorers.camera import Camera
from npss_baselines.manifold.restorers.conditional import Conditional
from npss_baselines.manifold.restorers.digest import digest_of
from npss_baselines.manifold.restorers.fill import Fill
from npss_baselines.manifold.restorers.keys import Keys
from npss_baselines.manifold.restorers.restorer import with_bones

#: A joint is missing for long if it is in no frame of more than this many, and frames in which nothing is known are a
#: gap if they are more than this: the Gaussian of 12 frames sees known values at both ends of shorter spells.
LONG, GAP = 10, 3
#: From the end of a long spell, frames over which its restoration fades into the Gaussian's.
FADE = 6


@dataclass(frozen=True, eq=False)
class ByCase:
    """Networks and Gaussians, each for a case, as a `Restorer`.

    - Noisy values: the Gaussian of 12 frames, corrected by the networks of `Camera`.
    - Frames without a known value, more than `GAP` in a row: `Keys`.
    - Joints missing for more than `LONG` frames: `Fill`, and near a frame where they are known, the Gaussian of 12.
    - All else: the Gaussian of 12 frames.

    Bones that end in joints not seen get their lengths.

    Attributes
    ----------
    gaussian : SpanGaussian
        The Gaussian of 12 frames.
    fill : Fill
    keys : Keys
    camera : Camera
        The networks.
    skeleton : Skeleton
        The skeleton.
    seen : dict
        What it was trained on, for reports.
    """

    gaussian: SpanGaussian
    fill: Fill
    keys: Keys
    camera: Camera
    skeleton: Skeleton = JOINTS
    seen: dict[str, object] = field(default_factory=dict)

    @property
    def signature(self) -> str:
        """The identity of all networks and Gaussians, to the bit."""
        arrays: list[Array] = [self.fill.pose.mean, self.fill.pose.covariance]
        for case in (self.fill, self.keys, self.camera):
            for net in case.nets:
                arrays += [*net.weights, *net.biases]
        return f"restorer-{digest_of(*arrays)}-{self.gaussian.signature}"

    def restore(self, left: Corrupted) -> Float64:
        """Restore motion; see `Restorer`."""
        restored = Conditional(self.gaussian, self.skeleton).restore(left)
        if np.any(left.noise):
            return self.camera.restore(left, restored, self.skeleton)
        for motion, known in zip(restored, left.known, strict=True):
            gap = _spells(~known.any(axis=1)) > GAP
            if gap.all():
                continue
            motion[:] = self.keys.restore(motion, ~gap, self.skeleton)
            self._fill(motion, _absent(known, gap))
        return with_bones(restored, left, self.skeleton)

    def _fill(self, motion: Float64, absent: npt.NDArray[np.bool_]) -> None:
        """Fill joints that are ``absent`` (T, J) for long in a motion ``(T, F)``, in place."""
        missing = np.stack([_spells(joint) > LONG for joint in absent.T], axis=1)
        for joints in np.unique(missing, axis=0):
            if not joints.any() or joints.all():
                continue
            filled = self.fill.restore(motion, joints, self.skeleton)
            chosen = np.flatnonzero((missing == joints).all(axis=1))
            away = _distances(np.any(absent[:, joints], axis=1))[chosen]
            share = np.clip((away - 1) / FADE, 0, 1)[:, np.newaxis]
            at = np.ix_(chosen, np.flatnonzero(np.repeat(joints, 3)))
            motion[at] = share * filled[at] + (1 - share) * motion[at]


def _absent(known: npt.NDArray[np.bool_], gap: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Return the joints ``(T, J)`` of which no value is known; in a gap, those absent before and after it."""
    frames = len(known)
    absent: npt.NDArray[np.bool_] = ~np.any(known[:, :-VELOCITIES].reshape(frames, -1, 3), axis=2)
    inside = np.flatnonzero(~gap)
    after = np.searchsorted(inside, np.arange(frames))
    before, behind = (inside[np.clip(number, 0, len(inside) - 1)] for number in (after - 1, after))
    return np.where(gap[:, np.newaxis], absent[before] & absent[behind], absent)


def _spells(flags: npt.NDArray[np.bool_]) -> npt.NDArray[np.intp]:
    """Return for each frame the length of the run of True that it is in; 0 where False."""
    lengths = np.zeros(len(flags), np.intp)
    for start, end in runs(flags):
        lengths[start:end] = end - start
    return lengths


def _distances(flags: Array) -> Float64:
    """Return for each frame the distance to the nearest one where the flag is False; infinite if there is none."""
    known = np.flatnonzero(~flags)
    if not len(known):
        return np.full(len(flags), np.inf)
    frames = np.arange(len(flags))
    after = np.searchsorted(known, frames)
    nearest = [known[np.clip(number, 0, len(known) - 1)] for number in (after - 1, after)]
    distances: Float64 = np.min([np.abs(frames - frame) for frame in nearest], axis=0).astype(np.float64)
    return distances
