"""The same score as a torch function: differentiable, on the device where the tensors are.

It is written from the definition, over all the bins that the convention counts, so that autograd sees nothing but sums,
quotients and absolute values. Three details keep its gradients finite and its range whole:

- Power is ``re**2 + im**2``, never the square of a magnitude, whose gradient at zero is not defined.
- Where a denominator is zero it is replaced before the division, not after it: a gradient of ``0/0`` would be nan even
  where its value is not used.
- Each feature of each sequence is divided by its own peak, which is taken as a constant. No square overflows then, and
  the gradient is still whole, because the score of a scaled feature is the same function whatever the scale.
"""

from __future__ import annotations

import numpy as np
import torch

from npss._metric.convention import Convention, ConventionName, as_convention
from npss.validation import check_finite, motion_array

__all__ = ["score"]

_DTYPES = (torch.float64, torch.float32, torch.float16, torch.bfloat16)


def score(gt: torch.Tensor, pred: torch.Tensor, *, convention: ConventionName | Convention = "paper") -> torch.Tensor:
    """NPSS as a differentiable torch function: the number that `npss.score` gives, as a scalar tensor.

    Parameters
    ----------
    gt : (N, T, D) or (T, D) tensor
        Ground truth: N sequences of T >= 2 frames of D features (angles in radians, usually). float64, float32,
        float16 or bfloat16, on any device.
    pred : tensor
        Prediction, of the same shape and device as `gt`, and of any of these dtypes.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `npss.score`.

    Returns
    -------
    () tensor
        The score, on the device of the input, computed in float64 if one of the two is, and in float32 otherwise, half
        precision included: float32 agrees with `npss.score` to about 1e-4 of the value, float64 to 1e-10.

    Raises
    ------
    TypeError
        If an argument is not a tensor of one of these dtypes, or the convention is neither a name nor a `Convention`.
    ValueError
        If the shapes are wrong or differ, or the devices differ, a value is NaN or infinite (named with its index),
        there are fewer than two frames, the ground truth has no power at all, or no convention has that name.

    See Also
    --------
    npss.score : the same for arrays, exactly summed: the one to report.
    npss.torchmetrics.NPSS : the same over batches.

    Notes
    -----
    As a loss it needs another one beside it: it sees neither the scale nor the sign of a predicted feature, nor a shift
    in time (but for ``power='real'``). Constant features of the prediction, zeros among them, have a gradient of zero
    up to rounding: a descent that starts from a standing pose goes nowhere.

    Whether the score exists (finite input, ground truth with power) is asked of the device once a call, which waits for
    it; only then, if it does not, are the tensors copied to say where.

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
    chosen = as_convention(convention)
    check_pair("gt", gt, "pred", pred)
    dtype = torch.promote_types(torch.promote_types(gt.dtype, pred.dtype), torch.float32)
    numerator, denominator = weighted_sums(gt.to(dtype), pred.to(dtype), chosen, relative=True)
    value = numerator / denominator
    if bool(value.isnan()):  # the one wait: NaN or infinite input ends here, and so does 0/0
        check_finite_tensor("gt", gt)
        check_finite_tensor("pred", pred)
        raise ValueError("gt: no power in any feature of any sequence, so there is nothing to score")
    return value


def check_pair(first_name: str, first: torch.Tensor, second_name: str, second: torch.Tensor) -> None:
    """Refuse what is no pair of motions, without a look at the values.

    The first is the one that the second is compared with.

    Raises
    ------
    TypeError, ValueError
        As `score`, but for those about values.
    """
    for name, motion in ((first_name, first), (second_name, second)):
        if not isinstance(motion, torch.Tensor):
            raise TypeError(f"{name}: expected a torch tensor, got {type(motion).__name__}; npss.score takes arrays")
        if motion.dtype not in _DTYPES:
            raise TypeError(
                f"{name}: expected floating-point numbers, got {motion.dtype}; convert it, e.g. {name}.float()"
            )
        motion_array(name, np.broadcast_to(0.0, motion.shape))  # the shape alone, by the rule of npss.score
    if second.shape != first.shape:
        raise ValueError(
            f"{second_name}: its shape {tuple(second.shape)} differs from that of {first_name}, "
            f"{tuple(first.shape)}; nothing is broadcast"
        )
    if second.device != first.device:
        raise ValueError(f"{second_name}: on {second.device}, whereas {first_name} is on {first.device}")
    if first.shape[-2] < 2:
        raise ValueError(f"{first_name}: one frame; a power spectrum needs at least two")


def check_finite_tensor(name: str, motion: torch.Tensor) -> None:
    """`check_finite` of a tensor on any device, and of any dtype: numpy has no bfloat16."""
    check_finite(
        name, motion.double().numpy(force=True) if motion.dtype == torch.bfloat16 else motion.numpy(force=True)
    )


def weighted_sums(
    gt: torch.Tensor, pred: torch.Tensor, convention: Convention, *, relative: bool
) -> tuple[torch.Tensor, torch.Tensor]:
    """Return the sums of ``weight * distance`` and of ``weight``, whose quotient is the score.

    Parameters
    ----------
    gt, pred : (N, T, D) or (T, D) tensor
        Of the same shape, dtype and device. NaN and infinite values make the first sum NaN.
    convention : Convention
    relative : bool
        Whether weights are relative to the largest peak of the ground truth, which no value can overflow, rather than
        comparable between calls.

    Returns
    -------
    numerator, denominator : () tensor
        Both zero, or both NaN if relative, where the ground truth has no power.
    """
    truth, total, peak = _spectra(gt, convention)
    prediction, _, _ = _spectra(pred, convention)
    difference = prediction - truth
    if convention.distance == "cdf":
        difference = difference.cumsum(-2)
    distance = difference.abs().sum(-2, keepdim=True)  # (..., 1, D)
    if convention.weight == "uniform":
        weight = (total != 0).to(total.dtype)
    else:
        peak = torch.where(total == 0, 0.0, peak)  # so that a feature without power sets no scale
        weight = total * (peak / peak.max() if relative else peak).square()
    return (weight * distance).sum(), weight.sum()


def _spectra(motion: torch.Tensor, convention: Convention) -> tuple[torch.Tensor, torch.Tensor, torch.Tensor]:
    """Return the normalised spectra ``(..., bins, D)``, their totals and the peaks ``(..., 1, D)``.

    The totals are those of features divided by their peaks. Comparisons are with exactly zero, for which NaN does not
    pass: it stays, to be found in the result.
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
