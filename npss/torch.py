"""The score as a differentiable torch function, on the device of its tensors.

It follows the definition, over all bins of the convention, so that autograd meets only sums, quotients and absolute
values. Three details keep gradients finite and prevent overflow:

- Power is ``re**2 + im**2``, not the square of a magnitude, whose gradient at zero is undefined.
- A zero denominator is replaced before the division, not after: a gradient of ``0/0`` would be nan even where the value
  is unused.
- Each feature of each sequence is divided by its peak, treated as a constant. So no square overflows, and the gradient
  is complete, because the score does not depend on the scale of a feature.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import reduce
from typing import NamedTuple

import torch

from npss._metric.bound import Normalize, check_normalize, largest_distance, unit_of_weight
from npss._metric.convention import Convention, ConventionName, as_convention
from npss._metric.sequences import Lengths, check_sequences, read_lengths, rows_by_length
from npss.validation import check_finite, motion_shape, real_array

__all__ = ["score"]

#: A tensor, or a list of sequences.
Motion = torch.Tensor | list[torch.Tensor] | tuple[torch.Tensor, ...]

_DTYPES = (torch.float64, torch.float32, torch.float16, torch.bfloat16)


def score(
    gt: Motion,
    pred: Motion,
    *,
    convention: ConventionName | Convention = "paper",
    lengths: Lengths = None,
    normalize: Normalize = None,
    representation: str | None = None,
) -> torch.Tensor:
    """Return the NPSS as a differentiable scalar tensor, equal to `npss.score`.

    Parameters
    ----------
    gt : (N, T, D), (T, D) or (N, T, J, C) tensor
        Ground truth: N sequences of T >= 2 frames of D features (angles in radians, usually), or of J joints, which are
        flattened. float64, float32, float16 or bfloat16, on any device. Or a list of N sequences ``(T, D)`` or
        ``(T, J, C)``.
    pred : tensor
        Prediction, with the shape and device of `gt` and any of these dtypes.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `npss.score`.
    lengths : (N,) array_like or tensor of int, optional
        As for `npss.score`.
    normalize : {'bound'}, optional
        As for `npss.score`; required for sequences of unequal length.
    representation : str, optional
        As for `npss.score`: ``'matrix'`` has the shape ``(N, T, J, 3, 3)``.

    Returns
    -------
    () tensor
        The score, on the device of the input. Computed in float64 if either input is, and in float32 otherwise,
        including half precision. float32 agrees with `npss.score` to about 1e-4 of the value, float64 to 1e-10.

    Raises
    ------
    TypeError
        If an argument is not a tensor of one of these dtypes, or the convention is neither a name nor a `Convention`.
    ValueError
        If the shapes are wrong or differ, or the devices differ, a value is NaN or infinite (the message names its
        index), there are fewer than two frames, the ground truth has no power, or the convention is unknown.

    See Also
    --------
    npss.score : the same for arrays, with exact sums: report this one.
    npss.torchmetrics.NPSS : the same over batches.

    Notes
    -----
    As a loss, combine it with another: it ignores the scale and the sign of a predicted feature, and shifts in time
    (except with ``power='real'``). Constant features of the prediction, including zeros, have a gradient of zero up to
    rounding, so descent from a standing pose makes no progress.

    Each call waits once for the device, to check that the score exists (finite input, ground truth with power). Tensors
    are copied only if it does not, to name the place.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, section 3.5,
    equations 7 to 9.

    Examples
    --------
    >>> import torch
    >>> import npss.torch
    >>> t = torch.arange(100, dtype=torch.float64)[:, None] / 25
    >>> gt = torch.cos(2 * torch.pi * torch.tensor([0.5, 1.0]) * t)
    >>> pred = torch.cos(2 * torch.pi * torch.tensor([1.25, 1.25]) * t).requires_grad_()
    >>> value = npss.torch.score(gt, pred)
    >>> round(value.item(), 3)
    2.0
    >>> value.backward()
    >>> pred.grad.shape
    torch.Size([100, 2])
    """
    choices = as_convention(convention)
    check_normalize(normalize)
    pairs = read_pairs(gt, pred, lengths=lengths, normalize=normalize, representation=representation)
    dtypes = [motion.dtype for pair in pairs.groups for motion in pair]
    dtype = reduce(torch.promote_types, dtypes, torch.float32)
    groups = [(truth.to(dtype), prediction.to(dtype)) for truth, prediction in pairs.groups]
    numerator, denominator = weighted_sums(groups, choices, relative=True, normalize=normalize)
    value = numerator / denominator
    if bool(value.isnan()):  # the only wait: NaN or infinite input, or 0/0
        check_finite_tensor("gt", pairs.gt)
        check_finite_tensor("pred", pairs.pred)
        raise ValueError("gt: no power in any feature of any sequence, so there is nothing to score")
    return value


class TensorPairs(NamedTuple):
    """Ground truth and prediction, in pairs of one length."""

    groups: list[tuple[torch.Tensor, torch.Tensor]]  # (n, T, D) or (T, D), from short to long
    gt: torch.Tensor | list[torch.Tensor]  # the frames that count, before flattening: sequences, or all of them
    pred: torch.Tensor | list[torch.Tensor]


def read_pairs(
    gt: Motion,
    pred: Motion,
    *,
    names: tuple[str, str] = ("gt", "pred"),
    lengths: Lengths = None,
    normalize: Normalize = None,
    representation: str | None = None,
) -> TensorPairs:
    """Check that tensors or lists of them are pairs of motions, without reading their values, and flatten joints.

    Errors compare the prediction with the ground truth.

    Raises
    ------
    TypeError, ValueError
        As for `score`, except for values.
    """
    if isinstance(gt, torch.Tensor) and isinstance(pred, torch.Tensor) and lengths is None:
        _check_tensors(names, (gt, pred), representation)
        _check_alike(names, (gt, pred), gt.shape, pred.shape)
        shape = motion_shape(names[0], tuple(gt.shape), representation)
        if shape[-2] < 2:
            raise ValueError(f"{names[0]}: one frame; a power spectrum needs at least two")
        return TensorPairs([(gt.reshape(shape), pred.reshape(shape))], gt, pred)
    truths, predictions = (
        _sequences(name, motion, representation) for name, motion in zip(names, (gt, pred), strict=True)
    )
    if len(truths) != len(predictions):
        raise ValueError(f"{names[1]}: {len(predictions)} sequences, but {names[0]} has {len(truths)}")
    counts = [len(truth) for truth in truths]
    if lengths is not None:
        counts = read_lengths(lengths, [min(map(len, pair)) for pair in zip(truths, predictions, strict=True)])
        truths, predictions = (
            [motion[:n] for motion, n in zip(motions, counts, strict=True)] for motions in (truths, predictions)
        )
    for i, pair in enumerate(zip(truths, predictions, strict=True)):
        _check_alike((f"{names[0]}: sequence {i}", f"{names[1]}: sequence {i}"), pair, pair[0].shape, pair[1].shape)
        _check_alike(
            (f"{names[0]}: sequence 0", f"{names[0]}: sequence {i}"),
            (truths[0], pair[0]),
            truths[0].shape[1:],
            pair[0].shape[1:],
        )
    if min(counts) < 2:
        raise ValueError(f"{names[0]}: one frame in sequence {counts.index(1)}; a power spectrum needs at least two")
    if len(set(counts)) > 1 and normalize is None:
        raise ValueError(
            f"normalize: expected 'bound' for sequences of {min(counts)} to {max(counts)} frames, whose scores are not "
            f"comparable, got None"
        )
    groups = []
    for rows in rows_by_length(counts):
        both = [torch.stack([motions[i] for i in rows]).flatten(2) for motions in (truths, predictions)]
        groups.append((both[0], both[1]))
    return TensorPairs(groups, truths, predictions)


def _sequences(name: str, motion: Motion, representation: str | None) -> list[torch.Tensor]:
    """Return the sequences of a tensor or a list."""
    if isinstance(motion, list | tuple):
        if not motion:
            raise ValueError(f"{name}: no sequences in an empty list")
        for i, sequence in enumerate(motion):
            shaped = sequence[None] if isinstance(sequence, torch.Tensor) else sequence
            if isinstance(sequence, torch.Tensor) and sequence.ndim < 2:
                got = tuple(sequence.shape)
                raise ValueError(f"{name}: sequence {i}: expected shape (T, D), or (T, J, C) with joints, got {got}")
            _check_tensors([f"{name}: sequence {i}"], [shaped], representation)
        return list(motion)
    _check_tensors([name], [motion], representation)
    return [motion] if motion.ndim == 2 else list(motion)


def _check_tensors(names: Sequence[str], motions: Sequence[torch.Tensor], representation: str | None) -> None:
    """Check types and shapes."""
    for name, motion in zip(names, motions, strict=True):
        if not isinstance(motion, torch.Tensor):
            raise TypeError(f"{name}: expected a torch tensor, got {type(motion).__name__}; npss.score takes arrays")
        if motion.dtype not in _DTYPES:
            raise TypeError(
                f"{name}: expected floating-point numbers, got {motion.dtype}; convert it, e.g. {name}.float()"
            )
        motion_shape(name, tuple(motion.shape), representation)


def _check_alike(
    names: tuple[str, str], pair: tuple[torch.Tensor, torch.Tensor], shape: torch.Size, other: torch.Size
) -> None:
    """Check that two tensors have the same shape, or parts of it, and device."""
    if other != shape:
        raise ValueError(
            f"{names[1]}: its shape {tuple(other)} differs from that of {names[0]}, {tuple(shape)}; "
            f"nothing is broadcast"
        )
    if pair[1].device != pair[0].device:
        raise ValueError(f"{names[1]}: on {pair[1].device}, but {names[0]} is on {pair[0].device}")


def check_finite_tensor(name: str, motion: torch.Tensor | list[torch.Tensor]) -> None:
    """Refuse NaN and infinite values of a tensor, or of a list of sequences, on any device and of any dtype."""
    if isinstance(motion, list):
        check_sequences(name, [real_array(name, sequence) for sequence in motion])
    else:
        check_finite(name, real_array(name, motion))


def weighted_sums(
    pairs: Sequence[tuple[torch.Tensor, torch.Tensor]],
    convention: Convention,
    *,
    relative: bool,
    normalize: Normalize = None,
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the sums of ``weight * distance`` and of ``weight``, whose quotient is the score.

    Parameters
    ----------
    pairs : sequence of pairs of (N, T, D) or (T, D) tensors
        Motions of the same dtype and device; those of a pair have the same shape. NaN and infinite values make the
        first sum NaN.
    convention : Convention
    relative : bool
        Make weights relative to the largest peak of the ground truth, which prevents overflow, instead of comparable
        between calls.
    normalize : {'bound'}, optional
        As for `score`.

    Returns
    -------
    numerator, denominator : () tensor
        Both zero, or both NaN if relative, if the ground truth has no power.
    """
    groups = [_distances(gt, pred, convention) for gt, pred in pairs]
    largest = torch.stack([peak.max() for _, _, peak in groups]).max() if relative else 1.0
    sums = []
    for (distance, total, peak), (gt, _) in zip(groups, pairs, strict=True):
        weight = (total != 0).to(total.dtype)
        if convention.weight == "power":
            weight = total * (peak / largest).square()
        if normalize is not None:
            distance = distance / float(largest_distance(convention, gt.shape[-2]))
            weight = weight / unit_of_weight(convention, gt.shape[-2])
        sums.append(((weight * distance).sum(), weight.sum()))
    numerators, denominators = zip(*sums, strict=True)
    return sum(numerators[1:], numerators[0]), sum(denominators[1:], denominators[0])


