"""Distances between clips, by G and its baselines."""

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
    """Compute distances between all clips of a set by each method.

    Whole clips are compared by extremes over time, of hidden units (G) or of other values. Windows are compared by
    Euclidean distance; the distance of two clips is that of their two closest windows.

    Parameters
    ----------
    motions : MotionSet
        N clips.
    manifolds : mapping of str to Manifold
        Manifolds by name.
    pca : Projector
        Principal components.
    scaling : Scaling
        Scaling for the ``normalised`` methods.

    Returns
    -------
    dict of Method to (N, N) ndarray of float64
        Square roots of G, which rank as G does, and Euclidean distances, by method. ``euclidean`` compares windows of
        features, ``euclidean, normalised`` of scaled features, ``pca`` of codes. A manifold's name is G, with the
        variants ``windows`` (G of the closest two windows), ``unsquashed`` (G of hidden units before tanh) and
        ``euclidean`` (windows of codes). The methods ``pca, extremes``, ``extremes`` (of features), ``extremes,
        normalised`` and ``length`` (of clips only) show which part of G is due to the manifold.
    """
    windows = np.asarray(motions.windows, np.float64)

    def closest(vectors: Array) -> Float64:
        return closest_windows(vectors.reshape(len(vectors), -1), motions.clip_of, len(motions.clips))

    def whole(transform: Callable[[Array], Array]) -> Float64:
        return distances_of([extremes(transform(clip)) for clip in motions.features])

    distances = {
        Method("euclidean"): closest(windows),
        Method("euclidean", "normalised"): closest(scaling.normalize(windows)),
        Method("pca"): closest(pca.encode(windows)),
    }
    for name, manifold in manifolds.items():
        codes = manifold.encode(windows)
        largest = 1 - manifold.network.config.eps  # as in the decoder
        vectors = clip_extremes(motions, manifold)
        distances[Method(name)] = distances_of(vectors)
        distances[Method(name, "windows")] = closest(extremes(codes))
        distances[Method(name, "unsquashed")] = distances_of(np.arctanh(vectors.clip(-largest, largest)))
        distances[Method(name, "euclidean")] = closest(codes)
    lengths = np.log([[clip.n_frames] for clip in motions.clips])
    return distances | {
        Method("pca", "extremes"): distances_of(clip_extremes(motions, pca)),
        Method("extremes"): whole(lambda clip: clip),
        Method("extremes", "normalised"): whole(scaling.normalize),
        Method("length"): distances_of(lengths),
    }


def clip_extremes(motions: MotionSet, projector: Projector) -> Float64:
    """Return the extremes of each clip's code, ``(N, 2 H)``; G is the squared distance of two rows."""
    return np.stack([extremes(projector.encode(clip[np.newaxis])[0]) for clip in motions.features])
