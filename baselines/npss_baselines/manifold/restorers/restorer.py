"""The protocol of restorers."""

from __future__ import annotations

from typing import Protocol

import numpy as np

from npss.skeleton import Skeleton
from npss.validation import Float64
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.simple import with_lengths


class Restorer(Protocol):
    """A way to restore motion, which sees which values are known, and how noisy they are."""

    @property
    def signature(self) -> str:
        """The identity of the restorer, to the bit; part of the signature of numbers that depend on it."""

    def restore(self, left: Corrupted) -> Float64:
        """Restore motion.

        Parameters
        ----------
        left : Corrupted
            Motion ``(n, T, F)``, as features of `npss_baselines.manifold.motion.features`.

        Returns
        -------
        (n, T, F) ndarray of float64
            The restored motion. Known values without noise stay as they are.
        """


def with_bones(motion: Float64, left: Corrupted, skeleton: Skeleton) -> Float64:
    """Give bones that end in joints not seen exactly the skeleton's lengths, then put back what was seen exactly."""
    return np.where(left.exact, left.features, with_lengths(motion, left.exact, skeleton))
