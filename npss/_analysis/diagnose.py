"""Diagnose motion whose score is meaningless; the pitfalls are in `npss._analysis.pitfalls`."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from npss._analysis.pitfalls import NOTE, PITFALLS, WARNING, Block
from npss._metric.convention import Convention, ConventionName, as_convention
from npss._metric.sequences import Group, Lengths, read_motions
from npss.validation import check_finite

_BLOCK = 2**18  # values of one motion seen at once


#: The meaning of a place, if it is not the first sequence, frame and feature.
_PLACES = {"shift": "the first is sequence", "degrees": "the largest is in feature"}
#: Pitfalls whose places are features.
_OF_FEATURES = ("degrees", "powerless", "weight")
#: Pitfalls of a whole motion; all others are counted.
_WHOLE = ("component-order", "shift", "context", "poses", "degrees", "axes", "joints", "share")


@dataclass(frozen=True)
class Finding:
    """A pitfall that `npss.diagnose` finds in a motion; its text is a full message.

    Attributes
    ----------
    pitfall : str
        ``'wrap'``, ``'gimbal-flip'``, ``'quaternion-sign'``, ``'hemisphere'``, ``'component-order'``, ``'constant'``,
        ``'shift'``, ``'context'``, ``'padding'``, ``'poses'``, ``'degrees'``, ``'axes'``, ``'joints'``,
        ``'powerless'``, ``'weight'``, ``'no-real-power'`` or ``'share'``.
    argument : str
        The motion: ``'gt'`` or ``'pred'``.
    count : int
        How often it occurs; for ``'context'``, the number of frames.
    where : tuple of int
        The index of the first place. It begins with the sequence (0 for motion of shape ``(T, D)``), and ends with the
        quaternion for ``'quaternion-sign'`` and ``'hemisphere'``, or the first of three features for ``'gimbal-flip'``.
        All features for ``'powerless'`` and ``'weight'``; the largest for ``'degrees'``; empty if it is everywhere.
    message : str
        What it means.
    severity : str
        ``'warning'`` if something should be done, or known, before the score is believed; ``'note'`` if it is reported
        for completeness: the text then begins with "note".
    """

    pitfall: str
    argument: str
    count: int
    where: tuple[int, ...]
    message: str
    severity: str = WARNING

    def __str__(self) -> str:
        """Return the finding in one line."""
        head = f"note: {self.argument}" if self.severity == NOTE else self.argument
        if self.pitfall in ("powerless", "weight"):
            return f"{head}: {self.count} {self.message}"
        if self.pitfall in _WHOLE:
            place = f"; {_PLACES[self.pitfall]} {self.where[0]}" if self.where else ""
            return f"{head}: {self.message}{place}"
        where = self.where[0] if len(self.where) == 1 else self.where
        last = "quaternion" if self.pitfall in ("quaternion-sign", "hemisphere") else "feature"
        what = ("sequence", f"sequence, {last}", f"sequence, frame, {last}")[len(self.where) - 1]
        return f"{head}: {self.count} {self.message}; the first at {what} {where}"


def diagnose(
    gt: npt.ArrayLike,
    pred: npt.ArrayLike,
    *,
    convention: ConventionName | Convention = "paper",
    lengths: Lengths = None,
    representation: str | None = None,
) -> tuple[Finding, ...]:
    """Look for pitfalls that change scores silently: jumps, flipped signs, shifts, padding, degrees, swapped axes.

    Parameters
    ----------
    gt, pred : (N, T, D), (T, D) or (N, T, J, C) array_like
        As for `score`. Places of findings count the flattened features.
    convention : {'paper', 'released', 'literal'} or Convention, optional
        The convention of the score whose share of DC is noted; nothing else depends on it.
    lengths : (N,) array_like of int, optional
        As for `score`. Sequences of each length are looked at by themselves, as for lists of sequences that differ in
        length; the messages name the length.
    representation : str, optional
        As for `score`.

    Returns
    -------
    tuple of Finding
        Warnings first, then notes; ``str`` of each is a line to print. An empty tuple means that none of these pitfalls
        was found, not that all is well.

    Raises
    ------
    TypeError, ValueError
        If the input is not as `score` expects it.

    Notes
    -----
    Nothing is repaired. The pitfalls are:

    - ``wrap``: jumps of about 2 pi between two frames of an angle;
    - ``gimbal-flip``: jumps of about pi in the outer two of three successive Euler angles, while the middle one shows
      that the rotation is the same, as conversions produce them when a joint passes gimbal lock;
    - ``quaternion-sign``: unit quaternions that change sign between frames, if D is a multiple of 4;
    - ``hemisphere``: unit quaternions that would be nearer to the ground truth with the other sign, throughout a
      sequence;
    - ``component-order``: unit quaternions, eight or more, that are much closer to the ground truth if their components
      are taken as x, y, z, w in place of w, x, y, z, or the other way round;
    - ``constant``: predictions that do not move;
    - ``shift``: a prediction of at least ten frames that equals the ground truth one or two frames earlier or later, or
      is closer to it by a factor of two, such as windows cut one frame late;
    - ``context``: first or last frames that are equal in prediction and ground truth, in all sequences;
    - ``padding``: sequences that move, and end in three or more equal frames, in both;
    - ``poses``: 99 columns, the first six not zero, as in Human3.6M poses before conversion;
    - ``degrees``: values or movements that are too large for radians;
    - ``axes``: motion that is smooth along the last axis only, as if time came last; along the third of four axes only;
      or much smoother along the first axis than along the second, as if time came first;
    - ``joints``: a last axis of 3, 4 or 6, and motion that is much smoother along the first axis than along the second,
      as if ``(T, J, C)`` were passed for ``(N, T, D)``;
    - ``powerless``: features that are zero throughout the ground truth, and so have no weight: a note, unless the
      prediction is not zero there;
    - ``weight``: a tenth of the features, or fewer, that hold nine tenths of the weight;
    - ``no-real-power``: predictions whose score by the convention ``released`` is rounding noise;
    - ``share``: a score by `convention` that is mostly the share of DC (`Parts`), which says how much a feature moves,
      not how; a note, since it is common.

    In angles as `npss.poses_to_euler` returns them (99 columns, the first six zero), ``wrap`` and ``gimbal-flip`` are
    notes: the ground truth of Human3.6M has such jumps, and published tables leave them in.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> motion = np.random.default_rng(0).normal(size=(2, 51, 3)).cumsum(axis=1)
    >>> for finding in npss.diagnose(motion[:, :-1], motion[:, 1:]):
    ...     print(f"{finding.severity} {finding.pitfall}, {str(finding):.40} ...")
    warning shift, pred: is the ground truth 1 frame later ...
    note share, note: pred: 79% of the score by 'paper', ...
    """
    motions = read_motions(gt, pred, lengths=lengths, representation=representation, spectra=False)
    chosen = as_convention(convention)
    findings = [one for group in motions.groups for one in _findings(group, chosen, by_length=motions.by_length)]
    return tuple(sorted(findings, key=lambda finding: finding.severity == NOTE))


def _findings(group: Group, convention: Convention, *, by_length: bool) -> list[Finding]:
    """Look for pitfalls in sequences of one length."""
    truth, prediction = group.gt, group.pred
    check_finite("gt", truth)
    check_finite("pred", prediction)
    if truth.ndim == 2:
        truth, prediction = truth[np.newaxis], prediction[np.newaxis]
    pitfalls = [pitfall() for pitfall in PITFALLS]
    height = max(1, _BLOCK // (truth.shape[1] * truth.shape[2]))
    with np.errstate(over="ignore", invalid="ignore"):  # values whose squares overflow count for no pitfall
        for top in range(0, len(truth), height):
            rows = slice(top, top + height)
            block = Block(top, truth[rows].astype(np.float64), prediction[rows].astype(np.float64), convention)
            for pitfall in pitfalls:
                pitfall.see(block)
        findings = [Finding(pitfall.name, *found) for pitfall in pitfalls for found in pitfall.found()]
    return [_placed(finding, group) for finding in findings] if by_length else findings


def _placed(finding: Finding, group: Group) -> Finding:
    """Name the length, and the place of the first sequence in the whole set."""
    where = finding.where
    if where and finding.pitfall not in _OF_FEATURES:
        where = (group.rows[where[0]], *where[1:])
    return replace(finding, where=where, message=f"{finding.message} (sequences of {group.n_frames} frames)")
