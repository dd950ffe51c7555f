"""What must be the same for two numbers to be comparable: Human3.6M's test windows, times and normalisation."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Literal, NamedTuple, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.euler_error import MOVES
from npss._metric.frames import whole_frames
from npss.rotations._forms import result_dtype
from npss.rotations._poses import POSE
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

__all__ = [
    "ACTIONS",
    "COLUMNS",
    "FPS",
    "MOVES",
    "POSE",
    "SLICES_MS",
    "TEST_LENGTHS",
    "TEST_SUBJECT",
    "TRAIN_SUBJECTS",
    "Normalization",
    "Window",
    "chain_blocks",
    "frames_to_ms",
    "ms_to_frames",
    "normalization",
    "random_windows",
    "srnn_windows",
    "stretch_blocks",
    "window_blocks",
]

#: The actions of Human3.6M, as its files name them.
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
#: The times, in milliseconds after the last seed frame, at which the field prints the Euler error.
SLICES_MS = (80, 160, 320, 400, 560, 1000)
#: The subject whose clips are the test set.
TEST_SUBJECT = 5
#: The subjects whose clips are the training set.
TRAIN_SUBJECTS = (1, 6, 7, 8, 9, 11)
#: The lengths in frames, at 25 frames per second, of the test subject's two clips of each action. They decide where the
#: test windows lie. Measured on the standard text files; None for the six clips that were not at hand: unknown, and so
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

#: The protocols of which `window_blocks` knows the windows.
Blocked = Literal["srnn-8", "srnn-8-late", "random-256"]
BLOCKED: tuple[Blocked, ...] = get_args(Blocked)

_SEED = 1234567890  # of the generator that draws the windows
_FIRST = 16  # the first frame that may be drawn
_SEED_ROOM, _TARGET_ROOM = 50, 100  # frames before and after the boundary for which a draw leaves room
_CONSTANT = 1e-4  # columns with a smaller standard deviation are dropped


class Window(NamedTuple):
    """Where a test window lies: in which clip, and in which of its frames at 25 frames per second.

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
        """The frames that the predictor sees."""
        return slice(self.start, self.start + self.n_seed)

    @property
    def target(self) -> slice:
        """The frames that it is to predict."""
        return slice(self.seed_frames.stop, self.seed_frames.stop + self.n_target)


