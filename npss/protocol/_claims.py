"""Check what the signature of a number claims about its motion: whose ground truth it is, and the signs of quaternions.

Whoever holds the arrays checks it, so that no number stands beside published ones by its name alone.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from npss.protocol._in_betweening import lafan1
from npss.protocol._verify import UNIT, VERIFIED, Verification, verify, verify_angles
from npss.validation import Array

_ROUNDING = 1e-6  # of the product of successive quaternions, in single precision


def check_claims(stated: Mapping[str, Any], gt: Array, **predictions: Array) -> Verification | None:
    """Check the fields of a signature by the arrays of its number.

    Parameters
    ----------
    stated : mapping of str to value
        The fields, ``protocol``, ``representation``, ``fps`` and ``quaternions`` among them, if stated.
    gt : (N, T, D) or (T, D) ndarray
        The ground truth.
    **predictions : (N, T, D) or (T, D) ndarray
        Predictions, by the names of their arguments.

    Returns
    -------
    Verification or None
        Whether the ground truth is that of the protocol; None if its name is unknown. Its ``stated`` belongs in the
        signature.

    Raises
    ------
    ValueError
        If the signs of quaternions are not as stated, which names the argument and the first place, or the ground truth
        has no quaternions.
    """
    signs = stated.get("quaternions")
    if signs in ("continuous", "w>=0"):
        places = _quaternions(gt)
        for name, motion in {"gt": gt, **predictions}.items():
            _check_signs(name, motion[..., places], signs)
    protocol, fps = stated.get("protocol"), stated.get("fps")
    if protocol not in VERIFIED:
        return None
    motion, representation = gt[np.newaxis] if gt.ndim == 2 else gt, stated.get("representation")
    if protocol != lafan1.name:
        if representation == "euler":
            return verify_angles(motion.astype(np.float64), protocol, fps=fps)
        return Verification(protocol=protocol, undecided=("its ground truth is known by Euler angles alone",))
    if representation not in (None, lafan1.fields()["representation"]):
        return Verification(protocol=protocol, undecided=("its ground truth is known by global quaternions alone",))
    try:
        return verify(motion, protocol, fps=fps)
    except ValueError as error:  # other features, which are scored all the same
        return Verification(protocol=protocol, findings=(str(error),))


def _quaternions(gt: Array) -> Array:
    """Return the features ``(J, 4)`` of quaternions: four in succession, of unit length in all frames; or else all."""
    squares = np.square(gt, dtype=np.float64).reshape(-1, gt.shape[-1])
    n = max(0, gt.shape[-1] - 3)
    lengths = np.sqrt(sum(squares[:, i : i + n] for i in range(4)))
    starts: list[int] = []
    for start in np.flatnonzero((np.abs(lengths - 1) <= UNIT).all(axis=0)).tolist():
        if not starts or start >= starts[-1] + 4:
            starts.append(start)
    if not starts and gt.shape[-1] % 4:
        raise ValueError(
            f"gt: expected quaternions, whose signs are stated, got {gt.shape[-1]} features, no four of unit length"
        )
    return np.add.outer(starts or range(0, gt.shape[-1], 4), np.arange(4))


def _check_signs(name: str, motion: Array, signs: str) -> None:
    """Raise a ValueError unless quaternions ``(..., T, J, 4)`` have the signs that the signature states."""
    q = motion.reshape(-1, *motion.shape[-3:])
    if signs == "continuous":
        wrong = (q[:, 1:] * q[:, :-1]).sum(axis=-1) < -_ROUNDING
        mend = "npss.rotations.continuous(..., axis=1) makes them so"
    else:
        wrong, mend = q[..., 0] < 0, "negate those with a negative w; they are taken as w, x, y, z"
    if wrong.any():
        sequence, frame, quaternion = (int(i) for i in np.argwhere(wrong)[0])
        raise ValueError(
            f"{name}: the signs of its quaternions are stated as {signs!r}, but {int(wrong.sum())} are not, the first "
            f"at sequence, frame, quaternion {sequence, frame + (signs == 'continuous'), quaternion}; {mend}"
        )
