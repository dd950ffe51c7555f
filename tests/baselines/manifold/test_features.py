"""Tests of resampling, bone lengths, features and windows: oracles, recovery and invariances."""

import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from npss.skeleton import Skeleton
from npss_baselines.data.h36m import load, open_root
from npss_baselines.data.motion import JOINTS, joints_of_poses
from npss_baselines.data.synthetic import synthetic_clips
from npss_baselines.manifold.motion.bones import normalise_lengths
from npss_baselines.manifold.motion.features import ACROSS, FPS, local_positions, to_features, to_positions
from npss_baselines.manifold.motion.ground import BELOW_GROUND, level, on_ground
from npss_baselines.manifold.motion.resample import resample
from npss_baselines.manifold.motion.windows import STEP, WINDOW, left_out, windows_of

J = {name: j for j, name in enumerate(JOINTS.names)}
SEEDS = st.integers(0, 2**32 - 1)


def walk(seed=0, n_frames=200):
    """Return a generated walk in body heights, ``(T, 20, 3)``."""
    return normalise_lengths(next(synthetic_clips(1, n_frames, seed=seed)).positions, JOINTS)


def random_motion(seed, n_frames=12):
    """Return random motion of all joints that has a facing direction."""
    rng = np.random.default_rng(seed)
    figure = JOINTS.positions(np.tile(np.eye(3), (20, 1, 1))) + 0.02 * rng.normal(size=(n_frames, 20, 3)).cumsum(axis=0)
    turns = Rotation.from_euler("y", rng.uniform(-3, 3, (n_frames, 1))).as_matrix()
    return np.einsum("tij,tkj->tki", turns, figure) + rng.normal(size=(n_frames, 1, 3)) * (1, 0, 1)


def moved(positions, angle, place):
    """Turn positions about y, then shift them along the ground."""
    turn = Rotation.from_euler("y", angle).as_matrix()
    return positions @ turn.T + (place[0], 0, place[1])


def begun(positions):
    """Move positions so that the first frame has its root above the origin and faces +z."""
    return moved(positions - positions[0, 0] * (1, 0, 1), -facing_oracle(positions[0]), (0, 0))


def facing_oracle(pose):
    across = sum(pose[J[left]] - pose[J[right]] for left, right in ACROSS)
    ahead = np.cross(across, [0, 1, 0])
    return np.arctan2(ahead[0], ahead[2])


def features_oracle(positions):
    """Compute features frame by frame, by rotation matrices."""
    rows = []
    for t, pose in enumerate(positions):
        back = Rotation.from_euler("y", -facing_oracle(pose))
        before = positions[t - 1] if t else pose
        turn = (
            Rotation.from_euler("y", facing_oracle(pose)) * Rotation.from_euler("y", -facing_oracle(before))
        ).as_rotvec()
        velocity = back.apply(pose[0] - before[0])
        rows.append([*back.apply(pose - pose[0] * (1, 0, 1)).ravel(), turn[1], velocity[0], velocity[2]])
    rows[0][-3:] = rows[1][-3:]
    return np.array(rows)


# Features


@pytest.mark.numeric
@pytest.mark.parametrize("motion", [walk(), random_motion(3)])
def test_features_against_matrices_frame_by_frame(motion):
    got = to_features(motion, JOINTS)
    assert got.shape == (len(motion), 63)
    np.testing.assert_allclose(got, features_oracle(motion), rtol=0, atol=1e-12)


@pytest.mark.numeric
def test_features_of_a_standing_figure_are_its_positions():
    rest = np.tile(JOINTS.positions(np.tile(np.eye(3), (20, 1, 1))), (5, 1, 1))
    np.testing.assert_allclose(
        to_features(rest, JOINTS), np.c_[rest.reshape(5, 60), np.zeros((5, 3))], rtol=0, atol=1e-14
    )


