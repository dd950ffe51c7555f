"""Tests of the comparison of sampled with real motion, by loops and by npss.score."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss
from npss_baselines.manifold.evaluation.fidelity import descriptors, nearest_npss, precision_and_recall
from npss_baselines.manifold.motion.scaling import Scaling


def sets(seed, sizes=(6, 5), shape=(12, 3)):
    rng = np.random.default_rng(seed)
    return [rng.normal(size=(n, *shape)) for n in sizes]


@pytest.mark.numeric
@given(st.integers(0, 2**32 - 1))
def test_the_nearest_is_the_least_npss(seed):
    real, sampled = sets(seed)
    expected = [min(npss.score(gt[np.newaxis], pred[np.newaxis]) for gt in real) for pred in sampled]
    np.testing.assert_allclose(nearest_npss(real, sampled), expected, rtol=1e-12)


def test_copies_are_near():
    real, sampled = sets(0)
    assert not nearest_npss(real, real[::-1]).any()
    assert (nearest_npss(real, sampled) > 0).all()


@pytest.mark.parametrize(
    ("real", "sampled", "message"),
    [
        (np.ones((2, 8, 3)), np.ones((2, 8, 4)), r"sampled: expected shape \(n, T, D\)"),
        (np.ones((8, 3)), np.ones((2, 8, 3)), r"sampled: expected shape"),
        (np.zeros((2, 8, 3)), np.ones((2, 8, 3)), "real: the motion at index 0 has no power"),
    ],
)
def test_refused(real, sampled, message):
    with pytest.raises(ValueError, match=message):
        nearest_npss(real, sampled)


@pytest.mark.numeric
@pytest.mark.parametrize("k", [1, 2, 3])
def test_precision_and_recall_by_loops(k):
    rng = np.random.default_rng(k)
    real, sampled = rng.normal(size=(30, 2)), rng.normal(0.7, 1.3, (25, 2))

    def covered(points, centres):
        def in_ball(point, centre):
            radius = sorted(np.linalg.norm(centres - centre, axis=1))[k]
            return np.linalg.norm(point - centre) <= radius

        return np.mean([any(in_ball(point, centre) for centre in centres) for point in points])

    assert precision_and_recall(real, sampled, k=k) == pytest.approx((covered(sampled, real), covered(real, sampled)))


def test_copies_are_precise_and_complete():
    real = np.random.default_rng(0).normal(size=(20, 4))
    assert precision_and_recall(real, real) == (1.0, 1.0)
    assert precision_and_recall(real, real + 100) == (0.0, 0.0)


@pytest.mark.parametrize(
    ("k", "error", "message"),
    [(0, ValueError, "k: "), (1.5, TypeError, "k: "), (4, ValueError, "real: expected shape")],
)
def test_neighbours_refused(k, error, message):
    with pytest.raises(error, match=f"^{message}"):
        precision_and_recall(np.zeros((4, 2)), np.zeros((4, 2)), k=k)


def test_descriptors():
    rng = np.random.default_rng(0)
    motion, scaling = rng.normal(size=(2, 9, 9)), Scaling(rng.normal(size=9), rng.uniform(1, 2, 9))
    described = descriptors(motion, scaling)
    assert described.shape == (2, 18)
    column = (motion[1, :, 4] - scaling.mean[4]) / scaling.scale[4]
    changes = [b - a for a, b in itertools.pairwise(column)]
    assert described[1, [4, 10, 16]] == pytest.approx([np.mean(column), np.std(column), np.std(changes)])
    np.testing.assert_allclose(described, descriptors(motion[:, ::-1], scaling))  # when does not matter
