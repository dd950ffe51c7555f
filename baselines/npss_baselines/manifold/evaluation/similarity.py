"""Measure how well distances between clips agree with their actions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from npss.records import Record
from npss.validation import Seed
from npss_baselines.data import SOURCES
from npss_baselines.manifold.applications.clip_distances import clip_distances, clip_extremes
from npss_baselines.manifold.applications.distance import g
from npss_baselines.manifold.applications.geodesic import geodesic_between
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.applications.retrieval import MATCHES, Retrieved, auc, chance, retrieve
from npss_baselines.manifold.evaluation.intervals import difference_interval
from npss_baselines.manifold.evaluation.records import context_of, records_of
from npss_baselines.manifold.evaluation.testbed import Testbed
from npss_baselines.manifold.motion.dataset import MotionSet

#: Equation 4 without a manifold, which other methods are compared with.
PLAIN = Method("extremes")


def nearness(testbed: Testbed) -> Iterator[Record]:
    """Measure whether close clips show the same action; see `retrieval`.

    Application ``distance``: ``auc``, how often two clips of the same action are closer than two of different actions.
    Application ``nearest``: mean average precision ``map`` and nearest-neighbour accuracy ``nearest``, averaged over
    clips, and ``map_of_actions`` and ``nearest_of_actions``, averaged over actions; each for every kind of match. Clips
    of all subjects take part, since no method has seen action names. Sources with a single action give no records.

    Averages over clips have the ends ``low`` and ``high`` of the 95 % interval of the difference from `PLAIN`, with the
    query as block.

    Raises
    ------
    ValueError
        If the source of a clip is not registered. The message names the source.
    """
    sources = {clip.source for clip in testbed.motions.clips}
    if unknown := sorted(sources - set(SOURCES)):
        raise ValueError(
            f"motions: unknown action names of source {unknown[0]!r}; they are known for {', '.join(SOURCES)}"
        )
    for vocabulary in dict.fromkeys(source.vocabulary for source in SOURCES.values()):
        selected = {name for name in sources if SOURCES[name].vocabulary == vocabulary}
        if selected:
            yield from _nearness(testbed, testbed.motions.only(sources=selected), vocabulary)


def _nearness(testbed: Testbed, motions: MotionSet, name: str) -> Iterator[Record]:
    labels = labels_of(motions)
    labelled = [i for i, label in enumerate(labels) if label]
    actions, subjects = [labels[i] for i in labelled], [motions.clips[i].subject for i in labelled]
    if len(set(actions)) < 2:  # no two actions to tell apart
        return
    n_clips = len(actions)
    context = context_of(
        motions, source=name, actions=len(set(actions)), clips=n_clips, unlabelled=len(labels) - n_clips
    )
    by_method = clip_distances(motions, testbed.manifolds, testbed.pca, testbed.scaling)
    by_method = {method: distances[np.ix_(labelled, labelled)] for method, distances in by_method.items()}

    for method, distances in by_method.items():
        yield from records_of(testbed, "distance", method, {"auc": auc(distances, actions)}, context)
    for matches in MATCHES:
        results = {
            method: retrieve(distances, actions, subjects, matches=matches) for method, distances in by_method.items()
        }
        results[Method("chance")] = chance(actions, subjects, matches=matches)
        for method, retrieved in results.items():
            if retrieved.n_queries:
                names = ("map", "nearest", "map_of_actions", "nearest_of_actions")
                values = dict(zip(names, (*retrieved.mean(), *retrieved.mean_of_labels(actions)), strict=True))
                details = {**context, "matches": matches, "queries": retrieved.n_queries}
                for record in records_of(testbed, "nearest", method, values, details):
                    yield record | _difference(results[PLAIN], retrieved, record["metric"], seed=testbed.seed)


def _difference(plain: Retrieved, retrieved: Retrieved, metric: str, *, seed: Seed) -> dict[str, object]:
    """Return the interval of the difference from `PLAIN`, for averages over queries; a query is a block."""
    if plain is retrieved or metric not in ("map", "nearest"):
        return {}
    by_query = [each.precision if metric == "map" else each.nearest for each in (plain, retrieved)]
    asked = np.isfinite(by_query[0])
    if asked.sum() < 2:
        return {}
    first, second = (np.stack([values[asked], np.ones(asked.sum())]) for values in by_query)
    low, high = difference_interval(first, second, seed=seed)
    return {"against": str(PLAIN), "low": low, "high": high}


def distance(testbed: Testbed, first: int, second: int) -> Iterator[Record]:
    """Measure the distances of two clips.

    ``g`` by each manifold; ``geodesic``, the length of the shortest path along it between their first windows; and the
    Euclidean ``distance`` of their closest windows.
    """
    motions = testbed.motions
    context = context_of(motions, clips=" ".join(motions.clips[i].name for i in (first, second)))
    for name, manifold in testbed.manifolds.items():
        codes = [manifold.encode(motions.features[i][np.newaxis])[0] for i in (first, second)]
        starts = [motions.windows[motions.clip_of == i][0] for i in (first, second)]
        values = {"g": float(g(*codes)), "geodesic": geodesic_between(manifold, *starts).length}
        yield from records_of(testbed, "distance", Method(name), values, context)
    windows = [motions.windows[motions.clip_of == i].reshape(-1, motions.windows[0].size) for i in (first, second)]
    closest = min(float(np.linalg.norm(windows[1] - window, axis=1).min()) for window in windows[0])
    yield from records_of(testbed, "distance", Method("euclidean"), {"distance": closest}, context)


def ranking(testbed: Testbed, query: int, n: int) -> Iterator[Record]:
    """Rank the clips nearest to a query, by G of each manifold and by Euclidean distance of the closest windows.

    Records also have ``rank``, ``clip``, its ``label`` and ``subject``, and its ``index`` in the set.
    """
    motions, actions = testbed.motions, labels_of(testbed.motions)
    context = context_of(motions, clip=motions.clips[query].name)
    by_method = {}
    for name, manifold in testbed.manifolds.items():
        vectors = clip_extremes(motions, manifold)
        by_method[Method(name), "g"] = np.square(vectors - vectors[query]).sum(axis=1)
    closest = np.full(len(actions), np.inf)
    for window in motions.windows[motions.clip_of == query]:
        np.minimum.at(closest, motions.clip_of, np.linalg.norm(motions.windows - window, axis=(1, 2)))
    by_method[Method("euclidean"), "distance"] = closest
    for (method, metric), distances in by_method.items():
        others = [int(i) for i in np.argsort(distances, kind="stable") if i != query]
        for rank, i in enumerate(others[:n], 1):
            clip = motions.clips[i]
            details = {"rank": rank, "clip": clip.name, "label": actions[i], "subject": clip.subject, "index": i}
            for record in records_of(testbed, "nearest", method, {metric: float(distances[i])}, context):
                yield record | details


def labels_of(motions: MotionSet) -> list[str]:
    """Return the label of each clip, or an empty string; of an unregistered source, the clip's description."""
    return [
        SOURCES[clip.source].label(clip.description) if clip.source in SOURCES else clip.description
        for clip in motions.clips
    ]