@pytest.mark.numeric
def test_directions_and_signs():
    angle = np.linspace(0, np.pi / 2, 31)  # from facing +z to facing +x, which is its left
    rest = JOINTS.positions(np.tile(np.eye(3), (20, 1, 1)))
    place = np.stack([1 - np.cos(angle), 0 * angle, np.sin(angle)], axis=-1)  # a quarter of a circle, by the left
    motion = np.stack([moved(rest, a, (0, 0)) + p for a, p in zip(angle, place, strict=True)])
    features = to_features(motion, JOINTS)
    assert (local_positions(features)[:, J["LeftHand"], 0] > 0.1).all()
    assert (local_positions(features)[:, J["LeftToeBase"], 2] > 0.02).all()
    np.testing.assert_allclose(features[:, -3], np.pi / 60)
    assert (features[:, -1] > 0.05).all()
    assert abs(features[:, -2]).max() < 0.002


@pytest.mark.numeric
@given(SEEDS, st.floats(-10, 10), st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)))
def test_features_are_invariant_to_place_and_direction(seed, angle, place):
    motion = random_motion(seed)
    expected = to_features(motion, JOINTS)
    got = to_features(moved(motion, angle, place), JOINTS)
    wrap = (got - expected)[:, -3]  # half a turn is pi or -pi
    got[:, -3] = expected[:, -3] + wrap - 2 * np.pi * np.round(wrap / (2 * np.pi))
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-9)


@pytest.mark.numeric
def test_height_and_tilt_matter():
    motion = random_motion(1)
    higher = to_features(motion + (0, 0.5, 0), JOINTS) - to_features(motion, JOINTS)
    np.testing.assert_allclose(higher, np.r_[np.tile([0, 0.5, 0], 20), 0, 0, 0] * np.ones((12, 1)), rtol=0, atol=1e-12)
    tilted = motion @ Rotation.from_euler("x", 0.3).as_matrix().T
    assert abs(to_features(tilted, JOINTS) - to_features(motion, JOINTS)).max() > 0.1


@pytest.mark.numeric
@given(SEEDS)
def test_recovery(seed):
    motion = random_motion(seed)
    np.testing.assert_allclose(to_positions(to_features(motion, JOINTS)), begun(motion), rtol=0, atol=1e-12)


@pytest.mark.numeric
@given(SEEDS)
def test_features_of_recovered_positions_are_the_same(seed):
    features = to_features(random_motion(seed), JOINTS)
    np.testing.assert_allclose(to_features(to_positions(features), JOINTS), features, rtol=0, atol=1e-12)


@pytest.mark.numeric
def test_the_velocities_of_the_first_frame_do_not_matter_for_recovery():
    features = to_features(random_motion(5), JOINTS)
    other = features.copy()
    other[0, -3:] = 7
    np.testing.assert_array_equal(to_positions(other), to_positions(features))
    other[1, -3:] = 7
    assert abs(to_positions(other) - to_positions(features)).max() > 1


@pytest.mark.numeric
@given(SEEDS, st.integers(1, 8))
def test_features_of_a_part_are_a_part_of_the_features(seed, start):
    motion = random_motion(seed)
    whole, part = to_features(motion, JOINTS)[start:], to_features(motion[start:], JOINTS)
    np.testing.assert_allclose(part[1:], whole[1:], rtol=0, atol=1e-12)
    np.testing.assert_allclose(part[0, :-3], whole[0, :-3], rtol=0, atol=1e-12)
    np.testing.assert_array_equal(part[0, -3:], part[1, -3:])


def test_turns_are_wrapped():
    rest = JOINTS.positions(np.tile(np.eye(3), (20, 1, 1)))
    motion = np.stack([moved(rest, angle, (0, 0)) for angle in (3, -3, 3, 0)])  # through pi, back, and on
    turns = to_features(motion, JOINTS)[1:, -3]
    np.testing.assert_allclose(turns, [2 * np.pi - 6, 6 - 2 * np.pi, -3])


