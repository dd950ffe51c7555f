"""Interpolation in time, with bone lengths restored."""

from __future__ import annotations

from dataclasses import dataclass

from npss.skeleton import Skeleton
from npss.validation import Float64
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.simple import Way, interpolated
from npss_baselines.manifold.restorers.restorer import with_bones


@dataclass(frozen=True)
class Interpolation:
    """Interpolation of each feature in time, as a `Restorer`.

    Attributes
    ----------
    way : {'linear', 'pchip', 'hermite'}
        The way; see `npss_baselines.manifold.applications.simple.interpolated`.
    skeleton : Skeleton
        The skeleton, for the lengths of bones that end in joints not seen.

    Examples
    --------
    >>> import numpy as np
    >>> from npss_baselines.manifold.applications.corrupt import stepped_keys
    >>> from npss_baselines.manifold.motion.prepared import motion_set
    >>> walks = motion_set(quick=True).windows[:1]
    >>> restored = Interpolation("linear").restore(stepped_keys(walks, every=5))
    >>> bool(np.abs(restored - walks).mean() < 0.01)
    True
    """

    way: Way = "linear"
    skeleton: Skeleton = JOINTS

    @property
    def signature(self) -> str:
        """The way."""
        return f"{self.way}-with-lengths"

    def restore(self, left: Corrupted) -> Float64:
        """Restore motion; see `Restorer`."""
        return with_bones(interpolated(left, self.way), left, self.skeleton)
