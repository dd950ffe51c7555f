"""How well distances between clips agree with their actions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from npss.records import Record
from npss_baselines.data import SOURCES
from npss_baselines.manifold.applications.clip_distances import clip_distances, clip_extremes
from npss_baselines.manifold.applications.distance import g
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.applications.retrieval import MATCHES, auc, chance, retrieve
from npss_baselines.manifold.evaluation.records import context_of, records_of
from npss_baselines.manifold.evaluation.testbed import Testbed
from npss_baselines.manifold.motion.dataset import MotionSet


def nearness(testbed: Testbed) -> Iterator[Record]:
    """Measure whether clips that are close to each other are of the same action; see `retrieval`.

    Application ``distance``: ``auc``, how often two clips of one action are closer than two of different ones.
    Application ``nearest``: mean average precision ``map`` and nearest-neighbour accuracy ``nearest``, means over
    clips, and ``map_of_actions`` and ``nearest_of_actions``, means over actions; each for every kind of match. All
    subjects' clips take part: no method has seen an action's name. There are no records of sources that have a single
    action.

    Raises
    ------
    ValueError
        If a clip is of a source that is not registered: names it.
    """
    sources = {clip.source for clip in testbed.motions.clips}
    if unknown := sorted(sources - set(SOURCES)):
        raise ValueError(
            f"motions: it is not known what actions are called in {unknown[0]!r}, only in {', '.join(SOURCES)}"
        )
    for vocabulary in dict.fromkeys(source.vocabulary for source in SOURCES.values()):
        compared = {name for name in sources if SOURCES[name].vocabulary == vocabulary}
        if compared:
            yield from _nearness(testbed, testbed.motions.only(sources=compared), vocabulary)


def _nearness(testbed: Testbed, motions: MotionSet, name: str) -> Iterator[Record]:
    every = labels_of(motions)
    chosen = [i for i, label in enumerate(every) if label]
    actions, subjects = [every[i] for i in chosen], [motions.clips[i].subject for i in chosen]
    if len(set(actions)) < 2:  # nothing to tell apart
        return
    n_clips = len(actions)
    context = context_of(
        motions, source=name, actions=len(set(actions)), clips=n_clips, unlabelled=len(every) - n_clips
    )
    by_method = clip_distances(motions, testbed.manifolds, testbed.pca, testbed.scaling)
    by_method = {method: distances[np.ix_(chosen, chosen)] for method, distances in by_method.items()}

    for method, distances in by_method.items():
        yield from records_of(testbed, "distance", method, {"auc": auc(distances, actions)}, context)
    for matches in MATCHES:
        found = {
            method: retrieve(distances, actions, subjects, matches=matches) for method, distances in by_method.items()
        }
        found[Method("chance")] = chance(actions, subjects, matches=matches)
        for method, retrieved in found.items():
            if retrieved.n_queries:
                names = ("map", "nearest", "map_of_actions", "nearest_of_actions")
                values = dict(zip(names, (*retrieved.mean(), *retrieved.mean_of_labels(actions)), strict=True))
                details = {**context, "matches": matches, "queries": retrieved.n_queries}
                yield from records_of(testbed, "nearest", method, values, details)


def distance(testbed: Testbed, first: int, second: int) -> Iterator[Record]:
    """Measure how far two clips are from each other: ``g`` by each manifold, ``distance`` of the closest windows."""
    motions = testbed.motions
    context = context_of(motions, clips=" ".join(motions.clips[i].name for i in (first, second)))
    for name, manifold in testbed.manifolds.items():
        codes = [manifold.encode(motions.features[i][np.newaxis])[0] for i in (first, second)]
        yield from records_of(testbed, "distance", Method(name), {"g": float(g(*codes))}, context)
    windows = [motions.windows[motions.clip_of == i].reshape(-1, motions.windows[0].size) for i in (first, second)]
    closest = min(float(np.linalg.norm(windows[1] - window, axis=1).min()) for window in windows[0])
    yield from records_of(testbed, "distance", Method("euclidean"), {"distance": closest}, context)


def ranking(testbed: Testbed, query: int, n: int) -> Iterator[Record]:
    """Rank the clips nearest to one: by G of each manifold, and by Euclidean distance of the closest windows.

    Records have ``rank``, ``clip``, its ``label`` and ``subject``, and ``index`` in the set, too.
    """
    motions, actions = testbed.motions, labels_of(testbed.motions)
    context = context_of(motions, clip=motions.clips[query].name)
    by_method = {}
    for name, manifold in testbed.manifolds.items():
        found = clip_extremes(motions, manifold)
        by_method[Method(name), "g"] = np.square(found - found[query]).sum(axis=1)
    closest = np.full(len(actions), np.inf)
    for window in motions.windows[motions.clip_of == query]:
        np.minimum.at(closest, motions.clip_of, np.linalg.norm(motions.windows - window, axis=(1, 2)))
    by_method[Method("euclidean"), "distance"] = closest
    for (method, metric), far in by_method.items():
        others = [int(i) for i in np.argsort(far, kind="stable") if i != query]
        for rank, i in enumerate(others[:n], 1):
            clip = motions.clips[i]
            ranked = {"rank": rank, "clip": clip.name, "label": actions[i], "subject": clip.subject, "index": i}
            for record in records_of(testbed, "nearest", method, {metric: float(far[i])}, context):
                yield record | ranked


def labels_of(motions: MotionSet) -> list[str]:
    """Return the label of each clip, empty where it has none; of a source that is not registered, its description."""
    return [
        SOURCES[clip.source].label(clip.description) if clip.source in SOURCES else clip.description
        for clip in motions.clips
    ]
