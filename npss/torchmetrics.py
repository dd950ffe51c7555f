"""The same score over batches, as a metric of torchmetrics."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from typing import Any, Literal, get_args

import torch
from torchmetrics import Metric

from npss._metric.convention import CHOICES, Convention, ConventionName, as_convention
from npss.torch import check_finite_tensor, check_pair, weighted_sums
from npss.validation import one_of

__all__ = ["NPSS"]

Policy = Literal["raise", "propagate"]
_POLICIES: tuple[Policy, ...] = get_args(Policy)
_LEAST = 1e-290  # a sum of weights below which float64 begins to lose digits


class NPSS(Metric):
    """NPSS of all batches together: the number that `npss.score` gives for the whole set, however it was split.

    **The prediction comes first**, as everywhere in torchmetrics: ``update(preds, target)``. `npss.score` has the
    ground truth first, and the score is not symmetric. By name, ``update(target=gt, preds=pred)``, they cannot be
    mixed up.

    Parameters
    ----------
    convention : {'paper', 'released', 'literal'} or Convention, optional
        As for `npss.score`.
    nan_policy : {'raise', 'propagate'}, optional
        What a batch does that holds NaN or infinite values: it is refused with a ValueError, or makes the score NaN.
        No such value is ever left out.
    **kwargs
        What every metric of torchmetrics takes: ``dist_sync_on_step``, ``sync_on_compute``, ...

    Raises
    ------
    TypeError, ValueError
        If the convention is neither a name nor a `Convention`, or no convention or policy has that name.

    See Also
    --------
    npss.torch.score : the differentiable function, for one batch.

    Notes
    -----
    The states are sums, of ``weight * distance`` and of ``weight`` (the mean of the batches' scores would be wrong).
    They are float64, computed in float64 from inputs of every dtype, bfloat16 and float16 included, and stay so:
    ``half()``, ``to(dtype)`` and ``set_dtype`` move them at most. Devices without float64 (MPS) cannot hold them: leave
    the metric on the CPU.

    A third state says what is summed, the convention, the policy and the number of frames, so that metrics which differ
    in these are never merged, nor taken for the same one by a ``MetricCollection``.

    A batch that ``update`` refuses leaves the states as they were, and so does one that ``forward`` does, which is
    ``metric(preds, target)`` and has to score the batch alone.

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
        self, *, convention: ConventionName | Convention = "paper", nan_policy: Policy = "raise", **kwargs: Any
    ) -> None:
        super().__init__(**kwargs)
        self.convention = as_convention(convention)
        one_of("nan_policy", nan_policy, _POLICIES)
        self.nan_policy = nan_policy
        # First, since older MetricCollections compare no other state before they let two metrics share theirs.
        self.add_state("kind", self._kind(n_frames=0), dist_reduce_fx=_common_kind)
        self.add_state("numerator", torch.zeros((), dtype=torch.float64), dist_reduce_fx="sum")
        self.add_state("denominator", torch.zeros((), dtype=torch.float64), dist_reduce_fx="sum")

    def update(self, preds: torch.Tensor, target: torch.Tensor) -> None:
        """Add a batch.

        Parameters
        ----------
        preds : (N, T, D) or (T, D) tensor
            Predictions: float64, float32, float16 or bfloat16, on the metric's device.
        target : tensor
            Ground truth, of the same shape and device as `preds`, and of any of these dtypes. It may be without power,
            where another batch has some.

        Raises
        ------
        TypeError, ValueError
            As `npss.torch.score`, but for values that are not finite if they are to propagate; and where T differs from
            that of earlier batches, or the ground truth's power is beyond float64 (values of about 1e150), which a sum
            over batches cannot hold.
        """
        check_pair("target", target, "preds", preds)
        kind = _common_kind(torch.stack([self.kind, self._kind(target.shape[-2]).to(self.kind.device)]))
        numerator, denominator = weighted_sums(target.double(), preds.double(), self.convention, relative=False)
        if not bool((numerator + denominator).isfinite()):
            if self.nan_policy == "raise":
                check_finite_tensor("preds", preds)
                check_finite_tensor("target", target)
            if bool(preds.isfinite().all() & target.isfinite().all()):
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
            NaN if values that were not finite propagate.

        Raises
        ------
        ValueError
            If the ground truth had no power, or so little (values below about 1e-145) that float64 does not hold it.
        """
        if not bool((self.denominator > _LEAST) | self.numerator.isnan()):
            raise ValueError("target: no power in any feature of any sequence so far, so there is nothing to score")
        return self.numerator / self.denominator

    def extra_repr(self) -> str:
        """Return what stands between the brackets when the metric is printed."""
        return f"{self.convention!r}, nan_policy={self.nan_policy!r}"

    def forward(self, *args: Any, **kwargs: Any) -> Any:
        """Add a batch and return its own score; an error leaves everything as it was.

        Of itself, torchmetrics has put the states aside by then, and what comes later would be summed without them.
        """
        before = dict(self.__dict__)
        try:
            return super().forward(*args, **kwargs)
        except Exception:
            self.__dict__.update(before)
            raise

    def _kind(self, n_frames: int) -> torch.Tensor:
        """Return the number of frames, and the places of the convention's choices and of the policy, ``(7,)``."""
        choices = [CHOICES[field.name].index(getattr(self.convention, field.name)) for field in fields(Convention)]
        return torch.tensor([n_frames, *choices, _POLICIES.index(self.nan_policy)])

    def _apply(self, fn: Callable[..., Any], *args: Any, **kwargs: Any) -> torch.nn.Module:
        """Let whatever is applied to states, and to what contains them, move them but not change their dtype."""

        def move(tensor: torch.Tensor) -> torch.Tensor:
            moved: torch.Tensor = fn(tensor)
            return moved if moved.dtype == tensor.dtype else tensor.to(moved.device)

        return super()._apply(move, *args, **kwargs)


def _common_kind(kinds: torch.Tensor) -> torch.Tensor:
    """Return the kind that all of ``(M, 6)`` have; 0 frames stand for no batch yet, which fits all."""
    common = kinds.amax(0)
    differ = kinds != common
    differ[:, 0] &= kinds[:, 0] > 0
    if bool(differ.any()):
        frames = sorted({int(n) for n in kinds[:, 0]} - {0})
        raise ValueError(f"batches of different conventions or numbers of frames {frames} do not add up to one score")
    return common
