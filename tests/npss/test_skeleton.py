"""Forward kinematics: oracles with the row vectors of the files, anatomy of real motion, bad input."""

import dataclasses
import json

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from npss import gait, poses_to_euler
from npss.skeleton import FEATURE_NAMES, H36M, Skeleton, poses_to_positions
from npss_baselines.data import h36m

JOINT = {name: j for j, name in enumerate(H36M.names)}


def random_poses(*leading, seed=0):
    poses = np.random.default_rng(seed).normal(size=(*leading, 99))
    poses[..., :3] *= 20
    poses[..., 3:6] *= 0.1
    return poses


def row_vector_oracle(pose, facing, place):
    """Return the positions of a pose, joint by joint, following the description of the files."""
    turned, position = [], []
    for j, parent in enumerate(H36M.parents):
        if parent == -1:
            turned.append(facing)
            position.append(place)
        else:
            local = Rotation.from_rotvec(pose[3 + 3 * j : 6 + 3 * j]).as_matrix()
            turned.append(local @ turned[parent])
            position.append(H36M.offsets[j] @ turned[parent] + position[parent])
    return np.array(position)


def path_oracle(poses):
    """Return the positions of a sequence with accumulated displacements and turns, with row vectors."""
    facing, place, positions = np.eye(3), np.zeros(3), []
    for t, pose in enumerate(poses):
        if t > 0:
            place = place + pose[:3] @ facing
            facing = Rotation.from_rotvec(pose[3:6]).as_matrix() @ facing
        positions.append(row_vector_oracle(pose, facing, place))
    return np.array(positions)


@pytest.mark.numeric
def test_poses_against_row_vectors_joint_by_joint():
    poses = random_poses(2, 5)
    got = poses_to_positions(poses)
    assert got.shape == (2, 5, 32, 3)
    expected = np.array([[row_vector_oracle(pose, np.eye(3), np.zeros(3)) for pose in sequence] for sequence in poses])
    np.testing.assert_allclose(got, expected, rtol=0, atol=1e-9)


@pytest.mark.numeric
def test_a_path_against_row_vectors_frame_by_frame():
    poses = random_poses(2, 6, seed=1)
    got = poses_to_positions(poses, root="path")
    np.testing.assert_allclose(got, [path_oracle(sequence) for sequence in poses], rtol=0, atol=1e-9)
    np.testing.assert_allclose(got[:, 0], poses_to_positions(poses[:, 0]), rtol=0, atol=1e-9)


@pytest.mark.numeric
def test_a_fixed_root_hides_unscored_columns():
    poses = random_poses(3, 4)
    moved = poses.copy()
    moved[..., :6] = random_poses(3, 4, seed=9)[..., :6]
    np.testing.assert_array_equal(poses_to_positions(poses), poses_to_positions(moved))
    assert not poses_to_positions(poses)[..., 0, :].any()
    assert abs(poses_to_positions(poses, root="path") - poses_to_positions(moved, root="path")).max() > 1


@pytest.mark.numeric
@pytest.mark.parametrize("root", ["fixed", "path"])
@pytest.mark.parametrize("leading", [(1,), (0,), (2, 0), (0, 3)])
def test_leading_axes_and_precision(root, leading):
    poses = random_poses(*leading)
    got = poses_to_positions(poses, root=root)
    assert got.shape == (*leading, 32, 3)
    assert got.dtype == np.float64
    single = poses_to_positions(poses.astype(np.float32), root=root)
    assert single.dtype == np.float32
    np.testing.assert_allclose(single, got, rtol=0, atol=2e-2)


def test_unsigned_integers():
    poses = np.ones((2, 99), np.uint8)
    np.testing.assert_array_equal(poses_to_positions(poses), poses_to_positions(poses.astype(float)))


@pytest.mark.numeric
@given(st.integers(0, 2**32 - 1), st.sampled_from(["fixed", "path"]))
def test_bones_keep_their_lengths(seed, root):
    positions = poses_to_positions(random_poses(3, seed=seed), root=root)
    for child, parent in H36M.bones:
        lengths = np.linalg.norm(positions[:, child] - positions[:, parent], axis=-1)
        np.testing.assert_allclose(lengths, np.linalg.norm(H36M.offsets[child]), rtol=1e-10)


def arms(parents, seed=0):
    rng = np.random.default_rng(seed)
    return Skeleton([f"joint {j}" for j in range(len(parents))], parents, rng.normal(size=(len(parents), 3)))


