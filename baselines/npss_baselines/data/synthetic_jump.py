"""A generated figure that jumps on the spot, whose feet stand still on the ground: unlike those of generated walks."""

from __future__ import annotations

import numpy as np

from npss.validation import Float64, positive_integer, positive_number
from npss_baselines.data.motion import JOINTS, NAMES, Clip

#: Seconds from one jump to the next: crouching, in the air, landing and standing up.
CROUCH, AIR, RISE = 0.6, 0.35, 0.65
#: The depth of a crouch, in body heights, and gravity in body heights (of 1.75 m) per second squared.
DEPTH, GRAVITY = 0.12, 9.81 / 1.75

_LOW = 0.01  # how far the hips of a standing figure are below those of one with straight legs


def jump_clip(n_frames: int, *, fps: float = 30.0) -> Clip:
    """Generate jumps on the spot.

    The figure crouches, flies along a parabola under gravity, lands, and stands up. Its arms swing up. The balls of the
    feet stay in place on the ground except in the air.

    Parameters
    ----------
    n_frames : int
        Number of frames.
    fps : float, optional
        Frames per second.

    Returns
    -------
    Clip
        The clip ``jump/0`` of the subject ``synthetic/jump``, in body heights.

    Raises
    ------
    TypeError, ValueError
        If a number is not positive.

    Examples
    --------
    >>> clip = jump_clip(160)
    >>> clip.positions.shape, float(clip.positions[:, NAMES.index("LeftToeBase"), 1].max()) > 0.05
    ((160, 20, 3), True)
    """
    time = np.arange(positive_integer("n_frames", n_frames)) / positive_number("fps", fps) % (CROUCH + AIR + RISE)
    flying = (time >= CROUCH) & (time < CROUCH + AIR)
    # The hips sink and rise by half a cosine wave; in the air, they follow the parabola that ends where it began.
    up = (time - CROUCH).clip(0, AIR)
    flight = GRAVITY / 2 * up * (AIR - up)
    sunk = np.where(
        time < CROUCH,
        (1 - np.cos(2 * np.pi * time / CROUCH)) / 2,
        (1 - np.cos(2 * np.pi * (time - CROUCH - AIR).clip(0) / RISE)) / 2,
    )
    positions = _rest(len(time))
    root = positions[:, 0].copy()
    root[:, 1] += flight - _LOW - DEPTH * np.where(flying, 0, sunk)
    upper = [i for i, name in enumerate(NAMES) if not name.endswith(("Leg", "Foot", "ToeBase")) or "UpLeg" in name]
    positions[:, upper] += (root - positions[:, 0])[:, np.newaxis]
    for side in ("Left", "Right"):
        _bend(positions, side, flight)
        _swing(positions, side, np.where(flying, 1, sunk / 2))
    return Clip("jump/0", "synthetic", "synthetic/jump", "jump", float(fps), positions)


def _rest(n_frames: int) -> Float64:
    """Return the skeleton's rest pose, ``(T, 20, 3)``."""
    rest = np.zeros_like(JOINTS.offsets)
    for joint in JOINTS._order:
        rest[joint] = JOINTS.offsets[joint] + (rest[JOINTS.parents[joint]] if JOINTS.parents[joint] >= 0 else 0)
    return np.tile(rest, (n_frames, 1, 1))


def _bend(positions: Float64, side: str, lifted: Float64) -> None:
    """Lift a foot, and bend the knee ahead, between hip and ankle."""
    hip, knee, ankle, ball = (NAMES.index(f"{side}{name}") for name in ("UpLeg", "Leg", "Foot", "ToeBase"))
    foot = positions[:, ball] - positions[:, ankle]
    positions[:, ankle, 1] += lifted
    positions[:, ball] = positions[:, ankle] + foot
    thigh, shank = (float(np.linalg.norm(JOINTS.offsets[joint])) for joint in (knee, ankle))
    way = positions[:, ankle] - positions[:, hip]
    distance = np.linalg.norm(way, axis=-1, keepdims=True)
    along = way / distance
    place = (distance**2 + thigh**2 - shank**2) / (2 * distance)
    ahead = np.cross(along, (-1.0, 0.0, 0.0))
    ahead /= np.linalg.norm(ahead, axis=-1, keepdims=True)
    positions[:, knee] = positions[:, hip] + place * along + np.sqrt(np.maximum(thigh**2 - place**2, 0)) * ahead


def _swing(positions: Float64, side: str, share: Float64) -> None:
    """Turn an arm about the shoulder: at a share of 0 it hangs, at 1 it points up."""
    arm = [NAMES.index(f"{side}{name}") for name in ("ForeArm", "Hand", "HandIndex")]
    angle = np.pi * share - np.pi / 2
    outward = 1.0 if side == "Left" else -1.0
    direction = np.stack([0.3 * outward * np.cos(angle), np.sin(angle), np.cos(angle)], axis=-1)
    direction /= np.linalg.norm(direction, axis=-1, keepdims=True)
    for joint in arm:
        length = np.linalg.norm(JOINTS.offsets[joint])
        positions[:, joint] = positions[:, JOINTS.parents[joint]] + length * direction
