"""The traps that `npss.diagnose` looks for: each sees the motion block by block, then says what it found."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from npss._checks import Float64

Mask = npt.NDArray[np.bool_]
#: What is found: in which argument, how often, where first, and what it means.
Found = tuple[str, int, tuple[int, ...], str]


class Block(NamedTuple):
    """Some sequences of both motions."""

    top: int  # index of the first sequence
    gt: Float64  # (n, T, D)
    pred: Float64  # (n, T, D)

    def named(self) -> Iterator[tuple[str, Float64]]:
        """Yield both motions with the names of the arguments."""
        yield "gt", self.gt
        yield "pred", self.pred


class Trap(ABC):
    """Something about motions that changes a score silently."""

    name: str

    @abstractmethod
    def see(self, block: Block) -> None:
        """Look at some more sequences."""

    @abstractmethod
    def found(self) -> Iterator[Found]:
        """Yield what was found in all of them."""


class _Tally:
    """How often something was seen, and where first."""

    def __init__(self) -> None:
        self.count = 0
        self.first: tuple[int, ...] = ()

    def add(self, top: int, where: Mask) -> None:
        if not self.count and where.any():
            index = np.unravel_index(int(np.argmax(where)), where.shape)
            self.first = (top + int(index[0]), *(int(i) for i in index[1:]))
        self.count += int(where.sum())


class _PlaceByPlace(Trap):
    """A trap that springs at single places of either motion."""

    meaning: str

    def __init__(self) -> None:
        self._tallies = {"gt": _Tally(), "pred": _Tally()}

    def see(self, block: Block) -> None:
        for argument, motion in block.named():
            self._tallies[argument].add(block.top, self.where(motion))

    def found(self) -> Iterator[Found]:
        for argument, tally in self._tallies.items():
            if tally.count:
                yield argument, tally.count, tally.first, self.meaning

    @abstractmethod
    def where(self, motion: Float64) -> Mask:
        """Return where it springs, ``(n, ...)``."""


class Wraps(_PlaceByPlace):
    """Angles that jump by a full turn, the joint standing still."""

    name = "wrap"
    meaning = "jumps of about 2 pi between frames, which change every score; npss.unwrap removes them"

    def where(self, motion: Float64) -> Mask:
        """Mark the frame (n, t, d) before each jump."""
        jumps = np.abs(np.abs(np.diff(motion, axis=1)) - 2 * math.pi) < 1
        angles = np.abs(motion).max(axis=1, keepdims=True) < 2.1 * math.pi  # larger values are no wrapped angles
        return np.asarray(jumps & angles)


class SignFlips(_PlaceByPlace):
    """Quaternions that change their sign, the rotation being the same."""

    name = "quaternion-sign"
    meaning = (
        "quaternions change sign between frames, which is the same rotation and another score: "
        "make q[t] . q[t + 1] positive first"
    )

    def where(self, motion: Float64) -> Mask:
        """Mark the frame and quaternion (n, t, d / 4) before each flip."""
        n, n_frames, d = motion.shape
        if d % 4:
            return np.zeros((n, 1), bool)
        quaternions = motion.reshape(n, n_frames, d // 4, 4)
        unit = (np.abs(np.square(quaternions).sum(axis=-1) - 1) < 1e-2).all(axis=1, keepdims=True)
        products = (quaternions[:, 1:] * quaternions[:, :-1]).sum(axis=-1)
        return np.asarray(unit & (products < -0.5))


class Constant(Trap):
    """Predictions that do not move."""

    name = "constant"

    def __init__(self) -> None:
        self._still = _Tally()
        self._sequences = 0

    def see(self, block: Block) -> None:
        """Count the sequences that move in the ground truth, and those of them that do not in the prediction."""
        moves = np.ptp(block.gt, axis=1).any(axis=1)
        self._still.add(block.top, moves & ~np.ptp(block.pred, axis=1).any(axis=1))
        self._sequences += len(moves)

    def found(self) -> Iterator[Found]:
        if self._still.count:
            yield (
                *("pred", self._still.count, self._still.first),
                f"constant predictions (of {self._sequences} sequences); by 'paper', whatever the pose, they all score "
                f"the same: T / 2 times the share of the ground truth's power that is not DC",
            )


class Shift(Trap):
    """A prediction that is the ground truth some frames earlier or later, in all sequences or in some."""

    name = "shift"
    _LAGS = (0, -1, 1, -2, 2)
    _FEWEST = 10  # frames; in fewer, what starts well and drifts away is closer to the past by a factor of two
    # How many times closer. One sequence may be twice as close to another's past by chance, all together hardly.
    _ALL, _ONE = 2, 4

    def __init__(self) -> None:
        self._squares: list[Float64] = []

    def see(self, block: Block) -> None:
        """Add up the squared difference at each lag, over the frames that all lags have."""
        n_frames = block.gt.shape[1]
        if n_frames < self._FEWEST:
            return
        middle = block.pred[:, 2 : n_frames - 2]
        lagged = [block.gt[:, 2 + lag : n_frames - 2 + lag] for lag in self._LAGS]
        self._squares.append(np.array([np.square(middle - gt).sum(axis=(1, 2)) for gt in lagged]))

    def found(self) -> Iterator[Found]:
        if not self._squares:
            return
        squares = np.concatenate(self._squares, axis=1)  # (lags, N)
        together = squares.sum(axis=1)
        lag = int(together.argmin())
        if together[lag] < together[0] / self._ALL**2:
            yield "pred", squares.shape[1], (), self._message(lag, together[0], together[lag])
            return
        best = squares.argmin(axis=0)
        for lag in range(1, len(self._LAGS)):
            where = np.flatnonzero((best == lag) & (squares[lag] < squares[0] / self._ONE**2))
            if where.size:
                message = self._message(lag, squares[0, where].sum(), squares[lag, where].sum())
                yield "pred", where.size, (int(where[0]),), f"{message}, in {where.size} of {best.size} sequences"

    def _message(self, lag: int, now: float, best: float) -> str:
        frames = abs(self._LAGS[lag])
        way = f"{frames} frame{'s' * (frames > 1)} {'later' if self._LAGS[lag] > 0 else 'earlier'}"
        closer = f"is {math.sqrt(now / best):.3g} times closer to" if best else "is"
        return f"{closer} the ground truth {way}"


class Degrees(Trap):
    """Angles in degrees."""

    name = "degrees"

    def __init__(self) -> None:
        self._largest: dict[str, Float64] = {}
        self._spread = {"gt": 0.0, "pred": 0.0}

    def see(self, block: Block) -> None:
        """Keep each feature's largest value, and add up how far all are from their means."""
        for argument, motion in block.named():
            largest = np.abs(motion).max(axis=(0, 1))
            self._largest[argument] = np.maximum(self._largest.get(argument, largest), largest)
            self._spread[argument] += float(motion.var(axis=1).sum())

    def found(self) -> Iterator[Found]:
        for argument, largest in self._largest.items():
            moving = largest[largest > 0]
            if len(moving) and 4 * math.pi < np.median(moving) < 1000:
                yield (
                    *(argument, 1, (int(np.argmax(largest)),)),
                    f"values up to {largest.max():.4g}, in most features beyond 4 pi: degrees, if these are angles, "
                    f"instead of radians",
                )
        gt, pred = math.sqrt(self._spread["gt"]), math.sqrt(self._spread["pred"])
        for argument, one, other in (("pred", pred, gt), ("gt", gt, pred)):
            if other and 40 < one / other < 80:
                yield argument, 1, (), f"moves {one / other:.0f} times as far as the other: degrees beside radians?"


