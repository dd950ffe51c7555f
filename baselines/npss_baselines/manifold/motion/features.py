"""Features: joint positions in the character's frame, and the velocities of that frame."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array, Float64, check_finite, each, real_array
from npss_baselines.manifold.motion.joints import first_frame, joint_named, positions_of

__all__ = ["local_positions", "to_features", "to_positions"]

#: Frames per second of prepared motion.
FPS = 30
#: Pairs of joints, left and right, that define the facing direction.
ACROSS = (("LeftUpLeg", "RightUpLeg"), ("LeftArm", "RightArm"))
#: Number of columns after the positions: turn about y, velocity along x, velocity along z.
VELOCITIES = 3

_LEVEL = 1e-6  # smallest horizontal share of the distances across that gives a facing direction


def to_features(positions: npt.ArrayLike, skeleton: Skeleton, *, across: Sequence[tuple[str, str]] = ACROSS) -> Float64:
    """Compute positions in the character's frame, and the velocities of that frame.

    The facing direction is horizontal, perpendicular to the sum of the right-to-left vectors in `across`. It is
    computed in each frame separately and not smoothed, so that features do not depend on neighbouring frames. In a
    walk, hips and shoulders turn against each other, and their sum hardly turns at all.

    Parameters
    ----------
    positions : (..., T, J, 3) array_like
        Positions of the skeleton's joints, y up.
    skeleton : npss.skeleton.Skeleton
        The skeleton of the positions.
    across : sequence of (str, str), optional
        Pairs of joints, left and right.

    Returns
    -------
    (..., T, 3 J + 3) ndarray of float64
        Positions of all joints, with the root above the origin and the figure facing +z, its left to +x. Then the
        changes since the previous frame: the turn about y in radians, from -pi to pi, positive to the left, and the
        displacement of the root along x and z in the current character's frame. The first frame repeats those of the
        second.

    Raises
    ------
    TypeError
        If `positions` does not hold real numbers, or `across` is not a sequence.
    ValueError
        If the shape is wrong, a position is not finite, a joint does not exist, or the vectors across cancel or are
        vertical in a frame, which the message names: a figure lying on its side has no facing direction.

    References
    ----------
    D. Holden et al., "Learning Motion Manifolds with Convolutional Autoencoders", SIGGRAPH Asia 2015 Technical Briefs.
    The direction is that of the code released with D. Holden et al., "A Deep Learning Framework for Character Motion
    Synthesis and Editing", SIGGRAPH 2016, which also smooths it.

    Examples
    --------
    A figure of two shoulders that faces +x and steps ahead by 1:

    >>> from npss.skeleton import Skeleton
    >>> figure = Skeleton(["neck", "left", "right"], [-1, 0, 0], [[0, 0, 0], [1, 0, 0], [-1, 0, 0]])
    >>> steps = [[[x, 5, 0], [x, 5, -1], [x, 5, 1]] for x in (3, 4)]
    >>> to_features(steps, figure, across=[("left", "right")])[1].round(9) + 0
    array([ 0.,  5.,  0.,  1.,  5.,  0., -1.,  5.,  0.,  0.,  0.,  1.])
    """
    array = positions_of(positions, skeleton)
    facing = _facing(array, skeleton, each("across", across, "pairs of joints"))  # (..., T)
    place = array[..., skeleton.parents.index(-1), :] * (1, 0, 1)
    features = np.empty((*array.shape[:-2], array.shape[-2] * 3 + VELOCITIES))
    features[..., :-VELOCITIES] = _turned(array - place[..., np.newaxis, :], -facing[..., np.newaxis]).reshape(
        *array.shape[:-2], -1
    )
    moved = _turned(np.diff(place, axis=-2), -facing[..., 1:])
    features[..., 1:, -3] = _wrapped(np.diff(facing, axis=-1))
    features[..., 1:, -2:] = moved[..., ::2]
    features[..., 0, -VELOCITIES:] = features[..., 1, -VELOCITIES:] if array.shape[-3] > 1 else 0
    return features


def to_positions(features: npt.ArrayLike) -> Array:
    """Compute world positions: sum up turns and displacements.

    Parameters
    ----------
    features : (..., T, 3 J + 3) array_like
        Features from `to_features`.

    Returns
    -------
    (..., T, J, 3) ndarray
        Positions. In the first frame the root is above the origin and the figure faces +z; the velocities of that frame
        are ignored. Computed in float64, returned as float32 for float32 and as float64 otherwise.

    Raises
    ------
    TypeError
        If `features` does not hold real numbers.
    ValueError
        If the shape is wrong, or a value is not finite.

    Examples
    --------
    A point that turns left and then moves ahead, to +x:

    >>> import numpy as np
    >>> to_positions([[0, 7, 0, 0, 0, 0], [0, 7, 0, np.pi / 2, 0, 2]]).round(9)[:, 0].tolist()
    [[0.0, 7.0, 0.0], [2.0, 7.0, 0.0]]
    """
    array = _features(features)
    local = local_positions(array.astype(np.float64))
    velocities = array[..., -VELOCITIES:].astype(np.float64)
    velocities[..., 0, :] = 0
    facing = np.cumsum(velocities[..., 0], axis=-1)
    steps = np.insert(velocities[..., 1:], 1, 0, axis=-1)  # x, 0, z
    path = np.cumsum(_turned(steps, facing), axis=-2)
    positions = _turned(local, facing[..., np.newaxis]) + path[..., np.newaxis, :]
    return positions.astype(np.float32 if array.dtype == np.float32 else np.float64)


def local_positions(features: npt.ArrayLike) -> Array:
    """Return the positions in the character's frame.

    Parameters
    ----------
    features : (..., T, 3 J + 3) array_like
        Features from `to_features`.

    Returns
    -------
    (..., T, J, 3) ndarray
        Positions with the root above the origin and the figure facing +z; a view where possible.

    Raises
    ------
    TypeError, ValueError
        As `to_positions`.

    Examples
    --------
    >>> local_positions([[1, 2, 3, 4, 5, 6, 0.1, 0, 2]]).tolist()
    [[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]]
    """
    array = _features(features)
    return array[..., :-VELOCITIES].reshape(*array.shape[:-1], -1, 3)


def _facing(positions: Float64, skeleton: Skeleton, pairs: Sequence[tuple[str, str]]) -> Float64:
    """Return the facing direction ``(..., T)``: the angle from +z about y, positive to the left."""
    if not pairs:
        raise ValueError("across: expected at least one pair of joints")
    vectors = [
        positions[..., joint_named("across", skeleton, left), :]
        - positions[..., joint_named("across", skeleton, right), :]
        for left, right in pairs
    ]
    across = np.sum(vectors, axis=0)  # (..., T, 3)
    undefined = np.hypot(across[..., 0], across[..., 2]) <= _LEVEL * np.linalg.norm(vectors, axis=-1).sum(axis=0)
    if undefined.any():
        raise ValueError(
            f"positions: no facing direction at frame {first_frame(undefined)}: seen from above, the vectors across, "
            f"{', '.join(f'{right} to {left}' for left, right in pairs)}, cancel or vanish"
        )
    facing: Float64 = np.arctan2(-across[..., 2], across[..., 0])  # across x up
    return facing


def _turned(vectors: Float64, angle: Float64) -> Float64:
    """Rotate vectors ``(..., 3)`` about y, from z to x, by angles ``(...)`` in radians."""
    sin, cos = np.sin(angle), np.cos(angle)
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=-1)


def _wrapped(angle: Float64) -> Float64:
    """Return equivalent angles in (-pi, pi]."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


def _features(features: npt.ArrayLike) -> Array:
    array = real_array("features", features)
    if array.ndim < 2 or array.shape[-1] % 3 or array.shape[-1] < 3 + VELOCITIES or 0 in array.shape:
        raise ValueError(f"features: expected shape (..., T, 3 J + {VELOCITIES}), got {array.shape}")
    check_finite("features", array)
    return array
