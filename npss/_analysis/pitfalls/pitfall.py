"""What a trap is: it sees the motion block by block, then says what it found."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from npss.rotations._poses import POSE, UNSCORED
from npss.validation import Float64

Mask = npt.NDArray[np.bool_]

#: Asks for something to be done before the score is believed.
WARNING = "warning"
#: Tells what is so, and right as it is.
NOTE = "note"


class Found(NamedTuple):
    """What is found: in which argument, how often, where first, what it means, and whether it asks for action."""

    argument: str
    number: int
    where: tuple[int, ...]
    message: str
    severity: str = WARNING


class Block(NamedTuple):
    """Some sequences of both motions."""

    top: int  # index of the first sequence
    gt: Float64  # (n, T, D)
    pred: Float64  # (n, T, D)

    def named(self) -> Iterator[tuple[str, Float64]]:
        """Yield both motions with the names of the arguments."""
        yield "gt", self.gt
        yield "pred", self.pred

    def as_published(self) -> bool:
        """Say whether both are laid out as `npss.poses_to_euler` returns poses: as the field scores Human3.6M."""
        return self.gt.shape[2] == POSE and not (self.gt[..., :UNSCORED].any() or self.pred[..., :UNSCORED].any())


class Trap(ABC):
    """Something about motions that changes a score silently."""

    name: str

    @abstractmethod
    def see(self, block: Block) -> None:
        """Look at some more sequences."""

    @abstractmethod
    def found(self) -> Iterator[Found]:
        """Yield what was found in all of them."""


class Tally:
    """How often something was seen, and where first."""

    def __init__(self) -> None:
        self.count = 0
        self.first: tuple[int, ...] = ()

    def add(self, top: int, where: Mask) -> None:
        """Count the places that are true, the sequences beginning at `top`."""
        if not self.count and where.any():
            index = np.unravel_index(int(np.argmax(where)), where.shape)
            self.first = (top + int(index[0]), *(int(i) for i in index[1:]))
        self.count += int(where.sum())
