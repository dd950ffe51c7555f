"""Ranks, marks and errors of leaderboards; test_leaderboard.py has their output."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest

import npss
from npss._analysis.fingerprint import fingerprint
from npss._analysis.holm import holm
from npss.ranking._results import Result, result_of_report
from npss.ranking._standings import notes, standings


def result(
    model,
    parts,
    *,
    weight=1.0,
    action="walking",
    column="NPSS paper",
    source="",
    signature="npss|version:1",
    fingerprint=None,
    groups=None,
):
    """A result of which the sequences add `parts`; a number alone has no known sequences."""
    named = {"model": model, "action": action, "column": column, "source": source, "signature": signature}
    if isinstance(parts, float):
        return Result(value=parts, **named)
    numerator = np.array(parts, float)
    weights = np.broadcast_to(weight, numerator.shape).astype(float)
    value = numerator.sum() / weights.sum()
    return Result(value=value, numerator=numerator, weight=weights, fingerprint=fingerprint, groups=groups, **named)


def by_model(found):
    return {one.result.model: one for one in found}


def test_a_clear_difference_is_marked_and_ranked():
    rng = np.random.default_rng(0)
    hard = rng.normal(5, 1, 12)  # some sequences are harder than others, which pairing takes out
    found = by_model(standings([result("good", hard), result("bad", hard + rng.uniform(0.1, 0.2, 12))]))
    assert (found["good"].rank, found["good"].best, found["good"].worse) == (1, True, False)
    assert (found["bad"].rank, found["bad"].best, found["bad"].worse) == (2, False, True)
    assert found["bad"].p_value == 2 / 2**12
    assert found["good"].p_value is None  # it is the one that the others are compared with


def test_where_higher_is_better_ranks_and_marks_are_those_of_the_negative_numbers():
    rng = np.random.default_rng(3)
    hard = rng.normal(5, 1, 12)
    parts = {"good": hard + rng.uniform(0.1, 0.2, 12), "bad": hard, "worst": hard - rng.uniform(0.1, 0.2, 12)}
    higher = [replace(result(name, values), lower_is_better=False) for name, values in parts.items()]
    lower = [result(name, 20 - values) for name, values in parts.items()]
    found, mirrored = by_model(standings(higher)), by_model(standings(lower))
    for name in parts:
        for trait in ("rank", "best", "worse", "p_value", "behind"):
            assert getattr(found[name], trait) == getattr(mirrored[name], trait)
    assert [found[name].rank for name in parts] == [1, 2, 3]


def test_only_the_euler_error_leaves_sequences_out_since_nothing_moves():
    weight = np.array([1.0] * 11 + [0.0])
    for heading, said in (("Euler error", True), ("Coverage", False), ("NPSS", False)):
        found = standings([replace(result("a", weight, weight=weight), heading=heading)])
        assert ("no Euler error for 1 of 12 sequences" in " ".join(notes(found))) == said


def test_times_of_two_metrics_are_no_title_of_their_columns():
    one = standings([replace(result("a", 1.0), heading="Euler error", unit="rad", time="80 ms")])
    speed = standings([replace(result("a", 1.0, column="Speed"), heading="Speed", unit="rad/s")])
    assert [line for line in notes([*speed, *one]) if " in rad" in line] == [
        "Under ms: Euler error, in rad.",
        "Speed: in rad/s.",
    ]
    both = standings(
        [replace(result("a", 1.0, column=h), heading=h, unit="rad", time="80 ms") for h in ("Euler error", "MPJPE")]
    )
    text = " ".join(notes(both))
    assert "Under ms" not in text
    assert "Euler error: in rad." in text
    assert "MPJPE: in rad." in text


def test_noise_shares_a_rank_and_is_not_marked():
    parts = np.random.default_rng(1).normal(5, 1, (2, 8))
    found = by_model(standings([result("a", parts[0]), result("b", parts[1])]))
    assert {one.rank for one in found.values()} == {1}
    assert not any(one.worse for one in found.values())
    assert sum(one.best for one in found.values()) == 1


def test_ranks_are_one_plus_the_significantly_better_models():
    rng = np.random.default_rng(2)
    parts = {f"m{k}": 5 + 0.4 * k + rng.normal(0, 0.5, 10) for k in range(5)}
    found = by_model(standings([result(name, values) for name, values in parts.items()]))
    pairs = list(itertools.combinations(parts, 2))
    raw = [npss._analysis.sign_flip.sign_flips(parts[a] - parts[b], np.ones(10)).p_value() for a, b in pairs]
    corrected = dict(zip(pairs, holm(raw), strict=True))
    for name, values in parts.items():
        better = sum(
            other.mean() < values.mean() and min(corrected.get((name, o), 1), corrected.get((o, name), 1)) <= 0.05
            for o, other in parts.items()
            if o != name
        )
        assert found[name].rank == 1 + better
    assert len({one.rank for one in found.values()}) > 1  # or nothing was tested


def test_more_models_need_more_to_differ():
    hard = np.random.default_rng(3).normal(5, 1, 8)
    some = {f"m{k}": hard + 0.5 * k for k in range(4)}  # each sequence agrees: p = 2 / 256
    found = standings([result(name, parts) for name, parts in some.items()])
    assert [one.rank for one in found] == [1, 2, 3, 4]  # 6 pairs: 6 * .0078 = .047
    found = standings([*[one.result for one in found], result("m4", hard + 2)])
    assert {one.rank for one in found} == {1}  # 10 pairs: .078
    (said,) = (line for line in notes(found) if "cannot show" in line)
    assert said.startswith("walking: 8 blocks cannot show any difference between 5 models")
    assert "0.0078" in said
    assert "0.005" in said


def test_without_sequences_ranks_go_by_value_and_only_equal_values_tie():
    values = {"a": 1.0, "b": 2.0, "c": 1.0 + 1e-15, "d": 3.0}
    found = by_model(standings([result(name, value) for name, value in values.items()]))
    assert {name: one.rank for name, one in found.items()} == {"a": 1, "c": 1, "b": 3, "d": 4}
    assert [name for name, one in found.items() if one.best] == ["a", "c"]
    assert all(one.low is None and one.p_value is None and not one.worse for one in found.values())
    assert any("ranked by value" in line for line in notes(list(found.values())))


def test_other_numbers_of_sequences():
    with pytest.raises(ValueError, match=r"'a' and 'b' have 4 and 3 sequences, so they cannot be compared"):
        standings([result("a", [1, 2, 3, 4]), result("b", [1, 2, 3])])


def test_a_single_model_is_not_called_the_best():
    (one,) = standings([result("alone", [1, 2, 3, 4])])
    assert (one.rank, one.best) == (1, False)


def test_published_numbers_are_neither_ranked_nor_best():
    found = by_model(standings([result("mine", 2.0), result("theirs", 1.0, source="Somebody 2019, Table 4")]))
    assert (found["theirs"].rank, found["theirs"].best) == (None, False)
    assert found["mine"].rank == 1
    assert any("Somebody 2019, Table 4" in line for line in notes(list(found.values())))
    only = standings([result("theirs", 1.0, source="Somebody")])
    assert only[0].rank is None


def test_a_published_model_may_share_the_name_of_another():
    found = standings([result("VGRU-d", 2.0), result("VGRU-d", 1.0, source="Somebody")])
    assert [one.rank for one in found] == [1, None]


def test_intervals_are_those_of_reports():
    rng = np.random.default_rng(4)
    gt = rng.normal(size=(8, 40, 3)).cumsum(axis=1)
    report = npss.report(gt, gt + rng.normal(size=gt.shape), convention="released")
    (one,) = standings([result_of_report("m", "walking", report)], level=0.9, seed=7)
    assert (one.low, one.high) == report.interval(level=0.9, seed=7)
    assert one.result.column == "NPSS released"
    assert one.result.value == report.score


def test_a_custom_convention_has_a_column():
    gt = np.random.default_rng(5).normal(size=(3, 20, 2))
    report = npss.report(gt, gt[::-1], convention=npss.Convention(weight="uniform"))
    column = result_of_report("m", "", report).column
    assert column == "NPSS power=magnitude,bins=two-sided,distance=cdf,weight=uniform,zero=dc"


def test_numbers_of_different_meaning_are_not_ranked_together():
    one = result("a", 1.0, signature=npss.signature("paper", frames=100))
    other = result("b", 2.0, signature=npss.signature("paper", frames=50))
    with pytest.raises(ValueError, match=r"'a' and 'b' are different numbers.*frames:100 and npss.*frames:50"):
        standings([one, other])
    assert len(standings([one, result("b", 2.0, action="eating", signature=other.signature)])) == 2


def test_duplicate_models():
    with pytest.raises(ValueError, match="walking, NPSS paper: duplicate model 'b'"):
        standings([result(name, 1.0) for name in "bbaa"])
    with pytest.raises(ValueError, match="walking, NPSS paper: duplicate model 'a'"):
        standings([result("a", 1.0), result("a", 2.0)])


@pytest.mark.parametrize("column", ["NPSS paper", "NPSS literal", "Euler error 80 ms"])
def test_models_are_compared_on_the_same_ground_truth_only(column):
    def scored(model, truth):
        return result(model, np.arange(len(truth)), column=column, fingerprint=fingerprint(truth))

    truth = np.random.default_rng(9).normal(size=(4, 20, 3))
    one = scored("a", truth)
    with pytest.raises(ValueError, match=r"'a' and 'b' were scored on different ground truth \(4 and 3 sequences\)"):
        standings([one, scored("b", truth[:3])])
    other = truth.copy()
    other[2, 5, 1] += 1e-3
    with pytest.raises(ValueError, match=r"walking: 'a' and 'b' .* \(sequence 2 differs\)"):
        standings([one, scored("b", other)])
    assert len(standings([one, scored("b", truth.astype(np.float32))])) == 2


def test_older_fingerprints_are_only_compared_with_each_other():
    def scored(model, numbers):
        return result(model, np.arange(4), fingerprint=np.array(numbers))

    old = scored("a", [1.0, 2.0, 3.0, 4.0])
    assert len(standings([old, scored("b", [1.0009, 2.0, 3.0, 4.0])])) == 2
    with pytest.raises(ValueError, match=r"'a' and 'b' were scored on different ground truth \(sequence 2 differs\)"):
        standings([old, scored("b", [1.0, 2.0, 3.004, 4.0])])
    new = result("new", np.arange(4), fingerprint=fingerprint(np.ones((4, 20, 3))))
    with pytest.raises(ValueError, match=r"walking: 'a' and 'new' cannot be compared: an older npss measured one"):
        standings([old, new])


def test_sequences_without_power_do_not_count():
    weight = np.array([0, 1, 1, 1, 1, 1, 1, 1, 1])
    parts = np.array([0, *range(1, 9)], float)
    found = by_model(standings([result("a", parts, weight=weight), result("b", parts + weight, weight=weight)]))
    assert found["b"].p_value == 2 / 2**8
    lonely = standings([result("a", [1.0, 0], weight=[1, 0]), result("b", [2.0, 0], weight=[1, 0])])
    assert [one.rank for one in lonely] == [1, 1]  # one sequence says nothing of chance
    assert [one.p_value for one in lonely] == [None, None]
    assert [one.behind for one in lonely] == [None, (1, 1)]
    assert "walking: 1 sequence, each its own block, assumed independent." in notes(lonely)


def test_so_many_models_that_draws_cannot_tell_them_apart():
    rng = np.random.default_rng(7)
    found = standings([result(f"m{k:02}", rng.normal(5 + k, 0.01, 20)) for k in range(33)])
    assert {one.rank for one in found} == {1}  # 528 pairs, and no p-value below 1 / 10000
    assert any("cannot show any difference between 33 models" in line for line in notes(found))


def blocks_of(n_blocks, each=2):
    """Labels of sequences that come in blocks of equal size."""
    return tuple(f"b{i // each}" for i in range(n_blocks * each))


def test_blocks_are_the_units_of_tests_and_intervals():
    rng = np.random.default_rng(4)
    weight = rng.uniform(1, 3, 26)
    parts = [weight * rng.uniform(1, 2, 26), weight * rng.uniform(1.3, 2.5, 26)]
    groups = (*blocks_of(12), None, None)
    found = by_model(
        standings([result(name, p, weight=weight, groups=groups) for name, p in zip("ab", parts, strict=True)])
    )
    sums = [p[:24].reshape(12, 2).sum(axis=1) for p in (*parts, weight)]
    assert found["b"].p_value == npss._analysis.sign_flip.sign_flips(sums[0] - sums[1], sums[2]).p_value()
    for one, numerator in zip((found["a"], found["b"]), sums, strict=False):
        assert not one.is_range
        expected = [float(end) for end in npss._analysis.bootstrap.bootstrap_interval(numerator, sums[2])]
        assert (one.low, one.high) == pytest.approx(expected, rel=1e-9)
        assert one.in_blocks == pytest.approx(numerator.sum() / sums[2].sum())
        assert one.in_blocks != one.result.value
    assert found["b"].behind == (int((sums[1] > sums[0]).sum()), 12)
    said = notes(list(found.values()))
    assert "walking: 12 blocks, 2 of 26 sequences in none." in said
    assert any(line.startswith("Before a colon: the score of the sequences in blocks") for line in said)
    (intervals,) = (line for line in said if line.startswith("Intervals: 95 %, studentised bootstrap over blocks"))
    assert "held the score in 75 to 97 % of cases" in intervals
    assert not any(line.startswith("Range") or "4/5" in line for line in said)
    assert "never other people" in said[-1]


def test_of_few_blocks_there_is_a_range_and_of_fewer_no_mark():
    hard = np.random.default_rng(5).normal(5, 1, 10)
    for n, marked in ((5, False), (6, True)):
        groups = blocks_of(n)
        parts = {name: hard[np.arange(2 * n) % 10] + more for name, more in (("good", 0.0), ("bad", 0.5))}
        found = by_model(standings([result(name, p, groups=groups) for name, p in parts.items()]))
        for name, one in found.items():
            of_blocks = parts[name].reshape(n, 2).mean(axis=1)
            assert one.is_range
            assert (one.low, one.high) == pytest.approx((of_blocks.min(), of_blocks.max()))
            assert one.in_blocks is None
        assert found["bad"].behind == (n, n)
        assert (found["bad"].rank, found["bad"].worse) == ((2, True) if marked else (1, False))
        assert found["bad"].p_value == (2 / 2**6 if marked else None)
        said = notes(list(found.values()))
        assert f"walking: {n} blocks." in said
        assert any(line.startswith("Range: the lowest and the highest score of a block") for line in said)
        assert marked != any("Fewer than 6 blocks give no p-value and no mark" in line for line in said)
        assert not any(line.startswith("Intervals") or "cannot show" in line for line in said)


def test_six_blocks_cannot_tell_three_models_apart():
    hard = np.random.default_rng(5).normal(5, 1, 6)
    found = standings([result(f"m{k}", hard + k) for k in range(3)])
    assert {one.rank for one in found} == {1}
    (said,) = (line for line in notes(found) if "cannot show" in line)
    assert said.startswith("walking: 6 blocks cannot show any difference between 3 models")


def test_a_difference_in_blocks_that_is_none_of_all_sequences_marks_nothing():
    """In blocks the second is clearly better, over all sequences the first: neither is worse by more than chance."""
    groups = (*(f"b{i}" for i in range(8)), None)
    one, other = np.array([2.0] * 8 + [1]), np.array([1.0 + 0.01 * i for i in range(8)] + [20])
    found = by_model(standings([result("one", one, groups=groups), result("other", other, groups=groups)]))
    assert found["one"].best
    assert found["other"].p_value == 2 / 2**8
    assert not found["other"].worse
    assert (found["other"].rank, found["one"].rank) == (1, 2)


def test_models_are_compared_in_the_same_blocks_only():
    parts = np.arange(1.0, 9)
    with pytest.raises(
        ValueError, match=r"walking, NPSS paper: 'a' and 'b' were scored in different blocks \(4 blocks; 8"
    ):
        standings([result("a", parts, groups=blocks_of(4)), result("b", parts)])
    alone = [result("a", parts, groups=blocks_of(4)), result("b", 3.0)]
    assert len(standings(alone)) == 2  # of a number without its sequences there are none


def test_under_the_null_hypothesis_blocks_have_few_marks():
    """Sequences of a block err alike: as units of their own they would be told apart in most columns."""
    rng = np.random.default_rng(9)
    marked = alone = 0
    for _ in range(150):
        parts = np.repeat(rng.normal(5, 1, (2, 8)), 8, axis=1)
        for groups in (blocks_of(8, 8), None):
            found = standings([result(f"m{k}", p, groups=groups) for k, p in enumerate(parts)])
            any_mark = any(one.rank > 1 for one in found)
            marked, alone = (marked + any_mark, alone) if groups else (marked, alone + any_mark)
    assert marked <= 0.05 * 150 + 3 * math.sqrt(0.05 * 0.95 * 150)
    assert alone > 0.3 * 150


@pytest.mark.parametrize("level", [0, 1, -1, math.nan])
def test_invalid_levels(level):
    with pytest.raises(ValueError, match="level: expected a number between 0 and 1"):
        standings([result("a", 1.0)], level=level)


def test_under_the_null_hypothesis_few_columns_have_a_mark():
    """The chance of any mark among four equal models is at most 5 %."""
    rng = np.random.default_rng(8)
    marked = 0
    for _ in range(300):
        parts = rng.lognormal(size=(4, 8))
        found = standings([result(f"m{k}", values) for k, values in enumerate(parts)])
        marked += any(one.rank > 1 for one in found)
    assert marked <= 0.05 * 300 + 3 * math.sqrt(0.05 * 0.95 * 300)


def test_weights_that_differ_by_more_than_precision_are_refused():
    weight = np.arange(1.0, 13)
    for factor, refused in ((1.005, False), (1.05, True)):
        other = weight.copy()
        other[-1] *= factor
        pair = [result("a", weight, weight=weight), result("b", weight, weight=other)]
        if refused:
            with pytest.raises(ValueError, match="'a' and 'b' have sequences of different weights"):
                standings(pair)
        else:
            standings(pair)
