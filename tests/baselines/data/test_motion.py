"""The common form of motion: the 20 joints, clips, and Human3.6M and the generated gait in this form."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from h36m_files import write
from joints import assert_left_is_left, at, lengths
from npss.gait import gait
from npss.skeleton import H36M, poses_to_positions
from npss_baselines.data.h36m_source import h36m_clips
from npss_baselines.data.motion import HEIGHT, JOINTS, NAMES, Clip, joints_of_poses
from npss_baselines.data.synthetic import synthetic_clips


class TestJoints:
    def test_names(self):
        assert len(NAMES) == len(set(NAMES)) == 20
        assert set(NAMES) < set(H36M.names)
        assert JOINTS.names == NAMES
        assert len(JOINTS.bones) == 19
        for name, side in zip(JOINTS.names, JOINTS.sides, strict=True):
            assert side == {"Lef": "left", "Rig": "right"}.get(name[:3], "centre")

    def test_ancestors_are_those_of_human36m_or_where_they_are(self):
        """The shoulders, which are left out, coincide with the neck."""
        for j, parent in JOINTS.bones:
            place = H36M.names.index(NAMES[j])
            while (place := H36M.parents[place]) != H36M.names.index(NAMES[parent]):
                assert H36M.names[place] not in NAMES or H36M.names[place] == "Spine1"
                if H36M.names[place].endswith("Shoulder"):
                    neck = H36M.names.index("Neck")
                    assert H36M.parents[place] == H36M.parents[neck]
                    assert np.array_equal(H36M.offsets[place], H36M.offsets[neck])
                    assert NAMES[parent] == "Neck"
                    break

    @given(st.integers(0, 1000))
    def test_bones_are_those_of_human36m_in_every_pose(self, seed):
        poses = np.random.default_rng(seed).normal(size=(3, 99))
        millimetres = lengths(joints_of_poses(poses))
        spine = 0.2 * (np.array(JOINTS.bones)[:, 0] == NAMES.index("Spine1"))  # 0.1 mm of it turn about the hips
        assert (np.abs(millimetres - millimetres[0]) <= 1e-9 + spine).all()
        other = [name.replace("Left", "*").replace("Right", "Left").replace("*", "Right") for name in NAMES]
        bones = {NAMES[j]: length for (j, _), length in zip(JOINTS.bones, millimetres[0], strict=True)}
        alike = [(bones[NAMES[j]] + bones[other[j]]) / 2 for j, _ in JOINTS.bones]
        height = bones["LeftLeg"] + bones["LeftFoot"] + bones["RightLeg"] + bones["RightFoot"]
        height = height / 2 + bones["Spine1"] + bones["Neck"] + bones["Head"]
        rest = lengths(JOINTS.positions(np.tile(np.eye(3), (20, 1, 1))))
        assert np.allclose(rest * height, alike, rtol=1e-3, atol=1e-12)
        assert np.allclose(rest / rest[1] * alike[1], alike, rtol=0, atol=1e-9 + spine)

    def test_rest(self):
        rest = JOINTS.positions(np.tile(np.eye(3), (20, 1, 1)))
        assert HEIGHT == 1
        assert rest[:, 1].min() == pytest.approx(0, abs=1e-15)
        assert rest[:, 1].max() == at(rest, "Head")[1] == pytest.approx(HEIGHT, rel=1e-15)
        mirrored = [NAMES.index(n.replace("Left", "*").replace("Right", "Left").replace("*", "Right")) for n in NAMES]
        assert np.array_equal(rest[mirrored] * (-1, 1, 1), rest)
        assert not rest[[NAMES.index(name) for name in ("Hips", "Spine1", "Neck", "Head")]][:, [0, 2]].any()
        assert_left_is_left(rest[np.newaxis])
        arm = [at(rest, f"Left{name}") for name in ("Arm", "ForeArm", "Hand", "HandIndex")]
        assert (np.diff([joint[0] for joint in arm]) > 0).all()
        assert np.allclose([joint[1] for joint in arm], arm[0][1], rtol=1e-15, atol=0)


class TestClip:
    GOOD = Clip("02_01", "cmu", "cmu/02", "walk", 120.0, np.zeros((4, 20, 3)))

    def test_positions_are_float64(self):
        clip = dataclasses.replace(self.GOOD, positions=np.ones((2, 20, 3), np.float32), fps=120)
        assert clip.positions.dtype == np.float64

    @pytest.mark.parametrize(
        ("error", "change", "message"),
        [
            (TypeError, {"fps": "120"}, "cmu 02_01: fps: expected a positive number, got '120'"),
            (ValueError, {"fps": 0.0}, "cmu 02_01: fps: expected a positive, finite number, got 0.0"),
            (ValueError, {"fps": np.inf}, "cmu 02_01: fps: expected a positive, finite number, got inf"),
            (TypeError, {"positions": "none"}, "cmu 02_01: positions: expected real numbers"),
            (
                ValueError,
                {"positions": np.zeros((4, 21, 3))},
                r"cmu 02_01: positions: expected shape \(T, 20, 3\), got",
            ),
            (ValueError, {"positions": np.zeros((20, 3))}, r"cmu 02_01: positions: expected shape \(T, 20, 3\), got"),
            (ValueError, {"positions": np.full((1, 20, 3), np.nan)}, r"cmu 02_01: positions: nan at index \(0, 0, 0\)"),
        ],
    )
    def test_errors(self, error, change, message):
        with pytest.raises(error, match=f"^{message}"):
            dataclasses.replace(self.GOOD, **change)


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    """Three clips of two subjects."""
    root = tmp_path_factory.mktemp("h36m")
    for i, name in enumerate(["S6/walking_2", "S1/smoking_1", "S1/eating_2", "S5/walking_1"]):
        poses = gait(1, 30, fps=50, seed=i)[0]
        write(root / "dataset" / f"{name}.txt", poses)
    return root


class TestHuman36m:
    def test_clips(self, root):
        clips = list(h36m_clips(root, subjects=[6, 1]))
        assert [clip.name for clip in clips] == ["S6/walking_2", "S1/eating_2", "S1/smoking_1"]
        assert [clip.subject for clip in clips] == ["h36m/S6", "h36m/S1", "h36m/S1"]
        assert [clip.description for clip in clips] == ["walking", "eating", "smoking"]
        assert {(clip.source, clip.fps) for clip in clips} == {("h36m", 50)}
        poses = np.loadtxt(root / "dataset/S6/walking_2.txt", delimiter=",")
        expected = poses_to_positions(poses, root="path")
        for name in NAMES:
            joint = expected[:, H36M.names.index(name)]
            assert np.allclose(at(clips[0].positions, name), joint, rtol=0, atol=0.01)  # mm; the loader has float32
        assert not clips[0].positions[0, 0].any()

    def test_all_subjects_and_progress(self, root, tmp_path):
        shares = []
        subjects = [clip.subject for clip in h36m_clips(root, cache=tmp_path, progress=shares.append)]
        assert subjects == ["h36m/S1", "h36m/S1", "h36m/S5", "h36m/S6"]
        assert shares == [0.25, 0.5, 0.75, 1]

    def test_clips_are_read_lazily(self, root, tmp_path):
        (tmp_path / "dataset/S1").mkdir(parents=True)
        (tmp_path / "dataset/S1/walking_1.txt").write_text("broken", encoding="utf-8")
        clips = h36m_clips(tmp_path, subjects=[1])
        with pytest.raises(ValueError, match=r"S1.walking_1.txt: line 1 has 1 columns"):
            next(clips)

    @pytest.mark.parametrize(
        ("error", "subjects", "message"),
        [
            (ValueError, [2], r"subjects: expected one or more of \(1, 5, 6, 7, 8, 9, 11\), got 2"),
            (ValueError, ["S1"], r"subjects: expected one or more of \(1, 5, 6, 7, 8, 9, 11\), got 'S1'"),
            (ValueError, [1, 7], r"subjects: .*dataset has no clips of 7"),
            (TypeError, 1, "subjects: expected a sequence of"),
        ],
    )
    def test_missing_subjects(self, root, error, subjects, message):
        with pytest.raises(error, match=message):
            h36m_clips(root, subjects=subjects)

    def test_no_data(self, tmp_path):
        with pytest.raises(FileNotFoundError, match=r"no Human3.6M"):
            h36m_clips(tmp_path)

    def test_real_motion(self, h36m_root):
        clip = next(h36m_clips(h36m_root, subjects=[6]))
        assert clip.name == "S6/directions_1"
        assert len(clip.positions) > 500
        assert np.ptp(lengths(clip.positions), axis=0).max() < 0.2  # mm; see above
        assert_left_is_left(clip.positions)
        speed = np.linalg.norm(np.diff(at(clip.positions, "Hips"), axis=0), axis=-1) * 50
        assert speed.max() < 3000  # mm/s


@pytest.fixture(scope="module")
def clips():
    return list(synthetic_clips(6, 400, seed=3))


class TestSynthetic:
    def test_names(self, clips):
        assert [clip.name for clip in clips] == [f"gait/{i}" for i in range(6)]
        assert [clip.subject for clip in clips] == [f"synthetic/{i}" for i in range(6)]
        assert {(clip.source, clip.description, clip.fps) for clip in clips} == {("synthetic", "gait", 30)}

    def test_walks_depend_on_the_seed_alone(self, clips):
        (again, *_), (other, *_) = synthetic_clips(1, 400, seed=3), synthetic_clips(1, 400, seed=4)
        assert np.array_equal(again.positions, clips[0].positions)
        assert not np.allclose(other.positions, clips[0].positions)
        assert not np.allclose(clips[1].positions, clips[0].positions)

    def test_they_walk_ahead_upright_on_the_ground(self, clips):
        for clip in clips:
            positions = clip.positions
            assert positions[..., 1].min() == 0
            assert_left_is_left(positions)
            step = np.diff(at(positions, "Hips"), axis=0)
            assert (np.linalg.norm(step, axis=-1) * 30 / 1000).max() < 4  # m/s
            ahead = np.cross(at(positions, "LeftUpLeg") - at(positions, "RightUpLeg"), [0, 1, 0])[:-1]
            assert (step * ahead).sum(-1).min() > 0
            feet = np.minimum(at(positions, "LeftFoot")[:, 1], at(positions, "RightFoot")[:, 1])
            assert feet.max() < 400  # mm

    def test_paths_wind(self, clips):
        for clip in clips:
            across = at(clip.positions, "LeftUpLeg") - at(clip.positions, "RightUpLeg")
            assert np.ptp(np.unwrap(np.arctan2(across[:, 0], across[:, 2]))) > 0.2

    def test_other_frame_rates(self):
        (clip,) = synthetic_clips(1, 100, seed=0, fps=120)
        assert clip.fps == 120

    @pytest.mark.parametrize(
        ("error", "n", "n_frames"), [(ValueError, 0, 10), (TypeError, 1.0, 10), (ValueError, 1, 0)]
    )
    def test_errors(self, error, n, n_frames):
        with pytest.raises(error, match="expected a positive integer"):
            next(synthetic_clips(n, n_frames, seed=0))
