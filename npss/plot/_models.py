"""Draw the models of a leaderboard, with intervals."""

from __future__ import annotations

from typing import TYPE_CHECKING

from npss._metric.registry import direction
from npss.plot.style import COLOURS, GREY, SMALL, TRUTH, by_defaults, footnote, label, new_figure, tidy

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from npss.ranking._frame import Leaderboard

_MARKERS = {
    "": ("o", COLOURS[0], "yours"),
    "published": ("D", TRUTH, "published"),
    "reference": ("s", GREY, "reference"),
}


@by_defaults
def models(board: Leaderboard, *, column: str | None = None) -> Figure:
    """Draw one column of a leaderboard: each model on each action, with its interval.

    Parameters
    ----------
    board : Leaderboard
        The leaderboard, or a selection of its models, actions and columns.
    column : str, optional
        The column, such as ``'NPSS released'``; by default the one by which the leaderboard is sorted.

    Returns
    -------
    matplotlib.figure.Figure
        A figure with an axes for each action, the best model of the first action on top. The best of an action has a
        full marker, and so have those that are not significantly worse; those that are have an empty one.

    Raises
    ------
    ImportError
        If matplotlib is missing.
    TypeError
        If `board` is not a leaderboard.
    ValueError
        If the leaderboard has no such column, or a value was changed.

    See Also
    --------
    npss.leaderboard : make the leaderboard.

    Examples
    --------
    >>> import numpy as np
    >>> import npss.plot
    >>> rng = np.random.default_rng(0)
    >>> gt = rng.normal(size=(12, 50, 3)).cumsum(axis=1)
    >>> reports = {name: npss.report(gt, gt + size * rng.normal(size=gt.shape)) for name, size in (("a", 1), ("b", 9))}
    >>> figure = npss.plot.models(npss.leaderboard(reports))
    >>> [text.get_text() for text in figure.axes[0].get_yticklabels()]
    ['a', 'b']
    """
    if not hasattr(board, "standings"):
        raise TypeError(f"board: expected a leaderboard from npss.leaderboard, got {type(board).__name__}")
    standings = board.standings
    columns = list(dict.fromkeys(standing.result.column for standing in standings))
    chosen = column if column is not None else board.by if board.by in columns else columns[0] if columns else None
    if chosen not in columns:
        raise ValueError(f"column: expected one of {', '.join(columns) or 'none'}, got {chosen!r}")
    drawn = [standing for standing in standings if standing.result.column == chosen]
    actions = list(dict.fromkeys(standing.result.action for standing in drawn))
    names: dict[str, None] = {}
    for action in actions:
        of_action = [standing for standing in drawn if standing.result.action == action]
        names |= dict.fromkeys(one.result.label for one in sorted(of_action, key=lambda one: one.result.loss))
    places = {name: -place for place, name in enumerate(names)}
    figure = new_figure(1.5 + 2.5 * max(2, len(actions)), 1.6 + 0.3 * len(names))
    axes_of = dict(zip(actions, figure.subplots(1, len(actions), sharey=True, squeeze=False)[0], strict=True))
    for standing in drawn:
        axes, y = axes_of[standing.result.action], places[standing.result.label]
        marker, colour, _ = _MARKERS[standing.result.kind]
        if standing.low is not None and standing.high is not None:
            axes.plot([standing.low, standing.high], [y, y], color=colour, linewidth=1.2)
        fill = "white" if standing.worse else colour
        axes.plot(standing.result.value, y, marker, color=colour, markerfacecolor=fill, markersize=5)
    first = axes_of[actions[0]]
    first.set_yticks(list(places.values()), [label(name) for name in places])
    for action, axes in axes_of.items():
        axes.set_title(label(action) if action else "", fontsize=SMALL, loc="left")
        axes.set_xlabel(label(chosen), fontsize=SMALL)
        tidy(axes, grid="x")
    kinds = dict.fromkeys(standing.result.kind for standing in drawn)
    if len(kinds) > 1:
        for kind in kinds:
            marker, colour, text = _MARKERS[kind]
            first.plot([], [], marker, color=colour, markersize=5, label=text)
        figure.legend(loc="outside upper left", ncols=3, frameon=False, fontsize=SMALL)
    higher = [standing.result.heading for standing in drawn if not standing.result.lower_is_better]
    lines = [direction(dict.fromkeys(higher))]
    lines += [note for note in board.notes if note.startswith(("Intervals:", "Range:"))]
    if any(standing.worse for standing in drawn):
        lines.append("empty: significantly worse than the best")
    footnote(figure, *lines, *dict.fromkeys(standing.result.signature for standing in drawn))
    return figure
