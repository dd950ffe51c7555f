"""Reports: against the oracles column by column, against `npss.score`, their text, and invalid input."""

import copy
import dataclasses
import json
import pickle

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import npss
import oracles
from npss._analysis.blocks import INFERRED
from npss._analysis.bootstrap import bootstrap_interval
from npss._analysis.report import joint_of
from npss._metric.contributions import contributions
from npss._metric.kernel import blocks, tile
from npss.records import measure
from strategies import pairs

CONVENTIONS = [*npss.CONVENTIONS, npss.Convention(bins="one-sided"), npss.Convention(weight="uniform")]


def close(one, other):
    np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12)


def motions(n=5, n_frames=20, d=4, seed=0):
    return np.random.default_rng(seed).normal(size=(2, n, n_frames, d)).cumsum(axis=2)


# --- the parts --------------------------------------------------------------------------------------------------------


@settings(max_examples=30)
@given(pair=pairs(max_n=3, max_t=16, max_d=3), name=st.sampled_from(list(npss.CONVENTIONS)))
def test_parts_are_those_of_the_definition(pair, name):
    gt, pred = pair
    report = npss.report(gt, pred, convention=name)
    power = {"paper": lambda c: abs(c) ** 2, "released": lambda c: c.real**2, "literal": lambda c: abs(c) ** 2}[name]
    for i, d in np.ndindex(report.emd.shape):
        column = np.s_[i : i + 1, :, d : d + 1]
        alone = oracles.npss(gt[column], pred[column], name)
        if alone is None:
            assert report.emd[i, d] == report.weight[i, d] == 0
            continue
        total = sum(power(c) for c in oracles.transform(gt[i, :, d].tolist()))
        close(report.weight[i, d], 1.0 if name == "literal" else total)
        close(report.emd[i, d], alone)
    close(float(report), oracles.npss(gt, pred, name))


@pytest.mark.parametrize("convention", CONVENTIONS)
@given(pair=pairs())
def test_the_score_is_that_of_the_set_to_the_bit_and_the_mean_of_its_parts(convention, pair):
    gt, pred = pair
    report = npss.report(gt, pred, convention=convention)
    assert report.score == float(report) == npss.score(gt, pred, convention=convention)
    assert type(report.score) is type(float(report)) is float
    close(np.average(report.emd, weights=report.weight), report.score)
    assert report.emd.shape == report.weight.shape == (len(gt), gt.shape[2])
    assert (report.emd[report.weight == 0] == 0).all()


@pytest.mark.parametrize("convention", CONVENTIONS)
@given(pair=pairs())
def test_each_sequence_and_feature_scores_as_it_does_alone(convention, pair):
    gt, pred = pair
    report = npss.report(gt, pred, convention=convention)
    sides = [
        (report.per_sequence, [np.s_[i : i + 1] for i in range(len(gt))]),
        (report.per_feature, [np.s_[..., d : d + 1] for d in range(gt.shape[2])]),
    ]
    for values, parts in sides:
        assert len(values) == len(parts)
        for value, part in zip(values, parts, strict=True):
            try:
                alone = npss.score(gt[part], pred[part], convention=convention)
            except ValueError:
                assert np.isnan(value)
            else:
                close(value, alone)
    scored = ~np.isnan(report.per_sequence)
    close(np.average(report.per_sequence[scored], weights=report.weight.sum(axis=1)[scored]), report.score)


def test_many_columns_are_put_together_in_their_places():
    gt, pred = motions(n=3, n_frames=7, d=33_000)  # more than one block
    whole = npss.report(gt, pred)
    for i, d in ((0, 0), (1, 16_500), (2, 32_999), (0, 32_768), (2, 32_767)):
        alone = npss.report(gt[i, :, [d]].T, pred[i, :, [d]].T)
        assert (whole.emd[i, d], whole.weight[i, d]) == (alone.emd[0, 0], alone.weight[0, 0])


def test_one_sequence_is_a_set_of_one():
    gt, pred = motions(n=1)
    one, other = npss.report(gt[0], pred[0]), npss.report(gt, pred)
    assert one.score == other.score
    np.testing.assert_array_equal(one.emd, other.emd)
    np.testing.assert_array_equal(one.weight, other.weight)
    assert one.emd.shape == (1, 4)
    assert isinstance(one.interval(), npss.Range)
    close(one.interval(), (one.score, one.score))


