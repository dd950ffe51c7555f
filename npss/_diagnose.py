"""What about the motion makes its score meaningless; the traps themselves are in `npss._traps`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss._checks import check_finite, motion_pair
from npss._traps import TRAPS, Block

_BLOCK = 2**18  # values of one motion seen at once


@dataclass(frozen=True)
class Finding:
    """A trap that a motion is in. `npss.diagnose` finds it; its text says all.

    Parameters
    ----------
    trap : str
        ``'wrap'``, ``'quaternion-sign'``, ``'constant'``, ``'shift'``, ``'degrees'``, ``'axes'``, ``'powerless'`` or
        ``'no-real-power'``.
    argument : str
        Which of the two motions.
    count : int
        How often.
    where : tuple of int
        Index of the first place, which begins with the sequence (0 for motion of shape ``(T, D)``), and ends with the
        quaternion for ``'quaternion-sign'``; of all features for ``'powerless'``; of the largest for ``'degrees'``;
        empty where it is everywhere.
    message : str
        What it means.
    """

    trap: str
    argument: str
    count: int
    where: tuple[int, ...]
    message: str

    def __str__(self) -> str:
        """Say it in one line."""
        if self.trap == "powerless":
            return f"{self.argument}: {self.count} {self.message}"
        if self.trap in ("shift", "degrees", "axes"):
            what = "the first is sequence" if self.trap == "shift" else "the largest is of feature"
            place = f"; {what} {self.where[0]}" if self.where else ""
            return f"{self.argument}: {self.message}{place}"
        where = self.where[0] if len(self.where) == 1 else self.where
        last = "quaternion" if self.trap == "quaternion-sign" else "feature"
        what = ("sequence", "sequence, feature", f"sequence, frame, {last}")[len(self.where) - 1]
        return f"{self.argument}: {self.count} {self.message}; the first at {what} {where}"


def diagnose(gt: npt.ArrayLike, pred: npt.ArrayLike) -> tuple[Finding, ...]:
    """Look for what changes scores silently: wraps, sign flips, constants, shifts, degrees, swapped axes.

    Parameters
    ----------
    gt, pred : (N, T, D) or (T, D) array_like
        As for `score`.

    Returns
    -------
    tuple of Finding
        What was found; ``str`` of each is a line to print. An empty tuple says that none of these traps was seen, not
        that all is well.

    Raises
    ------
    TypeError, ValueError
        If the input is not as `score` expects it.

    Notes
    -----
    Nothing is repaired. The traps are:

    - ``wrap``: jumps of about 2 pi between two frames of an angle;
    - ``quaternion-sign``: unit quaternions that change sign between frames, where D is a multiple of 4;
    - ``constant``: predictions that do not move;
    - ``shift``: a prediction of at least ten frames that is, or by a factor of two is closer to, the ground truth one
      or two frames earlier or later, such as windows cut one frame late;
    - ``degrees``: values or movements that are too large for radians;
    - ``axes``: motion that is smooth along the last axis only, as if time were there;
    - ``powerless``: features that are zero throughout the ground truth, and so have no weight;
    - ``no-real-power``: predictions whose score by the convention ``released`` is rounding noise.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> motion = np.random.default_rng(0).normal(size=(2, 51, 3)).cumsum(axis=1)
    >>> for finding in npss.diagnose(motion[:, :-1], motion[:, 1:]):
    ...     print(finding)
    pred: is the ground truth 1 frame later
    """
    truth, prediction = motion_pair(gt, pred)
    check_finite("gt", truth)
    check_finite("pred", prediction)
    if truth.ndim == 2:
        truth, prediction = truth[np.newaxis], prediction[np.newaxis]
    traps = [trap() for trap in TRAPS]
    height = max(1, _BLOCK // (truth.shape[1] * truth.shape[2]))
    with np.errstate(over="ignore", invalid="ignore"):  # values of which the squares overflow are in no trap
        for top in range(0, len(truth), height):
            rows = slice(top, top + height)
            block = Block(top, truth[rows].astype(np.float64), prediction[rows].astype(np.float64))
            for trap in traps:
                trap.see(block)
        return tuple(Finding(trap.name, *found) for trap in traps for found in trap.found())
