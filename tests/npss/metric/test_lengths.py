"""Sequences of unequal length: against the definition, sequence by sequence, and in every form of input."""

import json
import math
import pickle
from collections import defaultdict

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import npss
import oracles

pytestmark = pytest.mark.numeric

NAMES = tuple(npss.CONVENTIONS)
CUSTOM = [npss.Convention(bins="one-sided"), npss.Convention(power="real", weight="uniform", distance="spectrum")]


@st.composite
def sets(draw, max_n=5, max_t=12, least=2):
    """Draw ground truths, predictions and lengths; padded arrays hold NaN beyond a length."""
    lengths = draw(st.lists(st.integers(least, max_t), min_size=1, max_size=max_n))
    rng = np.random.default_rng(draw(st.integers(0, 2**32 - 1)))
    d = draw(st.integers(1, 3))
    both = []
    for _ in range(2):
        motions = [rng.normal(size=(n, d)).cumsum(axis=0) + rng.normal(size=d) for n in lengths]
        for motion in motions:
            motion[:, rng.random(d) < draw(st.sampled_from([0.0, 0.3]))] = 0.0
        both.append(motions)
    for motion in both[0]:
        motion[:, 0] = rng.normal(size=len(motion)) + 1  # has power
    return *both, lengths


def padded(motions, n_frames=None, fill=np.nan):
    array = np.full((len(motions), n_frames or max(map(len, motions)), *motions[0].shape[1:]), fill)
    for row, motion in zip(array, motions, strict=True):
        row[: len(motion)] = motion
    return array


def by_length(motions):
    groups = defaultdict(list)
    for motion in motions:
        groups[len(motion)].append(motion)
    return {n: np.stack(groups[n]) for n in sorted(groups)}


def defined(gt, pred, name):
    """Return the definition of the normalised score: bounds and units of weights, column by column."""
    numerator = denominator = 0.0
    for truth, prediction in zip(gt, pred, strict=True):
        n = len(truth)
        for d in range(truth.shape[1]):
            column = np.s_[np.newaxis, :, d : d + 1]
            emd = oracles.npss(truth[column], prediction[column], name)
            if emd is None:  # no power
                continue
            spectrum = oracles.transform(truth[:, d].tolist())
            power = sum(c.real**2 if name == "released" else abs(c) ** 2 for c in spectrum)
            weight = 1.0 if name == "literal" else power / n**2
            numerator += weight * emd / (2 if name == "literal" else n / 2)
            denominator += weight
    return numerator / denominator


# --- the number -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=15)
@given(drawn=sets())
def test_scores_by_t_are_those_of_the_definition(name, drawn):
    gt, pred, lengths = drawn
    scores = npss.score(padded(gt), padded(pred), lengths=lengths, convention=name)
    truths, predictions = by_length(gt), by_length(pred)
    assert list(scores) == sorted(set(lengths))
    for n, score in scores.items():
        assert type(n) is int
        assert type(score) is float
        assert score == pytest.approx(oracles.npss(truths[n], predictions[n], name), rel=1e-10, abs=1e-10)
        assert score == npss.score(truths[n], predictions[n], convention=name)


@pytest.mark.parametrize("name", NAMES)
@settings(max_examples=15)
@given(drawn=sets())
def test_the_normalised_score_is_that_of_the_definition(name, drawn):
    gt, pred, lengths = drawn
    score = npss.score(padded(gt), padded(pred), lengths=lengths, convention=name, normalize="bound")
    assert type(score) is float
    assert score == pytest.approx(defined(gt, pred, name), rel=1e-10, abs=1e-10)


@pytest.mark.parametrize("convention", [*NAMES, *CUSTOM])
@settings(max_examples=15)
@given(drawn=sets(), order=st.randoms(), extra=st.integers(0, 3), fill=st.sampled_from([np.nan, np.inf, 7.0]))
def test_every_form_gives_the_same_bits(convention, drawn, order, extra, fill):
    gt, pred, lengths = drawn
    arrays = padded(gt, max(lengths) + extra, fill), padded(pred, max(lengths) + extra, fill)
    shuffled = order.sample(range(len(gt)), len(gt))
    for options in ({}, {"normalize": "bound"}):
        expected = npss.score(*arrays, lengths=lengths, convention=convention, **options)
        forms = {
            "longer predictions": (arrays[0], padded(pred, max(lengths) + extra + 2, 0.0), lengths),
            "lists": (gt, pred, lengths),
            "an array of lengths": (*arrays, np.array(lengths, np.uint8)),
            "a list and an array": (gt, arrays[1], lengths),
            "tuples of lists": (tuple(motion.tolist() for motion in gt), pred, lengths),
            "permuted": ([gt[i] for i in shuffled], [pred[i] for i in shuffled], [lengths[i] for i in shuffled]),
        }
        for form, (truth, prediction, counts) in forms.items():
            value = npss.score(truth, prediction, lengths=counts, convention=convention, **options)
            assert value == expected, form
        if len(set(lengths)) > 1:
            assert npss.score(gt, pred, convention=convention, **options) == expected


