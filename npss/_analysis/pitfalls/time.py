"""Pitfalls of time: constant, shifted, left-in and padded frames."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
import numpy.typing as npt

from npss._analysis.pitfalls.pitfall import Block, Found, Mask, Pitfall, Tally
from npss.validation import Float64


class Constant(Pitfall):
    """Predictions that do not move."""

    name = "constant"

    def __init__(self) -> None:
        self._still = Tally()
        self._sequences = 0

    def see(self, block: Block) -> None:
        """Count the sequences, and those that move in the ground truth but not in the prediction."""
        moves = np.ptp(block.gt, axis=1).any(axis=1)
        self._still.add(block.top, moves & ~np.ptp(block.pred, axis=1).any(axis=1))
        self._sequences += len(moves)

    def found(self) -> Iterator[Found]:
        """Yield the number of predictions that stand still."""
        if self._still.count:
            yield Found(
                "pred",
                self._still.count,
                self._still.first,
                f"constant predictions (of {self._sequences} sequences); by 'paper', any constant pose scores the "
                f"same: T / 2 times the share of the ground truth's power that is not DC",
            )


class Shift(Pitfall):
    """A prediction that is the ground truth a few frames earlier or later, in all sequences or some."""

    name = "shift"
    _LAGS = (0, -1, 1, -2, 2)
    _FEWEST = 10  # frames; with fewer, a good start that drifts away is closer to the past by a factor of two
    # Ratios of distances. One sequence may be twice as close to the past by chance; all together hardly.
    _ALL, _ONE = 2, 4

    def __init__(self) -> None:
        self._squares: list[Float64] = []

    def see(self, block: Block) -> None:
        """Add up squared differences at each lag, over the frames common to all lags."""
        n_frames = block.gt.shape[1]
        if n_frames < self._FEWEST:
            return
        middle = block.pred[:, 2 : n_frames - 2]
        lagged = [block.gt[:, 2 + lag : n_frames - 2 + lag] for lag in self._LAGS]
        self._squares.append(np.array([np.square(middle - gt).sum(axis=(1, 2)) for gt in lagged]))

    def found(self) -> Iterator[Found]:
        """Yield the lag of all sequences, otherwise the lags of some."""
        if not self._squares:
            return
        squares = np.concatenate(self._squares, axis=1)  # (lags, N)
        together = squares.sum(axis=1)
        lag = int(together.argmin())
        if together[lag] < together[0] / self._ALL**2:
            yield Found("pred", squares.shape[1], (), self._message(lag, together[0], together[lag]))
            return
        best = squares.argmin(axis=0)
        for lag in range(1, len(self._LAGS)):
            where = np.flatnonzero((best == lag) & (squares[lag] < squares[0] / self._ONE**2))
            if where.size:
                message = self._message(lag, squares[0, where].sum(), squares[lag, where].sum())
                message += f", in {where.size} of {best.size} sequences"
                yield Found("pred", where.size, (int(where[0]),), message)

    def _message(self, lag: int, now: float, best: float) -> str:
        frames = abs(self._LAGS[lag])
        delay = f"{frames} frame{'s' * (frames > 1)} {'later' if self._LAGS[lag] > 0 else 'earlier'}"
        closer = f"is {math.sqrt(now / best):.3g} times closer to" if best else "is"
        return f"{closer} the ground truth {delay}"


class Context(Pitfall):
    """Frames that were given, not predicted: context or target frames left in the scored motion."""

    name = "context"
    _CLOSE = 1e-6  # of a feature's largest value: equal up to single precision

    def __init__(self) -> None:
        self._equal = np.array([2**62, 2**62])  # number of equal frames at the start and end of all sequences
        self._n_frames = 0

    def see(self, block: Block) -> None:
        """Count the equal frames at both ends; frames of zeros do not count."""
        self._n_frames = block.gt.shape[1]
        close = np.abs(block.pred - block.gt) <= self._CLOSE * np.abs(block.gt).max(axis=1, keepdims=True)
        equal: Mask = close.all(axis=2) & block.gt.any(axis=2)
        ends = [int(_leading(frames).min()) for frames in (equal, equal[:, ::-1])]
        self._equal = np.minimum(self._equal, ends)

    def found(self) -> Iterator[Found]:
        """Yield both ends, unless all frames are equal."""
        for count, end, name in zip(self._equal, ("first", "last"), ("context", "target"), strict=True):
            if 0 < count < self._n_frames:
                frames = "frame equals" if count == 1 else f"{count} frames equal"
                message = f"the {end} {frames} the ground truth's in all sequences: is the {name} left in?"
                yield Found("pred", int(count), (), message)


class Padding(Pitfall):
    """Sequences padded to a common length."""

    name = "padding"
    _FEWEST = 3  # equal frames

    def __init__(self) -> None:
        self._padded = Tally()
        self._least = 2**62

    def see(self, block: Block) -> None:
        """Count the sequences that move and end in equal frames in both motions."""
        gt, pred = (_leading((motion == motion[:, -1:]).all(axis=2)[:, ::-1]) for _, motion in block.named())
        padded = (gt < block.gt.shape[1]) & (np.minimum(gt, pred) >= self._FEWEST)
        self._padded.add(block.top, padded)
        if padded.any():
            self._least = min(self._least, int(np.minimum(gt, pred)[padded].min()))

    def found(self) -> Iterator[Found]:
        """Yield their number."""
        if self._padded.count:
            yield Found(
                "gt",
                self._padded.count,
                self._padded.first,
                f"sequences, and their predictions, end in {self._least} or more equal frames: padding? "
                f"It is scored as motion; pass lengths=",
            )


def _leading(mask: Mask) -> npt.NDArray[np.intp]:
    """Return the number of leading true values in each row."""
    leading: npt.NDArray[np.intp] = np.where(mask.all(axis=1), mask.shape[1], mask.argmin(axis=1))
    return leading