@pytest.mark.numeric
def test_leading_axes_and_precision():
    motions = np.stack([random_motion(1), random_motion(2)])
    features = to_features(motions[np.newaxis], JOINTS)
    assert features.shape == (1, 2, 12, 63)
    for i in (0, 1):
        np.testing.assert_array_equal(features[0, i], to_features(motions[i], JOINTS))
        np.testing.assert_array_equal(to_positions(features)[0, i], to_positions(features[0, i]))
    narrow = to_positions(features.astype(np.float32))
    assert narrow.dtype == np.float32
    assert to_positions(features).dtype == np.float64
    assert local_positions(features).shape == (1, 2, 12, 20, 3)
    assert np.shares_memory(local_positions(features), features)


@pytest.mark.numeric
def test_a_single_frame_does_not_move():
    features = to_features(walk()[:1], JOINTS)
    assert not features[0, -3:].any()
    assert to_positions(features).shape == (1, 20, 3)


def test_pairs_of_other_skeletons():
    wheel = Skeleton(["body", "a", "b"], [-1, 0, 0], [[0, 0, 0], [2, 0, 0], [-1, 0, 0]])
    motion = np.random.default_rng(0).normal(size=(9, 3, 3))
    features = to_features(motion, wheel, across=[("a", "b")])
    assert features.shape == (9, 12)
    first = local_positions(features)[:, 1] - local_positions(features)[:, 2]
    np.testing.assert_allclose(first[:, 2], 0, rtol=0, atol=1e-12)  # across: along x, from b to a
    assert (first[:, 0] > 0).all()
    shape = np.linalg.norm(motion[:, :, np.newaxis] - motion[:, np.newaxis], axis=-1)
    back = to_positions(features)
    np.testing.assert_allclose(np.linalg.norm(back[:, :, np.newaxis] - back[:, np.newaxis], axis=-1), shape)


def test_undefined_facing_direction():
    motion = walk()[:20].copy()
    on_its_side = Rotation.from_euler("z", np.pi / 2).as_matrix()
    rest = JOINTS.positions(np.tile(np.eye(3), (20, 1, 1)))
    motion[7] = rest @ on_its_side.T
    with pytest.raises(ValueError, match=r"^positions: no facing direction at frame 7: .*RightArm to LeftArm"):
        to_features(motion, JOINTS)
    with pytest.raises(ValueError, match=r"at frame \(1, 7\)"):
        to_features(np.stack([walk()[:20], motion]), JOINTS)
    motion[7] = rest
    for name in ("LeftArm", "RightArm"):  # shoulders against hips: they cancel
        other = "RightUpLeg" if name[0] == "L" else "LeftUpLeg"
        motion[7, J[name]] = rest[J[other]]
    with pytest.raises(ValueError, match=r"^positions: no facing direction at frame 7"):
        to_features(motion, JOINTS)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (
            lambda: to_features(np.zeros((4, 19, 3)), JOINTS),
            ValueError,
            r"^positions: expected shape \(\.\.\., T, 20, 3\)",
        ),
        (lambda: to_features(np.zeros((0, 20, 3)), JOINTS), ValueError, r"^positions: expected shape"),
        (lambda: to_features(np.full((2, 20, 3), np.nan), JOINTS), ValueError, r"^positions: nan at index \(0, 0, 0\)"),
        (lambda: to_features("walk", JOINTS), TypeError, r"^positions: expected real numbers"),
        (lambda: to_features(walk(), JOINTS, across=[]), ValueError, r"^across: expected at least one pair"),
        (lambda: to_features(walk(), JOINTS, across=[("Hips", "Tail")]), ValueError, r"^across: .*'Tail'"),
        (lambda: to_features(walk(), JOINTS, across="hips"), TypeError, r"^across: expected a sequence"),
        (lambda: to_positions(np.zeros((5, 62))), ValueError, r"^features: expected shape \(\.\.\., T, 3 J \+ 3\)"),
        (lambda: to_positions(np.zeros((5, 3))), ValueError, r"^features: expected shape"),
        (lambda: to_positions(np.full((5, 6), np.inf)), ValueError, r"^features: inf at index \(0, 0\)"),
        (lambda: local_positions(np.zeros(63)), ValueError, r"^features: expected shape"),
    ],
)
def test_bad_input_to_features(call, error, message):
    with pytest.raises(error, match=message):
        call()


