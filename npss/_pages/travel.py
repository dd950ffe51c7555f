"""How the figures of a survey travel: by the motion of the root where it is known."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Literal, NamedTuple

import numpy as np

from npss.files._samples import Pair
from npss.protocol import FPS
from npss.ranking._submissions import TRUTH, naming
from npss.skeleton import H36M, Skeleton, poses_to_positions
from npss.validation import Array, Float64

#: Whether figures travel: where the motion of the root is known, or nowhere.
Root = Literal["known", "fixed"]
_ROOT = slice(0, 6)  # columns of a pose: the displacement and the rotation of the root since the frame before
_FEET = [j for j, name in enumerate(H36M.names) if "Foot" in name or "Toe" in name]
_LITTLE = 60.0  # mm; a recording that travels less tells nothing about the slope of the floor


class Shown(NamedTuple):
    """The motions of an action, as the page shows them.

    Attributes
    ----------
    motions : dict of str to (N, T, J, 3) ndarray
        Positions of the ground truth and of each model, in millimetres.
    in_place : str
        Why the figures stay in place; empty if they travel.
    skeleton : Skeleton
        The joints and bones.
    fps : float
        Frames per second.
    """

    motions: dict[str, Array]
    in_place: str
    skeleton: Skeleton
    fps: float


def shown(action: str, pairs: Mapping[str, Pair], *, root: Root, steps: int) -> Shown:
    """Return the motions of an action: Human3.6M poses, or positions that are described by a meta.

    Parameters
    ----------
    action : str
        The action, for errors.
    pairs : mapping of str to Pair
        Ground truth and prediction of each model.
    root, steps
        As for `positions`; only Human3.6M poses take other steps than 1.

    Returns
    -------
    Shown
        The motions.

    Raises
    ------
    ValueError
        If motion cannot be drawn, models have different skeletons, or steps are not 1 without Human3.6M poses.
    """
    first = next(iter(pairs.values()))
    motions = {TRUTH: first.gt, **{model: pair.pred for model, pair in pairs.items()}}
    if first.meta is None:
        return Shown(*positions(action, motions, root=root, steps=steps), H36M, FPS)
    if steps != 1:
        raise ValueError(f"root_steps: only for poses of Human3.6M, and {action} is described by a meta; got {steps}")
    metas = {TRUTH: first.meta, **{model: pair.meta or first.meta for model, pair in pairs.items()}}
    places = {}
    for name, meta in metas.items():
        if why := meta.not_drawn():
            raise ValueError(f"{name!r} on {action!r}: cannot be shown: {why}")
        if (meta.parents, meta.joint_names) != (first.meta.parents, first.meta.joint_names):
            raise ValueError(f"{name!r} on {action!r}: its parents or joint_names differ from those of another model")
        with naming(name, action):
            places[name] = meta.positions(motions[name])
    skeleton = first.meta.skeleton(places[TRUTH])
    hips = [skeleton.parents.index(-1)]
    moves = {name: bool(np.ptp(of_one[:, :, hips], axis=1).any()) for name, of_one in places.items()}
    in_place = _why_in_place(moves, root)
    if in_place:
        places = {name: of_one - of_one[:, :, hips] * [1, 0, 1] for name, of_one in places.items()}
    return Shown(places, in_place, skeleton, first.meta.fps or FPS)


def _why_in_place(moves: Mapping[str, bool], root: Root) -> str:
    """Return why figures stay in place of which these roots move; nothing if all travel."""
    if root == "fixed":
        return "fixed on request"
    still = [repr(name) for name, of_one in moves.items() if not of_one]
    return f"the root does not move in {', '.join(still)}" if still else ""


def positions(action: str, poses: Mapping[str, Array], *, root: Root, steps: int) -> tuple[dict[str, Array], str]:
    """Return the positions of poses, and why they stay in place, if they do not travel.

    The motion of the root is known if it is not zero throughout in the ground truth and in every prediction, and the
    recorded persons stay upright. Since poses do not tell how far the root is tilted in the first frame, all figures of
    a sequence are turned so that the floor under the recorded person is level.

    Parameters
    ----------
    action : str
        The action, for errors.
    poses : mapping of str to (N, T, 99) ndarray
        Human3.6M poses of the ground truth and of each model.
    root : {'known', 'fixed'}
        Whether they travel if that is known, or stay in place.
    steps : int
        Factor of the motion of the root.

    Returns
    -------
    (dict of str to (N, T, 32, 3) ndarray, str)
        Positions in millimetres, and why they stay in place; empty if they travel.
    """
    in_place = _why_in_place({name: bool(of_one[..., _ROOT].any()) for name, of_one in poses.items()}, root)
    if not in_place:
        travelled = {}
        for name, of_one in poses.items():
            scaled = of_one.copy()
            scaled[..., _ROOT] *= steps
            with naming(name, action):
                travelled[name] = poses_to_positions(scaled, root="path")
        if _upright(travelled[TRUTH]):
            level = np.stack([_levelling(sequence) for sequence in travelled[TRUTH]])
            turned = {name: np.einsum("nij,ntkj->ntki", level, of_one) for name, of_one in travelled.items()}
            return turned, ""
        in_place = "the recorded person turns over"
    placed = {}
    for name, of_one in poses.items():
        with naming(name, action):
            placed[name] = poses_to_positions(of_one)
    return placed, in_place


def _upright(truth: Array) -> bool:
    """Return whether no foot is ever the highest joint, as in generated gaits, whose root turns over."""
    return not np.isin(truth[..., 1].argmax(axis=-1), _FEET).any()


def _levelling(truth: Array) -> Float64:
    """Return the rotation that levels the floor under a sequence ``(T, J, 3)``: the plane of its lowest joints."""
    low = np.take_along_axis(truth, truth[..., 1].argmin(axis=-1)[:, np.newaxis, np.newaxis], axis=-2)[:, 0]
    x, y, z = (low - low.mean(axis=0)).T
    across = np.stack([x, z])
    # Least squares, towards a level floor where the recorded person hardly travels.
    slope = np.linalg.solve(across @ across.T + len(low) * _LITTLE**2 * np.eye(2), across @ y)
    up = np.array([-slope[0], 1.0, -slope[1]]) / np.sqrt(1 + slope @ slope)
    # The shortest rotation of `up` onto y.
    axis = np.array([-up[2], 0.0, up[0]])
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    turn: Float64 = np.eye(3) + cross + cross @ cross / (1 + up[1])
    return turn
