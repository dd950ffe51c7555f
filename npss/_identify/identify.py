"""Say which NPSS a function computes."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any, Literal, get_args

import numpy as np

from npss._identify.calling import Subject
from npss._identify.finding import find
from npss._identify.identification import Identification
from npss._identify.judging import identification, no_npss
from npss.validation import each, one_of, positive_integer

#: The order of a function's arguments.
Order = Literal["gt,pred", "pred,gt"]


def identify(
    function: Callable[..., Any], *, order: Order | None = None, frame: int | Sequence[int] | None = None
) -> Identification:
    """Say which NPSS a function computes: run it on small motions, and compare its values with those of all choices.

    Parameters
    ----------
    function : callable
        A function of ground truth and prediction, of numpy arrays or torch tensors: ``(N, T, D)``, with joints ``(N, T,
        J, C)``, or one sequence at a time. It may return a number, an array or a tensor with one for each sequence or
        each feature of a sequence, or a tuple of distances and weights. Or a class with ``update`` and ``compute``, an
        instance of it, or a function without parameters that makes one.
    order : {'gt,pred', 'pred,gt'}, optional
        The order of its two arguments. By default the names of its parameters decide, such as ``gt``, ``target``,
        ``pred``, ``y_hat``.
    frame : int or sequence of int, optional
        The shape of a frame, if the function needs a certain one: ``99``, or ``(22, 4)``. By default, D = 12 and 24,
        and joints with 4, 3 or 6 components are tried.

    Returns
    -------
    Identification
        Its `convention` is a name or None, `nearest` and `differences` say what differs, and its text explains it.

    Raises
    ------
    TypeError
        If it is neither a function nor a class of that kind, or returns other values.
    ValueError
        If it needs other arguments than two motions, raises an error for every shape, or returns different values for
        equal motions; or if `order` or `frame` is invalid.

    Notes
    -----
    The choices are those in which public functions differ: the power of a bin, one- or two-sided spectra, the distance
    of two spectra, weights, aggregation, constant factors, removal of the mean, the axis of the transform. Numbers are
    equal if they differ by no more than the function's own rounding. The rule for features without power, epsilons in
    denominators included, does not change the name.

    The sum of a part for each sequence, or for each feature of a sequence, counts as the value of a function that
    returns such parts. What a function gets, it cannot tell: the representation, which frames, the signs of
    quaternions.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, section 3.5.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> def mine(gt, pred):
    ...     power, other = (np.fft.fft(motion, axis=1).real ** 2 for motion in (gt, pred))
    ...     cdf, other_cdf = (np.cumsum(p / p.sum(axis=1, keepdims=True), axis=1) for p in (power, other))
    ...     return np.average(np.abs(cdf - other_cdf).sum(axis=1), weights=power.sum(axis=1))
    >>> result = npss.identify(mine)
    >>> result.convention, result.no_power
    ('released', 'nan where a feature has no power')
    >>> print(npss.identify(lambda gt, pred: mine(pred, gt)).differences)
    {'weight': "the prediction's total power (arguments swapped?)"}
    """
    if order is not None:
        one_of("order", order, get_args(Order))
    shape = _shape(frame)
    subject = Subject(function, order)
    with np.errstate(all="ignore"):  # 0/0 is a matter of interest
        found = find(subject, shape)
        if not found.fits:
            return no_npss(subject, found)
        if subject.order is None and found.fits[0].swapped() != found.fits[0]:
            return _either(tuple(identify(function, order=each, frame=frame) for each in get_args(Order)))
        return identification(subject, found)


def _shape(frame: int | Sequence[int] | None) -> tuple[int, ...] | None:
    if frame is None:
        return None
    sizes = each("frame", frame, "sizes") if not isinstance(frame, int | np.integer) else [frame]
    if not sizes:
        raise ValueError("frame: expected at least one size, got none")
    shape = tuple(positive_integer("frame", size) for size in sizes)
    if math.prod(shape) < 2:
        raise ValueError(f"frame: expected at least two features, got {frame!r}")
    return shape


def _either(readings: tuple[Identification, ...]) -> Identification:
    """Merge the two readings of a function whose arguments have an unknown order."""
    best = min(readings, key=lambda reading: len(reading.differences))
    differences = {**best.differences, "order": "unknown: the names of the parameters do not say"}
    lines = ["The order of the arguments is unknown, and it decides; pass order= (--order)"]
    for order, reading in zip(get_args(Order), readings, strict=True):
        lines += [f'If it is "{order}":', *("  " + line for line in str(reading).splitlines())]
    return Identification(
        convention=None,
        nearest=best.nearest,
        differences=differences,
        choices=best.choices,
        no_power=best.no_power,
        example=best.example,
        readings=readings,
        text="\n".join(lines),
    )
