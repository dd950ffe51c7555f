"""The pitfall of parts: a score that says more about how much each feature moves than about how."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from npss._analysis.pitfalls.pitfall import NOTE, Block, Found, Pitfall
from npss._metric.convention import convention_name
from npss._metric.kernel import tile


class Share(Pitfall):
    """A score that is mostly the share of DC."""

    name = "share"
    _MOST = 0.5  # of the score
    _LEAST = 1e-9  # a score; less may be rounding noise

    def __init__(self) -> None:
        self._sums = np.zeros(3)  # of the weights, and of weighted distances and forms
        self._convention: str | None = None

    def see(self, block: Block) -> None:
        """Add up the weights, distances and forms."""
        if block.gt.shape[1] < 2:
            return
        self._convention = convention_name(block.convention)
        part = tile(block.gt, block.pred, block.convention, (slice(None), slice(None)), parts=True)
        assert part.parts is not None
        weight = part.weight if part.exponent is None else np.ldexp(part.weight, part.exponent)
        columns = np.ones_like(weight), part.distance, part.parts.form
        self._sums += [(weight * column).sum() for column in columns]

    def found(self) -> Iterator[Found]:
        """Yield the share in the score, if it is most of it."""
        total, distance, form = self._sums
        score = distance / total if total > 0 and np.isfinite(self._sums).all() else 0.0
        if score > self._LEAST and (share := 1 - form / distance) > self._MOST:
            name = repr(self._convention) if self._convention else "this convention"
            yield Found(
                "pred",
                1,
                (),
                f"{share:.0%} of the score by {name}, {score:.4g}, is the share of DC (npss.Parts): how much each "
                f"feature moves, not how; give the scores of shorter windows, the Euler error and the speed, too",
                NOTE,
            )
