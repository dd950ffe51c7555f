"""What about the motion makes its score meaningless; the traps themselves are in `npss._analysis.pitfalls`."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from npss._analysis.pitfalls import NOTE, TRAPS, WARNING, Block
from npss.validation import check_finite, motion_pair

_BLOCK = 2**18  # values of one motion seen at once


#: What the place of a finding is, where it is another than the first sequence, frame and feature.
_PLACES = {"shift": "the first is sequence", "degrees": "the largest is of feature"}
#: Traps that a motion is in or not; others spring so often.
_WHOLE = ("shift", "context", "poses", "degrees", "axes", "joints")


@dataclass(frozen=True)
class Finding:
    """A trap that a motion is in. `npss.diagnose` finds it; its text says all.

    Attributes
    ----------
    trap : str
        ``'wrap'``, ``'gimbal-flip'``, ``'quaternion-sign'``, ``'hemisphere'``, ``'constant'``, ``'shift'``,
        ``'context'``, ``'padding'``, ``'poses'``, ``'degrees'``, ``'axes'``, ``'joints'``, ``'powerless'``,
        ``'weight'`` or ``'no-real-power'``.
    argument : str
        Which of the two motions.
    count : int
        How often; of ``'context'``, how many frames.
    where : tuple of int
        Index of the first place, which begins with the sequence (0 for motion of shape ``(T, D)``), and ends with the
        quaternion for ``'quaternion-sign'`` and ``'hemisphere'``, with the first of three features for
        ``'gimbal-flip'``; of all features for ``'powerless'`` and ``'weight'``; of the largest for ``'degrees'``; empty
        where it is everywhere.
    message : str
        What it means.
    severity : str
        ``'warning'`` if something should be done, or known, before the score is believed; ``'note'`` if it is told
        for completeness: the text begins with it.
    """

    trap: str
    argument: str
    count: int
    where: tuple[int, ...]
    message: str
    severity: str = WARNING

    def __str__(self) -> str:
        """Say it in one line."""
        head = f"note: {self.argument}" if self.severity == NOTE else self.argument
        if self.trap in ("powerless", "weight"):
            return f"{head}: {self.count} {self.message}"
        if self.trap in _WHOLE:
            place = f"; {_PLACES[self.trap]} {self.where[0]}" if self.where else ""
            return f"{head}: {self.message}{place}"
        where = self.where[0] if len(self.where) == 1 else self.where
        last = "quaternion" if self.trap in ("quaternion-sign", "hemisphere") else "feature"
        what = ("sequence", f"sequence, {last}", f"sequence, frame, {last}")[len(self.where) - 1]
        return f"{head}: {self.count} {self.message}; the first at {what} {where}"


def diagnose(gt: npt.ArrayLike, pred: npt.ArrayLike) -> tuple[Finding, ...]:
    """Look for what changes scores silently: jumps of angles and signs, shifts, padding, degrees, swapped axes.

    Parameters
    ----------
    gt, pred : (N, T, D) or (T, D) array_like
        As for `score`.

    Returns
    -------
    tuple of Finding
        What was found, warnings first, then notes; ``str`` of each is a line to print. An empty tuple says that none of
        these traps was seen, not that all is well.

    Raises
    ------
    TypeError, ValueError
        If the input is not as `score` expects it.

    Notes
    -----
    Nothing is repaired. The traps are:

    - ``wrap``: jumps of about 2 pi between two frames of an angle;
    - ``gimbal-flip``: jumps of about pi of the outer two of three successive Euler angles, of which the middle one says
      that the rotation is the same, as the conversions make them where a joint passes gimbal lock;
    - ``quaternion-sign``: unit quaternions that change sign between frames, where D is a multiple of 4;
    - ``hemisphere``: unit quaternions that would be nearer to the ground truth with the other sign, throughout a
      sequence;
    - ``constant``: predictions that do not move;
    - ``shift``: a prediction of at least ten frames that is, or by a factor of two is closer to, the ground truth one
      or two frames earlier or later, such as windows cut one frame late;
    - ``context``: first or last frames that are equal in prediction and ground truth, in all sequences;
    - ``padding``: sequences that move, and end in three or more equal frames, in both;
    - ``poses``: 99 columns of which the first six are not zero, as those of Human3.6M poses before their conversion;
    - ``degrees``: values or movements that are too large for radians;
    - ``axes``: motion that is smooth along the last axis only, as if time were there;
    - ``joints``: a last axis of 3, 4 or 6, and motion that is much smoother along the first axis than along the second,
      as if ``(T, J, C)`` were passed for ``(N, T, D)``;
    - ``powerless``: features that are zero throughout the ground truth, and so have no weight: a note, unless something
      is predicted there;
    - ``weight``: a tenth of the features, or fewer, that hold nine tenths of the weight;
    - ``no-real-power``: predictions whose score by the convention ``released`` is rounding noise.

    In angles as `npss.poses_to_euler` returns them (99 columns, the first six zero), ``wrap`` and ``gimbal-flip`` are
    notes: the ground truth of Human3.6M has such jumps, and published tables are of angles as they come.

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
        findings = [Finding(trap.name, *found) for trap in traps for found in trap.found()]
    return tuple(sorted(findings, key=lambda finding: finding.severity == NOTE))
