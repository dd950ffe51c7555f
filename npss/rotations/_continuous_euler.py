"""Remove jumps of Euler angles between frames."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from npss.rotations._euler import EulerSequence, euler_sequence
from npss.rotations._frames import rotations_in_time
from npss.rotations._unwrap import require_turns
from npss.validation import Array, Float64

#: Largest cosine (sine) of the middle angle, in machine epsilons, for which a conversion may have detected gimbal lock:
#: twice that of `npss.rotations._euler`, because the angle is rounded, too.
_LOCK = 32


def continuous_euler(angles: npt.ArrayLike, *, seq: str, axis: int, start: npt.ArrayLike | None = None) -> Array:
    """Choose the equivalent Euler angles that are nearest to the frame before.

    Conversions keep angles in their ranges. So when a joint of a smooth motion passes gimbal lock, both outer angles
    jump by pi, and an angle that passes the end of its range jumps by 2 pi. Every metric of the angles counts these
    jumps. `npss.unwrap` removes only jumps of 2 pi; this function removes both.

    Parameters
    ----------
    angles : (..., 3) array_like
        Euler angles in radians with an axis of frames: ``(N, T, J, 3)`` with ``axis=1``, for example.
    seq : str
        As in `expmap_to_euler`: ``"h36m"``, or three letters, upper case intrinsic, lower case extrinsic.
    axis : int
        The axis of the frames; not the last one.
    start : (..., 3) array_like, optional
        Angles to start near, with the shape of one frame of `angles`: for example the last seed frame (default: the
        first frame is unchanged).

    Returns
    -------
    (..., 3) ndarray
        The same rotations; a new array. float32 for float32, float64 otherwise.

    Raises
    ------
    TypeError
        If `angles` or `start` is not an array of real numbers, `seq` is not a string, or `axis` is not a whole number.
    ValueError
        If a shape is wrong, `axis` is not an axis of `angles` before the last, `seq` is not a sequence, or a value is
        not finite or beyond 1e12 (the message names the first index).

    See Also
    --------
    npss.unwrap : jumps of 2 pi only, of any features.
    continuous : the same for quaternions.

    Notes
    -----
    Up to full turns, ``(a, b, c)`` is the same rotation as ``(a + pi, pi - b, c + pi)``, or as
    ``(a + pi, -b, c + pi)`` if the first letter is also the last. The nearest is that in the Euclidean norm. At gimbal
    lock, where only the sum or the difference of the outer angles is determined, both move by the same amount.

    Near gimbal lock, the outer angles of a smooth motion swing by about pi in a few frames. This is not a jump, and is
    kept.

    Published tables use the angles that conversions return. State the choice of continuous angles in the signature:
    pass ``unwrap="continuous"`` to `npss.signature` or `npss.report`.

    Examples
    --------
    A joint that bends past a right angle:

    >>> import numpy as np
    >>> from npss.rotations import continuous_euler, euler_to_matrix, matrix_to_euler
    >>> bent = [[0.3, 1.4, 0.2], [0.3, 1.6, 0.2], [0.3, 1.8, 0.2]]
    >>> angles = matrix_to_euler(euler_to_matrix(bent, seq="XYZ"), seq="XYZ")
    >>> angles.round(2)
    array([[ 0.3 ,  1.4 ,  0.2 ],
           [-2.84,  1.54, -2.94],
           [-2.84,  1.34, -2.94]])
    >>> continuous_euler(angles, seq="XYZ", axis=0).round(2)
    array([[0.3, 1.4, 0.2],
           [0.3, 1.6, 0.2],
           [0.3, 1.8, 0.2]])

    Human3.6M poses as scored, ``(N, T, 99)``, before and after:

    >>> import npss
    >>> poses = np.random.default_rng(0).normal(size=(2, 10, 99))
    >>> angles = npss.poses_to_euler(poses)
    >>> joints = continuous_euler(angles.reshape(2, 10, 33, 3), seq="h36m", axis=1)
    >>> joints.reshape(angles.shape).shape
    (2, 10, 99)
    """
    sequence = euler_sequence(seq)
    out, near = rotations_in_time("angles", angles, 3, axis, start)
    require_turns("angles", out)
    if near is not None:
        require_turns("start", near)
    locked = _LOCK * float(np.finfo(out.dtype).eps)
    for frame in np.moveaxis(out, axis, 0):
        if near is not None:
            frame[...] = _nearest(sequence, frame.astype(np.float64), near.astype(np.float64), locked)
        near = frame
    return out


def _nearest(sequence: EulerSequence, angles: Float64, near: Float64, locked: float) -> Float64:
    """Return the angles nearest to `near` that are the same rotations as `angles`."""
    half_turn = 0 if sequence.proper else math.pi
    other = np.stack([angles[..., 0] + math.pi, half_turn - angles[..., 1], angles[..., 2] + math.pi], axis=-1)
    same, other = (triple + math.tau * np.round((near - triple) / math.tau) for triple in (angles, other))
    nearer = np.square(other - near).sum(axis=-1) < np.square(same - near).sum(axis=-1)
    nearest: Float64 = np.where(nearer[..., np.newaxis], other, same)

    middle = nearest[..., 1]
    off, side = (np.sin(middle), np.cos(middle)) if sequence.proper else (np.cos(middle), np.sin(middle))
    # Whether the rotation determines the sum (1) or the difference (-1) of the outer angles.
    sign = np.sign(side) * (1 if sequence.proper else -sequence.cyclic if sequence.negate else sequence.cyclic)
    step = nearest - near
    rest = np.remainder(step[..., 0] + sign * step[..., 2] + math.pi, math.tau) - math.pi
    on_line = near + np.stack([rest / 2, step[..., 1], sign * rest / 2], axis=-1)
    return np.where((np.abs(off) <= locked)[..., np.newaxis], on_line, nearest)
