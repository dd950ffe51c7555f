"""User studies of metrics: plan the questions, count the votes, and test the results.

Most functions need numpy alone; the exact tests and Clopper and Pearson's interval need scipy (extra ``study``).
"""

from npss._analysis.interval import Interval
from npss.study._agreement import Agreement, JointAgreement, agreement, joint_agreement
from npss.study._counterbalance import counterbalance
from npss.study._design import Question, design
from npss.study._files import read_votes, write_votes
from npss.study._intervals import clopper_pearson_interval, wilson_interval
from npss.study._kappa import fleiss_kappa
from npss.study._paired import PairedTest, mcnemar_test
from npss.study._planning import power, sample_size
from npss.study._preference import Preference, preference_tests
from npss.study._ranking import model_scores, predict, rank
from npss.study._two_samples import ProportionTest, binomial_test, boschloo_test, fisher_test
from npss.study._votes import Attention, Count, Vote, attention, count_votes, simulate_votes

__all__ = [
    "Agreement",
    "Attention",
    "Count",
    "Interval",
    "JointAgreement",
    "PairedTest",
    "Preference",
    "ProportionTest",
    "Question",
    "Vote",
    "agreement",
    "attention",
    "binomial_test",
    "boschloo_test",
    "clopper_pearson_interval",
    "count_votes",
    "counterbalance",
    "design",
    "fisher_test",
    "fleiss_kappa",
    "joint_agreement",
    "mcnemar_test",
    "model_scores",
    "power",
    "predict",
    "preference_tests",
    "rank",
    "read_votes",
    "sample_size",
    "simulate_votes",
    "wilson_interval",
    "write_votes",
]
