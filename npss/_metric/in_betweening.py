"""L2Q and L2P: the distances of global quaternions and of global positions that in-betweening reports beside NPSS."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Literal, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.sequences import Lengths, read_motions
from npss.rotations._continuous import continuous
from npss.validation import Array, Float64, check_finite, one_of, real_array

#: The signs of quaternions that are compared.
Hemisphere = Literal["anchored", "nearest", "given"]
#: The norm of the differences.
Norm = Literal["pose", "joint", "rmse"]

_UNIT = 1e-2  # the largest distance of a quaternion's length from 1: bfloat16 rounds each component to 4e-3 of it


class Joints(NamedTuple):
    """Sequences of one length with their joints, in float64 and finite."""

    rows: Sequence[int]  # their places in the set
    gt: Float64  # (n, T, J, C)
    pred: Float64


def read_joints(gt: npt.ArrayLike, pred: npt.ArrayLike, channels: int, *, lengths: Lengths = None) -> list[Joints]:
    """Read ground truth and prediction of joints with `channels` numbers each, in groups of equal length."""
    what = f"(N, T, J, {channels}) or (N, T, {channels} J)"
    motions = []
    for name, values in (("gt", gt), ("pred", pred)):
        shape = tuple(getattr(values, "shape", ()))
        if len(shape) == 3 and shape[-1] == channels:
            raise ValueError(
                f"{name}: expected shape {what}, got {shape}; pass one sequence as x[None], one joint as x[:, :, None]"
            )
        positions_of_three = channels == 3 and len(shape) == 4 and shape[-2:] == (3, 3)  # and not matrices
        motions.append(real_array(name, values).reshape(*shape[:2], 9) if positions_of_three else values)
    groups = []
    for rows, truth, prediction in read_motions(*motions, lengths=lengths, spectra=False).groups:
        both = []
        for name, motion in (("gt", truth), ("pred", prediction)):
            if motion.ndim != 3 or motion.shape[-1] % channels:
                raise ValueError(f"{name}: expected shape {what}, got {motion.shape}, flattened joint by joint")
            check_finite(name, motion)
            both.append(motion.astype(np.float64, copy=False).reshape(*motion.shape[:2], -1, channels))
        groups.append(Joints(rows, *both))
    return groups


def read_quaternions(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    past: npt.ArrayLike | None = None,
    hemisphere: Hemisphere = "anchored",
    lengths: Lengths = None,
) -> list[Joints]:
    """Read global quaternions and choose their signs, as `l2q` describes it."""
    groups = read_joints(gt, pred, 4, lengths=lengths)
    one_of("hemisphere", hemisphere, get_args(Hemisphere))
    for group in groups:
        _require_unit("gt", group.gt)
        _require_unit("pred", group.pred)
    if hemisphere == "given":
        if past is not None:
            raise ValueError("past: only for hemisphere='anchored' or 'nearest'; leave it out")
        return groups
    start = None if past is None else _read_past(past, sum(len(rows) for rows, *_ in groups), groups[0].gt.shape[2])
    return [_anchored(group, start, nearest=hemisphere == "nearest") for group in groups]


def _read_past(past: npt.ArrayLike, n: int, n_joints: int) -> Float64:
    array = real_array("past", past)
    if array.shape not in ((n, n_joints, 4), (n, 4 * n_joints)):
        expected = f"({n}, {n_joints}, 4) or ({n}, {4 * n_joints})"
        raise ValueError(f"past: expected the quaternions of the last past frame, {expected}, got shape {array.shape}")
    check_finite("past", array)
    start: Float64 = array.astype(np.float64).reshape(n, n_joints, 4)
    _require_unit("past", start)
    return start


def _anchored(group: Joints, start: Float64 | None, *, nearest: bool) -> Joints:
    """Make both motions continuous in time, from `start` or the first frame of the ground truth."""
    rows, truth, prediction = group
    first: Array = truth[:, 0] if start is None else start[list(rows)]
    truth, prediction = continuous(truth, axis=1, start=first), continuous(prediction, axis=1, start=first)
    if nearest:
        away = (truth * prediction).sum(axis=-1, keepdims=True) < 0
        prediction = np.where(away, -prediction, prediction)
    return Joints(rows, truth, prediction)


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
    lengths: Lengths = None,
) -> float:
    """Return the L2Q: the distance of global quaternions, averaged over frames and windows.

    Parameters
    ----------
    gt, pred : (N, T, J, 4) or (N, T, 4 J) array_like, or list of sequences
        Unit quaternions of the *global* rotations of J joints, of the transition's frames only. Their order (w first or
        last) does not matter.
    past : (N, J, 4) or (N, 4 J) array_like, optional
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
    lengths : (N,) array_like of int, optional
        The number of frames of each sequence that count, as for `npss.score`. Lists of sequences may differ in length.

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
    groups = read_quaternions(gt, pred, past=past, hemisphere=hemisphere, lengths=lengths)
    return float(np.concatenate([norms(group.gt - group.pred, norm) for group in groups]).mean())


def flat_l2q(gt: Float64, pred: Float64) -> Float64:
    """Return the L2Q of each sequence of quaternions flattened joint by joint, ``(N, T, 4 J)``."""
    if gt.shape[-1] % 4:
        raise ValueError(f"gt: expected quaternions, four features for each joint, got {gt.shape[-1]} features")
    ((_, truth, prediction),) = read_quaternions(gt, pred)
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
