"""The test of a preference, against brute force, scipy and simulation."""

import inspect
import itertools
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import stats

from npss import study
from npss._analysis.holm import holm

ALTERNATIVES = ("two-sided", "greater", "less")


def votes_of(answers, models=("one", "two"), action="gait"):
    """Return votes from text: a string of A, B and - (a tie) for each participant."""
    choices = {"A": "A", "B": "B", "-": "tie"}
    return [
        study.Vote(action, study.Question(number, 0, *models), f"p{i}", choices[choice])
        for i, of_one in enumerate(answers)
        for number, choice in enumerate(of_one, 1)
    ]


def only(votes, **options):
    (preference,) = study.preference_tests(votes, **options)
    return preference


def shares_of(answers):
    decided = [of_one.replace("-", "") for of_one in answers]
    return np.array([of_one.count("A") / len(of_one) for of_one in decided if of_one])


def brute_force(shares, alternative, middle=0.5):
    """Try every flip."""
    away = [share - middle for share in shares]
    sums = [
        sum(s * a for s, a in zip(signs, away, strict=True)) for signs in itertools.product((1, -1), repeat=len(away))
    ]
    observed = sum(away)
    extreme = {
        "two-sided": lambda value: abs(value) >= abs(observed) - 1e-9,
        "greater": lambda value: value >= observed - 1e-9,
        "less": lambda value: value <= observed + 1e-9,
    }[alternative]
    return sum(map(extreme, sums)) / len(sums)


ANSWERS = st.lists(st.text("AB-", min_size=1, max_size=5), min_size=6, max_size=9)


@settings(max_examples=30)
@given(answers=ANSWERS, alternative=st.sampled_from(ALTERNATIVES))
def test_against_every_flip(answers, alternative):
    found, shares = only(votes_of(answers), alternative=alternative), shares_of(answers)
    assert (found.model_a, found.model_b, found.participants) == ("one", "two", len(shares))
    if len(shares) < 6:
        assert found.p_value is found.corrected is None
        assert found.interval == (0, 1)
        return
    assert found.share == pytest.approx(shares.mean())
    assert found.p_value == pytest.approx(brute_force(shares, alternative))
    assert found.method == f"sign-flip test over participants, all {2 ** len(shares)} flips"
    extreme, n = [share for share in shares if share in (0, 1)], len(shares)
    assert found.interval_method == ("Wilson" if 2 * len(extreme) > n else "sign flips")
    if found.interval_method == "Wilson":
        # Its ends are the shares from which the mean is 1.96 standard errors of a proportion away.
        for end in found.interval:
            assert n * (end - shares.mean()) ** 2 == pytest.approx(1.959964**2 * end * (1 - end), abs=1e-6)
        return
    # The interval holds the shares that the two-sided test does not reject.
    for end, outwards in zip(found.interval, (-1, 1), strict=True):
        if 0 < end < 1:
            assert brute_force(shares, "two-sided", end - outwards * 1e-6) > 0.05
            assert brute_force(shares, "two-sided", end + outwards * 1e-6) <= 0.05 + 1e-12


@pytest.mark.parametrize("alternative", ALTERNATIVES)
def test_many_participants_against_scipy(alternative):
    rng = np.random.default_rng(0)
    answers = ["".join(rng.choice(["A", "B"], 4, p=[0.61, 0.39])) for _ in range(28)]
    found = only(votes_of(answers), alternative=alternative)
    new = "rng" in inspect.signature(stats.permutation_test).parameters  # from scipy 1.15 on
    generator = "rng" if new else "random_state"
    theirs = stats.permutation_test(
        (shares_of(answers) - 0.5,),
        np.mean,
        permutation_type="samples",
        alternative=alternative,
        n_resamples=99999,
        **{generator: np.random.default_rng(1)},
    )
    assert found.method == "sign-flip test over participants, 9999 random flips"
    error = math.sqrt(theirs.pvalue * (1 - theirs.pvalue) * (1 / 9999 + 1 / 99999))
    assert found.p_value == pytest.approx(theirs.pvalue, abs=4 * error)
    assert only(votes_of(answers), alternative=alternative) == found
    assert only(votes_of(answers), alternative=alternative, seed=5).p_value != found.p_value


