"""Tests of interpolation: blends of directions, contacts of feet, and feet held by bending legs."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from npss_baselines.data.motion import JOINTS, NAMES
from npss_baselines.data.synthetic_jump import jump_clip
from npss_baselines.manifold.applications.interpolate import blend, interpolate, possible, slerp
from npss_baselines.manifold.motion import contacts
from npss_baselines.manifold.motion.contacts import contacts_of, hold_feet
from npss_baselines.manifold.motion.dataset import prepare
from npss_baselines.manifold.motion.features import local_positions, to_features, to_positions
from npss_baselines.manifold.motion.smooth import smoothed

LENGTHS = np.linalg.norm(JOINTS.offsets, axis=-1)
BALLS = [NAMES.index("LeftToeBase"), NAMES.index("RightToeBase")]
LEGS = {name for side in ("Left", "Right") for name in (f"{side}Leg", f"{side}Foot", f"{side}ToeBase")}


@pytest.fixture(scope="module")
def walks(motions):
    """Return the first windows of two walks, ``(1, T, F)`` each."""
    return [motions.windows[motions.clip_of == clip][:1].astype(np.float64) for clip in (1, 4)]


@pytest.fixture(scope="module")
def jump():
    """Return jumps on the spot, whose feet stand still, ``(1, T, F)``."""
    return prepare([jump_clip(160)]).windows.astype(np.float64)


def slid(positions, stands):
    """Return the average horizontal way of standing feet from frame to frame."""
    steps = np.linalg.norm(np.diff(positions[..., BALLS, :][..., ::2], axis=-3), axis=-1)
    return steps[stands[..., 1:, :] & stands[..., :-1, :]].mean()


def bone_lengths(features):
    local = local_positions(features)
    return np.stack([np.linalg.norm(local[..., c, :] - local[..., p, :], axis=-1) for c, p in JOINTS.bones], axis=-1)


def expected_lengths():
    return np.array([LENGTHS[child] for child, _ in JOINTS.bones])


# --- blends ---


@given(st.floats(0, 1), st.floats(0.1, 3), st.integers(0, 2**32 - 1))
def test_directions_turn_in_proportion(share, angle, seed):
    """Rotate a bone by an angle about a random axis: the blend is rotated by the share of it."""
    rng = np.random.default_rng(seed)
    one, other = np.linalg.qr(rng.normal(size=(3, 2)))[0].T

    def at(turned):
        pose = np.zeros((1, 63))
        for child, parent in JOINTS.bones:
            direction = np.cos(turned) * one + np.sin(turned) * other
            pose[0, 3 * child : 3 * child + 3] = pose[0, 3 * parent : 3 * parent + 3] + LENGTHS[child] * direction
        return pose

    np.testing.assert_allclose(slerp(at(0), at(angle), share), at(share * angle), rtol=0, atol=1e-9)


def posed(directions):
    """Return the features of a pose, ``(1, 63)``, from the directions of bones by joint."""
    pose = np.zeros((1, 63))
    for joint in JOINTS._order[1:]:
        parent = JOINTS.parents[joint]
        pose[0, 3 * joint : 3 * joint + 3] = pose[0, 3 * parent : 3 * parent + 3] + LENGTHS[joint] * directions[joint]
    return pose


@given(st.floats(0, 1), st.integers(0, 2**32 - 1))
def test_bones_turn_with_the_bones_above_them(share, seed):
    """Random poses, joint by joint with rotations of scipy: the angle of a joint is its share of the whole angle."""
    rng = np.random.default_rng(seed)
    start, end = rng.normal(size=(2, 20, 3))
    start, end = (each / np.linalg.norm(each, axis=1, keepdims=True) for each in (start, end))
    partly, wholly, expected = {0: Rotation.identity()}, {0: Rotation.identity()}, np.zeros((20, 3))
    for joint in JOINTS._order[1:]:
        parent = JOINTS.parents[joint]
        there = wholly[parent].inv().apply(end[joint])
        axis = np.cross(start[joint], there)
        turn = axis / np.linalg.norm(axis) * np.arccos(start[joint] @ there)
        partly[joint] = partly[parent] * Rotation.from_rotvec(share * turn)
        wholly[joint] = wholly[parent] * Rotation.from_rotvec(turn)
        expected[joint] = partly[joint].apply(start[joint])
    np.testing.assert_allclose(slerp(posed(start), posed(end), share), posed(expected), rtol=0, atol=1e-6)
    # The blend does not depend on which motion is the first.
    np.testing.assert_allclose(slerp(posed(end), posed(start), 1 - share), posed(expected), rtol=0, atol=1e-6)


def test_opposite_directions_turn_about_some_axis():
    up = posed(np.tile([0.0, 1.0, 0.0], (20, 1)))
    middle = local_positions(slerp(up, -up, 0.5))[0]
    for child, parent in JOINTS.bones:
        bone = middle[child] - middle[parent]
        assert bone[1] == pytest.approx(0, abs=1e-9)
        assert np.linalg.norm(bone) == pytest.approx(LENGTHS[child])


@pytest.mark.parametrize("way", ["linear", "slerp"])
def test_ends_are_the_motions(walks, way):
    for share, end in zip((0, 1), walks, strict=True):
        np.testing.assert_allclose(interpolate(None, *walks, share, way=way, constrained=False), end, atol=1e-6)


def test_the_manifold_blends_codes(testbed, walks):
    manifold = testbed.manifolds["manifold"]
    codes = [manifold.encode(walk) for walk in walks]
    expected = manifold.decode(0.75 * codes[0] + 0.25 * codes[1], 160)
    np.testing.assert_allclose(interpolate(manifold, *walks, 0.25, way="manifold", constrained=False), expected)


@pytest.mark.numeric
@pytest.mark.parametrize("way", ["linear", "slerp", "manifold"])
def test_constrained_blends_are_possible(testbed, walks, jump, way):
    """The jump dominates, and its feet stand; the walk pulls them along."""
    manifold = testbed.manifolds["manifold"]
    made, free = (
        interpolate(manifold, walks[0], jump, 0.75, way=way, constrained=constrained) for constrained in (True, False)
    )
    np.testing.assert_allclose(bone_lengths(made), np.broadcast_to(expected_lengths(), (1, 160, 19)), atol=1e-6)
    stands = contacts_of(jump, JOINTS)
    assert stands.mean() > 0.7
    assert slid(to_positions(made), stands) < 0.5 * slid(to_positions(free), stands)
    decoded = smoothed(free) if way == "manifold" else free
    np.testing.assert_array_equal(made, possible(decoded, walks[0], jump, 0.75))


def test_refused(walks):
    with pytest.raises(ValueError, match=r"^way: "):
        interpolate(None, *walks, 0.5, way="cubic")
    with pytest.raises(ValueError, match=r"^projector: the way 'manifold' needs a manifold, got None"):
        interpolate(None, *walks, 0.5, way="manifold")
    with pytest.raises(ValueError, match=r"^first: expected shape \(\.\.\., T, 63\)"):
        slerp(np.zeros((2, 9)), np.zeros((2, 9)), 0.5)
    with pytest.raises(ValueError, match=r"^second: "):
        slerp(walks[0], walks[1][:, 1:], 0.5)


# --- contacts ---


def standing(n_frames=40):
    """Return a figure that stands with bent knees, ``(T, 20, 3)``: the skeleton's rest pose, hips lowered."""
    rest = np.zeros((20, 3))
    for joint in JOINTS._order:
        parent = JOINTS.parents[joint]
        rest[joint] = JOINTS.offsets[joint] + (0 if parent < 0 else rest[parent])
    rest[:, 1] -= rest[BALLS, 1].min()
    return np.tile(rest, (n_frames, 1, 1))