@pytest.mark.parametrize("convention", [*NAMES, *CUSTOM])
@pytest.mark.parametrize("n_frames", [2, 9, 12])
def test_equal_lengths(convention, n_frames):
    gt, pred = np.random.default_rng(0).normal(size=(2, 4, n_frames, 3)).cumsum(axis=2)
    plain = npss.score(gt, pred, convention=convention)
    assert npss.score(gt, pred, lengths=[n_frames] * 4, convention=convention) == {n_frames: plain}
    assert npss.score(list(gt), list(pred), convention=convention) == plain
    chosen = npss.CONVENTIONS.get(convention, convention)
    bound = 2 if chosen.distance == "spectrum" else n_frames // 2 if chosen.bins == "one-sided" else n_frames / 2
    normalised = npss.score(gt, pred, convention=convention, normalize="bound")
    assert normalised == pytest.approx(plain / bound, rel=1e-15)
    assert npss.score(gt, pred, lengths=[n_frames] * 4, convention=convention, normalize="bound") == normalised


@pytest.mark.parametrize("n_frames", [2, 3, 8, 9])
@pytest.mark.parametrize("convention", [npss.Convention(bins=b, distance=d) for b in ("two-sided", "one-sided")
                                        for d in ("cdf", "spectrum")])  # fmt: skip
