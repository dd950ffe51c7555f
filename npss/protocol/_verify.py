"""Verify that a ground truth is that of a published table: by its shape, and by the score of zero-velocity."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Literal, get_args

import numpy as np
import numpy.typing as npt

from npss._metric.euler_error import euler_error
from npss._metric.in_betweening import l2q
from npss._metric.score import score
from npss.protocol._h36m import FPS
from npss.protocol._in_betweening import InBetweening, lafan1
from npss.rotations._poses import POSE, poses_to_euler
from npss.validation import Array, check_finite, positive_number, real_array

#: Human3.6M's protocols that are verified, and how their windows lie.
_PLACES = {"srnn-8": "on time", "srnn-8-late": "one frame late"}
#: The score of zero-velocity by 'released', measured by this project on each action, to four digits.
_SCORES: Mapping[str, Mapping[str, float]] = {
    "srnn-8": {"walking": 1.1413, "eating": 0.8677, "smoking": 0.9427},
    "srnn-8-late": {"walking": 1.1864, "eating": 0.8887, "smoking": 0.9438},
}
#: The Euler error of zero-velocity at these times: table 6 of the NPSS paper, and the same one frame late.
_AT_MS = (80, 160, 320, 400)
_ERRORS: Mapping[str, Mapping[str, tuple[float, ...]]] = {
    "srnn-8": {
        "walking": (0.39, 0.68, 0.99, 1.15),
        "eating": (0.27, 0.48, 0.73, 0.86),
        "smoking": (0.26, 0.48, 0.97, 0.95),
    },
    "srnn-8-late": {
        "walking": (0.38, 0.64, 1.01, 1.18),
        "eating": (0.26, 0.48, 0.76, 0.92),
        "smoking": (0.27, 0.53, 0.84, 0.90),
    },
}
#: A published number decides if half a unit of its last digit is less than this part of it: wrong windows and missing
#: joints change the score of zero-velocity by about a thousandth.
_DECIDES = 5e-4
UNIT = 1e-2  # the largest distance of a quaternion's length from 1

#: The names that `verify` knows.
Verified = Literal["lafan1", "srnn-8", "srnn-8-late"]
VERIFIED: tuple[Verified, ...] = get_args(Verified)


@dataclass(frozen=True, kw_only=True)
class Verification:
    """Whether a ground truth is that of a protocol.

    Attributes
    ----------
    protocol : str
        The name of the protocol.
    findings : tuple of str
        What differs, a sentence each. A number with a finding must not stand beside published ones.
    undecided : tuple of str
        What cannot be decided, a sentence each.
    agrees : tuple of str
        What agrees.
    """

    protocol: str
    findings: tuple[str, ...] = ()
    undecided: tuple[str, ...] = ()
    agrees: tuple[str, ...] = ()

    @property
    def ok(self) -> bool:
        """True if the ground truth is the protocol's: nothing differs, and nothing is undecided."""
        return not self.findings and not self.undecided

    @property
    def stated(self) -> dict[str, Any]:
        """The field for the signatures of numbers on this ground truth: ``verified:no``, or none."""
        return {"verified": "no"} if self.findings else {}

    def as_dict(self) -> dict[str, Any]:
        """Return it as JSON holds it: ``protocol``, ``ok``, ``findings``, ``undecided`` and ``agrees``."""
        return {
            "protocol": self.protocol,
            "ok": self.ok,
            "findings": list(self.findings),
            "undecided": list(self.undecided),
            "agrees": list(self.agrees),
        }

    def verdict(self) -> str:
        """Return it in one line, with what differs or cannot be decided."""
        return f"{self._head}{': ' * (not self.ok)}{'; '.join((*self.findings, *self.undecided))}"

    @property
    def _head(self) -> str:
        verdict = "verified" if self.ok else "not its ground truth" if self.findings else "undecided"
        return f"protocol {self.protocol}: {verdict}"

    def __str__(self) -> str:
        """Summarise it in a line for each sentence."""
        parts = (*self.findings, *self.undecided, *(f"agrees: {part}" for part in self.agrees))
        return "\n".join([self._head, *(f"  - {part}" for part in parts)])


@dataclass
class _Notes:
    """Sentences about one ground truth."""

    findings: list[str]
    undecided: list[str]
    agrees: list[str]


