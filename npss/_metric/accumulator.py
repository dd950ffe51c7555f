"""Score a set in parts: batches, files, processes, machines."""

from __future__ import annotations

import re
from typing import Any, NamedTuple, Self

import numpy.typing as npt

from npss._metric.bound import Normalize, check_normalize, normalised, stated_lengths
from npss._metric.convention import Convention, ConventionName, as_convention, convention_name
from npss._metric.fields import check_value
from npss._metric.registry import NPSS
from npss._metric.score import quotient, sums_by_length
from npss._metric.sequences import Lengths, read_motions
from npss._metric.signature import METRIC_VERSION, parse_signature, signature

_PART = ("sequences", "numerator", "denominator")
_FIELDS = ("signature", "features", *_PART)
_FIELDS_BY_LENGTH = ("signature", "features", "lengths")
_CONTRADICTION = "state: its sums and counts contradict each other"


class Accumulator:
    """Score a set in parts, with the same bits as scoring it at once.

    NPSS is a weighted mean, so averaging batch scores gives another number. An accumulator keeps the two sums of that
    mean exactly, as integers. However the set is split and in whatever order the parts are merged, `result` is the
    float that `score` returns for all sequences at once.

    Parameters
    ----------
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `score`.
    normalize : {'bound'}, optional
        As for `score`: batches may then differ in T.
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

    def __init__(
        self,
        *,
        convention: ConventionName | Convention = "paper",
        normalize: Normalize = None,
        representation: str | None = None,
    ) -> None:
        self._convention = as_convention(convention)
        check_normalize(normalize)
        self._normalize: Normalize = normalize
        if representation is not None:
            check_value("representation", representation)
        self._representation = representation
        self._features = 0
        self._by_length = False  # whether lengths were given
        self._parts: dict[int, _Part] = {}  # by T

    def update(self, gt: npt.ArrayLike, pred: npt.ArrayLike, *, lengths: Lengths = None, workers: int = 1) -> Self:
        """Add a batch.

        Parameters
        ----------
        gt, pred : (N, T, D), (T, D) or (N, T, J, C) array_like, or list of sequences
            As for `score`; D as in earlier batches, and T, unless the score is normalised or lengths are given.
        lengths : (N,) array_like of int, optional
            As for `score`.
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
        motions = read_motions(gt, pred, lengths=lengths, representation=self._representation)
        features = motions.groups[0].gt.shape[-1]
        by_length = self._by_length or motions.by_length
        self._check("gt", features, [group.n_frames for group in motions.groups], by_length)
        sums = sums_by_length(motions, self._convention, workers=workers)
        self._features = features
        self._by_length = by_length
        for group in motions.groups:
            self._add(group.n_frames, _Part(len(group.rows), *sums[group.n_frames]))
        return self

    def result(self) -> Any:
        """Return the score of all batches.

        Returns
        -------
        float, or dict of int to float
            A dict of scores by T if lengths were given, or a list of sequences that differ in length, unless
            normalised.

        Raises
        ------
        ValueError
            If no batch was added, or the ground truth of none has power.
        """
        if not self._parts:
            raise ValueError("result: the accumulator is empty")
        if self._normalize is not None:
            return quotient(*normalised({n: part[1:] for n, part in self._parts.items()}, self._convention))
        if not self._by_length:
            return quotient(*self._whole[1:])
        return {n: quotient(*self._parts[n][1:], f" of {n} frames") for n in sorted(self._parts)}

    def report(self) -> dict[Any, Any]:
        """Return the score, its signature and the size of the set.

        Returns
        -------
        dict
            ``npss``, ``sequences``, ``features`` and ``signature``; by T, if `result` is.

        Raises
        ------
        ValueError
            As for `result`.
        """
        result = self.result()
        if not isinstance(result, dict):
            return self._report(result, sum(part.sequences for part in self._parts.values()), self._stated)
        return {n: self._report(score, self._parts[n].sequences, {"frames": n}) for n, score in result.items()}

    def state(self) -> dict[str, Any]:
        """Return the content of the accumulator, ready for ``json.dumps``; `from_state` reads it.

        The two sums are hexadecimal integers, in units of a power of two that the metric version fixes.
        """
        state = {"signature": self._signature(self._stated), "features": self._features}
        if not self._keeps_lengths:
            return state | _written(self._whole)
        return state | {"lengths": {str(n): _written(self._parts[n]) for n in sorted(self._parts)}}

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
        keys = sorted(map(str, state)) if isinstance(state, dict) else []
        if keys not in (sorted(_FIELDS), sorted(_FIELDS_BY_LENGTH)):
            raise ValueError(f"state: expected a dict with the keys {', '.join(_FIELDS)}, got {state!r:.80}")
        values = parse_signature(state["signature"])
        by_length = "lengths" in state
        if (
            values["metric"] != NPSS.name
            or values["version"] != METRIC_VERSION
            or ("frames" not in values and not by_length)
        ):
            raise ValueError(
                f"state: expected the signature of an accumulator of metric version {METRIC_VERSION}, "
                f"got {state['signature']!r}"
            )
        accumulator = cls(
            **{name: values[name] for name in ("convention", "normalize", "representation") if name in values}
        )
        parts = state["lengths"] if by_length else {str(values["frames"]): {name: state[name] for name in _PART}}
        accumulator._features = _count("features", state["features"])
        accumulator._by_length = by_length and accumulator._normalize is None
        if not isinstance(parts, dict):
            raise ValueError(f"state: expected lengths as a dict, got {parts!r:.80}")
        for n_frames, part in parts.items():
            if not re.fullmatch("[0-9]+", str(n_frames)):
                raise ValueError(f"state: expected a number of frames, got {n_frames!r}")
            read = _read_part(part)
            if len({int(n_frames) > 0, accumulator._features > 0, read.sequences > 0}) > 1:
                raise ValueError(_CONTRADICTION)
            if read.sequences:  # pragma: no branch - a state of nothing has no parts
                accumulator._parts[int(n_frames)] = read
        if by_length and accumulator.state()["signature"] != state["signature"]:
            raise ValueError(_CONTRADICTION)
        return accumulator

    def __ior__(self, other: Accumulator) -> Self:
        """Add the content of another accumulator.

        Raises
        ------
        ValueError
            If its convention, normalisation, representation, T or D differs.
        """
        if not isinstance(other, Accumulator):
            return NotImplemented
        for name in ("convention", "normalize", "representation"):
            ours, theirs = (getattr(accumulator, f"_{name}") for accumulator in (self, other))
            if ours != theirs:
                if name == "convention":
                    ours, theirs = (convention_name(choice) or str(choice) for choice in (ours, theirs))
                raise ValueError(f"{name}: {theirs} cannot be merged into {ours}; their scores are not comparable")
        by_length = self._by_length or other._by_length
        if other._parts:
            self._check("the other accumulator", other._features, list(other._parts), by_length)
            self._features = other._features
        self._by_length = by_length
        for n_frames, part in other._parts.items():
            self._add(n_frames, part)
        return self

    def __or__(self, other: Accumulator) -> Accumulator:
        """Return a new accumulator with the content of both."""
        if not isinstance(other, Accumulator):
            return NotImplemented
        merged = Accumulator(
            convention=self._convention, normalize=self._normalize, representation=self._representation
        )
        merged |= self
        merged |= other
        return merged

    def __repr__(self) -> str:
        name = convention_name(self._convention) or self._convention
        sequences = sum(part.sequences for part in self._parts.values())
        return f"<npss.Accumulator of {sequences} sequences, convention {name}>"

    @property
    def _keeps_lengths(self) -> bool:
        return self._by_length or self._normalize is not None

    @property
    def _whole(self) -> _Part:
        """The only part, of sequences of one length."""
        return next(iter(self._parts.values()), _Part(0, 0, 0))

    @property
    def _stated(self) -> dict[str, Any]:
        """The fields of the signature for the lengths: none for scores by T."""
        return {} if self._by_length and self._normalize is None else stated_lengths(self._parts, self._normalize)

    def _signature(self, fields: dict[str, Any]) -> str:
        known: dict[str, Any] = {} if self._representation is None else {"representation": self._representation}
        return signature(self._convention, **known, **fields)

    def _report(self, score: float, sequences: int, fields: dict[str, Any]) -> dict[str, Any]:
        return {
            "npss": score,
            "sequences": sequences,
            "features": self._features,
            "signature": self._signature(fields),
        }

    def _add(self, n_frames: int, part: _Part) -> None:
        held = self._parts.get(n_frames, _Part(0, 0, 0))
        self._parts[n_frames] = _Part(*(ours + theirs for ours, theirs in zip(held, part, strict=True)))

    def _check(self, name: str, features: int, lengths: list[int], by_length: bool) -> None:
        """Refuse other features, and another length unless lengths are kept apart or scores are normalised."""
        if not self._parts:
            return
        apart = not (by_length or self._normalize) and {*lengths} != {*self._parts}
        if features != self._features or apart:
            theirs, ours = ("/".join(map(str, sorted(several))) for several in (lengths, self._parts))
            raise ValueError(
                f"{name}: {theirs} frames of {features} features; this accumulator holds sequences of {ours} frames of "
                f"{self._features} features; scores at different T are not comparable, except by normalize='bound'"
            )


class _Part(NamedTuple):
    """The exact sums of the sequences of one length."""

    sequences: int
    numerator: int
    denominator: int


def _written(part: _Part) -> dict[str, Any]:
    return {
        "sequences": part.sequences,
        "numerator": f"{part.numerator:x}",
        "denominator": f"{part.denominator:x}",
    }


def _read_part(part: object) -> _Part:
    if not isinstance(part, dict) or sorted(map(str, part)) != sorted(_PART):
        raise ValueError(f"state: expected {', '.join(_PART)} for a number of frames, got {part!r:.80}")
    sequences = _count("sequences", part["sequences"])
    try:
        numerator, denominator = (int(part[name], 16) for name in ("numerator", "denominator"))
    except (TypeError, ValueError) as error:
        raise ValueError(f"state: numerator and denominator must be hexadecimal integers ({error})") from error
    if min(numerator, denominator) < 0 or (numerator and not sequences):
        raise ValueError(_CONTRADICTION)
    return _Part(sequences, numerator, denominator)


def _count(name: str, value: object) -> int:
    if isinstance(value, bool) or not isinstance(value, int) or value < 0:
        raise ValueError(f"state: frames, features and sequences must be whole numbers, got {value!r} {name}")
    return value