# Lengths


def lengths(positions, skeleton=JOINTS):
    child, parent = np.array([(j, p) for j, p in enumerate(skeleton.parents) if p >= 0]).T
    bones = positions[..., child, :] - positions[..., parent, :]
    length = np.linalg.norm(bones, axis=-1, keepdims=True)
    return length[..., 0], bones / length


TARGET = np.linalg.norm(JOINTS.offsets[1:], axis=-1)


@pytest.mark.numeric
@given(SEEDS)
def test_lengths_change_and_directions_stay(seed):
    motion = 170 * random_motion(seed)
    got = normalise_lengths(motion, JOINTS)
    length, direction = lengths(got)
    np.testing.assert_allclose(length, np.tile(TARGET, (12, 1)), rtol=1e-12)
    np.testing.assert_allclose(direction, lengths(motion)[1], rtol=0, atol=1e-12)


@pytest.mark.numeric
@given(SEEDS, st.floats(1e-3, 1e3))
def test_normalisation_is_idempotent_and_ignores_the_unit(seed, unit):
    once = normalise_lengths(random_motion(seed), JOINTS)
    np.testing.assert_allclose(normalise_lengths(once, JOINTS), once, rtol=0, atol=1e-12)
    np.testing.assert_allclose(normalise_lengths(unit * random_motion(seed), JOINTS), once, rtol=0, atol=1e-12)


@pytest.mark.numeric
def test_the_path_is_scaled_by_the_legs():
    motion = random_motion(4)
    leg = sum(np.linalg.norm(motion[:, J[f"{side}{a}"]] - motion[:, J[f"{side}{b}"]], axis=-1).mean()
              for side in ("Left", "Right") for a, b in (("UpLeg", "Leg"), ("Leg", "Foot")))  # fmt: skip
    wanted = sum(
        np.linalg.norm(JOINTS.offsets[J[f"{side}{name}"]]) for side in ("Left", "Right") for name in ("Leg", "Foot")
    )
    np.testing.assert_allclose(normalise_lengths(motion, JOINTS)[:, 0], motion[:, 0] * wanted / leg)
    hands = normalise_lengths(motion, JOINTS, legs=[("LeftArm", "LeftHand")])
    assert abs(hands[:, 0] - normalise_lengths(motion, JOINTS)[:, 0]).max() > 1e-3


@pytest.mark.numeric
def test_zero_length_bones():
    names, parents = ["root", "knee", "foot", "tip"], [-1, 0, 1, 2]
    blunt = Skeleton(names, parents, [[0, 0, 0], [0, -2, 0], [0, -2, 0], [0, 0, 0]])
    pointed = Skeleton(names, parents, [[0, 0, 0], [0, -2, 0], [0, -2, 0], [0, 0, 1]])
    motion = np.array([[[0, 2, 0], [0, 1, 0], [0, 0, 0], [0, 0, 3]], [[0, 2, 0], [0, 1, 0], [0, 0, 0], [0, 0, 0]]])
    got = normalise_lengths(motion, blunt, legs=[("root", "foot")])
    np.testing.assert_array_equal(got[:, 3], got[:, 2])
    np.testing.assert_array_equal(got[0, :3], 2 * motion[0, :3])
    with pytest.raises(ValueError, match=r"^positions: tip coincides with its parent foot at frame 1, "):
        normalise_lengths(motion, pointed, legs=[("root", "foot")])
    with pytest.raises(ValueError, match=r"^positions: tip coincides with its parent foot at frame \(0, 1\)"):
        normalise_lengths(motion[np.newaxis], pointed, legs=[("root", "foot")])


