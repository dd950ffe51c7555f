"""Simple baselines that see which values are missing: interpolation in time, and bone lengths."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from npss.extras import install_hint
from npss.skeleton import Skeleton
from npss.validation import Float64, one_of
from npss_baselines.manifold.applications.corrupt import Corrupted

#: Ways to interpolate in time: straight lines; monotone cubics (Fritsch and Carlson); cubics whose slopes are those of
#: the parabola through three known values.
Way = Literal["linear", "pchip", "hermite"]


def interpolated(left: Corrupted, way: Way = "linear") -> Float64:
    """Interpolate each feature in time between known values.

    Before the first and after the last known value, that value is held. A feature without known values does not change.
    These baselines are oracles that know the mask; the manifold does not.

    Parameters
    ----------
    left : Corrupted
        Windows, and which of their values are known.
    way : {'linear', 'pchip', 'hermite'}, optional
        The way to interpolate.

    Returns
    -------
    (n, T, F) ndarray of float64
        The restored windows.

    Raises
    ------
    ImportError
        If scipy is missing, except for straight lines.
    ValueError
        If the way is unknown.

    References
    ----------
    F. N. Fritsch and R. E. Carlson, "Monotone Piecewise Cubic Interpolation", SIAM Journal on Numerical Analysis 17,
    1980.

    Examples
    --------
    >>> values = np.array([0.0, 9.0, 2.0, 9.0]).reshape(1, 4, 1)
    >>> known = np.array([True, False, True, False]).reshape(1, 4, 1)
    >>> interpolated(Corrupted(values, known)).ravel()
    array([0., 1., 2., 2.])
    """
    one_of("way", way, get_args(Way))
    curve = _curve(way)
    filled, frames = left.features.copy(), np.arange(left.features.shape[1])
    for window, known in enumerate(left.known):
        # Features that are known in the same frames are interpolated together.
        patterns, which = np.unique(known, axis=1, return_inverse=True)
        for number, pattern in enumerate(patterns.T):
            given = np.flatnonzero(pattern)
            if not len(given) or len(given) == len(frames):
                continue
            columns = np.flatnonzero(which.reshape(-1) == number)
            inside = np.clip(frames[~pattern], given[0], given[-1])
            values = filled[window][np.ix_(given, columns)]
            filled[window][np.ix_(~pattern, columns)] = curve(given, values, inside) if len(given) > 1 else values
    return filled


def with_lengths(features: npt.ArrayLike, known: npt.NDArray[np.bool_], skeleton: Skeleton) -> Float64:
    """Give each bone that ends in a joint that was not seen the length of the skeleton's, from the root outwards.

    Parameters
    ----------
    features : (n, T, 3 J + 3) array_like
        Restored features; the positions of joints come first.
    known : (n, T, 3 J + 3) ndarray of bool
        Where values were known. A joint of which any value was not is moved.
    skeleton : Skeleton
        The skeleton of J joints.

    Returns
    -------
    (n, T, 3 J + 3) ndarray of float64
        Features with these lengths.
    """
    restored = np.array(features, np.float64)
    n_joints = len(skeleton.names)
    joints = restored[..., : 3 * n_joints].reshape(*restored.shape[:-1], n_joints, 3)  # a view
    unseen: npt.NDArray[np.bool_] = np.any(~known[..., : 3 * n_joints].reshape(joints.shape), axis=-1)
    lengths = np.linalg.norm(skeleton.offsets, axis=-1)
    for joint in skeleton._order[1:]:
        parent = joints[..., skeleton.parents[joint], :]
        bone = joints[..., joint, :] - parent
        size = np.linalg.norm(bone, axis=-1, keepdims=True)
        moved = parent + bone * np.divide(lengths[joint], size, out=np.ones_like(size), where=size > 0)
        joints[..., joint, :] = np.where(unseen[..., joint, np.newaxis], moved, joints[..., joint, :])
    return restored


def _curve(way: Way) -> Callable[[Any, Float64, Any], Float64]:
    """Return a function of known frames, their values (k, c), and the frames to interpolate at."""
    if way == "linear":
        return lambda given, values, at: np.stack([np.interp(at, given, column) for column in values.T], axis=1)
    try:
        from scipy.interpolate import CubicHermiteSpline, PchipInterpolator
    except ImportError:
        raise ImportError(f"interpolation by cubics needs scipy; {install_hint('manifold', baselines=True)}") from None
    if way == "pchip":
        return lambda given, values, at: np.asarray(PchipInterpolator(given, values)(at))
    return lambda given, values, at: np.asarray(CubicHermiteSpline(given, values, _slopes(given, values))(at))


def _slopes(frames: npt.NDArray[np.intp], values: Float64) -> Float64:
    """Return the slopes ``(k, c)`` of the parabola through each three successive values; of two, of the line."""
    slopes: Float64 = np.gradient(values, frames.astype(np.float64), axis=0, edge_order=2 if len(frames) > 2 else 1)
    return slopes
