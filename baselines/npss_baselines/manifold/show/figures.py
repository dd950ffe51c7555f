"""Figures of all applications."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from npss import parse_signature, signature
from npss.commands import motion_page
from npss.records import Record
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.interpolate import interpolate
from npss_baselines.manifold.applications.restore import RESTORATIONS
from npss_baselines.manifold.applications.sample import PRIORS, filter_motion, motion_of, sample_codes
from npss_baselines.manifold.evaluation.similarity import labels_of, ranking
from npss_baselines.manifold.evaluation.synthesis import first_window, priors_of
from npss_baselines.manifold.evaluation.testbed import Testbed
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.features import FPS, local_positions
from npss_baselines.manifold.show import drawing
from npss_baselines.manifold.show.moving import moving_interpolations

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: Number of hidden units to draw.
DRAWN = 8
#: The clip to interpolate with a walk: jumping jacks and squats.
PAIR = "13_30"


#: Simple baselines that look like another.
_SIMILAR = ("pchip", "smoothing", "pose-gaussian", "key-ridge")


def clip_named(motions: MotionSet, name: str) -> int:
    """Return the index of a clip by name, or by source and name: ``cmu/02_01``.

    Raises
    ------
    ValueError
        If no clip or several clips have the name.
    """
    indices = [i for i, clip in enumerate(motions.clips) if name in (clip.name, f"{clip.source}/{clip.name}")]
    if len(indices) != 1:
        examples = ", ".join(clip.name for clip in motions.clips[:5])
        raise ValueError(
            f"CLIP: {len(indices)} of {len(motions.clips)} clips have the name {name!r}; the first clips are {examples}"
        )
    return indices[0]


def window_of(motions: MotionSet, clip: str | None) -> int:
    """Return the index of a clip's first window (default: the first whole window of all)."""
    if clip is None:
        return int(motions.mask.all(axis=1).argmax())
    return int(np.flatnonzero(motions.clip_of == clip_named(motions, clip))[0])


def restoration(testbed: Testbed, application: str, *, clip: str | None = None) -> Figure:
    """Draw a held-out window: original, corrupted, and restored by each method."""
    window = window_of(testbed.test, clip)
    left = testbed.corrupted(application)
    window_left = replace(left, features=left.features[[window]], known=left.known[[window]])
    restored = testbed.restored(application, window_left)
    rows = {"original": testbed.windows.features[[window]]} | {
        str(method): motion for method, motion in restored.items() if method.name not in _SIMILAR
    }
    if application == "project":
        del rows["input"]
    if "pca-best" in rows:
        del rows["pca"]
    n_frames = int(testbed.test.mask[window].sum())
    drawn = {name: local_positions(motion[0, :n_frames]) for name, motion in rows.items()}
    return drawing.strips(
        drawn,
        f"{application}: {RESTORATIONS[application]}",
        f"{_caption(testbed.test, testbed.test.clip_of[window])}; held out",
    )


def interpolation(testbed: Testbed, clips: Sequence[int] | None = None) -> Figure:
    """Draw two motions and their interpolations."""
    motions = testbed.motions
    chosen = _pair(motions) if clips is None else clips
    first, second = (first_window(motions, clip) for clip in chosen)
    rows = {motions.clips[chosen[0]].name: first}
    rows |= {f"slerp, possible, {share:g}": interpolate(None, first, second, share) for share in (0.25, 0.5, 0.75)}
    rows["linear, 0.5"] = interpolate(None, first, second, 0.5, way="linear", constrained=False)
    for name, projector in testbed.projectors().items():
        rows[f"{name}, 0.5"] = interpolate(projector, first, second, 0.5, way="manifold", constrained=False)
    rows[motions.clips[chosen[1]].name] = second
    return drawing.strips(
        {name: local_positions(motion[0]) for name, motion in rows.items()},
        "numbers are shares of the second motion",
        *(_caption(motions, clip) for clip in chosen),
    )


def samples(testbed: Testbed) -> Figure:
    """Draw a sample of each prior."""
    windows = testbed.training.windows[testbed.training.mask.all(axis=1)]
    rows = {"real": windows[0]}
    for name, projector in testbed.projectors().items():
        codes = projector.encode(windows)
        for prior in priors_of(testbed, name):
            drawn = sample_codes(codes, 1, prior=prior, seed=testbed.seed)
            rows[f"{name}, {prior}"] = projector.decode(drawn, windows.shape[1])[0]
            if prior == PRIORS[0]:
                rows[f"{name}, {prior}, possible"] = motion_of(projector, drawn, windows.shape[1])[0]
    return drawing.strips(
        {name: local_positions(motion) for name, motion in rows.items()},
        "local: from a Gaussian around a real code; uniform: each unit at each step from [-1, 1]; range: between the "
        "unit's minimum and maximum; values: from the unit's values in real motion",
    )


