"""Put motion on the ground: estimate the up direction, where a source does not state it, and the ground height."""

from __future__ import annotations

import numpy as np

from npss.skeleton import Skeleton
from npss.validation import Float64
from npss_baselines.manifold.motion.features import FPS

#: Ankles and balls of the feet; the balls touch the ground.
ANKLES, BALLS = ("LeftFoot", "RightFoot"), ("LeftToeBase", "RightToeBase")
#: A ball of the foot is on the ground while it is slower than this, in body heights per second ...
STILL = 0.06
#: ... and the hips are higher above it than this share of their height in the first frame.
STANDING = 0.9
#: Deviation of ground contacts from a plane, in body heights: the weight of a point drops beyond it.
UNEVEN = 0.006
#: Weight of the first frame against the ground: that of feet spread by this, in body heights.
TRUST = 0.12
#: Share of the frames in which the lowest joint is below the ground: feet touch it, and outliers count little.
BELOW_GROUND = 0.05


def level(positions: Float64, skeleton: Skeleton) -> Float64:
    """Rotate motion so that y is up, given only that it begins standing.

    Human3.6M's files state how the root turns from frame to frame, not its first orientation: paths begin with the
    pelvis upright, and climb or fall by its tilt, up to 20 degrees for one subject. In the first frame, up is from the
    middle of the feet to the neck. The farther motion travels, the more up is the normal of the plane that the balls of
    the feet touch (iteratively re-weighted least squares, with the first frame as prior).

    Parameters
    ----------
    positions : (T, J, 3) ndarray of float64
        Positions in body heights, at 30 frames per second, tilted by up to about 45 degrees.
    skeleton : npss.skeleton.Skeleton
        With the names of the joints of `npss_baselines.data.motion.JOINTS`.

    Returns
    -------
    (T, J, 3) ndarray of float64
        Positions rotated about the origin by the smallest such angle.
    """
    j = skeleton.names.index
    balls = positions[:, [j(name) for name in BALLS]]  # (T, 2, 3)
    feet = np.concatenate([balls, positions[:, [j(name) for name in ANKLES]]], axis=1)
    first = _unit(positions[0, j("Neck")] - feet[0].mean(axis=0))
    ahead = _unit(np.cross([1.0, 0.0, 0.0], first))
    level_axes = np.stack([np.cross(first, ahead), ahead])  # (2, 3)

    hips = (positions[:, skeleton.parents.index(-1), np.newaxis] - balls) @ first  # (T, 2), above the balls
    speed = FPS * np.linalg.norm(np.diff(balls, axis=0, prepend=balls[:1]), axis=-1)
    ground = balls[(speed < STILL) & (hips > STANDING * hips[0].mean())]
    slope = np.zeros(2)
    weight = np.ones(len(ground))
    for _ in range(10 if len(ground) > 2 else 0):
        place = ground - np.average(ground, axis=0, weights=weight)
        across, height = place @ level_axes.T, place @ first
        prior = TRUST**2 * weight.sum() * np.eye(2)
        slope = np.linalg.solve((across.T * weight) @ across + prior, (across.T * weight) @ height)
        weight = 1 / (1 + ((height - across @ slope) / UNEVEN) ** 2)
    turned: Float64 = positions @ _to_y(_unit(first - slope @ level_axes)).T
    return turned


def on_ground(positions: Float64) -> Float64:
    """Shift motion ``(T, J, 3)`` so that its lowest joint is below y = 0 in `BELOW_GROUND` of the frames."""
    moved: Float64 = positions.copy()
    moved[..., 1] -= np.quantile(positions[..., 1].min(axis=-1), BELOW_GROUND)
    return moved


def _unit(vector: Float64) -> Float64:
    unit: Float64 = vector / np.linalg.norm(vector)
    return unit


def _to_y(up: Float64) -> Float64:
    """Return the rotation matrix of smallest angle that takes a unit vector to y."""
    x, y, z = up
    axis = np.array([[0, -x, 0], [x, 0, z], [0, -z, 0]])  # the cross product with up x y
    matrix: Float64 = np.eye(3) + axis + axis @ axis / (1 + y)
    return matrix