@pytest.mark.parametrize(
    ("legs", "message"),
    [
        ([("LeftFoot", "LeftUpLeg")], "^legs: LeftUpLeg is not below LeftFoot"),
        ([("LeftUpLeg", "RightFoot")], "^legs: RightFoot is not below LeftUpLeg"),
        ([("Hips", "Tail")], "^legs: .*'Tail'"),
        ([("Hips", "Hips")], "^legs: the skeleton's legs have no length"),
        ([], "^legs: expected at least one pair"),
    ],
)
def test_bad_legs(legs, message):
    with pytest.raises(ValueError, match=message):
        normalise_lengths(walk(), JOINTS, legs=legs)


# Ground


def standing_here_and_there(reach, lean=0.05):
    """Return a figure that stands for ten frames at each of twenty places, leaning left in the first."""
    rest = JOINTS.positions(np.tile(np.eye(3), (20, 1, 1)))
    places = reach * np.random.default_rng(0).uniform(-1, 1, (20, 3)) * (1, 0, 1)
    motion = np.repeat(rest + places[:, np.newaxis], 10, axis=0)
    motion[0] = moved(rest @ Rotation.from_euler("z", -lean).as_matrix().T, 0, places[0, ::2])
    return motion


def degrees_from_level(motion, flat):
    """Return the angle between y and the up direction of a motion that is `flat`, rotated."""
    turn = Rotation.align_vectors(motion.reshape(-1, 3), flat.reshape(-1, 3))[0]
    return np.degrees(np.arccos(turn.apply([0, 1, 0])[1]))


@pytest.mark.numeric
@given(st.floats(-0.5, 0.5), st.floats(-0.5, 0.5))
def test_level_undoes_any_tilt(about_x, about_z):
    flat = standing_here_and_there(3)
    tilted = flat @ Rotation.from_rotvec([about_x, 0, about_z]).as_matrix().T
    got = level(tilted, JOINTS)
    assert degrees_from_level(got, flat) < 0.05
    np.testing.assert_allclose(got[..., 1], level(flat, JOINTS)[..., 1], rtol=0, atol=1e-4)
    np.testing.assert_allclose(lengths(got)[0], lengths(flat)[0], rtol=1e-9)


@pytest.mark.numeric
def test_weight_of_the_first_frame_drops_with_distance():
    angles = [degrees_from_level(level(flat, JOINTS), flat) for flat in map(standing_here_and_there, (0, 0.1, 0.3, 3))]
    assert angles[0] > angles[1] > angles[2] > angles[3]
    assert 3 < angles[0] < 5  # it leans to the side, and its neck is behind its toes
    assert angles[3] < 0.05


@pytest.mark.numeric
def test_level_without_ground_contact_uses_the_first_frame():
    rest = JOINTS.positions(np.tile(np.eye(3), (20, 1, 1)))
    flying = rest + np.arange(50)[:, np.newaxis, np.newaxis] * np.array([0.1, 0.05, 0.02])
    feet = rest[[J[name] for name in ("LeftFoot", "RightFoot", "LeftToeBase", "RightToeBase")]].mean(axis=0)
    stands = rest[J["Neck"]] - feet
    turn = Rotation.align_vectors([[0, 1, 0]], [stands])[0].as_matrix()
    got = level(flying[1:], JOINTS)
    np.testing.assert_allclose(got[..., 1], (flying[1:] @ turn.T)[..., 1], rtol=0, atol=1e-9)


@pytest.mark.numeric
def test_the_ground_is_where_feet_are():
    motion = on_ground(walk() + (0, 3, 0))
    lowest = motion[..., 1].min(axis=-1)
    assert (lowest <= 1e-12).mean() == pytest.approx(BELOW_GROUND, abs=0.006)
    np.testing.assert_array_equal((motion - walk())[..., ::2], 0)


# Resampling


def tone(hertz, fps, n_frames, phase=0.3):
    return np.sin(2 * np.pi * hertz * np.arange(n_frames) / fps + phase)[:, np.newaxis]


