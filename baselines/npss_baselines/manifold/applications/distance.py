"""The distance G between two motions, from the extremes of their hidden units."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from npss.metrics import Metric
from npss.protocol import FPS
from npss.skeleton import H36M, poses_to_positions
from npss.validation import Array, Float64, check_finite, motion_pair, real_array
from npss_baselines.data.motion import NAMES, Clip
from npss_baselines.manifold.motion.dataset import prepare

if TYPE_CHECKING:
    from npss_baselines.manifold.model.projector import Projector  # imports torch

__all__ = ["extremes", "g", "g_of_poses", "metric_of"]

_JOINTS = [H36M.names.index(name) for name in NAMES]


def extremes(code: npt.ArrayLike) -> Float64:
    """Compute the maximum and minimum over time of every hidden unit, which G compares.

    Parameters
    ----------
    code : (..., T', H) array_like
        Hidden units from `Projector.encode`; T' is at least 1.

    Returns
    -------
    (..., 2 H) ndarray of float64
        The maxima of the H units, then their minima.

    Raises
    ------
    TypeError
        If the code does not hold real numbers.
    ValueError
        If the code has fewer than two axes, no step or no unit, or a value is not finite.

    Examples
    --------
    >>> extremes([[0, 3], [2, -1], [1, 1]])
    array([ 2.,  3.,  0., -1.])
    """
    units = _code("code", code)
    return np.concatenate([units.max(axis=-2), units.min(axis=-2)], axis=-1)


def g(code0: npt.ArrayLike, code1: npt.ArrayLike) -> Float64:
    r"""Compute the distance G between motions, equation 4 of the paper.

    .. math:: G(X_0, X_1) = \lVert \max_i \Phi(X_0) - \max_i \Phi(X_1) \rVert_2^2
                          + \lVert \min_i \Phi(X_0) - \min_i \Phi(X_1) \rVert_2^2

    where i runs over the steps of the code :math:`\Phi(X)`. Timing and length do not matter, only how strongly each
    hidden unit responds.

    Parameters
    ----------
    code0, code1 : (..., T', H) array_like
        Codes from `Projector.encode`. Leading axes must agree; lengths T' may differ.

    Returns
    -------
    (...) ndarray of float64
        At least 0; exactly 0 between a code and itself; symmetric.

    Raises
    ------
    TypeError
        If a code does not hold real numbers.
    ValueError
        If a shape is wrong, the leading axes or the numbers of units differ, or a value is not finite.

    Notes
    -----
    The abstract calls G a "geodesic distance", but no path on the manifold is measured: G is the squared Euclidean
    distance of two vectors of extremes. Different motions can have distance 0. As a square, G does not obey the
    triangle inequality; its square root does.

    References
    ----------
    D. Holden, J. Saito, T. Komura and T. Joyce, "Learning Motion Manifolds with Convolutional Autoencoders",
    SIGGRAPH Asia Technical Briefs 2015, equation 4.

    Examples
    --------
    >>> float(g([[0.0, 0.5], [0.2, -0.5]], [[0.2, 0.5], [0.0, -0.5]]))  # the same code reversed
    0.0
    >>> float(g([[0.0], [0.5]], [[0.0], [1.0]]))
    0.25
    """
    first, second = _code("code0", code0), _code("code1", code1)
    if first.shape[:-2] != second.shape[:-2] or first.shape[-1] != second.shape[-1]:
        raise ValueError(
            f"code1: shape {second.shape} does not match {first.shape} of code0; only the number of steps, the "
            f"second-to-last axis, may differ"
        )
    squares: Float64 = np.square(extremes(first) - extremes(second)).sum(axis=-1)
    return squares


def g_of_poses(projector: Projector, gt: npt.ArrayLike, pred: npt.ArrayLike, *, fps: float = FPS) -> Float64:
    """Compute the distance G between predictions and ground truth, as poses of Human3.6M.

    As in all metrics of the field, only joint rotations count: the root stays in place and faces ahead. Poses are then
    prepared like the manifold's training motion, at 30 frames per second and on one skeleton.

    Parameters
    ----------
    projector : Projector
        The manifold; its ``signature`` is part of the score's.
    gt, pred : (N, T, 99) array_like
        Exponential maps, as for `npss.skeleton.poses_to_positions`.
    fps : float, optional
        Frames per second.

    Returns
    -------
    (N,) ndarray of float64
        G of each sequence. The average is the score; 0 is best.

    Raises
    ------
    TypeError, ValueError
        If the poses are invalid, or the shapes differ.

    Notes
    -----
    A score of 0 means that hidden units have equal extremes, not that motions are equal: G ignores when something
    happens, and nearly ignores how often.
    """
    first, second = (_features_of(poses, fps) for poses in motion_pair(gt, pred))
    return g(projector.encode(first), projector.encode(second))


def metric_of(projector: Projector) -> Metric:
    """Return the metric of the distance G by a manifold, to register; see `npss.metrics`.

    Parameters
    ----------
    projector : Projector
        The manifold; its signature is in the signatures of the metric.

    Returns
    -------
    Metric
        The metric ``g``, of Human3.6M poses.
    """
    return Metric(
        name="g",
        function=partial(g_of_poses, projector),
        says="the squared distance of the extremes over time of a motion manifold's hidden units",
        heading="G",
        takes="poses",
        options=("fps",),
        fields={"manifold": projector.signature},
    )


def _features_of(poses: Array, fps: float) -> Array:
    """Return the manifold's features of poses ``(N, T, 99)``."""
    positions = poses_to_positions(np.asarray(poses, np.float64))[..., _JOINTS, :]
    clips = [Clip(str(i), "poses", "", "", fps, motion) for i, motion in enumerate(positions)]
    return np.stack(prepare(clips).features)


def _code(name: str, values: npt.ArrayLike) -> Float64:
    array: Array = real_array(name, values)
    if array.ndim < 2 or 0 in array.shape[-2:]:
        raise ValueError(f"{name}: expected shape (..., T', H) = (..., steps, units), got {array.shape}")
    check_finite(name, array)
    return array.astype(np.float64)
