"""NPSS, the metric for long-term human motion prediction, with one meaning per number.

>>> import numpy as np
>>> import npss
>>> gt = np.sin(np.arange(100) / 4).reshape(100, 1)
>>> npss.score(gt, gt)
0.0
>>> npss.signature("paper", frames=100)
'npss|version:1|convention:paper|frames:100'
"""

from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

from npss._metric.convention import CONVENTIONS, Convention, ConventionName
from npss._metric.score import score, score_windows

if TYPE_CHECKING:
    from npss import inbetweening, metrics, plot, protocol, published, records, rotations, skeleton, stochastic, study
    from npss._analysis.compare import Comparison, compare
    from npss._analysis.diagnose import Finding, diagnose
    from npss._analysis.interval import Interval, Range
    from npss._analysis.ratio import ratio_interval
    from npss._analysis.report import Report, report
    from npss._identify.identification import Identification
    from npss._identify.identify import identify
    from npss._metric.accumulator import Accumulator
    from npss._metric.euler_error import EulerErrorAt, euler_error, euler_error_curve, mse
    from npss._metric.explain import explain
    from npss._metric.foot_skating import height_weighted_foot_skating
    from npss._metric.parts import Parts
    from npss._metric.position_error import position_error, position_error_curve, root_error, trajectory_error
    from npss._metric.rotation_error import rotation_error
    from npss._metric.signature import METRIC_VERSION, parse_signature, signature
    from npss._metric.spectrum import spectrum_divergence, spectrum_entropy
    from npss._metric.speed import speed_ratio
    from npss.ranking._frame import Leaderboard
    from npss.ranking._leaderboard import leaderboard
    from npss.rotations._poses import poses_to_euler
    from npss.rotations._unwrap import unwrap

__version__ = "0.2.0"

__all__ = [
    "CONVENTIONS",
    "METRIC_VERSION",
    "Accumulator",
    "Comparison",
    "Convention",
    "ConventionName",
    "EulerErrorAt",
    "Finding",
    "Identification",
    "Interval",
    "Leaderboard",
    "Parts",
    "Range",
    "Report",
    "__version__",
    "compare",
    "diagnose",
    "euler_error",
    "euler_error_curve",
    "explain",
    "height_weighted_foot_skating",
    "identify",
    "inbetweening",
    "leaderboard",
    "metrics",
    "mse",
    "parse_signature",
    "plot",
    "poses_to_euler",
    "position_error",
    "position_error_curve",
    "protocol",
    "published",
    "ratio_interval",
    "records",
    "report",
    "root_error",
    "rotation_error",
    "rotations",
    "score",
    "score_windows",
    "signature",
    "skeleton",
    "spectrum_divergence",
    "spectrum_entropy",
    "speed_ratio",
    "stochastic",
    "study",
    "trajectory_error",
    "unwrap",
]
# `from npss import *` must work without pandas.
__all__[:] = [name for name in __all__ if name != "Leaderboard" or find_spec("pandas")]

# Everything but scoring is imported on first access: `import npss` takes little longer than `import numpy`.
_LAZY = {
    "Accumulator": "npss._metric.accumulator",
    "Comparison": "npss._analysis.compare",
    "EulerErrorAt": "npss._metric.euler_error",
    "Finding": "npss._analysis.diagnose",
    "Identification": "npss._identify.identification",
    "Interval": "npss._analysis.interval",
    "Leaderboard": "npss.ranking._frame",
    "METRIC_VERSION": "npss._metric.signature",
    "Parts": "npss._metric.parts",
    "Range": "npss._analysis.interval",
    "Report": "npss._analysis.report",
    "compare": "npss._analysis.compare",
    "diagnose": "npss._analysis.diagnose",
    "euler_error": "npss._metric.euler_error",
    "euler_error_curve": "npss._metric.euler_error",
    "explain": "npss._metric.explain",
    "height_weighted_foot_skating": "npss._metric.foot_skating",
    "identify": "npss._identify.identify",
    "inbetweening": "npss.inbetweening",
    "leaderboard": "npss.ranking._leaderboard",
    "metrics": "npss.metrics",
    "mse": "npss._metric.euler_error",
    "parse_signature": "npss._metric.signature",
    "plot": "npss.plot",
    "poses_to_euler": "npss.rotations._poses",
    "position_error": "npss._metric.position_error",
    "position_error_curve": "npss._metric.position_error",
    "protocol": "npss.protocol",
    "published": "npss.published",
    "ratio_interval": "npss._analysis.ratio",
    "records": "npss.records",
    "report": "npss._analysis.report",
    "root_error": "npss._metric.position_error",
    "rotation_error": "npss._metric.rotation_error",
    "rotations": "npss.rotations",
    "signature": "npss._metric.signature",
    "skeleton": "npss.skeleton",
    "spectrum_divergence": "npss._metric.spectrum",
    "spectrum_entropy": "npss._metric.spectrum",
    "speed_ratio": "npss._metric.speed",
    "stochastic": "npss.stochastic",
    "study": "npss.study",
    "trajectory_error": "npss._metric.position_error",
    "unwrap": "npss.rotations._unwrap",
}


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'npss' has no attribute {name!r}")
    module = import_module(_LAZY[name])
    value = module if _LAZY[name] == f"npss.{name}" else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
