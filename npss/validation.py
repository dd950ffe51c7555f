"""Validate input, with errors that name the argument and the place.

The rules for every public function: check the kind of values before conversion; refuse ambiguous input; name the
argument, the shape and the first bad index; never write to an input.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from typing import Any, ParamSpec, TypeAlias, TypeGuard, TypeVar

import numpy as np
import numpy.typing as npt

__all__ = [
    "Array",
    "Float64",
    "Seed",
    "check_finite",
    "each",
    "generator",
    "is_integer",
    "is_real",
    "motion_pair",
    "one_of",
    "positive_integer",
    "positive_number",
    "real_array",
    "renamed",
]

Item = TypeVar("Item")
Arguments = ParamSpec("Arguments")
Result = TypeVar("Result")

#: An array of real numbers of any precision.
Array = npt.NDArray[Any]
#: An array of float64.
Float64 = npt.NDArray[np.float64]
#: A source of randomness: a whole number >= 0, for reproducible draws, or a generator, which each draw advances.
Seed: TypeAlias = "int | np.random.Generator"  # as text: `import numpy` alone does not import numpy.random

_BLOCK = 2**20  # values checked at once
_MOST_COORDINATES = 16  # of a joint: those of a homogeneous matrix

_REFUSED = {
    "b": "booleans",
    "c": "complex numbers",
    "O": "Python objects",
    "S": "bytes",
    "U": "strings",
    "T": "strings",
    "M": "dates",
    "m": "time differences",
    "V": "records",
}


def real_array(name: str, values: npt.ArrayLike) -> Array:
    """Read `values` as an array of real numbers, in the same precision and without a copy.

    Parameters
    ----------
    name : str
        Name of the argument, for errors.
    values : array_like
        Anything that numpy can read: an array, a memory map, nested lists. Also tensors of torch, jax and other
        libraries, and lists of them: detached from gradients, fetched from their device, and bfloat16 widened to
        float32, which is exact.

    Returns
    -------
    ndarray
        Integers or floats in the shape of `values`. It may share memory with `values`: never write to it.

    Raises
    ------
    TypeError
        If numpy cannot read the values, or they are masked, boolean, complex, text, dates or objects.
    ValueError
        If nested lists have unequal lengths.

    Examples
    --------
    >>> real_array("gt", [[1, 2], [3, 4]]).shape
    (2, 2)
    >>> real_array("gt", [True, False])
    Traceback (most recent call last):
    TypeError: gt: expected real numbers, got booleans (dtype bool)
    """
    _refuse_masked(name, values, "fill it (array.filled(...)) or drop its sequence")
    try:
        array = np.asarray(_fetched(values))
    except ValueError as error:
        raise ValueError(f"{name}: not a regular array of numbers ({error})") from error
    except Exception as error:  # of a device that is not there, of another version of DLPack, ...: the type varies
        raise TypeError(
            f"{name}: numpy cannot read this {type(values).__name__} ({error}); "
            f"pass a CPU array, e.g. tensor.detach().cpu().double().numpy()"
        ) from error
    # Of jax, by ml_dtypes.
    if array.dtype.kind == "V" and array.dtype.name.startswith(("bfloat", "float")):  # pragma: no cover
        array = array.astype(np.float32)
    check_real(name, array.dtype)
    if array.dtype.kind == "f" and array.dtype.itemsize > 8:  # computations are in float64
        with np.errstate(over="ignore"):
            narrow = array.astype(np.float64)
        check_finite(name, narrow, " in float64")
        return narrow
    return array


def _refuse_masked(name: str, values: object, advice: str) -> None:
    """Refuse a masked array, or a list of them."""
    parts = values if isinstance(values, list | tuple) else [values]
    if any(isinstance(part, np.ma.MaskedArray) for part in parts):
        raise TypeError(f"{name}: masked arrays are refused, because a masked entry has no value to score; {advice}")


def _fetched(values: Any) -> Any:
    """Return what numpy can read: without gradients, on the CPU, in a precision that numpy has.

    Libraries are told apart by their methods, so that none is imported.
    """
    if isinstance(values, list | tuple):
        return [_fetched(value) for value in values] if values and not is_real(values[0]) else values
    if hasattr(values, "detach") and hasattr(values, "numpy"):  # torch
        if str(values.dtype).startswith(("torch.bfloat16", "torch.float8")):  # unknown to numpy; exact in float32
            values = values.float()
        return values.numpy(force=True)
    if hasattr(values, "__cuda_array_interface__") and hasattr(values, "get"):  # cupy
        return values.get()
    if not hasattr(values, "__dlpack__") or isinstance(values, np.ndarray):
        return values
    try:  # jax and other array libraries
        return np.asarray(values) if hasattr(values, "__array__") else np.from_dlpack(values)
    except Exception:
        return np.from_dlpack(values, device="cpu")  # a copy from its device; numpy 2.1


def is_real_dtype(dtype: np.dtype[Any]) -> bool:
    """Return whether arrays of this dtype hold real numbers."""
    return dtype.kind in "iuf"


def check_real(name: str, dtype: np.dtype[Any]) -> None:
    """Raise a TypeError unless arrays of this dtype hold real numbers."""
    if not is_real_dtype(dtype):
        kind = _REFUSED.get(dtype.kind, "values of another kind")
        raise TypeError(f"{name}: expected real numbers, got {kind} (dtype {dtype})")


def check_finite(name: str, array: Array, where: str = "") -> None:
    """Refuse NaN and infinite values.

    Parameters
    ----------
    name : str
        Name of the argument, for the error.
    array : ndarray
        Real numbers, of any shape.
    where : str, optional
        Text of the error after the index.

    Raises
    ------
    ValueError
        If a value is not finite. The message names the first index, in C order.

    Examples
    --------
    >>> import numpy as np
    >>> check_finite("gt", np.array([0.0, np.nan]))
    Traceback (most recent call last):
    ValueError: gt: nan at index (1,); every value must be finite
    """
    blocks = array.reshape(1) if array.ndim == 0 else array
    rows = max(1, _BLOCK * len(blocks) // max(blocks.size, 1))  # bounds memory for arrays larger than it
    for top in range(0, len(blocks), rows):
        finite = np.isfinite(blocks[top : top + rows])
        if not finite.all():
            first = np.unravel_index(int(np.argmin(finite)), finite.shape)
            index = (int(first[0]) + top, *(int(i) for i in first[1:]))[: array.ndim]
            raise ValueError(f"{name}: {array[index]} at index {index}{where}; every value must be finite")


def motion_shape(name: str, shape: tuple[int, ...], representation: object = None) -> tuple[int, ...]:
    """Return the shape of motion whose joints are flattened: ``(N, T, D)`` or ``(T, D)``.

    Parameters
    ----------
    name : str
        Name of the argument, for errors.
    shape : tuple of int
        ``(N, T, D)``, ``(T, D)``, ``(N, T, J, C)`` with joints, or ``(N, T, J, 3, 3)`` for rotation matrices.
    representation : str, optional
        The representation of the motion; only ``'matrix'`` has five axes.

    Returns
    -------
    tuple of int
        The shape, flattened joint by joint.

    Raises
    ------
    TypeError
        If the representation is not text.
    ValueError
        If it is another shape or empty; ``(N, T, 3, 3)``, the matrices of one joint or the positions of three; or has
        joints of more than 16 numbers, as batches of sequences seem to have.

    Examples
    --------
    >>> motion_shape("gt", (8, 50, 22, 4))
    (8, 50, 88)
    >>> motion_shape("gt", (8, 50, 24, 3, 3), "matrix")
    (8, 50, 216)
    """
    if representation is not None and not isinstance(representation, str):
        raise TypeError(f"representation: expected text, got {representation!r}")
    matrices = representation == "matrix"
    ends_in_3_by_3 = len(shape) > 3 and shape[-2:] == (3, 3)
    if len(shape) == 4 and ends_in_3_by_3:
        raise ValueError(
            f"{name}: shape {shape} may be rotation matrices of one joint or positions of three; pass x[:, :, None] "
            f"with representation='matrix' for the matrices, x.reshape(N, T, 9) for the positions"
        )
    if len(shape) > 3 and matrices and not (len(shape) == 5 and ends_in_3_by_3):
        raise ValueError(f"{name}: expected rotation matrices (N, T, J, 3, 3), got shape {shape}")
    if not 2 <= len(shape) <= 4 + matrices:
        advice = "; for rotation matrices, pass representation='matrix'" if len(shape) == 5 and ends_in_3_by_3 else ""
        raise ValueError(
            f"{name}: expected shape (N, T, D) or (T, D) = (sequences, frames, features), or (N, T, J, C) with joints, "
            f"got {shape}{advice}"
        )
    if len(shape) == 4 and shape[-1] > _MOST_COORDINATES:
        raise ValueError(
            f"{name}: shape {shape} would be joints of {shape[-1]} numbers each; flatten it to (N, T, D), if its axes "
            f"are (sequences, frames, joints, coordinates), and neither batches of sequences nor time last"
        )
    flat = (*shape[:2], math.prod(shape[2:])) if len(shape) > 2 else shape
    for size, what in zip(flat[::-1], ("features", "frames", "sequences"), strict=False):
        if size == 0:
            raise ValueError(f"{name}: no {what} in an array of shape {shape}")
    return flat


def motion_array(name: str, values: npt.ArrayLike, representation: object = None) -> Array:
    """Read `values` as motion ``(N, T, D)`` or ``(T, D)``, flattened joint by joint.

    The caller checks that they are finite, except with joints: an error has the index before flattening.
    """
    motion = motion_with_joints(name, values, representation)
    if motion.ndim > 3:
        check_finite(name, motion)
    return flattened(motion)


def motion_with_joints(name: str, values: npt.ArrayLike, representation: object = None) -> Array:
    """Read `values` as motion, without flattening; the caller checks that they are finite."""
    _refuse_masked(name, values, "for sequences of unequal length, pass lengths=, one for each sequence")
    array = real_array(name, values)
    motion_shape(name, array.shape, representation)
    return array


def flattened(motion: Array) -> Array:
    """Flatten joints: ``(N, T, ...)`` to ``(N, T, D)``."""
    return motion.reshape(*motion.shape[:2], -1) if motion.ndim > 3 else motion


def motion_pair(
    gt: npt.ArrayLike, pred: npt.ArrayLike, representation: object = None, *, pred_name: str = "pred"
) -> tuple[Array, Array]:
    """Read ground truth and prediction as two arrays of the same shape.

    The caller checks that they are finite.

    Parameters
    ----------
    gt, pred : (N, T, D), (T, D) or (N, T, J, C) array_like
        Sequences, frames, features; or sequences, frames, joints and their coordinates.
    representation : str, optional
        The representation of the motion; ``'matrix'`` has the shape ``(N, T, J, 3, 3)``.
    pred_name : str, optional
        Name of the prediction, for errors.

    Returns
    -------
    gt, pred : (N, T, D) or (T, D) ndarray
        Flattened joint by joint; views where possible: never write to them.

    Raises
    ------
    TypeError
        As for `real_array`.
    ValueError
        As for `real_array` and `motion_shape`; also if the shapes differ.

    Examples
    --------
    >>> motion_pair([[0.0], [1.0]], [[0.0, 1.0]])
    Traceback (most recent call last):
    ValueError: pred: its shape (1, 2) differs from that of gt, (2, 1); nothing is broadcast
    """
    first = motion_with_joints("gt", gt, representation)
    second = motion_with_joints(pred_name, pred, representation)
    if first.shape != second.shape:
        shapes = f"its shape {second.shape} differs from that of gt, {first.shape}"
        raise ValueError(f"{pred_name}: {shapes}; nothing is broadcast")
    if first.ndim > 3:
        check_finite("gt", first)
        check_finite(pred_name, second)
    return flattened(first), flattened(second)


class BeyondFloat64Error(ValueError):
    """A result overflows although the argument is finite; `what` is the message without the argument's name."""

    def __init__(self, name: str, what: str) -> None:
        super().__init__(f"{name}: {what}")
        self.what = what


