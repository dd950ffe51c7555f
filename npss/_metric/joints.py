"""Read motion with an axis of joints."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from npss.validation import Array, check_finite, each, is_integer, motion_with_joints


def joint_array(name: str, values: npt.ArrayLike, core: tuple[int, ...]) -> Array:
    """Read motion as ``(N, T, J, *core)``: N sequences of T frames of J joints.

    Parameters
    ----------
    name : str
        Name of the argument, for errors.
    values : array_like
        ``(N, T, J, *core)``, or flattened joint by joint, ``(N, T, D)``, or a single sequence ``(T, D)``.
    core : tuple of int
        The shape of one joint: (3,) for positions, (3, 3) for matrices.

    Raises
    ------
    TypeError
        If it does not hold real numbers.
    ValueError
        If the shape is wrong or ambiguous, or a value is not finite.
    """
    return _with_joints(name, _read(name, values, core), core)


def joint_pair(
    gt: npt.ArrayLike, pred: npt.ArrayLike, core: tuple[int, ...], joints: Sequence[int] | None
) -> tuple[Array, Array]:
    """Read ground truth and prediction as ``(N, T, J, *core)``, of some joints.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid, or the shapes differ.
    """
    first, second = _read("gt", gt, core), _read("pred", pred, core)
    if first.shape != second.shape:
        raise ValueError(f"pred: its shape {second.shape} differs from that of gt, {first.shape}; nothing is broadcast")
    truth, prediction = _with_joints("gt", first, core), _with_joints("pred", second, core)
    if joints is None:
        return truth, prediction
    chosen = joint_indices(joints, truth.shape[2])
    return truth[:, :, chosen], prediction[:, :, chosen]


def joint_indices(joints: Sequence[int], n_joints: int, name: str = "joints") -> npt.NDArray[np.intp]:
    """Read indices of joints.

    Raises
    ------
    TypeError, ValueError
        If it is not a sequence of different indices, or is empty.
    """
    chosen = each(name, joints, "indices of joints")
    for joint in chosen:
        if not is_integer(joint):
            raise TypeError(f"{name}: expected indices of joints, got {joint!r}")
        if not 0 <= joint < n_joints:
            raise ValueError(f"{name}: expected indices from 0 to {n_joints - 1}, got {joint}")
    if not chosen or len(set(chosen)) < len(chosen):
        raise ValueError(f"{name}: expected different indices of joints, at least one, got {chosen}")
    return np.array(chosen, np.intp)


def _read(name: str, values: npt.ArrayLike, core: tuple[int, ...]) -> Array:
    array = motion_with_joints(name, values, "matrix" if core == (3, 3) else None)
    check_finite(name, array)
    return array


def _with_joints(name: str, array: Array, core: tuple[int, ...]) -> Array:
    """View motion as ``(N, T, J, *core)``."""
    size = math.prod(core)
    if array.ndim > 3 and array.shape[3:] == core:
        return array
    if array.ndim <= 3 and array.shape[-1] % size == 0:
        return array.reshape((*(array.shape[:2] if array.ndim == 3 else (1, len(array))), -1, *core))
    shapes = f"(N, T, J, {', '.join(map(str, core))}), (N, T, {size} J) or (T, {size} J)"
    raise ValueError(f"{name}: expected {shapes}, got {array.shape}")
