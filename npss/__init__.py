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
from typing import TYPE_CHECKING, Any

from npss._convention import CONVENTIONS, Convention
from npss._score import score, score_windows

if TYPE_CHECKING:
    from npss import plot, protocol, published, rotations, skeleton, study
    from npss._accumulator import Accumulator
    from npss._compare import Comparison, compare
    from npss._diagnose import Finding, diagnose
    from npss._euler_error import euler_error, euler_error_curve, mse
    from npss._explain import explain
    from npss._interval import Interval, Range
    from npss._leaderboard import leaderboard
    from npss._poses import poses_to_euler
    from npss._report import Report, report
    from npss._signature import METRIC_VERSION, parse_signature, signature
    from npss._unwrap import unwrap

__version__ = "0.1.0"

__all__ = [
    "CONVENTIONS",
    "METRIC_VERSION",
    "Accumulator",
    "Comparison",
    "Convention",
    "Finding",
    "Interval",
    "Range",
    "Report",
    "__version__",
    "compare",
    "diagnose",
    "euler_error",
    "euler_error_curve",
    "explain",
    "leaderboard",
    "mse",
    "parse_signature",
    "plot",
    "poses_to_euler",
    "protocol",
    "published",
    "report",
    "rotations",
    "score",
    "score_windows",
    "signature",
    "skeleton",
    "study",
    "unwrap",
]

# What a loop that only scores does not need is imported when it is first asked for: `import npss` costs little more
# than `import numpy`.
_LAZY = {
    "Accumulator": "npss._accumulator",
    "Comparison": "npss._compare",
    "Finding": "npss._diagnose",
    "Interval": "npss._interval",
    "METRIC_VERSION": "npss._signature",
    "Range": "npss._interval",
    "Report": "npss._report",
    "compare": "npss._compare",
    "diagnose": "npss._diagnose",
    "euler_error": "npss._euler_error",
    "euler_error_curve": "npss._euler_error",
    "explain": "npss._explain",
    "leaderboard": "npss._leaderboard",
    "mse": "npss._euler_error",
    "parse_signature": "npss._signature",
    "plot": "npss.plot",
    "poses_to_euler": "npss._poses",
    "protocol": "npss.protocol",
    "published": "npss.published",
    "report": "npss._report",
    "rotations": "npss.rotations",
    "signature": "npss._signature",
    "skeleton": "npss.skeleton",
    "study": "npss.study",
    "unwrap": "npss._unwrap",
}


def __getattr__(name: str) -> Any:
    if name not in _LAZY:
        raise AttributeError(f"module 'npss' has no attribute {name!r}")
    module = import_module(_LAZY[name])
    value = module if _LAZY[name] == f"npss.{name}" else getattr(module, name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_LAZY})
