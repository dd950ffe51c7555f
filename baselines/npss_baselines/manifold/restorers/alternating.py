"""Projection onto a manifold and known values in turn."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from npss.skeleton import Skeleton
from npss.validation import Float64
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.model.projector import Projector
from npss_baselines.manifold.restorers.restorer import with_bones

#: The number of rounds: few, since an autoencoder can drift.
ROUNDS = 2


@dataclass(frozen=True, eq=False)
class Alternating:
    """A projector, told what is known, as a `Restorer`.

    In each round, motion is projected, and known values are put back. Noisy values are only put back before the last
    projection.

    Attributes
    ----------
    projector : Projector
        The manifold.
    rounds : int
        The number of rounds.
    skeleton : Skeleton
        The skeleton, for the lengths of bones that end in joints not seen exactly.
    """

    projector: Projector
    rounds: int = ROUNDS
    skeleton: Skeleton = JOINTS

    @property
    def signature(self) -> str:
        """The identity of the manifold, and the rounds."""
        return f"{self.projector.signature}-alternating-{self.rounds}"

    def restore(self, left: Corrupted) -> Float64:
        """Restore motion; see `Restorer`."""
        motion = left.features
        for _ in range(self.rounds):
            motion = self.projector.project(np.where(left.known, left.features, motion))
        return with_bones(np.asarray(motion, np.float64), left, self.skeleton)
