"""The statistics of a study, against scipy, statsmodels, brute force and simulation."""

import math
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import special, stats

from npss import study

ALTERNATIVES = ("greater", "less", "two-sided")
INDEPENDENT = (study.binomial_test, study.fisher_test, study.boschloo_test)


@st.composite
def counts(draw, most=200):
    n_a, n_b = draw(st.integers(1, most)), draw(st.integers(1, most))
    return draw(st.integers(0, n_a)), n_a, draw(st.integers(0, n_b)), n_b


def table(a, n_a, b, n_b):
    return np.array([[a, n_a - a], [b, n_b - b]])


class TestBinomial:
    @pytest.mark.parametrize(
        ("alternative", "correction", "p"),
        [
            ("greater", True, 1.7087e-5),
            ("greater", False, 8.18e-6),
            ("two-sided", False, 1.64e-5),
            ("two-sided", True, 3.42e-5),
        ],
    )
    def test_the_papers_counts(self, alternative, correction, p):
        test = study.binomial_test(65, 80, 39, 80, alternative=alternative, correction=correction)
        digits = 5 if p == 1.7087e-5 else 3
        assert f"{test.p_value:.{digits}g}" == f"{p:.{digits}g}"
        assert test.alternative == alternative

    @given(counts(), st.booleans())
    def test_two_sided_is_the_chi_squared_test(self, four, correction):
        ours = study.binomial_test(*four, alternative="two-sided", correction=correction)
        if not table(*four).sum(axis=0).all():
            assert (ours.statistic, ours.p_value) == (0, 1)
            return
        theirs = stats.chi2_contingency(table(*four), correction=correction)
        assert ours.statistic**2 == pytest.approx(theirs.statistic, rel=1e-9, abs=1e-12)
        assert ours.p_value == pytest.approx(theirs.pvalue, rel=1e-9)

    @given(counts(), st.sampled_from(("greater", "less")), st.booleans())
    def test_one_sided_as_r_does(self, four, alternative, correction):
        """R: z = sign(difference) * sqrt(chi squared), and the tail of the normal distribution on that side."""
        a, n_a, b, n_b = four
        ours = study.binomial_test(*four, alternative=alternative, correction=correction)
        if a + b in (0, n_a + n_b):
            assert (ours.statistic, ours.p_value) == (0, 1)
            return
        expected = (a + b) / (n_a + n_b) * np.array([n_a, n_b])
        observed = np.array([a, b])
        difference = a / n_a - b / n_b
        yates = min(0.5, abs(difference) / (1 / n_a + 1 / n_b)) if correction else 0.0
        cells = np.concatenate([expected, [n_a, n_b] - expected])
        off = np.abs(np.concatenate([observed, [n_a, n_b] - observed]) - cells)
        z = np.sign(difference) * math.sqrt((np.square(np.maximum(off - yates, 0)) / cells).sum())
        p = stats.norm.sf(z) if alternative == "greater" else stats.norm.cdf(z)
        assert ours.statistic == pytest.approx(z, rel=1e-6, abs=1e-7)
        assert ours.p_value == pytest.approx(p, rel=1e-6)

    @given(counts())
    def test_uncorrected_equals_statsmodels(self, four):
        from statsmodels.stats.proportion import proportions_ztest

        a, n_a, b, n_b = four
        if a + b in (0, n_a + n_b):
            return
        for ours, theirs in (("greater", "larger"), ("less", "smaller"), ("two-sided", "two-sided")):
            z, p = proportions_ztest([a, b], [n_a, n_b], alternative=theirs)
            test = study.binomial_test(*four, alternative=ours, correction=False)
            assert test.statistic == pytest.approx(z, abs=1e-9)
            assert test.p_value == pytest.approx(p, rel=1e-9)

    @pytest.mark.parametrize("alternative", ALTERNATIVES)
    def test_the_correction_does_not_go_beyond_no_difference(self, alternative):
        test = study.binomial_test(40, 80, 40, 81, alternative=alternative)
        assert 0 < test.difference < (1 / 80 + 1 / 81) / 2
        assert test.statistic == 0
        assert test.p_value == (1 if alternative == "two-sided" else 0.5)

    @given(counts(), st.booleans())
    def test_symmetries(self, four, correction):
        a, n_a, b, n_b = four
        one = study.binomial_test(a, n_a, b, n_b, correction=correction)
        swapped = study.binomial_test(b, n_b, a, n_a, alternative="less", correction=correction)
        failures = study.binomial_test(n_a - a, n_a, n_b - b, n_b, alternative="less", correction=correction)
        for other in (swapped, failures):
            assert other.p_value == pytest.approx(one.p_value, rel=1e-9)
            assert other.statistic == pytest.approx(-one.statistic, rel=1e-9)

    def test_keeps_its_digits_far_out_in_the_tail(self):
        test = study.binomial_test(600, 1000, 100, 1000)
        assert 1e-130 < test.p_value < 1e-100
        assert math.log(test.p_value) == pytest.approx(special.log_ndtr(-test.statistic), rel=1e-12)

    def test_p_values_are_uniform_under_the_null(self):
        rng = np.random.default_rng(3)
        draws = rng.binomial(4000, 0.6, size=(1500, 2))
        for alternative in ALTERNATIVES:
            p = [
                study.binomial_test(a, 4000, b, 4000, alternative=alternative, correction=False).p_value
                for a, b in draws
            ]
            assert stats.kstest(p, "uniform").pvalue > 0.01
        # A statistic that is off by a tenth would be seen.
        z = [study.binomial_test(a, 4000, b, 4000, correction=False).statistic for a, b in draws]
        assert stats.kstest(stats.norm.sf(1.1 * np.array(z)), "uniform").pvalue < 0.05


