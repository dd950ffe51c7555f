"""Mirror images of motion: left and right exchanged."""

from __future__ import annotations

import re

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array
from npss_baselines.manifold.motion.features import VELOCITIES


def mirrored_joints(skeleton: Skeleton) -> npt.NDArray[np.intp]:
    """Return the index of each joint's counterpart; joints whose names have no side are their own.

    Examples
    --------
    >>> from npss_baselines.data.motion import JOINTS
    >>> [JOINTS.names[j] for j in mirrored_joints(JOINTS)[:2]]
    ['Hips', 'RightUpLeg']
    """
    other = {"Left": "Right", "Right": "Left"}
    names = [re.sub("^(Left|Right)", lambda side: other[side[0]], name) for name in skeleton.names]
    return np.array([skeleton.names.index(name) for name in names])


def mirror_image(features: Array, skeleton: Skeleton) -> Array:
    """Return the mirror image of features ``(..., 3 J + 3)``: sides exchanged, x and turns reversed.

    Examples
    --------
    >>> from npss_baselines.manifold.motion.prepared import motion_set
    >>> from npss_baselines.data.motion import JOINTS
    >>> walk = motion_set(quick=True).windows[:1]
    >>> bool(np.array_equal(mirror_image(mirror_image(walk, JOINTS), JOINTS), walk))
    True
    """
    image = exchange_sides(features, skeleton)
    image[..., :-VELOCITIES:3] *= -1  # x
    image[..., -VELOCITIES : -VELOCITIES + 2] *= -1  # the turn, and the velocity along x
    return image


def exchange_sides(values: Array, skeleton: Skeleton) -> Array:
    """Return values of features ``(..., 3 J + 3)``, such as which are known, with left and right joints exchanged."""
    joints = mirrored_joints(skeleton)
    columns = np.concatenate(
        [(3 * joints[:, np.newaxis] + np.arange(3)).ravel(), 3 * len(joints) + np.arange(VELOCITIES)]
    )
    exchanged: Array = np.asarray(values)[..., columns]
    return exchanged
