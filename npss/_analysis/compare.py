"""Is one prediction better than another: a paired test over blocks of the sequences of one ground truth."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss._analysis.blocks import INFERRED, Blocks, Label, counted, read_groups
from npss._analysis.bootstrap import checked_level
from npss._analysis.interval import Interval
from npss._analysis.sign_flip import MIN_BLOCKS_OF_TEST, SAMPLES, SignFlips, settled, sign_flips
from npss._metric.convention import Convention, ConventionName, as_convention
from npss._metric.fields import Value
from npss._metric.frames import whole_frames
from npss._metric.registry import EULER_ERROR, NPSS, metric_called
from npss._metric.signature import signature, stated_with, with_fields_of
from npss.validation import Float64, Seed, motion_array, positive_number, real_array


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Comparison:
    """Two predictions of one ground truth, compared. `npss.compare` makes it.

    Attributes
    ----------
    a, b : float
        The two scores.
    a_in_blocks, b_in_blocks : float
        Those of the sequences that are in blocks: the same, if none is left out.
    signature : str
        What they mean.
    n : int
        Blocks that count: those with power.
    better : int
        Blocks in which the first is better: lower, unless the metric says otherwise.
    p_value : float or None
        Two-sided: how often names of models dealt at random in every block make a difference at least as large. None
        of fewer than six blocks, which cannot show a difference.
    exact : bool
        Whether all ways to deal the names were counted, or 9999 drawn ones and the one that was seen.
    """

    a: float
    b: float
    a_in_blocks: float
    b_in_blocks: float
    signature: str
    n: int
    better: int
    p_value: float | None
    exact: bool
    _blocks: str
    _flips: SignFlips

    @property
    def difference(self) -> float:
        """Score of the first minus that of the second, in blocks: negative where the first is lower."""
        return self.a_in_blocks - self.b_in_blocks

    def interval(self, *, level: float = 0.95) -> Interval:
        """Return the differences that the test does not reject: a confidence interval of the difference.

        It excludes 0 if and only if ``p_value`` is at most ``1 - level``.

        Parameters
        ----------
        level : float, optional
            Share of such intervals that should hold the true difference.

        Returns
        -------
        Interval
            Its ends are infinite where there are too few blocks to tell: at any level, fewer than six.

        Raises
        ------
        TypeError, ValueError
            If the level is not between 0 and 1.
        """
        checked_level(level)
        return Interval(-math.inf, math.inf) if self.p_value is None else self._flips.interval(level)

    def __repr__(self) -> str:
        return f"Comparison(a={self.a!r}, b={self.b!r}, p_value={self.p_value!r}, signature={self.signature!r})"

    def __str__(self) -> str:
        """Say everything in a few lines."""
        inside = (self.a_in_blocks, self.b_in_blocks)
        left_out = "" if inside == (self.a, self.b) else f"{self.a:.4f} and {self.b:.4f}; in blocks "
        first = f"{left_out}{inside[0]:.4f} - {inside[1]:.4f} = {self.difference:.4f}"
        better = f"the first is better in {self.better} of {counted(self.n, 'block')}"
        if self.p_value is None:
            lines = [f"{first}, {better}", f"  fewer than {MIN_BLOCKS_OF_TEST} blocks give no p-value"]
        else:
            low, high = self.interval()
            ways = f"all {2**self.n}" if self.exact else f"{SAMPLES} random"
            lines = [
                f"{first}, {low:.4f} to {high:.4f} (95 %), p = {self.p_value:.3g}, {better}",
                f"  two-sided sign-flip test over {self.n} blocks, {ways} exchanges, and the differences that it does "
                f"not reject",
            ]
        return "\n".join([*lines, f"  {self._blocks}", f"  {INFERRED}", f"  {self.signature}"])


def compare(
    gt: npt.ArrayLike,
    pred_a: npt.ArrayLike,
    pred_b: npt.ArrayLike,
    *,
    metric: str = NPSS.name,
    convention: ConventionName | Convention = "paper",
    fps: float | None = None,
    at_ms: float | None = None,
    groups: Iterable[Label | None] | None = None,
    seed: Seed = 0,
    extra: Mapping[str, Value] | None = None,
    **context: Value,
) -> Comparison:
    """Test whether one prediction is better than another, by exchanging the two in some of the blocks.

    If the models were as good as each other, it would not matter which of a block's two predictions is called
    the first's. So all ways to exchange them are tried (up to 16 blocks; for 8, that is 256, in pairs of
    opposite ones), or 9999 drawn ones, and the share that makes a difference at least as large is the p-value.

    Parameters
    ----------
    gt : (N, T, D) array_like
        Ground truth of N >= 2 sequences; for a metric of positions, (N, T, J, 3).
    pred_a, pred_b : (N, T, D) array_like
        Two predictions of it.
    metric : str, optional
        What to compare by: ``'npss'``, ``'euler_error'``, ``'mse'``, or a metric that is registered (`npss.metrics`),
        of motion of the kind that it takes.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        Of NPSS.
    fps : float, optional
        Frames per second; needed for the Euler error, else only stated in the signature, or given to the metric.
    at_ms : float, optional
        The time of the Euler error, or of another metric that has times, in milliseconds.
    groups : sequence of str, int or None, optional
        A label for each sequence, as for `report`: those of equal label depend on each other and are exchanged
        together; those of None count for the two scores alone. By default each sequence is assumed to be independent
        of the others.
    seed : int or numpy.random.Generator, optional
        Of the generator that draws exchanges, where not all are tried.
    extra : mapping of str to str, int, float or bool; optional
        Fields of one's own that the signature states.
    **context
        Known fields that the signature states, as for `signature`.

    Returns
    -------
    Comparison
        With ``.difference``, ``.interval(level=.95)`` and ``.p_value``.

    Raises
    ------
    TypeError, ValueError
        As `score` or `euler_error`, with the names ``pred_a`` and ``pred_b``; where there is only one sequence, `fps`
        and `at_ms` do not fit the metric, there are not as many labels as sequences, no sequence with power is in a
        block, or a weight leaves the range of float64. If no metric has that name, or it has no number of each
        sequence, or other weights for each prediction.

    Notes
    -----
    The test holds the ground truth, and with it the weights of blocks, as given. Its null hypothesis is that a
    block's two predictions may as well be exchanged; then a p-value of at most p has probability of at most p,
    however few the blocks, if they are independent. That is more than equal scores: where the differences are skewed,
    or go with the weight of the block, models of equal score are told apart too often, and the interval misses too
    often. A p-value cannot be smaller than 2 / 2**B, which is .031 for the six blocks of the field's eight windows of
    walking; comparing many models asks for less (`leaderboard` corrects for it).

    References
    ----------
    J. A. Hartigan, "Using Subsample Values as Typical Values", Journal of the American Statistical Association 64,
    1969 (the interval).

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> rng = np.random.default_rng(0)
    >>> gt = rng.normal(size=(8, 50, 3)).cumsum(axis=1)
    >>> close = gt + 0.3 * rng.normal(size=gt.shape)
    >>> comparison = npss.compare(gt, close, np.zeros_like(gt))
    >>> comparison.difference < 0, comparison.p_value
    (True, 0.0078125)
    """
    compared = metric_called(metric)
    if compared.aggregation == "none":
        raise ValueError(f"metric: {metric!r} has no number of each sequence, which a comparison is made of")
    positions = compared.takes == "positions"
    truth = real_array("gt", gt) if positions else motion_array("gt", gt)
    shape = "(N, T, J, 3)" if positions else "(N, T, D)"
    if truth.ndim != shape.count(",") + 1 or len(truth) < 2:
        raise ValueError(f"gt: expected shape {shape} with N >= 2 sequences to pair, got {truth.shape}")
    known: dict[str, Value] = {"frames": truth.shape[1]}
    rate = None if fps is None else positive_number("fps", fps)
    if rate is not None:
        known["fps"] = rate
    if at_ms is not None and not compared.has_times:
        raise ValueError(
            f"at_ms: {compared.heading} is of all frames; leave it out, or compare by metric={EULER_ERROR.name!r}"
        )
    chosen = as_convention(convention)
    if compared.has_times:
        if rate is None or at_ms is None:
            raise ValueError(f"at_ms: the {compared.heading} is one of a time: give fps and at_ms")
        whole_frames("at_ms", at_ms, rate, first=1, last=truth.shape[1])
        known["at_ms"] = at_ms
    stated = with_fields_of(compared, stated_with(compare, context, extra, **known))
    meaning = signature(chosen if compared.has_conventions else None, metric=compared.name, **stated)

    def measured(name: str, pred: npt.ArrayLike) -> tuple[float, Float64, Float64]:
        found = compared.measure(truth, pred, pred_name=name, convention=chosen, fps=rate, at_ms=at_ms)
        return found.value, np.asarray(found.numerator), np.asarray(found.weight)

    labels = read_groups("groups", groups, len(truth))
    a, first, weight = measured("pred_a", pred_a)
    b, second, other_weight = measured("pred_b", pred_b)
    if not np.array_equal(weight, other_weight):
        raise ValueError(f"metric: the weights of {metric!r} differ, so they do not depend on gt alone, as they should")
    blocks = Blocks(labels, weight)
    base = blocks.sums(weight)
    counts = base > 0
    difference = blocks.sums(first - second)[counts]
    flips = sign_flips(difference, base[counts], seed=seed)
    inside = [float(blocks.inside(sums) / base.sum()) for sums in (first, second)] if blocks.left_out else [a, b]
    return Comparison(
        a=a,
        b=b,
        a_in_blocks=inside[0],
        b_in_blocks=inside[1],
        signature=meaning,
        n=blocks.n,
        better=int((compared.sign * settled(difference, base[counts]) < 0).sum()),
        p_value=flips.p_value() if blocks.n >= MIN_BLOCKS_OF_TEST else None,
        exact=flips.exact,
        _blocks=str(blocks),
        _flips=flips,
    )
