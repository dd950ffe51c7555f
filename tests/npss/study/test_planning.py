"""Power and sample size, against statsmodels, the closed form, and simulation."""

import math
import re

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from npss import study

ALTERNATIVES = {"greater": "larger", "less": "smaller", "two-sided": "two-sided"}
PROPORTIONS = st.integers(5, 95).map(lambda percent: percent / 100)


@given(PROPORTIONS, PROPORTIONS, st.integers(5, 500), st.integers(5, 500), st.sampled_from([*ALTERNATIVES]))
def test_power_equals_statsmodels(p_a, p_b, n_a, n_b, alternative):
    from statsmodels.stats.proportion import power_proportions_2indep

    ours = study.power(p_a, p_b, n_a, n_b, alternative=alternative, alpha=0.02, correction=False)
    theirs = power_proportions_2indep(
        p_a - p_b, p_b, n_a, ratio=n_b / n_a, alpha=0.02, alternative=ALTERNATIVES[alternative], return_results=False
    )
    assert ours == pytest.approx(theirs, abs=1e-9)


@pytest.mark.parametrize("correction", [True, False])
@pytest.mark.parametrize(
    ("alternative", "p"), [("greater", (0.8, 0.6)), ("less", (0.35, 0.55)), ("two-sided", (0.5, 0.72))]
)
def test_power_is_the_rate_of_rejection(alternative, p, correction):
    n, options = 60, {"alternative": alternative, "correction": correction}
    rejects = [[study.binomial_test(a, n, b, n, **options).p_value <= 0.05 for b in range(n + 1)] for a in range(n + 1)]
    chance = [stats.binom.pmf(np.arange(n + 1), n, one) for one in p]
    exact = chance[0] @ np.array(rejects) @ chance[1]
    assert study.power(*p, n, **options) == pytest.approx(exact, abs=0.025)
    drawn = np.random.default_rng(2).binomial(n, p, size=(4000, 2))
    simulated = np.array(rejects)[drawn[:, 0], drawn[:, 1]].mean()
    assert simulated == pytest.approx(study.power(*p, n, **options), abs=0.025 + 3 * 0.5 / math.sqrt(4000))


def closed_form(p_a, p_b, power, z_tail, correction):
    """Return the sample size of Fleiss, with the correction of Casagrande, Pike and Smith."""
    mean, difference = (p_a + p_b) / 2, abs(p_a - p_b)
    null, alternative = math.sqrt(2 * mean * (1 - mean)), math.sqrt(p_a * (1 - p_a) + p_b * (1 - p_b))
    n = ((stats.norm.isf(z_tail) * null + stats.norm.ppf(power) * alternative) / difference) ** 2
    return n / 4 * (1 + math.sqrt(1 + 4 / (n * difference))) ** 2 if correction else n


@given(PROPORTIONS, PROPORTIONS, st.sampled_from((0.5, 0.8, 0.95)), st.booleans())
def test_sample_size_is_the_closed_form(p_a, p_b, power, correction):
    if p_a <= p_b:
        return
    n = study.sample_size(p_a, p_b, power=power, correction=correction)
    assert n == math.ceil(closed_form(p_a, p_b, power, 0.05, correction) - 1e-9)
    assert n == study.sample_size(p_b, p_a, power=power, correction=correction, alternative="less")
    assert study.power(p_a, p_b, n, correction=correction) >= power
    assert n == 1 or study.power(p_a, p_b, n - 1, correction=correction) < power
    two_sided = study.sample_size(p_a, p_b, power=power, correction=correction, alternative="two-sided")
    assert n <= two_sided <= math.ceil(closed_form(p_a, p_b, power, 0.025, correction) - 1e-9)


def test_without_a_difference_power_is_the_level():
    for alternative in ALTERNATIVES:
        assert study.power(0.4, 0.4, 50, alternative=alternative, correction=False) == pytest.approx(0.05)


class TestErrors:
    def test_no_size_shows_a_missing_difference(self):
        swap = "; swap the two, or choose the alternative 'two-sided'"
        for p_a, p_b, alternative, wanted, remedy in (
            (0.6, 0.6, "two-sided", "another share than", ""),
            (0.6, 0.6, "greater", "more than", ""),
            (0.5, 0.6, "greater", "more than", swap),
            (0.6, 0.5, "less", "less than", swap),
        ):
            message = (
                f"p_a: expected {wanted} the other share, {p_b}, for the alternative '{alternative}', got {p_a}{remedy}"
            )
            with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
                study.sample_size(p_a, p_b, alternative=alternative)

    def test_no_size_is_astronomical(self):
        assert study.sample_size(0.5 + 1e-5, 0.5) > 1e9
        with pytest.raises(ValueError, match=r"is too close to p_b = 0\.5: .* more than 1099511627776 trials"):
            study.sample_size(0.5 + 1e-7, 0.5)

    @pytest.mark.parametrize(
        ("changed", "error", "message"),
        [
            ({"p_a": 1}, ValueError, "p_a: expected a number between 0 and 1, exclusive, got 1"),
            ({"p_b": "0.5"}, TypeError, "p_b: expected a number between 0 and 1, got '0.5'"),
            ({"alpha": 0}, ValueError, "alpha: expected a number between"),
            ({"alternative": "more"}, ValueError, "alternative: expected one of"),
            ({"correction": None}, TypeError, "correction: expected True or False"),
        ],
    )
    def test_of_both(self, changed, error, message):
        arguments = {"p_a": 0.8, "p_b": 0.6, **changed}
        with pytest.raises(error, match=message):
            study.sample_size(**arguments)
        with pytest.raises(error, match=message):
            study.power(**arguments, n_a=80)

    def test_of_each(self):
        with pytest.raises(ValueError, match="power: expected a number between 0 and 1"):
            study.sample_size(0.8, 0.6, power=1.0)
        for name in ("n_a", "n_b"):
            with pytest.raises(ValueError, match=f"{name}: expected a positive integer, got 0"):
                study.power(0.8, 0.6, **{"n_a": 80, name: 0})