# --- joints -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("feature", "joint"),
    [("LeftArm.x", "LeftArm"), ("a.b.c", "a.b"), ("hip", "hip"), ("0", "0"), ("", ""), (".x", ".x"), ("x.", "x")],
)
def test_the_joint_is_the_name_up_to_the_last_dot(feature, joint):
    assert joint_of(feature) == joint


@given(pair=pairs(max_d=4), names=st.lists(st.sampled_from(["a.x", "a.y", "b", "c.d.x"]), min_size=4, max_size=4))
def test_shares_of_joints(pair, names):
    gt, pred = pair
    names = names[: gt.shape[2]]
    report = npss.report(gt, pred, feature_names=names)
    shares = report.joint_share
    assert report.feature_names == tuple(names)
    assert set(shares) == {joint_of(name) for name in names}
    assert list(shares.values()) == sorted(shares.values(), reverse=True)
    assert all(type(share) is float and share >= 0 for share in shares.values())
    if report.score == 0:
        assert not any(shares.values())
        return
    close(sum(shares.values()), 1.0)
    total = (report.weight * report.emd).sum()
    for joint, share in shares.items():
        mine = [joint_of(name) == joint for name in names]
        close(share, (report.weight * report.emd)[:, mine].sum() / total)


def test_a_perfect_prediction_has_no_shares():
    gt, _ = motions()
    report = npss.report(gt, gt)
    assert (report.score, set(report.joint_share.values())) == (0.0, {0.0})
    assert report.interval() == (0.0, 0.0)
    assert "of the score" not in str(report)


def test_names_by_default_are_numbers():
    assert npss.report(*motions(d=3)).feature_names == ("0", "1", "2")
    assert npss.report(*motions(d=3)).joint_share.keys() == {"0", "1", "2"}


def test_names_of_joints_by_default():
    """Arrays with joints name them, as lists of sequences do; flattened features are no joints."""
    rng = np.random.default_rng(0)
    gt, pred = rng.normal(size=(2, 4, 9, 3, 2)).cumsum(axis=2)
    names = ("0.0", "0.1", "1.0", "1.1", "2.0", "2.1")
    for motions_of in (lambda x: x, list, lambda x: x.tolist(), lambda x: [*x[:3], x[3, :7]]):
        found = npss.report(motions_of(gt), motions_of(pred))
        for report in found.values() if isinstance(found, dict) else [found]:
            assert report.feature_names == names
            assert "joint  of the score" in str(report)
    flat = npss.report(gt.reshape(4, 9, 6), pred.reshape(4, 9, 6))
    assert flat.feature_names == tuple("012345")
    assert "feature  of the score" in str(flat)
    assert flat.per_feature.tolist() == npss.report(gt, pred).per_feature.tolist()
    one = npss.report(gt[0], pred[0])  # (T, J, C) is (N, T, D)
    assert one.feature_names == ("0", "1")
    matrices = np.broadcast_to(np.eye(3), (2, 6, 2, 3, 3)) + rng.normal(size=(2, 2, 6, 2, 3, 3))
    assert npss.report(*matrices, representation="matrix").feature_names[8:10] == ("0.8", "1.0")


def test_names_may_be_any_sequence_of_text():
    for names in (("a", "b"), np.array(["a", "b"]), iter("ab")):
        assert npss.report(*motions(d=2), feature_names=names).feature_names == ("a", "b")


def test_invalid_names():
    gt, pred = motions(d=3)
    for names in ("abc", 3, b"abc"):
        with pytest.raises(TypeError, match=r"^feature_names: expected a sequence of names, got"):
            npss.report(gt, pred, feature_names=names)
    for names in ([1, 2, 3], ["a", "b", None], [b"a", "b", "c"]):
        with pytest.raises(TypeError, match=r"^feature_names: expected text, got"):
            npss.report(gt, pred, feature_names=names)
    for names in ([], ["a", "b"], ["a", "b", "c", "d"]):
        with pytest.raises(ValueError, match=rf"^feature_names: expected 3 names, .* got {len(names)}"):
            npss.report(gt, pred, feature_names=names)


