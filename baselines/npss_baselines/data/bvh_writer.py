"""Write BVH files: the skeleton, channels and frame rate of a motion that was read, with other rotations."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from npss.files import write_text_atomically
from npss.rotations import continuous_euler, euler_to_matrix, matrix_to_euler, matrix_to_expmap
from npss.validation import Float64, check_finite
from npss_baselines.data.bvh import Bvh

__all__ = ["write"]

#: Largest angle in degrees, or share of the skeleton's size, that a missing channel may leave out.
TOLERANCE = 1e-4
#: Largest difference of matrices of the same rotation.
UNCHANGED = 1e-9
_SEQUENCES = {"X": "XYZ", "Y": "YZX", "Z": "ZXY"}


def write(path: str | os.PathLike[str], motion: Bvh) -> None:
    """Write a motion to a BVH file.

    Parameters
    ----------
    path : path
        The file; an existing one is replaced once the new one is complete.
    motion : Bvh
        The motion. Rotations are written as Euler angles in degrees, in each joint's own order: those of `Bvh.degrees`
        for rotations that have not changed, and others continuous in time from the frame before.

    Raises
    ------
    OSError
        If the file cannot be written.
    ValueError
        If a value is not finite, or a joint moves in a way for which it has no channel; names the joint.

    Examples
    --------
    >>> from npss_baselines.data import bvh
    >>> motion = bvh.read("walk.bvh")  # doctest: +SKIP
    >>> write("copy.bvh", motion)  # doctest: +SKIP
    """
    write_text_atomically(Path(path), text(motion))


def text(motion: Bvh) -> str:
    """Return the text of a BVH file; see `write`."""
    check_finite("rotations", motion.rotations)
    check_finite("translations", motion.translations)
    rows = np.concatenate([_values(motion, j) for j in range(len(motion.channels))], axis=1)
    header = ["HIERARCHY", *_hierarchy(motion, motion.skeleton.parents.index(-1), 0), "MOTION"]
    header += [f"Frames: {len(rows)}", f"Frame Time: {1 / motion.fps:.8f}"]
    frames = [" ".join(f"{value:.6f}" for value in row) for row in rows + 0.0]  # no -0
    return "\n".join([*header, *frames, ""])


def _hierarchy(motion: Bvh, joint: int, depth: int) -> Iterator[str]:
    """Yield the lines of a joint and of those below it."""
    channels, tabs = motion.channels[joint], "\t" * depth
    kind = "End Site" if channels is None else f"{'JOINT' if depth else 'ROOT'} {motion.skeleton.names[joint]}"
    yield f"{tabs}{kind}"
    yield f"{tabs}{{"
    yield f"{tabs}\tOFFSET {' '.join(f'{value:.6f}' for value in motion.skeleton.offsets[joint] + 0.0)}"
    if channels is not None:
        yield f"{tabs}\tCHANNELS {len(channels)} {' '.join(channels)}".rstrip()
        for child, parent in enumerate(motion.skeleton.parents):
            if parent == joint:
                yield from _hierarchy(motion, child, depth + 1)
    yield f"{tabs}}}"


def _values(motion: Bvh, joint: int) -> Float64:
    """Return the values of a joint's channels, ``(T, n)``."""
    channels, name = motion.channels[joint] or (), motion.skeleton.names[joint]
    places = motion.translations[:, joint]
    fixed = [axis for axis in range(3) if f"{'XYZ'[axis]}position" not in channels]
    away = np.abs(places[:, fixed] - motion.skeleton.offsets[joint, fixed])
    if away.max(initial=0) > TOLERANCE * (1 + np.abs(motion.skeleton.offsets).max()):
        raise ValueError(f"{name}: it moves by {away.max():g} along an axis without a position channel")
    order = "".join(channel[0] for channel in channels if channel.endswith("rotation"))
    own = None if motion.degrees is None else motion.degrees[:, joint]
    degrees = _degrees(motion.rotations[:, joint], order, name, own)
    by_channel = {f"{axis}rotation": degrees[:, i] for i, axis in enumerate(order)}
    by_channel |= {f"{axis}position": places[:, i] for i, axis in enumerate("XYZ")}
    columns: Float64 = (
        np.stack([by_channel[channel] for channel in channels], axis=1) if channels else np.empty((len(places), 0))
    )
    return columns


def _degrees(rotations: Float64, order: str, name: str, own: Float64 | None) -> Float64:
    """Return the Euler angles in degrees, ``(T, n)``, of rotations about n axes: own ones if they are the same."""
    axes = len(order)
    if own is None or not axes:
        return np.degrees(_continuous(_angles(rotations, order, name), order))
    seq = order + "".join(axis for axis in "XYZ" if axis not in order)
    changed = np.abs(euler_to_matrix(np.radians(own), seq=seq) - rotations).max(axis=(1, 2)) > UNCHANGED
    degrees = own[:, :axes].copy()
    for start, end in np.flatnonzero(np.diff(np.r_[False, changed, False])).reshape(-1, 2):
        angles = _angles(rotations[start:end], order, name)
        if start:
            angles = _continuous(angles, order, np.radians(degrees[start - 1]))
        elif end < len(own):  # back from the first frame that has not changed
            angles = _continuous(angles[::-1], order, np.radians(degrees[end]))[::-1]
        else:
            angles = _continuous(angles, order)
        degrees[start:end] = np.degrees(angles)
    return degrees


def _continuous(angles: Float64, order: str, start: Float64 | None = None) -> Float64:
    """Return the same rotations by the Euler angles ``(T, n)`` that are nearest to those of the frame before."""
    if len(order) == 3:
        nearest: Float64 = continuous_euler(angles, seq=order, axis=0, start=start)
        return nearest
    return np.unwrap(angles if start is None else np.concatenate([[start], angles]), axis=0)[-len(angles) :]


def _angles(rotations: Float64, order: str, name: str) -> Float64:
    """Return the Euler angles in radians, ``(T, n)``, of rotations about n axes."""
    if len(order) == 3:
        angles: Float64 = matrix_to_euler(rotations, seq=order)
        return angles
    rest, columns = rotations, []
    for place, axis in enumerate(order):
        # A later axis, which this rotation alone turns away from itself; or for the last rotation, any other axis.
        reference = "XYZ".index(order[place + 1] if place + 1 < len(order) else "XYZ".replace(axis, "")[0])
        angle = _about(rest, "XYZ".index(axis), reference)
        columns.append(angle)
        rest = euler_to_matrix(np.stack([-angle, 0 * angle, 0 * angle], axis=-1), seq=_SEQUENCES[axis]) @ rest
    left_out = np.degrees(np.linalg.norm(matrix_to_expmap(rest), axis=-1)).max()
    if left_out > TOLERANCE:
        raise ValueError(f"{name}: it turns by {left_out:g} degrees about axes without a rotation channel")
    return np.stack(columns, axis=-1) if columns else np.empty((len(rotations), 0))


def _about(rotations: Float64, axis: int, reference: int) -> Float64:
    """Return the angles about an axis from another axis to its rotated self, ``(T,)``."""
    third = 3 - axis - reference
    sign = 1 if (reference - axis) % 3 == 1 else -1
    angles: Float64 = sign * np.arctan2(rotations[:, third, reference], rotations[:, reference, reference])
    return angles
