"""Score a set in parts: batches, files, processes, machines."""

from __future__ import annotations

from typing import Any, Self

import numpy.typing as npt

from npss._metric.convention import Convention, ConventionName, as_convention, convention_name
from npss._metric.fields import check_value
from npss._metric.registry import NPSS
from npss._metric.score import quotient, weighted_sums
from npss._metric.signature import METRIC_VERSION, parse_signature, signature
from npss.validation import motion_pair

_FIELDS = ("signature", "features", "sequences", "numerator", "denominator")


class Accumulator:
    """Score a set in parts, with the same bits as scoring it at once.

    NPSS is a weighted mean, so averaging batch scores gives another number. An accumulator keeps the two sums of that
    mean exactly, as integers. However the set is split and in whatever order the parts are merged, `result` is the
    float that `score` returns for all sequences at once.

    Parameters
    ----------
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `score`.
    representation : str, optional
        As for `score`; the signature states it.

    Raises
    ------
    TypeError, ValueError
        If a parameter is invalid.

    Notes
    -----
    Bits are equal on one machine with one version of numpy. Others may round a Fourier transform differently.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, equation 9.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt, pred = np.random.default_rng(0).normal(size=(2, 8, 25, 3))
    >>> whole = npss.score(gt, pred)
    >>> first = npss.Accumulator().update(gt[:5], pred[:5])
    >>> second = npss.Accumulator().update(gt[5:], pred[5:])
    >>> (first | second).result() == (second | first).result() == whole
    True
    """

    def __init__(self, *, convention: ConventionName | Convention = "paper", representation: str | None = None) -> None:
        self._convention = as_convention(convention)
        if representation is not None:
            check_value("representation", representation)
        self._representation = representation
        self._shape: tuple[int, int] | None = None  # frames and features; None before the first batch
        self._sequences = 0
        self._numerator = 0
        self._denominator = 0

    def update(self, gt: npt.ArrayLike, pred: npt.ArrayLike, *, workers: int = 1) -> Self:
        """Add a batch.

        Parameters
        ----------
        gt, pred : (N, T, D), (T, D) or (N, T, J, C) array_like
            As for `score`; T and D as in earlier batches.
        workers : int, optional
            As for `score`.

        Returns
        -------
        Accumulator
            The accumulator itself, to chain calls.

        Raises
        ------
        TypeError, ValueError
            As for `score`, except that a batch without power is valid. Also if T or D differ from earlier batches.
            After an error, the accumulator is unchanged.
        """
        truth, prediction = motion_pair(gt, pred, self._representation)
        shape = truth.shape[-2:]
        self._check_shape("gt", shape)
        numerator, denominator = weighted_sums(truth, prediction, self._convention, workers=workers)
        self._shape = shape
        self._sequences += truth.shape[0] if truth.ndim == 3 else 1
        self._numerator += numerator
        self._denominator += denominator
        return self

    def result(self) -> float:
        """Return the score of all batches.

        Raises
        ------
        ValueError
            If no batch was added, or the ground truth of none has power.
        """
        if self._shape is None:
            raise ValueError("result: the accumulator is empty")
        return quotient(self._numerator, self._denominator)

    def report(self) -> dict[str, Any]:
        """Return the score, its signature and the size of the set.

        Returns
        -------
        dict
            ``npss``, ``sequences``, ``features`` and ``signature``.

        Raises
        ------
        ValueError
            As for `result`.
        """
        score = self.result()
        state = self.state()
        return {"npss": score, **{name: state[name] for name in ("sequences", "features", "signature")}}

    def state(self) -> dict[str, Any]:
        """Return the content of the accumulator, ready for ``json.dumps``; `from_state` reads it.

        The two sums are hexadecimal integers, in units of a power of two that the metric version fixes.
        """
        frames, features = self._shape or (0, 0)
        return {
            "signature": signature(self._convention, **self._context, frames=frames),
            "features": features,
            "sequences": self._sequences,
            "numerator": f"{self._numerator:x}",
            "denominator": f"{self._denominator:x}",
        }

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Self:
        """Restore an accumulator from its state.

        Parameters
        ----------
        state : dict
            As returned by `state`.

        Raises
        ------
        TypeError, ValueError
            If the state is invalid, or from another version of the metric.
        """
        if not isinstance(state, dict) or sorted(map(str, state)) != sorted(_FIELDS):
            raise ValueError(f"state: expected a dict with the keys {', '.join(_FIELDS)}, got {state!r:.80}")
        values = parse_signature(state["signature"])
        if values["metric"] != NPSS.name or values["version"] != METRIC_VERSION or "frames" not in values:
            raise ValueError(
                f"state: expected the signature of an accumulator of metric version {METRIC_VERSION}, "
                f"got {state['signature']!r}"
            )
        accumulator = cls(convention=values["convention"], representation=values.get("representation"))
        counts = [values["frames"], state["features"], state["sequences"]]
        if any(isinstance(count, bool) or not isinstance(count, int) or count < 0 for count in counts):
            raise ValueError(f"state: frames, features and sequences must be whole numbers, got {counts}")
        try:
            numerator, denominator = (int(state[name], 16) for name in ("numerator", "denominator"))
        except (TypeError, ValueError) as error:
            raise ValueError(f"state: numerator and denominator must be hexadecimal integers ({error})") from error
        frames, features, sequences = counts
        if min(numerator, denominator) < 0 or len({count > 0 for count in counts}) > 1 or (numerator and not sequences):
            raise ValueError("state: its sums and counts contradict each other")
        accumulator._shape = (frames, features) if frames else None
        accumulator._sequences = sequences
        accumulator._numerator = numerator
        accumulator._denominator = denominator
        return accumulator

    def __ior__(self, other: Accumulator) -> Self:
        """Add the content of another accumulator.

        Raises
        ------
        ValueError
            If its convention, representation, T or D differs.
        """
        if not isinstance(other, Accumulator):
            return NotImplemented
        if other._convention != self._convention:
            ours, theirs = (convention_name(choice) or str(choice) for choice in (self._convention, other._convention))
            raise ValueError(f"convention: {theirs} cannot be merged into {ours}; their scores are not comparable")
        if other._representation != self._representation:
            names = f"{other._representation} cannot be merged into {self._representation}"
            raise ValueError(f"representation: {names}; their scores are not comparable")
        if other._shape is not None:
            self._check_shape("the other accumulator", other._shape)
            self._shape = other._shape
        self._sequences += other._sequences
        self._numerator += other._numerator
        self._denominator += other._denominator
        return self

    def __or__(self, other: Accumulator) -> Accumulator:
        """Return a new accumulator with the content of both."""
        if not isinstance(other, Accumulator):
            return NotImplemented
        merged = Accumulator(convention=self._convention, representation=self._representation)
        merged |= self
        merged |= other
        return merged

    def __repr__(self) -> str:
        name = convention_name(self._convention) or self._convention
        return f"<npss.Accumulator of {self._sequences} sequences, convention {name}>"

    @property
    def _context(self) -> dict[str, Any]:
        return {} if self._representation is None else {"representation": self._representation}

    def _check_shape(self, name: str, shape: tuple[int, ...]) -> None:
        if self._shape is not None and shape != self._shape:
            raise ValueError(
                f"{name}: {shape[0]} frames of {shape[1]} features; this accumulator holds sequences of "
                f"{self._shape[0]} frames of {self._shape[1]} features; scores at different T are not comparable"
            )
