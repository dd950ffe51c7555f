"""Measure all applications."""

from __future__ import annotations

from collections.abc import Iterator

from npss.console import Progress
from npss.records import Record
from npss_baselines.manifold.applications.restore import RESTORATIONS
from npss_baselines.manifold.evaluation.restoration import restoration
from npss_baselines.manifold.evaluation.similarity import nearness
from npss_baselines.manifold.evaluation.synthesis import filtering, interpolation, sampling
from npss_baselines.manifold.evaluation.testbed import Testbed


def measure_all(testbed: Testbed) -> Iterator[Record]:
    """Measure every application, and show progress."""
    others = (interpolation, sampling, filtering, nearness)
    n_steps = len(RESTORATIONS) + len(others)
    with Progress("measuring") as progress:
        for done, application in enumerate(RESTORATIONS, 1):
            yield from restoration(testbed, application)
            progress(done / n_steps)
        for done, measure in enumerate(others, len(RESTORATIONS) + 1):
            yield from measure(testbed)
            progress(done / n_steps)