def verify(
    gt: npt.ArrayLike,
    protocol: Verified | InBetweening,
    *,
    past: npt.ArrayLike | None = None,
    action: str | None = None,
    fps: float | None = None,
) -> Verification:
    """Verify that a ground truth is that of a protocol, so that its numbers may stand beside published ones.

    By the convention ``'released'``, every constant prediction without zeros scores the same, so the *published* score
    of zero-velocity is a checksum of ground truth and windows that needs neither model nor data set.

    Parameters
    ----------
    gt : array_like
        The ground truth, target frames only. ``'lafan1'``: global quaternions ``(N, T, 22, 4)`` or ``(N, T, 88)``.
        ``'srnn-8'`` and ``'srnn-8-late'``: Human3.6M poses of one action, exponential maps ``(8, 100, 99)``.
    protocol : {'lafan1', 'srnn-8', 'srnn-8-late'} or InBetweening
        The protocol.
    past : array_like, optional
        The frames before `gt`, in the same representation, ``(N, S, ...)``; only the last one counts. With it, the
        L2Q or the Euler error of zero-velocity is compared to its published row, too, to two digits.
    action : str, optional
        The action of Human3.6M, if known; otherwise any that this project has measured: walking, eating, smoking.
    fps : float, optional
        Frames per second, if known.

    Returns
    -------
    Verification
        ``ok``, ``findings`` and ``undecided``; printed, a line for each.

    Raises
    ------
    TypeError
        If an array does not hold real numbers, or the protocol is neither a name nor an `InBetweening`.
    ValueError
        If the protocol is unknown, the array cannot be motion of it, a value is not finite, or `action` is given for a
        protocol without actions.

    Notes
    -----
    In-betweening decides from 30 and 45 frames. At 5 and 15, the published .0053 and .0522 have too few digits, and
    agreement is undecided. Shape, frame rate, lengths of quaternions and jumps of their signs are checked beside it.

    References
    ----------
    F. Harvey et al., "Robust Motion In-betweening", ACM Transactions on Graphics 39 (4), 2020 (the row of
    zero-velocity). A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, table 6.

    Examples
    --------
    >>> import numpy as np
    >>> from npss.protocol import verify
    >>> gt = np.random.default_rng(0).normal(size=(2231, 5, 22, 4))
    >>> result = verify(gt / np.linalg.norm(gt, axis=-1, keepdims=True), "lafan1")
    >>> result.ok, result.findings[0]
    (False, '2231 windows; lafan1 has 2232')
    """
    if fps is not None:
        positive_number("fps", fps)
    if isinstance(protocol, InBetweening) or protocol == lafan1.name:
        if action is not None:
            raise ValueError("action: in-betweening has none; leave it out")
        return _in_betweening(gt, lafan1 if isinstance(protocol, str) else protocol, past, fps)
    if not isinstance(protocol, str):
        raise TypeError(f"protocol: expected one of {', '.join(VERIFIED)}, or an InBetweening, got {protocol!r}")
    if protocol not in _PLACES:
        raise ValueError(f"protocol: expected one of {', '.join(VERIFIED)}, got {protocol!r}")
    return _human36m(gt, protocol, past, action, fps)


def _in_betweening(
    gt: npt.ArrayLike, protocol: InBetweening, past: npt.ArrayLike | None, fps: float | None
) -> Verification:
    truth = _joints("gt", gt)
    n, n_frames, n_joints, _ = truth.shape
    notes = _Notes([], [], [])
    _count(notes, n, protocol.windows, "windows", protocol.name)
    _count(notes, n_joints, protocol.joints, "joints", protocol.name)
    if fps is not None:
        _count(notes, fps, protocol.fps, "frames per second", protocol.name)
    lengths = np.linalg.norm(truth, axis=-1)
    unit = bool((np.abs(lengths - 1) <= UNIT).all())
    if not unit:
        notes.findings.append(f"not unit quaternions: their lengths are {lengths.min():.3g} to {lengths.max():.3g}")
    decided = False
    if n_frames not in protocol.transitions:
        notes.findings.append(f"{n_frames} frames; {_expected_frames(n_frames, protocol)}")
    else:
        decided = _checksum(notes, truth, protocol)
        if past is not None and unit:
            _l2q(notes, truth, past, protocol)
    flips = int(((truth[:, 1:] * truth[:, :-1]).sum(axis=-1) < 0).sum())
    if flips and not decided:
        notes.findings.append(
            f"signs of quaternions flip {flips} times from one frame to the next; make each clip continuous before "
            "it is cut (npss.rotations.continuous)"
        )
    return _verification(protocol.name, notes)