def one_of(name: str, value: object, choices: tuple[str, ...]) -> None:
    """Refuse a value that is not among the choices.

    Parameters
    ----------
    name : str
        Name of the argument, for the error.
    value : str
        The value.
    choices : tuple of str
        The choices.

    Raises
    ------
    TypeError
        If the value is not a string.
    ValueError
        If it is not one of the choices.

    Examples
    --------
    >>> one_of("average", "up", ("at", "upto"))
    Traceback (most recent call last):
    ValueError: average: expected one of at, upto, got 'up'
    """
    if not isinstance(value, str):
        raise TypeError(f"{name}: expected one of {', '.join(choices)}, got {value!r}")
    if value not in choices:
        raise ValueError(f"{name}: expected one of {', '.join(choices)}, got {value!r}")


def each(name: str, values: Iterable[Item], what: str = "numbers", *, ordered: bool = True) -> list[Item]:
    """Read several values; refuse a single one.

    Parameters
    ----------
    name : str
        Name of the argument, for the error.
    values : iterable
        The values.
    what : str, optional
        The kind of values, for the error.
    ordered : bool, optional
        Refuse sets, because the order matters.

    Returns
    -------
    list
        The values.

    Raises
    ------
    TypeError
        If it is not an iterable, or is text, a mapping, or a set although the order matters.

    Examples
    --------
    >>> each("at_ms", 80)
    Traceback (most recent call last):
    TypeError: at_ms: expected a sequence of numbers, got 80
    """
    single = isinstance(values, str | bytes | Mapping) or not isinstance(values, Iterable)
    if single or (ordered and isinstance(values, set | frozenset)):
        raise TypeError(f"{name}: expected a sequence of {what}, got {values!r}")
    return list(values)


