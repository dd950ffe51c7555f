"""Report on several samples: their spread, and apart from it the uncertainty over blocks."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import get_args

import numpy as np
import numpy.typing as npt

from npss._analysis.blocks import INFERRED, Blocks, Groups, Label, read_groups
from npss._analysis.fingerprint import fingerprint
from npss._analysis.interval import Interval, Range, interval, method
from npss._metric.convention import Convention, ConventionName, as_convention
from npss._metric.fields import Value
from npss._metric.registry import NPSS
from npss._metric.signature import signature, stated_with
from npss.protocol import Verification
from npss.protocol._claims import check_claims
from npss.stochastic._samples import read_samples
from npss.stochastic._score import Reduction, scored
from npss.validation import Float64, Seed, one_of, positive_number


@dataclass(frozen=True, kw_only=True, eq=False, repr=False)
class SampleReport:
    """NPSS of several samples, from `npss.stochastic.report`; ``float(report)`` is the score.

    Attributes
    ----------
    score : float
        The score, as `npss.stochastic.score` returns it.
    signature : str
        The signature of the score.
    scores : (S,) ndarray of float64
        The score of each sample, of all sequences. Read-only.
    numerator, weight : (N,) ndarray of float64
        What each sequence adds to the numerator and denominator of the score. Read-only.
    fingerprint : (N, 9) ndarray of float64
        As in `npss.Report`.
    groups : tuple of str, int or None; or None
        The block of each sequence, as in `npss.Report`.
    verification : npss.protocol.Verification or None
        Whether the ground truth is that of the stated protocol, as in `npss.Report`.
    """

    score: float
    signature: str
    scores: Float64
    numerator: Float64
    weight: Float64
    fingerprint: Float64
    groups: Groups = None
    verification: Verification | None = None

    def __float__(self) -> float:
        """Return the score."""
        return self.score

    @property
    def spread(self) -> float:
        """The sample standard deviation of the scores of samples; NaN of a single one.

        It says how much the score depends on the draw, not how it would be for other motion: see `interval`.
        """
        return float(self.scores.std(ddof=1)) if len(self.scores) > 1 else float("nan")

    @property
    def per_sequence(self) -> Float64:
        """The score of each sequence, ``(N,)``; NaN where it has no power."""
        quotient: Float64 = np.divide(
            self.numerator, self.weight, out=np.full(len(self.weight), np.nan), where=self.weight > 0
        )
        return quotient

    def interval(self, *, level: float = 0.95, seed: Seed = 0) -> Interval | Range:
        """Return the uncertainty of the score over other blocks of the same kind, with these numbers of samples.

        Parameters
        ----------
        level, seed
            As for `npss.Report.interval`.

        Returns
        -------
        Interval or Range
            As for `npss.Report.interval`.

        Raises
        ------
        TypeError, ValueError
            As for `npss.Report.interval`.
        """
        return interval(self.numerator, self.weight, self._blocks, level=level, seed=seed)

    @property
    def _blocks(self) -> Blocks:
        return Blocks(self.groups, self.weight)

    def __repr__(self) -> str:
        return f"SampleReport(score={self.score!r}, signature={self.signature!r})"

    def __str__(self) -> str:
        """Summarise the report in a few lines."""
        low, high = self.interval()
        blocks = self._blocks
        over = f"standard deviation {self.spread:.4f}, " if len(self.scores) > 1 else ""
        lines = [
            f"{NPSS.heading} {self.score:.4f}",
            f"  over {len(self.scores)} samples: {over}{self.scores.min():.4f} to {self.scores.max():.4f}",
            f"  over blocks: {low:.4f} to {high:.4f} ({method(blocks)})",
            f"  {self.signature}",
            *([] if self.verification is None else [f"  {self.verification.verdict()}"]),
            f"  {blocks}",
            f"  {INFERRED}",
        ]
        return "\n".join(lines)


def report(
    gt: npt.ArrayLike,
    samples: npt.ArrayLike,
    *,
    reduction: Reduction = "mean",
    convention: ConventionName | Convention = "paper",
    fps: float | None = None,
    groups: Iterable[Label | None] | None = None,
    extra: Mapping[str, Value] | None = None,
    **context: Value,
) -> SampleReport:
    """Score several samples of each sequence, with their spread and, apart from it, the uncertainty over blocks.

    Parameters
    ----------
    gt, samples, reduction, convention
        As for `npss.stochastic.score`.
    fps, groups, extra, **context
        As for `npss.report`.

    Returns
    -------
    SampleReport
        The report. ``print(report)`` shows the score, its spread over samples, and its interval over blocks;
        `npss.leaderboard` ranks it.

    Raises
    ------
    TypeError, ValueError
        As for `npss.stochastic.score` and `npss.report`.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> gt, *samples = np.random.default_rng(0).normal(size=(4, 12, 50, 3)).cumsum(axis=2)
    >>> report = npss.stochastic.report(gt, samples)
    >>> report.signature
    'npss|version:1|convention:paper|frames:50|draws:3|reduction:mean'
    >>> bool(report.scores.min() <= float(report) <= report.scores.max())
    True
    """
    one_of("reduction", reduction, get_args(Reduction))
    truth, drawn = read_samples(gt, samples, context.get("representation"))  # type: ignore[arg-type]
    chosen = as_convention(convention)
    fields = stated_with(report, context, extra, frames=truth.shape[1], draws=len(drawn), reduction=reduction)
    if fps is not None:
        fields["fps"] = positive_number("fps", fps)
    signature(chosen, **fields)  # checks the fields before they are compared to the motion
    verification = check_claims(fields, truth, **{f"samples[{i}]": sample for i, sample in enumerate(drawn)})
    meaning = signature(chosen, **fields | ({} if verification is None else verification.stated))
    labels = read_groups("groups", groups, len(truth))
    results = scored(truth, drawn, chosen)
    Blocks(labels, results.weight)  # checks that a block has power
    value, numerator = results.reduced(reduction)
    for array in (results.scores, numerator, results.weight):
        array.flags.writeable = False
    return SampleReport(
        score=value,
        signature=meaning,
        scores=results.scores,
        numerator=numerator,
        weight=results.weight,
        fingerprint=fingerprint(truth),
        groups=labels,
        verification=verification,
    )