@pytest.mark.numeric
@pytest.mark.parametrize(
    ("fps", "rate"), [(120, 120), (50, 50), (120.0000480000192, 120), (59.94, 59.94), (1 / 0.008333, 120)]
)
def test_tones_below_the_pass_band_edge_are_kept(fps, rate):
    for hertz in (0.5, 3, 7, 11, 12):
        got = resample(tone(hertz, rate, 800), fps)[30:-30]
        np.testing.assert_allclose(got, tone(hertz, 30, 2000)[30 : 30 + len(got)], rtol=0, atol=2e-3)


@pytest.mark.numeric
@pytest.mark.parametrize("fps", [120, 50, 59.94, 100])
def test_tones_above_the_nyquist_frequency_are_suppressed(fps):
    for hertz in (15, 16, 18, 22, 24.9):
        motion = tone(hertz, fps, 1200, phase=1)
        assert abs(resample(motion, fps)[40:-40]).max() < 3e-4
        assert abs(motion[:: round(fps / 30)][40:-40]).max() > 0.5  # what every n-th frame makes of it


@pytest.mark.numeric
@given(st.integers(1, 400), st.sampled_from([120, 50, 25, 59.94, 29.97, 100, 24, 240]), SEEDS)
def test_length_first_frame_and_motion_at_constant_speed(n_frames, fps, seed):
    rng = np.random.default_rng(seed)
    place, speed = rng.normal(size=(2, 3, 3))
    motion = place + speed * np.arange(n_frames)[:, np.newaxis, np.newaxis] / fps
    got = resample(motion, fps)
    assert len(got) == int((n_frames - 1) * 30 / fps + 1e-9) + 1
    np.testing.assert_allclose(
        got, place + speed * np.arange(len(got))[:, np.newaxis, np.newaxis] / 30, rtol=0, atol=1e-9
    )
    noise = rng.normal(size=(n_frames, 2))
    np.testing.assert_allclose(resample(noise, fps)[0], noise[0], rtol=0, atol=1e-9)


def test_constants_far_from_the_origin_are_exact():
    motion = np.c_[tone(1, 50, 300), np.full(300, 1e6)]
    assert abs(resample(motion, 50)[:, 1] - 1e6).max() < 1e-6


@pytest.mark.numeric
@given(st.integers(1, 40), st.sampled_from([30, 50.0, 120]))
def test_the_same_rate_is_the_same_motion(n_frames, fps):
    motion = np.random.default_rng(n_frames).normal(size=(n_frames, 2, 3))
    got = resample(motion, fps, to=fps)
    np.testing.assert_array_equal(got, motion)
    assert not np.shares_memory(got, motion)


@pytest.mark.numeric
def test_resampling_is_linear_and_symmetric_in_time():
    a, b = np.random.default_rng(0).normal(size=(2, 401, 5))
    np.testing.assert_allclose(resample(2 * a - b, 120), 2 * resample(a, 120) - resample(b, 120), rtol=0, atol=1e-12)
    np.testing.assert_allclose(resample(a[::-1], 120), resample(a, 120)[::-1], rtol=0, atol=1e-12)


@pytest.mark.parametrize(
    ("positions", "fps", "error", "message"),
    [
        (np.zeros((0, 20, 3)), 120, ValueError, r"^positions: expected shape"),
        (np.full((3, 1), np.inf), 120, ValueError, r"^positions: inf at index \(0, 0\)"),
        ([["a"]], 120, TypeError, "^positions: expected real numbers"),
        (np.zeros((3, 1)), 0, ValueError, "^fps: expected a positive"),
        (np.zeros((3, 1)), "120", TypeError, "^fps: expected a positive"),
        (np.zeros((3, 1)), 30.005, ValueError, r"^fps: 30.005 to 30 frames per second is not within 0.0001 of a ratio"),
        (np.zeros((3, 1)), 1e6, ValueError, "^fps: 1e\\+06 to 30 frames per second is not within 0.0001 of a ratio"),
        (np.zeros((3, 1)), 1e-6, ValueError, "^fps: 1e-06 to 30 frames per second is not within 0.0001 of a ratio"),
    ],
)
def test_bad_input_to_resample(positions, fps, error, message):
    with pytest.raises(error, match=message):
        resample(positions, fps)


