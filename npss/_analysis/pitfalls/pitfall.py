"""The interface of a pitfall: it sees the motion block by block, then yields findings."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from npss._metric.convention import CONVENTIONS, Convention
from npss.rotations._poses import POSE, UNSCORED
from npss.validation import Float64

Mask = npt.NDArray[np.bool_]

#: Something must be done, or known, before the score is believed.
WARNING = "warning"
#: Nothing needs to be done.
NOTE = "note"


class Found(NamedTuple):
    """A finding of one pitfall: the argument, the number of places, the first place, the message, the severity."""

    argument: str
    number: int
    where: tuple[int, ...]
    message: str
    severity: str = WARNING


class Block(NamedTuple):
    """Consecutive sequences of both motions."""

    top: int  # index of the first sequence
    gt: Float64  # (n, T, D)
    pred: Float64  # (n, T, D)
    convention: Convention = CONVENTIONS["paper"]  # of the score

    def named(self) -> Iterator[tuple[str, Float64]]:
        """Yield both motions with the names of the arguments."""
        yield "gt", self.gt
        yield "pred", self.pred

    def as_published(self) -> bool:
        """Return whether both are laid out as by `npss.poses_to_euler`: as the field scores Human3.6M."""
        return self.gt.shape[2] == POSE and not (self.gt[..., :UNSCORED].any() or self.pred[..., :UNSCORED].any())


class Pitfall(ABC):
    """A property of motions that changes a score silently."""

    name: str

    @abstractmethod
    def see(self, block: Block) -> None:
        """Look at the next sequences."""

    @abstractmethod
    def found(self) -> Iterator[Found]:
        """Yield the findings in all sequences."""


class Tally:
    """A count of places, and the first place."""

    def __init__(self) -> None:
        self.count = 0
        self.first: tuple[int, ...] = ()

    def add(self, top: int, where: Mask) -> None:
        """Count the places that are true; the first sequence has index `top`."""
        if not self.count and where.any():
            index = np.unravel_index(int(np.argmax(where)), where.shape)
            self.first = (top + int(index[0]), *(int(i) for i in index[1:]))
        self.count += int(where.sum())
