"""A metric: its function and its description for commands, records, tables and signatures."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt

from npss._metric.convention import CONVENTIONS
from npss._metric.fields import ARGUMENTS, FIELDS, Value, check_value
from npss._metric.parts import Parts
from npss.validation import (
    Array,
    BeyondFloat64Error,
    Float64,
    check_finite,
    flattened,
    is_integer,
    is_real,
    motion_with_joints,
    one_of,
    real_array,
)

#: The name of a metric in a signature.
NAME = r"[a-z_][a-z0-9_]*"
#: The name of a signature's field.
FIELD = r"[A-Za-z_][A-Za-z0-9_]*"

TAKES = ("angles", "poses", "positions")
AGGREGATIONS = ("mean", "weighted mean", "none")
OPTIONS = ("convention", "fps", "at_ms")


class Measured(NamedTuple):
    """The value for a set of motions, and each sequence's share of its numerator and denominator."""

    value: float
    numerator: Float64 | None = None  # (N,); None if the value is not a mean over sequences
    weight: Float64 | None = None  # (N,)
    parts: Parts | None = None  # what an NPSS is made of

    def by_sequence(self) -> Float64 | None:
        """Return the value of each sequence, ``(N,)``; 0 where its weight is 0."""
        if self.numerator is None or self.weight is None:
            return None
        zeros = np.zeros(len(self.weight))
        return np.divide(self.numerator, self.weight, out=zeros, where=self.weight > 0)