def _checksum(notes: _Notes, truth: Array, protocol: InBetweening) -> bool:
    """Compare the score of zero-velocity to the published one; return whether it agrees and decides."""
    row = protocol.zero_velocity.get("npss")
    n_frames = truth.shape[1]
    if row is None:
        notes.undecided.append(f"{protocol.name} has no score of zero-velocity to compare with")
        return False
    expected, half = row[protocol.transitions.index(n_frames)], _half_unit(4)
    found = _constant_score(truth)
    text = f"zero-velocity scores {found:.6f} over {n_frames} frames ('released'); published: {expected:.4f}"
    if abs(found - expected) > half:
        notes.findings.append(f"{text}: other windows, such as one frame early or late, or other motion")
        return False
    if half / expected > _DECIDES:
        notes.undecided.append(f"{text}, which agrees, but has too few digits to decide; verify longer transitions")
        return False
    notes.agrees.append(text)
    return True


def _l2q(notes: _Notes, truth: Array, past: npt.ArrayLike, protocol: InBetweening) -> None:
    row = protocol.zero_velocity.get("l2q")
    last = _last("past", _joints("past", past), truth)
    if row is None:
        return
    expected = row[protocol.transitions.index(truth.shape[1])]
    found = l2q(truth, np.repeat(last[:, np.newaxis], truth.shape[1], axis=1), past=last)
    text = f"the L2Q of zero-velocity is {found:.3f}; published: {expected:.2f}"
    (notes.agrees if abs(found - expected) <= _half_unit(2) else notes.findings).append(text)


def _expected_frames(n_frames: int, protocol: InBetweening) -> str:
    """Say which transitions a protocol has, and what else may be in the array."""
    lengths = ", ".join(map(str, protocol.transitions))
    extra = {n_frames - n: n for n in protocol.transitions if n_frames > n}
    context = protocol.past + protocol.future
    for frames, what in (
        (2, "both key frames"),
        (1, "a key frame"),
        (protocol.past, "the past"),
        (context, "the context"),
    ):
        if frames in extra:
            return f"{protocol.name} has transitions of {lengths}: are {extra[frames]} frames scored with {what}?"
    return f"{protocol.name} has transitions of {lengths}"


def _human36m(
    gt: npt.ArrayLike, protocol: str, past: npt.ArrayLike | None, action: str | None, fps: float | None
) -> Verification:
    truth = real_array("gt", gt)
    if truth.ndim != 3 or 0 in truth.shape:
        raise ValueError(f"gt: expected exponential maps (N, T, {POSE}), got shape {truth.shape}")
    check_finite("gt", truth)
    notes = _Notes([], [], [])
    for found, expected, what in zip(truth.shape, (8, 100, POSE), ("windows", "frames", "columns"), strict=True):
        _count(notes, found, expected, what, protocol)
    if fps is not None:
        _count(notes, fps, FPS, "frames per second", protocol)
    if notes.findings:
        return _verification(protocol, notes)
    known = _SCORES[protocol]
    if action is not None and action not in known:
        notes.undecided.append(f"no score of zero-velocity on {action!r} to compare with; known: {', '.join(known)}")
        return _verification(protocol, notes)
    angles = poses_to_euler(truth)
    found, matches = _matches(angles)
    held = None if past is None else _last_of(past, len(angles))
    wanted = [(protocol, of) for of in known if action in (None, of)]
    text = f"zero-velocity scores {found:.6f} ('released')"
    if match := next((match for match in matches if match in wanted), None):
        notes.agrees.append(f"{text}, as on {match[1]} {_PLACES[protocol]}")
        if held is not None:
            _euler_row(notes, angles, held, *match)
        return _verification(protocol, notes)
    row = ", ".join(f"{known[of]:.4f} on {of}" for _, of in wanted)
    other = "".join(f"; it is {of} {_PLACES[name]} ({name})" for name, of in matches[:1])
    notes.findings.append(f"{text}; {protocol} has {row}{other}")
    return _verification(protocol, notes)


