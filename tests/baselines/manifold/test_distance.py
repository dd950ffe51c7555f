"""Tests of the distance G: equation 4 and its properties."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from npss_baselines.manifold.applications.distance import extremes, g

pytestmark = pytest.mark.numeric

codes = hnp.arrays(np.float64, (6, 3), elements=st.floats(-1, 1, width=32))


def by_the_equation(code0, code1):
    total = 0.0
    for unit in range(code0.shape[1]):
        for extreme in (max, min):
            total += (extreme(code0[:, unit]) - extreme(code1[:, unit])) ** 2
    return total


class TestG:
    @given(codes, codes)
    def test_equation(self, a, b):
        assert float(g(a, b)) == pytest.approx(by_the_equation(a, b), abs=1e-12)

    @given(codes, codes)
    def test_non_negative_symmetric_and_zero_on_itself(self, a, b):
        assert g(a, b) >= 0
        assert g(a, b) == g(b, a)
        assert g(a, a) == 0

    @given(codes, codes, codes)
    def test_root_obeys_the_triangle_inequality(self, a, b, c):
        assert np.sqrt(g(a, c)) <= np.sqrt(g(a, b)) + np.sqrt(g(b, c)) + 1e-12

    def test_g_violates_the_triangle_inequality(self):
        a, b, c = np.zeros((1, 1)), np.ones((1, 1)), np.full((1, 1), 2.0)
        assert g(a, c) > g(a, b) + g(b, c)

    @given(codes, st.permutations(range(6)))
    def test_order_does_not_matter(self, a, order):
        assert g(a, a[list(order)]) == 0

    @given(codes, st.integers(1, 4))
    def test_repetition_does_not_matter(self, a, times):
        assert g(a, np.tile(a, (times, 1))) == 0

    def test_different_motions_can_have_distance_zero(self):
        a = np.array([[0.0, 0.0], [1.0, 1.0]])
        b = np.array([[0.0, 1.0], [1.0, 0.0]])
        assert g(a, b) == 0

    def test_leading_axes(self):
        rng = np.random.default_rng(0)
        a, b = rng.normal(size=(2, 4, 20, 5)), rng.normal(size=(2, 4, 13, 5))
        distances = g(a, b)
        assert distances.shape == (2, 4)
        for index in np.ndindex(2, 4):
            assert distances[index] == pytest.approx(by_the_equation(a[index], b[index]))

    @pytest.mark.parametrize(
        ("a", "b", "message"),
        [
            (np.zeros(3), np.zeros((2, 3)), r"code0: expected shape \(..., T', H\)"),
            (np.zeros((2, 3)), np.zeros((0, 3)), r"code1: expected shape"),
            (np.zeros((2, 3)), np.zeros((2, 4)), r"code1: shape \(2, 4\) does not match \(2, 3\) of code0"),
            (np.zeros((1, 2, 3)), np.zeros((4, 2, 3)), r"code1: shape"),
            (np.full((2, 3), np.inf), np.zeros((2, 3)), r"code0: inf at index \(0, 0\)"),
        ],
    )
    def test_bad_input(self, a, b, message):
        with pytest.raises(ValueError, match=message):
            g(a, b)

    def test_not_numbers(self):
        with pytest.raises(TypeError, match="code1: expected real numbers"):
            g(np.zeros((2, 3)), [["a"]])


def test_extremes_are_maxima_then_minima():
    code = np.random.default_rng(1).normal(size=(4, 7, 3))
    result = extremes(code)
    assert result.shape == (4, 6)
    for i, unit in np.ndindex(4, 3):
        assert result[i, unit] == max(code[i, :, unit])
        assert result[i, 3 + unit] == min(code[i, :, unit])