def rejections(test, n, proportions, **options):
    """Return how often, exactly, a test at the level .05 rejects where both samples of n have the same proportion."""
    p_values = [[test(a, n, b, n, **options).p_value for b in range(n + 1)] for a in range(n + 1)]
    rejects = np.array(p_values) <= 0.05
    chances = [stats.binom.pmf(np.arange(n + 1), n, p) for p in proportions]
    return np.array([chance @ rejects @ chance for chance in chances])


@pytest.mark.parametrize("alternative", ["greater", "two-sided"])
def test_exact_tests_never_reject_too_often_and_boschloos_more_often_than_fishers(alternative):
    proportions = (0.2, 0.5, 0.7)
    fisher = rejections(study.fisher_test, 7, proportions, alternative=alternative)
    boschloo = rejections(study.boschloo_test, 7, proportions, alternative=alternative)
    assert (fisher < boschloo).all()
    assert (boschloo <= 0.05).all()


def test_the_corrected_z_test_is_conservative_where_the_uncorrected_one_is_not():
    proportions = (0.3, 0.5, 0.8)
    assert rejections(study.binomial_test, 30, proportions).max() < 0.04
    assert rejections(study.binomial_test, 30, proportions, correction=False).max() > 0.05


class TestFisher:
    @given(counts(40))
    def test_by_the_hypergeometric_distribution(self, four):
        a, n_a, b, n_b = four
        by_chance = stats.hypergeom(n_a + n_b, a + b, n_a)
        assert study.fisher_test(*four).p_value == pytest.approx(by_chance.sf(a - 1), rel=1e-9)
        assert study.fisher_test(*four, alternative="less").p_value == pytest.approx(by_chance.cdf(a), rel=1e-9)
        all_p = by_chance.pmf(np.arange(n_a + 1))
        two = all_p[all_p <= all_p[a] * (1 + 1e-9)].sum()
        assert study.fisher_test(*four, alternative="two-sided").p_value == pytest.approx(two, rel=1e-6)

    def test_known_values(self):
        test = study.fisher_test(65, 80, 39, 80)
        assert f"{test.p_value:.2e}" == "1.36e-05"
        assert test.statistic == pytest.approx(65 * 41 / (15 * 39))

    def test_without_failures(self):
        test = study.fisher_test(3, 3, 4, 4)
        assert test.p_value == 1
        assert math.isnan(test.statistic)


class TestBoschloo:
    @pytest.mark.parametrize("alternative", ["greater", "less"])
    @pytest.mark.parametrize("four", [(7, 8, 2, 9), (3, 10, 8, 10), (1, 6, 1, 5), (6, 6, 1, 7)])
    def test_by_brute_force(self, four, alternative):
        """The largest probability, over all common proportions, of a table that Fisher's p-value calls as extreme."""
        a, n_a, b, n_b = four
        fisher = np.array(
            [
                [study.fisher_test(i, n_a, j, n_b, alternative=alternative).p_value for j in range(n_b + 1)]
                for i in range(n_a + 1)
            ]
        )
        extreme = fisher <= fisher[a, b] * (1 + 1e-9)
        p = np.linspace(0, 1, 2001)
        chance = stats.binom.pmf(np.arange(n_a + 1)[:, None], n_a, p)[:, None] * stats.binom.pmf(
            np.arange(n_b + 1)[:, None], n_b, p
        )
        test = study.boschloo_test(*four, alternative=alternative)
        assert test.p_value == pytest.approx(chance[extreme].sum(axis=0).max(), rel=1e-4)
        assert test.statistic == pytest.approx(fisher[a, b])

    def test_known_value(self):
        assert f"{study.boschloo_test(65, 80, 39, 80).p_value:.1e}" == "7.3e-06"
        assert study.boschloo_test(65, 80, 39, 80, alternative="two-sided").p_value == pytest.approx(
            2 * study.boschloo_test(65, 80, 39, 80).p_value
        )

    @pytest.mark.parametrize("four", [(0, 5, 0, 7), (5, 5, 7, 7)])
    def test_without_variance(self, four):
        test = study.boschloo_test(*four)
        assert (test.statistic, test.p_value) == (1, 1)


