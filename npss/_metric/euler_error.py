"""The Euler angle error, which the field calls "MSE", and the true mean squared error."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Literal, NamedTuple, get_args, overload

import numpy as np
import numpy.typing as npt

from npss._metric.exact_sum import UNIT, exact_sum
from npss._metric.sequences import Group, Lengths, read_motions
from npss._metric.times import Average, check_average, errors_at, frames_at
from npss.validation import Array, BeyondFloat64Error, Float64, check_finite, motion_pair, one_of

_BLOCK = 2**16  # values of one array processed at once
#: The features to compare: those that move in the ground truth, in the prediction, or in the whole set; or all.
Columns = Literal["gt", "pred", "set", "all"]
#: What a sequence without a feature to compare is: an error, or a sequence whose error is zero.
Still = Literal["error", "zero"]
#: Which features are compared, ``(D,)``.
Mask = npt.NDArray[np.bool_]
#: A feature moves if its standard deviation over the frames of a sequence exceeds this.
MOVES = 1e-4


class EulerErrorAt(NamedTuple):
    """The Euler error at one time, of the sequences that reach it.

    Attributes
    ----------
    error : float
        The error, in radians.
    sequences : int
        The number of sequences compared.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt = np.linspace(0, 1, 25)[:, np.newaxis] * np.ones((2, 1, 3))
    >>> npss.euler_error(gt, gt, at_ms=[80, 1000], lengths=[10, 25])
    {80: EulerErrorAt(error=0.0, sequences=2), 1000: EulerErrorAt(error=0.0, sequences=1)}
    """

    error: float
    sequences: int


@overload
def euler_error(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    fps: float = ...,
    at_ms: Sequence[float] = ...,
    columns: Columns = ...,
    average: Average = ...,
    still: Still = ...,
    lengths: None = ...,
) -> dict[float, float]: ...
@overload
def euler_error(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    fps: float = ...,
    at_ms: Sequence[float] = ...,
    columns: Columns = ...,
    average: Average = ...,
    still: Still = ...,
    lengths: npt.ArrayLike,
) -> dict[float, EulerErrorAt]: ...
def euler_error(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    fps: float = 25,
    at_ms: Sequence[float] = (80, 160, 320, 400, 560, 1000),
    columns: Columns = "gt",
    average: Average = "at",
    still: Still = "error",
    lengths: Lengths = None,
) -> Mapping[float, float | EulerErrorAt]:
    """Return the Euler angle error at given times: the field's "MSE", a mean of norms, not of squares.

    The error is the Euclidean norm of the difference of Euler angles in a frame, averaged over sequences.

    Parameters
    ----------
    gt, pred : (N, T, D), (T, D) or (N, T, J, C) array_like
        Ground truth and prediction: Euler angles in radians, or a list of sequences, which may differ in length. For
        Human3.6M poses, see `poses_to_euler`.
    fps : float, optional
        Frames per second.
    at_ms : sequence of float, optional
        Times in milliseconds after the last seed frame: at 25 frames per second, 80 ms is the second predicted frame.
    columns : {'gt', 'pred', 'set', 'all'}, optional
        The features of a sequence to compare: those that move in the ground truth (the field's choice), those that
        move in the prediction (one released evaluation, where a constant prediction has no error), those that move in
        the ground truth of the whole set (tables of AMASS), or all. A feature moves if its standard deviation over the
        T frames, or for 'set' over all frames of all sequences, exceeds 1e-4.
    average : {'at', 'up-to', 'sum'}, optional
        The error at each time, or the average or the sum (tables of AMASS) of the errors of all frames up to it.
    still : {'error', 'zero'}, optional
        Refuse a sequence in whose ground truth no feature moves, or count its error as zero (tables of AMASS).
    lengths : (N,) array_like of int, optional
        The number of frames of each sequence that count, as for `score`.

    Returns
    -------
    dict of float to float, or to EulerErrorAt
        The error at each time, in radians; whole numbers of milliseconds are ints. With `lengths`, or for lists of
        sequences that differ in length, the error of the sequences that reach the time, and their number.

    Raises
    ------
    TypeError
        If `gt` or `pred` does not hold real numbers, or a time is not a number.
    ValueError
        If the shapes are wrong or differ, a value is NaN or infinite, no feature of a sequence moves in the ground
        truth (commands leave out such sequences and report it; ``still="zero"`` counts them), or a time is not that of
        a frame. The message then names the nearest times.

    See Also
    --------
    euler_error_curve : the error of every frame.

    References
    ----------
    K. Fragkiadaki et al., "Recurrent Network Models for Human Dynamics", ICCV 2015. The mask of moving features and
    the times: J. Martinez et al., "On Human Motion Prediction Using Recurrent Neural Networks", CVPR 2017.
    A. Gopalakrishnan et al., CVPR 2019, tables 6 and 7. The set, the sum and still sequences: E. Aksan, M. Kaufmann,
    O. Hilliges, "Structured Prediction Helps 3D Human Motion Modelling", ICCV 2019, and the fairmotion library.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt = np.linspace(0, 1, 25)[:, np.newaxis] * [1.0, 2.0]
    >>> {t: round(e, 3) for t, e in npss.euler_error(gt, np.zeros_like(gt), at_ms=(80, 1000)).items()}
    {80: 0.093, 1000: 2.236}
    """
    check_average(average)
    motions = read_motions(gt, pred, lengths=lengths, spectra=False)
    frames = frames_at(at_ms, fps, motions.groups[-1].n_frames)
    of_set = _of_set(columns, *(group.gt for group in motions.groups))
    if not motions.by_length:
        return errors_at(_curve(motions.groups[0].gt, motions.groups[0].pred, columns, still, of_set), frames, average)
    curves = [curve for group in motions.groups for curve in _curves(group, columns, still, of_set)]
    return {time: _reached(curves, count, average) for time, count in frames.items()}


def _reached(curves: list[Float64], count: int, average: Average) -> EulerErrorAt:
    """Average the errors of the sequences that have so many frames, in any order."""
    errors = [errors_at(curve, {0: count}, average)[0] for curve in curves if len(curve) >= count]
    return EulerErrorAt(math.fsum(errors) / len(errors), len(errors))


def euler_error_curve(
    gt: npt.ArrayLike, pred: npt.ArrayLike, *, columns: Columns = "gt", still: Still = "error"
) -> Float64:
    """Return the Euler angle error of every predicted frame.

    Parameters
    ----------
    gt, pred : (N, T, D), (T, D) or (N, T, J, C) array_like
        As for `euler_error`.
    columns : {'gt', 'pred', 'set', 'all'}, optional
        As for `euler_error`.
    still : {'error', 'zero'}, optional
        As for `euler_error`.

    Returns
    -------
    (T,) ndarray of float64
        The average over sequences, in radians. Entry k is (k + 1) / fps seconds after the last seed frame.

    Raises
    ------
    TypeError, ValueError
        As for `euler_error`.

    References
    ----------
    As for `euler_error`.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt = np.array([[0.0, 0.0], [3.0, 4.0]])
    >>> npss.euler_error_curve(gt, np.zeros((2, 2)))
    array([0., 5.])
    """
    truth, prediction = motion_pair(gt, pred)
    return _curve(truth, prediction, columns, still, _of_set(columns, truth))


def mse(gt: npt.ArrayLike, pred: npt.ArrayLike) -> float:
    """Return the mean squared error over sequences, frames and features.

    The field's tables use "MSE" for another metric: see `euler_error`.

    Parameters
    ----------
    gt, pred : (N, T, D), (T, D) or (N, T, J, C) array_like
        Ground truth and prediction.

    Returns
    -------
    float
        In squared units of the input.

    Raises
    ------
    TypeError, ValueError
        If the input is invalid, or the result is beyond float64.

    Examples
    --------
    >>> import npss
    >>> npss.mse([[0.0, 1.0]], [[2.0, 1.0]])
    2.0
    """
    truth, prediction = motion_pair(gt, pred)
    total = 0
    with np.errstate(all="ignore"):
        for _, first, second in pair_blocks(truth, prediction):
            squares, shift = float(np.square(first - second).sum()), 0
            if not 1e-280 < squares < math.inf:
                first, second, shift = _scaled(first, second, truth, prediction)
                squares = float(np.square(first - second).sum())
            total += exact_sum(np.array([squares]), np.array([2 * shift]))
    try:
        return total / (truth.size << UNIT)
    except OverflowError:
        raise BeyondFloat64Error("pred", "its mean squared difference from gt is beyond the largest float64") from None


def sequence_errors(gt: npt.ArrayLike, pred: npt.ArrayLike, *, columns: Columns = "gt") -> Float64:
    """Return the error of every frame of every sequence, ``(N, T)``; `euler_error_curve` averages it."""
    truth, prediction = motion_pair(gt, pred)
    errors = np.concatenate(list(_errors(truth, prediction, columns, "error", _of_set(columns, truth))))
    _check_range(errors)
    return errors


def moving_pair(gt: npt.ArrayLike, pred: npt.ArrayLike) -> tuple[Array, Array, npt.NDArray[np.bool_]]:
    """Read ground truth and prediction, and drop still sequences, which have no Euler error.

    Also return the mask of still sequences, ``(N,)``. If all are still, keep them.
    """
    truth, prediction = motion_pair(gt, pred)
    still = np.concatenate([~moving(first).any(axis=1) for _, first, _ in pair_blocks(truth, truth)])
    if still.any():  # NaN counts as still, too
        check_finite("gt", truth)
        check_finite("pred", prediction)
        if not still.all():
            truth, prediction = truth[~still], prediction[~still]
    return truth, prediction, still


def _curves(group: Group, columns: Columns, still: Still, of_set: Mask) -> Float64:
    """Return the errors of sequences of one length, ``(n, T)``."""
    errors = np.concatenate(list(_errors(group.gt, group.pred, columns, still, of_set, group.rows)))
    _check_range(errors)
    return errors


def _curve(gt: Array, pred: Array, columns: Columns, still: Still, of_set: Mask) -> Float64:
    """Average the errors over sequences, ``(T,)``."""
    n_sequences = len(gt) if gt.ndim == 3 else 1
    curve = np.zeros(gt.shape[-2])
    for errors in _errors(gt, pred, columns, still, of_set):
        curve += errors.sum(axis=0) / n_sequences
    _check_range(curve)
    return curve


def _check_range(errors: Float64) -> None:
    if not np.isfinite(errors).all():
        raise BeyondFloat64Error("pred", "its difference from gt is beyond the largest float64")


def _of_set(columns: Columns, *motions: Array) -> Mask:
    """Return the features of all sequences together that are compared, ``(D,)``; all, if each sequence chooses."""
    one_of("columns", columns, get_args(Columns))
    return moving_in_set(*motions) if columns == "set" else np.ones(motions[0].shape[-1], bool)


def _errors(
    gt: Array, pred: Array, columns: Columns, still: Still, of_set: Mask, rows: Sequence[int] = ()
) -> Iterator[Float64]:
    """Yield the errors ``(n, T)`` of one block of sequences after another; infinite where beyond float64.

    `rows` are the places of the sequences in the whole set, for errors.
    """
    one_of("still", still, get_args(Still))
    for top, first, second in pair_blocks(gt, pred):
        with np.errstate(all="ignore"):
            if columns in ("all", "set"):
                moves = np.tile(of_set, (len(first), 1))
            else:
                moves = moving(first if columns == "gt" else second)
            errors = _norms(first, second, moves)
            if not np.isfinite(errors).all():
                first, second, shift = _scaled(first, second, gt, pred)
                errors = np.ldexp(_norms(first, second, moves), shift)
        nothing = ~moves.any(axis=1)
        if columns in ("gt", "set") and still == "error" and nothing.any():
            place = top + int(np.argmax(nothing))
            what = "the set" if columns == "set" else f"sequence {rows[place] if rows else place}"
            raise ValueError(
                f"gt: no feature of {what} moves "
                f"(standard deviation over its frames > {MOVES:g}), so nothing can be compared"
            )
        yield errors


def _norms(first: Float64, second: Float64, moves: npt.NDArray[np.bool_]) -> Float64:
    """Return the Euclidean norms ``(n, T)`` of the difference over the features in the mask, ``(n, D)``."""
    difference = first - second
    difference *= moves[:, np.newaxis]
    squares = np.einsum("ntd,ntd->nt", difference, difference)
    norms: Float64 = np.sqrt(squares)
    tiny = squares < 1e-280
    if tiny.any():  # zero, or underflown
        frames = difference[tiny]  # (m, D)
        shift = np.frexp(np.abs(frames).max(axis=-1))[1]
        scaled = np.ldexp(frames, -shift[:, np.newaxis])
        norms[tiny] = np.ldexp(np.sqrt(np.square(scaled).sum(axis=-1)), shift)
    return norms


def moving(motion: Float64) -> npt.NDArray[np.bool_]:
    """Return where the standard deviation over the frames exceeds `MOVES`, ``(n, D)``.

    It lies between range / sqrt(2 T) and range / 2, so most features are decided by their range.
    """
    span = motion.max(axis=1) - motion.min(axis=1)
    moves: npt.NDArray[np.bool_] = span > 1.001 * MOVES * math.sqrt(2 * motion.shape[1])
    sequence, feature = np.nonzero(~moves & (span > MOVES))
    if sequence.size:
        moves[sequence, feature] = motion[sequence, :, feature].std(axis=1) > MOVES
    return moves


def moving_in_set(*motions: Array) -> Mask:
    """Return where the standard deviation over all frames of all sequences exceeds `MOVES`, ``(D,)``."""
    frames = sum(motion[..., 0].size for motion in motions)
    over = tuple(range(motions[0].ndim - 1))
    with np.errstate(all="ignore"):
        mean = sum(motion.sum(axis=over, dtype=np.float64) for motion in motions) / frames
        squares = np.zeros_like(mean)
        for motion in motions:
            for _, block, _ in pair_blocks(motion, motion):
                squares += np.square(block - mean).sum(axis=(0, 1))
        moves: Mask = ~(np.sqrt(squares / frames) <= MOVES)  # true where beyond float64
    return moves


def pair_blocks(gt: Array, pred: Array) -> Iterator[tuple[int, Float64, Float64]]:
    """Yield the index of a block's first sequence and both blocks ``(n, T, D)``, as float64; never write to them."""
    truths, predictions = (gt, pred) if gt.ndim == 3 else (gt[np.newaxis], pred[np.newaxis])
    height = max(1, _BLOCK // (truths.shape[1] * truths.shape[2]))
    for top in range(0, len(truths), height):
        first = np.ascontiguousarray(truths[top : top + height], dtype=np.float64)
        second = np.ascontiguousarray(predictions[top : top + height], dtype=np.float64)
        yield top, first, second


def _scaled(first: Float64, second: Float64, gt: Array, pred: Array) -> tuple[Float64, Float64, int]:
    """Return blocks of `gt` and `pred` times ``2**-shift``, and the shift; it keeps squares in range.

    Raise a ValueError that names the place of a value that is not finite.
    """
    peak = float(np.max([np.abs(first).max(), np.abs(second).max()]))  # NaN stays NaN
    if not math.isfinite(peak):
        check_finite("gt", gt)
        check_finite("pred", pred)
    shift = math.frexp(peak)[1]
    return np.ldexp(first, -shift), np.ldexp(second, -shift), shift