def test_the_bound_is_reached(convention, n_frames):
    tone = np.cos(2 * np.pi * (n_frames // 2) * np.arange(n_frames) / n_frames)[:, np.newaxis]
    assert npss.score(tone, 0 * tone + 1, convention=convention, normalize="bound") == pytest.approx(1.0)


def test_the_length_of_a_sequence_does_not_change_its_weight():
    t = np.arange(80)[:, np.newaxis]
    slow, fast = np.cos(2 * np.pi * t / 20), np.cos(2 * np.pi * t / 10)  # whole periods in 20, 40 and 80 frames
    for n in (20, 40, 80):
        score = npss.score([slow[:20], slow[:n]], [slow[:20], 0 * fast[:n]], lengths=[20, n], normalize="bound")
        assert score == pytest.approx(0.5)


def test_joints_matrices_and_huge_values():
    rng = np.random.default_rng(0)
    lengths = [5, 9, 5]
    joints = [[rng.normal(size=(n, 4, 3)) for n in lengths] for _ in range(2)]
    flat = [[motion.reshape(len(motion), -1) for motion in motions] for motions in joints]
    assert npss.score(*joints) == npss.score(*flat) == npss.score(*map(padded, joints), lengths=lengths)
    matrices = [[rng.normal(size=(n, 2, 3, 3)) for n in lengths] for _ in range(2)]
    flat = [[motion.reshape(len(motion), -1) for motion in motions] for motions in matrices]
    assert npss.score(*matrices, representation="matrix") == npss.score(*flat)
    with pytest.raises(ValueError, match=r"^gt: sequence 0: .*; for rotation matrices, pass representation='matrix'"):
        npss.score(*matrices)
    for scale in (1e300, 1e-300):
        expected = npss.score(*flat, normalize="bound")
        scaled = [[motion * scale for motion in motions] for motions in flat]
        assert npss.score(*scaled, normalize="bound") == pytest.approx(expected, rel=1e-9)


# --- accumulators, reports, the Euler error ---------------------------------------------------------------------------


@settings(max_examples=15)
@given(drawn=sets(), convention=st.sampled_from([*NAMES, *CUSTOM]), normalize=st.sampled_from([None, "bound"]))
def test_accumulators(drawn, convention, normalize):
    gt, pred, lengths = drawn
    expected = npss.score(gt, pred, lengths=lengths, convention=convention, normalize=normalize)
    parts = [
        npss.Accumulator(convention=convention, normalize=normalize).update([truth], [prediction], lengths=[n])
        for truth, prediction, n in zip(gt, pred, lengths, strict=True)
    ]
    whole = npss.Accumulator(convention=convention, normalize=normalize)
    for part in parts[::-1]:
        whole |= npss.Accumulator.from_state(json.loads(json.dumps(part.state())))
    at_once = npss.Accumulator(convention=convention, normalize=normalize)
    at_once.update(padded(gt), padded(pred), lengths=lengths)
    for accumulator in (whole, at_once, pickle.loads(pickle.dumps(whole)), npss.Accumulator.from_state(whole.state())):
        assert accumulator.result() == expected
        assert accumulator.state() == whole.state()
    if normalize is None:
        report = whole.report()
        assert list(report) == sorted(set(lengths))
        for n, of_length in report.items():
            assert of_length["npss"] == expected[n]
            assert of_length["sequences"] == lengths.count(n)
            assert of_length["signature"] == npss.signature(convention, frames=n)
    else:
        frames = {"frames": lengths[0]} if len(set(lengths)) == 1 else {"lengths": f"{min(lengths)}-{max(lengths)}"}
        assert whole.report() == {
            "npss": expected,
            "sequences": len(gt),
            "features": gt[0].shape[1],
            "signature": npss.signature(convention, **frames, normalize="bound"),
        }
        loop = npss.Accumulator(convention=convention, normalize=normalize)
        for truth, prediction in zip(gt, pred, strict=True):
            loop.update(truth, prediction)  # lengths are not needed
        assert loop.result() == expected


@settings(max_examples=15)
@given(drawn=sets(), convention=st.sampled_from([*NAMES, *CUSTOM]))
def test_reports(drawn, convention):
    gt, pred, lengths = drawn
    groups = [f"person {i % 2}" for i in range(len(gt))]
    reports = npss.report(padded(gt), padded(pred), lengths=lengths, convention=convention, fps=25, groups=groups)
    scores = npss.score(gt, pred, lengths=lengths, convention=convention)
    truths, predictions = by_length(gt), by_length(pred)
    assert list(reports) == list(scores)
    for n, report in reports.items():
        plain = npss.report(truths[n], predictions[n], convention=convention, fps=25)
        assert (report.score, report.signature) == (scores[n], plain.signature)
        np.testing.assert_array_equal(report.emd, plain.emd)
        np.testing.assert_array_equal(report.fingerprint, plain.fingerprint)
        assert report.groups == tuple(group for group, length in zip(groups, lengths, strict=True) if length == n)
    whole = npss.report(gt, pred, lengths=lengths, convention=convention, normalize="bound", groups=groups)
    assert whole.score == npss.score(gt, pred, lengths=lengths, convention=convention, normalize="bound")
    assert whole.emd.shape == (len(gt), gt[0].shape[1])
    np.testing.assert_allclose(np.average(whole.emd, weights=whole.weight), whole.score, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(whole.parts.form + whole.parts.share, whole.score, rtol=1e-9, atol=1e-12)
    assert npss.parse_signature(whole.signature)["normalize"] == "bound"
    assert whole.groups == tuple(groups)
    for i, n in enumerate(lengths):
        alone = npss.report(gt[i], pred[i], convention=convention)
        ratio = alone.emd[0] * whole.emd[i].max() - whole.emd[i] * alone.emd[0].max()
        np.testing.assert_allclose(ratio, 0, atol=1e-9)
        np.testing.assert_array_equal(whole.fingerprint[i], alone.fingerprint[0])
        assert n == len(gt[i])
    str(whole), whole.interval()


@settings(max_examples=20)
@given(drawn=sets(least=1), average=st.sampled_from(["at", "up-to"]), columns=st.sampled_from(["gt", "pred", "all"]))
def test_the_euler_error_is_of_the_sequences_that_reach_a_time(drawn, average, columns):
    gt, pred, lengths = drawn
    if columns == "gt" and min(lengths) == 1:
        with pytest.raises(ValueError, match=rf"^gt: no feature of sequence {lengths.index(1)} moves"):
            npss.euler_error(gt, pred, lengths=lengths, fps=1000, at_ms=[1])
        return
    curves = [
        oracles.euler_curve(truth[np.newaxis], prediction[np.newaxis], columns)
        for truth, prediction in zip(gt, pred, strict=True)
    ]
    times = range(1, max(lengths) + 1)
    arrays = padded(gt), padded(pred)
    errors = npss.euler_error(*arrays, lengths=lengths, fps=1000, at_ms=times, columns=columns, average=average)
    assert list(errors) == list(times)
    for time, (error, sequences) in errors.items():
        reach = [curve[:time] for curve in curves if len(curve) >= time]
        values = [curve[-1] if average == "at" else math.fsum(curve) / time for curve in reach]
        assert sequences == len(reach) == sum(n >= time for n in lengths)
        assert error == pytest.approx(math.fsum(values) / len(values), rel=1e-10, abs=1e-12)
    with pytest.raises(ValueError, match=rf"^at_ms: {max(lengths) + 1} ms is out of range"):
        npss.euler_error(*arrays, lengths=lengths, fps=1000, at_ms=[max(lengths) + 1], columns=columns)


def test_the_euler_error_of_equal_lengths():
    gt, pred = np.random.default_rng(0).normal(size=(2, 6, 25, 3))
    plain = npss.euler_error(gt, pred, at_ms=(80, 1000))
    for time, (error, sequences) in npss.euler_error(gt, pred, at_ms=(80, 1000), lengths=[25] * 6).items():
        assert sequences == 6
        assert error == pytest.approx(plain[time], rel=1e-14)


# --- signatures -------------------------------------------------------------------------------------------------------


def test_the_signature_of_a_normalised_score():
    gt, pred = np.random.default_rng(0).normal(size=(2, 2, 8, 3))
    text = "npss|version:1|convention:paper|fps:25|lengths:4-8|normalize:bound"
    assert npss.report(gt, pred, lengths=[8, 4], normalize="bound", fps=25).signature == text
    assert npss.signature(**npss.parse_signature(text)) == text
    assert (
        npss.report(gt, pred, normalize="bound").signature == "npss|version:1|convention:paper|frames:8|normalize:bound"
    )
    assert "unit of the score: its largest value" in npss.explain(text)
    published = "npss|version:1|convention:released|representation:euler|frames:100|fps:25|protocol:srnn-8|unwrap:off"
    assert "comparable with tables 4 and 5" in npss.explain(published)
    assert (
        "not comparable with tables 4 and 5 of the NPSS paper (Human3.6M): normalize must be left out"
        in npss.explain(f"{published}|normalize:bound")
    )


def test_only_what_normalises_states_it():
    gt, pred = np.random.default_rng(0).normal(size=(2, 3, 8, 3))
    for name in ("normalize", "lengths"):
        with pytest.raises(TypeError, match=rf"^{name}: measure does not normalise scores; leave it out"):
            npss.records.measure(gt, pred, **{name: "bound"})


# --- comparisons and diagnoses ----------------------------------------------------------------------------------------


@settings(max_examples=20)
@given(drawn=sets(max_n=6), convention=st.sampled_from([*NAMES, *CUSTOM]))
def test_comparisons(drawn, convention):
    gt, pred, lengths = drawn
    other = [motion[::-1] + 1 for motion in pred]
    arrays = padded(gt), padded(pred), padded(other)
    if len(gt) == 1:
        with pytest.raises(ValueError, match=r"^gt: expected N >= 2 sequences to pair, got one"):
            npss.compare(*arrays, lengths=lengths, normalize="bound")
        return
    comparison = npss.compare(*arrays, lengths=lengths, normalize="bound", convention=convention, fps=30)
    expected = [
        npss.report(gt, motions, lengths=lengths, normalize="bound", convention=convention, fps=30)
        for motions in (pred, other)
    ]
    assert [comparison.a, comparison.b] == [report.score for report in expected]
    assert comparison.signature == expected[0].signature
    assert comparison.a_parts == expected[0].parts
    assert comparison.n == len(gt)
    lists = npss.compare(gt, pred, other, lengths=lengths, normalize="bound", convention=convention, fps=30)
    assert (lists.difference, lists.p_value) == (comparison.difference, comparison.p_value)


def test_comparisons_of_one_length():
    gt, pred = np.random.default_rng(0).normal(size=(2, 8, 12, 3))
    plain = npss.compare(gt[:, :9], pred[:, :9], -gt[:, ::-1][:, :9])
    same = npss.compare(gt, pred, -gt[:, ::-1], lengths=[9] * 8)
    assert (same.a, same.b, same.p_value, same.signature) == (plain.a, plain.b, plain.p_value, plain.signature)
    bound = npss.compare(gt, pred, -gt[:, ::-1], normalize="bound")
    assert bound.p_value == npss.compare(gt, pred, -gt[:, ::-1]).p_value
    with pytest.raises(ValueError, match=r"^normalize: expected 'bound' for sequences of 5 to 9 frames"):
        npss.compare(gt, pred, pred, lengths=[9, 5] * 4)
    with pytest.raises(ValueError, match=r"^metric: 'mse' compares sequences of one length, not normalised"):
        npss.compare(gt, pred, pred, metric="mse", lengths=[9] * 8)
    with pytest.raises(ValueError, match=r"^pred_b: its shape"):
        npss.compare(gt, pred, pred[..., :2], normalize="bound")
    with pytest.raises(ValueError, match=r"^pred_a: nan at index \(1, 0, 0\)"):
        npss.compare(gt, np.where(np.arange(8)[:, None, None] == 1, np.nan, pred), pred, lengths=[9] * 8)


def test_diagnoses_name_the_length_and_the_sequence():
    rng = np.random.default_rng(0)
    gt, pred = rng.normal(size=(2, 3, 40, 2)).cumsum(axis=2) * 0.1
    lengths = [20, 40, 20]
    pred[2, :20] = pred[2, :1]
    gt[1, 20:, 0] += 2 * np.pi
    gt[0, 20:] = pred[0, 20:] = 0  # padding
    assert "padding" in {finding.pitfall for finding in npss.diagnose(gt, pred)}
    found = {finding.pitfall: finding for finding in npss.diagnose(gt, pred, lengths=lengths)}
    assert "padding" not in found
    assert found["constant"].where == (2,)
    assert "(sequences of 20 frames)" in str(found["constant"])
    assert found["wrap"].where == (1, 19, 0)
    assert "(sequences of 40 frames)" in str(found["wrap"])
    lists = npss.diagnose(*([motion[:n] for motion, n in zip(motions, lengths, strict=True)] for motions in (gt, pred)))
    assert lists == npss.diagnose(gt, pred, lengths=lengths)


# --- what is refused --------------------------------------------------------------------------------------------------

GT, PRED = np.random.default_rng(0).normal(size=(2, 3, 8, 4))


@pytest.mark.parametrize(
    ("lengths", "error", "message"),
    [
        ([8, 8], ValueError, r"lengths: expected one for each of 3 sequences, got shape \(2,\)"),
        (8, ValueError, r"lengths: expected one for each of 3 sequences, got shape \(\)"),
        ([8, 9, 8], ValueError, "lengths: 9 at 1; expected a number of frames from 1 to 8"),
        ([8, 0, 8], ValueError, "lengths: 0 at 1; expected a number of frames from 1 to 8"),
        ([8, -1, 8], ValueError, "lengths: -1 at 1"),
        ([8.0, 8.0, 8.0], TypeError, "lengths: expected whole numbers, got dtype float64"),
        ([True, True, True], TypeError, r"lengths: expected whole numbers, got booleans; .* pass mask\.sum\(1\)"),
        (np.ones((3, 60), bool), TypeError, r"lengths: expected whole numbers, got booleans; .* pass mask\.sum\(1\)"),
        ("888", TypeError, "lengths: "),
        ([[8, 8, 8]], ValueError, r"lengths: expected one for each of 3 sequences, got shape \(1, 3\)"),
        ([8, 1, 8], ValueError, "gt: one frame in sequence 1; a power spectrum needs at least two"),
    ],
)
def test_invalid_lengths(lengths, error, message):
    for function in (npss.score, npss.report, npss.Accumulator().update):
        with pytest.raises(error, match=f"^{message}"):
            function(GT, PRED, lengths=lengths)


def test_invalid_lists():
    short = [GT[0], GT[1, :5]]
    batches = [np.ones((n, 50, 88)) for n in (8, 5)]
    cases = {
        r"gt: sequence 0: shape \(1, 8, 50, 88\) would be joints of 88 numbers": (batches, batches),
        r"gt: the shape of sequence 1, \(5, 3\), differs from that of sequence 0, \(8, 4\)": ([GT[0], GT[1, :5, :3]],)
        * 2,
        "pred: 7 frames in sequence 0, but gt has 8; .* pass lengths=": (short, [GT[0, :7], GT[1, :5]]),
        "pred: 3 sequences, but gt has 2": (short, PRED),
        r"pred: its shape \(8, 3\) differs from that of gt, \(8, 4\)": (short, [GT[0, :, :3], GT[1, :5, :3]]),
        "gt: one frame in sequence 1": ([GT[0], GT[1, :1]],) * 2,
        r"pred: nan at index \(1, 4, 0\)": (short, [GT[0], np.where(np.arange(5) == 4, np.nan, GT[1, :5].T).T]),
    }
    for message, pair in cases.items():
        with pytest.raises(ValueError, match=f"^{message}"):
            npss.score(*pair)
    with pytest.raises(TypeError, match=r"^gt: sequence 1: expected real numbers, got complex"):
        npss.score([GT[0], GT[1, :5] * 1j], short)
    with pytest.raises(TypeError, match=r"^gt: sequence 0: masked arrays are refused.*pass lengths="):
        npss.score([np.ma.array(GT[0]), GT[1, :5]], short)
    with pytest.raises(
        ValueError, match=r"^gt: sequence 0: shape \(1, 8, 3, 3\) may be rotation matrices of one joint"
    ):
        npss.score([np.ones((8, 3, 3)), np.ones((5, 3, 3))], short)


def test_values_that_count_must_be_finite():
    for name, pair in (("gt", (GT.copy(), PRED)), ("pred", (GT, PRED.copy()))):
        broken = pair[name == "pred"]
        broken[1, 5, 2] = np.nan
        with pytest.raises(ValueError, match=rf"^{name}: nan at index \(1, 5, 2\); every value must be finite"):
            npss.score(*pair, lengths=[8, 6, 8])
        assert npss.score(*pair, lengths=[8, 5, 8]) == npss.score(GT, PRED, lengths=[8, 5, 8])


def test_a_length_without_power_is_named():
    gt = [0 * GT[0], GT[1, :5]]
    with pytest.raises(ValueError, match=r"^gt: no power in any feature of any sequence of 8 frames"):
        npss.score(gt, [PRED[0], PRED[1, :5]])
    with pytest.raises(ValueError, match=r"^gt: no power in any feature of any sequence of 8 frames"):
        npss.report(gt, [PRED[0], PRED[1, :5]])
    alone = npss.score(gt[1], PRED[1, :5], normalize="bound")
    assert npss.score(gt, [PRED[0], PRED[1, :5]], normalize="bound") == alone


def test_invalid_normalisation():
    for normalize, error in (("Bound", ValueError), (True, TypeError), (2, TypeError)):
        for call in (npss.score, npss.report):
            with pytest.raises(error, match=r"^normalize: expected one of bound, got"):
                call(GT, PRED, normalize=normalize)
        with pytest.raises(error, match=r"^normalize: expected one of bound, got"):
            npss.Accumulator(normalize=normalize)


class TestAccumulators:
    def test_kinds_do_not_merge(self):
        plain, normalised = npss.Accumulator().update(GT, PRED), npss.Accumulator(normalize="bound").update(GT, PRED)
        with pytest.raises(ValueError, match=r"^normalize: bound cannot be merged into None"):
            plain | normalised
        with pytest.raises(ValueError, match=r"^the other accumulator: 5 frames of 4 features"):
            plain | npss.Accumulator().update(GT[:, :5], PRED[:, :5])
        assert sorted((plain | npss.Accumulator().update(GT, PRED, lengths=[5, 6, 7])).result()) == [5, 6, 7, 8]
        with pytest.raises(ValueError, match=r"^gt: 8 frames of 3 features"):
            normalised.update(GT[..., :3], PRED[..., :3])

    def test_the_empty_state_of_a_normalised_one(self):
        empty = npss.Accumulator(normalize="bound")
        assert npss.Accumulator.from_state(empty.state()).update(GT, PRED).result() == npss.score(
            GT, PRED, normalize="bound"
        )

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"lengths": []}, "state: expected lengths as a dict"),
            ({"lengths": {"5": {}}}, "state: expected sequences, numerator, denominator for a number of frames"),
            ({"lengths": {"x": {"sequences": 1, "numerator": "1", "denominator": "1"}}}, "expected a number of frames"),
            ({"lengths": {"0": {"sequences": 1, "numerator": "1", "denominator": "1"}}}, "contradict each other"),
            ({"lengths": {"7": {"sequences": 1, "numerator": "1", "denominator": "1"}}}, "contradict each other"),
            ({"features": 0}, "contradict each other"),
        ],
    )
    def test_invalid_states(self, change, message):
        state = npss.Accumulator(normalize="bound").update(GT, PRED, lengths=[5, 6, 7]).state()
        with pytest.raises(ValueError, match=message):
            npss.Accumulator.from_state({**state, **change})
