"""From positions of joints to what the manifold sees, and back: a figure in its own frame, and how that frame moves."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array, Float64, check_finite, each, real_array
from npss_baselines.manifold.motion.joints import first_frame, joint_named, positions_of

#: Frames per second of all prepared motion.
FPS = 30
#: The pairs of joints, left and right, across which a figure faces ahead.
ACROSS = (("LeftUpLeg", "RightUpLeg"), ("LeftArm", "RightArm"))
#: The columns behind the positions: turn about y, velocity along x, velocity along z.
VELOCITIES = 3

_LEVEL = 1e-6  # share of the distances across that must be level: with less there is no facing direction


def to_features(positions: npt.ArrayLike, skeleton: Skeleton, *, across: Sequence[tuple[str, str]] = ACROSS) -> Float64:
    """Take a figure's place and direction out of its motion, and append how they change.

    The figure faces along the ground, at right angles to the sum of the vectors from right to left that `across` names,
    in each frame by itself: nothing is smoothed, so that features know nothing of the frames around. Hips and shoulders
    turn against each other in a walk, and their sum hardly at all.

    Parameters
    ----------
    positions : (..., T, J, 3) array_like
        Positions of the skeleton's joints, y up.
    skeleton : npss.skeleton.Skeleton
        Whose joints they are.
    across : sequence of (str, str), optional
        Pairs of joints, left and right.

    Returns
    -------
    (..., T, 3 J + 3) ndarray of float64
        Positions with the root above the origin and the figure facing +z, its left to +x, joint by joint; then what
        has happened since the frame before: the turn about y in radians, from -pi to pi and positive to the left, and
        the displacement of the root, along x and z as the figure now faces. The first frame repeats the second's three.

    Raises
    ------
    TypeError
        If `positions` does not hold real numbers, or `across` is no sequence.
    ValueError
        If the shape is another one, a position is not finite, there is no such joint, or in some frame, which is
        named, the vectors across cancel or are vertical. A figure that lies on its side has no facing direction.

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
    """Put a figure back on its path: add up turns and displacements.

    Parameters
    ----------
    features : (..., T, 3 J + 3) array_like
        As of `to_features`.

    Returns
    -------
    (..., T, J, 3) ndarray
        Positions; in the first frame the root is above the origin and the figure faces +z, whatever the velocities of
        that frame. Computed in float64; float32 for float32, float64 for all else.

    Raises
    ------
    TypeError
        If `features` does not hold real numbers.
    ValueError
        If the shape is another one, or a value is not finite.

    Examples
    --------
    A point that turns to its left and then goes ahead, to +x:

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
    """Return the positions that features hold, without their path.

    Parameters
    ----------
    features : (..., T, 3 J + 3) array_like
        As of `to_features`.

    Returns
    -------
    (..., T, J, 3) ndarray
        Positions with the root above the origin, the figure facing +z: a view where possible.

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
    """Return the angle about y, to the left positive, by which the figure is turned from +z: ``(..., T)``."""
    if not pairs:
        raise ValueError("across: no pair of joints")
    vectors = [
        positions[..., joint_named("across", skeleton, left), :]
        - positions[..., joint_named("across", skeleton, right), :]
        for left, right in pairs
    ]
    across = np.sum(vectors, axis=0)  # (..., T, 3)
    lost = np.hypot(across[..., 0], across[..., 2]) <= _LEVEL * np.linalg.norm(vectors, axis=-1).sum(axis=0)
    if lost.any():
        raise ValueError(
            f"positions: no facing direction at frame {first_frame(lost)}: seen from above, the vectors of across, "
            f"{', '.join(f'{right} to {left}' for left, right in pairs)}, cancel or vanish"
        )
    facing: Float64 = np.arctan2(-across[..., 2], across[..., 0])  # across x up
    return facing


def _turned(vectors: Float64, angle: Float64) -> Float64:
    """Turn vectors ``(..., 3)`` about y, from z to x, by angles ``(...)`` in radians."""
    sin, cos = np.sin(angle), np.cos(angle)
    x, y, z = np.moveaxis(vectors, -1, 0)
    return np.stack([cos * x + sin * z, y, cos * z - sin * x], axis=-1)


def _wrapped(angle: Float64) -> Float64:
    """Return the same directions as angles from -pi, not included, to pi."""
    return np.pi - (np.pi - angle) % (2 * np.pi)


def _features(features: npt.ArrayLike) -> Array:
    array = real_array("features", features)
    if array.ndim < 2 or array.shape[-1] % 3 or array.shape[-1] < 3 + VELOCITIES or 0 in array.shape:
        raise ValueError(f"features: expected shape (..., T, 3 J + {VELOCITIES}), got {array.shape}")
    check_finite("features", array)
    return array
