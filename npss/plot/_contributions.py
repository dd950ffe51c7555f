"""Draw the contributions of joints and sequences to a score."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from npss._analysis.report import joint_of, kind_of
from npss._metric.registry import NPSS
from npss.plot.style import COLOURS, GREY, SMALL, TINY, by_defaults, footnote, label, new_figure, tidy
from npss.validation import Float64

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from npss._analysis.report import Report

_MOST_PRINTED = 12  # sequences; with more, cells are too small for numbers
_LEAST_PRINTED = 0.005


@by_defaults
def contributions(report: Report) -> Figure:
    """Draw the share of each joint of each sequence in the score.

    A share is a weight times a distance, divided by the sum of all; bars show the sums for each joint and sequence.
    Joints without a share are left out, and counted in the footnote.

    Parameters
    ----------
    report : npss.Report
        A report from `npss.report`. Features whose names agree up to the last dot belong to one joint.

    Returns
    -------
    matplotlib.figure.Figure
        A figure with three axes: the heat map, the bars of joints, the bars of sequences.

    Raises
    ------
    ImportError
        If matplotlib is missing.
    ValueError
        If the score is 0, so that there are no shares.

    Examples
    --------
    >>> import numpy as np
    >>> import npss.plot
    >>> motion = np.random.default_rng(0).normal(size=(2, 8, 50, 3)).cumsum(axis=2)
    >>> report = npss.report(*motion, feature_names=["hip", "knee.x", "knee.y"])
    >>> figure = npss.plot.contributions(report)
    >>> [label.get_text() for label in figure.axes[0].get_yticklabels()]
    ['knee', 'hip']
    """
    parts = report.weight * report.emd  # (N, D)
    total = parts.sum()
    if total == 0:
        raise ValueError("report: its score is 0, so there are no shares to draw")
    joint_of_feature = np.array([joint_of(name) for name in report.feature_names])
    ranked = [joint for joint, share in report.joint_share.items() if share > 0]
    shares = np.stack([parts[:, joint_of_feature == joint].sum(axis=1) for joint in ranked]) / total  # (joints, N)
    n_joints, n_sequences = shares.shape

    figure = new_figure(7.5, 1.9 + 0.22 * n_joints)
    grid = figure.add_gridspec(2, 2, width_ratios=(4, 1), height_ratios=(0.8, 0.22 * n_joints))
    heat = figure.add_subplot(grid[1, 0])
    by_joint = figure.add_subplot(grid[1, 1], sharey=heat)
    by_sequence = figure.add_subplot(grid[0, 0], sharex=heat)
    corner = figure.add_subplot(grid[0, 1])

    _draw_cells(heat, corner, shares)
    heat.set_yticks(range(n_joints), [label(joint) for joint in ranked])
    bars = by_joint.barh(range(n_joints), shares.sum(axis=1), color=COLOURS[0])
    by_joint.bar_label(bars, _percents(shares.sum(axis=1)), fontsize=TINY, padding=2)
    by_joint.set_xlim(0, 1.35 * shares.sum(axis=1).max())
    by_joint.set_title(kind_of(report.feature_names), fontsize=SMALL, color=GREY)
    by_joint.xaxis.set_major_formatter(_percent)
    tidy(by_joint, grid="x")
    by_joint.tick_params(labelleft=False)
    bars = by_sequence.bar(range(n_sequences), shares.sum(axis=0), color=COLOURS[0])
    if n_sequences <= _MOST_PRINTED:
        by_sequence.bar_label(bars, _percents(shares.sum(axis=0)), fontsize=TINY, padding=2)
        by_sequence.set_ylim(0, 1.25 * shares.sum(axis=0).max())
    by_sequence.set_title(f"{NPSS.heading} {report.score:.4f}: shares of joints and sequences", loc="left", fontsize=10)
    by_sequence.yaxis.set_major_formatter(_percent)
    tidy(by_sequence, grid="y")
    by_sequence.tick_params(labelbottom=False)

    without = len(set(joint_of_feature.tolist())) - n_joints
    footnote(figure, f"joints without a share: {without}", report.signature)
    return figure


def _draw_cells(axes: Axes, corner: Axes, shares: Float64) -> None:
    """Draw the heat map, its scale in the corner, and the numbers in its cells if they fit."""
    from matplotlib.ticker import MaxNLocator

    image = axes.imshow(shares, cmap="Blues", vmin=0, aspect="auto", interpolation="nearest")
    axes.set_xlabel("sequence", fontsize=SMALL)
    tidy(axes, grid="none")
    corner.set_axis_off()
    scale = corner.inset_axes((0, 0.4, 0.9, 0.2))
    corner.figure.colorbar(image, cax=scale, orientation="horizontal", ticks=MaxNLocator(2), format=_percent)
    scale.set_title("cell", fontsize=SMALL, color=GREY)
    scale.tick_params(labelsize=TINY)
    if shares.shape[1] > _MOST_PRINTED:
        return
    axes.set_xticks(range(shares.shape[1]))
    for (row, column), share in np.ndenumerate(shares):
        if share >= _LEAST_PRINTED:
            colour = "white" if share > 0.6 * shares.max() else "black"
            axes.text(column, row, f"{100 * share:.1f} %", ha="center", va="center", fontsize=TINY, color=colour)


def _percents(shares: Float64) -> list[str]:
    return [f"{100 * share:.1f} %" for share in shares]


def _percent(share: float, _: object) -> str:
    return f"{100 * share:.3g} %"
