"""The applications that restore motion: what is left of it, and what can be made of that without a manifold."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array, Float64, Seed, generator, one_of
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications import corrupt
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.motion.windows import windows_of

#: The applications, each with what is done to the motion that is to be restored.
RESTORATIONS = {
    "project": "nothing",
    "repair": f"values lost with probability {corrupt.LOST:g}",
    "kinect": (
        f"simulated camera, jitter {corrupt.JITTER:g} and {corrupt.TURN_JITTER:g} rad, drop-outs {corrupt.DROP:g} of "
        f"{corrupt.SPELL} frames, a limb occluded for {corrupt.OCCLUDED:g}"
    ),
    "fill": "right wrist and hand missing",
    "inbetween": f"every {corrupt.EVERY}th frame held",
}
#: Where it is worth while to project what `rescaled` returns: each value is as likely to be lost as any other.
LOST_AT_RANDOM = ("repair",)
#: The joint that `fill` does without, and all that hangs on it.
WRIST = "RightHand"


@dataclass(frozen=True)
class Windows:
    """Windows of motion, and which of their frames count.

    Attributes
    ----------
    features : (n, T, F) ndarray
        As of `npss_baselines.manifold.motion.features`.
    mask : (n, T) ndarray of bool
        False at the end of a window that is padded by mirroring.
    """

    features: Array
    mask: npt.NDArray[np.bool_]


def corrupted(
    application: str, windows: Windows, mean: npt.ArrayLike, *, skeleton: Skeleton = JOINTS, seed: Seed = 0
) -> Corrupted:
    """Corrupt windows as one of the applications wants it.

    Padding is mirrored anew from what is left: it tells nothing that has been lost elsewhere.

    Parameters
    ----------
    application : {'project', 'repair', 'kinect', 'fill', 'inbetween'}
        Which; see `RESTORATIONS` and `npss_baselines.manifold.applications.corrupt`.
    windows : Windows
        The motion.
    mean : (F,) array_like
        What lost values become: the mean over training frames, which networks see as zero.
    skeleton : npss.skeleton.Skeleton, optional
        Whose joints they are.
    seed : int or numpy.random.Generator, optional
        Of what is random.

    Returns
    -------
    Corrupted
        What is left.

    Raises
    ------
    TypeError, ValueError
        If an argument is not as described.
    """
    one_of("application", application, tuple(RESTORATIONS))
    rng = generator(seed)
    if application == "project":
        whole = np.asarray(windows.features, np.float64)
        return Corrupted(whole, np.ones(whole.shape, bool))
    if application == "repair":
        left = corrupt.zeros(windows.features, mean, seed=rng)
    elif application == "kinect":
        left = corrupt.kinect(windows.features, skeleton, seed=rng)
    elif application == "fill":
        left = corrupt.missing(windows.features, mean, joints=corrupt.branch(skeleton, WRIST))
    else:
        left = corrupt.stepped_keys(windows.features)
    return Corrupted(_padded(left.features, windows.mask), _padded(left.known, windows.mask))


def linear(left: Corrupted) -> Float64:
    """Interpolate linearly in time between known values, ``(n, T, F)``, feature by feature.

    Before the first and behind the last known value it is held. A feature that is never known stays as it is. It is an
    oracle that knows which values are lost; the manifold does not.
    """
    filled = left.features.copy()
    frames = np.arange(filled.shape[1])
    for window, feature in np.argwhere(left.known.any(axis=1) & ~left.known.all(axis=1)):
        known = left.known[window, :, feature]
        filled[window, ~known, feature] = np.interp(frames[~known], frames[known], filled[window, known, feature])
    return filled


def rescaled(left: Corrupted, mean: npt.ArrayLike) -> Float64:
    """Divide what is left ``(n, T, F)`` by the share that is known: right on average, if values are lost at random.

    Of a window of which nothing is known, the mean is left.

    Parameters
    ----------
    left : Corrupted
        Windows; lost values are the mean.
    mean : (F,) array_like
        The mean over training frames, from which values are taken to be further away than they are.

    Returns
    -------
    (n, T, F) ndarray of float64
        Neither known values nor others are what they were; a window's average deviation from the mean is.

    Examples
    --------
    >>> left = Corrupted(np.array([[[3.0, 1.0]]]), np.array([[[True, False]]]))
    >>> rescaled(left, [1.0, 1.0])
    array([[[5., 1.]]])
    """
    share = left.known.mean(axis=(1, 2), keepdims=True)
    centre = np.asarray(mean, np.float64)
    motion: Float64 = centre + (left.features - centre) / np.where(share > 0, share, 1.0)
    return motion


def keep_known(left: Corrupted, motion: Array) -> Array:
    """Return motion ``(n, T, F)`` with the values that were seen put back."""
    kept: Array = np.where(left.known, left.features, motion)
    return kept


def _padded(values: Array, mask: npt.NDArray[np.bool_]) -> Array:
    """Return windows with their padding mirrored from the frames that count."""
    mirrored = values.copy()
    for i in np.flatnonzero(~mask.all(axis=1)):
        mirrored[i] = windows_of(values[i, mask[i]].astype(np.float64), window=values.shape[1])[0][0]
    return mirrored
