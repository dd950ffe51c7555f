"""Put motion of the common joints back onto the skeleton that it came from, by inverse kinematics.

Each joint turns as little as needed for the bones below it to point where they should. So bones keep their lengths,
joints that the common skeleton lacks (fingers, twist) keep their place, and motion that did not change returns exactly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from npss.validation import Float64
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping
from npss_baselines.data.motion import JOINTS


@dataclass(frozen=True, eq=False)
class Fitted:
    """Motion on a skeleton, and how far it is from what was asked for.

    Attributes
    ----------
    motion : Bvh
        The motion, on the skeleton and with the channels of the original.
    error : (T, 20) ndarray
        The distance of each common joint from its target, in the unit of the file; 0 for joints that are made.
    """

    motion: Bvh
    error: Float64


def onto_skeleton(
    targets: Float64,
    original: Bvh,
    mapping: JointMapping,
    *,
    turning: npt.NDArray[np.bool_] | None = None,
    moving: npt.NDArray[np.bool_] | None = None,
) -> Fitted:
    """Turn the joints of a motion so that its common joints come near their targets.

    Parameters
    ----------
    targets : (T, 20, 3) ndarray
        Positions of the common joints, in the unit of the file; only directions of bones and the place of the hips
        count, so that bones keep their lengths.
    original : Bvh
        The motion to start from, with T frames: what no target determines stays as it is.
    mapping : JointMapping
        The common joints of the skeleton.
    turning : (T, J) ndarray of bool, optional
        Which joints may turn (default: all); the others keep their rotations exactly.
    moving : (T,) ndarray of bool, optional
        In which frames the hips may move (default: all).

    Returns
    -------
    Fitted
        The motion, and its error.

    Raises
    ------
    ValueError
        If the numbers of frames differ, or the mapping does not fit the skeleton.
    """
    if len(targets) != len(original.rotations):
        raise ValueError(f"targets: {len(targets)} frames, but the motion has {len(original.rotations)}")
    indices = mapping.indices(original.skeleton)
    wanted = _with_lengths(targets, original, mapping)
    skeleton, parents = original.skeleton, mapping.parents(original.skeleton)
    rotations, translations = original.rotations.copy(), original.translations.copy()
    hips = indices[0]
    assert hips is not None
    # The hips are where they should be; a joint above them carries the path.
    place, turned = skeleton.forward(rotations, offsets=translations)
    root = skeleton.parents.index(-1)
    still = np.zeros(len(targets), bool) if moving is None else ~moving
    translations[:, root] += np.where(still[:, np.newaxis], 0, wanted[:, 0] - place[:, hips])
    depths = [-1 if index is None else skeleton._order.index(index) for index in indices]
    for joint in sorted(range(len(indices)), key=depths.__getitem__):
        index = indices[joint]
        children = [child for child, parent in enumerate(parents) if parent == joint]
        if index is None or not children or not (turning is None or turning[:, index].any()):
            continue
        place, turned = skeleton.forward(rotations, offsets=translations)
        now = np.stack([place[:, indices[child]] - place[:, index] for child in children], axis=1)  # (T, c, 3)
        turn = _turn(now, wanted[:, children] - wanted[:, [joint]])
        parent = skeleton.parents[index]
        above = np.eye(3) if parent < 0 else turned[:, parent]
        frames = slice(None) if turning is None else turning[:, index]
        rotations[frames, index] = (np.swapaxes(above, -1, -2) @ turn @ turned[:, index])[frames]
    fitted = replace(original, rotations=rotations, translations=translations)
    error = np.linalg.norm(mapping.positions(fitted.positions(), skeleton) - wanted, axis=-1)
    error[:, [j for j, index in enumerate(indices) if index is None]] = 0
    return Fitted(fitted, error)


def _with_lengths(targets: Float64, original: Bvh, mapping: JointMapping) -> Float64:
    """Return targets whose bones have the lengths that they have in the original, root outwards."""
    now = mapping.positions(original.positions(), original.skeleton)
    wanted = targets.copy()
    for joint in JOINTS._order[1:]:
        parent = JOINTS.parents[joint]
        bone, length = targets[:, joint] - targets[:, parent], np.linalg.norm(now[:, joint] - now[:, parent], axis=-1)
        size = np.linalg.norm(bone, axis=-1)
        scale = np.divide(length, size, out=np.ones_like(size), where=size > 0)
        wanted[:, joint] = wanted[:, parent] + bone * scale[:, np.newaxis]
    return wanted


def _turn(now: Float64, wanted: Float64) -> Float64:
    """Return the rotations ``(T, 3, 3)`` that take vectors ``(T, c, 3)`` nearest to others, by least squares.

    One vector leaves the turn about itself open: then the smallest rotation is taken.

    References
    ----------
    W. Kabsch, "A Solution for the Best Rotation to Relate Two Sets of Vectors", Acta Crystallographica A32, 1976.
    """
    if now.shape[1] == 1:
        return _smallest(unit(now[:, 0]), unit(wanted[:, 0]))
    u, _, vt = np.linalg.svd(np.einsum("tci,tcj->tij", now, wanted))
    sign = np.linalg.det(u @ vt)
    u[..., -1] *= sign[:, np.newaxis]
    turn: Float64 = np.swapaxes(u @ vt, -1, -2)
    return turn


def _smallest(first: Float64, second: Float64) -> Float64:
    """Return the smallest rotations ``(T, 3, 3)`` from unit vectors ``(T, 3)`` to others."""
    axis, cos = np.cross(first, second), np.einsum("ti,ti->t", first, second)
    cross = np.zeros((len(first), 3, 3))
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        cross[:, j, i], cross[:, i, j] = axis[:, k], -axis[:, k]
    opposite = cos < -1 + 1e-9
    share = np.where(opposite, 0.0, 1 / np.where(opposite, 1.0, 1 + cos))
    turn: Float64 = np.eye(3) + cross + cross @ cross * share[:, np.newaxis, np.newaxis]
    if opposite.any():  # any half turn about a perpendicular axis
        one = first[opposite]
        other = np.cross(one, np.eye(3)[np.abs(one).argmin(axis=-1)])
        other = unit(other)
        turn[opposite] = 2 * other[:, :, np.newaxis] * other[:, np.newaxis, :] - np.eye(3)
    return turn


def unit(vectors: Float64) -> Float64:
    """Return vectors ``(..., 3)`` of length 1; those without a length stay as they are."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    of_length_1: Float64 = np.divide(vectors, length, out=np.zeros_like(vectors), where=length > 0)
    return of_length_1
