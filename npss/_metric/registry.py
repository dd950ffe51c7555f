"""The registry of metrics: built-in ones and those that users register."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from npss._metric.contributions import contributions
from npss._metric.convention import CONVENTIONS, Convention, as_convention
from npss._metric.euler_error import mse, sequence_errors
from npss._metric.frames import whole_frames
from npss._metric.metric import Measured, Metric
from npss.plugins import Registry
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

#: All metrics by name: NPSS, the Euler error, the mean squared error, and registered ones.
METRICS: Registry[Metric] = Registry("metric", {metric.name: metric for metric in (NPSS, EULER_ERROR, MSE)})


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
