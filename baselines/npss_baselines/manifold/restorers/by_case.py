"""The restorer that is trained: a way for each case of missing values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array, Float64
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.simple import interpolated
from npss_baselines.manifold.model.gaussian import SpanGaussian
from npss_baselines.manifold.motion.features import VELOCITIES
from npss_baselines.manifold.motion.runs import runs
from npss_baselines.manifold.restorers.camera import Camera
from npss_baselines.manifold.restorers.conditional import Conditional
from npss_baselines.manifold.restorers.digest import digest_of
from npss_baselines.manifold.restorers.fill import Fill, columns_of
from npss_baselines.manifold.restorers.keys import Keys
from npss_baselines.manifold.restorers.restorer import with_bones

#: Raise it whenever the same networks and Gaussians restore differently: files of other versions are refused.
VERSION = 2
#: Frames in which nothing is known are a gap if they are more than this in a row.
GAP = 3
#: A joint is missing for long if it is in no frame of more than this many: the Gaussian of 12 frames sees known values
#: at both ends of shorter spells, and the camera's networks in spells of up to `LONG_FOR_CAMERA`.
LONG, LONG_FOR_CAMERA = 5, 30
#: Frames of a spell up to which interpolation in time is better than filling from other joints. Chosen, like the two
#: above, on validation subjects.
EVEN = 12


@dataclass(frozen=True, eq=False)
class ByCase:
    """Networks and Gaussians, each for a case, as a `Restorer`.

    - Noisy values: the Gaussian of 12 frames, corrected by the networks of `Camera`.
    - Frames without a known value, more than `GAP` in a row: `Keys`.
    - Then, joints missing for long: a cubic in time and `Fill`; see `bridged`.
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
        """The version, and the identity of all networks and Gaussians, to the bit."""
        arrays: list[Array] = [self.fill.pose.mean, self.fill.pose.covariance]
        for case in (self.fill, self.keys, self.camera):
            for net in case.nets:
                arrays += [*net.weights, *net.biases]
        return f"restorer-{VERSION}-{digest_of(*arrays)}-{self.gaussian.signature}"

    def restore(self, left: Corrupted) -> Float64:
        """Restore motion; see `Restorer`."""
        restored = Conditional(self.gaussian, self.skeleton).restore(left)
        noisy = bool(np.any(left.noise))
        long = LONG_FOR_CAMERA if noisy else LONG
        if noisy:
            restored = self.camera.restore(left, restored, self.skeleton)
        for motion, known in zip(restored, left.known, strict=True):
            gap = _spells(~known.any(axis=1)) > GAP
            if gap.all():
                continue
            if not noisy:
                motion[:] = self.keys.restore(motion, ~gap, self.skeleton)
            self._fill(motion, _absent(known, gap), long)
        return with_bones(restored, left, self.skeleton)

    def _fill(self, motion: Float64, absent: npt.NDArray[np.bool_], long: int) -> None:
        """Fill joints that are ``absent`` (T, J) in more than ``long`` frames of a motion ``(T, F)``, in place."""
        missing = np.stack([_spells(joint) > long for joint in absent.T], axis=1)
        if not missing.any():
            return
        before, known = motion.copy(), ~np.stack([columns_of(joints) for joints in missing])
        curve = interpolated(Corrupted(before[np.newaxis], known[np.newaxis]), "hermite")[0]
        guesses = {
            joints.tobytes(): self.fill.restore(before, joints, self.skeleton)
            for joints in np.unique(missing, axis=0)
            if joints.any() and not joints.all()
        }
        for joint in np.flatnonzero(missing.any(axis=0)):
            at = slice(3 * joint, 3 * joint + 3)
            for start, end in runs(missing[:, joint]):
                if not missing[start:end].all(axis=1).any():
                    filled = _chained(guesses, missing, start, end)[:, at]
                    motion[start:end, at] = bridged(before[:, at], filled, curve[:, at], start, end)


def _chained(guesses: Mapping[bytes, Float64], missing: npt.NDArray[np.bool_], start: int, end: int) -> Float64:
    """Return the guess of a spell; where other joints go missing or return, the next guess continues the one before."""
    chained = guesses[missing[start].tobytes()].copy()
    for frame in range(start + 1, end):
        if (missing[frame] != missing[frame - 1]).any():
            now = guesses[missing[frame].tobytes()]
            chained[frame:] = now[frame:] + (chained[frame] - now[frame])
    return chained


def bridged(motion: Float64, filled: Float64, curve: Float64, start: int, end: int) -> Float64:
    """Return the values of a spell, which continue the motion around it.

    Filled values are moved so that they meet the motion: a pose that is guessed from the other joints is mostly wrong
    by the same amount as in the frames around, where the truth is known. In spells of at most `EVEN` frames the curve
    counts alone, and in longer ones by the square of `EVEN` over the length.

    Parameters
    ----------
    motion : (T, D) ndarray
        The motion; values of the spell do not count.
    filled : (T, D) ndarray
        Values guessed from other joints, in all frames.
    curve : (T, D) ndarray
        The motion, with the spell interpolated in time.
    start, end : int
        The first frame of the spell, and the one after the last.

    Returns
    -------
    (end - start, D) ndarray of float64
        Values; those filled where the spell is the whole motion.

    Examples
    --------
    >>> motion = np.zeros((100, 1))
    >>> bridged(motion, motion + 5, motion, 20, 80).max()
    np.float64(0.0)
    """
    ends = [frame for frame in (start - 1, end) if 0 <= frame < len(motion)]
    if not ends:
        return filled[start:end]
    wrong, frames = motion[ends] - filled[ends], np.arange(start, end)
    offset = np.stack([np.interp(frames, ends, column) for column in wrong.T], axis=1)
    share = min(1.0, (EVEN / (end - start)) ** 2) if len(ends) == 2 else 0.0
    spell: Float64 = share * curve[start:end] + (1 - share) * (filled[start:end] + offset)
    return spell


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
