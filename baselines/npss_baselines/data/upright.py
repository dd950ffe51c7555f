"""Which way is up in a clip, and clips turned so that it is y."""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, get_args

import numpy as np

from npss.validation import one_of
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping
from npss_baselines.data.motion import NAMES

#: The axes that may point up.
Up = Literal["y", "z"]

_TO_Y = {"y": np.eye(3), "z": np.array([[1.0, 0, 0], [0, 0, 1], [0, -1, 0]])}


def up_of(motion: Bvh, mapping: JointMapping) -> Up:
    """Return the axis along which the head is higher above the feet, on average."""
    places = mapping.positions(motion.positions(), motion.skeleton)
    feet = [NAMES.index(name) for name in ("LeftFoot", "RightFoot")]
    height = (places[:, NAMES.index("Head")] - places[:, feet].mean(axis=1)).mean(axis=0)
    return "z" if height[2] > height[1] else "y"


def with_y_up(motion: Bvh, up: Up) -> Bvh:
    """Return a clip turned so that y is up."""
    one_of("up", up, get_args(Up))
    return _turned(motion, up, back=False)


def with_own_up(motion: Bvh, up: Up) -> Bvh:
    """Undo `with_y_up`."""
    return _turned(motion, up, back=True)


def _turned(motion: Bvh, up: Up, *, back: bool) -> Bvh:
    if up == "y":
        return motion
    turn = _TO_Y[up].T if back else _TO_Y[up]
    root = motion.skeleton.parents.index(-1)
    rotations, translations = motion.rotations.copy(), motion.translations.copy()
    rotations[:, root] = turn @ rotations[:, root]
    translations[:, root] = translations[:, root] @ turn.T
    return replace(motion, rotations=rotations, translations=translations)
