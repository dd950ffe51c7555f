"""Kernel ridge regression of missing features on the known ones of the same frame."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss.skeleton import Skeleton
from npss.validation import Float64, Seed, generator, one_of
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.motion.scaling import Scaling, fit_scaling
from npss_baselines.manifold.restorers.digest import digest_of
from npss_baselines.manifold.restorers.restorer import with_bones

#: Training frames, the kernel's width in units of the median distance of two frames, and the ridge: the best on
#: validation subjects, where features of a kind have the same scale, and where each has its own.
FRAMES, SETTINGS = 4000, {"kind": (1.6, 0.03), "feature": (1.2, 0.03)}
#: The largest number of sets of known features: each costs a system of equations.
MOST_SETS = 16


@dataclass(frozen=True, eq=False)
class KernelRidge:
    """Kernel ridge regression with a Gaussian kernel, as a `Restorer` of joints that are missing for a long time.

    It keeps training frames, which are motion: it is for comparison, and is never stored.

    Attributes
    ----------
    frames : (N, F) ndarray
        Scaled training frames.
    scaling : Scaling
        The scaling of the features.
    width, ridge : float
        The kernel's width, in units of the median distance of two training frames; and what is added to its diagonal.
    skeleton : Skeleton
        The skeleton, for the lengths of bones that end in joints not seen.
    """

    frames: Float64
    scaling: Scaling
    width: float
    ridge: float
    skeleton: Skeleton = JOINTS

    @property
    def signature(self) -> str:
        """The identity of the training frames and settings."""
        return f"kernel-ridge-{self.width:g}-{self.ridge:g}-{digest_of(self.frames)}"

    def restore(self, left: Corrupted) -> Float64:
        """Restore motion; see `Restorer`.

        Raises
        ------
        ValueError
            If frames have more than `MOST_SETS` different sets of known features.
        """
        rows = self.scaling.normalize(left.features).reshape(-1, left.features.shape[-1])
        sets, which = np.unique(left.known.reshape(rows.shape), axis=0, return_inverse=True)
        if len(sets) > MOST_SETS:
            raise ValueError(
                f"left: frames have {len(sets)} different sets of known features; kernel ridge regression takes at "
                f"most {MOST_SETS}, since each costs a system of equations"
            )
        for number, known in enumerate(sets):
            chosen = which.reshape(-1) == number
            if known.all():
                continue
            if not known.any():
                rows[chosen] = 0
                continue
            given, asked = self.frames[:, known], self.frames[:, ~known]
            mean = asked.mean(axis=0)
            squares = _squares(given, given)
            width = self.width**2 * np.median(squares)
            kernel = np.exp(-squares / width)
            kernel[np.diag_indices(len(kernel))] += self.ridge
            weights = np.linalg.solve(kernel, asked - mean)
            at = np.flatnonzero(chosen)
            for part in np.array_split(at, max(1, len(at) // 4096)):
                similar = np.exp(-_squares(rows[np.ix_(part, known)], given) / width)
                rows[np.ix_(part, ~known)] = mean + similar @ weights
        restored = self.scaling.unnormalize(rows).reshape(left.features.shape)
        return with_bones(np.where(left.known, left.features, restored), left, self.skeleton)


def fit_kernel_ridge(
    windows: npt.ArrayLike, mask: npt.NDArray[np.bool_], *, scale: str = "kind", frames: int = FRAMES, seed: Seed = 0
) -> KernelRidge:
    """Draw the training frames of kernel ridge regression from windows ``(n, T, F)``, of frames in the mask.

    Features of a kind have the same scale, or each feature has its own; see
    `npss_baselines.manifold.motion.scaling.fit_scaling`.
    """
    one_of("scale", scale, tuple(SETTINGS))
    scaling = fit_scaling(windows, mask, scale)
    rows = np.asarray(windows)[mask]
    chosen = np.sort(generator(seed).permutation(len(rows))[:frames])
    return KernelRidge(scaling.normalize(rows[chosen]), scaling, *SETTINGS[scale])


def _squares(first: Float64, second: Float64) -> Float64:
    """Return the squared distances of all pairs of rows."""
    squares: Float64 = (
        np.square(first).sum(axis=1)[:, np.newaxis] + np.square(second).sum(axis=1) - 2 * first @ second.T
    )
    return np.maximum(squares, 0, out=squares)