def srnn_windows(
    lengths: Sequence[int], *, n_seed: int = 50, n_target: int = 100, late: bool = False
) -> tuple[Window, ...]:
    """Return the eight test windows of an action that published tables use, the "SRNN seeds".

    Parameters
    ----------
    lengths : sequence of int
        The lengths in frames, at 25 frames per second, of the test subject's two clips of the action.
    n_seed : int, optional
        Frames to see, at most 50: the last ones before the boundary between seed and target.
    n_target : int, optional
        Frames to predict, at most 100. The boundaries are the same whatever the two are, so that models which see more
        or predict less are still compared on the same frames.
    late : bool, optional
        Whether the windows are those of the code released with the NPSS paper, one frame later: protocol
        ``'srnn-8-late'`` instead of ``'srnn-8'``.

    Returns
    -------
    tuple of Window
        Eight windows, of clip 0 and clip 1 in turn.

    Raises
    ------
    TypeError
        If a length or a number of frames is not an integer, or `late` is not True or False.
    ValueError
        If there are not two lengths, one is too short to draw from, or a number of frames is out of range.

    Notes
    -----
    A draw ``a`` is the first of 50 seed frames; the target is ``a + 50`` to ``a + 149``, and the last ``a`` that may be
    drawn leaves one frame of the clip unused. The code released with the NPSS paper scores ``a + 51`` to ``a + 150``,
    up to the last frame. Which of the two its tables hold is not known: the zero-velocity row of its Table 6, which the
    earlier frames reproduce, was copied from Martinez et al. Late windows move as a whole, so that the target still
    begins right after the seed, and times still count from the last seed frame.

    References
    ----------
    K. Fragkiadaki et al., "Recurrent Network Models for Human Dynamics", ICCV 2015; A. Jain et al., "Structural-RNN",
    CVPR 2016; as used by J. Martinez et al., CVPR 2017.

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
    """Return 256 random test windows of an action, 128 of each clip.

    Eight windows are few: scores on 256 vary much less. The boundary between seed and target is the same whatever
    `n_seed` and `n_target` are, so that models which see more or predict less are still compared on the same frames.

    Parameters
    ----------
    lengths : sequence of int
        The lengths in frames, at 25 frames per second, of the test subject's two clips of the action.
    n_seed : int, optional
        Frames to see, at most 50: the last ones before the boundary.
    n_target : int, optional
        Frames to predict, at most 100.

    Returns
    -------
    tuple of Window
        256 windows, of clip 0 and clip 1 in turn.

    Raises
    ------
    TypeError
        If a length or a number of frames is not an integer.
    ValueError
        If there are not two lengths, one is too short to draw from, or a number of frames is out of range.

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
    """Return the block of each window, where a block is a chain of windows of one clip whose targets overlap.

    Windows whose targets share frames have errors in common, so they are no independent evidence. It is for few
    windows, such as those of `srnn_windows`; of many, nearly all are one chain, and `stretch_blocks` leaves more.

    Parameters
    ----------
    windows : iterable of Window
        Where the sequences lie.

    Returns
    -------
    tuple of str
        A label for each window, equal within a block: ``groups`` of `npss.report` and `npss.compare`.

    Raises
    ------
    TypeError
        If one is no `Window`.

    See Also
    --------
    window_blocks : by the name of the protocol.

    Examples
    --------
    >>> chain_blocks(srnn_windows((1500, 1261)))[::2]  # those of the first clip; two of them overlap
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
        return next(c for c in chains if c[0] == window.clip and c[1] <= window.target.start < c[2])

    return tuple(_label(*chain_of(window)) for window in places)


def stretch_blocks(windows: Iterable[Window], lengths: Sequence[int]) -> tuple[str | None, ...]:
    """Return the block of each window, where a block is a stretch of a clip that is twice as long as a target.

    Stretches follow each other from frame 0 of a clip on; what is left at its end, shorter than a stretch, is no
    block. A window belongs to the stretch that holds its whole target. One across a border belongs to none: it would
    tie two blocks together.

    Parameters
    ----------
    windows : iterable of Window
        Where the sequences lie, such as `random_windows`; of equal targets.
    lengths : sequence of int
        The lengths of the clips in frames, at the rate of the windows.

    Returns
    -------
    tuple of str or None
        A label for each window, equal within a block, and None for those in none: ``groups`` of `npss.report` and
        `npss.compare`.

    Raises
    ------
    TypeError
        If one is no `Window`, or a length is not an integer.
    ValueError
        If a window is not in a clip of these lengths, or targets differ in length.

    See Also
    --------
    window_blocks : by the name of the protocol.

    Examples
    --------
    >>> blocks = stretch_blocks(random_windows((1500, 1261), n_target=100), (1500, 1261))
    >>> blocks[:4], len(set(blocks) - {None}), blocks.count(None)
    ((None, 'clip 1, frames 1000-1199', None, None), 13, 121)
    """
    places = _places(windows)
    clips = [positive_integer("lengths", length) for length in each("lengths", lengths)]
    if len(targets := {window.n_target for window in places}) > 1:
        raise ValueError(f"windows: expected targets of one length, got {', '.join(map(str, sorted(targets)))} frames")
    found: list[str | None] = []
    for i, window in enumerate(places):
        if not (0 <= window.clip < len(clips) and window.target.stop <= clips[window.clip]):
            raise ValueError(f"windows: {window} at {i} is not in clips of {clips} frames")
        stretch = 2 * window.n_target
        start = window.target.start // stretch * stretch
        whole = window.target.stop <= start + stretch <= clips[window.clip]
        found.append(_label(window.clip, start, start + stretch) if whole else None)
    return tuple(found)


def window_blocks(protocol: Blocked, lengths: Sequence[int], *, n_target: int = 100) -> tuple[str | None, ...]:
    """Return the blocks of an action's test windows: which of them are no independent evidence.

    Parameters
    ----------
    protocol : {'srnn-8', 'srnn-8-late', 'random-256'}
        Which windows, as signatures name them: those of `srnn_windows`, or the same one frame later, in blocks by
        `chain_blocks`; or those of `random_windows`, in blocks by `stretch_blocks`.
    lengths : sequence of int
        The lengths in frames, at 25 frames per second, of the test subject's two clips, such as
        ``TEST_LENGTHS[action]``.
    n_target : int, optional
        Frames to predict.

    Returns
    -------
    tuple of str or None
        A label for each window, equal within a block, and None for those in none: ``groups`` of `npss.report` and
        `npss.compare`.

    Raises
    ------
    TypeError, ValueError
        If the protocol is none of these; and as `srnn_windows`, with lengths that are not known.

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
    """Return the predicted frames that lie at given times after the last seed frame.

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
        If a time is not positive, or is not a frame: the message names the nearest times that are. A billionth of a
        frame is forgiven, because ``1000 / 30`` is not exact.

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
    """Return the times after the last seed frame at which predicted frames lie.

    Parameters
    ----------
    frames : iterable of int
        Indices into the prediction: 0 is the first predicted frame.
    fps : float, optional
        Frames per second.

    Returns
    -------
    list of float
        Times in milliseconds; an int where the time is a whole number of them.

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
    """What maps poses to what models see and back: constant columns dropped, the others standardised.

    Attributes
    ----------
    mean : (D,) ndarray of float64
        The mean of every column.
    std : (D,) ndarray of float64
        The standard deviation of every column, 1 for those that are dropped.
    columns : tuple of int
        The C columns that are kept, ascending.
    """

    mean: Float64
    std: Float64
    columns: tuple[int, ...]

    def normalize(self, poses: npt.ArrayLike) -> Array:
        """Keep the columns that vary, less their mean, over their standard deviation.

        Parameters
        ----------
        poses : (..., D) array_like
            For Human3.6M ``(..., 99)``: the translation, then rotations as exponential maps in radians.

        Returns
        -------
        (..., C) ndarray
            For Human3.6M ``(..., 54)``. float32 for float32, float64 for all else.

        Raises
        ------
        TypeError
            If `poses` does not hold real numbers.
        ValueError
            If the last axis is not as long as it should be, or a value is NaN or infinite.
        """
        array = _rows("poses", poses, len(self.mean))
        kept = list(self.columns)
        return ((array[..., kept] - self.mean[kept]) / self.std[kept]).astype(result_dtype(array), copy=False)

    def unnormalize(self, values: npt.ArrayLike) -> Array:
        """Undo `normalize`; the columns that it dropped get their mean.

        Parameters
        ----------
        values : (..., C) array_like
            What `normalize` returns, or what a model that sees it predicts.

        Returns
        -------
        (..., D) ndarray
            Poses. float32 for float32, float64 for all else.

        Raises
        ------
        TypeError
            If `values` does not hold real numbers.
        ValueError
            If the last axis is not as long as it should be, or a value is NaN or infinite.
        """
        array = _rows("values", values, len(self.columns))
        kept = list(self.columns)
        poses = np.empty((*array.shape[:-1], len(self.mean)), result_dtype(array))
        poses[...] = self.mean
        poses[..., kept] = array * self.std[kept] + self.mean[kept]
        return poses