def filters(testbed: Testbed, units: Sequence[int] | None = None) -> Figure:
    """Draw the motions of single hidden units of the first manifold (default: the units that vary most)."""
    name, manifold = next(iter(testbed.manifolds.items()))
    codes = manifold.encode(testbed.training.windows)
    if units is None:
        units = [int(unit) for unit in codes.std(axis=(0, 1)).argsort()[::-1][:DRAWN]]
    n_frames = testbed.training.windows.shape[1]
    rows = {f"unit {unit}": filter_motion(manifold, codes.shape[1:], unit, n_frames) for unit in units}
    return drawing.strips(
        {name: local_positions(motion) for name, motion in rows.items()},
        f"{name}: enlarged effect of a single hidden unit at one step on the motion of the zero code",
    )


def whole_clips(motions: MotionSet, clips: Sequence[int], *notes: str) -> Figure:
    """Draw whole clips."""
    actions = labels_of(motions)
    rows = {f"{motions.clips[i].name} {actions[i]}": local_positions(motions.features[i]) for i in clips}
    return drawing.strips(rows, "each row is a whole clip; lengths differ", *notes)


def retrieval(records: Iterable[Record]) -> Figure:
    """Draw the mean average precision of every method by kind of match, from the records of `nearness`."""
    values: dict[str, dict[str, float]] = {}
    lines: dict[str, None] = {}
    for record in records:
        if record["application"] == "nearest" and record["metric"] == "map":
            fields = parse_signature(record["signature"])
            fields.pop("model", None)
            lines[signature(**fields)] = None
            values.setdefault(record["method"], {})[f"{fields['source']}, {fields['matches']}"] = record["value"]
    return drawing.bars(values, "mean average precision", *lines)


def moving_interpolation(testbed: Testbed, clips: Sequence[int] | None = None) -> str:
    """Return a page on which two motions, and interpolations between them, move side by side."""
    motions = testbed.motions
    chosen = _pair(motions) if clips is None else clips
    first, second = (first_window(motions, clip)[0] for clip in chosen)
    names = (motions.clips[chosen[0]].name, motions.clips[chosen[1]].name)
    projector = next(iter(testbed.manifolds.values()))
    moved = moving_interpolations(first, second, projector=projector, names=names)
    notes = [_caption(motions, clip) for clip in chosen]
    return motion_page(moved, title="interpolation", fps=FPS, skeleton=JOINTS, notes=notes)


def _pair(motions: MotionSet) -> tuple[int, int]:
    """Return two clips with whole windows: `PAIR` and a walk if present, otherwise the first two."""
    clips = list(dict.fromkeys(int(motions.clip_of[i]) for i in np.flatnonzero(motions.mask.all(axis=1))))
    actions = labels_of(motions)
    first = next((clip for clip in clips if motions.clips[clip].name == PAIR), clips[0])
    others = [clip for clip in clips if clip != first]
    if not others:
        raise ValueError("CLIP: interpolation needs whole windows of two clips")
    return first, next((clip for clip in others if actions[clip] == "walk"), others[0])


def all_figures(testbed: Testbed, records: Sequence[Record]) -> Iterator[tuple[str, Figure]]:
    """Yield the name and figure of every application, and of retrieval if the records have any."""
    for application in RESTORATIONS:
        yield application, restoration(testbed, application)
    yield "interpolate", interpolation(testbed)
    yield "sample", samples(testbed)
    yield "filters", filters(testbed)
    query = testbed.test.clips[0]
    index = clip_named(testbed.motions, f"{query.source}/{query.name}")
    name = next(iter(testbed.manifolds))
    nearest = [record["index"] for record in ranking(testbed, index, 5) if record["method"] == name]
    yield "nearest", whole_clips(testbed.motions, [index, *nearest], f"nearest to the first by G of {name}")
    if any(record["application"] == "nearest" for record in records):
        yield "retrieval", retrieval(records)


def _caption(motions: MotionSet, clip: int) -> str:
    what = motions.clips[clip]
    return f"{what.source} {what.name}: {what.description}"
