"""A page of moving skeletons, side by side."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from html import escape

import numpy.typing as npt

from npss._pages._html import figure, pack, page, positions_array
from npss.skeleton import Skeleton
from npss.validation import real_array


def motion_page(
    motions: Mapping[str, npt.ArrayLike],
    *,
    title: str,
    fps: float,
    skeleton: Skeleton,
    truth: str | None = None,
    notes: Sequence[str] = (),
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

    Returns
    -------
    str
        The page as HTML, one file that needs no network.

    Raises
    ------
    TypeError
        If positions are not real numbers.
    ValueError
        If there is no motion, a shape is wrong, positions are not finite or too far from the origin, or no motion has
        the label `truth`.
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
    lines = "".join(f"<li>{escape(note)}</li>" for note in notes)
    return page(
        title=title,
        body=f'<main>\n<h1>{escape(title)}</h1>\n<div id="player"></div>\n'
        f'<p class="note">Drag a figure to turn all of them.</p>\n{f"<ul>{lines}</ul>" if lines else ""}\n</main>',
        scripts=("player.js", "motion.js"),
        data={"figure": figure(skeleton, fps), "panels": panels},
    )
