"""Mappings of joints: every dialect is guessed, files are read again, and what is wrong is refused by name."""

import json

import numpy as np
import pytest

from dialects import CHAINS, dialect
from npss.skeleton import H36M, Skeleton
from npss_baselines.data import mapping
from npss_baselines.data.cmu import CMU_NAMES
from npss_baselines.data.mapping import JointMapping
from npss_baselines.data.motion import JOINTS, NAMES


@pytest.mark.parametrize("name", CHAINS)
def test_dialects_are_guessed(name):
    skeleton, expected = dialect(name)
    assert mapping.guess(skeleton).joints == expected


def test_human36m_is_guessed():
    assert mapping.guess(H36M).joints == {name: name for name in NAMES}


def test_the_files_of_cmu_are_guessed(cmu_root):
    from npss_baselines.data import bvh

    for path in sorted(cmu_root.glob("*/*.bvh"))[:3]:
        assert mapping.guess(bvh.read(path).skeleton).joints == CMU_NAMES


@pytest.mark.parametrize("name", CHAINS)
def test_positions_are_those_of_the_joints(name):
    skeleton, expected = dialect(name)
    pose = skeleton.positions(np.tile(np.eye(3), (1, len(skeleton.names), 1, 1)))
    common = mapping.guess(skeleton).positions(pose, skeleton)
    for joint, place in zip(NAMES, common[0], strict=True):
        if expected[joint] is None:  # made: in line with the forearm, of the common skeleton's length
            hand, elbow, tip = (
                NAMES.index(joint.replace("HandIndex", part)) for part in ("Hand", "ForeArm", "HandIndex")
            )
            bone = common[0, tip] - common[0, hand]
            forearm = common[0, hand] - common[0, elbow]
            assert np.linalg.norm(np.cross(bone, forearm)) == pytest.approx(0, abs=1e-12)
            assert np.linalg.norm(bone) == pytest.approx(np.linalg.norm(JOINTS.offsets[tip]), rel=1e-9)
        else:
            assert np.array_equal(place, pose[0, skeleton.names.index(expected[joint])])


def test_a_mapping_is_written_and_read(tmp_path):
    skeleton, _ = dialect("lafan1")
    guessed = mapping.guess(skeleton)
    guessed.write(tmp_path / "mapping.json")
    assert mapping.read(tmp_path / "mapping.json") == guessed
    assert json.loads(str(guessed))["LeftHandIndex"] is None


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"Head": 3}, TypeError, "Head: expected the name of a joint, got 3"),
        ({"Head": None}, TypeError, "Head: expected the name of a joint, got None"),
        ({"Tail": "Hips"}, ValueError, "Tail: unknown; expected Hips"),
        ({"Head": "Neck"}, ValueError, "Neck and Head: both are 'Neck'"),
    ],
)
def test_a_wrong_mapping_is_refused(tmp_path, change, error, message):
    path = tmp_path / "mapping.json"
    path.write_text(json.dumps({name: name for name in NAMES} | change), encoding="utf-8")
    with pytest.raises(error, match=rf"mapping\.json: {message}"):
        mapping.read(path)
    path.write_text("[]", encoding="utf-8")
    with pytest.raises(TypeError, match=r"mapping\.json: expected an object"):
        mapping.read(path)
    path.write_text("{}", encoding="utf-8")
    with pytest.raises(ValueError, match=r"mapping\.json: Hips: missing"):
        mapping.read(path)


def test_a_mapping_must_fit_the_skeleton():
    right = {name: name for name in NAMES}
    with pytest.raises(ValueError, match="Head: the skeleton has no joint 'skull'; it has Hips, "):
        JointMapping(right | {"Head": "skull"}).indices(H36M)
    crossed = right | {"LeftForeArm": "RightForeArm", "RightForeArm": "LeftForeArm"}
    with pytest.raises(ValueError, match="LeftForeArm: 'RightForeArm' is not below 'LeftArm'"):
        JointMapping(crossed).indices(H36M)


def test_what_is_not_found_is_named():
    names = [name.replace("Head", "Skull") for name in H36M.names]
    with pytest.raises(ValueError, match=r"^no joint for Head among Hips, .*; give a mapping"):
        mapping.guess(Skeleton(names, H36M.parents, H36M.offsets))
    names = [name.replace("LeftFoot", "LeftPaw") for name in H36M.names]
    with pytest.raises(ValueError, match=r"^no joint for LeftFoot among"):
        mapping.guess(Skeleton(names, H36M.parents, H36M.offsets))
