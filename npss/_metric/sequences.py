"""Sequences of unequal length: read them, and put those of equal length into groups."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from npss.validation import (
    Array,
    flattened,
    motion_pair,
    motion_with_joints,
    real_array,
)

#: The number of frames of each sequence that count, or None for all frames.
Lengths = npt.ArrayLike | None


class Group(NamedTuple):
    """Sequences of one length."""

    rows: Sequence[int]  # their places in the set
    gt: Array  # (n, T, D), or (T, D) for a single sequence
    pred: Array

    @property
    def n_frames(self) -> int:
        """T."""
        return int(self.gt.shape[-2])


class Motions(NamedTuple):
    """Ground truth and prediction, in groups of equal length, from short to long."""

    groups: list[Group]
    by_length: bool  # whether lengths are given, or differ

    @property
    def n_sequences(self) -> int:
        """N."""
        return sum(len(group.rows) for group in self.groups)


def read_motions(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    pred_name: str = "pred",
    lengths: Lengths = None,
    representation: object = None,
    spectra: bool = True,
) -> Motions:
    """Read ground truth and prediction: arrays, or lists of sequences, which may differ in length.

    Without `lengths`, the caller checks that arrays are finite.

    Parameters
    ----------
    gt, pred : array_like, or list of (T, D) or (T, J, C) array_like
        As for `motion_pair`, or a list of N sequences. With lengths, the two may differ in T.
    pred_name : str, optional
        Name of the prediction, for errors.
    lengths : (N,) array_like of int, optional
        The number of frames of each sequence that count, from the first.
    representation : str, optional
        As for `motion_pair`.
    spectra : bool, optional
        Refuse sequences of one frame, if their lengths are given or differ.

    Raises
    ------
    TypeError, ValueError
        As for `motion_pair`. If `lengths` are not whole numbers, one for each sequence, from 1 to T; if they are not
        given, and ground truth and prediction of a sequence differ in length.
    """
    if lengths is None and not (differ_in_length(gt) or differ_in_length(pred)):
        truth, prediction = motion_pair(gt, pred, representation, pred_name=pred_name)
        return Motions([Group(range(len(truth) if truth.ndim == 3 else 1), truth, prediction)], by_length=False)
    truths, predictions = (_sequences(name, values, representation) for name, values in (("gt", gt), (pred_name, pred)))
    if len(truths) != len(predictions):
        raise ValueError(f"{pred_name}: {len(predictions)} sequences, but gt has {len(truths)}")
    if truths[0].shape[1:] != predictions[0].shape[1:]:
        raise ValueError(
            f"{pred_name}: its shape {predictions[0].shape} differs from that of gt, {truths[0].shape}, in more than "
            f"frames; nothing is broadcast"
        )
    counts = _lengths(lengths, truths, predictions, pred_name)
    if spectra and min(counts) < 2:
        raise ValueError(f"gt: one frame in sequence {counts.index(1)}; a power spectrum needs at least two")
    pairs = [(truth[:n], prediction[:n]) for truth, prediction, n in zip(truths, predictions, counts, strict=True)]
    for name, motions in zip(("gt", pred_name), zip(*pairs, strict=True), strict=True):
        check_sequences(name, motions)
    groups = []
    for rows in rows_by_length(counts):
        both = (flattened(np.stack([pairs[i][k] for i in rows])) for k in range(2))
        groups.append(Group(rows, *both))
    return Motions(groups, by_length=True)


def rows_by_length(counts: Sequence[int]) -> list[tuple[int, ...]]:
    """Return the places of the sequences of each length, from short to long."""
    order = sorted(range(len(counts)), key=counts.__getitem__)  # stable
    return [tuple(rows) for _, rows in groupby(order, key=counts.__getitem__)]


def read_lengths(values: npt.ArrayLike, longest: Sequence[int]) -> list[int]:
    """Read lengths: whole numbers, one for each sequence, from 1 to its number of frames.

    Raises
    ------
    TypeError, ValueError
        If they are anything else.
    """
    if _are_booleans(values):
        raise TypeError("lengths: expected whole numbers, got booleans; of a mask of frames (N, T), pass mask.sum(1)")
    array = real_array("lengths", values)
    if array.dtype.kind not in "iu":
        raise TypeError(f"lengths: expected whole numbers, got dtype {array.dtype}")
    if array.shape != (len(longest),):
        raise ValueError(f"lengths: expected one for each of {len(longest)} sequences, got shape {array.shape}")
    counts = [int(count) for count in array]
    for i, (count, most) in enumerate(zip(counts, longest, strict=True)):
        if not 1 <= count <= most:
            raise ValueError(f"lengths: {count} at {i}; expected a number of frames from 1 to {most}")
    return counts


def _are_booleans(values: object) -> bool:
    parts = values if isinstance(values, list | tuple) else ()
    return "bool" in str(getattr(values, "dtype", "")) or any(isinstance(part, bool) for part in parts)


def _lengths(lengths: Lengths, truths: list[Array], predictions: list[Array], pred_name: str) -> list[int]:
    """Return the number of frames of each sequence that count."""
    both = [(len(truth), len(prediction)) for truth, prediction in zip(truths, predictions, strict=True)]
    if lengths is not None:
        return read_lengths(lengths, [min(pair) for pair in both])
    for i, (of_truth, of_prediction) in enumerate(both):
        if of_truth != of_prediction:
            raise ValueError(
                f"{pred_name}: {of_prediction} frames in sequence {i}, but gt has {of_truth}; to compare the first "
                f"frames of both, pass lengths="
            )
    return [of_truth for of_truth, _ in both]


def differ_in_length(values: object) -> bool:
    """Return whether these are several sequences that differ in length."""
    if not isinstance(values, list | tuple) or not all(_is_sequence(value) for value in values):
        return False
    return len({len(value) for value in values}) > 1


def _is_sequence(value: Any) -> bool:
    """Return whether a part of a list has frames and features."""
    if isinstance(value, list | tuple):
        return len(value) > 0 and isinstance(value[0], list | tuple | np.ndarray)
    return len(getattr(value, "shape", ())) > 1


def check_sequences(name: str, sequences: Sequence[Array]) -> None:
    """Refuse NaN and infinite values in the frames that count; the index begins with the sequence."""
    for i, sequence in enumerate(sequences):
        finite = np.isfinite(sequence)
        if not finite.all():
            index = (i, *(int(k) for k in np.argwhere(~finite)[0]))
            raise ValueError(f"{name}: {sequence[index[1:]]} at index {index}; every value must be finite")


def _sequences(name: str, values: npt.ArrayLike, representation: object) -> list[Array]:
    """Return the sequences of an array or a list, with joints if there are any."""
    if not differ_in_length(values):
        array = motion_with_joints(name, values, representation)
        return [array] if array.ndim == 2 else list(array)
    several: list[Any] = list(values)  # type: ignore[arg-type]
    sequences = [motion_with_joints(f"{name}: sequence {i}", [x], representation)[0] for i, x in enumerate(several)]
    for i, sequence in enumerate(sequences):
        if sequence.shape[1:] != sequences[0].shape[1:]:
            raise ValueError(
                f"{name}: the shape of sequence {i}, {sequence.shape}, differs from that of sequence 0, "
                f"{sequences[0].shape}, in more than frames"
            )
    return sequences