@st.composite
def trees(draw):
    """Parents in any order: a tree whose joints are renumbered."""
    n = draw(st.integers(1, 8))
    grown = [-1, *(draw(st.integers(0, j - 1)) for j in range(1, n))]
    new = draw(st.permutations(range(n)))
    parents = [0] * n
    for j, parent in enumerate(grown):
        parents[new[j]] = -1 if parent == -1 else new[parent]
    return parents


@pytest.mark.numeric
@pytest.mark.parametrize("bones_change", [False, True])
@given(trees(), st.integers(0, 2**32 - 1))
def test_any_tree_against_a_walk_up_to_the_root(bones_change, parents, seed):
    skeleton = arms(parents, seed)
    rng = np.random.default_rng(seed)
    rotations = Rotation.random(4 * len(parents), random_state=rng).as_matrix().reshape(4, len(parents), 3, 3)
    root = rng.normal(size=(4, 3))
    offsets = rng.normal(size=(4, len(parents), 3)) if bones_change else np.tile(skeleton.offsets, (4, 1, 1))
    got = skeleton.positions(rotations, root=root, offsets=offsets if bones_change else None)
    for t in range(4):
        for joint in range(len(parents)):
            point, j = np.zeros(3), joint
            while parents[j] >= 0:
                point, j = rotations[t, parents[j]] @ (offsets[t, j] + point), parents[j]
            # From the joint up to the root, in the opposite order of the library.
            np.testing.assert_allclose(got[t, joint], root[t] + point, rtol=0, atol=1e-12)


def test_the_root_is_at_its_offset_by_default():
    skeleton = Skeleton(["a", "b"], [-1, 0], [[1, 2, 3], [4, 0, 0]])
    straight = np.tile(np.eye(3), (5, 2, 1, 1))
    np.testing.assert_array_equal(skeleton.positions(straight)[3], [[1, 2, 3], [5, 2, 3]])
    root = np.zeros((5, 3))
    np.testing.assert_array_equal(skeleton.positions(straight, root=root)[3], [[0, 0, 0], [4, 0, 0]])
    assert skeleton.positions(straight.astype(np.float32), root=root).dtype == np.float32


@pytest.mark.numeric
@given(trees(), st.integers(0, 2**32 - 1))
def test_global_rotations_against_a_walk_up_to_the_root(parents, seed):
    skeleton = arms(parents, seed)
    local = Rotation.random(4 * len(parents), random_state=seed).as_matrix().reshape(4, len(parents), 3, 3)
    turned = skeleton.global_rotations(local)
    for t in range(4):
        for joint in range(len(parents)):
            product, j = np.eye(3), joint
            while j >= 0:
                product, j = local[t, j] @ product, parents[j]
            np.testing.assert_allclose(turned[t, joint], product, rtol=0, atol=1e-14)
    np.testing.assert_allclose(skeleton.local_rotations(turned), local, rtol=0, atol=1e-14)
    positions, rotations = skeleton.forward(local)
    np.testing.assert_array_equal(rotations, turned)
    np.testing.assert_array_equal(positions, skeleton.positions(local))


@pytest.mark.numeric
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-3, 0.01, 1 / 2.54, 1000]))
def test_any_unit(seed, unit):
    """Positions are in the unit of the offsets, whatever it is; rotations have none."""
    parents = [-1, 0, 1, 1]
    skeleton = arms(parents, seed)
    scaled = Skeleton(skeleton.names, parents, unit * skeleton.offsets)
    local = Rotation.random(8, random_state=seed).as_matrix().reshape(2, 4, 3, 3)
    one, other = skeleton.forward(local), scaled.forward(local)
    np.testing.assert_allclose(other.positions, unit * one.positions, rtol=1e-13, atol=1e-13 * unit)
    np.testing.assert_array_equal(other.rotations, one.rotations)


def test_precisions_of_global_rotations():
    skeleton = arms([-1, 0, 0])
    straight = np.tile(np.eye(3), (5, 3, 1, 1))
    for given_ in (straight, straight.astype(np.float32), straight.astype(int), straight[:0], straight[0]):
        dtype = np.float32 if given_.dtype == np.float32 else np.float64
        for got in (skeleton.global_rotations(given_), skeleton.local_rotations(given_)):
            assert got.dtype == dtype
            np.testing.assert_array_equal(got, given_)
            assert not np.shares_memory(got, given_)
    broken = straight.copy()
    broken[3, 1, 0, 0] = 2
    for call, name in ((skeleton.global_rotations, "local"), (skeleton.local_rotations, "turned")):
        with pytest.raises(ValueError, match=rf"^{name}: not a rotation matrix .* \(3, 1\)"):
            call(broken)
        with pytest.raises(ValueError, match=rf"^{name}: expected shape \(..., 3, 3, 3\), got"):
            call(straight[:, :2])


