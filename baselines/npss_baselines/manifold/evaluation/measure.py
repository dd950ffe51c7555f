"""What each use is worth: records of numbers, each with the signature that says what it is."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

import npss
from npss.records import Record
from npss.validation import Array, Seed, generator, renamed
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.clip_distances import clip_distances, clip_extremes
from npss_baselines.manifold.applications.distance import g
from npss_baselines.manifold.applications.interpolate import blend, interpolate
from npss_baselines.manifold.applications.restore import USES
from npss_baselines.manifold.applications.retrieval import MATCHES, auc, chance, retrieve
from npss_baselines.manifold.applications.sample import PRIORS, sample_codes
from npss_baselines.manifold.evaluation.testbed import Bench, fingerprint
from npss_baselines.manifold.motion import measures
from npss_baselines.manifold.motion.features import FPS, local_positions, to_positions
from npss_baselines.manifold.motion.labels import labels
from npss_baselines.manifold.motion.prepared import MotionSet

#: Shares of the second motion at which interpolations are measured, and how many pairs of windows are interpolated.
SHARES, PAIRS = (0.25, 0.5, 0.75), 50
#: Motions that are sampled, and training windows, evenly spread, that they are compared with and codes are drawn from.
SAMPLES, REAL = 50, 500
#: A hidden unit is idle if its standard deviation over held-out windows is less, saturated where its magnitude is more.
IDLE, SATURATED = 0.01, 0.95
#: Of which sources clips are compared with each other: words of the others mean other things.
TOGETHER = {"cmu": ("cmu", "cmu-styles"), "h36m": ("h36m",), "synthetic": ("synthetic",)}


def restoration(bench: Bench, use: str) -> Iterator[Record]:
    """Measure restored windows against what they were.

    Metrics: ``joint_error`` in heights, of the joints that were missing throughout ``missing_joint_error``,
    ``bone_error`` as a share of the lengths, and ``npss`` on positions in the character's frame, windows as sequences.
    """
    left, mask = bench.corrupted(use), bench.windows.mask
    gt = local_positions(bench.windows.features)
    missing = ~local_positions(left.known.astype(float)).any(axis=(0, 1, 3))
    stated = _stated(bench.test, frames=gt.shape[1], corruption=USES[use], seed=bench.seed)
    for method, motion in bench.restored(use, left).items():
        pred = local_positions(motion).astype(np.float64)
        values = {
            "joint_error": measures.joint_error(gt, pred, mask),
            "bone_error": measures.bone_error(pred, JOINTS, mask),
            "npss": measures.power_error(gt, pred, mask),
        }
        if missing.any():
            values["missing_joint_error"] = measures.joint_error(gt[:, :, missing], pred[:, :, missing], mask)
        yield from _records(bench, use, method, values, stated)


def interpolation(bench: Bench, clips: Sequence[int] | None = None) -> Iterator[Record]:
    """Measure whether motion between two windows is possible: lengths of bones, and feet that slide.

    The windows are the first ones of two clips, or random pairs of what is held out. Metrics are means over `SHARES`:
    ``bone_error``, and ``foot_speed`` in heights per second. Method ``input`` is the motions themselves, ``linear``
    features blended.
    """
    if clips is None:
        first, second = pairs(bench.test, PAIRS, seed=bench.seed)
        stated = _stated(bench.test, pairs=len(first), seed=bench.seed)
    else:
        first, second = (first_window(bench.motions, clip) for clip in clips)
        stated = _stated(bench.motions, clips=" ".join(bench.motions.clips[clip].name for clip in clips))
    motions = {"input": [first, second], "linear": [blend(first, second, share) for share in SHARES]}
    for name, projector in bench.projectors().items():
        motions[name] = [interpolate(projector, first, second, share) for share in SHARES]
    stated |= {"frames": first.shape[1], "shares": " ".join(f"{share:g}" for share in SHARES)}
    for method, several in motions.items():
        values = validity(np.concatenate(several))
        del values["joint_speed"]
        yield from _records(bench, "interpolate", method, values, stated)


def sampling(bench: Bench) -> Iterator[Record]:
    """Measure motion that is sampled, beside real windows, method ``input``.

    Metrics: ``bone_error``; ``foot_speed`` and ``joint_speed``, the mean speed of joints in the character's frame,
    both in heights per second. Methods are named by what is sampled and what from, of
    `npss_baselines.manifold.applications.sample.PRIORS`.
    """
    n_windows = len(bench.training.windows)
    some = np.linspace(0, n_windows - 1, min(REAL, n_windows)).astype(int)
    windows, mask = bench.training.windows[some], bench.training.mask[some]
    motions = {"input": windows}
    for name, projector in bench.projectors().items():
        codes = projector.encode(windows)
        for prior in priors_of(bench, name):
            drawn = sample_codes(codes, SAMPLES, prior=prior, seed=bench.seed)
            motions[f"{name}, {prior}"] = projector.decode(drawn, windows.shape[1])
    stated = _stated(bench.training, frames=windows.shape[1], samples=SAMPLES, seed=bench.seed)
    for method, motion in motions.items():
        values = validity(motion, mask if method == "input" else None)
        yield from _records(bench, "sample", method, values, stated)


def priors_of(bench: Bench, name: str) -> tuple[str, ...]:
    """Return what codes of a projector are drawn from: those of principal components know no [-1, 1]."""
    return PRIORS if name in bench.manifolds else PRIORS[1:]


def filtering(bench: Bench) -> Iterator[Record]:
    """Count what hidden units do on held-out windows: the shares that are ``idle``, and ``saturated``."""
    windows, stated = bench.test.windows, _stated(bench.test)
    for method, manifold in bench.manifolds.items():
        codes = manifold.encode(windows).astype(np.float64)
        values = {
            "idle": float((codes.std(axis=(0, 1)) < IDLE).mean()),
            "saturated": float((np.abs(codes) > SATURATED).mean()),
            "deviation": float(codes.std(axis=(0, 1)).mean()),
        }
        yield from _records(bench, "filters", method, values, stated)


def nearness(bench: Bench) -> Iterator[Record]:
    """Measure whether clips that are close to each other are of the same action; see `retrieval`.

    Use ``distance``: ``auc``, how often two clips of one action are closer than two of different ones.
    Use ``nearest``: mean average precision ``map`` and nearest-neighbour accuracy ``nearest``, means over clips, and
    ``map_of_actions`` and ``nearest_of_actions``, means over actions; each for every kind of match. All subjects' clips
    take part: no method has seen an action's name. There are no records of sources that have a single action.

    Raises
    ------
    ValueError
        If a clip is of a source that is not in `TOGETHER`: names it.
    """
    known = [source for sources in TOGETHER.values() for source in sources]
    if unknown := sorted({clip.source for clip in bench.motions.clips} - set(known)):
        raise ValueError(
            f"motions: it is not known what actions are called in {unknown[0]!r}, only in {', '.join(known)}"
        )
    for name, sources in TOGETHER.items():
        if any(clip.source in sources for clip in bench.motions.clips):
            yield from _nearness(bench, bench.motions.only(sources=sources), name)


def _nearness(bench: Bench, motions: MotionSet, name: str) -> Iterator[Record]:
    every = labels_of(motions)
    chosen = [i for i, label in enumerate(every) if label]
    of, subjects = [every[i] for i in chosen], [motions.clips[i].subject for i in chosen]
    if len(set(of)) < 2:  # nothing to tell apart
        return
    stated = _stated(motions, source=name, actions=len(set(of)), clips=len(of), unlabelled=len(every) - len(of))
    by_method = clip_distances(motions, bench.manifolds, bench.rival, bench.normalization)
    by_method = {method: distances[np.ix_(chosen, chosen)] for method, distances in by_method.items()}

    for method, distances in by_method.items():
        yield from _records(bench, "distance", method, {"auc": auc(distances, of)}, stated)
    for matches in MATCHES:
        found = {method: retrieve(distances, of, subjects, matches=matches) for method, distances in by_method.items()}
        for method, one in {**found, "chance": chance(of, subjects, matches=matches)}.items():
            if one.n_queries:
                names = ("map", "nearest", "map_of_actions", "nearest_of_actions")
                values = dict(zip(names, (*one.mean(), *one.mean_of_labels(of)), strict=True))
                context = {**stated, "matches": matches, "queries": one.n_queries}
                yield from _records(bench, "nearest", method, values, context)


def distance(bench: Bench, first: int, second: int) -> Iterator[Record]:
    """Measure how far two clips are from each other: ``g`` by each manifold, ``distance`` of the closest windows."""
    motions = bench.motions
    stated = _stated(motions, clips=" ".join(motions.clips[i].name for i in (first, second)))
    for method, manifold in bench.manifolds.items():
        codes = [manifold.encode(motions.features[i][np.newaxis])[0] for i in (first, second)]
        yield from _records(bench, "distance", method, {"g": float(g(*codes))}, stated)
    windows = [motions.windows[motions.clip_of == i].reshape(-1, motions.windows[0].size) for i in (first, second)]
    closest = min(float(np.linalg.norm(windows[1] - window, axis=1).min()) for window in windows[0])
    yield from _records(bench, "distance", "euclidean", {"distance": closest}, stated)


def ranking(bench: Bench, query: int, n: int) -> Iterator[Record]:
    """Rank the clips nearest to one: by G of each manifold, and by Euclidean distance of the closest windows.

    Records have ``rank``, ``clip``, its ``label`` and ``subject``, and ``index`` in the set, too.
    """
    motions, of = bench.motions, labels_of(bench.motions)
    stated = _stated(motions, clip=motions.clips[query].name)
    by_method = {}
    for name, manifold in bench.manifolds.items():
        found = clip_extremes(motions, manifold)
        by_method[name, "g"] = np.square(found - found[query]).sum(axis=1)
    closest = np.full(len(of), np.inf)
    for window in motions.windows[motions.clip_of == query]:
        np.minimum.at(closest, motions.clip_of, np.linalg.norm(motions.windows - window, axis=(1, 2)))
    by_method["euclidean", "distance"] = closest
    for (method, metric), far in by_method.items():
        others = [int(i) for i in np.argsort(far, kind="stable") if i != query]
        for rank, i in enumerate(others[:n], 1):
            clip = motions.clips[i]
            said = {"rank": rank, "clip": clip.name, "label": of[i], "subject": clip.subject, "index": i}
            for record in _records(bench, "nearest", method, {metric: float(far[i])}, stated):
                yield record | said


def labels_of(motions: MotionSet) -> list[str]:
    """Return the label of each clip, empty where it has none; see `npss_baselines.manifold.motion.labels`."""
    return labels([clip.source for clip in motions.clips], [clip.description for clip in motions.clips])


def validity(motion: Array, mask: measures.Mask | None = None) -> dict[str, float]:
    """Measure what can be said of motions ``(n, T, F)`` without a truth to compare them with."""
    counted = np.ones(motion.shape[:2], bool) if mask is None else mask
    local = local_positions(motion).astype(np.float64)
    speed = FPS * np.linalg.norm(np.diff(local, axis=1), axis=-1)  # (n, T - 1, J)
    return {
        "bone_error": measures.bone_error(local, JOINTS, counted),
        "foot_speed": measures.foot_speed(to_positions(motion), JOINTS, counted, fps=FPS),
        "joint_speed": float(speed[counted[:, 1:] & counted[:, :-1]].mean()),
    }


@renamed(rng="seed")
def pairs(motions: MotionSet, n: int, *, seed: Seed) -> tuple[Array, Array]:
    """Draw pairs of whole windows ``(n, T, F)``, the two of a pair of different clips."""
    whole = np.flatnonzero(motions.mask.all(axis=1))
    of = motions.clip_of[whole]
    if len(set(of)) < 2:
        raise ValueError("motions: to interpolate, it takes whole windows of two clips or more")
    chosen: list[tuple[int, int]] = []
    rng = generator(seed)
    while len(chosen) < n:
        first, second = rng.integers(len(whole), size=2)
        if of[first] != of[second]:
            chosen.append((whole[first], whole[second]))
    first, second = np.array(chosen).T
    return motions.windows[first].astype(np.float64), motions.windows[second].astype(np.float64)


def first_window(motions: MotionSet, clip: int) -> Array:
    """Return the first window of a clip, ``(1, T, F)``."""
    window: Array = motions.windows[motions.clip_of == clip][:1].astype(np.float64)
    return window


def _stated(motions: MotionSet, **context: Any) -> dict[str, Any]:
    """Return what signatures state of motion."""
    return {"fps": FPS, "motion": fingerprint(motions), **context}


def _records(
    bench: Bench, use: str, method: str, values: Mapping[str, float], stated: Mapping[str, Any]
) -> Iterator[Record]:
    model = bench.signature_of(use, method)
    context = dict(stated) if model is None else {**stated, "model": model}
    for metric, value in values.items():
        if np.isnan(value):
            continue  # there is none: of windows, none is whole, or no foot is ever on the ground
        line = npss.signature("paper" if metric == "npss" else None, metric=metric, **context)
        yield {"use": use, "method": method, "metric": metric, "value": value, "signature": line}
