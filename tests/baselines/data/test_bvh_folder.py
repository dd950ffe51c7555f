"""Any folder of BVH files: subjects, actions and joints by name, or from files beside the clips."""

import numpy as np
import pytest

from dialects import walking, with_z_up
from npss_baselines.data import SOURCES, bvh_writer, mapping
from npss_baselines.manifold.motion.prepared import motion_set
from npss_baselines.manifold.motion.split import split

#: Files by name, on skeletons of several programs.
FILES = {
    "anna/walk_01.bvh": "mixamo",
    "anna/walk_02.BVH": "lafan1",
    "anna/Run3.bvh": "xsens",
    "ben/deeper/walk.bvh": "bandai",
    "test/01_02.bvh": "rokoko",
    "validation/walk.bvh": "cmu",
    "alone.bvh": "lafan1",
}


@pytest.fixture
def folder(tmp_path):
    for seed, (name, dialect) in enumerate(FILES.items()):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        motion = walking(dialect, 40, seed=seed)
        bvh_writer.write(path, with_z_up(motion) if dialect == "xsens" else motion)
    return tmp_path


def clips_of(folder, **options):
    return list(SOURCES["bvh"].clips(folder, **options))


def test_subjects_and_actions_by_name(folder):
    done = []
    clips = clips_of(folder, progress=done.append)
    assert {(clip.name, clip.subject, clip.description) for clip in clips} == {
        ("alone", "", "alone"),
        ("anna/Run3", "bvh/anna", "run"),
        ("anna/walk_01", "bvh/anna", "walk"),
        ("anna/walk_02", "bvh/anna", "walk"),
        ("ben/deeper/walk", "bvh/ben", "walk"),
        ("test/01_02", "bvh/test", ""),
        ("validation/walk", "bvh/validation", "walk"),
    }
    assert done[-1] == 1
    for clip in clips:  # y is up, also where the file says z
        assert clip.positions[:, 3, 1].mean() - clip.positions[..., 1].min() < clip.positions[:, 0, 1].mean() / 2
    assert sorted(clip.name for clip in clips_of(folder, quick=True)) == sorted(
        {clip.name for clip in clips} - {"anna/walk_02"}
    )


def test_the_manifold_holds_out_subjects(folder):
    parts = split(motion_set({"bvh": folder}))
    assert parts.test is not None
    assert [clip.subject for clip in parts.test.clips] == ["bvh/test"]
    assert [clip.subject for clip in parts.validation.clips] == ["bvh/validation"]
    assert {clip.subject for clip in parts.training.clips} == {"", "bvh/anna", "bvh/ben"}


def test_a_list_of_clips(folder):
    lines = [f'{name},"s, {number}",{"jump" if number else ""}' for number, name in enumerate(FILES)]
    (folder / "labels.csv").write_text("\n".join(["file,subject,action", *lines]) + "\n", encoding="utf-8")
    clips = {clip.name: (clip.subject, clip.description) for clip in clips_of(folder)}
    assert clips["anna/walk_01"] == ("bvh/s, 0", "")
    assert clips["alone"] == ("bvh/s, 6", "jump")


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("clip,description\n", "labels.csv: line 1: expected file,subject,action, got "),
        ("file,subject,action\na.bvh,b\n", "labels.csv: line 2: expected a file, its subject and its action"),
        ("file,subject,action\na.bvh,b,c\n", "labels.csv: line 2: no BVH file 'a.bvh' in the folder"),
        ("file,subject,action\nalone.bvh,b,c\nalone.bvh,b,c\n", "labels.csv: line 3: duplicate file 'alone.bvh'"),
        ("file,subject,action\nalone.bvh,b,c\n", "labels.csv: does not list anna/Run3.bvh anna/walk_01.bvh"),
    ],
)
def test_broken_lists(folder, text, message):
    (folder / "labels.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=message):
        clips_of(folder)


def test_a_mapping_beside_clips(folder):
    own = mapping.guess(walking("lafan1", 2).skeleton)
    other = mapping.JointMapping({**own.joints, "Spine1": "Spine2"})
    other.write(folder / "anna" / "mapping.json")
    (folder / "anna" / "walk_01.bvh").unlink()
    (folder / "anna" / "Run3.bvh").unlink()
    positions = {clip.name: clip.positions for clip in clips_of(folder)}
    motion = walking("lafan1", 40, seed=1)
    expected = other.positions(motion.positions(), motion.skeleton)
    np.testing.assert_allclose(positions["anna/walk_02"], expected, rtol=0, atol=1e-3)
    other.write(folder / "mapping.json")
    with pytest.raises(ValueError, match=r"walk\.bvh: .*the skeleton has no joint"):
        clips_of(folder)


def test_no_clips(tmp_path):
    with pytest.raises(FileNotFoundError, match="no BVH files in it"):
        clips_of(tmp_path)
