"""CMU's clips: generated files with their hierarchy, and real ones if available."""

import csv
import re
import shutil

import numpy as np
import pytest

from joints import assert_left_is_left, at, lengths
from npss.console._progress import Progress
from npss_baselines.data import bvh
from npss_baselines.data.cmu import CMU_NAMES, LEAD_IN, cmu_clips, styles_clips
from npss_baselines.data.motion import JOINTS, NAMES

ARM = ("Collar", "Shldr", "ForeArm", "Hand", "Mid1", "Mid2")
LEG = ("Buttock", "Thigh", "Shin", "Foot")
CSV = """clip,description
02_01,walk
02_02,"jump, balance"
03_01,walk on uneven terrain
13_30,"jumping jacks, side twists, squats, jog"
"""


def chain(names, below=""):
    """Write a chain of joints at random offsets."""
    if not names:
        return below or "End Site\n{\nOFFSET 0 -1 2\n}\n"
    side = {"l": 1, "r": -1}.get(names[0][0], 0)
    offset = f"{side * (1 + len(names))} {len(names)} 0.25"
    channels = "CHANNELS 3 Zrotation Xrotation Yrotation"
    return f"JOINT {names[0]}\n{{\nOFFSET {offset}\n{channels}\n{chain(names[1:], below)}}}\n"


def motion(n_frames, seed=0):
    """Write a file with the relevant hierarchy of these clips and random numbers."""
    arms = "".join(chain([side + name for name in ARM]) for side in "rl")
    legs = "".join(chain([side + name for name in LEG]) for side in "rl")
    trunk = chain(["abdomen", "chest"], chain(["neck", "head"]) + arms)
    n_joints = 1 + 4 + 2 * (len(ARM) + len(LEG))
    rows = np.random.default_rng(seed).uniform(-50, 50, (n_frames, 3 + 3 * n_joints)).round(3)
    root = "CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation"
    return (
        f"HIERARCHY\nROOT hip\n{{\nOFFSET 0 0 0\n{root}\n{trunk}{legs}}}\nMOTION\nFrames:\t{n_frames}\n"
        f"Frame Time:\t0.00833333\n" + "\n".join(" ".join(map(str, row)) for row in rows) + "\n"
    )


@pytest.fixture(scope="module")
def root(tmp_path_factory):
    root = tmp_path_factory.mktemp("cmu")
    (root / "clips.csv").write_text(CSV, encoding="utf-8")
    for i, name in enumerate(["02_01", "02_02", "03_01", "13_30"]):
        (root / name[:2]).mkdir(exist_ok=True)
        (root / name[:2] / f"{name}.bvh").write_text(motion(LEAD_IN + 1 + i, seed=i), encoding="utf-8")
    return root


@pytest.fixture
def copy(root, tmp_path):
    return shutil.copytree(root, tmp_path / "copy")


@pytest.fixture(scope="module")
def styles(tmp_path_factory):
    styles = tmp_path_factory.mktemp("styles")
    for i, name in enumerate(["salsa/03", "indian/14", "indian/04", "salsa/01"]):
        (styles / name).parent.mkdir(exist_ok=True)
        (styles / f"{name}.bvh").write_text(motion(LEAD_IN + 2, seed=i), encoding="utf-8")
    return styles


def test_every_joint_has_a_name_in_these_files():
    assert set(CMU_NAMES) == set(NAMES)
    assert len(set(CMU_NAMES.values())) == 20
    for name, its in CMU_NAMES.items():
        assert {"Left": "l", "Right": "r"}.get(re.match("Left|Right|", name)[0]) in (None, its[0])


