"""Records of numbers, with their signatures."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import npss
from npss.records import Record
from npss_baselines.manifold.applications.method import Method
from npss_baselines.manifold.evaluation.testbed import Testbed, fingerprint
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.features import FPS


def context_of(motions: MotionSet, **context: Any) -> dict[str, Any]:
    """Return the signature fields of motion, with further fields."""
    return {"fps": FPS, "motion": fingerprint(motions), **context}


def records_of(
    testbed: Testbed, application: str, method: Method, values: Mapping[str, float], context: Mapping[str, Any]
) -> Iterator[Record]:
    """Yield a record for each metric that has a value."""
    model = testbed.signature_of(application, method)
    context = dict(context) if model is None else {**context, "model": model}
    for metric, value in values.items():
        if np.isnan(value):
            continue  # no value: no window is whole, or no foot is ever on the ground
        line = npss.signature("paper" if metric == "npss" else None, metric=metric, **context)
        yield {
            "application": application,
            "method": str(method),
            "metric": metric,
            "value": value,
            "signature": line,
        }
