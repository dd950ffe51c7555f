"""The conditional mean of a Gaussian, with bone lengths restored."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from npss.skeleton import Skeleton
from npss.validation import Float64
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.model.gaussian import SpanGaussian
from npss_baselines.manifold.restorers.restorer import with_bones


@dataclass(frozen=True, eq=False)
class Conditional:
    """A Gaussian of a few frames, given the known values, as a `Restorer`.

    With a span of one frame, the mean is that of ridge regression on the known values of the frame.

    Attributes
    ----------
    gaussian : SpanGaussian
        The distribution.
    skeleton : Skeleton
        The skeleton, for the lengths of bones that end in joints not seen exactly.
    """

    gaussian: SpanGaussian
    skeleton: Skeleton = JOINTS

    @property
    def signature(self) -> str:
        """The identity of the distribution, to the bit."""
        return f"{self.gaussian.signature}-with-lengths"

    def restore(self, left: Corrupted) -> Float64:
        """Restore motion; see `Restorer`. Motion shorter than a span is mirrored at its end."""
        n_frames, span = left.features.shape[1], self.gaussian.span
        if span == 1:
            frames = (-1, 1, left.features.shape[2])
            restored = self.gaussian.restore(
                left.features.reshape(frames), left.known.reshape(frames), noise=left.noise
            )
            return with_bones(restored.reshape(left.features.shape), left, self.skeleton)
        longer = ((0, 0), (0, max(0, span - n_frames)), (0, 0))
        features, known = (np.pad(values, longer, mode="symmetric") for values in (left.features, left.known))
        restored = self.gaussian.restore(features, known, noise=left.noise)
        return with_bones(restored[:, :n_frames], left, self.skeleton)
