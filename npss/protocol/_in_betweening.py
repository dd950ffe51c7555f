"""The protocol of in-betweening: which windows are cut, and which of their frames the metrics see."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, Literal, get_args

from npss._metric.registry import L2P, L2Q
from npss.validation import each, is_integer, one_of, positive_integer, positive_number

#: The windows of training subjects, from which statistics are made, or those that are scored.
Part = Literal["train", "test"]
#: The axis of the root that points forwards.
Axis = Literal["x", "y", "z"]
#: The metrics of in-betweening tables.
MetricName = Literal["npss", "l2q", "l2p"]


@dataclass(frozen=True, kw_only=True)
class InBetweening:
    """The protocol of an in-betweening benchmark: the numbers that its published rows depend on.

    A window has `past` frames, a transition of one of the lengths `transitions`, and `future` frames, of which the
    first is the target. Windows are centred and turned before they are cut shorter: the mean of the root's x and z over
    the window is subtracted, and the shortest rotation brings the axis `facing` of the root at the last past frame,
    flattened to the floor (y is up), to +x.

    Parameters
    ----------
    name : str
        The name in signatures. ``'lafan1'`` is reserved for the benchmark's own numbers.
    fps : float
        Frames per second.
    joints : int
        Number of joints, end sites not counted.
    test_length, test_step : int
        Frames of a test window, and frames from the start of one to the start of the next.
    train_length, train_step : int
        The same of training windows, of which statistics are made.
    past, future : int, optional
        Frames before and after the transition.
    transitions : tuple of int, optional
        The lengths of transitions, in frames.
    facing : {'x', 'y', 'z'}, optional
        The axis of the root that points forwards.
    test_subjects, train_subjects : tuple of int, optional
        The subjects whose clips they are cut from.
    windows : int, optional
        Number of test windows, if known.
    zero_velocity : mapping of str to tuple of float, optional
        The published row of zero-velocity, by metric (``'npss'``, ``'l2q'``), a number for each of `transitions`:
        a checksum of ground truth and windows (`verify`).

    Raises
    ------
    TypeError, ValueError
        If a number is not positive, a window is too short for its frames, a row has not a number for each transition,
        or the name is ``'lafan1'`` and a number is not the benchmark's.

    See Also
    --------
    lafan1 : the benchmark's own.

    References
    ----------
    F. Harvey et al., "Robust Motion In-betweening", ACM Transactions on Graphics 39 (4), 2020.

    Examples
    --------
    >>> from dataclasses import replace
    >>> from npss.protocol import lafan1
    >>> mine = replace(lafan1, name="mine", joints=31, facing="z", windows=None, zero_velocity={})
    >>> mine.fields()["protocol"]
    'mine'
    >>> replace(lafan1, test_step=20)
    Traceback (most recent call last):
    ValueError: name: 'lafan1' is the benchmark's, with other values of test_step; choose another name
    """

    name: str
    fps: float
    joints: int
    test_length: int
    test_step: int
    train_length: int
    train_step: int
    past: int = 10
    future: int = 10
    transitions: tuple[int, ...] = (5, 15, 30, 45)
    facing: Axis = "y"
    test_subjects: tuple[int, ...] = ()
    train_subjects: tuple[int, ...] = ()
    windows: int | None = None
    zero_velocity: Mapping[str, tuple[float, ...]] = field(default_factory=dict, hash=False)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise TypeError(f"name: expected text, got {self.name!r}")
        positive_number("fps", self.fps)
        for name in ("joints", "test_length", "test_step", "train_length", "train_step", "past", "future"):
            positive_integer(name, getattr(self, name))
        if self.windows is not None:
            positive_integer("windows", self.windows)
        one_of("facing", self.facing, get_args(Axis))
        lengths = tuple(positive_integer("transitions", n) for n in each("transitions", self.transitions))
        if not lengths or list(lengths) != sorted(set(lengths)):
            raise ValueError(f"transitions: expected increasing lengths in frames, got {self.transitions!r}")
        for name in ("test_subjects", "train_subjects"):
            subjects = tuple(each(name, getattr(self, name)))
            if not all(is_integer(subject) for subject in subjects):
                raise TypeError(f"{name}: expected whole numbers, got {subjects!r}")
            object.__setattr__(self, name, subjects)
        if (needed := self.past + lengths[-1] + self.future) > self.test_length:
            raise ValueError(f"test_length: expected {needed} frames or more for a transition of {lengths[-1]} frames")
        if self.train_length < self.past:
            raise ValueError(f"train_length: expected {self.past} frames or more, the past")
        if not isinstance(self.zero_velocity, Mapping):
            raise TypeError(f"zero_velocity: expected a mapping of metrics to rows, got {self.zero_velocity!r}")
        rows = {metric: tuple(map(float, each("zero_velocity", row))) for metric, row in self.zero_velocity.items()}
        if any(len(row) != len(lengths) for row in rows.values()):
            raise ValueError(f"zero_velocity: expected a number for each of the transitions {lengths}, got {rows}")
        object.__setattr__(self, "transitions", lengths)
        object.__setattr__(self, "zero_velocity", MappingProxyType(rows))
        own = _NAMED.get(self.name)
        if own is not None and self != own:
            other = [name for name in self.__dataclass_fields__ if getattr(self, name) != getattr(own, name)]
            raise ValueError(
                f"name: {self.name!r} is the benchmark's, with other values of {', '.join(other)}; choose another name"
            )

    def __reduce__(self) -> tuple[Any, ...]:
        """Copy and pickle it by its parameters, since a read-only mapping can be neither copied nor pickled."""
        values = {name: getattr(self, name) for name in self.__dataclass_fields__}
        return _from_parameters, ({**values, "zero_velocity": dict(self.zero_velocity)},)

    def starts(self, n_frames: int, *, part: Part = "test") -> range:
        """Return the first frames of the windows of a clip.

        Parameters
        ----------
        n_frames : int
            Frames of the clip.
        part : {'test', 'train'}, optional
            Test or training windows.

        Returns
        -------
        range
            Each start i with i + length < `n_frames`: the bound is strict, as in the benchmark, so the last frame of a
            clip is never used.

        Raises
        ------
        TypeError, ValueError
            If `n_frames` is not a positive integer, or `part` is neither.

        Examples
        --------
        >>> from npss.protocol import lafan1
        >>> list(lafan1.starts(105)), list(lafan1.starts(106))
        ([0], [0, 40])
        """
        length, step = self.cut(part)
        return range(0, max(0, positive_integer("n_frames", n_frames) - length), step)

    def cut(self, part: Part) -> tuple[int, int]:
        """Return the length and the step of windows, in frames; `part` is ``'test'`` or ``'train'``."""
        one_of("part", part, get_args(Part))
        return (self.test_length, self.test_step) if part == "test" else (self.train_length, self.train_step)

    def fields(self, metric: MetricName = "npss") -> dict[str, Any]:
        """Return the fields of the signature of a published number, without ``frames``.

        Parameters
        ----------
        metric : {'npss', 'l2q', 'l2p'}, optional
            The metric.

        Returns
        -------
        dict
            Keywords of `npss.report` or `npss.signature`.

        Raises
        ------
        TypeError, ValueError
            If it is another metric.

        Examples
        --------
        >>> import npss
        >>> npss.signature("released", frames=30, **npss.protocol.lafan1.fields())[:78]
        'npss|version:1|convention:released|representation:global-quaternions|frames:30'
        """
        one_of("metric", metric, get_args(MetricName))
        stated = {"fps": self.fps, "protocol": self.name, "unwrap": "off"}
        if metric == L2P.name:
            return {"representation": "global-positions", **stated, **L2P.stated(), "positions": "standardised"}
        own = L2Q.stated() if metric == L2Q.name else {}
        return {"representation": "global-quaternions", **stated, "quaternions": "continuous", **own}

    def action(self, n: int) -> str:
        """Return the name of a transition of `n` frames in records and tables: ``'in-betweening, 5 frames'``."""
        return f"in-betweening, {n} frames"


def _from_parameters(values: dict[str, Any]) -> InBetweening:
    return InBetweening(**values)


_NAMED: dict[str, InBetweening] = {}  # filled below: their names are theirs alone

#: The protocol of LaFAN1's in-betweening benchmark: 22 joints at 30 frames per second, y up, the hips' y axis forwards.
lafan1 = InBetweening(
    name="lafan1",
    fps=30,
    joints=22,
    test_length=65,
    test_step=40,
    train_length=50,
    train_step=20,
    test_subjects=(5,),
    train_subjects=(1, 2, 3, 4),
    windows=2232,
    zero_velocity={"npss": (0.0053, 0.0522, 0.2318, 0.4918), "l2q": (0.56, 1.10, 1.51, 1.81)},
)
_NAMED[lafan1.name] = lafan1
