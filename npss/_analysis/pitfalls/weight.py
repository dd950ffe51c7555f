"""Pitfalls of weight: features that count for nothing, or for everything."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from npss._analysis.pitfalls.pitfall import NOTE, WARNING, Block, Found, Mask, Pitfall, Tally
from npss.validation import Float64


class Powerless(Pitfall):
    """Features without power in the ground truth, which count for nothing."""

    name = "powerless"

    def __init__(self) -> None:
        self._power: Mask | None = None
        self._predicted: Mask | None = None

    def see(self, block: Block) -> None:
        """Look for features that are not zero."""
        power, predicted = (np.asarray(motion.any(axis=(0, 1))) for _, motion in block.named())
        self._power = power if self._power is None else self._power | power
        self._predicted = predicted if self._predicted is None else self._predicted | predicted

    def found(self) -> Iterator[Found]:
        """Yield the features without power: a note, unless the prediction is not zero there."""
        assert self._power is not None
        assert self._predicted is not None
        if not self._power.all():
            where = np.flatnonzero(~self._power)
            moved = int((self._predicted & ~self._power).sum())
            message = f"features (of {len(self._power)}) are zero throughout, so they do not count"
            message += f", though the prediction is not zero in {moved} of them" if moved else ""
            yield Found("gt", len(where), tuple(int(i) for i in where), message, WARNING if moved else NOTE)


class Weight(Pitfall):
    """A few features with most of the weight, such as translations beside angles."""

    name = "weight"
    _MOST = 0.9  # of the weight
    _FEW = 0.1  # of the features; on Human3.6M, at least a fifth of the moving ones hold that weight

    def __init__(self) -> None:
        self._weight: Float64 | float = 0.0

    def see(self, block: Block) -> None:
        """Add up the power of each feature."""
        self._weight = self._weight + np.square(block.gt).sum(axis=(0, 1))

    def found(self) -> Iterator[Found]:
        """Yield the features with most of the power."""
        weight = np.asarray(self._weight)
        total, n_features = weight.sum(), np.count_nonzero(weight)
        order = np.argsort(-weight, kind="stable")
        few = int(np.searchsorted(weight[order].cumsum(), self._MOST * total)) + 1
        if 0 < total < np.inf and few <= self._FEW * n_features:
            yield Found(
                "gt",
                few,
                tuple(sorted(int(i) for i in order[:few])),
                f"features (of {n_features}) hold {weight[order[:few]].sum() / total:.0%} of the weight, and so of the "
                f"score: are they in other units?",
            )


class NoRealPower(Pitfall):
    """Predictions whose score by the released code is rounding noise."""

    name = "no-real-power"

    def __init__(self) -> None:
        self._odd = Tally()

    def see(self, block: Block) -> None:
        """Count features that are circularly odd, such as whole periods of a sine, to the precision of float32.

        Predictions are often computed in float32.
        """
        even = block.pred + block.pred[:, -np.arange(block.pred.shape[1])]
        size = np.abs(block.pred).max(axis=1)
        self._odd.add(block.top, (np.abs(even).max(axis=1) < 1e-5 * size) & block.gt.any(axis=1))

    def found(self) -> Iterator[Found]:
        """Yield their number."""
        if self._odd.count:
            yield Found(
                "pred",
                self._odd.count,
                self._odd.first,
                "features have spectra without a real part: by 'released' they score rounding errors",
            )
