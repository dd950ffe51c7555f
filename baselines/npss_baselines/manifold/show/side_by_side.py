"""Clips side by side: as a moving page, and as rows of stick figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import numpy.typing as npt

from npss.commands import motion_page
from npss.validation import Float64
from npss_baselines.data.bvh import Bvh
from npss_baselines.data.mapping import JointMapping
from npss_baselines.data.motion import JOINTS
from npss_baselines.data.upright import Up, with_y_up
from npss_baselines.manifold.clips.filling import last_known
from npss_baselines.manifold.motion.features import FPS, local_positions
from npss_baselines.manifold.motion.own_clip import body_height, prepare_clip
from npss_baselines.manifold.show import drawing

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The height of a figure on a page, in millimetres.
HEIGHT = 1700.0
#: The number of figures in a row of a picture.
FIGURES = 12


class Shown(NamedTuple):
    """A clip to show."""

    motion: Bvh
    mapping: JointMapping
    up: Up


def page(
    clips: Mapping[str, Shown],
    *,
    title: str,
    notes: Sequence[str] = (),
    spans: Sequence[tuple[str, float, float]] = (),
    truth: str | None = None,
) -> str:
    """Make a page on which the common joints of clips move side by side.

    Parameters
    ----------
    clips : mapping of str to Shown
        The clips by label. Those on the skeleton of the first one keep their places relative to it.
    title : str
        The headline.
    notes : sequence of str, optional
        Lines below.
    spans : sequence of (str, float, float), optional
        Stretches of time to look at, in seconds, and what they are.
    truth : str, optional
        The label of the ground truth.

    Returns
    -------
    str
        The page as HTML.

    Raises
    ------
    ValueError
        If a clip goes farther than a page can show.
    """
    places = {label: _places(shown) for label, shown in clips.items()}
    first = next(iter(clips.values())).motion.skeleton.names
    centre = _centre(next(iter(places.values())))
    moved = {
        label: HEIGHT * (positions - (centre if clips[label].motion.skeleton.names == first else _centre(positions)))
        for label, positions in places.items()
    }
    rate = next(iter(clips.values())).motion.fps
    return motion_page(
        moved, title=title, fps=FPS, skeleton=JOINTS, truth=truth, notes=notes, spans=spans, frame_rate=rate
    )


def picture(clips: Mapping[str, Shown], *notes: str, spans: Sequence[tuple[float, float]] = ()) -> Figure:
    """Draw each clip as a row of stick figures.

    Parameters
    ----------
    clips : mapping of str to Shown
        The clips by label.
    *notes : str
        Lines of the caption.
    spans : sequence of (float, float), optional
        Stretches of time, in seconds, from which most of the figures are taken.

    Raises
    ------
    ImportError
        If matplotlib is missing.
    """
    rows = {
        label: local_positions(prepare_clip(_upright(shown), shown.mapping).features) for label, shown in clips.items()
    }
    longest = max(len(positions) for positions in rows.values())
    return drawing.strips(rows, *notes, frames=_chosen(spans, longest) if spans else None)


def _chosen(spans: Sequence[tuple[float, float]], n_frames: int) -> list[int]:
    """Return up to `FIGURES` frames of a motion, two of three from stretches of time if they have as many."""
    times = np.arange(n_frames) / FPS
    within = np.any([(start <= times) & (times < end) for start, end in spans], axis=0)
    inside, outside = np.flatnonzero(within), np.flatnonzero(~within)
    n_inside = max(min(len(inside), FIGURES * 2 // 3), FIGURES - len(outside))
    return sorted(
        {int(frame) for part, n in ((inside, n_inside), (outside, FIGURES - n_inside)) for frame in _spread(part, n)}
    )


def _spread(frames: npt.NDArray[np.intp], n: int) -> npt.NDArray[np.intp]:
    """Return up to n of some frames, evenly spread from the first to the last."""
    n = min(n, len(frames))
    return frames[np.linspace(0, len(frames) - 1, n).round().astype(int)] if n else frames[:0]


def _upright(shown: Shown) -> Bvh:
    """Return a clip with y up, whose missing values are the last known ones."""
    motion = replace(
        shown.motion,
        rotations=last_known(shown.motion.rotations),
        translations=last_known(shown.motion.translations),
    )
    return with_y_up(motion, shown.up)


def _places(shown: Shown) -> Float64:
    """Return the positions of the common joints in body heights, in the frames nearest to 30 per second."""
    motion = _upright(shown)
    common = shown.mapping.positions(motion.positions(), motion.skeleton)
    frames = np.arange(0, len(common), motion.fps / FPS).round().astype(int)
    places: Float64 = common[np.minimum(frames, len(common) - 1)] / body_height(common)
    return places


def _centre(places: Float64) -> Float64:
    """Return the middle of a path, on the ground."""
    hips = places[:, 0]
    middle: Float64 = (hips.min(axis=0) + hips.max(axis=0)) / 2
    middle[1] = places[..., 1].min()
    return middle
