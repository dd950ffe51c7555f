"""Interpolate two motions: by features, by rotations of joints, or in the hidden space of a manifold."""

from __future__ import annotations

from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
import numpy.typing as npt

from npss.rotations import expmap_to_matrix
from npss.skeleton import Skeleton
from npss.validation import Array, Float64, is_real, one_of, real_array
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.simple import with_lengths
from npss_baselines.manifold.motion.contacts import contacts_of, hold_feet
from npss_baselines.manifold.motion.features import VELOCITIES, local_positions
from npss_baselines.manifold.motion.onto_skeleton import unit
from npss_baselines.manifold.motion.smooth import smoothed

if TYPE_CHECKING:
    from npss_baselines.manifold.model.projector import Projector  # imports torch

__all__ = ["blend", "interpolate", "possible", "slerp"]

#: Ways to interpolate: features linearly; rotations of joints by a share of their angle; hidden units linearly.
Way = Literal["linear", "slerp", "manifold"]

_APART = 1e-9  # sine of the angle below which two directions are equal or opposite


def blend(first: npt.ArrayLike, second: npt.ArrayLike, share: float) -> Array:
    """Blend motions or codes linearly: (1 - share) first + share second.

    Parameters
    ----------
    first, second : array_like
        Arrays of the same shape.
    share : float
        Share of the second, from 0 to 1.

    Returns
    -------
    ndarray
        The blend, of the same shape.

    Raises
    ------
    TypeError, ValueError
        If the shapes differ, or the share is invalid.

    Examples
    --------
    >>> blend([0.0, 2.0], [4.0, 4.0], 0.25)
    array([1. , 2.5])
    """
    a, b = real_array("first", first), real_array("second", second)
    if a.shape != b.shape:
        raise ValueError(f"second: shape {b.shape} differs from shape {a.shape} of first")
    if not is_real(share):
        raise TypeError(f"share: expected a number from 0 to 1, got {share!r}")
    if not 0 <= share <= 1:
        raise ValueError(f"share: expected a number from 0 to 1, got {share!r}")
    blended: Array = (1 - share) * a + share * b
    return blended


def slerp(first: npt.ArrayLike, second: npt.ArrayLike, share: float, skeleton: Skeleton = JOINTS) -> Float64:
    """Blend motions by the rotations of their joints, and by everything else linearly.

    From the first motion to the second, each joint turns by the smallest rotation that takes its bone to the other
    direction, in the frame that turns with the bone above it. The blend turns by a share of the angle. So an arm that
    is straight in both motions is straight in between.

    Parameters
    ----------
    first, second : (..., T, 3 J + 3) array_like
        Features of motions.
    share : float
        Share of the second, from 0 to 1.
    skeleton : npss.skeleton.Skeleton, optional
        The skeleton of J joints.

    Returns
    -------
    (..., T, 3 J + 3) ndarray of float64
        Features of motion whose bones have the lengths of the skeleton's. The root's place and the velocities are
        blended linearly.

    Raises
    ------
    TypeError, ValueError
        As `blend`, or if the number of joints differs.

    Notes
    -----
    Positions do not tell how a bone turns about itself; the smallest rotation does not turn it. Opposite directions
    have many smallest rotations, of which one is taken.

    References
    ----------
    K. Shoemake, "Animating Rotation with Quaternion Curves", SIGGRAPH 1985.

    Examples
    --------
    A forearm that points ahead, and one that points up, blend at 45 degrees; a linear blend would be shorter:

    >>> from npss.skeleton import Skeleton
    >>> arm = Skeleton(["elbow", "hand"], [-1, 0], [[0, 0, 0], [0, 1, 0]])
    >>> ahead, up = [[0, 0, 0, 0, 0, 1, 0, 0, 0]], [[0, 0, 0, 0, 1, 0, 0, 0, 0]]
    >>> slerp(ahead, up, 0.5, arm)[0, 3:6].round(3)
    array([0.   , 0.707, 0.707])
    """
    blended = np.array(blend(first, second, share), np.float64)
    n_joints = len(skeleton.names)
    if blended.shape[-1] != 3 * n_joints + VELOCITIES:
        raise ValueError(f"first: expected shape (..., T, {3 * n_joints + VELOCITIES}), got {blended.shape}")
    start, end = (local_positions(np.asarray(motion, np.float64)) for motion in (first, second))
    joints = start.copy()
    root = skeleton._order[0]
    joints[..., root, :] = local_positions(blended)[..., root, :]
    # Rotations from the first motion, of each bone and what it carries: to the blend, and to the second motion.
    still = np.broadcast_to(np.eye(3), (*start.shape[:-2], 3, 3))
    partly, wholly = {root: still}, {root: still}
    for joint in skeleton._order[1:]:
        parent = skeleton.parents[joint]
        before, after = (unit(motion[..., joint, :] - motion[..., parent, :]) for motion in (start, end))
        turn = _smallest_rotation(before, np.einsum("...ji,...j->...i", wholly[parent], after))
        partly[joint] = partly[parent] @ expmap_to_matrix(share * turn)
        wholly[joint] = wholly[parent] @ expmap_to_matrix(turn)
        bone = np.linalg.norm(skeleton.offsets[joint]) * before
        joints[..., joint, :] = joints[..., parent, :] + np.einsum("...ij,...j->...i", partly[joint], bone)
    blended[..., :-VELOCITIES] = joints.reshape(*blended.shape[:-1], -1)
    return blended


