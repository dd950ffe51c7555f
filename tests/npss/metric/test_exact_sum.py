"""Exact sums against fractions."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss._metric import exact_sum as _exact_sum
from npss._metric.exact_sum import UNIT, exact_sum

pytestmark = pytest.mark.numeric

FLOATS = st.lists(st.floats(allow_nan=False, allow_infinity=False), max_size=30)


@given(values=FLOATS)
def test_equals_the_sum_of_fractions(values):
    assert Fraction(exact_sum(np.array(values, np.float64)), 2**UNIT) == sum(map(Fraction, values))


@given(values=st.lists(st.tuples(st.floats(-1e300, 1e300), st.integers(-2148, 2100)), max_size=10))
def test_with_exponents(values):
    terms = np.array([value for value, _ in values], np.float64)
    exponents = np.array([exponent for _, exponent in values], np.int64)
    expected = sum(Fraction(value) * Fraction(2) ** exponent for value, exponent in values)
    assert Fraction(exact_sum(terms, exponents), 2**UNIT) == expected


@given(values=FLOATS, cut=st.integers(0, 30), order=st.randoms())
def test_does_not_depend_on_order_or_grouping(values, cut, order):
    shuffled = list(values)
    order.shuffle(shuffled)
    parts = (np.array(part, np.float64) for part in (shuffled[:cut], shuffled[cut:]))
    assert sum(exact_sum(part) for part in parts) == exact_sum(np.array(values, np.float64))


def test_many_terms_of_any_shape():
    values = np.random.default_rng(0).lognormal(0, 20, size=(300, 70))
    assert Fraction(exact_sum(values), 2**UNIT) == sum(map(Fraction, values.ravel().tolist()))


def test_too_many_terms_are_refused(monkeypatch):
    monkeypatch.setattr(_exact_sum, "_MOST_TERMS", 3)
    with pytest.raises(ValueError, match="at most 3 terms, got 4"):
        exact_sum(np.ones(4))
