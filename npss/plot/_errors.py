"""Draw the Euler error of models over time, with bands."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from npss._analysis.blocks import Blocks, Label, read_groups
from npss._analysis.interval import ends, method
from npss._metric.euler_error import moving_pair, sequence_errors
from npss._metric.fields import Value
from npss._metric.registry import EULER_ERROR
from npss._metric.signature import signature, stated_with
from npss.plot.style import COLOURS, DASHES, GREY, SMALL, TINY, by_defaults, footnote, label, new_figure, tidy
from npss.protocol import SLICES_MS
from npss.ranking._names import model_name
from npss.validation import Float64, Seed, positive_number

if TYPE_CHECKING:
    from matplotlib.figure import Figure


@by_defaults
def errors(
    gt: npt.ArrayLike,
    preds: Mapping[str, npt.ArrayLike],
    *,
    fps: float,
    groups: Iterable[Label | None] | None = None,
    level: float = 0.95,
    seed: Seed = 0,
    extra: Mapping[str, Value] | None = None,
    **context: Value,
) -> Figure:
    """Draw the Euler error of models over time, each with a pointwise band.

    A band shows the uncertainty of the error at each time over other blocks of the same kind, as
    `npss.Report.interval` does for the score: with fewer than ten blocks, it reaches from the lowest to the highest
    error of a block. Bands of two models may overlap although one is better in nearly every block; compare models by
    `npss.compare`.

    Parameters
    ----------
    gt : (N, T, D) or (T, D) array_like
        Ground truth: Euler angles in radians, as for `npss.euler_error`.
    preds : mapping of str to array_like
        Predictions by the names of the models, each of the shape of `gt`.
    fps : float
        Frames per second.
    groups : sequence of str, int or None, optional
        The block of each sequence, as for `npss.report`; by default each sequence is assumed to be its own block.
    level : float, optional
        The level of the confidence bands.
    seed : int or numpy.random.Generator, optional
        The seed of the generator that resamples.
    extra : mapping of str to str, int, float or bool; optional
        Fields of your own for the signature.
    **context
        Known fields for the signature, as for `npss.signature`.

    Returns
    -------
    matplotlib.figure.Figure
        A figure with one axes. A band is left out if the blocks do not determine its upper end. Sequences without
        motion in the ground truth have no Euler error and are left out; the signature counts them.

    Raises
    ------
    ImportError
        If matplotlib is missing.
    TypeError, ValueError
        As `npss.euler_error_curve`, with the model's name; if there are no models, or the level is not between 0 and 1.

    See Also
    --------
    npss.euler_error_curve : compute the numbers in this picture.

    Examples
    --------
    >>> import numpy as np
    >>> import npss.plot
    >>> gt = np.random.default_rng(0).normal(size=(8, 25, 3)).cumsum(axis=1)
    >>> figure = npss.plot.errors(gt, {"zero": np.zeros_like(gt), "half": gt / 2}, fps=25)
    >>> [line.get_label() for line in figure.axes[0].get_lines()][:2]
    ['zero', 'half']
    """
    rate = positive_number("fps", fps)
    if not isinstance(preds, Mapping):
        raise TypeError(f"preds: expected a mapping of names to predictions, got {type(preds).__name__}")
    if not preds:
        raise ValueError("preds: no model to draw")
    curves: dict[str, Float64] = {}
    for name, pred in preds.items():
        try:
            if (shown := model_name(name)) in curves:
                raise ValueError(f"preds: two models are called {shown!r}")
            moving, predicted, still = moving_pair(gt, pred)
            curve = np.zeros((len(still), moving.shape[-2]))
            curve[~still] = sequence_errors(moving, predicted)
            curves[shown] = curve  # (N, T)
        except (TypeError, ValueError) as error:
            raise type(error)(f"{error}; for {name!r} of preds") from None

    n_sequences, n_frames = int((~still).sum()), curve.shape[1]
    weight = np.broadcast_to(~still, (n_frames, len(still))).astype(np.float64)
    fields: dict[str, Value] = {"frames": n_frames, "fps": rate, **EULER_ERROR.stated()}
    if still.any():
        fields["still"] = int(still.sum())
    meaning = signature(None, metric=EULER_ERROR.name, **stated_with(errors, context, extra, **fields))
    figure = new_figure(7, 4)
    axes = figure.subplots()
    blocks = Blocks(read_groups("groups", groups, len(still)), weight[0])
    times = 1000 * np.arange(1, n_frames + 1) / rate
    bounded = True
    for i, (name, curve) in enumerate(curves.items()):
        colour, dash = COLOURS[i % len(COLOURS)], DASHES[i % len(DASHES)]
        mean = curve.sum(axis=0) / n_sequences
        axes.plot(times, mean, color=colour, linestyle=dash, linewidth=1.5, label=label(name))
        low, high = ends(curve.T, weight, blocks, level=level, seed=seed)
        if np.isfinite(high).all():
            axes.fill_between(times, low, high, color=colour, alpha=0.15, linewidth=0)
        else:
            bounded = False
    slices = [time for time in SLICES_MS if time <= times[-1]]
    for time in slices:
        axes.axvline(time, color=GREY, linewidth=0.6, linestyle=":")
    above = axes.secondary_xaxis("top")
    above.set_xticks(slices, [str(time) for time in slices], rotation=90)
    above.tick_params(labelsize=TINY, colors=GREY, length=0)
    above.spines["top"].set_visible(False)
    axes.set_xlim(0, times[-1])
    axes.set_ylim(bottom=0)
    axes.set_xlabel("time after the last seed frame (ms)", fontsize=SMALL)
    axes.set_ylabel(EULER_ERROR.labelled, fontsize=SMALL)
    axes.legend(frameon=False, fontsize=SMALL)
    tidy(axes, grid="y")
    note = f"mean of {n_sequences} sequences; "
    if bounded:
        note += f"bands: pointwise, {method(blocks, level=level, seed=seed)}\n{blocks}"
    else:
        note += f"no band if the blocks do not bound it\n{blocks}"
    footnote(figure, note, meaning)
    return figure