class SwappedAxes(Trap):
    """Time where the features should be."""

    name = "axes"

    def __init__(self) -> None:
        self._sums = np.zeros((2, 2))  # along time and features: squared steps, squared distances from the mean

    def see(self, block: Block) -> None:
        if block.gt.shape[1] < 3:  # between two frames, all motion looks erratic
            return
        for row, axis in enumerate((1, 2)):
            steps = np.square(np.diff(block.gt, axis=axis)).sum()
            self._sums[row] += steps, block.gt.var(axis=axis).sum() * block.gt.shape[axis]

    def found(self) -> Iterator[Found]:
        # Steps of white noise are sqrt(2) times as large as its distances from the mean; those of motion much smaller.
        with np.errstate(invalid="ignore", divide="ignore"):
            along_time, along_features = self._sums[:, 0] / self._sums[:, 1]
        if along_time > 1 and along_features < 0.25:
            yield (
                *("gt", 1, ()),
                "varies smoothly along the last axis and erratically along the one before: is time last? "
                "Expected (sequences, frames, features)",
            )


class Powerless(Trap):
    """Features that count for nothing, since the ground truth has no power in them."""

    name = "powerless"

    def __init__(self) -> None:
        self._power: Mask | None = None
        self._predicted: Mask | None = None

    def see(self, block: Block) -> None:
        power, predicted = (np.asarray(motion.any(axis=(0, 1))) for _, motion in block.named())
        self._power = power if self._power is None else self._power | power
        self._predicted = predicted if self._predicted is None else self._predicted | predicted

    def found(self) -> Iterator[Found]:
        assert self._power is not None
        assert self._predicted is not None
        if not self._power.all():
            where = np.flatnonzero(~self._power)
            moved = int((self._predicted & ~self._power).sum())
            yield (
                *("gt", len(where), tuple(int(i) for i in where)),
                f"features (of {len(self._power)}) are zero throughout, so they do not count"
                + (f", though the prediction is not zero in {moved} of them" if moved else ""),
            )


class NoRealPower(Trap):
    """Predictions of which the released code sees rounding alone."""

    name = "no-real-power"

    def __init__(self) -> None:
        self._odd = _Tally()

    def see(self, block: Block) -> None:
        """Count the features of sequences that are circularly odd, such as a whole number of periods of a sine.

        As far as float32 tells: predictions are often computed in it.
        """
        even = block.pred + block.pred[:, -np.arange(block.pred.shape[1])]
        size = np.abs(block.pred).max(axis=1)
        self._odd.add(block.top, (np.abs(even).max(axis=1) < 1e-5 * size) & block.gt.any(axis=1))

    def found(self) -> Iterator[Found]:
        if self._odd.count:
            yield (
                *("pred", self._odd.count, self._odd.first),
                "features of sequences have a spectrum without real part: by 'released' they score rounding errors",
            )


TRAPS: tuple[type[Trap], ...] = (Wraps, SignFlips, Constant, Shift, Degrees, SwappedAxes, Powerless, NoRealPower)