def moved(pose, joints, path):
    place = pose.copy()
    place[:, [NAMES.index(name) for name in joints]] += path[:, np.newaxis]
    return place


def test_a_standing_foot_is_low_and_slow():
    pose = standing()
    lifted = np.zeros((40, 3))
    lifted[20:, 1] = 0.1  # the left foot stands on a step from frame 20 on
    slid = np.zeros((40, 3))
    slid[:, 2] = np.arange(40) * 0.5 / 30  # the right foot slides at .5 body heights a second
    pose = moved(moved(pose, ["LeftFoot", "LeftToeBase"], lifted), ["RightFoot", "RightToeBase"], slid)
    stands = contacts_of(to_features(pose, JOINTS), JOINTS)
    assert stands.shape == (40, 2)
    assert stands[:19, 0].all()
    assert not stands[19:, 0].any()  # it moves from frame 19 to 20
    assert not stands[:, 1].any()
    with pytest.raises(ValueError, match=r"^features: expected shape \(\.\.\., T, 63\) for 20 joints"):
        contacts_of(np.zeros((4, 9)), JOINTS)


@pytest.mark.numeric
def test_held_feet_stay_where_they_stand(jump):
    drifting = jump.copy()
    drifting[..., -1] += 0.002 * np.sin(np.arange(160) / 9)  # the root slides back and forth
    stands = contacts_of(jump, JOINTS)
    stands[:, 100:140] = False
    held = hold_feet(drifting, stands, JOINTS)
    np.testing.assert_allclose(bone_lengths(held), bone_lengths(drifting), atol=1e-6)
    before, after = to_positions(drifting)[0], to_positions(held)[0]
    others = [i for i, name in enumerate(NAMES) if name not in LEGS]
    # As features begin with the figure above the origin, both are in the same place.
    np.testing.assert_allclose(after[:, others], before[:, others], atol=1e-9)
    assert slid(after, stands[0]) < 0.1 * slid(before, stands[0])
    far = slice(100 + contacts.EASE, 140 - contacts.EASE)
    np.testing.assert_allclose(after[far], before[far], atol=1e-9)