# --- without power ----------------------------------------------------------------------------------------------------


def test_sequences_without_power_have_no_score_and_change_none():
    gt, pred = motions(n=6)
    still = gt.copy()
    still[[0, 3]] = 0
    still[..., 1] = 0
    report, rest = npss.report(still, pred), npss.report(*(x[[1, 2, 4, 5]][..., [0, 2, 3]] for x in (gt, pred)))
    assert np.flatnonzero(np.isnan(report.per_sequence)).tolist() == [0, 3]
    assert np.flatnonzero(np.isnan(report.per_feature)).tolist() == [1]
    assert report.score == rest.score
    assert report.interval() == pytest.approx(rest.interval(), rel=1e-9)
    assert report.joint_share["1"] == 0
    lines = str(report).splitlines()
    rows = [line.split() for line in lines[lines.index("sequence    NPSS") + 2 :]]
    assert [row[0] for row in rows][-2:] == ["0", "3"]
    values = [float(row[1]) for row in rows[:-2]]
    assert values == sorted(values, reverse=True)
    assert [row[1] for row in rows[-2:]] == ["nan", "nan"]


def test_a_ground_truth_without_any_power_is_refused():
    with pytest.raises(ValueError, match=r"^gt: no power in any feature"):
        npss.report(np.zeros((3, 4, 2)), np.ones((3, 4, 2)))
    with pytest.raises(ValueError, match=r"^gt: one frame"):
        npss.report(np.ones((3, 1, 2)), np.ones((3, 1, 2)))


# --- extreme values ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("scale", [2.0**-450, 2.0**-300, 2.0**300, 2.0**450])
@pytest.mark.parametrize("convention", npss.CONVENTIONS)
def test_large_and_small_values_change_nothing(scale, convention):
    gt, pred = motions()
    report, expected = (npss.report(gt * s, pred * s, convention=convention) for s in (scale, 1))
    assert report.score == expected.score
    np.testing.assert_array_equal(report.emd, expected.emd)
    np.testing.assert_array_equal(report.weight, expected.weight * (1 if convention == "literal" else scale**2))
    assert report.interval() == expected.interval()
    assert str(report) == str(expected)


@pytest.mark.parametrize("scale", [1e-200, 1e-165, 1e-162, 1e-150, 1e148, 1e152, 1e153, 1e154, 1e200, 1e300])
def test_weights_beyond_float64_are_refused_and_not_rounded(scale):
    gt, pred = motions() * scale
    assert npss.score(gt, pred) > 0
    with pytest.raises(ValueError, match=r"^gt: its power is beyond float64; scale it"):
        npss.report(gt, pred)
    assert npss.report(gt, pred, convention="literal").score == npss.score(gt, pred, convention="literal")


@pytest.mark.parametrize("scale", [1e-200, 1e-170, 1e-100])
def test_a_feature_too_small_for_float64_weighs_nothing(scale):
    gt, pred = motions()
    gt[..., 2] *= scale
    report = npss.report(gt, pred)
    assert report.score == npss.score(gt, pred)
    close(np.average(report.emd, weights=report.weight), report.score)
    assert (report.weight[:, 2] > 0).all() == (scale == 1e-100)
    assert np.isnan(report.per_feature[2]) == (scale != 1e-100)


def test_predictions_of_any_size():
    gt, pred = motions()
    expected = npss.report(gt, pred)
    for scale in (1e-300, 1e-200, 1e200, 1e300):
        close(npss.report(gt, pred * scale).emd, expected.emd)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_invalid_values_are_named(bad):
    for which, name in enumerate(("gt", "pred")):
        both = motions()
        both[which][2, 3, 1] = bad
        with pytest.raises(ValueError, match=rf"^{name}: {bad} at index \(2, 3, 1\)"):
            npss.report(*both)
        with pytest.raises(ValueError, match=rf"^{name}: {bad} at index \(2, 3, 1\)"):
            contributions(*both, npss.CONVENTIONS["paper"])


# --- the interval -----------------------------------------------------------------------------------------------------


