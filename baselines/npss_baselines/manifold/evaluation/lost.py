"""The error of restored motion where something was lost, and its ratio to that of the best simple baseline."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

import npss
from npss.validation import Array, Float64
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.motion.features import local_positions


class Lost(NamedTuple):
    """Sums of windows.

    Attributes
    ----------
    distances : (n,) ndarray of float64
        The sum of each window's distances of restored joints from the truth, in body heights.
    counts : (n,) ndarray of int
        Their number.
    """

    distances: Float64
    counts: npt.NDArray[np.intp]

    @property
    def error(self) -> float:
        """The mean distance."""
        return float(self.distances.sum() / self.counts.sum())


def lost_error(truth: Array, restored: Array, left: Corrupted, mask: npt.NDArray[np.bool_]) -> Lost:
    """Compute the error of joints of which a coordinate was lost or noisy.

    Parameters
    ----------
    truth, restored : (n, T, F) ndarray
        Features.
    left : Corrupted
        What was left of them.
    mask : (n, T) ndarray of bool
        Frames that count.

    Returns
    -------
    Lost
        The distances of joints in the character's frame, wherever a coordinate of the joint was not seen exactly.
    """
    distances = np.linalg.norm(local_positions(restored) - local_positions(truth), axis=-1)  # (n, T, J)
    counted = ~local_positions(left.exact.astype(float)).all(axis=-1) & mask[..., np.newaxis]
    return Lost((distances * counted).sum(axis=(1, 2)), counted.sum(axis=(1, 2)))


class Ratio(NamedTuple):
    """A ratio of errors.

    Attributes
    ----------
    value, low, high : float
        The ratio, and the ends of its paired interval of 95 %, or the lowest and highest ratio of a clip if there are
        fewer than ten.
    clips : int
        The number of clips, which are the blocks.
    """

    value: float
    low: float
    high: float
    clips: int


def ratio(first: Lost, second: Lost, clips: Sequence[str] | npt.NDArray[np.str_]) -> Ratio:
    """Return the ratio of two errors on the same windows, whose clips are named."""
    low, high = npss.ratio_interval(first.distances, second.distances, groups=[str(clip) for clip in clips])
    return Ratio(first.error / second.error, low, high, len(set(clips)))


def best_of(errors: Mapping[str, Lost], names: Sequence[str]) -> str:
    """Return the name with the smallest error."""
    return min((name for name in names if name in errors), key=lambda name: errors[name].error)


def by_subject(subjects: Sequence[str]) -> Iterator[tuple[str, npt.NDArray[np.bool_]]]:
    """Yield ``all`` and each subject, with the windows that count."""
    names = np.asarray(subjects)
    yield "all", np.ones(len(names), bool)
    for subject in sorted(set(subjects)):
        yield subject, names == subject


def only(errors: Lost, chosen: npt.NDArray[np.bool_]) -> Lost:
    """Select windows."""
    return Lost(errors.distances[chosen], errors.counts[chosen])