def test_without_scipy(monkeypatch):
    monkeypatch.setitem(sys.modules, "scipy.signal", None)
    with pytest.raises(ImportError, match=r"resampling needs scipy; .*'./baselines\[manifold\]'"):
        resample(np.zeros((9, 1)), 120)


# Windows


@pytest.mark.numeric
@given(st.integers(1, 700))
def test_windows_against_a_loop(n_frames):
    clip = np.random.default_rng(n_frames).normal(size=(n_frames, 2))
    windows, mask = windows_of(clip)
    assert windows.shape[1:] == (WINDOW, 2)
    starts = [s for s in range(0, n_frames, STEP) if s + WINDOW <= n_frames]
    if starts:
        np.testing.assert_array_equal(windows, [clip[s : s + WINDOW] for s in starts])
        assert mask.all()
        assert left_out(n_frames) == n_frames - starts[-1] - WINDOW
    else:
        there_and_back = [*range(n_frames), *range(n_frames - 2, 0, -1)]
        mirrored = [there_and_back[t % len(there_and_back)] for t in range(WINDOW)]
        np.testing.assert_array_equal(windows, clip[mirrored][np.newaxis])
        np.testing.assert_array_equal(mask, [[t < n_frames for t in range(WINDOW)]])
        assert left_out(n_frames) == 0


def test_windows_keep_their_precision_and_share_no_memory():
    clip = np.zeros((300, 63), np.float32)
    windows, mask = windows_of(clip)
    assert windows.dtype == np.float32
    assert mask.dtype == bool
    windows[0] = 1
    assert not clip.any()
    assert not windows[1].any()


@pytest.mark.parametrize(
    ("clip", "options", "error", "message"),
    [
        (np.zeros((0, 63)), {}, ValueError, "^features: expected shape"),
        (np.zeros(63), {}, ValueError, "^features: expected shape"),
        (np.zeros((9, 2)), {"window": 0}, ValueError, "^window: expected a positive"),
        (np.zeros((9, 2)), {"step": 2.5}, TypeError, "^step: expected a positive"),
    ],
)
def test_bad_input_to_windows(clip, options, error, message):
    with pytest.raises(error, match=message):
        windows_of(clip, **options)


# Real motion


@pytest.mark.numeric
@pytest.mark.parametrize("name", [(7, "walking"), (5, "sitting")])
def test_recovery_of_whole_clips(h36m_root, name):
    poses = load(open_root(h36m_root), *name, 1)
    motion = level(normalise_lengths(resample(joints_of_poses(poses.astype(float)), 50), JOINTS), JOINTS)
    assert len(motion) > 2000
    features = to_features(motion, JOINTS)
    assert abs(to_positions(features) - begun(motion)).max() < 1e-11
    assert abs(to_positions(features.astype(np.float32)) - begun(motion)).max() < 1e-6


@pytest.mark.numeric
@pytest.mark.parametrize("subject", [1, 5, 9])
def test_human36m_walks_are_level(h36m_root, subject):
    """The files' first frame is upright by definition, though the pelvis was tilted: without `level`, paths climb."""
    poses = load(open_root(h36m_root), subject, "walking", 1)
    motion = normalise_lengths(resample(joints_of_poses(poses.astype(float)), 50), JOINTS)
    assert np.ptp(motion[:, 0, 1]) > 0.3
    levelled = on_ground(level(motion, JOINTS))
    assert np.ptp(levelled[:, 0, 1]) < 0.1
    assert abs(levelled[..., 1].min(axis=-1)).max() < 0.03  # one foot is always on the ground


def test_fps_of_the_paper():
    assert (FPS, WINDOW, STEP) == (30, 160, 80)
