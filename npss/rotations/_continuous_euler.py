"""Euler angles without jumps: of all triples that are one rotation, in each frame the one that goes on."""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from npss.rotations._euler import EulerSequence, euler_sequence
from npss.rotations._frames import rotations_in_time
from npss.rotations._unwrap import require_turns
from npss.validation import Array, Float64

#: In machine epsilons, the cosine (sine) of the middle angle up to which a conversion may have seen gimbal lock: twice
#: that of `npss.rotations._euler`, since the angle is rounded, too.
_LOCK = 32


def continuous_euler(angles: npt.ArrayLike, *, seq: str, axis: int, start: npt.ArrayLike | None = None) -> Array:
    """Choose, of the Euler angles that are the same rotation, those nearest to the frame before.

    Where a joint passes gimbal lock, the conversions let both outer angles jump by pi, to stay in their ranges, though
    the motion is smooth; and each angle jumps by 2 pi where it passes the end of its range. Every metric of the angles
    counts the jumps. `npss.unwrap` removes those of 2 pi alone; this removes both.

    Parameters
    ----------
    angles : (..., 3) array_like
        Euler angles in radians, one axis of which are the frames: ``(N, T, J, 3)`` with ``axis=1``, for example.
    seq : str
        As in `expmap_to_euler`: ``"h36m"``, or three letters, upper case intrinsic, lower case extrinsic.
    axis : int
        The axis of the frames; not the last one.
    start : (..., 3) array_like, optional
        Angles, of the shape of `angles` without its frames, near which to begin: such as those of the last past frame.
        Without, the first frame stays as it is.

    Returns
    -------
    (..., 3) ndarray
        The same rotations: a new array. float32 for float32, float64 for all else.

    Raises
    ------
    TypeError
        If `angles` or `start` is not an array of real numbers, `seq` not a string, or `axis` no whole number.
    ValueError
        If a shape is another one, `axis` is no axis of `angles` before the last, `seq` is no sequence, or a value is
        not finite or beyond 1e12 (the first index is named).

    See Also
    --------
    npss.unwrap : jumps of 2 pi alone, of any features.
    continuous : the same for quaternions.

    Notes
    -----
    With any whole turns added, ``(a, b, c)`` is the same rotation as ``(a + pi, pi - b, c + pi)``, or as
    ``(a + pi, -b, c + pi)`` where the first letter is also the last. Near is meant in the Euclidean norm. At gimbal
    lock itself, where only the sum or the difference of the outer angles is determined, both move by the same.

    Close to the lock, but not through it, the outer angles of a smooth motion swing by about pi in a few frames: that
    is no jump, and stays.

    Published tables are of angles as the conversions return them; a score of continuous ones says so in its signature:
    pass ``unwrap="continuous"`` to `npss.signature` or `npss.report`.

    Examples
    --------
    A joint that is bent through a right angle:

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

    The poses of Human3.6M as they are scored, ``(N, T, 99)``, before and after:

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
    """Return, of the triples that are the same rotations as `angles`, those nearest to `near`."""
    half_turn = 0 if sequence.proper else math.pi
    other = np.stack([angles[..., 0] + math.pi, half_turn - angles[..., 1], angles[..., 2] + math.pi], axis=-1)
    same, other = (one + math.tau * np.round((near - one) / math.tau) for one in (angles, other))
    nearer = np.square(other - near).sum(axis=-1) < np.square(same - near).sum(axis=-1)
    chosen: Float64 = np.where(nearer[..., np.newaxis], other, same)

    middle = chosen[..., 1]
    off, side = (np.sin(middle), np.cos(middle)) if sequence.proper else (np.cos(middle), np.sin(middle))
    # Whether their sum (1) or their difference (-1) is what the rotation tells of the outer angles.
    sign = np.sign(side) * (1 if sequence.proper else -sequence.cyclic if sequence.negate else sequence.cyclic)
    step = chosen - near
    rest = np.remainder(step[..., 0] + sign * step[..., 2] + math.pi, math.tau) - math.pi
    on_line = near + np.stack([rest / 2, step[..., 1], sign * rest / 2], axis=-1)
    return np.where((np.abs(off) <= locked)[..., np.newaxis], on_line, chosen)
