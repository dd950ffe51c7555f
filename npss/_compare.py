"""Is one prediction better than another: a paired test over the sequences of one ground truth."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss._checks import Float64, motion_array, motion_pair, one_of, positive_number
from npss._convention import Convention, as_convention
from npss._euler_error import sequence_errors
from npss._fields import Value
from npss._frames import whole_frames
from npss._report import contributions
from npss._score import quotient, weighted_sums
from npss._sign_flip import SAMPLES, SignFlips, sign_flips
from npss._signature import signature, stated_with


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class Comparison:
    """Two predictions of one ground truth, compared. `npss.compare` makes it.

    Parameters
    ----------
    a, b : float
        The two scores; lower is better.
    signature : str
        What they mean.
    n : int
        Sequences that count: those with power.
    p_value : float
        Two-sided: how often names of models dealt at random in every sequence make a difference at least as large.
    exact : bool
        Whether all ways to deal the names were counted, or 9999 drawn ones and the one that was seen.
    """

    a: float
    b: float
    signature: str
    n: int
    p_value: float
    exact: bool
    _flips: SignFlips

    @property
    def difference(self) -> float:
        """Score of the first minus that of the second: negative where the first is better."""
        return self.a - self.b

    def interval(self, *, level: float = 0.95) -> tuple[float, float]:
        """Return the differences that the test does not reject: a confidence interval of the difference.

        It excludes 0 if and only if ``p_value`` is at most ``1 - level``.

        Parameters
        ----------
        level : float, optional
            Share of such intervals that should hold the true difference.

        Returns
        -------
        low, high : float
            Infinite where there are too few sequences to tell: at the usual level, fewer than six.

        Raises
        ------
        TypeError, ValueError
            If the level is not between 0 and 1.
        """
        return self._flips.interval(level)

    def __repr__(self) -> str:
        return f"Comparison(a={self.a!r}, b={self.b!r}, p_value={self.p_value!r}, signature={self.signature!r})"

    def __str__(self) -> str:
        """Say everything in a few lines."""
        low, high = self.interval()
        ways = f"all {2**self.n}" if self.exact else f"{SAMPLES} random"
        return (
            f"{self.a:.4f} - {self.b:.4f} = {self.difference:.4f}, {low:.4f} to {high:.4f} (95 %), "
            f"p = {self.p_value:.3g}\n"
            f"  two-sided sign-flip test over {self.n} sequences, {ways} exchanges, and the differences that it does "
            f"not reject\n"
            f"  {self.signature}"
        )


def compare(
    gt: npt.ArrayLike,
    pred_a: npt.ArrayLike,
    pred_b: npt.ArrayLike,
    *,
    metric: str = "npss",
    convention: str | Convention = "paper",
    fps: float | None = None,
    at_ms: float | None = None,
    seed: int = 0,
    extra: Mapping[str, Value] | None = None,
    **context: Value,
) -> Comparison:
    """Test whether one prediction is better than another, by exchanging the two in some of the sequences.

    If the models were as good as each other, it would not matter which of a sequence's two predictions is called
    the first's. So all ways to exchange them are tried (up to 16 sequences; for 8, that is 256, in pairs of
    opposite ones), or 9999 drawn ones, and the share that makes a difference at least as large is the p-value.

    Parameters
    ----------
    gt : (N, T, D) array_like
        Ground truth of N >= 2 sequences.
    pred_a, pred_b : (N, T, D) array_like
        Two predictions of it.
    metric : {'npss', 'euler_error'}, optional
        What to compare by.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        Of NPSS.
    fps : float, optional
        Frames per second; needed for the Euler error, else only stated in the signature.
    at_ms : float, optional
        The time of the Euler error, in milliseconds.
    seed : int, optional
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
        and `at_ms` do not fit the metric, or a weight leaves the range of float64.

    Notes
    -----
    The test holds the ground truth, and with it the weights of sequences, as given. Its null hypothesis is that a
    sequence's two predictions may as well be exchanged; then a p-value of at most p has probability of at most p,
    however few the sequences. That is more than equal scores: where the differences are skewed, or go with the weight
    of the sequence, models of equal score are told apart too often, and the interval misses too often. A p-value cannot
    be smaller than 2 / 2**N, which is .0078 for the eight windows of the field; comparing many models asks for less
    (`leaderboard` corrects for it).

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
    one_of("metric", metric, ("npss", "euler_error"))
    truth = motion_array("gt", gt)
    if truth.ndim != 3 or len(truth) < 2:
        raise ValueError(f"gt: expected shape (N, T, D) with N >= 2 sequences to pair, got {truth.shape}")
    known: dict[str, Value] = {"frames": truth.shape[1]}
    rate = None if fps is None else positive_number("fps", fps)
    if rate is not None:
        known["fps"] = rate
    if metric == "npss" and at_ms is not None:
        raise ValueError("at_ms: NPSS is of all frames; leave it out, or compare by metric='euler_error'")
    chosen = as_convention(convention)
    if metric == "euler_error":
        if rate is None or at_ms is None:
            raise ValueError("at_ms: the Euler error is one of a time: give fps and at_ms")
        frame = whole_frames("at_ms", at_ms, rate, first=1, last=truth.shape[1], per_second=1000) - 1
        known |= {"at_ms": at_ms, "columns": "gt", "average": "at"}
    stated = stated_with(compare, context, extra, **known)
    meaning = signature(chosen if metric == "npss" else None, metric=metric, **stated)

    def measured(name: str, values: npt.ArrayLike) -> tuple[float, Float64, Float64]:
        try:
            _, pred = motion_pair(truth, values)
            if metric == "euler_error":
                errors = sequence_errors(truth, pred)[:, frame]
                return float(errors.mean()), errors, np.ones(len(errors))
            value = quotient(*weighted_sums(truth, pred, chosen))
            emd, weight = contributions(truth, pred, chosen)
            return value, (weight * emd).sum(axis=1), weight.sum(axis=1)
        except (TypeError, ValueError) as error:
            raise type(error)(re.sub("^pred:", f"{name}:", str(error))) from error

    a, first, weight = measured("pred_a", pred_a)
    b, second, _ = measured("pred_b", pred_b)
    counts = weight > 0
    flips = sign_flips((first - second)[counts], weight[counts], seed=seed)
    return Comparison(
        a=a,
        b=b,
        signature=meaning,
        n=int(counts.sum()),
        p_value=flips.p_value(),
        exact=flips.exact,
        _flips=flips,
    )
