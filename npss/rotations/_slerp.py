"""Interpolate between two rotations."""

from __future__ import annotations

from functools import partial

import numpy as np
import numpy.typing as npt

from npss.rotations._blocks import Columns, fill, in_blocks
from npss.rotations._forms import Quaternion, result_dtype, rotation_array
from npss.rotations._quaternion import read_quaternion
from npss.validation import Array, check_finite, is_integer, is_real, real_array

#: The precision of the computation.
WORK = np.dtype(np.float64)


def slerp(
    a: npt.ArrayLike, b: npt.ArrayLike, t: npt.ArrayLike, *, axis: int = 0, linear_above: float | None = None
) -> Array:
    """Interpolate between quaternions along the shorter arc, at constant angular velocity.

    Parameters
    ----------
    a, b : (..., 4) array_like
        Quaternions of the same shape, of any nonzero length: the rotations at 0 and at 1.
    t : float or (K,) array_like
        Where, from 0 to 1.
    axis : int, optional
        The axis of the result for an array `t`, as in `numpy.linspace`: ``axis=1`` makes (N, K, J, 4) of (N, J, 4).
    linear_above : float, optional
        Interpolate linearly, and scale to unit length, where the dot product of the two unit quaternions (in the same
        hemisphere) exceeds this. The LaFAN1 benchmark's is 0.99 (default: never; no approximation is needed).

    Returns
    -------
    (..., 4) ndarray, or (..., K, ..., 4) for an array `t`
        Unit quaternions, in the hemisphere of `a`. float32 if `a` and `b` are, float64 otherwise.

    Raises
    ------
    TypeError
        If `a`, `b` or `t` does not hold real numbers, `axis` is not a whole number, or `linear_above` not a number.
    ValueError
        If a shape is wrong or differs, a value is not finite, a quaternion is zero, `t` is not from 0 to 1,
        `linear_above` is not from 0 to 1, or `axis` is not an axis of the result before the last.

    See Also
    --------
    continuous : choose signs in time; slerp takes the shorter arc whatever the signs.

    References
    ----------
    K. Shoemake, "Animating Rotation with Quaternion Curves", SIGGRAPH 1985. The linear part: F. G. Harvey et al.,
    "Robust Motion In-betweening", SIGGRAPH 2020, released benchmark.

    Examples
    --------
    A third of the way from no rotation to a quarter turn about x:

    >>> from npss.rotations import quaternion_to_expmap, slerp
    >>> quaternion_to_expmap(slerp([1, 0, 0, 0], [1, 1, 0, 0], 1 / 3)).round(4)
    array([0.5236, 0.    , 0.    ])
    >>> slerp([1, 0, 0, 0], [1, 1, 0, 0], [0, 0.5, 1]).shape
    (3, 4)
    """
    start, end = _unit("a", a), _unit("b", b)
    if start.shape != end.shape:
        raise ValueError(f"b: its shape {end.shape} differs from that of a, {start.shape}; nothing is broadcast")
    fraction = _fractions(t)
    place = _axis(axis, start.ndim + fraction.ndim)
    limit = _limit(linear_above)
    dtype = np.result_type(*map(result_dtype, (real_array("a", a), real_array("b", b))))

    arcs = np.empty((*start.shape[:-1], 10))
    in_blocks(np.concatenate([start, end], axis=-1), arcs, (1, 1), partial(_arcs, limit), WORK)
    if not fraction.ndim:
        between = np.empty(start.shape, dtype)
        in_blocks(arcs, between, (1, 1), partial(_along, float(fraction)), WORK)
        return between
    frames = (*start.shape[:place], len(fraction), *start.shape[place:])
    result: Array = np.empty(frames, dtype)
    for between, at in zip(np.moveaxis(result, place, 0), fraction.tolist(), strict=True):
        in_blocks(arcs, between, (1, 1), partial(_along, at), WORK)
    return result


def _unit(name: str, q: npt.ArrayLike) -> Array:
    """Scale quaternions to unit length, and keep their signs."""
    array = rotation_array(name, q, (4,))
    unit = np.empty(array.shape)
    fill(name, array, unit, (1, 1), _scale, WORK)
    return unit


def _scale(columns: Columns, outputs: Columns) -> None:
    quaternion = read_quaternion(columns, columns[0].dtype)
    length = np.sqrt(_dot(quaternion, quaternion))
    for column, out in zip(quaternion, outputs, strict=True):
        np.divide(column, length, out=out)


def _arcs(limit: float, columns: Columns, outputs: Columns) -> None:
    """Describe arcs: the start, the end in its hemisphere, the angle (0 where it is straight), and its sine."""
    start, end = columns[:4], columns[4:]
    dot = _dot(start, end)
    sign = np.where(dot < 0, -1.0, 1.0)
    near = tuple(sign * column for column in end)
    apart = tuple(x - y for x, y in zip(start, near, strict=True))
    together = tuple(x + y for x, y in zip(start, near, strict=True))
    # The arc cosine of the dot product would lose half of the digits of small angles.
    angle = 2 * np.arctan2(np.sqrt(_dot(apart, apart)), np.sqrt(_dot(together, together)))
    angle[np.abs(dot) > limit] = 0.0
    sine = np.sin(angle)
    sine[angle == 0] = 1.0
    for column, out in zip((*start, *near, angle, sine), outputs, strict=True):
        out[:] = column


def _along(t: float, columns: Columns, outputs: Columns) -> None:
    """Interpolate along arcs."""
    angle, sine = columns[8:]
    before, after = np.sin((1 - t) * angle) / sine, np.sin(t * angle) / sine
    straight = angle == 0
    before[straight], after[straight] = 1 - t, t
    between = tuple(before * x + after * y for x, y in zip(columns[:4], columns[4:8], strict=True))
    length = np.sqrt(_dot(between, between))
    for column, out in zip(between, outputs, strict=True):
        np.divide(column, length, out=out)


def _dot(a: Columns | Quaternion, b: Columns | Quaternion) -> Array:
    product: Array = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3]
    return product


def _fractions(t: npt.ArrayLike) -> Array:
    fraction = real_array("t", t)
    if fraction.ndim > 1:
        raise ValueError(f"t: expected a number or shape (K,), got {fraction.shape}")
    check_finite("t", fraction)
    if fraction.size and not (fraction.min() >= 0 and fraction.max() <= 1):
        outside = fraction[(fraction < 0) | (fraction > 1)].flat[0]
        raise ValueError(f"t: expected numbers from 0 to 1, got {outside}")
    return fraction.astype(np.float64)


def _axis(axis: int, ndim: int) -> int:
    """Return where the axis of `t` goes, from the front."""
    if not is_integer(axis):
        raise TypeError(f"axis: expected a whole number, got {axis!r}")
    if not -ndim <= axis < ndim or axis % ndim == ndim - 1 > 0:
        raise ValueError(f"axis: expected an axis before the last of {ndim}, got {axis}")
    return axis % ndim


def _limit(linear_above: float | None) -> float:
    if linear_above is None:
        return np.inf
    if not is_real(linear_above):
        raise TypeError(f"linear_above: expected a number, got {linear_above!r}")
    if not 0 <= linear_above <= 1:
        raise ValueError(f"linear_above: expected a number from 0 to 1, got {linear_above}")
    return float(linear_above)
