"""Read and write Euler angles in the 24 sequences and in the Human3.6M convention.

With the half angles a, b, c of an intrinsic sequence i, j, k (e = 1 if i, j, k are in cyclic order, else -1), the
products of three elementary quaternions are, as complex numbers,

    P = (w + e q_j) + i (q_i + q_k) = (cos b + e sin b) exp i(a + c)        i, j, k different
    Q = (w - e q_j) + i (q_i - q_k) = (cos b - e sin b) exp i(a - c)

    P = w + i q_i     = cos b exp i(a + c)                                 i = k, and m the axis left over
    Q = q_j + i e q_m = sin b exp i(a - c)

so the outer angles are arg(P Q) and arg(P conj(Q)), for a quaternion of any length. Rounding in P and Q moves both
angles together. So the rotation is reproduced even near gimbal lock (P = 0 or Q = 0), where the textbook formula on
matrix entries fails.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from npss.rotations._blocks import Columns, require_finite
from npss.rotations._forms import Form, Quaternion
from npss.validation import Array, one_of

#: The Human3.6M convention: the angles of "XYZ", negated.
H36M = "h36m"

_LETTERS = ["".join(s) for s in product("XYZ", repeat=3) if s[0] != s[1] != s[2]]
#: All values of `seq`.
SEQUENCES = (H36M, *_LETTERS, *map(str.lower, _LETTERS))

#: Ratio of |P| and |Q|, in machine epsilons, below which a rotation counts as gimbal lock.
_LOCK = 8.0

#: Real and imaginary parts.
_Complex = tuple[Array, Array]


@dataclass(frozen=True)
class EulerSequence:
    """A parsed sequence of axes."""

    axes: tuple[int, int, int]  # i, j and k of the intrinsic sequence; i, j and m if i = k
    cyclic: int
    proper: bool
    reverse: bool  # extrinsic: the intrinsic sequence read backwards
    negate: bool


def euler_form(seq: str) -> Form:
    """Return the form of the sequence `seq`, or raise as `one_of` does."""
    sequence = euler_sequence(seq)
    return Form((3,), _reader(sequence), _writer(sequence))


def euler_sequence(seq: str) -> EulerSequence:
    """Parse the sequence `seq`, or raise as `one_of` does."""
    one_of("seq", seq, SEQUENCES)
    letters = "XYZ" if seq == H36M else seq
    extrinsic = letters.islower()
    i, j, k = ("XYZ".index(letter) for letter in letters.upper()[:: -1 if extrinsic else 1])
    cyclic = 1 if (j - i) % 3 == 1 else -1
    proper = i == k
    return EulerSequence((i, j, 3 - i - j if proper else k), cyclic, proper, extrinsic, seq == H36M)


def _reader(sequence: EulerSequence) -> Callable[[Columns, np.dtype[Any]], Quaternion]:
    e = sequence.cyclic

    def read(columns: Columns, given: np.dtype[Any]) -> Quaternion:
        require_finite(columns)
        halves = [column * (-0.5 if sequence.negate else 0.5) for column in columns]
        if sequence.reverse:
            halves.reverse()
        (ca, cb, cc), (sa, sb, sc) = map(np.cos, halves), map(np.sin, halves)
        cacc, sasc, sacc, casc = ca * cc, sa * sc, sa * cc, ca * sc
        if sequence.proper:
            w, qi = cb * (cacc - sasc), cb * (sacc + casc)
            qj, qk = sb * (cacc + sasc), e * sb * (sacc - casc)
        else:
            sb_e = e * sb
            w, qi = cb * cacc - sb_e * sasc, cb * sacc + sb_e * casc
            qj, qk = sb * cacc - e * cb * sasc, cb * casc + sb_e * sacc
        parts = qi, qj, qk
        x, y, z = (parts[sequence.axes.index(axis)] for axis in range(3))
        return w, x, y, z

    return read


def _writer(sequence: EulerSequence) -> Callable[[Quaternion, Columns], None]:
    i, j, k = sequence.axes
    e = sequence.cyclic
    add = np.add if e == 1 else np.subtract

    def write(quaternion: Quaternion, outputs: Columns) -> None:
        w, *vector = quaternion
        qi, qj, qk = vector[i], vector[j], vector[k]
        first, middle, last = outputs[::-1] if sequence.reverse else outputs
        if sequence.proper:
            p, q = (w + 0 * qi, qi), (qj, e * qk)
            p_length, q_length = _length(*p), _length(*q)
            np.arctan2(q_length, p_length, out=middle)
            np.multiply(middle, 2, out=middle)
        else:
            p_re, q_re = (w + qj, w - qj)[::e]
            p, q = (p_re, qi + qk), (q_re, qi - qk)
            p_length, q_length = _length(*p), _length(*q)
            sine = add(w * qj, qi * qk)
            sine *= 2
            np.arctan2(_signed(sine, sequence.negate), p_length * q_length, out=middle)
        near, far = np.minimum(p_length, q_length), np.maximum(p_length, q_length)
        far *= _LOCK * np.finfo(far.dtype).eps
        locked = near <= far
        if locked.any():
            p_lost = locked & (p_length < q_length)
            p, q = _unlocked(p, q, p_lost, locked & ~p_lost, -1 if sequence.reverse else 1)

        rr, ii = p[0] * q[0], p[1] * q[1]
        ri, ir = p[0] * q[1], p[1] * q[0]
        np.arctan2(_signed(ir + ri, sequence.negate), rr - ii, out=first)
        ir -= ri
        rr += ii
        np.arctan2(_signed(ir, sequence.negate), rr, out=last)

    return write


def _signed(values: Array, negate: bool) -> Array:
    """Negate on request, and turn -0.0 into 0.0: half a turn is pi, not -pi, for any sign of the zeros."""
    if negate:
        return np.subtract(0, values, out=values)
    return np.add(values, 0, out=values)


def _length(re: Array, im: Array) -> Array:
    length = re * re
    length += im * im
    np.sqrt(length, out=length)
    return length


def _unlocked(p: _Complex, q: _Complex, p_lost: Array, q_lost: Array, sign: int) -> tuple[_Complex, _Complex]:
    """Choose the undefined direction of p or q so that the last angle (the first for sign -1) is zero."""
    return (
        (np.where(p_lost, q[0], p[0]), np.where(p_lost, sign * q[1], p[1])),
        (np.where(q_lost, p[0], q[0]), np.where(q_lost, sign * p[1], q[1])),
    )
