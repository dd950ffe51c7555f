"""Compare two predictions: a paired test over blocks of sequences."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import numpy.typing as npt

from npss._analysis.blocks import INFERRED, Blocks, Label, counted, read_groups
from npss._analysis.bootstrap import checked_level
from npss._analysis.interval import Interval
from npss._analysis.sign_flip import MIN_BLOCKS_OF_TEST, SAMPLES, SignFlips, settled, sign_flips
from npss._metric.bound import Normalize, check_normalize, stated_lengths
from npss._metric.contributions import contributions, normalised_contributions
from npss._metric.convention import Convention, ConventionName, as_convention
from npss._metric.fields import Value
from npss._metric.frames import whole_frames
from npss._metric.metric import Measured
from npss._metric.parts import Parts
from npss._metric.registry import EULER_ERROR, L2P, NPSS, metric_called
from npss._metric.sequences import Lengths, differ_in_length, read_motions
from npss._metric.signature import parse_signature, signature, stated_with, with_fields_of
from npss.protocol._claims import check_claims
from npss.validation import Seed, flattened, motion_with_joints, positive_number, real_array


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Comparison:
    """The comparison of two predictions of one ground truth, from `npss.compare`.

    Attributes
    ----------
    a, b : float
        The two scores.
    a_in_blocks, b_in_blocks : float
        The scores of the sequences in blocks: the same, unless some sequences are in no block.
    signature : str
        The signature of the scores.
    n : int
        The number of blocks with power.
    better : int
        The number of blocks in which the first is better: lower, unless higher is better by the metric.
    p_value : float or None
        Two-sided: the share of exchanges of the models' names, block by block, that make a difference at least as
        large. None for fewer than six blocks, which cannot show a difference.
    a_parts, b_parts : Parts or None
        What the two scores are made of; None for another metric than NPSS.
    exact : bool
        Whether all exchanges are counted, or 9999 random ones and the observed one.
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
    a_parts: Parts | None
    b_parts: Parts | None
    _blocks: str
    _flips: SignFlips

    @property
    def difference(self) -> float:
        """The first score minus the second, over the sequences in blocks: negative if the first is lower."""
        return self.a_in_blocks - self.b_in_blocks

    @property
    def _verdict(self) -> str:
        """What the p-value says at 5 %, as text."""
        if self.p_value is None or self.p_value > 0.05:
            return "undecided: noise alone makes such a difference in more than 5 % of cases"
        higher = parse_signature(self.signature).get("better") == "higher"
        verdict = "better" if (self.difference > 0) == higher else "worse"
        return f"the first is {verdict}: the difference is more than noise"

    def interval(self, *, level: float = 0.95) -> Interval:
        """Return the confidence interval of the difference: the differences that the test does not reject.

        It excludes 0 if and only if ``p_value`` is at most ``1 - level``.

        Parameters
        ----------
        level : float, optional
            The confidence level.

        Returns
        -------
        Interval
            The interval. Its ends are infinite if there are too few blocks: at any level, fewer than six.

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
        """Summarise the comparison in a few lines."""
        inside = (self.a_in_blocks, self.b_in_blocks)
        left_out = "" if inside == (self.a, self.b) else f"{self.a:.4f} and {self.b:.4f}; in blocks "
        first = f"{left_out}{inside[0]:.4f} - {inside[1]:.4f} = {self.difference:z.4f}"
        better = f"the first is better in {self.better} of {counted(self.n, 'block')}"
        if self.p_value is None:
            lines = [f"{first}, {better}", f"  fewer than {MIN_BLOCKS_OF_TEST} blocks give no p-value"]
        else:
            low, high = self.interval()
            ways = f"all {2**self.n}" if self.exact else f"{SAMPLES} random"
            lines = [
                f"{first}, {low:.4f} to {high:.4f} (95 %), p = {self.p_value:.3g}, {better}",
                f"  {self._verdict}",
                f"  two-sided sign-flip test over {self.n} blocks, {ways} exchanges; interval: the differences "
                f"not rejected",
            ]
        both = {"first": self.a_parts, "second": self.b_parts}
        parts = [f"  the {name}: {parts}" for name, parts in both.items() if parts]
        return "\n".join([*lines, *parts, f"  {self._blocks}", f"  {INFERRED}", f"  {self.signature}"])


def compare(
    gt: npt.ArrayLike,
    pred_a: npt.ArrayLike,
    pred_b: npt.ArrayLike,
    *,
    metric: str = NPSS.name,
    convention: ConventionName | Convention = "paper",
    lengths: Lengths = None,
    normalize: Normalize = None,
    fps: float | None = None,
    at_ms: float | None = None,
    groups: Iterable[Label | None] | None = None,
    seed: Seed = 0,
    extra: Mapping[str, Value] | None = None,
    **context: Value,
) -> Comparison:
    """Test whether one prediction is better than another, by exchanging the two in some blocks.

    If the models are equally good, their predictions can be exchanged in any block. The p-value is the share of
    exchanges that make a difference at least as large. Up to 16 blocks all exchanges are tried (for 8 blocks, 256, in
    pairs of opposite ones), beyond that 9999 random ones.

    Parameters
    ----------
    gt : (N, T, D) or (N, T, J, C) array_like
        Ground truth of N >= 2 sequences, as for `score`; for a metric of positions, (N, T, J, 3).
    pred_a, pred_b : array_like
        Two predictions, of the same shape as `gt`.
    metric : str, optional
        The metric to compare by: ``'npss'``, ``'euler_error'``, ``'mse'``, or a registered metric (`npss.metrics`) that
        takes motion of this kind.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        The convention of NPSS.
    lengths : (N,) array_like of int, optional
        The number of frames of each sequence that count, as for `score`; for NPSS only.
    normalize : {'bound'}, optional
        As for `score`; for NPSS only. Required for sequences of unequal length, which one test compares.
    fps : float, optional
        Frames per second; needed for the Euler error, otherwise stated in the signature and passed to the metric.
    at_ms : float, optional
        The time of the Euler error, or of another metric with times, in milliseconds.
    groups : sequence of str, int or None, optional
        A label for each sequence, as for `report`. Sequences with the same label depend on each other and are
        exchanged together; sequences with None count only for the two scores. By default sequences are assumed to be
        independent.
    seed : int or numpy.random.Generator, optional
        The seed of the generator that draws exchanges, if not all are tried.
    extra : mapping of str to str, int, float or bool; optional
        Fields of your own for the signature.
    **context
        Known fields for the signature, checked as by `report`. With ``representation='matrix'``, motion has the shape
        ``(N, T, J, 3, 3)``.

    Returns
    -------
    Comparison
        With ``.difference``, ``.interval(level=.95)`` and ``.p_value``.

    Raises
    ------
    TypeError, ValueError
        As `score` or `euler_error`, with the names ``pred_a`` and ``pred_b``. If there is only one sequence, `fps` or
        `at_ms` does not fit the metric, the number of labels is not the number of sequences, no sequence with power is
        in a block, or a weight leaves the range of float64. If the metric is unknown, has no values for single
        sequences, or has weights that depend on the prediction.

    Notes
    -----
    The test takes the ground truth, and so the weights of blocks, as fixed. Its null hypothesis is that the two
    predictions of a block are exchangeable. Then the probability of a p-value of at most p is at most p, for any number
    of blocks, if they are independent. This hypothesis is stronger than equal scores: if differences are skewed, or
    related to the weight of the block, models of equal score are told apart too often, and the interval misses too
    often. A p-value is at least 2 / 2**B, which is .031 for the six blocks of the field's eight windows of walking;
    comparing many models requires smaller ones (`leaderboard` corrects for it).

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
        raise ValueError(f"metric: {metric!r} has no values for single sequences, which a comparison needs")
    representation, chosen = context.get("representation"), as_convention(convention)
    check_normalize(normalize)
    if compared.takes == "poses" and representation not in (None, "expmap"):
        raise ValueError(f"representation: {metric!r} takes poses, exponential maps, not {representation!r}")
    rate = None if fps is None else positive_number("fps", fps)
    measure: Callable[..., Measured]
    how: dict[str, Any] = {"representation": representation, "convention": chosen}
    if lengths is not None or normalize is not None or any(map(differ_in_length, (gt, pred_a, pred_b))):
        if compared is not NPSS:
            raise ValueError(
                f"metric: {metric!r} compares sequences of one length, not normalised; NPSS compares others"
            )
        how |= {"lengths": lengths, "normalize": normalize}
        both = {"pred_a": pred_a, "pred_b": pred_b}
        motions, others = (
            read_motions(gt, pred, pred_name=name, lengths=lengths, representation=representation)
            for name, pred in both.items()
        )
        n, frames = motions.n_sequences, [group.n_frames for group in motions.groups]
        arrays = [(one.gt, one.pred, other.pred) for one, other in zip(motions.groups, others.groups, strict=True)]
        measure = partial(_measure_lengths, gt, **how)
    else:
        positions = compared.takes == "positions"
        truth = real_array("gt", gt) if positions else motion_with_joints("gt", gt, representation)
        shape = "(N, T, J, 3)" if positions else "(N, T, D)"
        if (truth.ndim != 4 if positions else truth.ndim < 3) or len(truth) < 2:
            raise ValueError(f"gt: expected shape {shape} with N >= 2 sequences to pair, got {truth.shape}")
        n, frames, arrays = len(truth), [truth.shape[1]], []
        measure = partial(compared.measure, truth, **how, fps=rate, at_ms=at_ms)
    if n < 2:
        raise ValueError("gt: expected N >= 2 sequences to pair, got one")
    fields: dict[str, Value] = stated_lengths(frames, normalize)
    if rate is not None:
        fields["fps"] = rate
    if at_ms is not None and not compared.has_times:
        raise ValueError(
            f"at_ms: {compared.heading} covers all frames; leave it out, or compare by metric={EULER_ERROR.name!r}"
        )
    if compared.has_times:
        if rate is None or at_ms is None:
            raise ValueError(f"at_ms: the {compared.heading} is measured at one time: give fps and at_ms")
        whole_frames("at_ms", at_ms, rate, first=1, last=frames[-1])
        fields["at_ms"] = at_ms
    all_fields = with_fields_of(compared, stated_with(compare, context, extra, **fields))

    def meaning(verified: Mapping[str, Any]) -> str:
        named = chosen if compared.has_conventions else None
        return signature(named, metric=compared.name, **{**all_fields, **verified})

    meaning({})  # checks the fields before the numbers are computed
    labels = read_groups("groups", groups, n)
    of_a, of_b = measure(pred_a, pred_name="pred_a"), measure(pred_b, pred_name="pred_b")
    if not arrays:
        one, a_of_one, b_of_one = (flattened(real_array("gt", motion)) for motion in (truth, pred_a, pred_b))
        arrays = [(one, a_of_one, b_of_one)]
    of_positions = compared.takes == "positions" or compared is L2P
    claims = all_fields | ({"representation": "global-positions"} if of_positions else {})
    verifications = [check_claims(claims, one, pred_a=a, pred_b=b) for one, a, b in arrays]
    verified = {name: value for found in verifications if found for name, value in found.stated.items()}
    (first, weight), (second, other_weight) = (
        (np.asarray(of_one.numerator), np.asarray(of_one.weight)) for of_one in (of_a, of_b)
    )
    a, b = of_a.value, of_b.value
    if not np.array_equal(weight, other_weight):
        raise ValueError(f"metric: the weights of {metric!r} must depend on gt alone, but differ between predictions")
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
        signature=meaning(verified),
        n=blocks.n,
        better=int((compared.sign * settled(difference, base[counts]) < 0).sum()),
        p_value=flips.p_value() if blocks.n >= MIN_BLOCKS_OF_TEST else None,
        exact=flips.exact,
        a_parts=of_a.parts,
        b_parts=of_b.parts,
        _blocks=str(blocks),
        _flips=flips,
    )


def _measure_lengths(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    pred_name: str,
    convention: Convention,
    lengths: Lengths,
    normalize: Normalize,
    representation: object,
) -> Measured:
    """Measure the NPSS of sequences that may differ in length, if it is normalised."""
    groups = read_motions(gt, pred, pred_name=pred_name, lengths=lengths, representation=representation).groups
    if normalize is not None:
        numbers = normalised_contributions(groups, convention)
    elif len(groups) == 1:
        numbers = contributions(groups[0].gt, groups[0].pred, convention)
    else:
        raise ValueError(
            f"normalize: expected 'bound' for sequences of {groups[0].n_frames} to {groups[-1].n_frames} frames, whose "
            f"scores are not comparable, got None"
        )
    return Measured(numbers.score, *numbers.by_sequence(), numbers.parts())
