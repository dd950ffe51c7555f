"""Call the user's function as it wants to be called, and read what it returns."""

from __future__ import annotations

import copy
import inspect
import math
import traceback
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from importlib.util import find_spec
from itertools import pairwise
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from npss._identify.arguments import parameters_of
from npss._identify.compute import Numbers
from npss._identify.probes import Probe
from npss.validation import Float64

_OURS = Path(__file__).parent
#: The shapes of a frame to try: 12 features, of joints with 4, 3 or 6 components.
_FRAMES = ((12,), (3, 4), (4, 3), (2, 6))


class Form(NamedTuple):
    """How a function takes motion."""

    frame: tuple[int, ...]  # (D,), or (J, C) for joints
    wider: tuple[int, ...]  # another shape that it may take
    single: bool  # one sequence at a time
    dtype: str | None = None  # of tensors; None for numpy arrays
    of_one: bool = False  # a single sequence is an array of one

    @property
    def shape(self) -> str:
        """Name the axes of an array."""
        names = {1: "D", 2: "J, C", 3: "J, 3, 3"}.get(len(self.frame), ", ".join(map(str, self.frame)))
        return f"({'' if self.single and not self.of_one else 'N, '}T, {names})"

    def words(self) -> str:
        """Describe the arguments."""
        what = "arrays" if self.dtype is None else f"tensors of {self.dtype}"
        return f"{what} {self.shape}" + (", one sequence at a time" if self.single else "")


