"""What is measured of motion: error, lengths of bones, feet that slide, and NPSS."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

import npss
from npss.skeleton import Skeleton
from npss.validation import Array, Float64

Mask = npt.NDArray[np.bool_]

#: Where a foot counts as being on the ground: less than this many heights above the lowest place of any in that motion.
NEAR = 0.03
FEET = ("LeftFoot", "LeftToeBase", "RightFoot", "RightToeBase")


def joint_error(gt: Array, pred: Array, mask: Mask) -> float:
    """Compute how far joints are from where they ought to be.

    Parameters
    ----------
    gt, pred : (n, T, J, 3) ndarray
        Positions, in heights.
    mask : (n, T) ndarray of bool
        Which frames count.

    Returns
    -------
    float
        The mean distance over joints and frames, in heights.

    Raises
    ------
    ValueError
        If the shapes do not fit, or no frame counts.

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
    r"""Compute how far the lengths of bones are from those of the skeleton: 0 for whatever a body can do.

    Parameters
    ----------
    positions : (n, T, J, 3) ndarray
        In the unit of the skeleton.
    skeleton : npss.skeleton.Skeleton
        Whose bones they are.
    mask : (n, T) ndarray of bool
        Which frames count.

    Returns
    -------
    float
        The mean over bones and frames of \|length - skeleton's\| / skeleton's.

    Raises
    ------
    ValueError
        If the shapes do not fit, or no frame counts.

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
    """Compute how fast feet slide that are on the ground, where they should stand.

    A foot (`FEET`: ankles and balls of the feet) is on the ground while it is less than `NEAR` heights above the lowest
    place that any of them has in that motion.

    Parameters
    ----------
    positions : (n, T, J, 3) ndarray
        In heights, y up, path in the world included.
    skeleton : npss.skeleton.Skeleton
        Whose joints they are.
    mask : (n, T) ndarray of bool
        Which frames count.
    fps : float
        Frames per second.

    Returns
    -------
    float
        The mean horizontal speed of feet while they are on the ground, in heights per second. NaN if none ever is,
        from one frame to the next.

    Raises
    ------
    ValueError
        If the skeleton has no such joints, the shapes do not fit, or no frame counts.
    """
    if absent := set(FEET) - set(skeleton.names):
        raise ValueError(f"skeleton: it lacks {', '.join(sorted(absent))}")
    _counted(positions, mask)
    feet = positions[:, :, [skeleton.names.index(foot) for foot in FEET]]  # (n, T, feet, 3)
    height = np.where(mask[:, :, np.newaxis], feet[..., 1], np.inf)
    grounded = height - height.min(axis=(1, 2), keepdims=True) < NEAR
    speed = fps * np.linalg.norm(np.diff(feet[..., ::2], axis=1), axis=-1)
    both = grounded[:, 1:] & grounded[:, :-1]
    return float(speed[both].mean()) if both.any() else float("nan")


def power_error(gt: Array, pred: Array, mask: Mask) -> float:
    """Score windows by NPSS, convention ``paper``, on positions: sequences of windows, features of coordinates.

    Parameters
    ----------
    gt, pred : (n, T, J, 3) ndarray
        Positions in the character's frame.
    mask : (n, T) ndarray of bool
        Windows of which a frame does not count are left out: a spectrum needs all of them.

    Returns
    -------
    float
        NPSS, which `power_signature` states; NaN if no window is whole.
    """
    whole = mask.all(axis=1)
    if not whole.any():
        return float("nan")
    sequences: list[Float64] = [each[whole].reshape(int(whole.sum()), each.shape[1], -1) for each in (gt, pred)]
    return npss.score(*sequences)


def _counted(positions: Array, mask: Mask) -> Array:
    """Return the frames that count, ``(frames, J, 3)``."""
    if positions.ndim != 4 or mask.shape != positions.shape[:2]:
        raise ValueError(f"mask: its shape {mask.shape} does not fit positions of shape {positions.shape}")
    if not mask.any():
        raise ValueError("mask: no frame counts")
    chosen: Array = positions[mask]
    return chosen
