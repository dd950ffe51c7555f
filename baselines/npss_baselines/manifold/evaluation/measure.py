"""Measure all applications."""

from __future__ import annotations

from collections.abc import Iterator

from npss.console import Progress
from npss.records import Record
from npss_baselines.manifold.applications.restore import FILLS, RESTORATIONS, WRIST
from npss_baselines.manifold.evaluation.restoration import restoration
from npss_baselines.manifold.evaluation.similarity import nearness
from npss_baselines.manifold.evaluation.synthesis import filtering, interpolation, sampling
from npss_baselines.manifold.evaluation.testbed import Testbed


def measure_all(testbed: Testbed) -> Iterator[Record]:
    """Measure every application, and show progress."""
    others = (interpolation, sampling, filtering, nearness)
    restorations = [(application, (WRIST,)) for application in RESTORATIONS] + [("fill", joints) for joints in FILLS]
    n_steps = len(restorations) + len(others)
    with Progress("measuring") as progress:
        for done, (application, joints) in enumerate(restorations, 1):
            yield from restoration(testbed, application, joints)
            progress(done / n_steps)
        for done, measure in enumerate(others, len(restorations) + 1):
            yield from measure(testbed)
            progress(done / n_steps)
