"""Drawing: rows of stick figures over time, and bar charts."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from npss.plot.style import COLOURS, GREY, SMALL, TINY, TRUTH, by_defaults, footnote, label, new_figure, tidy
from npss.skeleton import Skeleton
from npss.validation import Array
from npss_baselines.data.motion import JOINTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_COLOUR = {"left": COLOURS[0], "right": COLOURS[1], "centre": TRUTH}
_AZIMUTH = np.radians(-55)  # of the view; 0 is from the front
_WIDTH, _HEIGHT = 8.0, 0.65  # inches: of the figure, and of a body height
_ROW, _BELOW = 1.55, 0.2  # body heights: from row to row, and below the ground
_NAME = 2.0  # body heights at the left, for the row's name


@by_defaults
def strips(
    motions: Mapping[str, Array],
    *notes: str,
    skeleton: Skeleton = JOINTS,
    n_figures: int = 12,
    frames: Sequence[int] | None = None,
    fps: float = 30,
) -> Figure:
    """Draw each motion as a row of stick figures over time.

    Parameters
    ----------
    motions : mapping of str to (T, J, 3) ndarray
        Positions in the character's frame, in body heights, y up, by row name. T may differ.
    *notes : str
        Lines of the caption.
    skeleton : npss.skeleton.Skeleton, optional
        The skeleton of the motions.
    n_figures : int, optional
        Stick figures in a row, evenly spread from the first frame to the last.
    frames : sequence of int, optional
        The frames to draw instead; a shorter motion stays in its last frame.
    fps : float, optional
        Frames per second.

    Returns
    -------
    matplotlib.figure.Figure
        A figure with one axes, which has a collection of lines for each row.

    Raises
    ------
    ImportError
        If matplotlib is not installed.
    """
    figure = new_figure(_WIDTH, _HEIGHT * (_ROW * len(motions) + _BELOW) + 0.14 * (len(notes) + 2))
    from matplotlib.collections import LineCollection
    from matplotlib.patches import Rectangle

    axes = figure.subplots()
    n_figures = n_figures if frames is None else len(frames)
    space = (_WIDTH / _HEIGHT - _NAME) / n_figures  # between figures, in body heights
    places = space * (np.arange(n_figures) + 0.5)
    bones = np.array(skeleton.bones)
    colours = np.array([_COLOUR[skeleton.sides[child]] for child, _ in bones])
    same_length = len({len(positions) for positions in motions.values()}) == 1
    for row, (name, positions) in enumerate(motions.items()):
        evenly = np.linspace(0, len(positions) - 1, n_figures).round().astype(int)
        chosen = evenly if frames is None else np.minimum(frames, len(positions) - 1)
        ground = -row * _ROW
        x, up, z = np.moveaxis(positions[chosen], -1, 0)  # each (figures, J)
        across = np.cos(_AZIMUTH) * x - np.sin(_AZIMUTH) * z
        near = np.sin(_AZIMUTH) * x + np.cos(_AZIMUTH) * z
        drawn = np.stack([across + places[:, np.newaxis], up + ground], axis=-1)[:, bones]  # (figures, bones, 2, 2)
        order = np.argsort(near[:, bones].mean(axis=2), axis=1, kind="stable")  # near bones last
        lines = np.take_along_axis(drawn, order[..., np.newaxis, np.newaxis], axis=1).reshape(-1, 2, 2)
        figures = LineCollection(list(lines), colors=colours[order].ravel(), linewidths=1.1, capstyle="round")
        axes.add_collection(figures)
        band = Rectangle((0, ground - _BELOW), space * n_figures, _ROW + _BELOW, transform=axes.transData)
        figures.set_clip_path(band)  # keep invalid poses inside the row
        axes.plot([0, space * n_figures], [ground, ground], color="#DDDDDD", linewidth=0.6, zorder=0)
        axes.text(-_NAME, ground + 0.5, label(name).replace(", ", ",\n"), fontsize=SMALL, va="center")
        if not same_length or row == len(motions) - 1:
            digits = 1 if len(positions) > 2 * fps else 2
            for place, frame in zip(places, chosen, strict=True):
                axes.text(
                    place, ground - 0.05, f"{frame / fps:.{digits}f}", fontsize=TINY, color=GREY, ha="center", va="top"
                )
    axes.set(xlim=(-_NAME, space * n_figures), ylim=(-(len(motions) - 1) * _ROW - _BELOW, _ROW - _BELOW))
    axes.set_axis_off()
    axes.set_aspect("equal")
    footnote(figure, "left side blue, right side orange; seconds", *notes)
    return figure


@by_defaults
def bars(values: Mapping[str, Mapping[str, float]], what: str, *notes: str) -> Figure:
    """Draw groups of horizontal bars, labelled by value.

    Parameters
    ----------
    values : mapping of str to mapping of str to float
        Values by group, then by bar; each group has the same bars.
    what : str
        Label of the value axis.
    *notes : str
        Lines of the caption.

    Raises
    ------
    ImportError
        If matplotlib is not installed.
    """
    groups, names = list(values), list(next(iter(values.values())))
    figure = new_figure(_WIDTH, 0.8 + 0.17 * len(groups) * (len(names) + 1) + 0.12 * len(notes))
    axes = figure.subplots()
    for j, name in enumerate(names):
        places = [-(i * (len(names) + 1) + j) for i in range(len(groups))]
        lengths = [values[group][name] for group in groups]
        drawn = axes.barh(places, lengths, height=0.9, color=COLOURS[j % len(COLOURS)], label=label(name))
        axes.bar_label(drawn, fmt="%.3f", fontsize=SMALL - 1, padding=2)
    middles = [-(i * (len(names) + 1) + (len(names) - 1) / 2) for i in range(len(groups))]
    axes.set_yticks(middles, [label(group) for group in groups])
    axes.set_ylim(-len(groups) * (len(names) + 1) + 1, 1)
    axes.set_xlabel(what, fontsize=SMALL)
    axes.legend(frameon=False, fontsize=SMALL - 1, loc="upper left", bbox_to_anchor=(1, 1))
    tidy(axes, grid="x")
    footnote(figure, *notes)
    return figure