class TestMcNemar:
    @given(st.integers(0, 300), st.integers(0, 300), st.sampled_from(ALTERNATIVES))
    def test_is_a_binomial_test(self, only_a, only_b, alternative):
        test = study.mcnemar_test(only_a, only_b, alternative=alternative)
        assert (test.only_a, test.only_b, test.alternative) == (only_a, only_b, alternative)
        if only_a + only_b == 0:
            assert test.p_value == 1
        else:
            expected = stats.binomtest(only_a, only_a + only_b, alternative=alternative).pvalue
            assert test.p_value == pytest.approx(expected, rel=1e-9)

    def test_is_that_of_statsmodels(self):
        from statsmodels.stats.contingency_tables import mcnemar

        theirs = mcnemar([[34, 31], [6, 5]], exact=True)
        assert study.mcnemar_test(31, 6, alternative="two-sided").p_value == pytest.approx(theirs.pvalue, rel=1e-9)

    def test_is_exact_for_many_questions(self):
        assert study.mcnemar_test(5000, 3000).p_value == pytest.approx(
            stats.binomtest(5000, 8000, alternative="greater").pvalue, rel=1e-8
        )
        assert study.mcnemar_test(2000, 0).p_value == 0  # 2**-2000 is below the smallest float

    def test_keeps_its_level_and_finds_more_than_a_test_of_independent_samples(self):
        """Paired answers, simulated: on half of the questions both metrics are right, on the others by chance."""
        rng = np.random.default_rng(1)
        rejected = {}
        for p_a in (0.3, 0.6):
            p_values = []
            for _ in range(1000):
                easy = rng.random(80) < 0.5
                a, b = easy | (rng.random(80) < p_a), easy | (rng.random(80) < 0.3)
                paired = study.mcnemar_test(int((a & ~b).sum()), int((b & ~a).sum()))
                independent = study.binomial_test(int(a.sum()), 80, int(b.sum()), 80)
                p_values.append((paired.p_value, independent.p_value))
            rejected[p_a] = (np.array(p_values) <= 0.05).mean(axis=0)
        assert rejected[0.3][0] <= 0.05
        assert rejected[0.6][0] > rejected[0.6][1] + 0.1


class TestIntervals:
    @given(
        st.integers(1, 300).flatmap(lambda n: st.tuples(st.integers(0, n), st.just(n))),
        st.sampled_from((0.8, 0.95, 0.99)),
    )
    def test_are_those_of_scipy(self, of, level):
        k, n = of
        for ours, method in ((study.wilson_interval, "wilson"), (study.clopper_pearson_interval, "exact")):
            theirs = stats.binomtest(k, n).proportion_ci(level, method)
            assert ours(k, n, level=level) == pytest.approx((theirs.low, theirs.high), abs=1e-9)
        low, high = study.wilson_interval(k, n, level=level)
        assert 0 <= low <= k / n <= high <= 1

    @given(counts())
    def test_of_the_difference_is_that_of_statsmodels(self, four):
        from statsmodels.stats.proportion import confint_proportions_2indep

        a, n_a, b, n_b = four
        theirs = confint_proportions_2indep(a, n_a, b, n_b, method="newcomb", compare="diff", alpha=0.1)
        ours = study.binomial_test(*four, level=0.9)
        assert ours.interval_difference == pytest.approx(theirs, abs=1e-9)
        assert ours.level == 0.9

    @given(counts(15), st.sampled_from(INDEPENDENT))
    def test_are_the_same_with_every_test(self, four, test):
        a, n_a, b, n_b = four
        found = test(*four)
        assert found.interval_a == study.wilson_interval(a, n_a)
        assert found.interval_b == study.wilson_interval(b, n_b)
        assert found.proportion_a == a / n_a
        assert found.proportion_b == b / n_b
        assert found.difference == pytest.approx(a / n_a - b / n_b, abs=1e-15)
        low, high = found.interval_difference
        assert low <= found.difference <= high

    def test_coverage(self):
        """Exact, over a grid of proportions: Wilson's is the level on average, the exact one's the level or more."""
        n, p = 40, np.linspace(0.01, 0.99, 197)
        chance = stats.binom.pmf(np.arange(n + 1)[:, None], n, p)
        coverage = {}
        for interval in (study.wilson_interval, study.clopper_pearson_interval):
            ends = np.array([interval(k, n) for k in range(n + 1)])
            covered = (ends[:, :1] <= p) & (p <= ends[:, 1:])
            coverage[interval] = (chance * covered).sum(axis=0)
        wilson, exact = coverage.values()
        assert wilson.mean() == pytest.approx(0.95, abs=0.005)
        assert 0.85 < wilson.min() < 0.95
        assert exact.min() >= 0.95
        assert exact.mean() > wilson.mean()

    def test_coverage_of_the_difference(self):
        n, p = 25, (0.8, 0.5)
        chance = [stats.binom.pmf(np.arange(n + 1), n, one) for one in p]
        covered = [
            [
                low <= p[0] - p[1] <= high
                for b in range(n + 1)
                for low, high in [study.binomial_test(a, n, b, n).interval_difference]
            ]
            for a in range(n + 1)
        ]
        assert chance[0] @ np.array(covered) @ chance[1] == pytest.approx(0.95, abs=0.02)


