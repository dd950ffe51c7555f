"""Simple baselines: against scipy one feature at a time, and what each must leave alone."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicHermiteSpline, PchipInterpolator

from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.corrupt import Corrupted
from npss_baselines.manifold.applications.simple import interpolated, with_lengths


def corrupted(seed, share=0.5, shape=(2, 20, 5)):
    rng = np.random.default_rng(seed)
    return Corrupted(rng.normal(size=shape).cumsum(axis=1), rng.random(shape) < share)


@given(seed=st.integers(0, 99), share=st.sampled_from([0.05, 0.3, 0.9]))
def test_lines_are_those_of_one_feature_alone(seed, share):
    left = corrupted(seed, share)
    expected = left.features.copy()
    for window, feature in np.argwhere(left.known.any(axis=1) & ~left.known.all(axis=1)):
        frames = np.flatnonzero(left.known[window, :, feature])
        line = np.interp(np.arange(20), frames, left.features[window, frames, feature])
        expected[window, :, feature] = np.where(left.known[window, :, feature], expected[window, :, feature], line)
    np.testing.assert_allclose(interpolated(left), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("way", ["pchip", "hermite"])
def test_cubics_are_those_of_one_feature_alone(way):
    left = corrupted(0, 0.4)
    restored = interpolated(left, way)
    for window in range(2):
        for feature in range(5):
            frames = np.flatnonzero(left.known[window, :, feature])
            values = left.features[window, frames, feature]
            slopes = np.gradient(values, frames, edge_order=2)
            curve = PchipInterpolator(frames, values) if way == "pchip" else CubicHermiteSpline(frames, values, slopes)
            expected = curve(np.clip(np.arange(20), frames[0], frames[-1]))
            np.testing.assert_allclose(restored[window, :, feature], expected, rtol=0, atol=1e-12)


@given(
    seed=st.integers(0, 99),
    share=st.sampled_from([0.05, 0.3, 1.0]),
    way=st.sampled_from(["linear", "pchip", "hermite"]),
)
def test_known_values_stay_and_unknown_ones_do_not_count(seed, share, way):
    left = corrupted(seed, share)
    other = Corrupted(np.where(left.known, left.features, 99.0), left.known)
    restored, again = interpolated(left, way), interpolated(other, way)
    assert np.array_equal(restored[left.known], left.features[left.known])
    some = np.broadcast_to(left.known.any(axis=1, keepdims=True), left.known.shape)
    assert np.array_equal(restored[some], again[some])
    assert np.array_equal(restored[~some], left.features[~some])


def test_a_parabola_is_restored_by_cubics_with_its_slopes():
    t = np.arange(21.0)
    left = Corrupted((t**2 - 3 * t).reshape(1, 21, 1), (np.arange(21) % 5 == 0).reshape(1, 21, 1))
    np.testing.assert_allclose(interpolated(left, "hermite"), left.features, rtol=0, atol=1e-9)
    assert np.abs(interpolated(left) - left.features).max() > 1


def test_an_unknown_way_is_refused():
    with pytest.raises(ValueError, match=r"^way: expected one of linear, pchip, hermite, got 'cubic'"):
        interpolated(corrupted(0), "cubic")


def test_bones_of_unseen_joints_get_their_lengths():
    rng = np.random.default_rng(0)
    joints = JOINTS.positions(np.tile(np.eye(3), (1, 4, 20, 1, 1))) + 0.1 * rng.normal(size=(1, 4, 20, 3))
    features = np.concatenate([joints.reshape(1, 4, 60), np.zeros((1, 4, 3))], axis=2)
    known = np.ones(features.shape, bool)
    hand = [JOINTS.names.index(name) for name in ("LeftHand", "LeftHandIndex")]
    known[0, 2, 3 * hand[0] + 1] = False
    known[0, 2, 3 * hand[1] : 3 * hand[1] + 3] = False
    restored = with_lengths(features, known, JOINTS)
    places = restored[..., :60].reshape(1, 4, 20, 3)
    for joint in hand:
        bone = places[0, 2, joint] - places[0, 2, JOINTS.parents[joint]]
        assert np.linalg.norm(bone) == pytest.approx(np.linalg.norm(JOINTS.offsets[joint]), rel=1e-12)
    others = [j for j in range(20) if j not in hand]
    assert np.array_equal(places[:, :, others], joints[:, :, others])
    assert np.array_equal(restored[:, [0, 1, 3]], features[:, [0, 1, 3]])
    nothing = with_lengths(features, np.zeros_like(known), JOINTS)[..., :60].reshape(1, 4, 20, 3)
    lengths = np.linalg.norm((nothing - nothing[:, :, [max(p, 0) for p in JOINTS.parents]])[:, :, 1:], axis=-1)
    np.testing.assert_allclose(
        lengths, np.broadcast_to(np.linalg.norm(JOINTS.offsets[1:], axis=-1), lengths.shape), rtol=1e-9
    )
