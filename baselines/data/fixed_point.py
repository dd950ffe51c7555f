"""Read comma-separated numbers of seven decimals, as Human3.6M's files hold them, several times faster than in general.

All the numbers of a block are read at once. One ends before each separator; the eight bytes that lie before it are one
64-bit word: the point and the seven decimals. With the digit before the point put in the point's place, the word
is an eight-digit integer, whose digits are joined in pairs, then fours, then all eight.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

_BLOCK = 2**18  # bytes read at once: what is made of them stays in cache
_PAD = b"0" * 16  # so that there are sixteen bytes before the first separator, too
_ZEROS = np.uint64(0x3030303030303030)  # "00000000"
_NINES = np.uint64(0x4646464646464646)  # carries digits beyond "9" into the highest bit of their byte
_POINT = np.uint64(ord("."))
_BYTE = np.uint64(0xFF)
_HIGH = np.uint64(0x8080808080808080)
_JOIN = (  # digits to pairs, pairs to fours, fours to eight: the mask, the factor and the shift of each step
    (np.uint64(0x0F0F0F0F0F0F0F0F), np.uint64(10 * 2**8 + 1), np.uint64(8)),
    (np.uint64(0x00FF00FF00FF00FF), np.uint64(100 * 2**16 + 1), np.uint64(16)),
    (np.uint64(0x0000FFFF0000FFFF), np.uint64(10000 * 2**32 + 1), np.uint64(32)),
)


def read_fixed_point(text: bytes, columns: int) -> npt.NDArray[np.float32] | None:
    r"""Return the rows of a text, or None if it is not made of rows of numbers with seven decimals.

    Parameters
    ----------
    text : bytes
        Lines of `columns` numbers such as ``-0.1234567``, separated by commas.
    columns : int
        How many there must be in every row.

    Returns
    -------
    (T, columns) ndarray of float32, or None
        The float32 nearest to the float64 nearest to the digits, as ``numpy.loadtxt`` reads them. None says nothing
        about what is wrong, and nothing need be: other notations are left to other readers.

    Examples
    --------
    >>> read_fixed_point(b"0.5000000,-1.2500000\n12.0000000,0.0000000\n", 2)
    array([[ 0.5 , -1.25],
           [12.  ,  0.  ]], dtype=float32)
    >>> read_fixed_point(b"0.5,1e3\n", 2) is None
    True
    """
    if not text.endswith(b"\n"):
        text += b"\n"
    padded = np.frombuffer(_PAD + text, np.uint8)
    parts = []
    start = 0
    while start < len(text):
        stop = text.index(b"\n", min(start + _BLOCK, len(text) - 1)) + 1
        numbers = _read_block(padded[start : stop + len(_PAD)], columns)
        if numbers is None:
            return None
        parts.append(numbers)
        start = stop
    return np.concatenate(parts)


def _read_block(padded: npt.NDArray[np.uint8], columns: int) -> npt.NDArray[np.float32] | None:
    """Read whole lines, before which there are sixteen bytes of anything."""
    ends = np.flatnonzero(padded[len(_PAD) :] < ord("-"))  # commas and line ends; any other such byte is found below
    lengths = np.diff(ends, prepend=-1) - 1
    ends += len(_PAD)
    separators = padded[ends]
    if ends.size % columns or not np.array_equal(separators == ord("\n"), np.arange(1, ends.size + 1) % columns == 0):
        return None
    # As records of two words, which are gathered whole; unaligned integers would all be copied into alignment first.
    words = np.ndarray((padded.size - 15,), "V16", padded, strides=(1,))[ends - 16].view("<u8").reshape(-1, 2)
    before, digits = words[:, 0], words[:, 1] ^ _POINT
    wrong = digits & _BYTE  # where there was no point
    digits |= before >> np.uint64(56)
    wrong |= (digits + _NINES) & _HIGH
    wrong |= (digits - _ZEROS) & _HIGH
    if wrong.any():
        return None
    for mask, factor, shift in _JOIN:
        digits &= mask
        digits *= factor
        digits >>= shift
    values = digits.astype(np.float64)
    values /= 1e7
    long = lengths != len("0.0000000")
    signed = ((before >> np.uint64(48)) & _BYTE) == ord("-")
    signed &= lengths == len("-0.0000000")
    np.negative(values, out=values, where=signed)
    long &= ~signed
    if long.any():  # numbers of ten and more, or nonsense: few
        exact = _read_long(padded, ends[long], lengths[long])
        if exact is None:
            return None
        values[long] = exact
    return values.astype(np.float32).reshape(-1, columns)


def _read_long(
    padded: npt.NDArray[np.uint8], ends: npt.NDArray[np.intp], lengths: npt.NDArray[np.intp]
) -> npt.NDArray[np.float64] | None:
    """Read numbers with more than one digit before the point, of at most sixteen bytes."""
    if lengths.max() > 16:
        return None
    rows = padded[ends[:, np.newaxis] + np.arange(-16, 0)]  # (n, 16)
    rows[np.arange(16) < 16 - lengths[:, np.newaxis]] = ord("0")  # what belongs to the number before
    first = 16 - lengths
    signed = rows[np.arange(len(rows)), first] == ord("-")
    rows[np.flatnonzero(signed), first[signed]] = ord("0")
    digits = np.delete(rows, -8, axis=1)  # without the point, which was found there
    if ((digits < ord("0")) | (digits > ord("9"))).any() or (lengths < len("0.0000000") + signed).any():
        return None
    values: npt.NDArray[np.float64] = rows.view("S16").ravel().astype(np.float64)
    np.negative(values, out=values, where=signed)
    return values
