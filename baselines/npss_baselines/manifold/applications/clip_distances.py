"""How far clips are from each other: by G, and by all that G is compared with."""

from __future__ import annotations

from collections.abc import Callable, Mapping

import numpy as np

from npss.validation import Array, Float64
from npss_baselines.manifold.applications.distance import extremes
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.applications.retrieval import closest_windows, distances_of
from npss_baselines.manifold.model.projector import Manifold, Projector
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.scaling import Scaling


def clip_distances(
    motions: MotionSet, manifolds: Mapping[str, Manifold], pca: Projector, scaling: Scaling
) -> dict[Method, Float64]:
    """Compute distances between all clips of a set, by each method.

    Whole clips are compared by their extremes over time, of hidden units (G) or of what else there is. Windows are
    compared frame by frame in Euclidean distance; two clips are as far apart as the closest two of their windows.

    Parameters
    ----------
    motions : MotionSet
        N clips.
    manifolds : mapping of str to Manifold
        By name.
    pca : Projector
        Principal components.
    scaling : Scaling
        For ``euclidean, normalised``.

    Returns
    -------
    dict of Method to (N, N) ndarray of float64
        Roots of G and Euclidean distances, which rank as their squares do. By method: ``euclidean`` (windows of
        features as they are) and ``euclidean, normalised``; ``pca`` (windows of codes); each manifold's name (G), with
        ``, windows`` (G of windows, the closest two), ``, unsquashed`` (G of hidden units before tanh) and ``,
        euclidean`` (windows of codes). What of G is due to the manifold, and what not: ``pca, extremes``, ``extremes``
        (as G, of the features themselves), ``extremes, normalised``, and ``length``, in which motion is not looked at.
    """
    windows = np.asarray(motions.windows, np.float64)

    def close(vectors: Array) -> Float64:
        return closest_windows(vectors.reshape(len(vectors), -1), motions.clip_of, len(motions.clips))

    def whole(see: Callable[[Array], Array]) -> Float64:
        return distances_of([extremes(see(clip)) for clip in motions.features])

    distances = {
        Method("euclidean"): close(windows),
        Method("euclidean", "normalised"): close(scaling.normalize(windows)),
        Method("pca"): close(pca.encode(windows)),
    }
    for name, manifold in manifolds.items():
        codes = manifold.encode(windows)
        largest = 1 - manifold.network.config.eps  # as in the inverse
        found = clip_extremes(motions, manifold)
        distances[Method(name)] = distances_of(found)
        distances[Method(name, "windows")] = close(extremes(codes))
        distances[Method(name, "unsquashed")] = distances_of(np.arctanh(found.clip(-largest, largest)))
        distances[Method(name, "euclidean")] = close(codes)
    lengths = np.log([[clip.n_frames] for clip in motions.clips])
    return distances | {
        Method("pca", "extremes"): distances_of(clip_extremes(motions, pca)),
        Method("extremes"): whole(lambda clip: clip),
        Method("extremes", "normalised"): whole(scaling.normalize),
        Method("length"): distances_of(lengths),
    }


def clip_extremes(motions: MotionSet, projector: Projector) -> Float64:
    """Return the extremes of the code of every clip, ``(N, 2 H)``: G is the squared distance of two rows."""
    return np.stack([extremes(projector.encode(clip[np.newaxis])[0]) for clip in motions.features])