def interpolate(
    projector: Projector | None,
    first: npt.ArrayLike,
    second: npt.ArrayLike,
    share: float,
    *,
    way: Way = "slerp",
    constrained: bool = True,
) -> Array:
    """Interpolate two motions, so that the result is possible: bones keep their lengths, and standing feet their place.

    Parameters
    ----------
    projector : Projector or None
        The manifold, for the way ``'manifold'``.
    first, second : (n, T, F) array_like
        The motions, of the joints of `npss_baselines.data.motion.JOINTS`.
    share : float
        Share of the second, from 0 to 1; 0 and 1 give the first and the second, by ``'manifold'`` their projections.
    way : {'linear', 'slerp', 'manifold'}, optional
        Blend features, rotations of joints, or hidden units; see `Way`. For a linear manifold such as principal
        components, ``'manifold'`` is only the projection of the linear blend.
    constrained : bool, optional
        Whether the blend is made possible, by `possible`; the paper leaves this to future work. The decoded motion of
        a manifold is smoothed, too.

    Returns
    -------
    (n, T, F) ndarray
        The blended motions.

    Raises
    ------
    TypeError, ValueError
        If the motions are invalid, their shapes differ, the share is not from 0 to 1, the way is unknown, or
        ``'manifold'`` has no projector.

    Examples
    --------
    >>> from npss_baselines.data.synthetic import synthetic_clips
    >>> from npss_baselines.manifold.motion.dataset import prepare
    >>> first, second = prepare(synthetic_clips(2, 160, seed=0)).windows[:, np.newaxis]
    >>> interpolate(None, first, second, 0.5).shape
    (1, 160, 63)
    """
    one_of("way", way, get_args(Way))
    if way == "linear":
        blended: Array = blend(first, second, share)
    elif way == "slerp":
        blended = slerp(first, second, share)
    elif projector is None:
        raise ValueError("projector: the way 'manifold' needs a manifold, got None")
    else:
        code = blend(projector.encode(first), projector.encode(second), share)
        blended = projector.decode(code, np.shape(first)[1])
        blended = smoothed(blended) if constrained else blended
    return possible(blended, first, second, share) if constrained else blended


def possible(blended: npt.ArrayLike, first: npt.ArrayLike, second: npt.ArrayLike, share: float) -> Float64:
    """Give a blend of motions the lengths of bones, and hold the feet that stand in it.

    A foot stands in the blend while it stands in motions whose shares are together more than a half: in the dominant
    one, or, at a share of a half, in both.

    Parameters
    ----------
    blended : (n, T, 63) array_like
        The blend.
    first, second : (n, T, 63) array_like
        The motions.
    share : float
        Share of the second, from 0 to 1.

    Returns
    -------
    (n, T, 63) ndarray of float64
        The blend, made possible.

    Raises
    ------
    TypeError, ValueError
        As `interpolate`.
    """
    unknown = np.zeros(np.shape(blended), bool)
    one, other = (contacts_of(motion, JOINTS).astype(float) for motion in (first, second))
    return hold_feet(with_lengths(blended, unknown, JOINTS), blend(one, other, share) > 0.5, JOINTS)


def _smallest_rotation(first: Float64, second: Float64) -> Float64:
    """Return the smallest rotations from unit vectors ``(..., 3)`` to others, as exponential maps."""
    axis = np.cross(first, second)
    sin, cos = np.linalg.norm(axis, axis=-1, keepdims=True), np.sum(first * second, axis=-1, keepdims=True)
    # Of opposite vectors, the axis is any that is perpendicular: beside the smallest coordinate.
    beside = np.cross(first, np.eye(3)[np.abs(first).argmin(axis=-1)])
    axis = unit(np.where(sin > _APART, axis, beside))
    rotation: Float64 = np.arctan2(np.where(sin > _APART, sin, 0), cos) * axis
    return rotation