def normalization(clips: Iterable[npt.ArrayLike]) -> Normalization:
    """Compute the statistics by which models of the field see poses.

    Parameters
    ----------
    clips : iterable of (T_i, D) array_like
        The training set: for Human3.6M all rows, at 50 frames per second, of both clips of the `TRAIN_SUBJECTS` for the
        action or actions that the model learns.

    Returns
    -------
    Normalization
        Mean and standard deviation over the rows of all clips, which every row enters alike. Columns whose standard
        deviation is below 1e-4 are dropped; for Human3.6M `COLUMNS` are left.

    Raises
    ------
    TypeError
        If a clip does not hold real numbers.
    ValueError
        If there is no clip, one is not ``(T, D)`` with the D of the first or not finite, or no column varies.

    References
    ----------
    J. Martinez et al., "On Human Motion Prediction Using Recurrent Neural Networks", CVPR 2017.

    Examples
    --------
    >>> import numpy as np
    >>> found = normalization([np.array([[1.0, 7.0], [2.0, 7.0]]), np.array([[3.0, 7.0]])])
    >>> found.columns
    (0,)
    >>> x = found.normalize([[2.0, 7.0], [3.0, 7.0]])
    >>> x.round(3)
    array([[0.   ],
           [1.225]])
    >>> found.unnormalize(x)
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
        raise ValueError("clips: no clip to compute statistics of")
    total = sum(len(array) for array in rows)
    # Mean and spread in turn: the difference of two large sums would lose the columns that hardly vary.
    with np.errstate(over="ignore", invalid="ignore"):
        mean: Float64 = np.sum([array.sum(axis=0, dtype=np.float64) for array in rows], axis=0) / total
        std: Float64 = np.sqrt(
            np.sum([np.square(np.subtract(array, mean, dtype=np.float64)).sum(axis=0) for array in rows], axis=0)
            / total
        )
    if not np.isfinite(std).all():
        raise ValueError(f"clips: column {int(np.argmin(np.isfinite(std)))} has no standard deviation within float64")
    columns = tuple(int(column) for column in np.flatnonzero(std >= _CONSTANT))
    if not columns:
        raise ValueError(f"clips: no column varies (standard deviation of {_CONSTANT:g} or more)")
    std[std < _CONSTANT] = 1
    for array in (mean, std):
        array.setflags(write=False)
    return Normalization(mean, std, columns)


def _windows(lengths: Sequence[int], count: int, n_seed: int, n_target: int) -> tuple[Window, ...]:
    """Draw windows of clip 0 and clip 1 in turn; the boundary of each depends on the draw alone."""
    for name, value, most in (("n_seed", n_seed, _SEED_ROOM), ("n_target", n_target, _TARGET_ROOM)):
        if positive_integer(name, value) > most:
            raise ValueError(f"{name}: {value} frames, but these windows have at most {most}")
    clips = [positive_integer("lengths", length) for length in each("lengths", lengths)]
    if len(clips) != 2:
        raise ValueError(f"lengths: an action has two clips, got {len(clips)} lengths")
    room = _SEED_ROOM + _TARGET_ROOM
    for clip, length in enumerate(clips):
        if length <= _FIRST + room:
            raise ValueError(
                f"lengths: clip {clip} has {length} frames; windows of {room} frames need at least {_FIRST + room + 1}"
            )
    generator = np.random.RandomState(_SEED)  # the legacy generator: its stream is fixed for ever
    draws = [(i % 2, int(generator.randint(_FIRST, clips[i % 2] - room))) for i in range(count)]
    return tuple(Window(clip, draw + _SEED_ROOM - n_seed, n_seed, n_target) for clip, draw in draws)


def _places(windows: Iterable[Window]) -> list[Window]:
    places = each("windows", windows, "windows")
    for i, window in enumerate(places):
        if not isinstance(window, Window):
            raise TypeError(f"windows: expected a Window, got {window!r} at {i}")
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
