"""Interpolate between two rotations."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.rotations._forms import convert, rotation_array
from npss.rotations._quaternion import QUATERNION
from npss.validation import Array, check_finite, is_integer, is_real, real_array


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
    dtype = np.result_type(start, end)
    start, end = start.astype(np.float64), end.astype(np.float64)

    dot = (start * end).sum(axis=-1, keepdims=True)
    end = np.where(dot < 0, -end, end)
    # The arc cosine of the dot product would lose half of the digits of small angles.
    angle = 2 * np.arctan2(_length(start - end), _length(start + end))
    straight = (angle == 0) | (np.abs(dot) > limit)
    sine = np.sin(np.where(straight, 1, angle))
    if fraction.ndim:
        fraction = np.expand_dims(fraction, tuple(range(1, start.ndim + 1)))
        fraction = np.moveaxis(fraction, 0, place)
        start, end, angle, sine, straight = (np.expand_dims(x, place) for x in (start, end, angle, sine, straight))
    before = np.where(straight, 1 - fraction, np.sin((1 - fraction) * angle) / sine)
    after = np.where(straight, fraction, np.sin(fraction * angle) / sine)
    between = before * start + after * end
    result: Array = (between / _length(between)).astype(dtype, order="C")
    return result


def _unit(name: str, q: npt.ArrayLike) -> Array:
    """Scale quaternions to unit length, and keep their signs."""
    array = rotation_array(name, q, (4,))
    unit = convert(name, array, QUATERNION, QUATERNION)  # also chooses w >= 0
    flipped = (np.sign(array) * unit).sum(axis=-1, keepdims=True) < 0
    return np.where(flipped, -unit, unit)


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


def _length(q: Array) -> Array:
    length: Array = np.sqrt((q * q).sum(axis=-1, keepdims=True))
    return length
