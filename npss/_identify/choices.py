"""The choices behind an NPSS function, in words, as a convention, and as a call of npss.

They are more than those of `npss.Convention`: public functions also differ in what they average, transform or multiply.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

from npss._metric.convention import CONVENTIONS, Convention, ConventionName, convention_name

#: What a function leaves to its caller.
NOT_PART = "not part"

#: The choices of each axis, in words. The first is that of `released`.
WORDS: dict[str, dict[str, str]] = {
    "power": {
        "real": "real part",
        "magnitude": "squared magnitude",
        "complex": "square of the complex number",
        "amplitude": "magnitude, not squared",
    },
    "bins": {"two-sided": "two-sided", "one-sided": "one-sided, none doubled (rfft)"},
    "distance": {"cdf": "L1 of cumulative distributions", "spectrum": "L1 of spectra, not cumulated"},
    "weight": {
        "gt": "the ground truth's total power",
        "pred": "the prediction's total power (arguments swapped?)",
        "uniform": "none",
        "gt-modulus": "the modulus of the ground truth's total power",
        "pred-modulus": "the modulus of the prediction's total power (arguments swapped?)",
        NOT_PART: "not part of this function",
    },
    "aggregation": {
        "set": "over the whole set",
        "sequence": "per sequence, then averaged",
        "feature": "per feature, then averaged",
        "batch": "per batch, then averaged",
        "batch-size": "per batch, then averaged by the size of batches",
        "last": "over the last batch only",
        "sequence-batch": "per sequence, averaged in each batch, then over batches",
        "sequence-last": "per sequence, averaged over the last batch only",
        "feature-batch": "per feature, averaged in each batch, then over batches",
        "feature-batch-size": "per feature, averaged in each batch, then by the size of batches",
        "feature-last": "per feature, averaged over the last batch only",
        "batches": "over batches in an unknown way",
        "unknown": "over sequences in an unknown way",
        NOT_PART: "not part of this function",
    },
    "factor": {},  # words by `Factor`
    "mean": {
        "kept": "kept",
        "removed": "removed first",
        "removed-frames": "of each feature, removed first",
    },
    "axis": {
        "time": "time",
        "features": "features (is time the last axis of its input?)",
        "mixed": "features for the transform, frames for all else",
        "components": "components of a joint for the transform, frames for all else",
    },
}

#: The names of the axes in messages.
TITLES = {
    "power": "power",
    "bins": "bins",
    "distance": "distance",
    "weight": "weights",
    "aggregation": "aggregation",
    "factor": "constant factor",
    "mean": "mean of a feature",
    "axis": "axis",
}

#: The most probable name first, where several are as near.
_NAMES: tuple[ConventionName, ...] = ("released", "paper", "literal")


class Factor(NamedTuple):
    """A constant times a product of sizes: ``number * N**n * T**t * D**d * K**k``, K the number of bins."""

    number: float = 1.0
    n: int = 0
    t: int = 0
    d: int = 0
    k: int = 0

    def of(self, n: int, t: int, d: int, k: int) -> float:
        """Return the factor for N sequences, T frames, D features and K bins."""
        return float(self.number * float(n) ** self.n * float(t) ** self.t * float(d) ** self.d * float(k) ** self.k)

    def words(self) -> str:
        """Describe the factor."""
        sizes = {"N": self.n, "T": self.t, "D": self.d, "bins": self.k}
        parts = [f"times {self.number:.6g}"] * (self.number != 1)
        parts += [f"times {size}" for size, exponent in sizes.items() if exponent > 0]
        parts += [f"divided by {size}" for size, exponent in sizes.items() if exponent < 0]
        return ", ".join(parts) or "none"

    def code(self) -> str:
        """Return the factor as the end of an expression of `gt`, an array ``(N, T, D)``."""
        sizes = {"len(gt)": self.n, "gt.shape[-2]": self.t, "gt.shape[-1]": self.d, "(gt.shape[-2] // 2 + 1)": self.k}
        parts = [f" * {self.number:.6g}"] * (self.number != 1)
        parts += [f" {'*' if exponent > 0 else '/'} {size}" for size, exponent in sizes.items() if exponent]
        return "".join(parts)


#: Products of sizes that public functions multiply a score by, the simplest first.
FACTORS = (
    Factor(),
    Factor(n=-1),
    Factor(t=-1),
    Factor(d=-1),
    Factor(k=-1),
    Factor(n=-1, d=-1),
    Factor(n=-1, t=-1),
    Factor(n=1),
    Factor(d=1),
    Factor(n=1, d=1),
)


class Choices(NamedTuple):
    """A combination of choices; the defaults are those of `released`."""

    power: str = "real"
    bins: str = "two-sided"
    distance: str = "cdf"
    weight: str = "gt"
    aggregation: str = "set"
    factor: Factor = Factor()
    mean: str = "kept"
    axis: str = "time"

    def words(self, axis: str) -> str:
        """Describe the choice of an axis."""
        choice = getattr(self, axis)
        return choice.words() if isinstance(choice, Factor) else WORDS[axis][choice]

    def swapped(self) -> Choices:
        """Return the choices with the roles of ground truth and prediction exchanged."""
        roles = {"gt": "pred", "pred": "gt", "gt-modulus": "pred-modulus", "pred-modulus": "gt-modulus"}
        return self._replace(weight=roles.get(self.weight, self.weight))

    def differences(self, name: ConventionName) -> dict[str, str]:
        """Return the words for each axis on which the choices differ from a named convention.

        What is not part of the function does not differ.
        """
        named = of_convention(CONVENTIONS[name])
        pairs = ((axis, getattr(self, axis), getattr(named, axis)) for axis in self._fields)
        return {axis: self.words(axis) for axis, own, other in pairs if own not in (other, NOT_PART)}

    def nearest(self) -> ConventionName:
        """Return the named convention that differs on the fewest axes."""
        return min(_NAMES, key=lambda name: len(self.differences(name)))

    def convention(self, zero: str | None) -> Convention | None:
        """Return the choices that `npss.Convention` knows, or None if it lacks the power; `zero` as there, if known."""
        if self.power not in ("real", "magnitude") or self.axis not in ("time", "features"):
            return None
        weight = "uniform" if self.weight == "uniform" else "power"
        choices = {"power": self.power, "bins": self.bins, "distance": self.distance, "weight": weight}
        default = CONVENTIONS[self.nearest()].zero
        return Convention(**choices, zero=zero or default)  # type: ignore[arg-type]

    def call(self, zero: str | None) -> str | None:
        """Return the expression of `gt` and `pred` with which npss reproduces the function, or None."""
        convention = self.convention(zero)
        if convention is None or self.weight == NOT_PART:
            return None
        if self.aggregation not in ("set", "sequence", NOT_PART):
            return None
        named = convention_name(convention)
        keywords = f'convention="{named}"' if named else f"convention={short(convention)}"
        first, second = ("pred", "gt") if self.weight == "pred" else ("gt", "pred")
        if self.aggregation == "sequence":
            first, second = (name[0] for name in (first, second))  # g and p, of one sequence
        first, second = self._prepared(first), self._prepared(second)
        score = f"npss.score({first}, {second}, {keywords})"
        if self.aggregation == "sequence":
            score = f"np.mean([{score} for g, p in zip(gt, pred)])"
        return score + self.factor.code()

    def _prepared(self, motion: str) -> str:
        axis = -1 if self.axis == "features" and self.mean == "removed" else -2
        if self.mean != "kept":
            motion = f"({motion} - {motion}.mean({axis}, keepdims=True))"
        if self.axis == "features":
            return f"{motion}.swapaxes(-2, -1)"
        return motion[1:-1] if motion[0] == "(" else motion


def short(convention: Convention) -> str:
    """Write a convention with only the fields that differ from its defaults."""
    default = Convention()
    names = ("power", "bins", "distance", "weight", "zero")
    fields = [(name, getattr(convention, name)) for name in names]
    text = ", ".join(f'{name}="{value}"' for name, value in fields if value != getattr(default, name))
    return f"npss.Convention({text})"


def of_convention(convention: Convention) -> Choices:
    """Return the choices of a convention."""
    weight = "gt" if convention.weight == "power" else "uniform"
    return Choices(convention.power, convention.bins, convention.distance, weight)


def of_columns(axis: str) -> Iterator[Choices]:
    """Yield the combinations that decide the distance of a feature of a sequence, for an axis of the transform."""
    means = {
        "time": ("kept", "removed"),
        "features": ("kept", "removed", "removed-frames"),
        "mixed": ("kept", "removed-frames"),
        "components": ("kept", "removed-frames"),
    }
    for mean, power, bins, distance in product(means[axis], WORDS["power"], WORDS["bins"], WORDS["distance"]):
        yield Choices(power, bins, distance, NOT_PART, NOT_PART, Factor(), mean, axis)


def of_sequences(columns: Choices) -> Iterator[Choices]:
    """Yield the combinations that decide the score of one sequence, given those of its features."""
    weights = ["gt", "pred", "uniform"]
    if columns.power == "complex":  # whose total may be negative, or complex
        weights += ["gt-modulus", "pred-modulus"]
    for weight in weights:
        yield columns._replace(weight=weight)


def of_sets(columns: Choices) -> Iterator[Choices]:
    """Yield the combinations that decide the score of a set, given those of its features."""
    for choices in of_sequences(columns):
        # Without weights, all aggregations are one function.
        for aggregation in ("set",) if choices.weight == "uniform" else ("set", "sequence", "feature"):
            yield choices._replace(aggregation=aggregation)
