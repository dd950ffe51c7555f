"""Errors of positions: of joints (MPJPE, PA-MPJPE), of the root, and of its path on the floor."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.joints import joint_array, joint_indices, joint_pair
from npss._metric.times import Average, check_average, errors_at, frames_at
from npss.validation import Array, BeyondFloat64Error, Float64, is_integer, one_of

#: How a predicted pose is moved before it is compared.
Align = Literal["root", "procrustes"]
#: The axis that points up.
Up = Literal["x", "y", "z"]
_FRAMES = 4096  # frames aligned at once


def position_error(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    fps: float = 25,
    at_ms: Sequence[float] = (80, 160, 320, 400, 560, 1000),
    average: Average = "at",
    align: Align | None = None,
    root: int = 0,
    joints: Sequence[int] | None = None,
) -> dict[float, float]:
    """Return the mean distance of predicted from true joints at given times: MPJPE, and PA-MPJPE.

    Parameters
    ----------
    gt, pred : (N, T, J, 3), (N, T, 3 J) or (T, 3 J) array_like
        Positions of joints, in any unit. Pass three joints as ``(N, T, 9)``.
    fps : float, optional
        Frames per second.
    at_ms : sequence of float, optional
        Times in milliseconds after the last seed frame: at 25 frames per second, 80 ms is the second predicted frame.
    average : {'at', 'up-to', 'sum'}, optional
        The error at each time, or the mean or sum of the errors of all frames up to it. Published tables use the first
        two, and rank methods differently by them.
    align : {None, 'root', 'procrustes'}, optional
        Compare positions as they are; relative to the root; or after the similarity transform (rotation without
        reflection, translation and scale) that brings each predicted frame nearest to the true one by least squares.
    root : int, optional
        The index of the root, for ``align="root"``.
    joints : sequence of int, optional
        Indices of the joints to average and, for ``align="procrustes"``, to align (default: all).

    Returns
    -------
    dict of float to float
        The error at each time, in the unit of the positions; whole numbers of milliseconds are ints.

    Raises
    ------
    TypeError
        If an argument has the wrong type.
    ValueError
        If a shape is wrong, ambiguous or differs, a value is not finite, an option is invalid, a time is not that of a
        frame (the message names the nearest), or fewer than three joints are to be aligned by 'procrustes', which
        leaves no error of two.

    See Also
    --------
    position_error_curve : the error of every frame.
    root_error : the error of the root alone.

    Notes
    -----
    Sign it with ``npss.signature(None, metric="position_error", average=..., extra={"align": ...})``.

    References
    ----------
    C. Ionescu et al., "Human3.6M", TPAMI 2014 (MPJPE). The alignment: S. Umeyama, "Least-Squares Estimation of
    Transformation Parameters Between Two Point Patterns", TPAMI 1991, equations 39 to 43.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt = np.random.default_rng(0).normal(size=(2, 25, 17, 3))
    >>> {t: round(e, 6) for t, e in npss.position_error(gt, gt + [3, 4, 0], at_ms=(80, 1000)).items()}
    {80: 5.0, 1000: 5.0}
    >>> round(npss.position_error(gt, 2 * gt + [3, 4, 0], at_ms=[80], align="procrustes")[80], 6)
    0.0
    """
    check_average(average)
    curve = position_error_curve(gt, pred, align=align, root=root, joints=joints)
    return errors_at(curve, frames_at(at_ms, fps, len(curve)), average)


def position_error_curve(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    align: Align | None = None,
    root: int = 0,
    joints: Sequence[int] | None = None,
) -> Float64:
    """Return the mean distance of predicted from true joints in every frame.

    Parameters
    ----------
    gt, pred, align, root, joints
        As for `position_error`.

    Returns
    -------
    (T,) ndarray of float64
        The average over joints and sequences. Entry k is (k + 1) / fps seconds after the last seed frame.

    Raises
    ------
    TypeError, ValueError
        As for `position_error`.

    References
    ----------
    As for `position_error`.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt = np.zeros((1, 3, 2, 3))
    >>> npss.position_error_curve(gt, gt + np.array([1.0, 2.0, 3.0])[:, np.newaxis, np.newaxis] * [1, 0, 0])
    array([1., 2., 3.])
    """
    curve: Float64 = sequence_position_errors(gt, pred, align=align, root=root, joints=joints).mean(axis=0)
    return curve


def sequence_position_errors(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    align: Align | None = None,
    root: int = 0,
    joints: Sequence[int] | None = None,
) -> Float64:
    """Return the error of every frame of every sequence, ``(N, T)``; `position_error_curve` averages it."""
    if align is not None:
        one_of("align", align, get_args(Align))
    truth, prediction = joint_pair(gt, pred, (3,), joints)
    if align == "procrustes" and truth.shape[2] < 3:
        raise ValueError(f"joints: expected at least 3 to align, got {truth.shape[2]}")
    origins = [_root(name, motion, root) for name, motion in (("gt", gt), ("pred", pred))] if align == "root" else None
    errors = np.empty(truth.shape[:2])
    height = max(1, _FRAMES // truth.shape[1])
    for top in range(0, len(truth), height):
        some = slice(top, top + height)
        first, second = truth[some].astype(np.float64), prediction[some].astype(np.float64)
        with np.errstate(all="ignore"):
            if origins is not None:
                first -= origins[0][some]
                second -= origins[1][some]
            elif align == "procrustes":
                first, second = _aligned(first, second)
            errors[some] = _distances(first, second).mean(axis=-1)
    if not np.isfinite(errors).all():
        raise BeyondFloat64Error("pred", "its distance from gt is beyond float64")
    return errors


def root_error(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    fps: float = 25,
    at_ms: Sequence[float] = (80, 160, 320, 400, 560, 1000),
    average: Average = "at",
    root: int = 0,
) -> dict[float, float]:
    """Return the distance of the predicted from the true root at given times.

    Parameters
    ----------
    gt, pred : (N, T, J, 3), (N, T, 3 J) or (T, 3 J) array_like
        Positions of joints in the world, in any unit; a root alone is ``(N, T, 3)``.
    fps, at_ms, average
        As for `position_error`.
    root : int, optional
        The index of the root.

    Returns
    -------
    dict of float to float
        The error at each time, in the unit of the positions.

    Raises
    ------
    TypeError, ValueError
        As for `position_error`; also if the true root never moves, as where poses were taken without their path.

    See Also
    --------
    trajectory_error : the same on the floor.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> path = np.linspace(0, 1, 25)[:, np.newaxis] * [3.0, 4.0, 12.0]
    >>> npss.root_error(path, 0 * path, at_ms=[1000])
    {1000: 13.0}
    """
    check_average(average)
    curve = sequence_root_errors(gt, pred, root=root).mean(axis=0)
    return errors_at(curve, frames_at(at_ms, fps, len(curve)), average)


def trajectory_error(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    up: Up,
    fps: float = 25,
    at_ms: Sequence[float] = (80, 160, 320, 400, 560, 1000),
    average: Average = "at",
    root: int = 0,
) -> dict[float, float]:
    """Return the distance on the floor of the predicted from the true root at given times.

    Parameters
    ----------
    gt, pred, fps, at_ms, average, root
        As for `root_error`.
    up : {'x', 'y', 'z'}
        The axis that points up, which is left out.

    Returns
    -------
    dict of float to float
        The error at each time, in the unit of the positions.

    Raises
    ------
    TypeError, ValueError
        As for `root_error`; also if `up` is not an axis.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> path = np.linspace(0, 1, 25)[:, np.newaxis] * [3.0, 12.0, 4.0]
    >>> npss.trajectory_error(path, 0 * path, up="y", at_ms=[1000])
    {1000: 5.0}
    """
    check_average(average)
    curve = sequence_root_errors(gt, pred, root=root, up=up).mean(axis=0)
    return errors_at(curve, frames_at(at_ms, fps, len(curve)), average)


def sequence_root_errors(gt: npt.ArrayLike, pred: npt.ArrayLike, *, root: int = 0, up: Up | None = None) -> Float64:
    """Return the error of the root in every frame of every sequence, ``(N, T)``; on the floor if `up` is given."""
    joint_pair(gt, pred, (3,), None)  # the shapes are equal
    first, second = _root("gt", gt, root)[:, :, 0], _root("pred", pred, root)[:, :, 0]
    if up is not None:
        one_of("up", up, get_args(Up))
        floor = [axis for axis, name in enumerate("xyz") if name != up]
        first, second = first[..., floor], second[..., floor]
    if not (first != first[:, :1]).any():
        raise ValueError("gt: the root never moves, so there is no path to compare")
    with np.errstate(over="ignore"):
        errors = _distances(first, second)
    if not np.isfinite(errors).all():
        raise BeyondFloat64Error("pred", "the distance of its root from that of gt is beyond float64")
    return errors


def _root(name: str, motion: npt.ArrayLike, root: int) -> Float64:
    """Return the positions of the root, ``(N, T, 1, 3)``."""
    array = joint_array(name, motion, (3,))
    if not is_integer(root):
        raise TypeError(f"root: expected the index of a joint, got {root!r}")
    joint = joint_indices([root], array.shape[2], "root")
    return array[:, :, joint].astype(np.float64)


def _distances(first: Array, second: Array) -> Float64:
    """Return the norms of differences over the last axis; no square is out of range."""
    difference = np.abs(first - second)
    distance: Float64 = difference[..., 0]
    for axis in range(1, difference.shape[-1]):
        distance = np.hypot(distance, difference[..., axis])
    return distance


def _aligned(first: Float64, second: Float64) -> tuple[Float64, Float64]:
    """Centre both, and turn and scale the second, ``(n, T, J, 3)``, to the first."""
    first = first - first.mean(axis=-2, keepdims=True)
    second = second - second.mean(axis=-2, keepdims=True)
    # By the size of each pose, so that no square is out of range.
    size, other = (np.abs(pose).max(axis=(-2, -1), keepdims=True) for pose in (first, second))
    target = np.divide(first, size, where=size > 0, out=np.zeros_like(first))
    given = np.divide(second, other, where=other > 0, out=np.zeros_like(second))
    left, singular, right = np.linalg.svd(np.swapaxes(given, -1, -2) @ target)
    proper = np.sign(np.linalg.det(left) * np.linalg.det(right))  # -1 where the best orthogonal matrix is a reflection
    left[..., -1] *= proper[..., np.newaxis]
    singular[..., -1] *= proper
    squares = np.square(given).sum(axis=(-2, -1))
    # A pose in one point has no scale, and stays in the middle.
    scale = np.divide(singular.sum(axis=-1), squares, where=squares > 0, out=np.zeros_like(squares))
    return first, (scale[..., np.newaxis, np.newaxis] * size) * (given @ (left @ right))