@pytest.mark.numeric
def test_bones_that_change():
    """Offsets of every frame replace the skeleton's, including that of the root."""
    skeleton = Skeleton(["a", "b"], [-1, 0], [[1, 2, 3], [4, 0, 0]])
    straight = np.tile(np.eye(3), (2, 2, 1, 1))
    offsets = [[[0, 0, 0], [4, 0, 0]], [[1, 0, 0], [5, 0, 1]]]
    np.testing.assert_array_equal(skeleton.positions(straight, offsets=offsets)[1], [[1, 0, 0], [6, 0, 1]])
    got = skeleton.positions(straight, offsets=offsets, root=np.full((2, 3), 7))
    np.testing.assert_array_equal(got[1], [[7, 7, 7], [12, 7, 8]])
    np.testing.assert_array_equal(skeleton.positions(straight[0], offsets=offsets[1]), [[1, 0, 0], [6, 0, 1]])
    assert skeleton.positions(straight.astype(np.float32), offsets=offsets).dtype == np.float32
    for shape in [(2, 3), (1, 2, 3), (2, 2, 2)]:
        with pytest.raises(ValueError, match=r"^offsets: expected shape \(2, 2, 3\), got"):
            skeleton.positions(straight, offsets=np.zeros(shape))
    with pytest.raises(ValueError, match=r"^offsets: nan at index \(1, 1, 2\)"):
        skeleton.positions(straight, offsets=[offsets[0], [[1, 0, 0], [5, 0, np.nan]]])
    with pytest.raises(TypeError, match=r"^offsets: expected real numbers"):
        skeleton.positions(straight, offsets=[[["0"] * 3] * 2] * 2)


@pytest.mark.numeric
def test_poses_are_positions_of_the_transposed_rotations():
    poses = random_poses(4)
    maps = poses[:, 3:].reshape(4, 32, 3).copy()
    maps[:, 0] = 0
    rotations = Rotation.from_rotvec(maps.reshape(-1, 3)).as_matrix().reshape(4, 32, 3, 3)
    np.testing.assert_allclose(H36M.positions(rotations.swapaxes(-1, -2)), poses_to_positions(poses), rtol=0, atol=1e-9)


def test_bones_and_sides():
    assert len(H36M.bones) == 32 - 1 - 4
    assert all(H36M.parents[child] == parent for child, parent in H36M.bones)
    lengths = np.linalg.norm(H36M.offsets, axis=1)
    assert {child for child, _ in H36M.bones} == set(np.flatnonzero(lengths))
    assert H36M.sides.count("left") == H36M.sides.count("right") == 13
    across = H36M.offsets[:, 0]
    assert all(across[j] > 0 for j, side in enumerate(H36M.sides) if side == "left" and across[j])
    assert Skeleton(["root", "tip"], [-1, 0], np.ones((2, 3))).bones == ((1, 0),)  # the root has no bone
    names = ["LHipJoint", "LowerBack", "LeftFoot", "r_foot", "RThumb", "Rib", "rightHand", "L"]
    skeleton = Skeleton(names, [-1] + [0] * 7, np.ones((8, 3)))
    assert skeleton.sides == ("left", "centre", "left", "right", "right", "centre", "right", "centre")


def test_names_of_features_are_those_of_columns():
    assert len(FEATURE_NAMES) == len(set(FEATURE_NAMES)) == 99
    assert FEATURE_NAMES[:7] == (
        *("translation.x", "translation.y", "translation.z", "Hips.x", "Hips.y", "Hips.z"),
        "RightUpLeg.x",
    )
    for joint, column in ((2, 9), (17, 54), (31, 98 - 2)):
        assert FEATURE_NAMES[column] == f"{H36M.names[joint]}.x"
    # A rotation in a joint's columns moves its descendants, and appears in the same columns of Euler angles.
    for name, moves in (("LeftLeg", "LeftFoot"), ("RightArm", "RightForeArm"), ("Neck", "Head")):
        pose = np.zeros(99)
        column = FEATURE_NAMES.index(f"{name}.x")
        pose[column] = 0.5
        assert set(np.flatnonzero(poses_to_euler(pose))) == {column}
        moved = np.abs(poses_to_positions(pose) - poses_to_positions(np.zeros(99))).max(axis=1) > 1
        assert moved[JOINT[moves]]
        assert not moved[JOINT[name]]


