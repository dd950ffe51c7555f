"""The windows of clips, and the parts of a window: past, transition, target."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from npss.inbetweening._motion import Local, forward, multiply, read_local, rotate
from npss.inbetweening._positions import Statistics
from npss.protocol import InBetweening, lafan1
from npss.protocol._in_betweening import Part
from npss.rotations import continuous
from npss.skeleton import Skeleton
from npss.validation import Float64, each, positive_integer

_VERTICAL = 1e-6  # an axis of unit length whose part on the floor is shorter has no direction there


class Transition(NamedTuple):
    """The parts of N windows around a transition of n frames.

    Attributes
    ----------
    past : Local
        The frames before the transition, 10 in LaFAN1's benchmark.
    truth : Local
        The n frames of the transition, which the metrics see.
    future : Local
        The frames after it, 10 in LaFAN1's benchmark. Only the first, the target, is known to predictors.
    """

    past: Local
    truth: Local
    future: Local

    @property
    def n_frames(self) -> int:
        """Frames of the transition."""
        return int(self.truth.root.shape[-2])


def windows(clips: Iterable[Local], *, part: Part = "test", protocol: InBetweening = lafan1) -> Local:
    """Cut clips into windows, centre them and turn them.

    Parameters
    ----------
    clips : iterable of Local
        Clips of one skeleton, ``(T, J, 4)`` and ``(T, 3)``, at the frame rate of the protocol.
    part : {'test', 'train'}, optional
        Test or training windows.
    protocol : InBetweening, optional
        The lengths and steps of windows.

    Returns
    -------
    Local
        The windows of all clips in their order, ``(N, length, J, 4)`` and ``(N, length, 3)``, float64. Quaternions are
        made continuous in time over each whole clip. In each window, the mean of the root's x and z is 0, and the
        root's axis `protocol.facing` points to +x at the last past frame, seen from above.

    Raises
    ------
    TypeError
        If a clip is not a `Local`, or does not hold real numbers.
    ValueError
        If a shape is wrong, a value is not finite, clips differ in their joints, no clip is long enough for a window,
        or the axis is vertical at the last past frame of a window.

    See Also
    --------
    transition : the parts of windows around a transition.
    npss.protocol.InBetweening.starts : the first frames of the windows of a clip.

    Notes
    -----
    Centring and turning see the whole window, before it is cut for a shorter transition. Local rotations of joints
    other than the root do not change.

    References
    ----------
    F. Harvey et al., "Robust Motion In-betweening", ACM Transactions on Graphics 39 (4), 2020, and its benchmark.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.inbetweening import Local, windows
    >>> clip = Local(np.tile([1.0, 0, 0, 0], (106, 22, 1)).cumsum(axis=0), np.zeros((106, 3)))
    >>> clip.quaternions[..., 1] += 1  # lean
    >>> windows([clip]).quaternions.shape
    (2, 65, 22, 4)
    """
    length, _ = protocol.cut(part)
    cut: list[tuple[Float64, Float64]] = []
    n_joints: int | None = None
    for i, clip in enumerate(each("clips", clips, "clips")):
        name = f"clips: clip {i}"
        quaternions, root = read_local(name, clip)
        if quaternions.ndim != 3:
            raise ValueError(f"{name}: expected quaternions of shape (T, J, 4), got {quaternions.shape}")
        if n_joints not in (None, quaternions.shape[1]):
            raise ValueError(f"{name}: {quaternions.shape[1]} joints, but clip 0 has {n_joints}")
        n_joints = quaternions.shape[1]
        quaternions = continuous(quaternions, axis=0)
        starts = protocol.starts(len(root), part=part)
        cut += [(quaternions[start : start + length], root[start : start + length]) for start in starts]
    if not cut:
        raise ValueError(f"clips: none is longer than {length} frames, a window")
    return _turned(np.stack([part for part, _ in cut]), np.stack([part for _, part in cut]), protocol)


def transition(windows: Local, n: int, *, protocol: InBetweening = lafan1) -> Transition:
    """Return the parts of windows around a transition of `n` frames, which begins after the past.

    Parameters
    ----------
    windows : Local
        Test windows, as `windows` returns them.
    n : int
        Frames of the transition: 5, 15, 30 or 45 in the benchmark.
    protocol : InBetweening, optional
        How many frames the past and the future have.

    Returns
    -------
    Transition
        Views of the windows. The rest of a longer window is left out.

    Raises
    ------
    TypeError
        If `windows` is not a `Local`, or `n` is not an integer.
    ValueError
        If a shape is wrong, a value is not finite, or the windows are too short.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.inbetweening import Local, transition
    >>> part = transition(Local(np.ones((3, 65, 22, 4)), np.zeros((3, 65, 3))), 30)
    >>> part.past.root.shape, part.truth.root.shape, part.future.root.shape
    ((3, 10, 3), (3, 30, 3), (3, 10, 3))
    """
    quaternions, root = read_local("windows", windows)
    if quaternions.ndim != 4:
        raise ValueError(f"windows: expected quaternions of shape (N, T, J, 4), got {quaternions.shape}")
    begin = protocol.past
    end = begin + positive_integer("n", n)
    if end + protocol.future > root.shape[1]:
        raise ValueError(f"n: {n} frames between {begin} and {protocol.future} do not fit into {root.shape[1]} frames")
    past, truth, future = (
        Local(quaternions[:, frames], root[:, frames])
        for frames in (slice(begin), slice(begin, end), slice(end, end + protocol.future))
    )
    return Transition(past, truth, future)


def train_statistics(clips: Iterable[Local], skeleton: Skeleton, *, protocol: InBetweening = lafan1) -> Statistics:
    """Compute the mean and the standard deviation of each coordinate over the training windows, for L2P.

    Parameters
    ----------
    clips : iterable of Local
        The clips of the training subjects; a generator is read one clip at a time.
    skeleton : Skeleton
        The joints.
    protocol : InBetweening, optional
        The length and the step of training windows.

    Returns
    -------
    Statistics
        ``mean`` and ``std``, both ``(J, 3)``: global positions in the frames of their windows, frames and windows
        pooled; the standard deviation of the population (divided by the number).

    Raises
    ------
    TypeError, ValueError
        As for `windows` and `forward`.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.inbetweening import Local, train_statistics
    >>> from npss.skeleton import Skeleton
    >>> bone = Skeleton(["hips", "head"], [-1, 0], [[0, 0, 0], [0, 10, 0]])
    >>> lean = np.tile(np.sqrt([0.5, 0.5, 0, 0]), (71, 2, 1))  # the hips' y axis along z
    >>> stats = train_statistics([Local(lean, np.zeros((71, 3)))], bone)  # the head is in front
    >>> stats.mean[:, 0].round(6).tolist()
    [0.0, 10.0]
    """
    count, mean, squares = 0, np.zeros((len(skeleton.names), 3)), np.zeros((len(skeleton.names), 3))
    for clip in clips:
        if not len(protocol.starts(len(clip[1]), part="train")):
            continue
        positions = forward(windows([clip], part="train", protocol=protocol), skeleton).positions
        # Pooled clip by clip (Chan et al., 1979): all windows together may not fit into memory.
        number = positions.shape[0] * positions.shape[1]
        of_clip = positions.mean(axis=(0, 1))
        step = of_clip - mean
        squares += np.square(positions - of_clip).sum(axis=(0, 1)) + np.square(step) * (
            count * number / (count + number)
        )
        mean += step * (number / (count + number))
        count += number
    if not count:
        raise ValueError(f"clips: none is longer than {protocol.train_length} frames, a training window")
    return Statistics(mean, np.sqrt(squares / count))


def _turned(quaternions: Float64, root: Float64, protocol: InBetweening) -> Local:
    """Centre windows ``(N, T, J, 4)`` and ``(N, T, 3)`` on the floor, and turn them."""
    facing = rotate(quaternions[:, protocol.past - 1, 0], np.eye(3)["xyz".index(protocol.facing)])
    x, z = facing[:, 0], facing[:, 2]
    vertical = np.hypot(x, z) < _VERTICAL
    if vertical.any():
        raise ValueError(
            f"clips: the {protocol.facing} axis of the root is vertical at the last past frame of window "
            f"{int(np.argmax(vertical))}; choose the axis that points forwards by the protocol's facing"
        )
    angle = np.arctan2(z, x) / 2  # half the rotation about y that brings (x, 0, z) to +x
    turn = np.stack([np.cos(angle), 0 * angle, np.sin(angle), 0 * angle], axis=-1)[:, np.newaxis]
    middle = root.mean(axis=1, keepdims=True) * [1, 0, 1]
    quaternions = quaternions.copy()
    quaternions[:, :, 0] = multiply(turn, quaternions[:, :, 0])
    return Local(quaternions, rotate(turn, root - middle))