@dataclass(frozen=True, kw_only=True, eq=False)
class Metric:
    """A metric: how its values are computed, averaged, printed and explained.

    Parameters
    ----------
    name : str
        The first word of its signatures: lower-case letters, digits and ``_``.
    function : callable
        ``function(gt, pred)``, with `options` as keywords. Both are float64 arrays of the same shape, read-only and
        finite, of N sequences of T frames: (N, T, D), or (N, T, J, 3) positions. It returns finite numbers >= 0, in
        the form that `aggregation` describes.
    says : str
        The meaning, as a phrase without the name, for `npss.explain`.
    heading : str, optional
        The heading of its column (default: `name`).
    aggregation : {'mean', 'weighted mean', 'none'}, optional
        How sequences are aggregated. ``'mean'``: the function returns a number for each sequence, (N,).
        ``'weighted mean'``: it returns two such arrays, the numbers and their weights, which depend on the ground
        truth alone. ``'none'``: it returns one number for all sequences, which has no interval and no test.
    takes : {'angles', 'poses', 'positions'}, optional
        The input: Euler angles in radians, or any other features that are scored; Human3.6M poses, exponential maps,
        (N, T, 99); or positions of Human3.6M's joints in millimetres, (N, T, 32, 3).
    options : tuple of str, optional
        Keyword arguments of the function: ``'fps'``, frames per second; ``'at_ms'``, a time in milliseconds after the
        last seed frame, for a metric with a column for each time.
    unit : str, optional
        The unit of its values.
    digits : int, optional
        Decimal places in tables (default: those of the table).
    lower_is_better : bool, optional
        The direction.
    fields : mapping of str to value, optional
        Further fields of its signatures, such as parameters of the function. None marks a field that belongs to this
        metric alone and whose value depends on the motion.

    Raises
    ------
    TypeError, ValueError
        If a parameter is invalid. The message names it.

    See Also
    --------
    register : add the metric to the registry.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.metrics import Metric
    >>> def largest(gt, pred):
    ...     return np.abs(gt - pred).max(axis=(1, 2))
    >>> metric = Metric(name="largest", function=largest, says="the largest difference of an angle", unit="rad")
    >>> metric.heading, metric.aggregation, metric.lower_is_better
    ('largest', 'mean', True)
    """

    name: str
    function: Callable[..., Any]
    says: str
    heading: str = ""
    aggregation: str = "mean"
    takes: str = "angles"
    options: tuple[str, ...] = ()
    unit: str = ""
    digits: int | None = None
    lower_is_better: bool = True
    fields: Mapping[str, Value | None] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise TypeError(f"name: expected text, got {self.name!r}")
        if not re.fullmatch(NAME, self.name):
            raise ValueError(f"name: expected lower-case letters, digits and '_', got {self.name!r}")
        object.__setattr__(self, "heading", self.heading or self.name)
        for name in ("heading", "says", "unit"):
            text = getattr(self, name)
            if not isinstance(text, str):
                raise TypeError(f"{name}: expected text, got {text!r}")
            if not text.isprintable() or text != text.strip() or not (text or name == "unit"):
                raise ValueError(f"{name}: expected one line of text without surrounding blanks, got {text!r}")
        for name in ("name", "heading"):
            if getattr(self, name) in CONVENTIONS:
                raise ValueError(f"{name}: {getattr(self, name)!r} is the name of a convention")
        if not callable(self.function):
            raise TypeError(f"function: expected a function, got {self.function!r}")
        one_of("aggregation", self.aggregation, AGGREGATIONS)
        one_of("takes", self.takes, TAKES)
        if not isinstance(self.options, tuple):
            raise TypeError(f"options: expected a tuple of names, got {self.options!r}")
        for option in self.options:
            one_of("options", option, OPTIONS)
        if self.digits is not None and not (is_integer(self.digits) and self.digits >= 0):
            raise ValueError(f"digits: expected a whole number, 0 or more, got {self.digits!r}")
        if not isinstance(self.lower_is_better, bool):
            raise TypeError(f"lower_is_better: expected True or False, got {self.lower_is_better!r}")
        object.__setattr__(self, "fields", MappingProxyType(_checked_fields(self.fields)))

    def column(
        self, *, convention: str | None = None, window: str | None = None, at_ms: str | float | None = None
    ) -> str:
        """Return the name of a column: ``'NPSS paper 0-1 s'``, ``'Euler error 80 ms'``."""
        time = at_ms if isinstance(at_ms, str | None) else f"{at_ms:.10g}"
        parts = [self.heading, convention, window and f"{window} s", time and f"{time} ms"]
        return " ".join(part for part in parts if part)

    @property
    def sign(self) -> int:
        """1 if lower is better, else -1."""
        return 1 if self.lower_is_better else -1

    @property
    def has_conventions(self) -> bool:
        """Whether it has a value for each convention."""
        return "convention" in self.options

    @property
    def has_times(self) -> bool:
        """Whether it has a value for each time."""
        return "at_ms" in self.options

    @property
    def labelled(self) -> str:
        """The heading with the unit, for an axis."""
        return f"{self.heading} ({self.unit})" if self.unit else self.heading

    def stated(self) -> dict[str, Any]:
        """Return the fields of its signatures: known fields by name, others in ``extra``."""
        fields = {name: value for name, value in self.fields.items() if value is not None}
        if not self.lower_is_better:
            fields["better"] = "higher"
        extra = {name: fields.pop(name) for name in list(fields) if name not in FIELDS}
        return fields | ({"extra": extra} if extra else {})

    def measure(
        self,
        gt: npt.ArrayLike,
        pred: npt.ArrayLike,
        *,
        pred_name: str = "pred",
        representation: object = None,
        **options: Any,
    ) -> Measured:
        """Call the function on motion, and check the result.

        Parameters
        ----------
        gt, pred : array_like
            N sequences, or a single one.
        pred_name : str, optional
            Name of the prediction, for errors.
        representation : str, optional
            The representation of the motion: ``'matrix'`` has the shape ``(N, T, J, 3, 3)``.
        **options
            All available options; the metric's own are passed to the function.

        Raises
        ------
        TypeError, ValueError
            If the input is invalid, an option is missing, or the function returns an invalid result.
        """
        arrays = [self._read(name, motion, representation) for name, motion in (("gt", gt), (pred_name, pred))]
        if arrays[0].shape != arrays[1].shape:
            shapes = f"its shape {arrays[1].shape} differs from that of gt, {arrays[0].shape}"
            raise ValueError(f"{pred_name}: {shapes}; nothing is broadcast")
        truth, prediction = arrays if self.takes == "positions" else map(flattened, arrays)
        passed = {}
        for name in self.options:
            if options.get(name) is None:
                raise ValueError(f"{name}: required by {self.heading}")
            passed[name] = options[name]
        try:
            result = self.function(truth, prediction, **passed)
        except BeyondFloat64Error as error:
            raise ValueError(f"{pred_name}: {error.what}") from error
        return result if isinstance(result, Measured) else self._measured(result, len(truth))

    def _read(self, name: str, values: npt.ArrayLike, representation: object) -> Float64:
        """Read motion as ``(N, T, D)`` or with joints, float64, finite and read-only."""
        array: Array
        if self.takes == "positions":
            array = real_array(name, values)
            if array.ndim not in (3, 4) or array.shape[-1] != 3 or 0 in array.shape:
                raise ValueError(f"{name}: expected positions (N, T, J, 3) or (T, J, 3), got shape {array.shape}")
            n_axes = 4
        else:
            array, n_axes = motion_with_joints(name, values, representation), 3
        check_finite(name, array)
        view = np.asarray(array, np.float64)[np.newaxis if array.ndim < n_axes else ...]
        view.flags.writeable = False
        return view

    def _measured(self, result: object, n: int) -> Measured:
        """Check the result of the function and aggregate it."""
        where = f"metric {self.name!r}"
        if self.aggregation == "none":
            if not is_real(result) and not (isinstance(result, np.ndarray) and result.ndim == 0):
                raise TypeError(f"{where}: expected one number for all sequences, got {result!r:.100}")
            return Measured(float(_numbers(where, np.reshape(result, 1), 1)[0]))
        if self.aggregation == "mean":
            values, weight = _numbers(where, result, n), np.ones(n)
            return Measured(_mean(where, values, weight), values, weight)
        if not isinstance(result, tuple) or len(result) != 2:
            raise TypeError(f"{where}: expected a tuple of numbers and weights, got {result!r:.100}")
        values, weight = _numbers(where, result[0], n), _numbers(f"{where}: weights", result[1], n)
        if not weight.any():
            raise ValueError(f"{where}: all weights are 0")
        with np.errstate(over="ignore"):
            numerator = values * weight
        return Measured(_mean(where, numerator, weight), numerator, weight)


