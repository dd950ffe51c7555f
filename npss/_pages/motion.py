"""A page of moving skeletons, side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy.typing as npt

from npss._pages._html import figure, pack, page, positions_array
from npss.skeleton import Skeleton
from npss.validation import positive_number, real_array


def motion_page(
    motions: Mapping[str, npt.ArrayLike],
    *,
    title: str,
    fps: float,
    skeleton: Skeleton,
    truth: str | None = None,
    notes: Sequence[str] = (),
    spans: Sequence[tuple[str, float, float]] = (),
    frame_rate: float | None = None,
) -> str:
    """Make a page on which motions play side by side and in step.

    Parameters
    ----------
    motions : mapping of str to (T, J, 3) array_like
        Positions in millimetres, y up, by label. T may differ: a shorter motion stays in its last frame.
    title : str
        The headline.
    fps : float
        Frames per second.
    skeleton : Skeleton
        The skeleton to draw.
    truth : str, optional
        The label of the motion to draw as ground truth, in green.
    notes : sequence of str, optional
        Lines below the motions.
    spans : sequence of (str, float, float), optional
        Stretches of time to look at, each with a line to click below the motions, its beginning and its end in seconds.
        They are marked on the slider, and the motions begin half a second before the first one.
    frame_rate : float, optional
        The rate at which the page counts frames, such as that of the file (default: `fps`).

    Returns
    -------
    str
        The page as HTML, one file that needs no network.

    Raises
    ------
    TypeError
        If positions are not real numbers.
    ValueError
        If there is no motion, a shape is wrong, positions are not finite or too far from the origin, no motion has the
        label `truth`, a span does not end after it begins, or the rate is not positive.
    """
    if not motions:
        raise ValueError("motions: expected at least one")
    if truth is not None and truth not in motions:
        raise ValueError(f"truth: expected one of {', '.join(motions)}, got {truth!r}")
    panels = []
    for label, positions in motions.items():
        name = f"motions[{label!r}]"
        (array,) = positions_array(name, real_array(name, positions)[None], skeleton)
        panels.append({"label": label, "truth": label == truth, "motion": pack(array, skeleton)})
    for text, start, end in spans:
        if not 0 <= start < end:
            raise ValueError(
                f"spans: {text!r}: expected seconds from 0 on, the first before the last; got {start}, {end}"
            )
    lines = "".join(
        f'<li><button type="button" class="link" data-span="{index}">{escape(text)}</button></li>'
        for index, (text, _, _) in enumerate(spans)
    ) + "".join(f"<li>{escape(note)}</li>" for note in notes)
    sides = _sides("motion") + (f"; of the truth: {_sides('truth')}" if truth is not None else "")
    shown = figure(skeleton, fps) | {"rate": positive_number("frame_rate", fps if frame_rate is None else frame_rate)}
    return page(
        title=title,
        body=f'<main>\n<h1>{escape(title)}</h1>\n<div id="player"></div>\n'
        f'<p class="note">Drag a figure to turn all of them. Of the body: {sides}.</p>\n'
        f"{f'<ul>{lines}</ul>' if lines else ''}\n</main>",
        scripts=("player.js", "motion.js"),
        data={"figure": shown, "panels": panels, "spans": [[start, end] for _, start, end in spans]},
    )


def _sides(kind: str) -> str:
    """Return the legend of the sides of a figure."""
    return " and ".join(
        f'<span class="side" style="background: var(--{kind}-{side})"></span> {side} side' for side in ("left", "right")
    )
