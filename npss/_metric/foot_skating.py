"""Foot skating: how fast feet move while they are near the floor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.joints import joint_array, joint_indices
from npss.validation import BeyondFloat64Error, is_real, one_of, positive_number

#: The axis that points up.
Up = Literal["x", "y", "z"]


def height_weighted_foot_skating(
    positions: npt.ArrayLike, *, feet: Sequence[int], up: Up, height: float, fps: float, floor: float = 0.0
) -> float:
    """Return the mean horizontal speed of feet, weighted by their nearness to the floor.

    A foot at height h above the floor that moves horizontally at speed v since the frame before skates by ::

        v * (2 - 2 ** min(max(h / height, 0), 1))

    the whole speed on or below the floor, nothing from `height` up. The mean is over sequences, frames and feet. Every
    code has its own definition of foot skating; this name stands for this one.

    Parameters
    ----------
    positions : (N, T, J, 3), (N, T, 3 J) or (T, 3 J) array_like
        Positions of joints in the world, in any unit.
    feet : sequence of int
        Indices of the joints that touch the floor.
    up : {'x', 'y', 'z'}
        The axis that points up.
    height : float
        Where a foot no longer skates, in the unit of the positions; the paper's is 2.5 cm.
    fps : float
        Frames per second.
    floor : float, optional
        The height of the floor.

    Returns
    -------
    float
        In units of the positions per second. Compare it with that of the ground truth, which is not 0.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If the shape is wrong or ambiguous, a value is not finite, there is only one frame, or an option is invalid.

    Notes
    -----
    Sign it with ``npss.signature(None, metric="height_weighted_foot_skating", fps=..., extra={"height": ...,
    "floor": ..., "feet": ...})``.

    References
    ----------
    H. Zhang, S. Starke, T. Komura, J. Saito, "Mode-Adaptive Neural Networks for Quadruped Motion Control", SIGGRAPH
    2018, section on foot skating artefacts.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> foot = np.arange(5.0)[:, np.newaxis] * [0.01, 0, 0]  # 1 cm per frame
    >>> skating = {"feet": [0], "up": "y", "height": 0.025, "fps": 30}
    >>> round(npss.height_weighted_foot_skating(foot, **skating), 6)
    0.3
    >>> npss.height_weighted_foot_skating(foot + [0, 0.025, 0], **skating)
    0.0
    """
    array = joint_array("positions", positions, (3,))
    one_of("up", up, get_args(Up))
    limit, rate = positive_number("height", height), positive_number("fps", fps)
    if not is_real(floor):
        raise TypeError(f"floor: expected a number, got {floor!r}")
    if not np.isfinite(floor):
        raise ValueError(f"floor: expected a finite number, got {floor}")
    if array.shape[1] < 2:
        raise ValueError(f"positions: expected at least two frames, got shape {array.shape}")
    paths = array[:, :, joint_indices(feet, array.shape[2], "feet")].astype(np.float64)
    vertical = "xyz".index(up)
    with np.errstate(over="ignore"):
        steps = np.diff(np.delete(paths, vertical, axis=-1), axis=1)
        speed = np.hypot(steps[..., 0], steps[..., 1]) * rate
        nearness = 2 - np.exp2(np.clip((paths[:, 1:, :, vertical] - floor) / limit, 0, 1))
        skating = float((speed * nearness).mean())
    if not np.isfinite(skating):
        raise BeyondFloat64Error("positions", "their speed is beyond float64")
    return skating
