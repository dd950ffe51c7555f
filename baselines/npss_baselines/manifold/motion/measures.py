"""Measures of motion: joint error, bone error, foot speed, and NPSS."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import npss
from npss.skeleton import Skeleton
from npss.validation import Array, Float64

Mask = npt.NDArray[np.bool_]

#: A foot is on the ground while it is lower than this, in body heights above the motion's lowest foot position.
NEAR = 0.03
FEET = ("LeftFoot", "LeftToeBase", "RightFoot", "RightToeBase")


def joint_error(gt: Array, pred: Array, mask: Mask) -> float:
    """Compute the joint error: the mean distance of joints from the ground truth.

    Parameters
    ----------
    gt, pred : (n, T, J, 3) ndarray
        Positions in body heights.
    mask : (n, T) ndarray of bool
        Frames that count.

    Returns
    -------
    float
        The distance averaged over joints and frames, in body heights.

    Raises
    ------
    ValueError
        If the shapes do not match, or no frame counts.

    Examples
    --------
    >>> import numpy as np
    >>> joint_error(np.zeros((1, 2, 1, 3)), np.array([[[[3, 4, 0]], [[9, 9, 9]]]]), np.array([[True, False]]))
    5.0
    """
    if gt.shape != pred.shape:
        raise ValueError(f"pred: its shape {pred.shape} differs from that of gt, {gt.shape}")
    return float(np.linalg.norm(_counted(pred, mask) - _counted(gt, mask), axis=-1).mean())


def bone_error(positions: Array, skeleton: Skeleton, mask: Mask) -> float:
    r"""Compute the relative error of bone lengths: 0 for every possible pose.

    Parameters
    ----------
    positions : (n, T, J, 3) ndarray
        Positions in the unit of the skeleton.
    skeleton : npss.skeleton.Skeleton
        The reference.
    mask : (n, T) ndarray of bool
        Frames that count.

    Returns
    -------
    float
        \|length - reference\| / reference, averaged over bones and frames.

    Raises
    ------
    ValueError
        If the shapes do not match, or no frame counts.

    Examples
    --------
    >>> import numpy as np
    >>> arm = Skeleton(["shoulder", "hand"], [-1, 0], [[0, 0, 0], [2, 0, 0]])
    >>> bone_error(np.array([[[[0, 0, 0], [0, 3, 0]]]]), arm, np.ones((1, 1), bool))
    0.5
    """
    child, parent = np.array(skeleton.bones).T
    frames = _counted(positions, mask)
    lengths = np.linalg.norm(frames[:, child] - frames[:, parent], axis=-1)  # (frames, bones)
    right = np.linalg.norm(skeleton.offsets[child], axis=-1)
    return float((np.abs(lengths - right) / right).mean())


def foot_speed(positions: Array, skeleton: Skeleton, mask: Mask, *, fps: float) -> float:
    """Compute the horizontal speed of feet on the ground, where they should stand still.

    A foot (`FEET`: ankles and balls of the feet) is on the ground while it is less than `NEAR` body heights above the
    lowest position of any foot in the motion.

    Parameters
    ----------
    positions : (n, T, J, 3) ndarray
        World positions in body heights, y up.
    skeleton : npss.skeleton.Skeleton
        The skeleton of the positions.
    mask : (n, T) ndarray of bool
        Frames that count.
    fps : float
        Frames per second.

    Returns
    -------
    float
        The average speed, in body heights per second. NaN if no foot is on the ground in two successive frames.

    Raises
    ------
    ValueError
        If the skeleton lacks these joints, the shapes do not fit, or no frame counts.
    """
    speed, stays = foot_speeds(positions, skeleton, mask, fps=fps)
    return float(speed[stays].mean()) if stays.any() else float("nan")


def foot_speeds(positions: Array, skeleton: Skeleton, mask: Mask, *, fps: float) -> tuple[Array, Mask]:
    """Return the horizontal speed ``(n, T - 1, feet)`` of each foot, and where it counts in `foot_speed`."""
    if absent := set(FEET) - set(skeleton.names):
        raise ValueError(f"skeleton: missing joints {', '.join(sorted(absent))}")
    _counted(positions, mask)
    feet = positions[:, :, [skeleton.names.index(foot) for foot in FEET]]  # (n, T, feet, 3)
    height = np.where(mask[:, :, np.newaxis], feet[..., 1], np.inf)
    grounded = height - height.min(axis=(1, 2), keepdims=True) < NEAR
    speed = fps * np.linalg.norm(np.diff(feet[..., ::2], axis=1), axis=-1)
    return speed, grounded[:, 1:] & grounded[:, :-1]


def power_error(gt: Array, pred: Array, mask: Mask) -> float:
    """Score positions by NPSS, convention ``paper``: each window is a sequence, each coordinate a feature.

    Parameters
    ----------
    gt, pred : (n, T, J, 3) ndarray
        Positions in the character's frame.
    mask : (n, T) ndarray of bool
        Frames that count. Windows with frames that do not are left out: a spectrum needs all frames.

    Returns
    -------
    float
        NPSS; NaN if no window is whole.
    """
    whole = mask.all(axis=1)
    if not whole.any():
        return float("nan")
    sequences: list[Float64] = [
        positions[whole].reshape(int(whole.sum()), positions.shape[1], -1) for positions in (gt, pred)
    ]
    return npss.score(*sequences)


def _counted(positions: Array, mask: Mask) -> Array:
    """Return the frames that count, ``(frames, J, 3)``."""
    if positions.ndim != 4 or mask.shape != positions.shape[:2]:
        raise ValueError(f"mask: its shape {mask.shape} does not fit positions of shape {positions.shape}")
    if not mask.any():
        raise ValueError("mask: no frame counts")
    chosen: Array = positions[mask]
    return chosen