class TestErrors:
    @pytest.mark.parametrize("test", [study.binomial_test, study.fisher_test, study.boschloo_test])
    def test_options_are_named(self, test):
        """A fifth number would be an option by accident."""
        with pytest.raises(TypeError, match="positional argument"):
            test(5, 10, 3, 10, "greater")
        assert test(a=5, n_a=10, b=3, n_b=10).p_value == test(5, 10, 3, 10).p_value

    @pytest.mark.parametrize("test", INDEPENDENT)
    @pytest.mark.parametrize(
        ("four", "error", "message"),
        [
            ((5.0, 8, 2, 8), TypeError, "a: expected a whole number, got 5.0"),
            ((True, 8, 2, 8), TypeError, "a: expected a whole number, got True"),
            ((9, 8, 2, 8), ValueError, "a: expected 0 to n_a = 8, got 9"),
            ((5, 8, -1, 8), ValueError, "b: expected 0 to n_b = 8, got -1"),
            ((5, 8, 0, 0), ValueError, "n_b: expected a positive integer, got 0"),
            ((5, "8", 0, 0), TypeError, "n_a: expected a positive integer, got '8'"),
        ],
    )
    def test_counts(self, test, four, error, message):
        with pytest.raises(error, match=message):
            test(*four)

    @pytest.mark.parametrize("test", [*INDEPENDENT, lambda a, _, b, __, **options: study.mcnemar_test(a, b, **options)])
    def test_alternative(self, test):
        with pytest.raises(ValueError, match="alternative: expected one of greater, less, two-sided, got 'larger'"):
            test(5, 8, 2, 8, alternative="larger")

    def test_options(self):
        with pytest.raises(TypeError, match="correction: expected True or False, got 1"):
            study.binomial_test(5, 8, 2, 8, correction=1)
        with pytest.raises(TypeError, match=r"only_a: expected a whole number, got 1\.5"):
            study.mcnemar_test(1.5, 2)
        with pytest.raises(ValueError, match="only_b: expected 0 or more, got -2"):
            study.mcnemar_test(1, -2)

    @pytest.mark.parametrize("interval", [study.wilson_interval, study.clopper_pearson_interval])
    def test_intervals(self, interval):
        with pytest.raises(ValueError, match="successes: expected 0 to n = 4, got 5"):
            interval(5, 4)
        for level, error in ((1, ValueError), (0.0, ValueError), (math.nan, ValueError), ("0.95", TypeError)):
            with pytest.raises(error, match="level: expected a number between 0 and 1"):
                interval(3, 4, level=level)

    @pytest.mark.parametrize("call", [study.fisher_test, study.boschloo_test])
    def test_without_scipy(self, monkeypatch, call):
        monkeypatch.setitem(sys.modules, "scipy.stats", None)
        with pytest.raises(
            ImportError, match=rf"{call.__name__} needs scipy; in the project's folder: pip install '\.\[study\]'"
        ):
            call(5, 8, 2, 8)
        with pytest.raises(ImportError, match="clopper_pearson_interval needs scipy"):
            study.clopper_pearson_interval(5, 8)
        assert study.binomial_test(65, 80, 39, 80).p_value < 2e-5


def test_numpy_numbers_are_accepted():
    four = np.array([65, 80, 39, 80], dtype=np.int8)
    for test in INDEPENDENT:
        assert test(*four) == test(65, 80, 39, 80)
    assert study.mcnemar_test(*four[:2]) == study.mcnemar_test(65, 80)
    assert study.wilson_interval(*four[:2]) == study.wilson_interval(65, 80)


def test_importing_it_imports_only_numpy():
    code = (
        "import sys, npss; before = set(sys.modules); import npss.study, npss.published; "
        "tops = {name.partition('.')[0] for name in set(sys.modules) - before}; "
        "print(*sorted(tops - set(sys.stdlib_module_names) - {'npss', 'numpy'}))"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, encoding="utf-8", check=True)
    assert done.stdout.strip() == ""
