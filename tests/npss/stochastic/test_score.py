"""NPSS of samples: the reductions by their definition, the report, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss
from npss.stochastic import report, score

pytestmark = pytest.mark.numeric

seeds = st.integers(0, 2**32 - 1)
conventions = st.sampled_from([*npss.CONVENTIONS, npss.Convention(weight="uniform", bins="two-sided")])


def drawn(seed, s=3, n=4, frames=12, features=2):
    """Return sequences of different loudness, and samples near them."""
    rng = np.random.default_rng(seed)
    gt = rng.normal(size=(n, frames, features)).cumsum(axis=1) * rng.uniform(0.1, 5, (n, 1, 1))
    return gt, gt + rng.normal(size=(s, n, frames, features))


@given(seeds, conventions)
def test_reductions_equal_their_definition(seed, convention):
    gt, samples = drawn(seed)
    scores = [npss.score(gt, sample, convention=convention) for sample in samples]
    assert score(gt, samples, convention=convention) == pytest.approx(np.mean(scores), rel=1e-12)
    each = np.array([[npss.score(gt[[i]], sample[[i]], convention=convention) for i in range(4)] for sample in samples])
    for reduction, chosen in (("best", each.argmin(axis=0)), ("worst", each.argmax(axis=0))):
        picked = samples[chosen, np.arange(4)]
        expected = npss.score(gt, picked, convention=convention)
        assert score(gt, samples, reduction=reduction, convention=convention) == pytest.approx(expected, rel=1e-12)


@given(seeds)
def test_properties(seed):
    gt, samples = drawn(seed)
    best, mean, worst = (score(gt, samples, reduction=which) for which in ("best", "mean", "worst"))
    scores = [npss.score(gt, sample) for sample in samples]
    assert best <= min(scores) * (1 + 1e-12)  # each sequence chooses its own
    assert worst >= max(scores) * (1 - 1e-12)
    assert best <= mean * (1 + 1e-12) <= worst * (1 + 1e-11)
    for reduction in ("best", "mean", "worst"):
        one = score(gt, samples[:1], reduction=reduction)
        assert one == pytest.approx(scores[0], rel=1e-12)
        assert score(gt, samples[::-1], reduction=reduction) == pytest.approx(
            score(gt, samples, reduction=reduction), rel=1e-12
        )
    assert score(gt, [*samples, gt], reduction="best") == 0
    assert score(gt, [*samples, gt], reduction="mean") < mean
    assert score(gt, samples[:2], reduction="best") >= best * (1 - 1e-12)


def test_choosing_for_each_sequence_differs_from_choosing_one_sample():
    gt, samples = drawn(0, n=2)
    samples[0, 0], samples[1, 1] = gt[0], gt[1]
    assert score(gt, samples, reduction="best") == 0
    assert min(npss.score(gt, sample) for sample in samples) > 0.001


def test_shapes():
    gt, samples = drawn(1, features=12)
    joints = gt.reshape(4, 12, 4, 3), samples.reshape(3, 4, 12, 4, 3)
    assert score(*joints) == score(gt, samples) == score(gt, list(samples))
    assert score(gt[0], samples[:, 0]) == score(gt[:1], samples[:, :1])
    three = samples[..., :9].reshape(3, 4, 12, 1, 3, 3)
    matrices = score(gt[..., :9].reshape(4, 12, 1, 3, 3), three, representation="matrix")
    assert matrices == score(gt[..., :9], samples[..., :9])
    with pytest.raises(ValueError, match=r"^gt: shape \(4, 12, 3, 3\) may be"):
        score(gt[..., :9].reshape(4, 12, 3, 3), three)


def test_golden_value_with_its_signature():
    """Tones one, two and three bins off, on both sides of the spectrum."""
    t = np.arange(60)[:, np.newaxis]
    tones = [np.cos(2 * np.pi * k * t / 60)[np.newaxis] for k in (5, 6, 7, 8)]
    text = "npss|version:1|convention:paper|frames:60|draws:3|reduction:best"
    assert report(tones[0], tones[1:], reduction="best").signature == text
    assert npss.signature(**npss.parse_signature(text)) == text
    values = [score(tones[0], tones[1:], reduction=which) for which in ("best", "mean", "worst")]
    assert values == pytest.approx([1, 2, 3], rel=1e-12)


class TestReport:
    def test_spread_and_interval_are_apart(self):
        gt, samples = drawn(0, s=5, n=12)
        result = report(gt, samples, fps=25, groups=[i // 2 for i in range(12)])
        scores = [npss.score(gt, sample) for sample in samples]
        assert result.scores == pytest.approx(scores, rel=1e-12)
        assert float(result) == result.score == pytest.approx(np.mean(scores), rel=1e-12)
        assert result.spread == pytest.approx(np.std(scores, ddof=1), rel=1e-9)
        # Of a range of six blocks, each scored by itself.
        blocks = [score(gt[i : i + 2], samples[:, i : i + 2]) for i in range(0, 12, 2)]
        assert result.interval() == pytest.approx(npss.Range(min(blocks), max(blocks)), rel=1e-12)
        assert isinstance(result.interval(), npss.Range)
        each = [score(gt[[i]], samples[:, [i]]) for i in range(12)]
        assert result.per_sequence == pytest.approx(each, rel=1e-12)
        text = str(result)
        assert f"over 5 samples: standard deviation {result.spread:.4f}, {min(scores):.4f} to {max(scores):.4f}" in text
        assert f"over blocks: {min(blocks):.4f} to {max(blocks):.4f} (range of 6 blocks" in text
        assert result.signature in text
        assert repr(result).startswith("SampleReport(score=")

    @pytest.mark.parametrize("reduction", ["mean", "best", "worst"])
    def test_more_blocks_give_an_interval_and_more_samples_less_spread(self, reduction):
        gt, samples = drawn(1, s=4, n=12)
        result = report(gt, samples, reduction=reduction)
        assert result.score == score(gt, samples, reduction=reduction)
        assert isinstance(result.interval(), npss.Interval)
        low, high = result.interval()
        assert low < result.score < high
        same = report(gt, np.repeat(samples[:1], 4, axis=0), reduction=reduction)
        assert same.spread == 0
        assert same.interval() == pytest.approx(npss.report(gt, samples[0]).interval(), rel=1e-9)

    def test_one_sample_has_no_spread(self):
        gt, samples = drawn(2)
        result = report(gt, samples[:1])
        assert np.isnan(result.spread)
        assert "standard deviation" not in str(result)

    def test_arrays_are_read_only(self):
        result = report(*drawn(3))
        for array in (result.scores, result.numerator, result.weight):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1


@pytest.mark.parametrize("call", [score, report])
def test_what_is_refused(call):
    gt, samples = drawn(0)
    for arrays, options, error, message in [
        ((gt, samples), {"reduction": "median"}, ValueError, "reduction: expected one of mean, best, worst"),
        ((gt, samples), {"reduction": None}, TypeError, "reduction: expected one of"),
        ((gt, samples), {"convention": "code"}, ValueError, "convention"),
        ((gt, gt), {}, ValueError, r"samples: expected \(S, 4, 12, 2\)"),
        ((gt, samples[..., 0]), {}, ValueError, "samples: expected"),
        ((np.zeros_like(gt), samples), {}, ValueError, "gt: "),
    ]:
        with pytest.raises(error, match=f"^{message}"):
            call(*arrays, **options)


def test_fields_that_the_report_states():
    gt, samples = drawn(0)
    with pytest.raises(TypeError, match=r"^draws: the signature states it anyway"):
        report(gt, samples, draws=3)
    assert "protocol:lafan1" in report(gt, samples, protocol="lafan1").signature
    with pytest.raises(ValueError, match=r"^groups: expected 4 labels"):
        report(gt, samples, groups=["a"])


def test_leaderboards_keep_samples_and_blocks_apart():
    pytest.importorskip("pandas")
    gt, samples = drawn(0, s=4, n=12)
    good, bad = report(gt, samples), report(gt, gt + 5 * (samples - gt))
    board = npss.leaderboard({"good": {"walking": good}, "bad": {"walking": bad}})
    row = board.tidy.set_index("model").loc["good"]
    assert row["value"] == good.score
    assert (row["low"], row["high"]) == pytest.approx(good.interval(), rel=1e-12)
    assert (row["samples"], row["sample_low"], row["sample_high"]) == (4, good.scores.min(), good.scores.max())
    assert row[["seeds", "seed_low"]].isna().all()
    text = board.to_text()
    assert f"samples {good.scores.min():.3f}–{good.scores.max():.3f}" in text
    assert "After 'samples': the lowest and the highest score of one sample; intervals are over blocks." in board.notes
    # The best of four is another number than the mean.
    with pytest.raises(ValueError, match="reduction"):
        npss.leaderboard({"mean": {"walking": good}, "best": {"walking": report(gt, samples, reduction="best")}})
    alone = npss.leaderboard({"one": npss.report(gt, samples[0])})
    assert alone.tidy["samples"].isna().all()
    assert ", samples " not in alone.to_text()
