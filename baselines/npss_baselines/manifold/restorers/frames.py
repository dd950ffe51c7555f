"""Training frames at random times, of mirror images, too."""

from __future__ import annotations

from collections import Counter

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Seed, generator
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.mirror import mirror_image
from npss_baselines.manifold.motion.scaling import Scaling
from npss_baselines.manifold.restorers.net import Float32

Indices = npt.NDArray[np.intp]


class Frames:
    """The scaled frames of all clips and of their mirror images, one after the other.

    Frames of different clips are nearly independent; those of one window are not. Hence training draws frames, each at
    a time of its own. Sources are drawn in proportion to the root of their number of frames, so that the largest does
    not outweigh the others.

    Parameters
    ----------
    motions : MotionSet
        The clips.
    scaling : Scaling
        The scaling of the features.
    skeleton : Skeleton
        The skeleton of the motion.
    """

    def __init__(self, motions: MotionSet, scaling: Scaling, skeleton: Skeleton) -> None:
        images = [image for clip in motions.features for image in (clip, mirror_image(clip, skeleton))]
        lengths = np.array([len(image) for image in images])
        ends = np.cumsum(lengths)
        self.scaled: Float32 = scaling.normalize(np.concatenate(images)).astype(np.float32)
        self.first: Indices = np.repeat(ends - lengths, lengths)  # the first frame of each frame's clip
        self.last: Indices = np.repeat(ends - 1, lengths)
        sources = np.repeat([clip.source for clip in motions.clips], 2)
        counts: Counter[str] = Counter()
        for source, length in zip(sources, lengths, strict=True):
            counts[source] += int(length)
        weight = np.repeat([counts[source] ** -0.5 for source in sources], lengths)
        self._cumulative = np.cumsum(weight)

    def draw(self, n: int, seed: Seed) -> Indices:
        """Draw frames."""
        at = generator(seed).random(n) * self._cumulative[-1]
        drawn: Indices = np.searchsorted(self._cumulative, at, side="right").clip(max=len(self.scaled) - 1)
        return drawn

    def around(self, frames: Indices, offsets: npt.ArrayLike) -> Float32:
        """Return the frames ``(n, offsets, F)`` around some, at most to the ends of the clip."""
        wanted = frames[:, np.newaxis] + np.asarray(offsets)
        inside = np.clip(wanted, self.first[frames, np.newaxis], self.last[frames, np.newaxis])
        taken: Float32 = self.scaled[inside]
        return taken
