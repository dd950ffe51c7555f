"""Draw skeletons at several times, one row per motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Literal, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.frames import whole_frames
from npss.plot.style import COLOURS, GREY, SMALL, TRUTH, by_defaults, footnote, label, new_figure
from npss.validation import Array, check_finite, each, is_real, one_of, positive_number, real_array

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from npss.skeleton import Skeleton

_COLOUR = {"left": COLOURS[0], "right": COLOURS[1], "centre": TRUTH}
#: The axis that points up.
Up = Literal["y", "z"]
_CELL = 1.9  # height of a skeleton, in inches


@by_defaults
def film_strip(
    motions: Mapping[str, npt.ArrayLike],
    *,
    fps: float,
    at_ms: Sequence[float] = (160, 560, 1000, 2000, 4000),
    skeleton: Skeleton,
    up: Up = "y",
    azimuth: float = -60,
) -> Figure:
    """Draw skeletons at given times, one row per motion.

    Each is seen along a level line, without perspective, centred on its root; all are drawn to one scale.

    Parameters
    ----------
    motions : mapping of str to (T, J, 3) array_like
        Positions of the joints by the motion's name, the ground truth first; for Human3.6M those of
        `npss.skeleton.poses_to_positions`. They may differ in T.
    fps : float
        Frames per second.
    at_ms : sequence of float, optional
        Times in milliseconds after the last seed frame: at 25 frames per second, 80 ms is the second predicted frame.
    skeleton : npss.skeleton.Skeleton
        The bones and the side of each.
    up : {'y', 'z'}, optional
        The axis that points up.
    azimuth : float, optional
        The direction of view, in degrees: with y up, 0 is from z, the front of a figure that faces ahead, and 90 from
        x, its left; with z up, 0 is from -y.

    Returns
    -------
    matplotlib.figure.Figure
        A figure with one axes for each time of each motion.

    Raises
    ------
    ImportError
        If matplotlib is missing.
    TypeError, ValueError
        If there are no motions or times, a shape is not ``(T, J, 3)``, a position is not finite, a time is not a frame
        or beyond the last, or an option is not one of its choices.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, figure 2.

    Examples
    --------
    >>> import numpy as np
    >>> import npss.plot
    >>> from npss.skeleton import H36M, poses_to_positions
    >>> still = poses_to_positions(np.zeros((100, 99)))
    >>> figure = npss.plot.film_strip({"still": still}, fps=25, skeleton=H36M)
    >>> len(figure.axes)
    5
    """
    rate = positive_number("fps", fps)
    one_of("up", up, get_args(Up))
    if not (is_real(azimuth) and math.isfinite(azimuth)):
        raise ValueError(f"azimuth: expected an angle in degrees, got {azimuth!r}")
    if not isinstance(motions, Mapping):
        raise TypeError(f"motions: expected a mapping of names to positions, got {type(motions).__name__}")
    times = each("at_ms", at_ms, "times")
    if not motions or not times:
        raise ValueError(f"{'at_ms: no time' if motions else 'motions: no motion'} to draw")
    drawn = []
    for name, positions in motions.items():
        array = _positions(f"motions[{name!r}]", positions, len(skeleton.names))
        frames = [whole_frames("at_ms", time, rate, first=1, last=len(array)) - 1 for time in times]
        drawn.append(array[frames] - array[frames][:, [skeleton.parents.index(-1)]])
    across, upwards, depth = _view(np.stack(drawn), up, math.radians(azimuth))  # each (motions, times, J)

    figure, cells = _cells(len(motions), len(times), across, upwards)
    from matplotlib.collections import LineCollection

    bones = np.array(skeleton.bones)  # (bones, 2)
    colours = np.array([_COLOUR[skeleton.sides[child]] for child, _ in bones])
    for row, name in enumerate(motions):
        cells[row, 0].set_ylabel(label(name), fontsize=SMALL)
        for column, time in enumerate(times):
            place = np.stack([across[row, column], upwards[row, column]], axis=-1)  # (J, 2)
            near_last = np.argsort(depth[row, column][bones].mean(axis=1), kind="stable")
            lines = LineCollection(place[bones[near_last]], colors=colours[near_last], linewidths=1.8, capstyle="round")
            cells[row, column].add_collection(lines)
            if row == 0:
                cells[row, column].set_title(f"{time:g} ms", fontsize=SMALL, color=GREY)
    footnote(figure, f"left side blue, right side orange; times after the last seed frame, {rate:g} frames per second")
    return figure


def _positions(name: str, values: npt.ArrayLike, n_joints: int) -> Array:
    array = real_array(name, values)
    if array.ndim != 3 or array.shape[1:] != (n_joints, 3) or len(array) == 0:
        raise ValueError(f"{name}: expected shape (T, J, 3) = (frames, {n_joints}, 3), got {array.shape}")
    check_finite(name, array)
    return array.astype(np.float64)


def _view(positions: Array, up: str, azimuth: float) -> tuple[Array, Array, Array]:
    """Return coordinates ``(..., J)`` of positions ``(..., J, 3)``: to the right, upwards, and towards the viewer."""
    left, upwards, ahead = np.moveaxis(positions, -1, 0) if up == "y" else _z_up(positions)
    across = math.cos(azimuth) * left - math.sin(azimuth) * ahead
    return across, upwards, math.sin(azimuth) * left + math.cos(azimuth) * ahead


def _z_up(positions: Array) -> tuple[Array, Array, Array]:
    x, y, z = np.moveaxis(positions, -1, 0)
    return x, z, -y


def _cells(n_rows: int, n_columns: int, across: Array, upwards: Array) -> tuple[Figure, npt.NDArray[np.object_]]:
    """Return a figure of cells without axes, on a common scale that fits every skeleton."""
    margin = 0.05 * float(np.ptp(upwards)) or 1.0
    limits = [(float(values.min()) - margin, float(values.max()) + margin) for values in (across, upwards)]
    (west, east), (south, north) = limits
    width = max(0.8, _CELL * (east - west) / (north - south))
    figure = new_figure(0.6 + n_columns * width, 0.6 + n_rows * _CELL)
    cells = figure.subplots(n_rows, n_columns, squeeze=False)
    for axes in cells.flat:
        axes.set(xlim=limits[0], ylim=limits[1], xticks=[], yticks=[], aspect="equal")
        axes.spines[:].set_visible(False)
    return figure, cells
