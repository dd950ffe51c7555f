"""When two scores are equal: one tolerance for every rank."""

from __future__ import annotations

import math

#: Scores nearer than this to each other differ by rounding alone: two constant predictions have the same NPSS by
#: theorem, and theirs differ by up to a sixth of it over 10 000 frames. A score that is itself all but zero comes from
#: differences of numbers near 1, hence the absolute part. Tables print four digits, and float32 files keep seven.
REL_TOL, ABS_TOL = 1e-9, 1e-12


def tied(a: float, b: float) -> bool:
    """Say whether two scores share a rank."""
    return math.isclose(a, b, rel_tol=REL_TOL, abs_tol=ABS_TOL)
