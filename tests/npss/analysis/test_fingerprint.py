"""Fingerprints of ground truths identify copies, and nothing else."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

import npss
from npss._analysis.fingerprint import PROJECTIONS, differing, fingerprint


def clips(n, n_frames=240, n_features=24):
    """Smooth motion, as of somebody who walks: joints that swing about poses of their own."""
    t = np.arange(n_frames)[:, np.newaxis] / 50
    found = []
    for i in range(n):
        rng = np.random.default_rng(i)
        phase = 2 * np.pi * rng.uniform(0.7, 1.1) * t + rng.uniform(0, 6, n_features)
        found.append(rng.uniform(-0.6, 0.6, n_features) + rng.uniform(0.05, 0.4, n_features) * np.sin(phase))
    return np.stack(found)


def test_is_the_norm_and_the_projections():
    gt = np.random.default_rng(0).normal(size=(2, 5, 3))
    found = fingerprint(gt)
    assert found.shape == (2, 1 + PROJECTIONS)
    for i, sequence in enumerate(gt):
        expected = [math.sqrt(math.fsum(x * x for x in sequence.flat))]
        for k in range(8):
            terms = [
                math.cos(t * (t + k)) * math.cos(d * (d + k + 8)) * sequence[t - 1, d - 1]
                for t in range(1, 6)
                for d in range(1, 4)
            ]
            expected.append(math.fsum(terms))
        # 15 terms below 5: each sum is off by less than 15 * 15 * 5 / 2**53, and cosines by a few units.
        np.testing.assert_allclose(found[i], expected, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(fingerprint(gt[1]), found[1:])


FULL = clips(8)
EVEN = FULL[:, 0:200:2]
ANEW = np.random.default_rng(0)


def swapped(first, second):
    features = np.arange(24)
    features[[first, second]] = features[[second, first]]
    return EVEN[..., features]


OTHERS = {
    "odd rows": FULL[:, 1:201:2],
    "one frame later": FULL[:, 2:202:2],
    "backwards": EVEN[:, ::-1],
    "another sign": -EVEN,
    "frames shuffled": EVEN[:, ANEW.permutation(100)],
    "another order of joints": EVEN[..., ANEW.permutation(24)],
    "two joints swapped": swapped(3, 4),
    "the first and the last joint swapped": swapped(0, 23),
    "another order of sequences": EVEN[[1, 0, *range(2, 8)]],
    "half precision": EVEN.astype(np.float16),
    "0.1 % more": 1.001 * EVEN,
    "one joint turned by a degree": EVEN + np.radians(1) * (np.arange(24) == 11),
    "one value": EVEN + 0.01 * (np.arange(24) == 11) * (np.arange(100) == 57)[:, np.newaxis],
}


@pytest.mark.parametrize("n", [4, 8])
@pytest.mark.parametrize("what", OTHERS)
def test_models_on_other_ground_truths_are_not_ranked_together(what, n):
    pytest.importorskip("pandas")
    rng = np.random.default_rng(1)
    reports = {
        name: npss.report(gt[:n], gt[:n] + 0.1 * rng.normal(size=gt[:n].shape), fps=25, convention="released")
        for name, gt in (("one", EVEN), ("other", OTHERS[what]))
    }
    with pytest.raises(ValueError, match="'one' and 'other' were scored on different ground truth"):
        npss.leaderboard(reports)


@pytest.mark.parametrize("what", OTHERS)
def test_others_are_far_beyond_the_tolerance(what):
    one, other = fingerprint(EVEN), fingerprint(OTHERS[what])
    assert (np.abs(one - other).max(axis=1) / one[:, 0]).max() > 5e-5


@given(
    hnp.arrays(
        np.float64,
        hnp.array_shapes(min_dims=3, max_dims=3, max_side=12),
        elements=st.floats(-1e6, 1e6).filter(lambda x: x == 0 or abs(x) > 1e-30),
    )
)
def test_copies_are_recognised(gt):
    for copy in (gt.astype(np.float32), np.asfortranarray(gt), gt.astype(np.float32).astype(np.float64), gt + 0.0):
        assert not differing(fingerprint(gt), fingerprint(copy)).any()
    np.testing.assert_array_equal(fingerprint(gt), [fingerprint(one)[0] for one in gt])


@pytest.mark.parametrize("value", [0.1, 1 / 3, -1e-3])
def test_long_copies_that_are_rounded_all_one_way_are_recognised(value):
    gt = np.full((1, 20000, 30), value)
    assert not differing(fingerprint(gt), fingerprint(gt.astype(np.float32))).any()


@pytest.mark.parametrize("length", [99, 400])
def test_no_two_features_have_the_same_coefficients_and_no_two_frames(length):
    for one in (fingerprint(np.eye(length)[:, np.newaxis, :]), fingerprint(np.eye(length)[:, :, np.newaxis])):
        apart = [np.abs(one[i + 1 :] - one[i]).max(axis=1).min() for i in range(length - 1)]
        assert min(apart) > 1e-3  # of a difference of 1; the tolerance is 1e-5


def test_a_sequence_of_zeros_equals_only_itself():
    zeros = fingerprint(np.zeros((2, 9, 4)))
    assert not differing(zeros, zeros).any()
    assert differing(zeros, fingerprint(np.full((2, 9, 4), 1e-30))).all()


def test_values_beyond_float64_warn_of_nothing():
    assert np.isinf(fingerprint(np.full((1, 3, 2), 1e300))[0, 0])


def test_copies_of_real_motion(h36m_root):
    """Also where expmap becomes Euler angles near a pole, which makes rounding large."""
    from npss_baselines.data.h36m_source import Human36M

    for task in Human36M().tasks(h36m_root, ("walking", "walkingtogether", "purchases"), "random-256"):
        one = fingerprint(npss.poses_to_euler(task.target))
        single = task.target.astype(np.float32)
        for other in (npss.poses_to_euler(single), npss.poses_to_euler(task.target).astype(np.float32)):
            found = fingerprint(other)
            assert not differing(one, found).any()
            assert (np.abs(one - found).max(axis=1) / one[:, 0]).max() < 1e-6
