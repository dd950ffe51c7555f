"""What each step of a training of the manifold is of: a phase, an epoch, and a chunk of batches."""

from __future__ import annotations

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass

from npss_baselines.manifold.training.config import Phase

#: Windows, about, of one step of Lightning: a chunk of batches, because its own work would take longer than the paper's
#: batches of a single window. What is random in a chunk is drawn from the seed, the phase and the number of the chunk.
CHUNK = 256


@dataclass(frozen=True)
class Place:
    """Where training is."""

    phase: int
    epoch: int
    chunk: int  # of the epoch


class Schedule:
    """What each chunk of a run is of.

    Parameters
    ----------
    phases : sequence of Phase
        What training does.
    n_windows : int
        That are trained on.
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
        """Return where a chunk is, counted from 0."""
        phase = next(i for i, end in enumerate(self._ends) if step < end)
        epoch, chunk = divmod(step - (self._ends[phase - 1] if phase else 0), self.chunks[phase])
        return Place(phase, epoch, chunk)
