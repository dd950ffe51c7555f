"""Remove sign flips of quaternions between frames."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from npss.rotations._frames import rotations_in_time
from npss.validation import Array


def continuous(q: npt.ArrayLike, *, axis: int, start: npt.ArrayLike | None = None) -> Array:
    """Choose the signs of quaternions so that they do not jump from frame to frame.

    q and -q are the same rotation. Conversions return the one with w >= 0, so the quaternions of a motion that passes
    half a turn flip signs in the middle, and every metric of their components counts the jump. This function negates a
    frame if its dot product with the frame before is negative, as the LaFAN1 benchmark does when it reads a clip.

    Parameters
    ----------
    q : (..., 4) array_like
        Quaternions with an axis of frames: ``(N, T, J, 4)`` with ``axis=1``, for example. Any length except zero.
        Order w, x, y, z or x, y, z, w.
    axis : int
        The axis of the frames; not the last one.
    start : (..., 4) array_like, optional
        Quaternions to start near, with the shape of one frame of `q`: for example the last seed frame, so that a
        prediction is in the same hemisphere (default: the first frame keeps its sign).

    Returns
    -------
    (..., 4) ndarray
        The same rotations, each within a right angle of the frame before; a new array. float32 for float32, float64
        otherwise.

    Raises
    ------
    TypeError
        If `q` or `start` is not an array of real numbers, or `axis` is not a whole number.
    ValueError
        If a shape is wrong, `axis` is not an axis of `q` before the last, a value is not finite, or a quaternion is
        zero. The message names the first index.

    See Also
    --------
    continuous_euler : the same for Euler angles.

    Notes
    -----
    Cut windows afterwards, or pass the frame before each as `start`. Otherwise ground truth and prediction may be in
    opposite hemispheres. NPSS ignores this (a feature and its negative score the same), but any mean of differences
    counts it.

    State the choice in the signature: pass ``quaternions="continuous"`` to `npss.signature` or `npss.report`.

    References
    ----------
    F. G. Harvey, M. Yurick, D. Nowrouzezahrai, C. Pal. "Robust Motion In-betweening." SIGGRAPH 2020.

    Examples
    --------
    A joint that passes half a turn about x:

    >>> import numpy as np
    >>> from npss.rotations import continuous, expmap_to_quaternion
    >>> q = expmap_to_quaternion([[3.0, 0, 0], [3.2, 0, 0], [3.4, 0, 0]])
    >>> q[:, :2].round(2)
    array([[ 0.07,  1.  ],
           [ 0.03, -1.  ],
           [ 0.13, -0.99]])
    >>> continuous(q, axis=0)[:, :2].round(2)
    array([[ 0.07,  1.  ],
           [-0.03,  1.  ],
           [-0.13,  0.99]])
    >>> continuous(q[1:], axis=0, start=q[0])[:, :2].round(2)
    array([[-0.03,  1.  ],
           [-0.13,  0.99]])
    """
    out, near = rotations_in_time("q", q, 4, axis, start)
    _require_nonzero("q", out)
    if near is not None:
        _require_nonzero("start", near)
    for frame in np.moveaxis(out, axis, 0):
        if near is not None:
            away = (_scaled(near) * _scaled(frame)).sum(axis=-1, keepdims=True) < 0
            np.subtract(0, frame, out=frame, where=away)  # unlike np.negative, never -0.0
        near = frame
    return out


def _require_nonzero(name: str, q: Array) -> None:
    zero = ~q.any(axis=-1)
    if zero.any():
        index = tuple(int(i) for i in np.unravel_index(int(np.argmax(zero)), zero.shape))
        raise ValueError(f"{name}: a zero quaternion, not a rotation, at index {index}")


def _scaled(q: Array) -> Array:
    """Divide by the largest component, to keep products of two quaternions in range."""
    scaled: Array = q / np.abs(q).max(axis=-1, keepdims=True)
    return scaled