def test_the_interval_is_of_the_sums_over_each_sequence():
    report = npss.report(*motions(n=11))
    numerator, denominator = (report.weight * report.emd).sum(axis=1), report.weight.sum(axis=1)
    for options in ({}, {"level": 0.5}, {"seed": 3}, {"level": 0.8, "seed": 1}):
        assert report.interval(**options) == bootstrap_interval(numerator, denominator, **options)
    assert isinstance(report.interval(), npss.Interval)
    assert all(type(end) is float for end in report.interval())
    assert report.interval()[0] < report.score < report.interval()[1]


def test_few_blocks_have_a_range():
    report = npss.report(*motions(n=9))
    found = report.interval()
    assert isinstance(found, npss.Range)
    assert found == (report.per_sequence.min(), report.per_sequence.max()) == report.interval(level=0.5, seed=3)


LABELS = [*"aabbccddeeffgghhii", "j", 7, 7, None, None]  # eleven blocks, and two sequences in none


def test_blocks_are_the_units_of_the_interval():
    gt, pred = motions(n=len(LABELS))
    report = npss.report(gt, pred, groups=LABELS)
    assert report.groups == tuple(LABELS)
    assert report.score == npss.score(gt, pred)  # of all
    inside = [label is not None for label in LABELS]
    close(report.score_in_blocks, npss.score(gt[inside], pred[inside]))
    members = [[i for i, other in enumerate(LABELS) if other == label] for label in [*"abcdefghij", 7]]
    numerator = np.array([(report.weight * report.emd)[some].sum() for some in members])
    denominator = np.array([report.weight[some].sum() for some in members])
    close(report.interval(), bootstrap_interval(numerator, denominator))
    text = str(report)
    assert text.startswith(f"NPSS {report.score:.4f}; in blocks {report.score_in_blocks:.4f}, ")
    assert text.splitlines()[3] == f"  11 blocks, 2 of {len(LABELS)} sequences in none"
    few = npss.report(gt[:8], pred[:8], groups=LABELS[:8])
    scores = [npss.score(gt[i : i + 2], pred[i : i + 2]) for i in (0, 2, 4, 6)]
    close(few.interval(), (min(scores), max(scores)))
    assert few.score_in_blocks == few.score


def test_the_order_of_sequences_and_the_names_of_blocks_do_not_matter():
    gt, pred = motions(n=len(LABELS))
    expected = npss.report(gt, pred, groups=LABELS).interval(seed=1)
    named = {label: label and f"block {label}" for label in LABELS}
    close(npss.report(gt, pred, groups=np.array([named[label] for label in LABELS], object)).interval(seed=1), expected)
    order = np.r_[0 : len(LABELS) : 2, 1 : len(LABELS) : 2]  # blocks come in the same order, apart
    apart = npss.report(gt[order], pred[order], groups=[LABELS[i] for i in order])
    close(apart.interval(seed=1), expected)


def test_invalid_groups():
    gt, pred = motions(n=3)
    for groups in ("abc", 3, b"abc", {"a", "b", "c"}, frozenset("abc"), {0: "a", 1: "a", 2: "b"}):
        with pytest.raises(TypeError, match=r"^groups: expected a sequence of labels, one for each sequence, got"):
            npss.report(gt, pred, groups=groups)
    for bad in (1.0, float("nan"), True, b"a", ("a",)):
        with pytest.raises(
            TypeError, match=r"^groups: expected text, a whole number, or None for no block, got .* at 1"
        ):
            npss.report(gt, pred, groups=["a", bad, "b"])
    for groups in ([], ["a", "b"], list("abcd")):
        with pytest.raises(ValueError, match=rf"^groups: expected 3 labels, .* got {len(groups)}"):
            npss.report(gt, pred, groups=groups)
    with pytest.raises(ValueError, match=r"^groups: empty text at 2"):
        npss.report(gt, pred, groups=["a", None, ""])
    with pytest.raises(ValueError, match=r"^groups: no sequence is in a block"):
        npss.report(gt, pred, groups=[None] * 3)
    gt[0] = 0
    with pytest.raises(ValueError, match=r"^groups: no sequence with power is in a block"):
        npss.report(gt, pred, groups=["a", None, None])


def test_invalid_intervals():
    report = npss.report(*motions())
    with pytest.raises(ValueError, match=r"^level: "):
        report.interval(level=95)
    with pytest.raises(TypeError, match=r"^seed: "):
        report.interval(seed=None)
    with pytest.raises(TypeError):
        report.interval(0.95)