class TestClips:
    def test_clips(self, root):
        clips = list(cmu_clips(root))
        assert [clip.name for clip in clips] == ["02_01", "02_02", "03_01", "13_30"]
        assert [clip.subject for clip in clips] == ["cmu/02", "cmu/02", "cmu/03", "cmu/13"]
        assert [clip.description for clip in clips][1:3] == ["jump, balance", "walk on uneven terrain"]
        assert {(clip.source, clip.fps) for clip in clips} == {("cmu", 120)}
        assert [len(clip.positions) for clip in clips] == [1, 2, 3, 4]

    def test_positions_are_those_of_the_file_after_the_lead_in(self, root):
        *_, clip = cmu_clips(root)
        file = bvh.read(root / "13/13_30.bvh")
        for name, its in CMU_NAMES.items():
            expected = file.positions()[LEAD_IN:, file.skeleton.names.index(its)]
            assert np.array_equal(at(clip.positions, name), expected)

    def test_byte_order_marks(self, copy):
        for file in (copy / "clips.csv", copy / "02/02_01.bvh"):
            file.write_bytes(b"\xef\xbb\xbf" + file.read_bytes())
        assert next(cmu_clips(copy)).name == "02_01"

    def test_subjects(self, root):
        assert [clip.name for clip in cmu_clips(root, subjects=["13", "02"])] == ["02_01", "02_02", "13_30"]
        assert list(cmu_clips(root, subjects=[])) == []

    def test_progress(self, root):
        shares = []
        assert len(list(cmu_clips(root, subjects=("02", "03"), progress=shares.append))) == 3
        assert shares == [1 / 3, 2 / 3, 1]
        with Progress("reading") as progress:
            list(cmu_clips(root, progress=progress))

    def test_clips_are_read_lazily(self, copy):
        (copy / "02/02_02.bvh").write_text("broken", encoding="utf-8")
        clips = cmu_clips(copy)
        assert next(clips).name == "02_01"
        with pytest.raises(ValueError, match=r"02.02_02.bvh: line 1: expected HIERARCHY, got 'broken'"):
            next(clips)

    def test_styles(self, styles):
        shares = []
        clips = list(styles_clips(styles, progress=shares.append))
        assert [clip.name for clip in clips] == ["indian/04", "indian/14", "salsa/01", "salsa/03"]
        assert [clip.description for clip in clips] == ["indian", "indian", "salsa", "salsa"]
        assert {(clip.source, clip.subject, len(clip.positions)) for clip in clips} == {("cmu-styles", "", 2)}
        assert shares == [0.25, 0.5, 0.75, 1]


class TestErrors:
    @pytest.mark.parametrize(
        ("old", "new", "message"),
        [
            (CSV, "", "line 1: expected clip,description, got None"),
            (CSV, "clip,description\n", "no clips"),
            ("clip,", "name,", r"line 1: expected clip,description, got \['name', 'description'\]"),
            ("02_01,walk", "02_01", r"line 2: expected a clip and its description, got \['02_01'\]"),
            ("02_01,walk", "02_01,", r"line 2: expected a clip and its description, got \['02_01', ''\]"),
            ("02_01,walk", "02_01,walk,run", r"line 2: expected a clip and its description"),
            ("02_01,walk", "", r"line 2: expected a clip and its description, got \[\]"),
            ("02_01,walk", "../02_01,walk", "line 2: expected a clip such as 02_01, got '../02_01'"),
            ("03_01", "02_02", "line 4: duplicate clip 02_02"),
            ('"jump, balance"', '"jump" x', "',' expected after '\"'"),
            ("03_01,walk on uneven terrain\n", "", "does not list 03.03_01.bvh"),
        ],
    )
    def test_listing(self, copy, old, new, message):
        (copy / "clips.csv").write_text(CSV.replace(old, new, 1), encoding="utf-8")
        with pytest.raises(ValueError, match=f"copy.clips.csv: .*({message})"):
            cmu_clips(copy)

    @pytest.mark.parametrize("mark", ["", "\ufeff"])
    def test_listing_with_a_byte_order_mark_and_other_line_endings(self, copy, mark):
        (copy / "clips.csv").write_bytes((mark + CSV.replace("\n", "\r\n")).encode())
        assert next(cmu_clips(copy)).name == "02_01"

    def test_listing_is_utf16(self, copy):
        (copy / "clips.csv").write_bytes(CSV.encode("utf-16"))
        with pytest.raises(ValueError, match=r"clips\.csv: the text is UTF-16; save it as UTF-8"):
            cmu_clips(copy)

    def test_listing_is_not_text(self, copy):
        (copy / "clips.csv").write_bytes(CSV.encode() + b"\xff")
        with pytest.raises(ValueError, match=r"clips\.csv: line 6 is not UTF-8 text"):
            cmu_clips(copy)

    def test_missing_files(self, copy):
        for name in ("02/02_02.bvh", "13/13_30.bvh"):
            (copy / name).unlink()
        with pytest.raises(FileNotFoundError, match=r"copy lacks 02.02_02.bvh 13.13_30.bvh$"):
            cmu_clips(copy)
        assert [clip.name for clip in cmu_clips(copy, subjects=["03"])] == ["03_01"]

    def test_no_data(self, tmp_path):
        with pytest.raises(FileNotFoundError, match=r"clips\.csv"):
            cmu_clips(tmp_path)
        with pytest.raises(FileNotFoundError, match=r": no clips in it; expected files such as salsa/03.bvh"):
            styles_clips(tmp_path)

    @pytest.mark.parametrize(
        ("error", "subjects", "message"),
        [
            (ValueError, ["02", "4"], "subjects: .* has no clips of '4', only of 02, 03, 13"),
            (TypeError, [2], "subjects: expected strings, got 2"),
            (TypeError, "02", "subjects: expected a sequence of names, got '02'"),
        ],
    )
    def test_subjects(self, root, error, subjects, message):
        with pytest.raises(error, match=message):
            cmu_clips(root, subjects=subjects)

    def test_another_skeleton(self, styles, tmp_path):
        (tmp_path / "salsa").mkdir()
        text = (styles / "salsa/01.bvh").read_text(encoding="utf-8").replace("lShldr", "LeftShoulder")
        (tmp_path / "salsa/01.bvh").write_text(text, encoding="utf-8")
        with pytest.raises(ValueError, match=r"salsa.01.bvh: another skeleton, without the joints lShldr"):
            next(styles_clips(tmp_path))

    @pytest.mark.parametrize("n_frames", [1, LEAD_IN])
    def test_no_frames_beyond_the_lead_in(self, copy, n_frames):
        (copy / "02/02_01.bvh").write_text(motion(n_frames), encoding="utf-8")
        with pytest.raises(
            ValueError, match=rf"02.02_01.bvh: {n_frames} frames, expected more than the 8 of the lead-in"
        ):
            next(cmu_clips(copy))


