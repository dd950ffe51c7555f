"""The registry of metrics: built-in ones and those that users register."""

from __future__ import annotations

from collections.abc import Iterable
from functools import partial
from typing import Any

import numpy as np

from npss._metric.contributions import contributions
from npss._metric.convention import CONVENTIONS, Convention, as_convention
from npss._metric.euler_error import mse, sequence_errors
from npss._metric.frames import whole_frames
from npss._metric.in_betweening import flat_l2p, flat_l2q
from npss._metric.metric import Measured, Metric
from npss._metric.position_error import Align, sequence_position_errors, sequence_root_errors
from npss._metric.rotation_error import sequence_rotation_errors
from npss._metric.spectrum import EPSILON, spectrum_divergence
from npss.plugins import Registry
from npss.rotations._poses import POSE, UNSCORED
from npss.validation import Float64


def _npss(gt: Float64, pred: Float64, *, convention: str | Convention) -> Measured:
    of_columns = contributions(gt, pred, as_convention(convention))
    return Measured(of_columns.score, *of_columns.by_sequence(), of_columns.parts())


def _euler_error(gt: Float64, pred: Float64, *, fps: float, at_ms: float) -> Measured:
    frame = whole_frames("at_ms", at_ms, fps, first=1, last=gt.shape[1]) - 1
    errors = sequence_errors(gt, pred)[:, frame]
    return Measured(float(errors.mean()), errors, np.ones(len(errors)))


def _mse(gt: Float64, pred: Float64) -> Measured:
    parts = [mse(*pair) for pair in zip(gt, pred, strict=True)]
    return Measured(mse(gt, pred), np.array(parts), np.ones(len(parts)))


def _at(errors: Float64, fps: float, at_ms: float) -> Float64:
    """Return the error of each sequence at a time, from ``(N, T)``."""
    return errors[:, whole_frames("at_ms", at_ms, fps, first=1, last=errors.shape[1]) - 1]


def _flat(*positions: Float64) -> list[Float64]:
    """Flatten joint by joint: three joints are not matrices."""
    return [x.reshape(*x.shape[:2], -1) for x in positions]


def _position_error(gt: Float64, pred: Float64, *, fps: float, at_ms: float, align: Align | None = None) -> Float64:
    return _at(sequence_position_errors(*_flat(gt, pred), align=align), fps, at_ms)


def _root_error(gt: Float64, pred: Float64, *, fps: float, at_ms: float) -> Float64:
    return _at(sequence_root_errors(*_flat(gt, pred)), fps, at_ms)


def _trajectory_error(gt: Float64, pred: Float64, *, fps: float, at_ms: float) -> Float64:
    return _at(sequence_root_errors(*_flat(gt, pred), up="y"), fps, at_ms)


def _rotation_error(gt: Float64, pred: Float64, *, fps: float, at_ms: float) -> Float64:
    if gt.shape[-1] != POSE:
        raise ValueError(
            f"gt: expected Human3.6M poses, exponential maps of {POSE} features, got {gt.shape[-1]}; "
            f"npss.rotation_error takes any rotations"
        )
    joints = (x[..., UNSCORED:] for x in (gt, pred))
    return _at(sequence_rotation_errors(*joints, representation="expmap"), fps, at_ms)


NPSS = Metric(
    name="npss",
    function=_npss,
    says="the power-weighted mean distance between the power spectra of prediction and ground truth",
    heading="NPSS",
    aggregation="weighted mean",
    options=("convention",),
    fields={"convention": None, "unwrap": None},
)
EULER_ERROR = Metric(
    name="euler_error",
    function=_euler_error,
    says="the Euclidean norm of the difference of Euler angles in a frame, averaged over sequences",
    heading="Euler error",
    options=("fps", "at_ms"),
    unit="rad",
    digits=3,
    fields={"columns": "gt", "average": "at", "still": None},
)
MSE = Metric(
    name="mse",
    function=_mse,
    says="the mean, over sequences, frames and features, of the squared difference",
    heading="MSE",
)
L2Q = Metric(
    name="l2q",
    function=flat_l2q,
    says="the Euclidean norm of the difference of global quaternions, averaged over frames and sequences",
    heading="L2Q",
    digits=4,
    fields={"hemisphere": "anchored", "norm": "pose"},
)
L2P = Metric(
    name="l2p",
    function=flat_l2p,
    says="the Euclidean norm of the difference of global positions, averaged over frames and sequences",
    heading="L2P",
    digits=4,
    fields={"norm": "pose", "positions": None},
)