def is_integer(value: object) -> TypeGuard[int]:
    """Return whether a value is an int or a numpy integer, and not a bool.

    Parameters
    ----------
    value : object
        Anything.

    Returns
    -------
    bool
        Whether it is.

    Examples
    --------
    >>> is_integer(1), is_integer(1.0), is_integer(True)
    (True, False, False)
    """
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


def is_real(value: object) -> TypeGuard[float]:
    """Return whether a value is an integer or a float, of Python or numpy, and not a bool.

    Parameters
    ----------
    value : object
        Anything.

    Returns
    -------
    bool
        Whether it is.

    Examples
    --------
    >>> is_real(1), is_real(1.0), is_real("1")
    (True, True, False)
    """
    return is_integer(value) or isinstance(value, float | np.floating)


def positive_number(name: str, value: object) -> float:
    """Read a positive, finite real number.

    Parameters
    ----------
    name : str
        Name of the argument, for the error.
    value : int or float
        A number of Python or numpy; not a bool.

    Returns
    -------
    float
        The number.

    Raises
    ------
    TypeError
        If it is not a real number.
    ValueError
        If it is not positive, or not finite.

    Examples
    --------
    >>> positive_number("fps", 25)
    25.0
    """
    if not is_real(value):
        raise TypeError(f"{name}: expected a positive number, got {value!r}")
    try:
        number = float(value)
    except OverflowError:  # a whole number beyond float64
        number = math.inf
    if not (np.isfinite(number) and number > 0):
        raise ValueError(f"{name}: expected a positive, finite number, got {value!r:.100}")
    return number


