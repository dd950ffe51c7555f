"""The number of principal components that restores best, for a strong baseline of the manifold."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from npss.skeleton import Skeleton
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.restore import LOST_AT_RANDOM, Windows, corrupted, rescaled
from npss_baselines.manifold.model.pca import PCA, fit_pca
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.features import local_positions
from npss_baselines.manifold.motion.measures import joint_error
from npss_baselines.manifold.motion.scaling import Scaling

#: To choose a size, every third training subject is set aside, and up to `LARGEST` of their windows are used.
EVERY, LARGEST = 3, 100
#: All components: a number larger than any window has.
ALL = 2**20


class Restoration(NamedTuple):
    """An application, and its variant for PCA."""

    application: str
    rescaled: bool = False  # whether windows are rescaled before projection


def truncated(fitted: PCA, size: int) -> PCA:
    """Return a PCA with the first `size` components."""
    return replace(fitted, components=fitted.components[:size])


def best_sizes(
    training: MotionSet,
    scaling: Scaling,
    applications: Sequence[str],
    *,
    skeleton: Skeleton = JOINTS,
    seed: int = 0,
) -> dict[Restoration, int]:
    """Choose the number of components with the smallest joint error on training subjects set aside from the fit.

    Candidates are powers of two and all components.

    Parameters
    ----------
    training : MotionSet
        Motion of at least two subjects; clips of unknown subjects count as one subject.
    scaling : Scaling
        Scaling of the features; its mean replaces lost values.
    applications : sequence of str
        Names in `npss_baselines.manifold.applications.restore.RESTORATIONS`.
    skeleton : npss.skeleton.Skeleton, optional
        The skeleton of the motion.
    seed : int, optional
        Seed of the corruptions.

    Returns
    -------
    dict of Restoration to int
        The best number for each application, also rescaled where values are lost at random. `ALL` means all components.
        Empty for a single subject.
    """
    held_out = sorted({clip.subject for clip in training.clips})[1::EVERY]
    if not held_out:
        return {}
    fitting = training.only(exclude_subjects=held_out).windows
    fitted = fit_pca(fitting, scaling, n_components=fitting[0].size)
    validation = training.only(subjects=held_out)
    indices = np.linspace(0, len(validation.windows) - 1, min(LARGEST, len(validation.windows))).astype(int)
    windows = Windows(validation.windows[indices], validation.mask[indices])
    gt = local_positions(windows.features)
    n_components = len(fitted.components)
    sizes = [*(2**i for i in range(n_components.bit_length()) if 2**i < n_components), ALL]
    best = {}
    for application in applications:
        left = corrupted(application, windows, scaling.mean, skeleton=skeleton, seed=seed)
        inputs = {Restoration(application): left.features}
        if application in LOST_AT_RANDOM:
            inputs[Restoration(application, rescaled=True)] = rescaled(left, scaling.mean)
        for restoration, features in inputs.items():
            restored = {size: local_positions(truncated(fitted, size).project(features)) for size in sizes}
            errors = {size: joint_error(gt, pred, windows.mask) for size, pred in restored.items()}
            best[restoration] = min(errors, key=errors.__getitem__)
    return best
