"""Blocks: groups of sequences that depend on each other, the unit of every p-value and interval."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from typing import Any

import numpy as np

from npss.validation import Float64, each, is_integer

#: The version of the rules for intervals, p-values and fingerprints of ground truths; records state it.
STATISTICS_VERSION = 2
#: The scope of the inference, as text for a page.
INFERRED = (
    "Inferred: other blocks of this kind, such as other stretches of these recordings; never other people, unless each "
    "block is a person."
)

#: The name of a block.
Label = str | int
#: The block of each sequence, or None for a sequence in no block; None alone: each sequence is its own block.
Groups = tuple[Label | None, ...] | None


def statistics_version(sequences: Mapping[str, Any]) -> int:
    """Return the version of the rules for the ``sequences`` of a record; older records state none, which means 1.

    Raises
    ------
    ValueError
        If the version is unknown.
    """
    version = sequences.get("statistics", 1)
    if isinstance(version, bool) or version not in range(1, STATISTICS_VERSION + 1):
        raise ValueError(
            f"sequences: statistics: expected a version from 1 to {STATISTICS_VERSION}, got {version!r:.100}; "
            "a newer npss may have written the record"
        )
    return int(version)


def read_groups(name: str, groups: Iterable[object] | None, n: int) -> Groups:
    """Read the labels of `n` sequences: text, whole numbers, or None for a sequence in no block.

    Raises
    ------
    TypeError, ValueError
        If the number of labels is not `n`, a label is anything else, or all are None.
    """
    if groups is None:
        return None
    labels = each(name, groups, "labels, one for each sequence")
    if len(labels) != n:
        raise ValueError(f"{name}: expected {n} labels, one for each sequence, got {len(labels)}")
    for i, label in enumerate(labels):
        if not (label is None or isinstance(label, str) or is_integer(label)):
            raise TypeError(f"{name}: expected text, a whole number, or None for no block, got {label!r} at {i}")
        if label == "":
            raise ValueError(f"{name}: empty text at {i}; use None for a sequence in no block")
    if all(label is None for label in labels):
        raise ValueError(f"{name}: no sequence is in a block")
    return tuple(int(label) if is_integer(label) else label for label in labels)  # type: ignore[misc]


class Blocks:
    """The blocks of N sequences; every p-value and interval is of sums over blocks.

    Parameters
    ----------
    groups : tuple of str, int or None; or None
        The block of each sequence, as `read_groups` returns it.
    weight : (..., N) ndarray of float64
        Weights of the sequences; blocks without weight do not count.

    Raises
    ------
    ValueError
        If no block has a weight.
    """

    def __init__(self, groups: Groups, weight: Float64) -> None:
        self.groups = groups
        self.sequences = weight.shape[-1]
        self.n = int(np.count_nonzero(self.sums(weight).reshape(-1, len(self)).any(axis=0)))
        if not self.n:
            raise ValueError("groups: no sequence with power is in a block")

    @property
    def assumed(self) -> bool:
        """Whether sequences are assumed to be independent, for lack of labels."""
        return self.groups is None

    @property
    def left_out(self) -> int:
        """The number of sequences in no block."""
        return 0 if self.groups is None else sum(label is None for label in self.groups)

    def sums(self, values: Float64) -> Float64:
        """Sum values of sequences ``(..., N)`` over blocks ``(..., B)``."""
        if self._order is None:
            return values
        sequences, starts = self._order
        added: Float64 = np.add.reduceat(values[..., sequences], starts, axis=-1)
        return added

    def inside(self, values: Float64) -> Float64:
        """Return the sum over all sequences in blocks."""
        total: Float64 = self.sums(values).sum(axis=-1)
        return total

    @cached_property
    def _order(self) -> tuple[np.ndarray[Any, Any], np.ndarray[Any, Any]] | None:
        """The sequences ordered by block, and the start of each block."""
        if self.groups is None:
            return None
        places = {label: place for place, label in enumerate(dict.fromkeys(self.groups)) if label is not None}
        block = np.array([-1 if label is None else places[label] for label in self.groups])
        sequences = np.argsort(block, kind="stable")[self.left_out :]
        return sequences, np.flatnonzero(np.diff(block[sequences], prepend=-1))

    def __len__(self) -> int:
        return self.sequences if self._order is None else len(self._order[1])

    def __str__(self) -> str:
        """Return the number of blocks, and of sequences in no block."""
        if self.assumed:
            return f"{counted(self.n, 'sequence')}, each its own block, assumed independent"
        left_out = f", {self.left_out} of {self.sequences} sequences in none" if self.left_out else ""
        return counted(self.n, "block") + left_out


def counted(n: int, what: str) -> str:
    """Return a number with its noun."""
    return f"{n} {what}{'s' * (n != 1)}"