# --- the text ---------------------------------------------------------------------------------------------------------


def test_the_signature_states_what_it_should():
    report = npss.report(*motions(), convention="released", fps=50, representation="euler", protocol="mine")
    assert npss.parse_signature(report.signature) == {
        "metric": "npss", "version": npss.METRIC_VERSION, "convention": "released", "representation": "euler",
        "frames": 20, "fps": 50, "protocol": "mine",
    }  # fmt: skip
    assert report.signature == npss.signature("released", representation="euler", frames=20, fps=50, protocol="mine")
    assert npss.report(*motions()).signature == npss.signature("paper", frames=20)
    own = npss.Convention(weight="uniform")
    assert npss.parse_signature(npss.report(*motions(), convention=own).signature)["convention"] == own
    assert npss.report(*(x[0] for x in motions())).signature == npss.signature("paper", frames=20)


@pytest.mark.parametrize("name", ["frames", "version", "metric"])
def test_a_signature_cannot_be_made_to_lie(name):
    with pytest.raises(TypeError, match=rf"^{name}: the signature states it anyway"):
        npss.report(*motions(), **{name: 7})
    with pytest.raises(TypeError, match=r"^fps: expected a positive number"):
        npss.report(*motions(), fps="25")
    with pytest.raises(ValueError, match=r"^fps: expected a positive"):
        npss.report(*motions(), fps=0)
    with pytest.raises(TypeError, match=r"^representation: "):
        npss.report(*motions(), representation=["euler"])


@pytest.mark.parametrize(("n", "d"), [(1, 1), (8, 8), (9, 9), (20, 30)])
def test_the_text_has_the_numbers_and_their_meaning(n, d):
    names = [f"joint{i}.x" for i in range(d)]
    report = npss.report(*motions(n=n, d=d), fps=25, feature_names=names)
    text = str(report)
    low, high = report.interval()
    how = f"range of {n} block{'s' * (n > 1)}, too few for an interval"
    if n >= 10:
        how = "95 %, studentised bootstrap over blocks, 9999 resamples, seed 0"
    assert text.split("\n\n")[0].splitlines() == [
        f"NPSS {report.score:.4f}, {low:.4f} to {high:.4f} ({how})",
        f"  {report.parts}",
        f"  {report.signature}",
        f"  {n} sequence{'s' * (n > 1)}, each its own block, assumed independent",
        f"  {INFERRED}",
    ]
    joints, sequences = (block.splitlines() for block in text.split("\n\n")[1:])
    listed = list(report.joint_share.items())[:8]
    assert [line.split() for line in joints[2:10]] == [[joint, f"{share:.1%}"] for joint, share in listed]
    worst = np.argsort(-report.per_sequence)[:8]
    assert [line.split() for line in sequences[2:10]] == [[str(i), f"{report.per_sequence[i]:.4f}"] for i in worst]
    assert joints[10:] == ([f"and {d - 8} more"] if d > 8 else [])
    assert sequences[10:] == ([f"and {n - 8} more, with less"] if n > 8 else [])


def test_the_representation_is_short():
    report = npss.report(*motions())
    assert repr(report) == f"Report(score={report.score!r}, signature={report.signature!r})"


# --- the object -------------------------------------------------------------------------------------------------------


def test_a_report_cannot_be_changed():
    gt, pred = motions()
    report = npss.report(gt, pred)
    with pytest.raises(dataclasses.FrozenInstanceError):
        report.score = 0.0
    for array in (report.emd, report.weight):
        with pytest.raises(ValueError, match="read-only"):
            array[0, 0] = 1.0
        assert not np.shares_memory(array, gt)
        assert not np.shares_memory(array, pred)
    report.per_sequence[0] = 7.0  # a new array each time
    report.joint_share.clear()
    assert report.per_sequence[0] != 7.0
    assert report.joint_share


def test_a_report_can_be_copied_and_kept():
    report = npss.report(*motions())
    for other in (copy.copy(report), copy.deepcopy(report), pickle.loads(pickle.dumps(report))):
        assert str(other) == str(report)
        np.testing.assert_array_equal(other.emd, report.emd)
    assert len({report, copy.copy(report)}) == 2  # reports are themselves alone


