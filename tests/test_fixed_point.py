"""The fast reader reads what numpy.loadtxt reads, to the bit, or declines."""

import io

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from baselines.data import fixed_point
from baselines.data.fixed_point import read_fixed_point

NUMBERS = st.integers(-(10**13), 10**13).map(lambda n: f"{n / 1e7:.7f}") | st.sampled_from(
    ["0.0000000", "-0.0000000", "9.9999999", "-10.0000000", "00.5000000"]
)
ROWS = st.lists(st.lists(NUMBERS, min_size=3, max_size=3), min_size=1, max_size=6)


def loadtxt(text):
    return np.loadtxt(io.BytesIO(text), dtype=np.float32, delimiter=",", comments=None, ndmin=2)


@given(rows=ROWS, ends=st.booleans())
def test_equals_loadtxt_to_the_bit(rows, ends):
    text = "\n".join(",".join(row) for row in rows).encode() + (b"\n" if ends else b"")
    read = read_fixed_point(text, 3)
    np.testing.assert_array_equal(read.view(np.uint32), loadtxt(text).view(np.uint32))


@given(rows=ROWS, data=st.data())
def test_declines_or_is_right_whatever_a_byte_is_changed_to(rows, data):
    text = bytearray("\n".join(",".join(row) for row in rows).encode())
    text[data.draw(st.integers(0, len(text) - 1))] = data.draw(st.sampled_from(b",\n.-+ /:09aeE\r\x00\x80\xff"))
    read = read_fixed_point(bytes(text), 3)
    if read is not None:
        np.testing.assert_array_equal(read, loadtxt(bytes(text)))


def test_several_blocks(monkeypatch):
    values = np.random.default_rng(0).normal(scale=5, size=(200, 7))
    text = "\n".join(",".join(f"{value:.7f}" for value in row) for row in values).encode()
    expected = loadtxt(text)
    for size in (1, 80, 1000, 10**6):
        monkeypatch.setattr(fixed_point, "_BLOCK", size)
        np.testing.assert_array_equal(read_fixed_point(text, 7), expected)


@pytest.mark.parametrize(
    "text",
    [b"", b"\n", b"1.0000000,2.0000000\n", b"1.0,2.0,3.0\n", b"1.0000000,,3.0000000\n",
     b"1.0000000\n2.0000000,3.0000000\n",
     b".5000000,0.5000000,0.5000000\n", b"--.5000000,0.5000000,0.5000000\n", b"1-0.5000000,0.5000000,0.5000000\n",
     b"0.5000000,0.5000000,123456789012.5000000\n", b"0.5000000,0.5000000,nan.0000000\n",
     b"-.0000000,1.0000000,2.0000000"],
)  # fmt: skip
def test_declines(text):
    assert read_fixed_point(text, 3) is None
