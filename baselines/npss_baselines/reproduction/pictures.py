"""The pictures of the reference numbers: models with intervals, and amplitude by frequency; no motion is drawn."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from npss.plot.style import COLOURS, DASHES, SMALL, TINY, TRUTH, by_defaults, footnote, label, new_figure, tidy
from npss.protocol import FPS
from npss.validation import Float64
from npss_baselines.reproduction.results import EIGHT, MANY, Results
from npss_baselines.reproduction.tables import published_value, shown

if TYPE_CHECKING:
    from matplotlib.figure import Figure

#: The frequencies that are summed in a band, and the highest that is drawn: there is little above it. A repetition of
#: half the window has power at every second frequency only.
_BAND, _MOST_HZ = 2, 6.0
_STILL: dict[str, list[float]] = {"prediction": []}


@by_defaults
def models(results: Results, convention: str = "released") -> Figure:
    """Draw the NPSS of each model on each action, with its interval or range, and the published value.

    Parameters
    ----------
    results : Results
        The results.
    convention : str, optional
        The convention.

    Returns
    -------
    matplotlib.figure.Figure
        A figure with an axes for each action.

    Raises
    ------
    ImportError
        If matplotlib is missing.
    """
    actions = results.actions
    rows = {action: shown(results, "table-4", action) for action in actions}
    names = list(dict.fromkeys(row.name for of_action in rows.values() for row in of_action))
    places = {name: -place for place, name in enumerate(names)}
    figure = new_figure(9, 1.5 + 0.28 * len(names))
    axes_of = figure.subplots(1, len(actions), sharey=True, squeeze=False)[0]
    for axes, action in zip(axes_of, actions, strict=True):
        for protocol, colour, shift, marker in ((EIGHT, COLOURS[0], 0.15, "o"), (MANY, COLOURS[1], -0.15, "s")):
            spans = results.spans(action, protocol)
            for name, found in results.of(action, protocol).items():
                if name in places:
                    y, value = places[name] + shift, found.number("npss", convention).value
                    if span := spans.get((name, convention)):
                        axes.plot([span.low, span.high], [y, y], color=colour, linewidth=1.2)
                    axes.plot(value, y, marker, color=colour, markersize=4)
        if convention == "released":
            for row in rows[action]:
                theirs = published_value(row, action, "npss", "released")
                if theirs is not None:
                    axes.plot(theirs, places[row.name], "D", color=TRUTH, markersize=4, fillstyle="none")
        axes.set_title(action, fontsize=SMALL, loc="left")
        axes.set_xlabel(f"NPSS {convention}", fontsize=SMALL)
        axes.set_xlim(left=0)
        tidy(axes, grid="x")
    axes_of[0].set_yticks(list(places.values()), [label(name) for name in names])
    for kind, colour, marker in (
        (f"8 windows ({EIGHT}), range of blocks", COLOURS[0], "o"),
        (f"256 windows ({MANY}), 95 % interval", COLOURS[1], "s"),
        *((("published", TRUTH, "D"),) if convention == "released" else ()),
    ):
        fill = "none" if kind == "published" else "full"
        axes_of[0].plot([], [], marker, color=colour, markersize=4, fillstyle=fill, label=kind)
    figure.legend(loc="outside upper left", ncols=3, frameon=False, fontsize=SMALL)
    lines = {
        found.number("npss", convention).signature
        for protocol in (EIGHT, MANY)
        for action in actions
        for found in results.of(action, protocol).values()
    }
    footnote(figure, "lower is better; mean over the draws of models with noise, and over seeds", *sorted(lines))
    return figure


@by_defaults
def amplitudes(results: Results) -> Figure:
    """Draw the mean amplitude of the moving angles by frequency, of the ground truth and of each model.

    Parameters
    ----------
    results : Results
        The results.

    Returns
    -------
    matplotlib.figure.Figure
        A figure with an axes for each action. The mean pose (0 Hz) is left out.

    Raises
    ------
    ImportError
        If matplotlib is missing.
    """
    actions = results.actions
    rows = dict.fromkeys(row.name for action in actions for row in shown(results, "table-4", action))
    records = {
        (action, name): found.record["amplitude"]
        for action in actions
        for name, found in results.of(action).items()
        if name in rows and "amplitude" in found.record
    }
    moving = [name for name in rows if any(any(records.get((a, name), _STILL)["prediction"][1:]) for a in actions)]
    held = [name for name in rows if name not in moving and any((action, name) in records for action in actions)]
    figure = new_figure(10, 4)
    axes_of = figure.subplots(1, len(actions), sharey=True, squeeze=False)[0]
    for axes, action in zip(axes_of, actions, strict=True):
        lines = {}
        for i, name in enumerate(moving):
            if (action, name) not in records:
                continue
            amplitude = records[action, name]
            lines["ground truth"] = amplitude["truth"], TRUTH, "-", 2.0
            dash = DASHES[i // len(COLOURS) % len(DASHES)]
            lines[name] = amplitude["prediction"], COLOURS[i % len(COLOURS)], dash, 1.2
        for name, (heights, colour, dash, width) in lines.items():
            hertz, bands = _in_bands(heights)
            axes.plot(hertz, bands, color=colour, linestyle=dash, linewidth=width, label=label(name))
        axes.set_yscale("log")
        axes.set_title(action, fontsize=SMALL, loc="left")
        axes.set_xlabel("frequency (Hz)", fontsize=SMALL)
        tidy(axes)
    axes_of[0].set_ylabel("mean amplitude (rad)", fontsize=SMALL)
    handles = {line.get_label(): line for axes in axes_of for line in axes.get_lines()}
    figure.legend(handles.values(), handles, loc="outside right upper", frameon=False, fontsize=TINY)
    note = (
        f"mean over windows ({EIGHT}) and moving Euler angles, jumps of 2π removed; in bands of two frequencies, the "
        "root of the sum of their squares; 0 Hz, the mean pose, is left out"
    )
    footnote(figure, note, *([f"not drawn, since they do not move: {', '.join(held)}"] if held else []))
    return figure


def _in_bands(heights: list[float]) -> tuple[Float64, Float64]:
    """Return the middles of bands in Hz, and their amplitudes: the roots of sums of squares."""
    hertz = np.arange(len(heights)) * FPS / (2 * (len(heights) - 1))
    n = int(np.count_nonzero((hertz > 0) & (hertz <= _MOST_HZ))) // _BAND
    parts = np.stack([hertz, np.asarray(heights)])[:, 1 : 1 + n * _BAND].reshape(2, n, _BAND)
    return parts[0].mean(axis=1), np.sqrt(np.square(parts[1]).sum(axis=1))