def positive_integer(name: str, value: object) -> int:
    """Read a positive integer.

    Parameters
    ----------
    name : str
        Name of the argument, for the error.
    value : int
        An integer of Python or numpy; not a bool.

    Returns
    -------
    int
        The number.

    Raises
    ------
    TypeError
        If it is not an integer.
    ValueError
        If it is not positive.

    Examples
    --------
    >>> positive_integer("workers", 0)
    Traceback (most recent call last):
    ValueError: workers: expected a positive integer, got 0
    """
    if not is_integer(value):
        raise TypeError(f"{name}: expected a positive integer, got {value!r}")
    if value <= 0:
        raise ValueError(f"{name}: expected a positive integer, got {value!r}")
    return int(value)


def generator(seed: Seed) -> np.random.Generator:
    """Return a random generator: a new one from a seed, or the one passed.

    Parameters
    ----------
    seed : int or numpy.random.Generator
        A whole number >= 0, or a generator, which each draw advances.

    Returns
    -------
    numpy.random.Generator
        The generator.

    Raises
    ------
    TypeError
        If it is neither.
    ValueError
        If the number is negative.

    Examples
    --------
    >>> float(generator(0).random()) == float(np.random.default_rng(0).random())
    True
    """
    if isinstance(seed, np.random.Generator):
        return seed
    if not is_integer(seed):
        raise TypeError(f"seed: expected a whole number or a numpy.random.Generator, got {seed!r}")
    if seed < 0:
        raise ValueError(f"seed: expected a whole number >= 0, got {seed}")
    return np.random.default_rng(int(seed))


def renamed(**names: str) -> Callable[[Callable[Arguments, Result]], Callable[Arguments, Result]]:
    """Refuse former names of a function's arguments, with an error that names the new ones.

    Parameters
    ----------
    **names : str
        The new name of each argument, by its former name.

    Returns
    -------
    callable
        A decorator.

    Raises
    ------
    TypeError
        If the decorated function is called with a former name.

    Examples
    --------
    >>> @renamed(rng="seed")
    ... def draw(*, seed=0): ...
    >>> draw(rng=1)
    Traceback (most recent call last):
    TypeError: draw() has no argument 'rng': it is called 'seed'
    """

    def decorate(function: Callable[Arguments, Result]) -> Callable[Arguments, Result]:
        @wraps(function)
        def call(*args: Arguments.args, **kwargs: Arguments.kwargs) -> Result:
            for former, present in names.items():
                if former in kwargs:
                    raise TypeError(f"{function.__name__}() has no argument {former!r}: it is called {present!r}")
            return function(*args, **kwargs)

        return call

    return decorate
