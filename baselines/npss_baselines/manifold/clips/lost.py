"""Which places and rotations of a clip are missing, frame by frame.

A joint without a place: the bone to it and all that hangs from it are unknown, so every joint turns freely that carries
nothing else. Joints without a common one at or below them, such as fingers, keep their rotation if anything is known. A
joint without a rotation: the places of all joints below it are unknown, but their rotations are kept.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss_baselines.data.mapping import JointMapping
from npss_baselines.data.motion import JOINTS, NAMES

Mask = npt.NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Lost:
    """What is missing in a clip of T frames.

    Attributes
    ----------
    places : (T, 20) ndarray of bool
        Of the common joints.
    rotations, translations : (T, J) ndarray of bool
        Of the joints of the skeleton, in the frames of their parents.
    """

    places: Mask
    rotations: Mask
    translations: Mask

    def __bool__(self) -> bool:
        """Return whether anything is missing."""
        return bool(self.places.any() or self.rotations.any() or self.translations.any())

    def __or__(self, other: Lost) -> Lost:
        """Return what is missing in either."""
        return Lost(
            self.places | other.places, self.rotations | other.rotations, self.translations | other.translations
        )


def without_places(missing: Mask, skeleton: Skeleton, mapping: JointMapping) -> Lost:
    """Return what is missing if common joints have no places ``(T, 20)``."""
    places = missing.copy()
    for joint in JOINTS._order[1:]:
        places[:, joint] |= places[:, JOINTS.parents[joint]]
    below, at = _carried(skeleton, mapping)
    seen = ~places
    # The last common joint of a limb turns freely; others that carry none, such as fingers, only with the whole figure.
    alone = np.where(at.any(axis=1), ~_any(seen, at), ~seen.any(axis=1, keepdims=True))
    rotations = np.where(below.any(axis=1), ~_any(seen, below), alone)
    translations = alone
    return Lost(places, rotations, translations)


def without_channels(rotations: Mask, translations: Mask, skeleton: Skeleton, mapping: JointMapping) -> Lost:
    """Return what is missing if joints of the skeleton have no rotations or translations ``(T, J)``."""
    below, _ = _carried(skeleton, mapping)
    places = _any(rotations, below.T)
    root = skeleton.parents.index(-1)
    hips = NAMES.index("Hips")
    places[:, hips] |= rotations[:, root] & translations[:, root]
    return Lost(places, rotations.copy(), translations.copy())


def _carried(skeleton: Skeleton, mapping: JointMapping) -> tuple[Mask, Mask]:
    """Return which common joints are below each joint of a skeleton, and which are below or at it, ``(J, 20)``."""
    at = np.zeros((len(skeleton.names), len(NAMES)), bool)
    for common, joint in enumerate(mapping.indices(skeleton)):
        if joint is not None:
            at[joint, common] = True
    below = np.zeros_like(at)
    for joint in skeleton._order[::-1]:
        if (parent := skeleton.parents[joint]) >= 0:
            below[parent] |= below[joint] | at[joint]
    for tip, parent in enumerate(JOINTS.parents):
        if mapping.joints[NAMES[tip]] is None:  # made from the bone to the hand
            below[:, tip], at[:, tip] = below[:, parent], at[:, parent]
    return below, below | at


def _any(mask: Mask, of: Mask) -> Mask:
    """Return in which frames any of the joints ``(T, n)`` is in a set ``(m, n)``, as ``(T, m)``."""
    return (mask.astype(np.intp) @ of.T.astype(np.intp)) > 0
