"""Restore frames of which nothing is known from the keys around: the two before and the two after.

Networks correct a cubic through the keys, whose slopes are those of the parabola through three of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array, Float64
from npss_baselines.manifold.applications.simple import with_lengths
from npss_baselines.manifold.motion.mirror import mirror_image
from npss_baselines.manifold.motion.scaling import Scaling
from npss_baselines.manifold.restorers.net import Float32, Net, mean_of

#: The unit of times, in frames.
UNIT = 15.0
#: Added to the motion of keys, in scaled units: corrections of slower motion are small.
STILL = 0.02
#: The furthest distance from a key, in frames, that networks are trained on.
FURTHEST = 25


@dataclass(frozen=True, eq=False)
class Keys:
    """Networks that correct a cubic through keys.

    Attributes
    ----------
    scaling : Scaling
        The scaling of the features.
    nets : tuple of Net
        Networks; their mean, times `amount_of`, corrects the cubic.
    """

    scaling: Scaling
    nets: tuple[Net, ...]

    def restore(self, motion: Float64, known: npt.NDArray[np.bool_], skeleton: Skeleton) -> Float64:
        """Restore the frames of motion ``(T, F)`` that are not ``known`` (T,): those far from all keys stay at one."""
        keys, asked = np.flatnonzero(known), np.flatnonzero(~known)
        if not len(keys) or not len(asked):
            return motion
        after = np.searchsorted(keys, asked)
        numbers = after[:, np.newaxis] + np.array([-2, -1, 0, 1])
        there = (numbers >= 0) & (numbers < len(keys))
        frames = keys[np.clip(numbers, 0, len(keys) - 1)]
        times = (frames - asked[:, np.newaxis]).astype(np.float64)
        first, second = (
            self._restored(self.scaling.normalize(image[frames]), times, there)
            for image in (motion, mirror_image(motion, skeleton))
        )
        restored = motion.copy()
        restored[asked] = (first + mirror_image(second, skeleton)) / 2
        possible: Float64 = with_lengths(
            restored[np.newaxis], np.broadcast_to(known[:, np.newaxis], motion.shape)[np.newaxis], skeleton
        )[0]
        return possible

    def _restored(self, keys: Float64, times: Float64, there: npt.NDArray[np.bool_]) -> Float64:
        curve = cubic(keys, times, there)
        change = mean_of(self.nets, inputs_of(keys, curve, times, there))
        return self.scaling.unnormalize(curve + amount_of(keys, times, there) * change)


def cubic(keys: Array, times: Float64, there: npt.NDArray[np.bool_]) -> Float64:
    """Return the value at time 0 of the cubic through the second and the third of four keys.

    Its slopes are those of the parabola through three keys, or of the line where only two exist; where there is no key
    on one side, the nearest is held.

    Parameters
    ----------
    keys : (n, 4, F) ndarray
        Values of keys.
    times : (n, 4) ndarray
        Their times, in order, the first two before 0 and the others after.
    there : (n, 4) ndarray of bool
        False for keys that do not exist, whose values do not count.
    """
    before, after = there[:, :1], there[:, 3:]
    with np.errstate(divide="ignore", invalid="ignore"):  # of keys that do not exist
        gaps = np.diff(times, axis=1)[..., np.newaxis]
        slopes = np.diff(keys, axis=1) / gaps
        first, second = np.moveaxis((slopes[:, 1:] - slopes[:, :-1]) / (gaps[:, 1:] + gaps[:, :-1]), 1, 0)
        gap, middle, u = gaps[:, 1], slopes[:, 1], -times[:, 1:2] / gaps[:, 1]
        # The second derivatives of the two parabolas, halved; of the other, or of a line, where a key does not exist.
        at_left = middle - gap * np.where(before, first, np.where(after, second, 0))
        at_right = middle + gap * np.where(after, second, np.where(before, first, 0))
        value = (
            keys[:, 1] * (1 + 2 * u) * (1 - u) ** 2
            + keys[:, 2] * u**2 * (3 - 2 * u)
            + gap * u * (1 - u) * ((1 - u) * at_left - u * at_right)
        )
    held = np.where(there[:, 1:2], keys[:, 1], keys[:, 2])
    both: Float64 = np.where(there[:, 1:3].all(axis=1, keepdims=True), value, held)
    return both


def moved(keys: Array, there: npt.NDArray[np.bool_]) -> Float64:
    """Return the root mean square ``(n, 1)`` of differences of keys ``(n, 4, F)`` from the nearest before, or after."""
    nearest = np.where(there[:, 1:2], keys[:, 1], keys[:, 2])
    squares = np.square(keys - nearest[:, np.newaxis]).mean(axis=2) * there
    size: Float64 = np.sqrt(squares.sum(axis=1) / np.maximum(there.sum(axis=1) - 1, 1)) + STILL
    return size[:, np.newaxis]


def amount_of(keys: Array, times: Float64, there: npt.NDArray[np.bool_]) -> Float64:
    """Return the size of corrections ``(n, 1)``: small near a key and in slow motion, none beyond twice `FURTHEST`."""
    away = np.where(there, np.abs(times), np.inf)[:, 1:3].min(axis=1)
    share: Float64 = np.clip(0.015 * away**1.5, 0.005, 1.0) * np.clip(2 - away / FURTHEST, 0, 1)
    return share[:, np.newaxis] * moved(keys, there)


def inputs_of(keys: Array, curve: Float64, times: Float64, there: npt.NDArray[np.bool_]) -> Float32:
    """Return what the networks see: differences of keys, relative to their size, the cubic, times, and which exist."""
    n = len(keys)
    size = moved(keys, there)
    nearest = np.where(there[:, 1:2], keys[:, 1], keys[:, 2])
    differences = np.where(there[..., np.newaxis], keys - nearest[:, np.newaxis], 0) / size[..., np.newaxis]
    when = np.where(there, times, 0) / UNIT
    gap = np.where(there[:, 1:3].all(axis=1), times[:, 2] - times[:, 1], UNIT)
    share = np.where(there[:, 1], -times[:, 1], 0) / gap
    waves = [np.sin(np.pi * share), np.sin(2 * np.pi * share), share, gap / UNIT]
    parts = [
        nearest,
        differences.reshape(n, -1),
        (curve - nearest) / size,
        np.log(size),
        when,
        np.stack(waves, 1),
        there,
    ]
    return np.concatenate(parts, axis=1).astype(np.float32)
