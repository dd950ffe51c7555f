"""The distances of stochastic prediction: definitions in loops, properties, and what is refused."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss
from npss.stochastic import _distances, ade, apd, fde, mmade, mmfde

pytestmark = pytest.mark.numeric

seeds = st.integers(0, 2**32 - 1)
sizes = st.tuples(st.integers(1, 4), st.integers(1, 4), st.integers(1, 5), st.integers(1, 4))  # S, N, T, D


def drawn(seed, size):
    rng = np.random.default_rng(seed)
    samples = rng.normal(size=size)
    return rng.normal(size=size[1:]), samples, rng.normal(size=(size[1], 3))


def displacement(one, other):
    """Return the mean distance of two motions over frames, and that of the last frame."""
    norms = [math.dist(a, b) for a, b in zip(one, other, strict=True)]
    return sum(norms) / len(norms), norms[-1]


def by_definition(gt, samples, contexts, threshold):
    """Return ADE, FDE, MMADE and MMFDE."""
    n = len(gt)
    totals = np.zeros(4)
    for i in range(n):
        own = np.array([displacement(sample[i], gt[i]) for sample in samples]).min(axis=0)
        similar = [j for j in range(n) if math.dist(contexts[i], contexts[j]) < threshold]
        others = [np.array([displacement(sample[i], gt[j]) for sample in samples]).min(axis=0) for j in similar]
        totals += np.concatenate([own, np.mean(others, axis=0)]) / n
    return totals


@given(seeds, sizes, st.sampled_from([0.1, 1.5, 100]))
def test_equals_the_definition(seed, size, threshold):
    gt, samples, contexts = drawn(seed, size)
    expected = by_definition(gt, samples, contexts, threshold)
    context = {"contexts": contexts, "threshold": threshold}
    got = [ade(gt, samples), fde(gt, samples), mmade(gt, samples, **context), mmfde(gt, samples, **context)]
    np.testing.assert_allclose(got, expected, rtol=1e-12)
    if len(samples) > 1:
        pairs = [(a, b) for i, a in enumerate(samples) for b in samples[:i]]
        distances = [[math.dist(a[i].ravel(), b[i].ravel()) for a, b in pairs] for i in range(len(gt))]
        assert apd(samples) == pytest.approx(np.mean(distances), rel=1e-12)


@given(seeds, sizes, st.floats(0.1, 10))
def test_properties(seed, size, unit):
    gt, samples, contexts = drawn(seed, size)
    rng = np.random.default_rng(seed)
    for metric in (ade, fde):
        value = metric(gt, samples)
        assert metric(unit * gt, unit * samples) == pytest.approx(unit * value, rel=1e-12)
        assert metric(gt, rng.permutation(samples)) == pytest.approx(value, rel=1e-12)
        assert metric(gt, np.concatenate([samples, samples[:1] + 1])) <= value * (1 + 1e-12)  # more samples never hurt
        assert metric(gt, np.concatenate([samples, gt[np.newaxis]])) == 0
    # A tiny threshold leaves each sequence its own future; a huge one gives all to all.
    assert mmade(gt, samples, contexts, threshold=1e-9) == pytest.approx(ade(gt, samples), rel=1e-12)
    assert mmfde(gt, samples, contexts, threshold=1e-9) == pytest.approx(fde(gt, samples), rel=1e-12)
    everyone = mmade(gt, samples, contexts, threshold=1e9)
    order = rng.permutation(len(gt))
    shuffled = mmade(gt[order], samples[:, order], contexts[order], threshold=1e9)
    assert shuffled == pytest.approx(everyone, rel=1e-12)
    twice = np.concatenate([samples, samples + 3])
    value = apd(twice)
    assert apd(rng.permutation(twice)) == pytest.approx(value, rel=1e-12)
    assert apd(twice + rng.normal(size=size[1:])) == pytest.approx(value, rel=1e-9)  # no truth is involved
    assert apd(unit * twice) == pytest.approx(unit * value, rel=1e-12)


def test_negative_examples():
    gt, samples, _ = drawn(0, (3, 2, 4, 3))
    assert ade(gt, samples) != fde(gt, samples)
    # The best sample of the last frame and that of all frames differ.
    one = np.zeros((1, 2, 1))
    assert fde(one, [one + [[9], [0]], one + 1]) == 0
    assert ade(one, [one + [[9], [0]], one + 1]) == 1
    # Copies of one sample are not diverse, noise is.
    assert apd(np.repeat(samples[:1], 3, axis=0)) == 0
    assert apd(samples) > apd(0.5 * samples)
    # At the threshold itself, two contexts are not similar.
    gt = np.array([[[0.0]], [[4.0]]])
    contexts = [[0.0], [1.0]]
    assert mmade(gt, [gt], contexts, threshold=1.0) == 0.0
    assert mmade(gt, [gt], contexts, threshold=1.1) == 2.0  # 0 to its own future, 4 to the other
    assert mmade(gt, [0 * gt, 0 * gt + 4], contexts, threshold=1.1) == 0.0


def test_blocks_of_futures_do_not_matter(monkeypatch):
    gt, samples, contexts = drawn(1, (3, 7, 4, 2))
    whole = mmade(gt, samples, contexts, threshold=2)
    monkeypatch.setattr(_distances, "_VALUES", 50)
    assert mmade(gt, samples, contexts, threshold=2) == pytest.approx(whole, rel=1e-12)


def test_joints_single_sequences_and_precisions():
    gt, samples, _ = drawn(2, (3, 2, 4, 6))
    joints = gt.reshape(2, 4, 2, 3), samples.reshape(3, 2, 4, 2, 3)
    contexts = np.zeros((2, 2, 3))
    for metric in (ade, fde):
        assert metric(*joints) == metric(gt, samples) == metric(gt, list(samples))
        assert metric(gt[0], samples[:, 0]) == metric(gt[:1], samples[:, :1])
        single = metric(gt.astype(np.float32), samples.astype(np.float32))
        assert single == pytest.approx(metric(gt, samples), rel=1e-6)
    assert apd(joints[1]) == apd(samples)
    assert mmade(*joints, contexts, threshold=1) == mmade(gt, samples, contexts.reshape(2, 6), threshold=1)


def test_golden_values_with_their_signatures():
    gt = np.zeros((2, 2, 2))
    samples = np.stack([gt + [3, 4], gt + [[0, 1], [0, 3]]])
    context = {"frames": 2, "draws": 2}
    values = {
        "ade|version:1|frames:2|draws:2": ade(gt, samples),
        "fde|version:1|frames:2|draws:2": fde(gt, samples),
        "apd|version:1|frames:2|draws:2": apd(samples),
        "mmade|version:1|frames:2|draws:2|threshold:0.5": mmade(gt, samples, [[0], [9]], threshold=0.5),
        "mmfde|version:1|frames:2|draws:2|threshold:0.5": mmfde(gt, samples, [[0], [9]], threshold=0.5),
    }
    assert list(values.values()) == pytest.approx([2, 3, math.sqrt(9 + 9 + 9 + 1), 2, 3], rel=1e-13)
    for text in values:
        name = text.partition("|")[0]
        extra = {"threshold": 0.5} if name.startswith("mm") else None
        assert npss.signature(None, metric=name, extra=extra, **context) == text


@pytest.mark.parametrize("metric", [ade, fde, lambda gt, samples: mmade(gt, samples, np.ones((2, 3)), threshold=1)])
def test_what_is_refused(metric):
    gt, samples, _ = drawn(0, (3, 2, 4, 6))
    broken = samples.copy()
    broken[2, 1, 3, 0] = np.nan
    for arrays, error, message in [
        ((gt, gt), ValueError, r"samples: expected \(S, 2, 4, 6\), S predictions of each sequence of gt, got"),
        ((gt, samples[:, :1]), ValueError, r"samples: expected \(S, 2, 4, 6\), .* got \(3, 1, 4, 6\)"),
        ((gt, samples[:0]), ValueError, "samples: expected at least one sample"),
        ((gt[0], samples), ValueError, r"samples: expected \(S, 1, 4, 6\)"),
        ((gt, broken), ValueError, r"samples: nan at index \(2, 1, 3, 0\)"),
        ((broken[2], samples), ValueError, r"gt: nan at index \(1, 3, 0\)"),
        ((gt, samples > 0), TypeError, "samples: expected real numbers, got booleans"),
        ((1e200 * gt, samples), ValueError, "samples: their distance is beyond float64"),
    ]:
        with pytest.raises(error, match=f"^{message}"):
            metric(*arrays)


def test_what_only_some_refuse():
    gt, samples, contexts = drawn(0, (3, 2, 4, 6))
    with pytest.raises(ValueError, match=r"^samples: expected at least two"):
        apd(samples[:1])
    with pytest.raises(ValueError, match=r"^samples: expected at least one sample, .* got shape \(4, 6\)"):
        apd(gt[0])
    for bad in (contexts[:1], contexts[0], contexts[:, :0]):
        with pytest.raises(ValueError, match=r"^contexts: expected a pose for each of 2 sequences"):
            mmade(gt, samples, bad, threshold=1)
    with pytest.raises(ValueError, match=r"^contexts: inf at index"):
        mmfde(gt, samples, contexts + np.inf, threshold=1)
    with pytest.raises(ValueError, match=r"^threshold: expected a positive"):
        mmfde(gt, samples, contexts, threshold=0)
    with pytest.raises(TypeError, match=r"threshold"):
        mmade(gt, samples, contexts)
