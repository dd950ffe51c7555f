"""Preference for one of two models: a test with the participant as the unit."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from npss._analysis.holm import holm
from npss._analysis.interval import Interval
from npss._analysis.sign_flip import MIN_BLOCKS_OF_TEST, SAMPLES, sign_flips
from npss.study._input import ALTERNATIVES, Alternative, fraction
from npss.study._intervals import wilson_of_sum
from npss.study._votes import Vote, check_choice
from npss.validation import Float64, Seed, generator, one_of


@dataclass(frozen=True, kw_only=True)
class Preference:
    """How much participants prefer one model to another.

    Attributes
    ----------
    model_a, model_b : str
        The two models, in alphabetical order.
    participants : int
        The number of participants who decided for one of the two at least once.
    share : float
        The mean of their shares of answers for A, each of the participant's answers without ties; NaN if there are no
        participants.
    interval : Interval
        The confidence interval of the share: 0 to 1 for fewer than six participants.
    interval_method : {'sign flips', 'Wilson'}
        How it is made. ``'sign flips'``: the shares that the two-sided test does not reject. ``'Wilson'``, where most
        participants have a share of 0 or 1, such as all who decided once: Wilson's interval with the participants as
        trials, which does not follow from the test and may exclude 1/2 where its p-value is above 1 - level, or the
        reverse.
    level : float
        Confidence level of the interval, which is not corrected.
    method : str
        The name of the test.
    alternative : {'two-sided', 'greater', 'less'}
        The alternative to a share of 1/2.
    p_value : float or None
        The p-value; None for fewer than six participants, who cannot show a preference.
    corrected : float or None
        The p-value by Holm's correction over all pairs with a p-value.

    Examples
    --------
    >>> from npss import study
    >>> question = study.Question(1, 4, "GRU-d", "VGRU-d")
    >>> (preference,) = study.preference_tests([study.Vote("walking", question, f"p{i}", "B") for i in range(8)])
    >>> preference.model_a, preference.share, preference.p_value
    ('GRU-d', 0.0, 0.0078125)
    """

    model_a: str
    model_b: str
    participants: int
    share: float
    interval: Interval
    interval_method: Literal["sign flips", "Wilson"]
    level: float
    method: str
    alternative: Alternative
    p_value: float | None
    corrected: float | None


def preference_tests(
    votes: Sequence[Vote], *, alternative: Alternative = "two-sided", level: float = 0.95, seed: Seed = 0
) -> list[Preference]:
    """Test for each pair of models which one participants prefer, by flipping signs.

    The unit is the participant, whose answers depend on each other: a test of pooled votes takes a few people of strong
    taste for many who agree. Each participant counts by the share of answers for A, however many these are. If there is
    no preference, a share is as likely to be as far above 1/2 as below; the p-value is the share of flips, participant
    by participant, that move the mean at least as far from 1/2. Up to 16 participants, all flips are tried; beyond
    that, 9999 random ones.

    Parameters
    ----------
    votes : sequence of Vote
        Votes from `read_votes`, on any actions. Attention checks are left out, and so are ties.
    alternative : {'two-sided', 'greater', 'less'}, optional
        Whether A is preferred to B or B to A, only A to B, or only B to A.
    level : float, optional
        Confidence level of the intervals.
    seed : int or numpy.random.Generator, optional
        The seed of the generator that draws flips, if not all are tried.

    Returns
    -------
    list of Preference
        The result for each pair of models in the votes, sorted by their names.

    Raises
    ------
    TypeError, ValueError
        If a choice is not A, B or tie, or an option is not one of its values.

    Notes
    -----
    The test speaks of these motions: participants are drawn from a population, the questions are not. It is exact if
    the tastes of participants are distributed symmetrically about no preference.

    Its interval presumes shares distributed symmetrically about the true one. Those of few answers or strong tastes are
    not: of 8 participants who answer once and of whom 90 % prefer A, it would hold .9 in 57 % of studies, and Wilson's
    does in 96 %.

    References
    ----------
    R. A. Fisher, "The Design of Experiments", 1935, section 21. E. B. Wilson, "Probable Inference, the Law of
    Succession, and Statistical Inference", JASA 22, 1927 (the interval of coarse shares).

    Examples
    --------
    >>> from npss import study
    >>> survey = study.design(["GRU-d", "VGRU-d"], range(8), 4, seed=0)
    >>> votes = study.simulate_votes(survey, {"GRU-d": 0.0, "VGRU-d": 1.0}, 12, action="walking", seed=1)
    >>> (preference,) = study.preference_tests(votes)
    >>> round(preference.share, 3), round(preference.p_value, 4)
    (0.292, 0.0078)
    """
    one_of("alternative", alternative, ALTERNATIVES)
    fraction("level", level)
    generator(seed)
    shares = _shares(votes)
    preferences = [_preference(*models, shares[models], alternative, level, seed) for models in sorted(shares)]
    tested = [(i, of.p_value) for i, of in enumerate(preferences) if of.p_value is not None]
    for (i, _), corrected in zip(tested, holm([p for _, p in tested]), strict=True):
        preferences[i] = replace(preferences[i], corrected=corrected)
    return preferences


def _shares(votes: Sequence[Vote]) -> dict[tuple[str, str], Float64]:
    """Return each participant's share of answers for the first model, by pair of models in alphabetical order."""
    answers: dict[tuple[str, str], dict[str, list[bool]]] = {}
    for vote in votes:
        check_choice(vote)
        question = vote.question
        if question.expected:
            continue
        shown = question.model_a, question.model_b
        models = min(shown), max(shown)
        of_pair = answers.setdefault(models, {})
        if vote.choice != "tie":
            chosen = shown[vote.choice == "B"]
            of_pair.setdefault(vote.participant, []).append(chosen == models[0])
    return {
        models: np.array([sum(of) / len(of) for of in of_pair.values()], dtype=np.float64)
        for models, of_pair in answers.items()
    }


def _preference(a: str, b: str, shares: Float64, alternative: Alternative, level: float, seed: Seed) -> Preference:
    """Test the shares of one pair."""
    n = len(shares)
    method, p_value, interval = "sign-flip test over participants", None, Interval(0.0, 1.0)
    interval_method: Literal["sign flips", "Wilson"] = "sign flips"
    if n >= MIN_BLOCKS_OF_TEST:
        flips = sign_flips(shares - 0.5, np.ones(n), seed=seed)
        method += f", all {2**n} flips" if flips.exact else f", {SAMPLES} random flips"
        p_value = (
            flips.p_value() if alternative == "two-sided" else flips.one_sided(1 if alternative == "greater" else -1)
        )
        if np.isin(shares, (0.0, 1.0)).sum() > n / 2:
            interval_method, interval = "Wilson", wilson_of_sum(float(shares.sum()), n, level=level)
        else:
            low, high = flips.interval(level)
            interval = Interval(max(0.0, 0.5 + low), min(1.0, 0.5 + high))
    return Preference(
        model_a=a,
        model_b=b,
        participants=n,
        share=float(shares.mean()) if n else math.nan,
        interval=interval,
        interval_method=interval_method,
        level=level,
        method=method,
        alternative=alternative,
        p_value=p_value,
        corrected=None,
    )