def test_arrays_are_read_only_and_inputs_unchanged():
    offsets = np.zeros((2, 3))
    skeleton = Skeleton(["a", "b"], np.array([-1, 0]), offsets)
    offsets += 1
    assert not skeleton.offsets.any()
    with pytest.raises(ValueError, match="read-only"):
        skeleton.offsets[0] = 1
    with pytest.raises(AttributeError):
        skeleton.names = ("c", "d")
    assert skeleton.parents == (-1, 0)
    assert dataclasses.replace(skeleton, names=["c", "d"]).names == ("c", "d")
    assert all(type(parent) is int for parent in skeleton.parents)
    poses = random_poses(3)
    before = poses.copy()
    poses_to_positions(poses, root="path")
    np.testing.assert_array_equal(poses, before)


@pytest.mark.parametrize(
    ("names", "parents", "offsets", "error", "message"),
    [
        ([], [], np.zeros((0, 3)), ValueError, "names: expected at least one joint"),
        ("ab", [-1, 0], np.zeros((2, 3)), TypeError, "names: expected a sequence of strings, got 'ab'"),
        (["a", 3], [-1, 0], np.zeros((2, 3)), TypeError, "names: expected strings, got 3 at index 1"),
        (["a", "b", "a"], [-1, 0, 0], np.zeros((3, 3)), ValueError, "names: duplicate 'a', at index 0 and 2"),
        (["a", "b"], [-1], np.zeros((2, 3)), ValueError, "parents: expected one for each of 2 joints, got 1"),
        (["a", "b"], [-1, 0.0], np.zeros((2, 3)), TypeError, r"parents: expected integers, got 0.0 for b"),
        (["a", "b"], [-1, True], np.zeros((2, 3)), TypeError, r"parents: expected integers, got True for b"),
        (["a", "b"], [-1, 2], np.zeros((2, 3)), ValueError, "parents: 2 for b; expected -1 or one of the 2 joints"),
        (["a", "b"], [-1, 3], np.zeros((2, 3)), ValueError, "parents: 3 for b"),
        (["a", "b"], [-2, 0], np.zeros((2, 3)), ValueError, "parents: -2 for a"),
        (["a", "b"], [-1, -1], np.zeros((2, 3)), ValueError, "parents: expected one root.*got 2"),
        (["a", "b"], [1, 0], np.zeros((2, 3)), ValueError, "parents: expected one root.*got 0"),
        (["a", "b", "c"], [-1, 2, 1], np.zeros((3, 3)), ValueError, "parents: b is not connected to the root"),
        (["a", "b"], [-1, 0], np.zeros((2, 2)), ValueError, r"offsets: expected shape \(J, 3\) = \(2, 3\), got"),
        (["a", "b"], [-1, 0], np.zeros((2, 4)), ValueError, r"offsets: expected shape \(J, 3\) = \(2, 3\), got"),
        (["a", "b"], [-1, 0], np.zeros((3, 3)), ValueError, r"offsets: expected shape \(J, 3\) = \(2, 3\), got"),
        (["a", "b"], [-1, 0], [[0, 0, 0], [0, np.nan, 0]], ValueError, r"offsets: nan at index \(1, 1\)"),
        (["a", "b"], [-1, 0], [["0"] * 3] * 2, TypeError, "offsets: expected real numbers"),
    ],
)
def test_invalid_skeletons(names, parents, offsets, error, message):
    with pytest.raises(error, match=f"^{message}"):
        Skeleton(names, parents, offsets)


def test_bad_rotations_and_roots():
    skeleton = arms([-1, 0])
    straight = np.tile(np.eye(3), (5, 2, 1, 1))
    with pytest.raises(ValueError, match=r"^rotations: expected shape \(..., 2, 3, 3\), got \(5, 3, 3, 3\)"):
        skeleton.positions(np.tile(np.eye(3), (5, 3, 1, 1)))
    broken = straight.copy()
    broken[3, 1, 0, 0] = 2
    with pytest.raises(ValueError, match=r"^rotations: not a rotation matrix .* \(3, 1\)"):
        skeleton.positions(broken)
    for shape in [(3,), (4, 3), (6, 3), (5, 2), (5, 4), (1, 5, 3)]:
        with pytest.raises(ValueError, match=r"^root: expected shape \(5, 3\), got"):
            skeleton.positions(straight, root=np.zeros(shape))
    with pytest.raises(ValueError, match=r"^root: inf at index \(2, 0\)"):
        skeleton.positions(straight, root=[[0, 0, 0], [0, 0, 0], [np.inf, 0, 0], [0, 0, 0], [0, 0, 0]])