_POSITIONS: dict[str, Any] = {
    "takes": "positions",
    "options": ("fps", "at_ms"),
    "unit": "mm",
    "digits": 1,
}
#: Records state that the root of poses is fixed; for other positions, the caller states what it does.
_POSE = {"average": "at", "root": None}
POSITION_ERROR = Metric(
    name="position_error",
    function=_position_error,
    says="the distance of predicted from true joints in a frame, averaged over joints and sequences (MPJPE)",
    heading="Position error",
    fields={**_POSE, "align": "none"},
    **_POSITIONS,
)
ALIGNED_POSITION_ERROR = Metric(
    name="aligned_position_error",
    function=partial(_position_error, align="procrustes"),
    says="the position error after the best rotation, translation and scale of each predicted frame (PA-MPJPE)",
    heading="Aligned position error",
    fields={**_POSE, "align": "procrustes"},
    **_POSITIONS,
)
ROOT_ERROR = Metric(
    name="root_error",
    function=_root_error,
    says="the distance of the predicted from the true root in a frame, averaged over sequences",
    heading="Root error",
    fields={"average": "at"},
    **_POSITIONS,
)
TRAJECTORY_ERROR = Metric(
    name="trajectory_error",
    function=_trajectory_error,
    says="the distance on the floor of the predicted from the true root in a frame, averaged over sequences",
    heading="Trajectory error",
    fields={"average": "at", "up": "y"},
    **_POSITIONS,
)
ROTATION_ERROR = Metric(
    name="rotation_error",
    function=_rotation_error,
    says="the angle between predicted and true rotations of joints in a frame, averaged over joints and sequences",
    heading="Rotation error",
    takes="poses",
    options=("fps", "at_ms"),
    unit="rad",
    digits=3,
    fields={"average": "at", "joints": "all scored", "unit": "rad"},
)
SPECTRUM_DIVERGENCE = Metric(
    name="spectrum_divergence",
    function=spectrum_divergence,
    says="the Kullback-Leibler divergence of the power spectra of the whole set, averaged over features",
    heading="Spectrum divergence",
    aggregation="none",
    unit="nats",
    fields={"direction": "gt-pred", "spectra": "set", "features": "all", "epsilon": EPSILON},
)

#: All metrics by name: the built-in ones, and registered ones.
METRICS: Registry[Metric] = Registry(
    "metric",
    {
        metric.name: metric
        for metric in (
            NPSS,
            EULER_ERROR,
            MSE,
            POSITION_ERROR,
            ALIGNED_POSITION_ERROR,
            ROOT_ERROR,
            TRAJECTORY_ERROR,
            ROTATION_ERROR,
            SPECTRUM_DIVERGENCE,
            L2Q,
            L2P,
        )
    },
)


def register(metric: Metric, *, replace: bool = False) -> Metric:
    """Register a metric, so that records, tables, comparisons, signatures and commands accept its name.

    Parameters
    ----------
    metric : Metric
        The metric.
    replace : bool, optional
        Replace a registered metric of the same name, as when a notebook cell is run again.

    Returns
    -------
    Metric
        The same metric.

    Raises
    ------
    TypeError
        If it is not a `Metric`.
    ValueError
        If the name is taken by a built-in metric, or by another one without `replace`; or if the name or heading is
        that of another metric.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> from npss.metrics import Metric, register
    >>> def bias(gt, pred):
    ...     return np.abs((pred - gt).mean(axis=(1, 2)))
    >>> metric = register(Metric(name="bias", function=bias, says="the mean difference of angles", unit="rad"))
    >>> gt = np.arange(12.0).reshape(1, 4, 3)
    >>> npss.records.measure(gt, gt + 0.5, metrics=["bias"], frames=4)["metrics"]
    {'bias': 0.5}
    >>> print(npss.explain("bias|version:1|frames:4").splitlines()[0])
    bias: the mean difference of angles.
    """
    if not isinstance(metric, Metric):
        raise TypeError(f"metric: expected a Metric, got {metric!r}")
    for other in METRICS.values():
        if other.name == metric.name:
            continue
        if _alike(metric.heading, other.heading):
            raise ValueError(
                f"metric: the heading {metric.heading!r} is ambiguous: {other.name!r} has the heading {other.heading!r}"
            )
        if shared := {metric.name, metric.heading} & {other.name, other.heading}:
            raise ValueError(f"metric: {shared.pop()!r} is ambiguous: it is a name of {other.name!r}, too")
    METRICS.register(metric.name, metric, replace=replace)
    return metric


def metric_called(name: object, argument: str = "metric") -> Metric:
    """Return the metric with this name or heading.

    Raises
    ------
    TypeError, ValueError
        If there is none. The message names the argument.
    """
    if not isinstance(name, str):
        raise TypeError(f"{argument}: expected the name of a metric, got {name!r}")
    metric = METRICS.get(name) or next((metric for metric in METRICS.values() if metric.heading == name), None)
    if metric is None:
        raise ValueError(f"{argument}: unknown metric {name!r}; known: {', '.join(METRICS)}")
    return metric


def metric_of_column(column: str) -> Metric | None:
    """Return the metric of a column, or None if it is unknown."""
    return next((metric for metric in METRICS.values() if _alike(metric.heading, column)), None)


def direction(higher: Iterable[str]) -> str:
    """Describe the better direction, given the columns or headings for which higher is better."""
    names = ", ".join(higher)
    return f"lower is better, except for {names}" if names else "lower is better"


def score_heading(name: str) -> str:
    """Return the heading of a score by its name in a record: that of a convention or a metric."""
    if name in CONVENTIONS:
        return NPSS.column(convention=name)
    return METRICS[name].heading if name in METRICS else name


def _alike(one: str, other: str) -> bool:
    """Return whether the two are equal, or one begins with the other and a blank."""
    return f"{one} ".startswith(f"{other} ") or f"{other} ".startswith(f"{one} ")
