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

import torch

from npss._metric.convention import Convention, ConventionName, as_convention
from npss.validation import check_finite, motion_shape

__all__ = ["score"]

_DTYPES = (torch.float64, torch.float32, torch.float16, torch.bfloat16)


def score(
    gt: torch.Tensor,
    pred: torch.Tensor,
    *,
    convention: ConventionName | Convention = "paper",
    representation: str | None = None,
) -> torch.Tensor:
    """Return the NPSS as a differentiable scalar tensor, equal to `npss.score`.

    Parameters
    ----------
    gt : (N, T, D), (T, D) or (N, T, J, C) tensor
        Ground truth: N sequences of T >= 2 frames of D features (angles in radians, usually), or of J joints, which are
        flattened. float64, float32, float16 or bfloat16, on any device.
    pred : tensor
        Prediction, with the shape and device of `gt` and any of these dtypes.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `npss.score`.
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
    truth, prediction = flat_pair("gt", gt, "pred", pred, representation)
    dtype = torch.promote_types(torch.promote_types(gt.dtype, pred.dtype), torch.float32)
    numerator, denominator = weighted_sums(truth.to(dtype), prediction.to(dtype), choices, relative=True)
    value = numerator / denominator
    if bool(value.isnan()):  # the only wait: NaN or infinite input, or 0/0
        check_finite_tensor("gt", gt)
        check_finite_tensor("pred", pred)
        raise ValueError("gt: no power in any feature of any sequence, so there is nothing to score")
    return value


def flat_pair(
    first_name: str, first: torch.Tensor, second_name: str, second: torch.Tensor, representation: str | None = None
) -> tuple[torch.Tensor, torch.Tensor]:
    """Check that two tensors are a pair of motions, without reading values, and flatten their joints.

    Errors compare the second with the first.

    Raises
    ------
    TypeError, ValueError
        As for `score`, except for values.
    """
    for name, motion in ((first_name, first), (second_name, second)):
        if not isinstance(motion, torch.Tensor):
            raise TypeError(f"{name}: expected a torch tensor, got {type(motion).__name__}; npss.score takes arrays")
        if motion.dtype not in _DTYPES:
            raise TypeError(
                f"{name}: expected floating-point numbers, got {motion.dtype}; convert it, e.g. {name}.float()"
            )
        shape = motion_shape(name, tuple(motion.shape), representation)
    if second.shape != first.shape:
        raise ValueError(
            f"{second_name}: its shape {tuple(second.shape)} differs from that of {first_name}, "
            f"{tuple(first.shape)}; nothing is broadcast"
        )
    if second.device != first.device:
        raise ValueError(f"{second_name}: on {second.device}, but {first_name} is on {first.device}")
    if shape[-2] < 2:
        raise ValueError(f"{first_name}: one frame; a power spectrum needs at least two")
    return first.reshape(shape), second.reshape(shape)


def check_finite_tensor(name: str, motion: torch.Tensor) -> None:
    """Call `check_finite` on a tensor of any device and dtype, including bfloat16, which numpy lacks."""
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
        Motions of the same shape, dtype and device. NaN and infinite values make the first sum NaN.
    convention : Convention
    relative : bool
        Make weights relative to the largest peak of the ground truth, which prevents overflow, instead of comparable
        between calls.

    Returns
    -------
    numerator, denominator : () tensor
        Both zero, or both NaN if relative, if the ground truth has no power.
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
        peak = torch.where(total == 0, 0.0, peak)  # a feature without power must not set the scale
        weight = total * (peak / peak.max() if relative else peak).square()
    return (weight * distance).sum(), weight.sum()


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
