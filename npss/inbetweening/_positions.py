"""L2P, and the statistics by which it standardises positions."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Literal, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.in_betweening import Norm, norms, read_joints
from npss._metric.sequences import Lengths
from npss.files._arrays import MAX_SIZE, naming_file, read_arrays
from npss.files._formats import listed, open_arrays, suffixes
from npss.validation import Array, Float64, check_finite, one_of, real_array

#: The unit of positions that are not standardised.
Unit = Literal["m", "cm", "mm"]


class Statistics(NamedTuple):
    """The mean and the standard deviation of each coordinate over the training windows.

    ``np.savez("stats.npz", **stats._asdict())`` stores them for ``stats="stats.npz"``.

    Attributes
    ----------
    mean, std : (J, 3) ndarray of float64
        In the unit of positions.
    """

    mean: Array
    std: Array


def l2p(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    mean: npt.ArrayLike | None = None,
    std: npt.ArrayLike | None = None,
    stats: Statistics | str | os.PathLike[str] | None = None,
    unit: Unit | None = None,
    norm: Norm = "pose",
    lengths: Lengths = None,
) -> float:
    """Return the L2P: the distance of global positions, averaged over frames and windows.

    Published numbers standardise each coordinate by its mean and standard deviation over the training windows: give
    `mean` and `std`, or `stats`. Otherwise state the unit of the positions, which are left as they are.

    Parameters
    ----------
    gt, pred : (N, T, J, 3) or (N, T, 3 J) array_like, or list of sequences
        Global positions of J joints, in the frames of their windows, of the transition's frames only.
    mean, std : (J, 3), (3 J,) or (1, 3 J, 1) array_like, optional
        The statistics; flattened joint by joint. `std` is positive. (The mean cancels out of differences.)
    stats : Statistics or path, optional
        The statistics from `train_statistics`, or an ``.npz`` file with arrays ``mean`` and ``std``.
    unit : {'m', 'cm', 'mm'}, optional
        The unit of positions that are not standardised; nothing is converted.
    norm : {'pose', 'joint', 'rmse'}, optional
        ``'pose'``: the Euclidean norm over all joints and coordinates of a frame, as published. ``'joint'``: the
        distance of each joint, averaged over joints. ``'rmse'``: the root of the mean square over frames, joints and
        coordinates of a window. Each is then averaged over windows.
    lengths : (N,) array_like of int, optional
        The number of frames of each sequence that count, as for `npss.score`. Lists of sequences may differ in length.

    Returns
    -------
    float
        The number; 0 for equal positions. Without a unit if standardised, otherwise in `unit`.

    Raises
    ------
    TypeError
        If an array does not hold real numbers, or a choice is not text.
    ValueError
        If a shape is wrong, shapes differ, a value is not finite, a standard deviation is not positive, a file cannot
        be read, a choice is unknown, or not exactly one of the three is given: `mean` and `std`, `stats`, `unit`.

    See Also
    --------
    npss.inbetweening.measure : L2Q, L2P and NPSS in one record with signatures.

    References
    ----------
    F. Harvey et al., "Robust Motion In-betweening", ACM Transactions on Graphics 39 (4), 2020.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.inbetweening import l2p
    >>> gt = np.zeros((1, 5, 22, 3))
    >>> round(l2p(gt, gt + 1, mean=np.zeros((22, 3)), std=np.full((22, 3), 2)), 3)  # sqrt(66) / 2
    4.062
    >>> round(l2p(gt, gt + 0.01, unit="m", norm="joint"), 5)
    0.01732
    """
    groups = read_joints(gt, pred, 3, lengths=lengths)
    scale = read_scale(groups[0].gt.shape[2], mean=mean, std=std, stats=stats, unit=unit)
    return float(np.concatenate([norms((group.gt - group.pred) / scale, norm) for group in groups]).mean())


def read_scale(
    n_joints: int,
    *,
    mean: npt.ArrayLike | None,
    std: npt.ArrayLike | None,
    stats: Statistics | str | os.PathLike[str] | None,
    unit: Unit | None,
) -> Float64:
    """Return what to divide differences of positions by, ``(J, 3)``: 1 for positions in a unit."""
    own = mean is not None or std is not None
    if own + (stats is not None) + (unit is not None) != 1:
        given = [
            name for name, value in (("mean, std", own or None), ("stats", stats), ("unit", unit)) if value is not None
        ]
        raise ValueError(f"stats: expected one of mean and std, stats, unit; got {' and '.join(given) or 'none'}")
    if unit is not None:
        one_of("unit", unit, get_args(Unit))
        return np.ones((n_joints, 3))
    if stats is not None:
        mean, std = _read(stats)
    elif mean is None or std is None:
        raise ValueError(f"{'mean' if mean is None else 'std'}: expected both mean and std, got only the other")
    _per_coordinate("mean", mean, n_joints)
    scale = _per_coordinate("std", std, n_joints)
    if not (scale > 0).all():
        joint, axis = (int(i) for i in np.unravel_index(int(np.argmin(scale)), scale.shape))
        raise ValueError(f"std: expected positive numbers, got {scale[joint, axis]} for joint {joint}, {'xyz'[axis]}")
    return scale


def _per_coordinate(name: str, values: npt.ArrayLike, n_joints: int) -> Float64:
    array = real_array(name, values)
    size = 3 * n_joints
    if array.shape not in ((n_joints, 3), (size,), (1, size, 1)):
        raise ValueError(f"{name}: expected shape ({n_joints}, 3), ({size},) or (1, {size}, 1), got {array.shape}")
    check_finite(name, array)
    numbers: Float64 = array.astype(np.float64).reshape(n_joints, 3)
    return numbers


def _read(stats: Statistics | str | os.PathLike[str]) -> Statistics:
    if isinstance(stats, str | os.PathLike):
        path = Path(stats)
        if path.suffix not in suffixes("arrays"):
            raise ValueError(f"stats: {path}: expected a {listed('arrays')} file with arrays mean and std")
        with naming_file(path), open_arrays(path, "arrays") as arrays:
            if missing := [name for name in Statistics._fields if name not in arrays]:
                raise ValueError(f"no array {missing[0]!r} in it; expected mean and std")
            return Statistics(**read_arrays(arrays, Statistics._fields, MAX_SIZE))
    if not isinstance(stats, tuple) or len(stats) != 2:
        raise TypeError(f"stats: expected Statistics(mean, std) or a path, got {type(stats).__name__}")
    return Statistics(*stats)