class Subject:
    """A function of two motions, or a class with ``update`` and ``compute``."""

    def __init__(self, function: Any, order: str | None) -> None:
        self.name = str(getattr(function, "__qualname__", type(function).__qualname__))
        self._make: Callable[[], Any] | None = None
        self._function = function
        if isinstance(function, type) and not _is_metric(function):
            self._function = self._instance(function)
        elif _is_metric(function):
            self._make = (lambda: self._instance(function)) if isinstance(function, type) else lambda: _fresh(function)
        elif not callable(function):
            raise TypeError(f"function: expected a function, or a class with update and compute, got {function!r}")
        elif _makes_metric(function):
            self._make = function
        if self._make is not None:
            made = self._make()
            if not _is_metric(made):
                raise TypeError(f"function: {self.name} returns {made!r}, which has no update and compute")
            self._parameters = parameters_of(made.update)
        elif callable(self._function):
            self._parameters = parameters_of(self._function)
        else:
            raise TypeError(f"function: {self.name} can neither be called nor has it update and compute")
        #: Which argument is the ground truth, as given or by the names; None if that is unknown.
        self.order = order or self._parameters.order

    @property
    def is_class(self) -> bool:
        """Whether it takes batches by ``update``."""
        return self._make is not None

    def _instance(self, kind: type) -> Any:
        try:
            return kind()
        except Exception as error:
            raise ValueError(
                f"function: {self.name}() raises {text_of(error)}; pass a function that makes one, such as "
                f"lambda: {self.name}(...)"
            ) from error

    def __call__(self, probe: Probe, form: Form, batches: Sequence[int] = ()) -> list[Any]:
        """Return what the function returns, once for each sequence if it takes single ones.

        A class gets the sequences in batches of these sizes; by default, in one.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            if self._make is None:
                return [self._call(self._function, gt, pred, form) for gt, pred in _pieces(probe, form)]
            made = self._make()
            for gt, pred in _pieces(probe, form, batches):
                self._call(made.update, gt, pred, form)
            return [made.compute()]

    def _call(self, function: Callable[..., Any], gt: Float64, pred: Float64, form: Form) -> Any:
        first, second = (pred, gt) if self.order == "pred,gt" else (gt, pred)
        pair = [_as_wanted(motion, form) for motion in (first, second)]
        names = self._parameters.names
        try:
            return function(*pair) if names is None else function(**dict(zip(names, pair, strict=True)))
        except SystemExit as error:
            raise RuntimeError(f"SystemExit: {error}") from error


def forms(frame: tuple[int, ...] | None, *, tensors: bool) -> Iterator[Form]:
    """Yield ways to pass motion, the usual ones first; of one shape of a frame if it is given."""
    frames = _FRAMES if frame is None else (frame,) if len(frame) == 1 else ((math.prod(frame),), frame)
    for dtype in ("float64", "float32") if tensors else (None,):
        for single in (False, True):
            for shape in frames:
                yield Form(shape, shape if frame else (2 * shape[0], *shape[1:]), single, dtype)


def torch_is_installed() -> bool:
    """Return whether torch can be imported; it is not imported."""
    return find_spec("torch") is not None


def readings(
    outputs: Sequence[list[Any]], probes: Sequence[Probe], *, single: bool
) -> dict[tuple[str, str], list[Numbers]]:
    """Read what a function returned for each probe as numbers, in all ways that fit every probe.

    `single`: it was called once for each sequence.

    The key of a reading is its level (``"set"``: a number, ``"sequence"``: one for each sequence, ``"column"``: one for
    each feature of each sequence) and what it is, in words.

    Raises
    ------
    TypeError
        If a value is neither a number nor an array or a tuple of them.
    """
    found: dict[tuple[str, str], list[Numbers]] = {}
    for probe, returned in zip(probes, outputs, strict=True):
        each = [_read(_arrays(value), 1 if single else len(probe.gt)) for value in returned]
        joined = {
            key: np.concatenate([np.ravel(one[key]) for one in each])
            for key in each[0]
            if all(key in one for one in each)
        }
        if single:
            joined = {("sequence" if level == "set" else level, what): v for (level, what), v in joined.items()}
        for key, value in joined.items():
            found.setdefault(key, []).append(value)
    return {key: values for key, values in found.items() if len(values) == len(probes)}


def _read(arrays: list[Numbers], n: int) -> dict[tuple[str, str], Numbers]:
    read: dict[tuple[str, str], Numbers] = {}
    if len(arrays) == 1:
        (array,) = arrays
        if array.size == 1:
            read = {("set", "a number"): array}
        if array.size == n and array.ndim:
            read |= {
                ("sequence", "a number for each sequence"): array,
                ("set", "a part for each sequence, to be added up"): array.sum(),
            }
        if read:
            return read
        return {
            ("column", "a number for each feature of each sequence"): array,
            ("set", "a part for each feature of each sequence, to be added up"): array.sum(),
            ("set", "a number for each feature of each sequence, to be averaged"): array.mean(),
        }
    first, second = arrays[:2]
    if first.size == 1:
        read[("set", "a number and others")] = first
    if len(arrays) == 2 and first.size == second.size:
        read[("set", "distances and weights")] = (first * second).sum() / second.sum()
        read[("set", "sums of weighted distances and of weights")] = first.sum() / second.sum()
    return read


def sum_of_weights(value: Any) -> Numbers:
    """Return the sum of the second of two arrays that a function returned."""
    return np.asarray(_arrays(value)[1].sum())


def _arrays(value: Any) -> list[Numbers]:
    """Return what a function returned as arrays, several if it is a tuple."""
    if isinstance(value, tuple):
        return [_array(one) for one in value] or [_array(None)]
    return [_array(value)]


def _array(value: Any) -> Numbers:
    if isinstance(value, Mapping):
        keys = ", ".join(map(str, value))
        raise TypeError(f"function: returns a dict ({keys}); pass a function that returns one of its values")
    if hasattr(value, "detach"):  # a tensor
        value = value.detach().cpu()
        if str(value.dtype) == "torch.bfloat16":  # unknown to numpy
            value = value.float()
    try:
        array = np.asarray(value)
        if array.dtype.kind not in "fciu":
            raise TypeError
        return array.astype(complex if array.dtype.kind == "c" else float).real
    except (TypeError, ValueError):
        raise TypeError(
            f"function: returns {type(value).__name__}; expected a number, an array, or a tuple of them"
        ) from None


def _pieces(probe: Probe, form: Form, batches: Sequence[int] = ()) -> Iterator[tuple[Float64, Float64]]:
    """Yield copies of the motions as a function takes them."""
    shape = probe.gt.shape
    gt, pred = (motion.reshape(*shape[:2], *probe.frame).copy() for motion in (probe.gt, probe.pred))
    if form.single:
        of_each = (motion[:, np.newaxis] if form.of_one else motion for motion in (gt, pred))
        yield from zip(*of_each, strict=True)
    else:
        edges = np.cumsum([0, *(batches or [len(gt)])])
        yield from ((gt[start:stop], pred[start:stop]) for start, stop in pairwise(edges))


def _as_wanted(motion: Float64, form: Form) -> Any:
    if form.dtype is None:
        return motion
    import torch  # here, because only functions of tensors need it

    return torch.tensor(motion, dtype=getattr(torch, form.dtype))


def _is_metric(value: Any) -> bool:
    return callable(getattr(value, "update", None)) and callable(getattr(value, "compute", None))


def _makes_metric(function: Callable[..., Any]) -> bool:
    """Return whether it is to be called without arguments: a partial class, or a function without parameters."""
    if isinstance(function, partial):
        return _is_metric(function.func)
    try:
        return not inspect.signature(function).parameters
    except (TypeError, ValueError):
        return False


def _fresh(metric: Any) -> Any:
    """Copy a metric, without what it has seen."""
    made = copy.deepcopy(metric)
    if callable(getattr(made, "reset", None)):
        made.reset()
    return made


def text_of(error: BaseException) -> str:
    """Return an error in one line, with the line of the user's code that raised it or called what did."""
    text = " ".join(f"{type(error).__name__}: {error}".split())
    theirs = [frame for frame in traceback.extract_tb(error.__traceback__) if Path(frame.filename).parent != _OURS]
    return f"{text} ({theirs[0].filename}, line {theirs[0].lineno})" if theirs else text