def verify_angles(angles: Array, protocol: Verified, *, fps: float | None = None) -> Verification:
    """Verify windows of Human3.6M by their Euler angles ``(N, T, D)``, of an unknown action.

    Most actions have no measured score, so a score as on none of those that have is undecided.
    """
    notes = _Notes([], [], [])
    for found, expected, what in zip(angles.shape, (8, 100), ("windows", "frames"), strict=False):
        _count(notes, found, expected, what, protocol)
    if fps is not None:
        _count(notes, fps, FPS, "frames per second", protocol)
    if notes.findings:
        return _verification(protocol, notes)
    found, matches = _matches(angles)
    text = f"zero-velocity scores {found:.6f} ('released')"
    if match := next((match for match in matches if match[0] == protocol), None):
        notes.agrees.append(f"{text}, as on {match[1]} {_PLACES[protocol]}")
    elif matches:
        name, of = matches[0]
        notes.findings.append(f"{text}; it is {of} {_PLACES[name]} ({name})")
    else:
        notes.undecided.append(f"{text}, as on none of {', '.join(_SCORES[protocol])}: another action, or other motion")
    return _verification(protocol, notes)


def measured_actions(protocol: str) -> tuple[str, ...]:
    """Return the actions of Human3.6M whose score of zero-velocity is known."""
    return tuple(_SCORES.get(protocol, ()))


def _matches(angles: Array) -> tuple[float, list[tuple[str, str]]]:
    """Return the score of zero-velocity, and the protocols and actions that have it."""
    found = _constant_score(angles)
    rows = [(name, of, score) for name, row in _SCORES.items() for of, score in row.items()]
    return found, [(name, of) for name, of, score in rows if abs(found - score) <= _half_unit(4)]


def _last_of(past: npt.ArrayLike, n: int) -> Array:
    """Return the last of the frames before n windows, (n, 1, 99)."""
    frames = real_array("past", past)
    if frames.ndim != 3 or frames.shape[::2] != (n, POSE):
        raise ValueError(f"past: expected exponential maps ({n}, S, {POSE}), got shape {frames.shape}")
    return frames[:, -1:]


def _euler_row(notes: _Notes, angles: Array, last: Array, protocol: str, action: str) -> None:
    """Compare the Euler error of zero-velocity to that of the protocol."""
    held = np.repeat(poses_to_euler(last), angles.shape[1], axis=1)
    found = list(euler_error(angles, held, fps=FPS, at_ms=_AT_MS).values())
    expected = _ERRORS[protocol][action]
    text = f"the Euler error of zero-velocity is {_row(found, 3)}; {protocol} has {_row(expected, 2)} on {action}"
    agrees = all(abs(one - other) <= _half_unit(2) for one, other in zip(found, expected, strict=True))
    (notes.agrees if agrees else notes.findings).append(text)


def _constant_score(truth: Array) -> float:
    """Return the score of zero-velocity: that of any constant prediction without zeros."""
    return score(
        truth.reshape(*truth.shape[:2], -1), np.ones((*truth.shape[:2], truth[0, 0].size)), convention="released"
    )


def _joints(name: str, values: npt.ArrayLike) -> Array:
    """Read quaternions as ``(N, T, J, 4)``."""
    array = real_array(name, values)
    if array.ndim == 3 and array.shape[-1] % 4 == 0:
        array = array.reshape(*array.shape[:2], -1, 4)
    if array.ndim != 4 or array.shape[-1] != 4 or 0 in array.shape:
        raise ValueError(f"{name}: expected global quaternions (N, T, J, 4) or (N, T, 4 J), got shape {array.shape}")
    check_finite(name, array)
    return array.astype(np.float64)


def _last(name: str, frames: Array, truth: Array) -> Array:
    if (len(frames), *frames.shape[2:]) != (len(truth), *truth.shape[2:]):
        raise ValueError(f"{name}: its shape {frames.shape} is not that of frames before gt, {truth.shape}")
    last: Array = frames[:, -1]
    return last


def _count(notes: _Notes, found: float, expected: float | None, what: str, protocol: str) -> None:
    if expected is not None:
        same = found == expected
        text = f"{found:g} {what}" + ("" if same else f"; {protocol} has {expected:g}")
        (notes.agrees if same else notes.findings).append(text)


def _half_unit(digits: int) -> float:
    """Return half a unit of the last digit, and a little for numbers half way."""
    return 0.5 * 10.0**-digits * (1 + 1e-6)


def _row(numbers: npt.ArrayLike, digits: int) -> str:
    return " ".join(f"{number:.{digits}f}" for number in np.asarray(numbers).tolist())


def _verification(protocol: str, notes: _Notes) -> Verification:
    return Verification(
        protocol=protocol,
        findings=tuple(notes.findings),
        undecided=tuple(notes.undecided),
        agrees=tuple(notes.agrees),
    )