def _numbers(where: str, values: object, n: int) -> Float64:
    """Read one finite, non-negative number for each sequence."""
    array: Array = real_array(where, values)  # type: ignore[arg-type]
    if array.shape != (n,):
        raise ValueError(f"{where}: expected a number for each of {n} sequences, shape ({n},), got {array.shape}")
    check_finite(where, array)
    if (array < 0).any():
        i = int((array < 0).argmax())
        raise ValueError(f"{where}: {array[i]} at index ({i},); expected numbers >= 0")
    return array.astype(np.float64)


def _mean(where: str, numerator: Float64, weight: Float64) -> float:
    with np.errstate(over="ignore"):
        sums = numerator.sum(), weight.sum()
    if not np.isfinite(sums).all():
        raise ValueError(f"{where}: its sum over sequences is beyond float64")
    return float(sums[0] / sums[1])


def _checked_fields(fields: object) -> dict[str, Value | None]:
    if not isinstance(fields, Mapping):
        raise TypeError(f"fields: expected a mapping of names to values, got {fields!r}")
    for name, value in fields.items():
        if not isinstance(name, str) or not re.fullmatch(FIELD, name):
            raise ValueError(f"fields: expected names of ASCII letters, digits and '_', got {name!r}")
        if name in (*ARGUMENTS, "at_ms", "better") and not (name == "convention" and value is None):
            raise ValueError(f"fields: the signature states {name!r} anyway; leave it out")
        if name in FIELDS and value is not None:
            check_value(name, value)
        if name not in (*FIELDS, *ARGUMENTS) and not isinstance(value, str | int | float | None):
            raise TypeError(f"fields: {name}: expected text, a number or a truth value, got {value!r}")
    return dict(fields)