# --- records ----------------------------------------------------------------------------------------------------------


def test_records_of_sequences_agree_with_each_alone():
    gt, pred = motions(n=4, n_frames=25)
    gt[2] *= 1e-3  # less, and not nothing
    record = measure(gt, pred, fps=25, at_ms=(80, 400, 1000), frames=25, sequences=True)
    alone = record["sequences"]
    assert set(alone) == {"npss", "weight", "euler_error", "fingerprint", "statistics"}
    np.testing.assert_array_equal(alone["fingerprint"], npss.report(gt, pred).fingerprint)
    for name in npss.CONVENTIONS:
        close(alone["npss"][name], [npss.score(*one, convention=name) for one in zip(gt, pred, strict=True)])
        close(np.average(alone["npss"][name], weights=alone["weight"][name]), record["npss"][name])
    assert list(alone["euler_error"]) == ["80", "400", "1000"] == list(record["euler_error"])
    for time, errors in alone["euler_error"].items():
        expected = [npss.euler_error(*one, at_ms=(int(time),))[int(time)] for one in zip(gt, pred, strict=True)]
        close(errors, expected)
        close(np.mean(errors), record["euler_error"][time])
    plain = measure(gt, pred, fps=25, at_ms=(80, 400, 1000), frames=25)
    del record["sequences"]
    assert record == plain


def test_records_of_sequences_are_json():
    gt, pred = motions(n=3)
    gt[1] = 0
    alone = measure(gt, pred, conventions=("paper",), frames=20, sequences=True)["sequences"]
    assert alone.keys() == {"npss", "weight", "fingerprint", "statistics"}
    assert alone.pop("fingerprint")[1] == [0.0] * 9
    assert alone.pop("statistics") == 2
    assert alone["npss"]["paper"][1] == alone["weight"]["paper"][1] == 0.0  # JSON has no NaN
    assert all(type(value) is float for values in alone.values() for value in values["paper"])


def test_records_hold_the_blocks_of_their_sequences():
    record = measure(
        *motions(n=4), conventions=("paper",), frames=20, sequences=True, groups=["a", None, np.int64(3), 3]
    )
    assert json.loads(json.dumps(record))["sequences"]["groups"] == ["a", None, 3, 3]
    with pytest.raises(ValueError, match=r"^groups: expected 4 labels"):
        measure(*motions(n=4), frames=20, sequences=True, groups=["abc"])


def test_records_of_sequences_are_of_what_was_unwrapped():
    gt, pred = motions(n=3) * 2
    wrapped = (gt + np.pi) % (2 * np.pi) - np.pi
    record = measure(wrapped, pred, conventions=("paper",), unwrapped="target", frames=20, sequences=True)
    pairs_ = zip(npss.unwrap(wrapped), npss.unwrap(pred), strict=True)
    close(record["sequences"]["npss"]["paper"], [npss.score(*one) for one in pairs_])


@pytest.mark.parametrize("sequences", [False, True])
def test_each_block_is_computed_once_for_the_score_and_its_parts(monkeypatch, sequences):
    gt, pred = motions(n=70, n_frames=50, d=600)  # of two blocks
    seen = []

    def counted(*arguments, **options):
        seen.append(arguments[-1])
        return tile(*arguments, **options)

    monkeypatch.setattr("npss._metric.score.tile", counted)
    record = measure(gt, pred, conventions=("paper",), sequences=sequences, frames=50)
    assert len(seen) == len(blocks(gt)) > 1
    assert record["npss"]["paper"] == npss.score(gt, pred)


def test_parts_are_the_same_of_any_number_of_threads():
    gt, pred = motions(n=70, n_frames=50, d=600)
    one, several = (contributions(gt, pred, npss.CONVENTIONS["paper"], workers=n) for n in (1, 3))
    assert one.score == several.score == npss.score(gt, pred)
    np.testing.assert_array_equal(one.emd, several.emd)
    np.testing.assert_array_equal(one.weight, several.weight)
    np.testing.assert_array_equal(one.form, several.form)
    np.testing.assert_array_equal(one.floor, several.floor)
