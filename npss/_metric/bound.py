"""Scores in units of their bound: the only ones that sequences of different lengths can share."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from fractions import Fraction
from typing import Any, Literal

from npss._metric.convention import Convention
from npss.validation import one_of

#: The unit of a score: None for bins, or its largest value.
Normalize = Literal["bound"] | None


def check_normalize(normalize: object) -> None:
    """Raise a TypeError or ValueError unless it is None or ``'bound'``."""
    if normalize is not None:
        one_of("normalize", normalize, ("bound",))


def largest_distance(convention: Convention, n_frames: int) -> Fraction:
    """Return the distance of a constant and the highest frequency, the largest of two spectra with power."""
    if convention.distance == "spectrum":
        return Fraction(2)
    return Fraction(n_frames, 2) if convention.bins == "two-sided" else Fraction(n_frames // 2)


def unit_of_weight(convention: Convention, n_frames: int) -> int:
    """Return the weight of a constant 1, so that a sequence does not count more because it is longer."""
    return n_frames**2 if convention.weight == "power" else 1


def normalised(sums: Mapping[int, tuple[int, int]], convention: Convention) -> tuple[Fraction, Fraction]:
    """Return the exact sums of weight times distance and of the weights, of sequences of all lengths.

    Parameters
    ----------
    sums : mapping of int to (int, int)
        The two sums by T, as `weighted_sums` returns them.
    convention : Convention
    """
    numerator = denominator = Fraction(0)
    for n_frames, (weighted, weight) in sums.items():
        unit = unit_of_weight(convention, n_frames)
        numerator += weighted / (unit * largest_distance(convention, n_frames))
        denominator += Fraction(weight, unit)
    return numerator, denominator


def stated_lengths(lengths: Collection[int], normalize: Normalize) -> dict[str, Any]:
    """Return the fields of a signature that state the numbers of frames, and how a score is normalised."""
    least, most = min(lengths, default=0), max(lengths, default=0)
    frames: dict[str, Any] = {"frames": most} if least == most else {"lengths": f"{least}-{most}"}
    return frames if normalize is None else {**frames, "normalize": normalize}
