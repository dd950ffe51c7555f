"""The score over batches, as a metric of torchmetrics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any, Literal, get_args

import torch
from torchmetrics import Metric

from npss._metric.bound import Normalize, check_normalize
from npss._metric.convention import CHOICES, Convention, ConventionName, as_convention
from npss._metric.fields import check_value
from npss._metric.sequences import Lengths
from npss.torch import Motion, check_finite_tensor, read_pairs, weighted_sums
from npss.validation import one_of

__all__ = ["NPSS"]

Policy = Literal["raise", "propagate"]
_POLICIES: tuple[Policy, ...] = get_args(Policy)
_ANY = -1  # in place of a number of frames, if the score is normalised
_LEAST = 1e-290  # float64 loses digits in smaller sums of weights


class NPSS(Metric):
    """The NPSS of all batches: the value of `npss.score` for the whole set, however it is split.

    **The prediction comes first**, as everywhere in torchmetrics: ``update(preds, target)``. `npss.score` takes the
    ground truth first, and the score is not symmetric. Pass names to be safe: ``update(target=gt, preds=pred)``.

    Parameters
    ----------
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `npss.score`.
    normalize : {'bound'}, optional
        As for `npss.score`; required for sequences of unequal length, also of different batches.
    representation : str, optional
        As for `npss.score`: ``'matrix'`` has the shape ``(N, T, J, 3, 3)``.
    nan_policy : {'raise', 'propagate'}, optional
        How to treat a batch with NaN or infinite values: raise a ValueError, or make the score NaN. Such values are
        never skipped.
    **kwargs
        Arguments of every metric of torchmetrics: ``dist_sync_on_step``, ``sync_on_compute``, ...

    Raises
    ------
    TypeError, ValueError
        If a parameter is invalid.

    See Also
    --------
    npss.torch.score : the differentiable function, for one batch.

    Notes
    -----
    The states are the sums of ``weight * distance`` and of ``weight`` (averaging batch scores would be wrong). They are
    float64, computed in float64 from inputs of any dtype, including bfloat16 and float16. ``half()``, ``to(dtype)`` and
    ``set_dtype`` may move them, but keep the dtype. Devices without float64 (MPS) cannot hold them: keep the metric on
    the CPU.

    A third state identifies the sums: the convention, the policy and the number of frames, or -1 if normalised. So
    metrics that differ in these are never merged, and a ``MetricCollection`` never treats them as the same.

    A batch that ``update`` or ``forward`` (``metric(preds, target)``, which also scores the batch alone) refuses leaves
    the states unchanged.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, section 3.5,
    equations 7 to 9.

    Examples
    --------
    >>> import torch
    >>> from npss.torchmetrics import NPSS
    >>> t = torch.arange(100)[:, None] / 25
    >>> slow, fast = (torch.cos(2 * torch.pi * f * t) for f in (0.5, 1.0))
    >>> metric = NPSS(convention="paper")
    >>> metric.update(preds=fast, target=slow)
    >>> metric.update(preds=slow, target=slow)
    >>> round(metric.compute().item(), 3)
    1.0
    """

    higher_is_better = False
    is_differentiable = True
    full_state_update = False
    plot_lower_bound = 0.0

    kind: torch.Tensor  # (7,)
    numerator: torch.Tensor  # ()
    denominator: torch.Tensor  # ()

    def __init__(
        self,
        *,
        convention: ConventionName | Convention = "paper",
        normalize: Normalize = None,
        representation: str | None = None,
        nan_policy: Policy = "raise",
        **kwargs: Any,
    ) -> None:
        super().__init__(**kwargs)
        self.convention = as_convention(convention)
        check_normalize(normalize)
        self.normalize: Normalize = normalize
        if representation is not None:
            check_value("representation", representation)
        self.representation = representation
        one_of("nan_policy", nan_policy, _POLICIES)
        self.nan_policy = nan_policy
        # First, because older MetricCollections compare only the first state before two metrics share states.
        self.add_state("kind", self._kind(0 if normalize is None else _ANY), dist_reduce_fx=_common_kind)
        self.add_state("numerator", torch.zeros((), dtype=torch.float64), dist_reduce_fx="sum")
        self.add_state("denominator", torch.zeros((), dtype=torch.float64), dist_reduce_fx="sum")

    def update(self, preds: Motion, target: Motion, lengths: Lengths = None) -> None:
        """Add a batch.

        Parameters
        ----------
        preds : (N, T, D), (T, D) or (N, T, J, C) tensor, or list of sequences
            Predictions: float64, float32, float16 or bfloat16, on the metric's device.
        target : tensor
            Ground truth, with the shape and device of `preds` and any of these dtypes. It may have no power if another
            batch has some.
        lengths : (N,) array_like or tensor of int, optional
            As for `npss.score`.

        Raises
        ------
        TypeError, ValueError
            As for `npss.torch.score`, except for values that are not finite under the policy 'propagate'. Also if T
            differs from earlier batches, or the power of the ground truth is beyond float64 (values of about 1e150),
            which a sum over batches cannot hold.
        """
        pairs = read_pairs(
            target,
            preds,
            names=("target", "preds"),
            lengths=lengths,
            normalize=self.normalize,
            representation=self.representation,
        )
        n_frames = pairs.groups[0][0].shape[-2] if self.normalize is None else _ANY
        kind = _common_kind(torch.stack([self.kind, self._kind(n_frames).to(self.kind.device)]))
        groups = [(truth.double(), prediction.double()) for truth, prediction in pairs.groups]
        numerator, denominator = weighted_sums(groups, self.convention, relative=False, normalize=self.normalize)
        if not bool((numerator + denominator).isfinite()):
            if self.nan_policy == "raise":
                check_finite_tensor("preds", pairs.pred)
                check_finite_tensor("target", pairs.gt)
            if all(bool(motion.isfinite().all()) for pair in groups for motion in pair):
                raise ValueError("target: its power is beyond float64; divide all targets by one constant")
            numerator, denominator = numerator * torch.nan, torch.zeros_like(denominator)
        self.numerator = self.numerator + numerator
        self.denominator = self.denominator + denominator
        self.kind = kind

    def compute(self) -> torch.Tensor:
        """Return the score of all batches so far.

        Returns
        -------
        () tensor of float64
            NaN if values that are not finite propagate.

        Raises
        ------
        ValueError
            If the ground truth has no power, or too little for float64 (values below about 1e-145).
        """
        if not bool((self.denominator > _LEAST) | self.numerator.isnan()):
            raise ValueError("target: no power in any feature of any sequence so far, so there is nothing to score")
        return self.numerator / self.denominator

    def extra_repr(self) -> str:
        """Return the arguments, for the printed representation."""
        normalised = "" if self.normalize is None else f", normalize={self.normalize!r}"
        return f"{self.convention!r}{normalised}, nan_policy={self.nan_policy!r}"

    def forward(self, *args: Any, **kwargs: Any) -> Any:
        """Add a batch and return its score; an error leaves the metric unchanged.

        Without this, an error would lose the earlier batches, whose states torchmetrics sets aside during `forward`.
        """
        before = dict(self.__dict__)
        try:
            return super().forward(*args, **kwargs)
        except Exception:
            self.__dict__.update(before)
            raise

    def _kind(self, n_frames: int) -> torch.Tensor:
        """Return the number of frames or `_ANY`, and indices of the convention's choices and the policy, ``(7,)``."""
        choices = [CHOICES[field.name].index(getattr(self.convention, field.name)) for field in fields(Convention)]
        return torch.tensor([n_frames, *choices, _POLICIES.index(self.nan_policy)])

    def _apply(self, fn: Callable[..., Any], *args: Any, **kwargs: Any) -> torch.nn.Module:
        """Apply a function to the states that may move them, but keep their dtype."""

        def move(tensor: torch.Tensor) -> torch.Tensor:
            moved: torch.Tensor = fn(tensor)
            return moved if moved.dtype == tensor.dtype else tensor.to(moved.device)

        return super()._apply(move, *args, **kwargs)


def _common_kind(kinds: torch.Tensor) -> torch.Tensor:
    """Return the common kind of ``(M, 7)`` kinds; 0 frames, before the first batch, match any number."""
    common = kinds.amax(0)
    differ = kinds != common
    differ[:, 0] &= kinds[:, 0] != 0
    if bool(differ.any()):
        frames = ["any" if n == _ANY else n for n in sorted({int(n) for n in kinds[:, 0]} - {0})]
        if not differ[:, 1:].any() and "any" not in frames:
            raise ValueError(
                f"batches: scores of {' and '.join(map(str, frames))} frames are not comparable, and cannot be merged; "
                f"pass normalize='bound', or keep one metric for each length"
            )
        raise ValueError(f"batches: different conventions, policies or numbers of frames {frames} cannot be merged")
    return common
