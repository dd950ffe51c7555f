"""Draw the distance of one feature: two power spectra, and the area between their distributions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from npss._metric.convention import Convention, ConventionName, as_convention
from npss._metric.fields import Value
from npss._metric.power import PowerSpectrum
from npss._metric.score import score
from npss._metric.signature import signature, stated_with
from npss.plot.style import COLOURS, DASHES, GREY, SMALL, TRUTH, by_defaults, footnote, label, new_figure, tidy
from npss.validation import Float64, check_finite, each, is_integer, motion_pair, positive_number

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_FLOOR = 1e-8  # smaller shares are mostly rounding and not shown


@by_defaults
def spectra(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    fps: float,
    sequence: int = 0,
    feature: int = 0,
    convention: ConventionName | Convention = "paper",
    names: Sequence[str] = ("ground truth", "prediction"),
    feature_names: Sequence[str] | None = None,
    extra: Mapping[str, Value] | None = None,
    **context: Value,
) -> Figure:
    """Draw the normalised power spectra of one feature of one sequence, and the area that is their distance.

    The upper panel shows the power on a logarithmic axis, since most of it is in the mean pose (DC). The lower panel
    shows the cumulative distributions over the convention's bins, in the order of cumulation; the shaded area divided
    by the width of a bin is the printed distance (``emd``, in bins). For conventions without cumulation it shows the
    spectra themselves, with a third panel for the bins above DC.

    Parameters
    ----------
    gt, pred : (N, T, D) or (T, D) array_like
        As for `npss.score`.
    fps : float
        Frames per second.
    sequence, feature : int, optional
        Indices of the sequence and the feature, from 0.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `npss.score`.
    names : pair of str, optional
        Names of the ground truth and the prediction.
    feature_names : sequence of str, optional
        Names of the D features, such as ``npss.skeleton.FEATURE_NAMES``.
    extra : mapping of str to str, int, float or bool; optional
        Fields of your own for the signature.
    **context
        Known fields for the signature, as for `npss.signature`.

    Returns
    -------
    matplotlib.figure.Figure
        A figure with two axes, or three without cumulation.

    Raises
    ------
    ImportError
        If matplotlib is missing.
    TypeError, ValueError
        As `npss.score`. If the sequence or feature does not exist, the feature has no power in the ground truth, there
        are not two names, or the number of feature names is not the number of features.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, section 3.5,
    equations 7 to 9.

    Examples
    --------
    >>> import numpy as np
    >>> import npss.plot
    >>> t = np.arange(100)[:, np.newaxis] / 25
    >>> figure = npss.plot.spectra(1 + np.sin(6 * t), 1 + np.sin(5 * t), fps=25)
    >>> figure.savefig("spectra.svg")  # doctest: +SKIP
    >>> print(figure.axes[1].get_title(loc="left"))
    emd = 0.5718 bins = shaded area / 0.25 Hz
    """
    chosen = as_convention(convention)
    rate = positive_number("fps", fps)
    truth, prediction = motion_pair(gt, pred)
    check_finite("gt", truth)
    check_finite("pred", prediction)
    n_frames, n_features = truth.shape[-2:]
    meaning = signature(chosen, **stated_with(spectra, context, extra, frames=n_frames, fps=rate))
    if n_frames < 2:
        raise ValueError("gt: a power spectrum needs at least two frames, got one")
    i = _index("sequence", sequence, len(truth) if truth.ndim == 3 else 1)
    d = _index("feature", feature, n_features)
    labels = [label(name) for name in each("names", names, "two names")]
    if len(labels) != 2:
        raise ValueError(f"names: expected two, for ground truth and prediction, got {len(labels)}")
    feature_name = f"feature {d}" if feature_names is None else _names(feature_names, n_features)[d]

    pair = [
        (array if array.ndim == 3 else array[np.newaxis])[i, :, d].astype(np.float64) for array in (truth, prediction)
    ]
    first, second = (_normalised(series, chosen) for series in pair)
    if not pair[0].any() or not first.any():
        raise ValueError(f"gt: {feature_name} of sequence {i} has no power, so it does not count in the score")
    emd = score(pair[0][:, np.newaxis], pair[1][:, np.newaxis], convention=chosen)

    figure = new_figure(7, 5.6)
    width, n_bins = rate / n_frames, n_frames // 2 + 1
    if chosen.distance == "cdf":
        above, below = figure.subplots(2, 1)
        _draw_area(below, np.cumsum(first), np.cumsum(second), np.arange(len(first) + 1) * width)
        below.set_ylabel("cumulative share", fontsize=SMALL)
        unit = "bins "
    else:
        panels = figure.subplot_mosaic([["above", "above"], ["below", "zoom"]], width_ratios=(2, 1))
        above, below = panels["above"], panels["below"]
        edges = (np.arange(len(first) + 1) - 0.5) * width
        _draw_area(below, first, second, edges)
        below.set_ylabel("share of the power", fontsize=SMALL)
        _draw_zoom(panels["zoom"], first, second, edges, n_bins)
        unit = ""
    _label_frequencies(below, rate, two_sided=chosen.bins == "two-sided")
    below.set_title(f"emd = {emd:.4g} {unit}= shaded area / {width:.4g} Hz", loc="left", fontsize=10)
    _draw_power(above, first, second, labels, width, n_bins)
    kind = "squared real part" if chosen.power == "real" else "squared magnitude"
    above.set_ylabel(f"share of the power\n({kind})", fontsize=SMALL)
    above.set_title(f"{label(feature_name)}, sequence {i}", loc="left", fontsize=10)
    footnote(figure, meaning)
    return figure


def _index(name: str, value: object, size: int) -> int:
    if not is_integer(value):
        raise TypeError(f"{name}: expected an index, got {value!r}")
    if not 0 <= value < size:
        raise ValueError(f"{name}: expected 0 to {size - 1}, got {value}")
    return int(value)


def _names(names: Sequence[str], n_features: int) -> list[str]:
    listed = each("feature_names", names, "names")
    if len(listed) != n_features:
        raise ValueError(f"feature_names: expected {n_features} names, one for each feature, got {len(listed)}")
    return listed


def _normalised(series: Float64, convention: Convention) -> Float64:
    """Return the normalised power of ``(T,)`` values in the convention's bins, bit for bit as in the score."""
    n_frames = len(series)
    power = np.zeros(n_frames // 2 + 1)
    twins = convention.bins == "two-sided"
    if series.any():
        columns, _, _ = PowerSpectrum(n_frames, convention.power, twins=twins).rescaled(series[np.newaxis])
        power = columns[:, 0]
    total = power.sum()
    if total > 0:
        power = power / total
    elif convention.zero == "dc":
        power[0] = 1.0
    if twins:
        paired = slice(1, (n_frames + 1) // 2)
        power[paired] /= 2
        power = np.concatenate([power, power[paired][::-1]])
    return power


def _draw_power(axes: Axes, first: Float64, second: Float64, labels: Sequence[str], width: float, n_bins: int) -> None:
    """Draw the bins from DC to the highest frequency; negative frequencies have the same power."""
    frequencies = np.arange(n_bins) * width
    axes.set_yscale("log")
    for power, name, colour, dash in zip((first, second), labels, (TRUTH, COLOURS[1]), DASHES, strict=False):
        axes.plot(
            frequencies,
            power[:n_bins],
            color=colour,
            linestyle=dash,
            linewidth=1.2,
            marker="o",
            markersize=2.5,
            label=f"{name} (DC {100 * power[0]:.4g} %)",
        )
    lowest = min(power[power > _FLOOR].min(initial=1.0) for power in (first, second))
    axes.set_ylim(lowest / 2, 2)
    axes.set_xlim(-width, frequencies[-1] + width)
    axes.set_xlabel("frequency (Hz)", fontsize=SMALL)
    axes.legend(frameon=False, fontsize=SMALL)
    tidy(axes)


def _draw_area(axes: Axes, first: Float64, second: Float64, edges: Float64) -> None:
    axes.stairs(first, edges, baseline=second, fill=True, color=COLOURS[1], alpha=0.3, linewidth=0)
    for values, colour, dash in zip((first, second), (TRUTH, COLOURS[1]), DASHES, strict=False):
        axes.stairs(values, edges, baseline=None, color=colour, linestyle=dash, linewidth=1.2)
    axes.use_sticky_edges = False  # keep lines along an edge visible
    axes.set_xlim(edges[0], edges[-1])
    tidy(axes)


def _draw_zoom(axes: Axes, first: Float64, second: Float64, edges: Float64, n_bins: int) -> None:
    """Draw the bins above DC that hold 99 % of their power."""
    rest = np.maximum(first, second)[1:n_bins]
    last = 1 + int(np.searchsorted(np.cumsum(rest), 0.99 * rest.sum()))
    _draw_area(axes, first, second, edges)
    axes.set_xlim(edges[1], edges[last + 1])
    axes.set_ylim(0, 1.1 * rest.max() if rest.max() > _FLOOR else 1)
    axes.set_title("without DC", loc="left", fontsize=SMALL)
    axes.set_xlabel("frequency (Hz)", fontsize=SMALL)


def _label_frequencies(axes: Axes, rate: float, *, two_sided: bool) -> None:
    """Label the frequencies; the upper half of two-sided bins are the negative ones."""
    if not two_sided:
        axes.set_xlabel("frequency (Hz)", fontsize=SMALL)
        return
    from matplotlib.ticker import MaxNLocator

    half = [float(tick) for tick in MaxNLocator(5).tick_values(0, rate / 2) if 0 <= tick < 0.95 * rate / 2]
    ticks = half + [rate - tick for tick in half[:0:-1]]
    axes.set_xticks(ticks, [f"{tick:g}" for tick in half] + [f"−{tick:g}" for tick in half[:0:-1]])
    axes.axvline(rate / 2, color=GREY, linewidth=0.8, linestyle=":")
    axes.set_xlabel("frequency (Hz) of all bins, the negative ones last", fontsize=SMALL)
