"""The protocol of Human3.6M: test windows, times and normalisation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.frames import whole_frames
from npss.rotations._forms import result_dtype
from npss.validation import (
    Array,
    Float64,
    check_finite,
    each,
    is_integer,
    one_of,
    positive_integer,
    positive_number,
    real_array,
)

#: The actions of Human3.6M, named as its files.
ACTIONS = (
    *("directions", "discussion", "eating", "greeting", "phoning", "posing", "purchases", "sitting", "sittingdown"),
    *("smoking", "takingphoto", "waiting", "walking", "walkingdog", "walkingtogether"),
)
#: The 54 of the 99 columns of a Human3.6M pose that vary over the training subjects.
COLUMNS = (
    *(*range(0, 10), *range(12, 16), *range(21, 25), *range(27, 31), *range(36, 48)),
    *(*range(51, 58), *range(60, 63), *range(75, 82), *range(84, 87)),
)
#: Frames per second of test windows: every second frame of the files.
FPS = 25
#: The field's times for the Euler error, in milliseconds after the last seed frame.
SLICES_MS = (80, 160, 320, 400, 560, 1000)
#: The subject whose clips are the test set.
TEST_SUBJECT = 5
#: The subjects whose clips are the training set.
TRAIN_SUBJECTS = (1, 6, 7, 8, 9, 11)
#: The lengths in frames, at 25 frames per second, of the test subject's two clips of each action. The positions of the
#: test windows depend on them. Measured on the standard text files. None for six clips whose lengths are unknown and
#: not checked.
TEST_LENGTHS: Mapping[str, tuple[int | None, int | None]] = MappingProxyType(
    {
        "directions": (None, 1034),
        "discussion": (None, None),
        "eating": (1638, 1166),
        "greeting": (737, 1600),
        "phoning": (1639, 1043),
        "posing": (1123, 943),
        "purchases": (1240, 1562),
        "sitting": (1969, 1939),
        "sittingdown": (None, 1963),
        "smoking": (1601, 1711),
        "takingphoto": (1663, 1391),
        "waiting": (None, None),
        "walking": (1500, 1261),
        "walkingdog": (969, 1068),
        "walkingtogether": (1508, 1492),
    }
)

#: The protocols that `window_blocks` supports.
Blocked = Literal["srnn-8", "srnn-8-late", "random-256"]
BLOCKED: tuple[Blocked, ...] = get_args(Blocked)

_SEED = 1234567890  # of the generator that draws the windows
_FIRST = 16  # the first frame of the range of draws
_SEED_ROOM, _TARGET_ROOM = 50, 100  # frames that a draw reserves before and after the boundary
_CONSTANT = 1e-4  # columns with a smaller standard deviation are dropped


class Window(NamedTuple):
    """The position of a test window: its clip, and its frames at 25 frames per second.

    Attributes
    ----------
    clip : int
        0 or 1: the first or the second clip of the action.
    start : int
        The first seed frame.
    n_seed : int
        Number of seed frames.
    n_target : int
        Number of frames to predict.

    Examples
    --------
    >>> window = Window(clip=0, start=1087, n_seed=50, n_target=100)
    >>> window.seed_frames, window.target
    (slice(1087, 1137, None), slice(1137, 1237, None))
    """

    clip: int
    start: int
    n_seed: int
    n_target: int

    @property
    def seed_frames(self) -> slice:
        """The frames that the predictor reads."""
        return slice(self.start, self.start + self.n_seed)

    @property
    def target(self) -> slice:
        """The frames to predict."""
        return slice(self.seed_frames.stop, self.seed_frames.stop + self.n_target)


def srnn_windows(
    lengths: Sequence[int], *, n_seed: int = 50, n_target: int = 100, late: bool = False
) -> tuple[Window, ...]:
    """Return the eight test windows of an action in published tables, the "SRNN seeds".

    Parameters
    ----------
    lengths : sequence of int
        The lengths in frames, at 25 frames per second, of the test subject's two clips of the action.
    n_seed : int, optional
        Seed frames, at most 50: the last ones before the boundary between seed and target.
    n_target : int, optional
        Target frames, at most 100. The boundaries do not depend on `n_seed` and `n_target`, so that models with more
        seed frames or fewer target frames are compared on the same frames.
    late : bool, optional
        Use the windows of the code released with the NPSS paper, one frame later: protocol ``'srnn-8-late'`` instead
        of ``'srnn-8'``.

    Returns
    -------
    tuple of Window
        Eight windows, alternating between clip 0 and clip 1.

    Raises
    ------
    TypeError
        If a length or a number of frames is not an integer, or `late` is not True or False.
    ValueError
        If there are not two lengths, a clip is too short, or a number of frames is out of range.

    Notes
    -----
    A draw ``a`` is the first of 50 seed frames; the target is ``a + 50`` to ``a + 149``, and the largest ``a`` leaves
    one frame of the clip unused. The code released with the NPSS paper scores ``a + 51`` to ``a + 150``, up to the last
    frame. It is unknown which of the two its tables contain: the zero-velocity row of its Table 6, which the earlier
    frames reproduce, was copied from Martinez et al. Late windows move as a whole: target frames still directly follow
    seed frames, and times still count from the last seed frame.

    References
    ----------
    K. Fragkiadaki et al., "Recurrent Network Models for Human Dynamics", ICCV 2015; A. Jain et al., "Structural-RNN",
    CVPR 2016; used by J. Martinez et al., CVPR 2017.

    Examples
    --------
    >>> walking = srnn_windows((1500, 1261))
    >>> [window.start for window in walking]
    [1087, 955, 1145, 332, 660, 304, 201, 54]
    >>> walking[1]
    Window(clip=1, start=955, n_seed=50, n_target=100)
    >>> srnn_windows((1500, 1261), late=True)[1]
    Window(clip=1, start=956, n_seed=50, n_target=100)
    """
    if not isinstance(late, bool):
        raise TypeError(f"late: expected True or False, got {late!r}")
    windows = _windows(lengths, 8, n_seed, n_target)
    return tuple(window._replace(start=window.start + late) for window in windows)


def random_windows(lengths: Sequence[int], *, n_seed: int = 10, n_target: int = 25) -> tuple[Window, ...]:
    """Return 256 random test windows of an action, 128 in each clip.

    Scores on 256 windows vary much less than on eight. The boundaries between seed and target do not depend on `n_seed`
    and `n_target`, so that models with more seed frames or fewer target frames are compared on the same frames.

    Parameters
    ----------
    lengths : sequence of int
        The lengths in frames, at 25 frames per second, of the test subject's two clips of the action.
    n_seed : int, optional
        Seed frames, at most 50: the last ones before the boundary.
    n_target : int, optional
        Target frames, at most 100.

    Returns
    -------
    tuple of Window
        256 windows, alternating between clip 0 and clip 1.

    Raises
    ------
    TypeError
        If a length or a number of frames is not an integer.
    ValueError
        If there are not two lengths, a clip is too short, or a number of frames is out of range.

    References
    ----------
    W. Mao et al., "Learning Trajectory Dependencies for Human Motion Prediction", ICCV 2019.

    Examples
    --------
    >>> windows = random_windows((1500, 1261))
    >>> len(windows), windows[0]
    (256, Window(clip=0, start=1127, n_seed=10, n_target=25))
    >>> windows[0].target == random_windows((1500, 1261), n_seed=50)[0].target
    True
    """
    return _windows(lengths, 256, n_seed, n_target)


def chain_blocks(windows: Iterable[Window]) -> tuple[str, ...]:
    """Return the block of each window: a chain of windows of one clip whose targets overlap.

    Windows whose targets share frames share errors, so they are not independent evidence. Use this function for few
    windows, such as `srnn_windows`. Many windows form nearly a single chain; for them, use `stretch_blocks`.

    Parameters
    ----------
    windows : iterable of Window
        The positions of the sequences.

    Returns
    -------
    tuple of str
        A label for each window, equal within a block: ``groups`` of `npss.report` and `npss.compare`.

    Raises
    ------
    TypeError
        If an item is not a `Window`.

    See Also
    --------
    window_blocks : blocks by the name of the protocol.

    Examples
    --------
    >>> chain_blocks(srnn_windows((1500, 1261)))[::2]  # windows of the first clip; two of them overlap
    ('clip 0, frames 1137-1294', 'clip 0, frames 1137-1294', 'clip 0, frames 710-809', 'clip 0, frames 251-350')
    """
    places = _places(windows)
    chains: list[tuple[int, int, int]] = []  # clip, first frame, and the frame after the last
    for window in sorted(places, key=lambda window: (window.clip, window.target.start)):
        start, stop = window.target.start, window.target.stop
        if chains and chains[-1][0] == window.clip and start < chains[-1][2]:
            start, stop = chains[-1][1], max(stop, chains.pop()[2])
        chains.append((window.clip, start, stop))

    def chain_of(window: Window) -> tuple[int, int, int]:
        return next(chain for chain in chains if chain[0] == window.clip and chain[1] <= window.target.start < chain[2])

    return tuple(_label(*chain_of(window)) for window in places)


def stretch_blocks(windows: Iterable[Window], lengths: Sequence[int]) -> tuple[str | None, ...]:
    """Return the block of each window: a stretch of a clip, twice as long as a target.

    Stretches are consecutive from frame 0 of a clip; a shorter remainder at its end is not a block. A window belongs
    to the stretch that contains its whole target. A window across a border belongs to no block, because it would link
    two of them.

    Parameters
    ----------
    windows : iterable of Window
        The positions of the sequences, such as `random_windows`; with targets of equal length.
    lengths : sequence of int
        The lengths of the clips in frames, at the rate of the windows.

    Returns
    -------
    tuple of str or None
        A label for each window, equal within a block, or None for a window in no block: ``groups`` of `npss.report`
        and `npss.compare`.

    Raises
    ------
    TypeError
        If an item is not a `Window`, or a length is not an integer.
    ValueError
        If a window is not in a clip of these lengths, or targets differ in length.

    See Also
    --------
    window_blocks : blocks by the name of the protocol.

    Examples
    --------
    >>> blocks = stretch_blocks(random_windows((1500, 1261), n_target=100), (1500, 1261))
    >>> blocks[:4], len(set(blocks) - {None}), blocks.count(None)
    ((None, 'clip 1, frames 1000-1199', None, None), 13, 121)
    """
    places = _places(windows)
    clips = [positive_integer("lengths", length) for length in each("lengths", lengths)]
    if len(sizes := {window.n_target for window in places}) > 1:
        raise ValueError(f"windows: expected targets of equal length, got {', '.join(map(str, sorted(sizes)))} frames")
    labels: list[str | None] = []
    for i, window in enumerate(places):
        if not (0 <= window.clip < len(clips) and window.target.stop <= clips[window.clip]):
            raise ValueError(f"windows: {window} at index {i} is not in clips of {clips} frames")
        stretch = 2 * window.n_target
        start = window.target.start // stretch * stretch
        whole = window.target.stop <= start + stretch <= clips[window.clip]
        labels.append(_label(window.clip, start, start + stretch) if whole else None)
    return tuple(labels)


def window_blocks(protocol: Blocked, lengths: Sequence[int], *, n_target: int = 100) -> tuple[str | None, ...]:
    """Return the block of each test window of an action; windows of a block are not independent evidence.

    Parameters
    ----------
    protocol : {'srnn-8', 'srnn-8-late', 'random-256'}
        The windows by their name in signatures: `srnn_windows`, or the same one frame later, in blocks by
        `chain_blocks`; or `random_windows`, in blocks by `stretch_blocks`.
    lengths : sequence of int
        The lengths in frames, at 25 frames per second, of the test subject's two clips, such as
        ``TEST_LENGTHS[action]``.
    n_target : int, optional
        Frames to predict.

    Returns
    -------
    tuple of str or None
        A label for each window, equal within a block, or None for a window in no block: ``groups`` of `npss.report`
        and `npss.compare`.

    Raises
    ------
    TypeError, ValueError
        If the protocol is invalid or a length is unknown (None); also as for `srnn_windows`.

    Examples
    --------
    >>> blocks = {action: window_blocks("srnn-8", TEST_LENGTHS[action]) for action in ("walking", "eating", "smoking")}
    >>> {action: len(set(labels)) for action, labels in blocks.items()}
    {'walking': 6, 'eating': 5, 'smoking': 6}
    """
    one_of("protocol", protocol, BLOCKED)
    if protocol == "random-256":
        return stretch_blocks(random_windows(lengths, n_target=n_target), lengths)
    return chain_blocks(srnn_windows(lengths, n_target=n_target, late=protocol == "srnn-8-late"))


def ms_to_frames(at_ms: Iterable[float], *, fps: float = FPS) -> list[int]:
    """Convert times after the last seed frame to predicted frames.

    Parameters
    ----------
    at_ms : iterable of float
        Times in milliseconds.
    fps : float, optional
        Frames per second.

    Returns
    -------
    list of int
        Indices into the prediction: 0 is the first predicted frame, ``1000 / fps`` milliseconds after the seed.

    Raises
    ------
    TypeError
        If a time or `fps` is not a number.
    ValueError
        If a time is not positive or not that of a frame. The message names the nearest valid times. The tolerance is a
        billionth of a frame, because ``1000 / 30`` is not exact.

    See Also
    --------
    frames_to_ms : the inverse.

    Examples
    --------
    >>> ms_to_frames(SLICES_MS)
    [1, 3, 7, 9, 13, 24]
    >>> ms_to_frames([100], fps=30)
    [2]
    >>> ms_to_frames([100])
    Traceback (most recent call last):
    ValueError: at_ms: 100 ms is not a whole number of frames at 25 frames per second; nearest: 80 and 120 ms
    """
    rate = positive_number("fps", fps)
    return [whole_frames("at_ms", time, rate, first=1) - 1 for time in each("at_ms", at_ms)]


def frames_to_ms(frames: Iterable[int], *, fps: float = FPS) -> list[float]:
    """Convert predicted frames to times after the last seed frame.

    Parameters
    ----------
    frames : iterable of int
        Indices into the prediction: 0 is the first predicted frame.
    fps : float, optional
        Frames per second.

    Returns
    -------
    list of float
        Times in milliseconds; whole numbers are ints.

    Raises
    ------
    TypeError
        If a frame is not an integer, or `fps` not a number.
    ValueError
        If a frame is negative, or `fps` not positive.

    See Also
    --------
    ms_to_frames : the inverse.

    Examples
    --------
    >>> frames_to_ms([1, 3, 24, 99])
    [80, 160, 1000, 4000]
    """
    rate = positive_number("fps", fps)
    times: list[float] = []
    for frame in each("frames", frames):
        if not is_integer(frame):
            raise TypeError(f"frames: expected indices of predicted frames, got {frame!r}")
        if frame < 0:
            raise ValueError(f"frames: expected indices of predicted frames, 0 or more, got {frame}")
        time = (int(frame) + 1) * 1000 / rate
        times.append(int(time) if time.is_integer() else time)
    return times


@dataclass(frozen=True, eq=False)
class Normalization:
    """The normalisation of poses for models: drop constant columns, standardise the others.

    Attributes
    ----------
    mean : (D,) ndarray of float64
        The mean of every column.
    std : (D,) ndarray of float64
        The standard deviation of every column, 1 for dropped ones.
    columns : tuple of int
        The C kept columns, ascending.
    """

    mean: Float64
    std: Float64
    columns: tuple[int, ...]

    def normalize(self, poses: npt.ArrayLike) -> Array:
        """Return the columns that vary, minus their mean, divided by their standard deviation.

        Parameters
        ----------
        poses : (..., D) array_like
            For Human3.6M ``(..., 99)``: the translation, then rotations as exponential maps in radians.

        Returns
        -------
        (..., C) ndarray
            For Human3.6M ``(..., 54)``. float32 for float32, float64 otherwise.

        Raises
        ------
        TypeError
            If `poses` does not hold real numbers.
        ValueError
            If the last axis has the wrong length, or a value is NaN or infinite.
        """
        array = _rows("poses", poses, len(self.mean))
        kept = list(self.columns)
        return ((array[..., kept] - self.mean[kept]) / self.std[kept]).astype(result_dtype(array), copy=False)

    def unnormalize(self, values: npt.ArrayLike) -> Array:
        """Undo `normalize`, and set dropped columns to their mean.

        Parameters
        ----------
        values : (..., C) array_like
            Normalised poses, from `normalize` or a model.

        Returns
        -------
        (..., D) ndarray
            Poses. float32 for float32, float64 otherwise.

        Raises
        ------
        TypeError
            If `values` does not hold real numbers.
        ValueError
            If the last axis has the wrong length, or a value is NaN or infinite.
        """
        array = _rows("values", values, len(self.columns))
        kept = list(self.columns)
        poses = np.empty((*array.shape[:-1], len(self.mean)), result_dtype(array))
        poses[...] = self.mean
        poses[..., kept] = array * self.std[kept] + self.mean[kept]
        return poses


def normalization(clips: Iterable[npt.ArrayLike]) -> Normalization:
    """Compute the field's normalisation of poses from a training set.

    Parameters
    ----------
    clips : iterable of (T_i, D) array_like
        The training set: for Human3.6M all rows, at 50 frames per second, of both clips of the `TRAIN_SUBJECTS` for the
        action or actions of the model.

    Returns
    -------
    Normalization
        Mean and standard deviation over the rows of all clips, with equal weights. Columns with a standard deviation
        below 1e-4 are dropped; for Human3.6M, `COLUMNS` remain.

    Raises
    ------
    TypeError
        If a clip does not hold real numbers.
    ValueError
        If there are no clips, a clip is not finite or not ``(T, D)`` with the D of the first, or no column varies.

    References
    ----------
    J. Martinez et al., "On Human Motion Prediction Using Recurrent Neural Networks", CVPR 2017.

    Examples
    --------
    >>> import numpy as np
    >>> fitted = normalization([np.array([[1.0, 7.0], [2.0, 7.0]]), np.array([[3.0, 7.0]])])
    >>> fitted.columns
    (0,)
    >>> x = fitted.normalize([[2.0, 7.0], [3.0, 7.0]])
    >>> x.round(3)
    array([[0.   ],
           [1.225]])
    >>> fitted.unnormalize(x)
    array([[2., 7.],
           [3., 7.]])
    """
    rows: list[Array] = []
    for i, clip in enumerate(each("clips", clips)):
        name = f"clips[{i}]"
        array = real_array(name, clip)
        if array.ndim != 2 or array.size == 0:
            raise ValueError(f"{name}: expected shape (T, D) = (frames, columns), got {array.shape}")
        rows.append(_rows(name, array, rows[0].shape[1] if rows else array.shape[1]))
    if not rows:
        raise ValueError("clips: expected at least one clip")
    total = sum(len(array) for array in rows)
    # The mean first, then the spread: the difference of two large sums would lose columns that hardly vary.
    with np.errstate(over="ignore", invalid="ignore"):
        mean: Float64 = np.sum([array.sum(axis=0, dtype=np.float64) for array in rows], axis=0) / total
        std: Float64 = np.sqrt(
            np.sum([np.square(np.subtract(array, mean, dtype=np.float64)).sum(axis=0) for array in rows], axis=0)
            / total
        )
    if not np.isfinite(std).all():
        column = int(np.argmin(np.isfinite(std)))
        raise ValueError(f"clips: the standard deviation of column {column} is beyond float64")
    columns = tuple(int(column) for column in np.flatnonzero(std >= _CONSTANT))
    if not columns:
        raise ValueError(f"clips: no column has a standard deviation of {_CONSTANT:g} or more")
    std[std < _CONSTANT] = 1
    for array in (mean, std):
        array.setflags(write=False)
    return Normalization(mean, std, columns)


def _windows(lengths: Sequence[int], count: int, n_seed: int, n_target: int) -> tuple[Window, ...]:
    """Draw windows of clip 0 and clip 1 in turn; the boundary of a window depends only on its draw."""
    for name, value, most in (("n_seed", n_seed, _SEED_ROOM), ("n_target", n_target, _TARGET_ROOM)):
        if positive_integer(name, value) > most:
            raise ValueError(f"{name}: expected at most {most} frames, got {value}")
    clips = [positive_integer("lengths", length) for length in each("lengths", lengths)]
    if len(clips) != 2:
        raise ValueError(f"lengths: expected those of the two clips of an action, got {len(clips)} lengths")
    room = _SEED_ROOM + _TARGET_ROOM
    for clip, length in enumerate(clips):
        if length <= _FIRST + room:
            raise ValueError(
                f"lengths: clip {clip} has {length} frames; windows of {room} frames need at least {_FIRST + room + 1}"
            )
    generator = np.random.RandomState(_SEED)  # the legacy generator, whose stream never changes
    draws = [(i % 2, int(generator.randint(_FIRST, clips[i % 2] - room))) for i in range(count)]
    return tuple(Window(clip, draw + _SEED_ROOM - n_seed, n_seed, n_target) for clip, draw in draws)


def _places(windows: Iterable[Window]) -> list[Window]:
    places = each("windows", windows, "windows")
    for i, window in enumerate(places):
        if not isinstance(window, Window):
            raise TypeError(f"windows: expected a Window, got {window!r} at index {i}")
    return places


def _label(clip: int, start: int, stop: int) -> str:
    return f"clip {clip}, frames {start}-{stop - 1}"


def _rows(name: str, values: npt.ArrayLike, width: int) -> Array:
    """Read finite values whose last axis has `width` entries."""
    array = real_array(name, values)
    if array.ndim == 0 or array.shape[-1] != width:
        raise ValueError(f"{name}: expected shape (..., {width}), got {array.shape}")
    check_finite(name, array)
    return array
