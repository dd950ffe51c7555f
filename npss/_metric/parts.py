"""What a score is made of: the form of the spectra, and the share of their power in the mean pose (DC)."""

from __future__ import annotations

from typing import NamedTuple

from npss.validation import Float64


class Parts(NamedTuple):
    """What an NPSS is made of; ``form + share`` is the score.

    NPSS compares power spectra, whose first bin (DC) is the power of the mean pose. The share of DC in the power tells
    how much an angle moves, compared with its mean; the other bins, relative to each other, tell at which frequencies.
    Scale all bins of the prediction but DC by one factor, for each feature of each sequence, so that its share of DC
    is that of the ground truth. The score of that is `form`; the rest is `share`.

    Attributes
    ----------
    form : float
        The score that is left with the true shares of DC. 0 for a prediction without power outside DC (at most 1e-20 of
        its total).
    share : float
        The score minus `form`. Negative if the true shares would raise the score, which happens under ``'paper'`` and
        ``'released'``: the prediction moves too little, and at too high a frequency. Never negative under
        ``'literal'``.
    share_floor : float or None
        The lowest score of any prediction with the same shares of DC: the weighted mean of T / 2 times the difference
        of the shares of prediction and ground truth; for a distance of spectra, not of cumulative distributions, twice
        the difference. For a prediction of zeros under ``'released'``, its score. None for a one-sided convention.

    Notes
    -----
    A difference of the means, a constant prediction and a constant ground truth are all share. A pure tone of another
    frequency, with the same mean and amplitude, is all form.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> t = np.arange(100)[:, np.newaxis] / 25
    >>> walk = 1 + np.cos(2 * np.pi * t)
    >>> print(npss.report(walk, 2 + np.cos(2 * np.pi * t)).parts)
    form 0.0000, share of DC +11.1111; no prediction with such shares scores below 11.1111
    >>> print(npss.report(walk, 1 + np.cos(4 * np.pi * t)).parts)
    form 1.3333, share of DC +0.0000; no prediction with such shares scores below 0.0000
    """

    form: float
    share: float
    share_floor: float | None

    def __str__(self) -> str:
        """State the parts in a line."""
        share = self.share if abs(self.share) >= 0.5e-4 else 0.0  # no "-0.0000"
        text = f"form {self.form:.4f}, share of DC {share:+.4f}"
        if share < 0:
            text += " (the true shares would raise the score)"
        if self.share_floor is not None:
            text += f"; no prediction with such shares scores below {self.share_floor:.4f}"
        return text


def parts_of(score: float, weight: Float64, form: Float64, floor: Float64 | None, total: float) -> Parts:
    """Average the parts of columns; `score` is the sum of their weighted distances divided by the `total` weight."""
    of_form = float((weight * form).sum() / total)
    return Parts(of_form, score - of_form, None if floor is None else float((weight * floor).sum() / total))