class TestRealMotion:
    @pytest.fixture
    def walks(self, cmu_root):
        clips = list(cmu_clips(cmu_root, subjects=["07"]))
        assert len(clips) == 12
        assert all("walk" in clip.description for clip in clips)
        return clips[:-1]  # 07_12: see `cmu_clips`

    def test_listing(self, cmu_root):
        with (cmu_root / "clips.csv").open(encoding="utf-8", newline="") as file:
            names = [row["clip"] for row in csv.DictReader(file)]
        assert len(names) == 142
        assert next(cmu_clips(cmu_root)).name == names[0]

    def test_bones_keep_their_lengths(self, cmu_root):
        file = bvh.read(cmu_root / "05/05_17.bvh")
        positions = file.positions()
        height = np.ptp(positions[0, :, 1])
        assert 100 < height < 200
        for j, parent in file.skeleton.bones:
            bone = np.linalg.norm(positions[:, j] - positions[:, parent], axis=-1)
            assert np.ptp(bone) < 1e-6 * height
            assert bone[0] == pytest.approx(np.linalg.norm(file.skeleton.offsets[j]), rel=1e-9)

    def test_proportions_are_those_of_the_common_skeleton(self, walks):
        """Joints of the same name are the same joints: no bone's length is off by a third."""
        bones = lengths(walks[0].positions).mean(axis=0)
        expected = np.linalg.norm(JOINTS.offsets[[j for j, _ in JOINTS.bones]], axis=-1)
        ratio = dict(zip([NAMES[j] for j, _ in JOINTS.bones], bones / expected / (bones[1] / expected[1]), strict=True))
        limbs = [ratio[f"{side}{name}"] for side in ("Left", "Right") for name in ("Foot", "Arm", "ForeArm", "Hand")]
        assert 0.75 < min(limbs) < max(limbs) < 1.35

    def test_feet_are_near_the_ground_and_left_is_left(self, walks):
        for clip in walks:
            height = np.median(np.ptp(clip.positions[..., 1], axis=1))
            lowest = clip.positions[..., 1].min(axis=1) / height
            assert -0.02 < np.percentile(lowest, 5) < np.percentile(lowest, 95) < 0.1
            assert (at(clip.positions, "Head") - at(clip.positions, "Hips"))[:, 1].min() > 0.3 * height
            assert_left_is_left(clip.positions)

    def test_only_the_lead_in_is_left_out(self, walks, cmu_root):
        """In the lead-in, hands move faster than ever after it; after it, at their normal speed."""
        for clip in walks:
            file = bvh.read(cmu_root / f"07/{clip.name}.bvh")
            hands = file.positions()[:, [file.skeleton.names.index(name) for name in ("lHand", "rHand")]]
            step = np.linalg.norm(np.diff(hands, axis=0), axis=-1).max(axis=1)
            assert step[:4].min() > step[LEAD_IN:].max()
            assert step[LEAD_IN : LEAD_IN + 5].max() < 2 * np.median(step[LEAD_IN : LEAD_IN + 60])

    def test_styles(self, cmu_styles_root):
        clip = next(styles_clips(cmu_styles_root))
        assert (clip.name, clip.fps, len(clip.positions) > 1000) == ("indian/04", 120, True)
        assert_left_is_left(clip.positions)
