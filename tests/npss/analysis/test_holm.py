"""Holm's correction against its definition by closed testing, and against statsmodels."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from npss._analysis.holm import holm


@given(p=st.lists(st.floats(0, 1), max_size=8))
def test_holm_is_bonferroni_for_every_set_of_hypotheses(p):
    """Closed testing: of all sets that a hypothesis belongs to, the one in which it is hardest to reject."""
    sets = [chosen for n in range(1, len(p) + 1) for chosen in itertools.combinations(range(len(p)), n)]
    bonferroni = {chosen: min(1.0, len(chosen) * min(p[i] for i in chosen)) for chosen in sets}
    expected = [max(bonferroni[chosen] for chosen in sets if i in chosen) for i in range(len(p))]
    np.testing.assert_allclose(holm(p), expected, rtol=1e-12)


def test_holm_equals_statsmodels():
    multitest = pytest.importorskip("statsmodels.stats.multitest")
    p = [0.04, 0.001, 0.012, 0.8, 0.012, 1.0, 0.0, 0.03, 0.3, 0.5, 0.009, 0.02]
    for n in (1, 2, 5, 12):  # few: a call takes a tenth of a second
        np.testing.assert_allclose(holm(p[:n]), multitest.multipletests(p[:n], method="holm")[1], rtol=1e-12)
