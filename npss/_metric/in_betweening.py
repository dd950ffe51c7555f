"""L2Q and L2P: the distances of global quaternions and of global positions that in-betweening reports beside NPSS."""

from __future__ import annotations

from typing import Literal, get_args

import numpy as np
import numpy.typing as npt

from npss.rotations._continuous import continuous
from npss.validation import Array, Float64, check_finite, one_of, real_array

#: The signs of quaternions that are compared.
Hemisphere = Literal["anchored", "nearest", "given"]
#: The norm of the differences.
Norm = Literal["pose", "joint", "rmse"]

_UNIT = 1e-2  # the largest distance of a quaternion's length from 1: bfloat16 rounds each component to 4e-3 of it


def joint_pair(gt: npt.ArrayLike, pred: npt.ArrayLike, channels: int) -> tuple[Float64, Float64]:
    """Read ground truth and prediction as ``(N, T, J, channels)``, finite, in float64, of the same shape."""
    pair = []
    for name, values in (("gt", gt), ("pred", pred)):
        array = real_array(name, values)
        if array.ndim != 4 or array.shape[-1] != channels or 0 in array.shape:
            what = "sequences, frames, joints, " + ("w x y z" if channels == 4 else "x y z")
            raise ValueError(f"{name}: expected shape (N, T, J, {channels}) = ({what}), got {array.shape}")
        check_finite(name, array)
        pair.append(array.astype(np.float64, copy=False))
    first, second = pair
    if first.shape != second.shape:
        raise ValueError(f"pred: its shape {second.shape} differs from that of gt, {first.shape}; nothing is broadcast")
    return first, second


def quaternion_pair(
    gt: npt.ArrayLike, pred: npt.ArrayLike, *, past: npt.ArrayLike | None = None, hemisphere: Hemisphere = "anchored"
) -> tuple[Float64, Float64]:
    """Read global quaternions ``(N, T, J, 4)`` and choose their signs, as `l2q` describes it."""
    truth, prediction = joint_pair(gt, pred, 4)
    one_of("hemisphere", hemisphere, get_args(Hemisphere))
    for name, quaternions in (("gt", truth), ("pred", prediction)):
        _require_unit(name, quaternions)
    if hemisphere == "given":
        if past is not None:
            raise ValueError("past: only for hemisphere='anchored' or 'nearest'; leave it out")
        return truth, prediction
    start: Array = truth[:, 0]
    if past is not None:
        start = real_array("past", past)
        if start.shape != truth[:, 0].shape:
            expected = f"the last past frame, {truth[:, 0].shape}"
            raise ValueError(f"past: expected the quaternions of {expected}, got shape {start.shape}")
        check_finite("past", start)
        _require_unit("past", start)
    truth, prediction = continuous(truth, axis=1, start=start), continuous(prediction, axis=1, start=start)
    if hemisphere == "nearest":
        away = (truth * prediction).sum(axis=-1, keepdims=True) < 0
        prediction = np.where(away, -prediction, prediction)
    return truth, prediction


def norms(difference: Float64, norm: Norm) -> Float64:
    """Return the norm of differences ``(N, T, J, C)`` for each sequence, ``(N,)``."""
    one_of("norm", norm, get_args(Norm))
    squares = np.square(difference).sum(axis=-1)  # (N, T, J)
    if norm == "rmse":
        roots: Float64 = np.sqrt(squares.mean(axis=(1, 2)) / difference.shape[-1])
        return roots
    lengths = np.sqrt(squares.sum(axis=-1)) if norm == "pose" else np.sqrt(squares).mean(axis=-1)
    means: Float64 = lengths.mean(axis=1)
    return means


def l2q(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    past: npt.ArrayLike | None = None,
    hemisphere: Hemisphere = "anchored",
    norm: Norm = "pose",
) -> float:
    """Return the L2Q: the distance of global quaternions, averaged over windows and frames.

    Parameters
    ----------
    gt, pred : (N, T, J, 4) array_like
        Unit quaternions of the *global* rotations of J joints, of the transition's frames only. Their order (w first or
        last) does not matter.
    past : (N, J, 4) array_like, optional
        The global quaternions of the last past frame, in whose hemisphere both begin (default: that of the ground
        truth's first frame).
    hemisphere : {'anchored', 'nearest', 'given'}, optional
        q and -q are the same rotation, but not the same four numbers. ``'anchored'``: both are made continuous in time
        from `past`, so that signs agree where the rotations do. ``'nearest'``: for every joint and frame, the sign of
        the prediction that is nearer to the ground truth, the "minimum over the sign" of some codes. ``'given'``: the
        numbers as they are; 5 of 22 joints in the other hemisphere cost 4.472 for a perfect prediction.
    norm : {'pose', 'joint', 'rmse'}, optional
        ``'pose'``: the Euclidean norm over all joints and components of a frame, as published. ``'joint'``: the norm of
        each joint, averaged over joints. ``'rmse'``: the root of the mean square over frames, joints and components of
        a window. Each is then averaged over windows.

    Returns
    -------
    float
        The number; 0 for equal rotations. At most 2 sqrt(J) with ``norm='pose'``.

    Raises
    ------
    TypeError
        If an array does not hold real numbers, or a choice is not text.
    ValueError
        If a shape is wrong, shapes differ, a value is not finite, a quaternion is not of unit length (within 0.01), a
        choice is unknown, or `past` is given with signs as they are.

    See Also
    --------
    npss.inbetweening.measure : L2Q, L2P and NPSS in one record with signatures.

    References
    ----------
    F. Harvey et al., "Robust Motion In-betweening", ACM Transactions on Graphics 39 (4), 2020.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.inbetweening import l2q
    >>> gt = np.tile([1.0, 0, 0, 0], (1, 5, 22, 1))
    >>> pred = gt.copy()
    >>> pred[:, :, :5] *= -1  # the same rotations
    >>> l2q(gt, pred), round(l2q(gt, pred, hemisphere="given"), 3)
    (0.0, 4.472)
    """
    truth, prediction = quaternion_pair(gt, pred, past=past, hemisphere=hemisphere)
    return float(norms(truth - prediction, norm).mean())


def flat_l2q(gt: Float64, pred: Float64) -> Float64:
    """Return the L2Q of each sequence of quaternions flattened joint by joint, ``(N, T, 4 J)``."""
    if gt.shape[-1] % 4:
        raise ValueError(f"gt: expected quaternions, four features for each joint, got {gt.shape[-1]} features")
    shape = (*gt.shape[:2], -1, 4)
    truth, prediction = quaternion_pair(gt.reshape(shape), pred.reshape(shape))
    return norms(truth - prediction, "pose")


def flat_l2p(gt: Float64, pred: Float64) -> Float64:
    """Return the L2P of each sequence of positions as they are, ``(N, T, 3 J)``."""
    return norms((gt - pred)[..., np.newaxis], "pose")


def _require_unit(name: str, quaternions: Array) -> None:
    lengths = np.sqrt(np.square(quaternions.astype(np.float64, copy=False)).sum(axis=-1))
    far = np.abs(lengths - 1) > _UNIT
    if far.any():
        index = tuple(int(i) for i in np.unravel_index(int(np.argmax(far)), far.shape))
        raise ValueError(f"{name}: expected unit quaternions, got one of length {lengths[index]:.4g} at index {index}")
