"""Applications that restore corrupted motion, and baselines without a manifold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Array, Float64, Seed, generator, one_of
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications import corrupt
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.motion.windows import windows_of

#: The applications, each with its corruption of the motion.
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
#: Applications where all values are equally likely to be lost, so that `rescaled` motion is worth projecting.
LOST_AT_RANDOM = ("repair",)
#: The joint that `fill` removes, with all joints below it.
WRIST = "RightHand"
#: The same with other joints, for evaluation: each other limb's end, and two limbs at once.
FILLS = (("LeftHand",), ("LeftFoot",), ("RightFoot",), ("LeftHand", "RightHand"), ("LeftFoot", "RightHand"))


@dataclass(frozen=True)
class Windows:
    """Windows of motion, and which of their frames count.

    Attributes
    ----------
    features : (n, T, F) ndarray
        Features as in `npss_baselines.manifold.motion.features`.
    mask : (n, T) ndarray of bool
        False in the padding of a window.
    """

    features: Array
    mask: npt.NDArray[np.bool_]


def corrupted(
    application: str,
    windows: Windows,
    mean: npt.ArrayLike,
    *,
    joints: Sequence[str] = (WRIST,),
    skeleton: Skeleton = JOINTS,
    seed: Seed = 0,
) -> Corrupted:
    """Corrupt windows for one of the applications.

    Padding is mirrored again from the corrupted frames, so that it does not reveal lost values.

    Parameters
    ----------
    application : {'project', 'repair', 'kinect', 'fill', 'inbetween'}
        The application; see `RESTORATIONS` and `npss_baselines.manifold.applications.corrupt`.
    windows : Windows
        The motion.
    mean : (F,) array_like
        Replacement of lost values: the average over training frames, which scaling maps to zero.
    joints : sequence of str, optional
        The joints that ``fill`` removes, with all joints below them.
    skeleton : npss.skeleton.Skeleton, optional
        The skeleton of the motion.
    seed : int or numpy.random.Generator, optional
        Source of randomness.

    Returns
    -------
    Corrupted
        The corrupted windows.

    Raises
    ------
    TypeError, ValueError
        If an argument is invalid.
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
        below = sorted({below for joint in joints for below in corrupt.branch(skeleton, joint)})
        left = corrupt.missing(windows.features, mean, joints=below)
    else:
        left = corrupt.stepped_keys(windows.features)
    return replace(left, features=_padded(left.features, windows.mask), known=_padded(left.known, windows.mask))


def rescaled(left: Corrupted, mean: npt.ArrayLike) -> Float64:
    """Divide deviations from the mean, ``(n, T, F)``, by the share of known values.

    This is unbiased if values are lost at random. A window without known values does not change.

    Parameters
    ----------
    left : Corrupted
        Windows whose lost values are the mean.
    mean : (F,) array_like
        The average over training frames.

    Returns
    -------
    (n, T, F) ndarray of float64
        Rescaled windows. Known values change, too; the expected deviation from the mean is that of the original.

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
    """Replace known values in motion ``(n, T, F)`` by the given ones."""
    kept: Array = np.where(left.known, left.features, motion)
    return kept


def _padded(values: Array, mask: npt.NDArray[np.bool_]) -> Array:
    """Mirror the padding of windows from the frames that count."""
    mirrored = values.copy()
    for i in np.flatnonzero(~mask.all(axis=1)):
        mirrored[i] = windows_of(values[i, mask[i]].astype(np.float64), window=values.shape[1])[0][0]
    return mirrored
