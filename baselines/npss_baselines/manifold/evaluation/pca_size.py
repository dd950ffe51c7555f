"""How many principal components restore best: the fairest baseline of the manifold."""

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

#: To choose a size, every third training subject is put aside, and so many of their windows are used, evenly spread.
EVERY, LARGEST = 3, 100
#: More components than windows have.
ALL = 2**20


class Restoration(NamedTuple):
    """What is restored, and how."""

    application: str
    rescaled: bool = False  # whether what is projected was rescaled before


def truncated(fitted: PCA, size: int) -> PCA:
    """Return the first so many components of some."""
    return replace(fitted, components=fitted.components[:size])


def best_sizes(
    training: MotionSet,
    scaling: Scaling,
    applications: Sequence[str],
    *,
    skeleton: Skeleton = JOINTS,
    seed: int = 0,
) -> dict[Restoration, int]:
    """Choose how many components restore best, by the joint error on training subjects that they are not fitted to.

    Sizes are 1, 2, 4, 8 and so on, and all that there are.

    Parameters
    ----------
    training : MotionSet
        Of two subjects or more; clips whose subject is not stated are one subject's.
    scaling : Scaling
        By which components see features; its mean is what lost values become.
    applications : sequence of str
        Of `npss_baselines.manifold.applications.restore.RESTORATIONS`.
    skeleton : npss.skeleton.Skeleton, optional
        Whose joints they are.
    seed : int, optional
        Of the corruptions.

    Returns
    -------
    dict of Restoration to int
        For each application; also rescaled, where values are lost at random. `ALL` for as many as there are. Empty if
        there is a single subject.
    """
    aside = sorted({clip.subject for clip in training.clips})[1::EVERY]
    if not aside:
        return {}
    others = training.only(exclude_subjects=aside).windows
    fitted = fit_pca(others, scaling, n_components=others[0].size)
    left_out = training.only(subjects=aside)
    some = np.linspace(0, len(left_out.windows) - 1, min(LARGEST, len(left_out.windows))).astype(int)
    windows = Windows(left_out.windows[some], left_out.mask[some])
    gt = local_positions(windows.features)
    n_components = len(fitted.components)
    sizes = [*(2**i for i in range(n_components.bit_length()) if 2**i < n_components), ALL]
    best = {}
    for application in applications:
        left = corrupted(application, windows, scaling.mean, skeleton=skeleton, seed=seed)
        seen = {Restoration(application): left.features}
        if application in LOST_AT_RANDOM:
            seen[Restoration(application, rescaled=True)] = rescaled(left, scaling.mean)
        for restoration, features in seen.items():
            restored = {size: local_positions(truncated(fitted, size).project(features)) for size in sizes}
            errors = {size: joint_error(gt, pred, windows.mask) for size, pred in restored.items()}
            best[restoration] = min(errors, key=errors.__getitem__)
    return best
