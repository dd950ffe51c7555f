"""Golden values: scores of one small pair, to tell whether a machine computes what it should."""

from __future__ import annotations

import numpy as np

from npss._metric.convention import CONVENTIONS
from npss._metric.euler_error import euler_error
from npss._metric.score import score, score_windows
from npss._metric.signature import signature
from npss.validation import Float64

#: Signature -> value. For NPSS, a change here is a change of the metric's version.
GOLDEN = {
    "npss|version:1|convention:paper|frames:12": 0.24225672877846768,
    "npss|version:1|convention:released|frames:12": 0.13955109642887997,
    "npss|version:1|convention:literal|frames:12": 0.25217421654704647,
    "npss|version:1|convention:paper|frames:12|fps:3|window:0-1": 0.02140068156302469,
    "npss|version:1|convention:paper|frames:12|fps:3|window:1-2": 0.3829341428201235,
    "npss|version:1|convention:paper|frames:12|fps:3|window:2-4": 0.3612245210929423,
    "npss|version:1|convention:released|frames:12|fps:3|window:0-1": 0.9761889663918832,
    "npss|version:1|convention:released|frames:12|fps:3|window:1-2": 0.5867003367003366,
    "npss|version:1|convention:released|frames:12|fps:3|window:2-4": 1.4413176406132293,
    "npss|version:1|convention:literal|frames:12|fps:3|window:0-1": 0.021248339973439556,
    "npss|version:1|convention:literal|frames:12|fps:3|window:1-2": 0.4446311858076563,
    "npss|version:1|convention:literal|frames:12|fps:3|window:2-4": 0.2752358752358752,
    "euler_error|version:1|frames:12|fps:25|average:at|columns:gt": 8.340353225079447,
    "euler_error|version:1|frames:12|fps:25|average:at|columns:pred": 9.824578945360631,
    "euler_error|version:1|frames:12|fps:25|average:at|columns:all": 10.63201574054866,
    "euler_error|version:1|frames:12|fps:25|average:up-to|columns:gt": 5.3704829763468505,
    "euler_error|version:1|frames:12|fps:25|average:up-to|columns:pred": 5.6208893596223675,
    "euler_error|version:1|frames:12|fps:25|average:up-to|columns:all": 6.283508231380057,
}
#: The largest relative difference that rounding on another machine explains: sums of a dozen terms, with much to spare.
TOLERANCE = 1e-12


def golden_pair() -> tuple[Float64, Float64]:
    """Return ground truth and prediction: two sequences of 12 frames and three features, two of which are still."""
    t = np.arange(12.0)[:, np.newaxis]
    gt = np.hstack([1 + t % 4, (t * t) % 7, t - 5.5])
    pred = np.hstack([1 + t % 3, (t * t) % 5, 5.5 - t])
    gt, pred = np.stack([gt, gt]), np.stack([pred, pred[:, ::-1]])
    gt[1, :, 0], pred[1, :, 2] = 3, 0
    return gt, pred


def computed() -> dict[str, float]:
    """Compute the golden values on this machine: NPSS of the first sequence, the others of both; errors at 480 ms."""
    gt, pred = golden_pair()
    values = {}
    for name in CONVENTIONS:
        values[signature(name, frames=12)] = score(gt[:1], pred[:1], convention=name)
    for name in CONVENTIONS:
        for window, value in score_windows(gt, pred, fps=3, convention=name).items():
            values[signature(name, frames=12, fps=3, window=window)] = value
    for average in ("at", "up-to"):
        for columns in ("gt", "pred", "all"):
            errors = euler_error(gt, pred, fps=25, at_ms=(480,), columns=columns, average=average)
            text = signature(None, metric="euler_error", frames=12, fps=25, average=average, columns=columns)
            values[text] = errors[480]
    return values
