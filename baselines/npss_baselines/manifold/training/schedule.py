"""The schedule of training: the phase, epoch and chunk of batches of each step."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from npss_baselines.manifold.training.config import Phase

#: Approximate number of windows in a step of Lightning. A step is a chunk of batches, since Lightning's overhead
#: exceeds the work on one of the paper's batches of a single window. The seed, the phase and the chunk's number fix all
#: random choices in a chunk.
CHUNK = 256


@dataclass(frozen=True)
class Place:
    """A position in training."""

    phase: int
    epoch: int
    chunk: int  # in the epoch


class Schedule:
    """The place of each chunk of a run.

    Parameters
    ----------
    phases : sequence of Phase
        The phases of training.
    n_windows : int
        Number of training windows.
    """

    def __init__(self, phases: Sequence[Phase], n_windows: int) -> None:
        self._n_windows = n_windows
        self.batches = [math.ceil(n_windows / phase.stage.batch) for phase in phases]
        self.chunk = [max(1, CHUNK // phase.stage.batch) for phase in phases]  # batches
        self.chunks = [math.ceil(batches / chunk) for batches, chunk in zip(self.batches, self.chunk, strict=True)]
        epochs = [phase.stage.epochs for phase in phases]
        self._ends = list(itertools.accumulate(chunks * n for chunks, n in zip(self.chunks, epochs, strict=True)))

    def __len__(self) -> int:
        """Return the number of chunks."""
        return self._ends[-1]

    def __getitem__(self, step: int) -> Place:
        """Return the place of a chunk, counted from 0."""
        phase = next(i for i, end in enumerate(self._ends) if step < end)
        epoch, chunk = divmod(step - (self._ends[phase - 1] if phase else 0), self.chunks[phase])
        return Place(phase, epoch, chunk)
