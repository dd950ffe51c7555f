"""One score of a set that comes in parts: batches, files, processes, machines."""

from __future__ import annotations

from typing import Any, Self

import numpy.typing as npt

from npss._metric.convention import Convention, ConventionName, as_convention, convention_name
from npss._metric.registry import NPSS
from npss._metric.score import quotient, weighted_sums
from npss._metric.signature import METRIC_VERSION, parse_signature, signature
from npss.validation import motion_pair

_FIELDS = ("signature", "features", "sequences", "numerator", "denominator")


class Accumulator:
    """The score of a set that comes in parts, to the bit that of the whole.

    NPSS is a weighted mean, so the mean of batch scores is another number. An accumulator keeps the two sums of that
    mean, exactly, as whole numbers: whatever the split into batches, the order of merging, or the process that computed
    a part, `result` is the float that `score` returns for all the sequences at once.

    Parameters
    ----------
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `score`.

    Raises
    ------
    TypeError, ValueError
        If the convention is none.

    Notes
    -----
    The same bits on the same machine and version of numpy: others may round a Fourier transform differently.

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

    def __init__(self, *, convention: ConventionName | Convention = "paper") -> None:
        self._convention = as_convention(convention)
        self._shape: tuple[int, int] | None = None  # frames and features, known from the first batch on
        self._sequences = 0
        self._numerator = 0
        self._denominator = 0

    def update(self, gt: npt.ArrayLike, pred: npt.ArrayLike, *, workers: int = 1) -> Self:
        """Add a batch.

        Parameters
        ----------
        gt, pred : (N, T, D) or (T, D) array_like
            As for `score`; T and D as in the batches before.
        workers : int, optional
            As for `score`.

        Returns
        -------
        Accumulator
            Itself, so that calls can be chained.

        Raises
        ------
        TypeError, ValueError
            As `score`, except that a batch without any power is no error; and where T or D differ from the batches
            before. Then nothing of the batch was added.
        """
        truth, prediction = motion_pair(gt, pred)
        shape = truth.shape[-2:]
        self._check_shape("gt", shape)
        numerator, denominator = weighted_sums(truth, prediction, self._convention, workers=workers)
        self._shape = shape
        self._sequences += truth.shape[0] if truth.ndim == 3 else 1
        self._numerator += numerator
        self._denominator += denominator
        return self

    def result(self) -> float:
        """Return the score of all that was added.

        Raises
        ------
        ValueError
            If there was nothing, or nothing whose ground truth has power.
        """
        if self._shape is None:
            raise ValueError("result: nothing was added to this accumulator")
        return quotient(self._numerator, self._denominator)

    def report(self) -> dict[str, Any]:
        """Return the score with what it is the score of.

        Returns
        -------
        dict
            ``npss``, ``sequences``, ``features`` and ``signature``.

        Raises
        ------
        ValueError
            As `result`.
        """
        score = self.result()
        state = self.state()
        return {"npss": score, **{name: state[name] for name in ("sequences", "features", "signature")}}

    def state(self) -> dict[str, Any]:
        """Return all that the accumulator holds, ready for ``json.dumps``; `from_state` reads it.

        The two sums are hexadecimal whole numbers, in units of a power of two that belongs to the metric version.
        """
        frames, features = self._shape or (0, 0)
        return {
            "signature": signature(self._convention, frames=frames),
            "features": features,
            "sequences": self._sequences,
            "numerator": f"{self._numerator:x}",
            "denominator": f"{self._denominator:x}",
        }

    @classmethod
    def from_state(cls, state: dict[str, Any]) -> Self:
        """Return the accumulator that a state was taken from.

        Parameters
        ----------
        state : dict
            As `state` returned it.

        Raises
        ------
        TypeError, ValueError
            If it is not such a state, or is that of another version of the metric.
        """
        if not isinstance(state, dict) or sorted(map(str, state)) != sorted(_FIELDS):
            raise ValueError(f"state: expected a dict with the keys {', '.join(_FIELDS)}, got {state!r:.80}")
        stated = parse_signature(state["signature"])
        if stated["metric"] != NPSS.name or stated["version"] != METRIC_VERSION or "frames" not in stated:
            raise ValueError(
                f"state: {state['signature']!r} is not that of an accumulator of version {METRIC_VERSION} of the metric"
            )
        accumulator = cls(convention=stated["convention"])
        counts = [stated["frames"], state["features"], state["sequences"]]
        if any(isinstance(count, bool) or not isinstance(count, int) or count < 0 for count in counts):
            raise ValueError(f"state: frames, features and sequences must be whole numbers, got {counts}")
        try:
            numerator, denominator = (int(state[name], 16) for name in ("numerator", "denominator"))
        except (TypeError, ValueError) as error:
            raise ValueError(f"state: its sums must be hexadecimal whole numbers ({error})") from error
        frames, features, sequences = counts
        if min(numerator, denominator) < 0 or len({count > 0 for count in counts}) > 1 or (numerator and not sequences):
            raise ValueError("state: its sums and counts do not belong together")
        accumulator._shape = (frames, features) if frames else None
        accumulator._sequences = sequences
        accumulator._numerator = numerator
        accumulator._denominator = denominator
        return accumulator

    def __ior__(self, other: Accumulator) -> Self:
        """Add all that another accumulator holds.

        Raises
        ------
        ValueError
            If its convention, T or D is another.
        """
        if not isinstance(other, Accumulator):
            return NotImplemented
        if other._convention != self._convention:
            mine, others = (convention_name(one) or str(one) for one in (self._convention, other._convention))
            raise ValueError(f"convention: {others} cannot be merged into {mine}; their scores are not comparable")
        if other._shape is not None:
            self._check_shape("the other accumulator", other._shape)
            self._shape = other._shape
        self._sequences += other._sequences
        self._numerator += other._numerator
        self._denominator += other._denominator
        return self

    def __or__(self, other: Accumulator) -> Accumulator:
        """Return a new accumulator that holds what both hold."""
        if not isinstance(other, Accumulator):
            return NotImplemented
        merged = Accumulator(convention=self._convention)
        merged |= self
        merged |= other
        return merged

    def __repr__(self) -> str:
        name = convention_name(self._convention) or self._convention
        return f"<npss.Accumulator of {self._sequences} sequences, convention {name}>"

    def _check_shape(self, name: str, shape: tuple[int, ...]) -> None:
        if self._shape is not None and shape != self._shape:
            raise ValueError(
                f"{name}: {shape[0]} frames of {shape[1]} features; this accumulator holds sequences of "
                f"{self._shape[0]} frames of {self._shape[1]} features, and scores at another T are not comparable"
            )