def _distances(
    gt: torch.Tensor, pred: torch.Tensor, convention: Convention
) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return the distances, total powers in units of squared peaks, and peaks, ``(..., 1, D)`` each.

    The peak is 0 for a feature without power, which must not set the scale.
    """
    truth, total, peak = _spectra(gt, convention)
    prediction, _, _ = _spectra(pred, convention)
    difference = prediction - truth
    if convention.distance == "cdf":
        difference = difference.cumsum(-2)
    return difference.abs().sum(-2, keepdim=True), total, torch.where(total == 0, 0.0, peak)


def _spectra(motion: torch.Tensor, convention: Convention) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return the normalised spectra ``(..., bins, D)``, their totals and the peaks ``(..., 1, D)``.

    Totals are of features divided by their peaks. NaN is not equal to zero, so it passes the comparisons and remains in
    the result.
    """
    n_frames = motion.shape[-2]
    peak = motion.detach().abs().amax(-2, keepdim=True)
    transform = torch.fft.rfft(motion / torch.where(peak == 0, 1.0, peak), dim=-2)
    power = transform.real.square()
    if convention.power == "magnitude":
        power = power + transform.imag.square()
    if convention.bins == "two-sided":
        power = torch.cat([power, power[..., 1 : (n_frames + 1) // 2, :].flip(-2)], -2)
    total = power.sum(-2, keepdim=True)
    powerless = power.new_zeros(power.shape[-2], 1)
    powerless[0] = 1.0 if convention.zero == "dc" else 0.0
    spectrum = torch.where(total == 0, powerless, power) / torch.where(total == 0, 1.0, total)
    return spectrum, total, peak