@pytest.mark.numeric
def test_legs_within_reach_hold_exactly():
    """A figure whose hips are low enough to reach: the ball of the foot does not move at all."""
    pose = standing()
    pose[:, [i for i, name in enumerate(NAMES) if name not in LEGS], 1] -= 0.05
    sway = np.zeros((40, 3))
    sway[:, 2] = 0.02 * np.sin(np.arange(40) / 5)
    pose += sway[:, np.newaxis]
    # Give the legs their lengths again: knees bend ahead.
    features = hold_feet(to_features(pose, JOINTS)[np.newaxis], np.ones((1, 40, 2), bool), JOINTS)
    held = to_positions(features)[0]
    assert np.ptp(held[:, BALLS], axis=0).max() < 1e-9
    legs = [(child, parent) for child, parent in JOINTS.bones if NAMES[child] in LEGS]
    for child, parent in legs:
        np.testing.assert_allclose(np.linalg.norm(held[:, child] - held[:, parent], axis=-1), LENGTHS[child], atol=1e-9)
    knee = held[:, NAMES.index("LeftLeg"), 2] - held[:, NAMES.index("LeftUpLeg"), 2]
    assert (knee > 0).all()


def test_a_place_out_of_reach_is_approached():
    pose = standing()
    pose[20:, [i for i, name in enumerate(NAMES) if name not in LEGS], 2] += 2.0  # the body jumps ahead
    features = to_features(pose, JOINTS)[np.newaxis]
    held = to_positions(hold_feet(features, np.ones((1, 40, 2), bool), JOINTS))[0]
    leg = [NAMES.index(name) for name in ("LeftUpLeg", "LeftFoot")]
    reach = np.linalg.norm(held[:, leg[1]] - held[:, leg[0]], axis=-1)
    longest = LENGTHS[NAMES.index("LeftLeg")] + LENGTHS[NAMES.index("LeftFoot")]
    assert reach.max() <= longest
    np.testing.assert_allclose(reach, contacts.STRAIGHT * longest, atol=1e-9)


def test_without_contacts_nothing_moves(walks):
    still = np.zeros((1, 160, 2), bool)
    held = hold_feet(walks[0], still, JOINTS)
    np.testing.assert_allclose(held[:, 1:], walks[0][:, 1:], atol=1e-6)  # features are computed again
    with pytest.raises(ValueError, match=r"^contacts: expected booleans of shape \(1, 160, 2\)"):
        hold_feet(walks[0], still.astype(float), JOINTS)


@pytest.mark.numeric
def test_a_foot_stands_in_a_blend_where_it_stands_in_the_larger_part(walks, monkeypatch):
    first, second = (contacts_of(walk, JOINTS) for walk in walks)
    seen = []
    monkeypatch.setattr(
        "npss_baselines.manifold.applications.interpolate.hold_feet",
        lambda features, stands, _: seen.append(stands) or features,
    )
    for share in (0.25, 0.5, 0.75):
        possible(blend(*walks, share), *walks, share)
    for stands, expected in zip(seen, (first, first & second, second), strict=True):
        np.testing.assert_array_equal(stands, expected)