@settings(max_examples=20)
@given(answers=ANSWERS, data=st.data())
def test_sides_repetition_and_ties_do_not_matter(answers, data):
    votes = votes_of(answers)
    found = only(votes)
    mirrored = [
        study.Vote("gait", vote.question.mirrored(), vote.participant, {"A": "B", "B": "A"}.get(vote.choice, "tie"))
        if data.draw(st.booleans())
        else vote
        for vote in votes
    ]
    assert only(mirrored) == found
    assert only(votes + votes_of(answers, action="another")) == found
    assert only(votes + votes_of(["--"] * 9, action="another")) == found
    check = study.Question(9, 0, "ground truth", "ground truth, upside down", "A")
    assert study.preference_tests([*votes, study.Vote("gait", check, "p0", "B")]) == [found]
    other = only(votes_of(answers, models=("one", "an other")))
    assert (other.model_a, other.p_value) == ("an other", found.p_value)
    if found.participants:
        assert other.share == pytest.approx(1 - found.share)
        assert other.interval == pytest.approx((1 - found.interval.high, 1 - found.interval.low))


def test_pairs_are_corrected_together():
    answers = {("a", "b"): ["AAAB"] * 8, ("a", "c"): ["AB"] * 7, ("b", "c"): ["ABBB"] * 6, ("c", "d"): ["A"] * 5}
    votes = [vote for models, of_pair in answers.items() for vote in votes_of(of_pair, models)]
    found = study.preference_tests(votes)
    assert [(one.model_a, one.model_b) for one in found] == list(answers)
    assert [one.p_value for one in found] == [2 / 2**8, 1.0, 2 / 2**6, None]
    assert [one.corrected for one in found] == [*holm([2 / 2**8, 1.0, 2 / 2**6]), None]
    undecided = only(votes_of(["--"] * 8))
    assert (undecided.participants, undecided.p_value) == (0, None)
    assert math.isnan(undecided.share)
    assert study.preference_tests([]) == []


def test_error_rates_where_tastes_differ():
    """Nobody is preferred on average, but each participant has a taste: its logit has a standard deviation of 1.41."""
    rng = np.random.default_rng(0)
    participants, questions, studies = 14, 4, 500
    wrong = pooled = 0
    for _ in range(studies):
        taste = 1 / (1 + np.exp(-1.41 * rng.standard_normal(participants)))
        first = rng.random((participants, questions)) < taste[:, np.newaxis]
        answers = ["".join("BA"[choice] for choice in of_one) for of_one in first.astype(int)]
        wrong += only(votes_of(answers)).p_value <= 0.05
        pooled += stats.binomtest(int(first.sum()), first.size).pvalue <= 0.05
    # Four standard errors above the level; an exact test is below the level, one that errs twice as often is not.
    most = 0.05 + 4 * math.sqrt(0.05 * 0.95 / studies)
    assert 0.01 < wrong / studies <= most
    assert pooled / studies > most


@pytest.mark.parametrize("participants", [8, 12, 30])
def test_coverage_of_one_answer_each(participants):
    """The chance that the interval holds the true share, exactly: a sum over the numbers of answers for A."""
    counts = np.arange(participants + 1)
    low, high = np.transpose([only(votes_of(["A"] * k + ["B"] * (participants - k))).interval for k in counts])
    for share in (0.5, 0.6, 0.7, 0.8, 0.9, 0.95):
        # Wilson's interval holds some shares slightly less often than its level.
        assert stats.binom.pmf(counts, participants, share)[(low <= share) & (share <= high)].sum() > 0.925


@pytest.mark.parametrize("answers", [2, 8])
@pytest.mark.parametrize(("share", "concentration"), [(0.9, 0.5), (0.8, 2.0), (0.95, np.inf)])
def test_coverage_of_strong_tastes(answers, share, concentration):
    """Of eight participants, whose tastes have a beta distribution."""
    rng, studies, held = np.random.default_rng(0), 200, 0
    for _ in range(studies):
        taste = share if math.isinf(concentration) else rng.beta(share * concentration, (1 - share) * concentration, 8)
        firsts = rng.binomial(answers, taste, 8)
        low, high = only(votes_of(["A" * k + "B" * (answers - k) for k in firsts])).interval
        held += low <= share <= high
    assert held / studies > 0.95 - 4 * math.sqrt(0.95 * 0.05 / studies)


@pytest.mark.parametrize("answers", [1, 4])
def test_all_who_agree_leave_doubt(answers):
    assert only(votes_of(["A" * answers] * 6)).interval == study.wilson_interval(6, 6)


def test_errors():
    votes = votes_of(["AB"] * 6)
    for options, message in (
        ({"alternative": "both"}, "alternative: "),
        ({"level": 1.0}, "level: expected a number between 0 and 1"),
        ({"seed": -1}, "seed: "),
    ):
        with pytest.raises(ValueError, match=message):
            study.preference_tests(votes, **options)
    with pytest.raises(TypeError, match="level: "):
        study.preference_tests(votes, level="high")
    with pytest.raises(ValueError, match="votes: expected a choice of A, B, tie, got 'C'"):
        study.preference_tests([study.Vote("gait", study.Question(1, 0, "one", "two"), "p", "C")])
