"""Ties: one tolerance for every rank."""

from __future__ import annotations

import math

#: Scores nearer than this differ by rounding alone: in theory all constant predictions have the same NPSS, and in
#: practice they differ by up to a sixth of this over 10 000 frames. A score near zero comes from differences of numbers
#: near 1, hence the absolute tolerance. Tables print four digits, and float32 files keep seven.
REL_TOL, ABS_TOL = 1e-9, 1e-12


def tied(a: float, b: float) -> bool:
    """Return whether two scores share a rank."""
    return math.isclose(a, b, rel_tol=REL_TOL, abs_tol=ABS_TOL)
