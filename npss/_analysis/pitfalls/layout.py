"""Pitfalls of layout: wrong axes, wrong units, poses before conversion."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator

import numpy as np

from npss._analysis.pitfalls.pitfall import Block, Found, Pitfall
from npss.rotations._poses import POSE, UNSCORED
from npss.validation import Float64

#: The largest squared steps of smooth motion, in units of squared distances from the mean: those of white noise are 2,
#: those of motion along time a few hundredths.
_SMOOTH = 0.25


#: The sizes of joints: positions or Euler angles, quaternions, 6D, matrices.
_COORDINATES = (3, 4, 6, 9)


class SwappedAxes(Pitfall):
    """Time on the axis of features, or on that of joints."""

    name = "axes"
    _SIZES = (1, *_COORDINATES)  # of what follows time on the last axis: nothing, or the coordinates of a joint

    def __init__(self) -> None:
        self._time = np.zeros(2)  # squared steps, squared distances from the mean
        self._features = np.zeros((len(self._SIZES), 2))  # the same along the last axis

    def see(self, block: Block) -> None:
        """Add up the steps along both axes."""
        n, n_frames, n_features = block.gt.shape
        if n_frames < 3:  # two frames look erratic in any motion
            return
        self._time += _roughness(block.gt, 1)
        for row, size in zip(self._features, self._SIZES, strict=True):
            if size == 1 or (n_features % size == 0 and n_features // size > 2):
                row += _roughness(block.gt.reshape(n, n_frames, -1, size), 2)

    def found(self) -> Iterator[Found]:
        """Yield a finding if motion is smooth along the last axis only."""
        with np.errstate(invalid="ignore", divide="ignore"):
            along_time, along_features = self._time[0] / self._time[1], self._features[:, 0] / self._features[:, 1]
        smooth = along_features < _SMOOTH
        if along_time > 1 and smooth[0]:
            yield Found(
                "gt",
                1,
                (),
                "varies smoothly along the last axis and erratically along the one before: is time last? "
                "Expected (sequences, frames, features)",
            )
        elif along_time > 1 and smooth.any():
            yield Found(
                "gt",
                1,
                (),
                f"varies smoothly from each {self._SIZES[int(smooth.argmax())]} features to the next and erratically "
                f"along the axis before: is time the third of four axes? Expected (sequences, frames, joints, "
                f"coordinates)",
            )


def _roughness(motion: Float64, axis: int) -> tuple[float, float]:
    """Return the sums of squared steps along an axis, and of squared distances from the mean over it."""
    return float(np.square(np.diff(motion, axis=axis)).sum()), float(motion.var(axis=axis).sum()) * motion.shape[axis]


class FirstAxis(Pitfall):
    """Time on the axis of sequences."""

    _SMOOTHER = 25  # ratio of squared steps; between windows of a motion, steps are as large or larger
    _message: str

    @staticmethod
    @abstractmethod
    def concerns(n_features: int) -> bool:
        """Return whether motion with so many features may be of that kind."""

    def __init__(self) -> None:
        self._steps = np.zeros(2)  # squared, along the first axis and the second
        self._counts = np.zeros(2)
        self._distances = 0.0  # squared, from the mean along the second axis
        self._last: Float64 | None = None

    def see(self, block: Block) -> None:
        """Add up the steps along the first two axes."""
        if not self.concerns(block.gt.shape[2]) or block.gt.shape[1] < 3:
            return
        rows = block.gt if self._last is None else np.concatenate([self._last, block.gt])
        self._last = block.gt[-1:]
        for axis, motion in enumerate((rows, block.gt)):
            steps = np.diff(motion, axis=axis)
            self._steps[axis] += np.square(steps).sum()
            self._counts[axis] += steps.size
        self._distances += float(block.gt.var(axis=1).sum()) * block.gt.shape[1]

    def found(self) -> Iterator[Found]:
        """Yield a finding if motion is smooth along the first axis and not along the second."""
        if self._counts.all():
            first, second = self._steps / self._counts
            if 0 < first < second / self._SMOOTHER and self._steps[1] > _SMOOTH * self._distances:
                text = "varies much more smoothly along the first axis than along the second"
                yield Found("gt", 1, (), f"{text}: {self._message}")


class JointAxis(FirstAxis):
    """One sequence ``(T, J, C)`` of joints passed as ``(N, T, D)``."""

    name = "joints"
    _message = "(frames, joints, coordinates) of one sequence? Expected (sequences, frames, features): array[None]"

    @staticmethod
    def concerns(n_features: int) -> bool:
        """Return whether the last axis may hold the coordinates of a joint."""
        return n_features in _COORDINATES[:3]  # nine features may be three joints


class TimeFirst(FirstAxis):
    """Motion ``(T, N, ...)`` passed as ``(N, T, ...)``."""

    name = "axes"
    _message = "is time first? Expected (sequences, frames, features)"

    @staticmethod
    def concerns(n_features: int) -> bool:
        """Return whether the last axis holds more than one joint."""
        return not JointAxis.concerns(n_features)


class Degrees(Pitfall):
    """Angles in degrees."""

    name = "degrees"

    def __init__(self) -> None:
        self._largest: dict[str, Float64] = {}
        self._spread = {"gt": 0.0, "pred": 0.0}

    def see(self, block: Block) -> None:
        """Keep each feature's largest value, and add up the variances."""
        for argument, motion in block.named():
            largest = np.abs(motion).max(axis=(0, 1))
            self._largest[argument] = np.maximum(self._largest.get(argument, largest), largest)
            self._spread[argument] += float(motion.var(axis=1).sum())

    def found(self) -> Iterator[Found]:
        """Yield a finding if values, or movements compared with the other motion, are too large for radians."""
        for argument, largest in self._largest.items():
            moving = largest[largest > 0]
            if len(moving) and 4 * math.pi < np.median(moving) and np.quantile(moving, 0.9) <= 360:  # else positions
                yield Found(
                    argument,
                    1,
                    (int(np.argmax(largest)),),
                    f"values up to {largest.max():.4g}, beyond 4 pi in most features: degrees instead of radians, if "
                    f"these are angles",
                )
        gt, pred = math.sqrt(self._spread["gt"]), math.sqrt(self._spread["pred"])
        for argument, spread, other in (("pred", pred, gt), ("gt", gt, pred)):
            if other and 40 < spread / other < 80:
                message = f"moves {spread / other:.0f} times as far as the other: degrees beside radians?"
                yield Found(argument, 1, (), message)


class Poses(Pitfall):
    """Human3.6M poses that were not converted to Euler angles."""

    name = "poses"

    def __init__(self) -> None:
        self._root = {"gt": False, "pred": False}

    def see(self, block: Block) -> None:
        """Look for a root that moves."""
        if block.gt.shape[2] == POSE:
            for argument, motion in block.named():
                self._root[argument] |= bool(motion[..., :UNSCORED].any())

    def found(self) -> Iterator[Found]:
        """Yield a finding for each motion with a root among its 99 columns.

        If the ground truth has none, it is converted, and `powerless` says that the prediction moves more.
        """
        for argument, root in self._root.items():
            if root and self._root["gt"]:
                yield Found(
                    argument,
                    1,
                    (),
                    f"{POSE} columns, the first {UNSCORED} not zero: Human3.6M poses? npss.poses_to_euler, or "
                    f"npss score --expmap, converts them to Euler angles",
                )
