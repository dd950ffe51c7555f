"""A clip of the user's own, on any skeleton: to features, and what changed in them back onto the skeleton."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.validation import Float64
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.motion.bones import leg_length, normalise_lengths
from npss_baselines.manifold.motion.features import FPS, to_features, to_positions
from npss_baselines.manifold.motion.ground import on_ground
from npss_baselines.manifold.motion.onto_skeleton import Fitted, onto_skeleton, unit
from npss_baselines.manifold.motion.resample import resample


@dataclass(frozen=True, eq=False)
class OwnClip:
    """A clip of the user's own.

    Attributes
    ----------
    motion : Bvh
        The clip as it was read.
    mapping : JointMapping
        Its common joints.
    common : (T, 20, 3) ndarray
        Positions of the common joints, in the unit and at the rate of the file.
    features : (T', 63) ndarray of float64
        Features at 30 frames per second, in body heights.
    """

    motion: Bvh
    mapping: JointMapping
    common: Float64
    features: Float64

    def back(
        self,
        features: Float64,
        *,
        places: npt.NDArray[np.bool_] | None = None,
        turning: npt.NDArray[np.bool_] | None = None,
    ) -> Fitted:
        """Put changed features back onto the skeleton of the clip.

        Only the change of each bone's direction, and of the place of the hips, goes back: what did not change returns
        exactly, and details above 12 Hz stay as they are.

        Parameters
        ----------
        features : (T', 63) ndarray
            The changed features.
        places : (T, 20) ndarray of bool, optional
            Which common joints change their places (default: all). Where they meet frames in which they do not, the
            change is zero: a remainder is spread over the frames in which they do.
        turning : (T, J) ndarray of bool, optional
            Which joints of the skeleton may turn (default: all).

        Returns
        -------
        Fitted
            The clip on its own skeleton, and how far its joints are from what the features ask for.
        """
        before, after = self._in_world(self.features), self._in_world(np.asarray(features, np.float64))
        turns = unit(_bones(after)) - unit(_bones(before))
        moves = (after[:, 0] - before[:, 0]) * body_height(self.common)
        changes = np.concatenate([turns, moves[:, np.newaxis]], axis=1)  # (T', 21, 3)
        at_rate = resample(changes, FPS, self.motion.fps)
        frames = np.minimum(np.arange(len(self.common)), len(at_rate) - 1)  # the last frames may lie after the last one
        changes = at_rate[frames]
        if places is not None:
            changes = _confined(changes, np.concatenate([places, places[:, :1]], axis=1))
        turns, moves = changes[:, :-1], changes[:, -1]
        targets = self.common.copy()
        targets[:, 0] += moves
        towards = unit(_bones(self.common)) + turns  # only the direction counts
        for joint in JOINTS._order[1:]:
            targets[:, joint] = targets[:, JOINTS.parents[joint]] + towards[:, joint]
        moving = None if places is None else places[:, 0]
        return onto_skeleton(targets, self.motion, self.mapping, turning=turning, moving=moving)

    def _in_world(self, features: Float64) -> Float64:
        """Return positions at 30 frames per second, in body heights, turned as the file begins."""
        positions = to_positions(features)
        first, wanted = (place[0] - place[0, 0] for place in (to_positions(self.features[:1]), self.common))
        across = np.sum(first[:, 2] * wanted[:, 0] - first[:, 0] * wanted[:, 2])
        along = np.sum(first[:, 0] * wanted[:, 0] + first[:, 2] * wanted[:, 2])
        sin, cos = np.array([across, along]) / np.hypot(across, along)
        turned: Float64 = positions @ np.array([[cos, 0, -sin], [0, 1, 0], [sin, 0, cos]])
        return turned


_PARENTS = [max(parent, 0) for parent in JOINTS.parents]


def prepare_clip(motion: Bvh, mapping: JointMapping) -> OwnClip:
    """Prepare a clip as training motion is prepared: its common joints, at 30 frames per second, with common bones.

    Parameters
    ----------
    motion : Bvh
        The clip; y is up.
    mapping : JointMapping
        Its common joints.

    Raises
    ------
    ValueError
        If the mapping does not fit the skeleton, or the motion cannot be prepared.
    """
    common = mapping.positions(motion.positions(), motion.skeleton)
    positions = normalise_lengths(resample(common, motion.fps), JOINTS)
    return OwnClip(motion, mapping, common, to_features(on_ground(positions), JOINTS))


def body_height(common: Float64) -> float:
    """Return the unit of features in the unit of positions ``(T, 20, 3)`` of the common joints: by the legs' length."""
    own, of_height_1 = (np.linalg.norm(bones, axis=-1) for bones in (_bones(common), JOINTS.offsets))
    return leg_length(own, JOINTS) / leg_length(of_height_1, JOINTS)


def _bones(positions: Float64) -> Float64:
    """Return the vector from each joint's parent to it, ``(T, 20, 3)``; zero for the root."""
    return positions - positions[:, _PARENTS]


def _confined(changes: Float64, where: npt.NDArray[np.bool_]) -> Float64:
    """Return changes ``(T, n, 3)`` that are zero but where they may be, and begin and end there without a jump."""
    confined = np.where(where[..., np.newaxis], changes, 0)
    frames = np.arange(len(changes))
    for column, inside in enumerate(where.T):
        if inside.any() and not inside.all():
            for axis in range(3):
                at_edges = np.interp(frames[inside], frames[~inside], changes[~inside, column, axis])
                confined[inside, column, axis] -= at_edges
    return confined