def test_bad_poses():
    with pytest.raises(ValueError, match=r"^poses: expected shape \(..., 99\), got \(4, 54\)"):
        poses_to_positions(np.zeros((4, 54)))
    poses = np.zeros((4, 99))
    poses[2, 1] = np.nan
    with pytest.raises(ValueError, match=r"^poses: nan at index \(2, 1\)"):
        poses_to_positions(poses)
    poses[2, 1], poses[3, 9] = 0, 1e300
    with pytest.raises(ValueError, match=r"^poses: as .* from column 3 on: an angle .* \(3, 2\)"):
        poses_to_positions(poses)
    with pytest.raises(ValueError, match=r"^poses: a path needs a time axis"):
        poses_to_positions(np.zeros(99), root="path")
    with pytest.raises(ValueError, match=r"^root: expected one of fixed, path, got 'still'"):
        poses_to_positions(np.zeros((2, 99)), root="still")
    with pytest.raises(TypeError, match=r"^root: expected one of"):
        poses_to_positions(np.zeros((2, 99)), root=None)


@pytest.mark.numeric
def test_a_generated_gait_stands_upright():
    positions = poses_to_positions(gait.gait(4, 100, seed=0))
    height = positions[..., 1].mean(axis=(0, 1))
    assert height[JOINT["HeadTop"]] > height[JOINT["Hips"]] + 500
    assert max(height[JOINT["LeftFoot"]], height[JOINT["RightFoot"]]) < height[JOINT["Hips"]] - 700


@pytest.fixture(scope="module")
def walking(h36m_root):
    return h36m.load(h36m.open_root(h36m_root), 5, "walking", 1).astype(np.float64)


def ahead_of_line(positions, joint, above, below):
    """Return how far, in mm, a joint is ahead of the line between two others."""
    line = positions[:, JOINT[below]] - positions[:, JOINT[above]]
    bow = positions[:, JOINT[joint]] - positions[:, JOINT[above]]
    return bow[:, 2] - line[:, 2] * bow[:, 1] / line[:, 1]


@pytest.mark.parametrize("side", ["Left", "Right"])
def test_a_real_walker_is_anatomically_right(walking, side):
    positions = poses_to_positions(walking)
    knee = ahead_of_line(positions, f"{side}Leg", f"{side}UpLeg", f"{side}Foot")
    assert np.median(knee) > 40  # knees bend so that the shin goes backwards
    assert knee.min() > -5
    x, y, _ = np.moveaxis(positions, -1, 0)
    assert y[:, JOINT[f"{side}ToeEnd"]].mean() < -700
    assert y[:, JOINT["HeadTop"]].mean() > 500
    sign = 1 if side == "Left" else -1
    assert np.mean(sign * x[:, JOINT[f"{side}Hand"]]) > 100
    assert np.mean(sign * x[:, JOINT[f"{side}Foot"]]) > -30


def test_the_standing_foot_stays_in_place_only_with_row_vectors(walking):
    def slowest_foot(poses):  # mm/s, the slower of the two, over the walk
        velocity = np.linalg.norm(np.diff(poses_to_positions(poses, root="path"), axis=0), axis=-1) * h36m.FILE_FPS
        return np.median(np.minimum(velocity[:, JOINT["LeftToeBase"]], velocity[:, JOINT["RightToeBase"]]))

    other_way = walking.copy()
    other_way[:, 3:] *= -1  # as if R rotated column vectors
    assert slowest_foot(walking) < 60
    assert slowest_foot(other_way) > 600
    still = walking.copy()
    still[:, :6] = 0
    assert slowest_foot(still) > 300


def test_the_skeleton_is_that_of_the_published_files(samples_root):
    description = samples_root.parent / "skeleton_h36m.json"
    if not description.is_file():
        pytest.skip("needs skeleton_h36m.json beside the folder of samples")
    published = json.loads(description.read_text(encoding="utf-8"))
    assert list(H36M.names) == published["joint_names"]
    assert list(H36M.parents) == published["parents"]
    assert H36M.offsets.tolist() == published["offsets_mm"]
