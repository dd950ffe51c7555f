"""Files of results on any motion: layouts, meta, lengths and groups, and what is refused."""

import ast
import json

import numpy as np
import pytest

import npss
from npss.files._meta import Meta
from npss.files._results import is_folder_of_results, read_results
from npss.files._samples import read_poses
from pages import PROJECT, blocks

PAGE = PROJECT / "docs" / "write-results.md"
META = {"representation": "positions", "fps": 30, "protocol": "mine", "unit": "cm", "parents": [-1, 0, 1, 2]}


def walks(seed=0, shape=(4, 12, 4, 3)):
    gt, noise = np.random.default_rng(seed).normal(size=(2, *shape)).cumsum(axis=2)
    return gt, gt + noise / 10


def write(path, conditions, meta=None):
    arrays = {f"{name}/{kind}": motion for name, pair in conditions.items() for kind, motion in pair.items()}
    if meta is not None:
        arrays["meta"] = np.array(json.dumps(meta))
    if path.suffix == ".npz":
        np.savez(path, **arrays)
        return
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        for name, values in arrays.items():
            file[name] = json.dumps(meta) if name == "meta" else values


def pairs_of(path):
    return {pair.name: pair for pair in read_results(path)}


@pytest.mark.parametrize("suffix", [".npz", ".h5"])
def test_conditions_are_read(tmp_path, suffix):
    gt, pred = walks()
    write(tmp_path / f"a{suffix}", {"5": {"gt": gt, "pred": pred}, "15": {"gt": pred, "pred": gt}}, META)
    found = pairs_of(tmp_path / f"a{suffix}")
    assert set(found) == {"5", "15"}
    assert np.array_equal(found["5"].gt, gt.reshape(4, 12, 12))
    assert np.array_equal(found["15"].pred, gt.reshape(4, 12, 12))
    assert found["5"].meta.parents == (-1, 0, 1, 2)
    assert found["5"].meta.context() == {"representation": "positions", "protocol": "mine"}


def test_arrays_alone_are_one_condition(tmp_path):
    gt, pred = walks()
    np.savez(tmp_path / "a.npz", gt=gt[0].reshape(12, 12), pred=pred[0].reshape(12, 12))
    (pair,) = read_results(tmp_path / "a.npz")
    assert (pair.name, pair.gt.shape, pair.meta) == ("all", (1, 12, 12), Meta())


def test_folders_of_arrays_are_read(tmp_path):
    gt, pred = walks()
    for name, array in (("walk_gt", gt), ("walk_pred", pred), ("gt", pred), ("pred", gt)):
        np.save(tmp_path / f"{name}.npy", array)
    assert is_folder_of_results(tmp_path)
    assert not is_folder_of_results(tmp_path / "gt.npy")
    found = pairs_of(tmp_path)
    assert set(found) == {"walk", "all"}
    assert np.array_equal(found["walk"].pred, found["all"].gt)
    (tmp_path / "meta.json").write_text(json.dumps(META), encoding="utf-8")
    assert pairs_of(tmp_path)["walk"].meta.fps == 30
    np.save(tmp_path / "walk_samples.npy", np.stack([gt, pred]))
    assert np.array_equal(pairs_of(tmp_path)["walk"].samples[1], found["walk"].pred)
    (tmp_path / "._walk_gt.npy").write_bytes(b"of a file system")  # hidden
    assert set(pairs_of(tmp_path)) == {"walk", "all"}
    (tmp_path / "walk_pred.npy").write_bytes(b"damaged")
    with pytest.raises(ValueError, match=r"walk_pred\.npy: "):
        read_results(tmp_path)
    np.save(tmp_path / "walk_pred.npy", pred)
    np.save(tmp_path / "all_gt.npy", gt)
    with pytest.raises(ValueError, match=r"gt\.npy: the condition 'all' has this array twice"):
        read_results(tmp_path)
    (tmp_path / "all_gt.npy").unlink()
    np.save(tmp_path / "walk_extra.npy", gt)
    with pytest.raises(ValueError, match=r"walk_extra\.npy: expected CONDITION_gt\.npy"):
        read_results(tmp_path)


def test_samples_are_read_cut_and_checked(tmp_path):
    gt, pred = walks()
    samples = np.stack([gt, pred, 2 * pred])
    samples[:, 1, 7:] = np.nan
    meta = {**META, "lengths": {"walk": [12, 7, 12, 12]}}
    write(tmp_path / "a.npz", {"walk": {"gt": gt, "pred": pred, "samples": samples}}, meta)
    found = pairs_of(tmp_path / "a.npz")
    assert found["walk, 7 frames"].samples.shape == (3, 1, 7, 12)
    assert np.array_equal(found["walk, 12 frames"].samples[2], 2 * pred[[0, 2, 3]].reshape(3, 12, 12))
    for wrong, message in (
        (samples[:, 1:], r"walk: samples: expected shape \(S, \*\(4, 12, 12\)\)"),
        (gt, "walk: samples"),
    ):
        write(tmp_path / "a.npz", {"walk": {"gt": gt, "pred": pred, "samples": wrong}}, META)
        with pytest.raises(ValueError, match=message):
            read_results(tmp_path / "a.npz")


def test_unequal_lengths_are_conditions_of_their_own(tmp_path):
    """What lies beyond a length may be anything, and scores are those of the cut sequences."""
    gt, pred = walks()
    gt[1, 7:], pred[1, 7:] = np.nan, np.inf
    meta = {**META, "lengths": {"walk": [12, 7, 12, 7]}, "groups": {"walk": ["a", "b", None, 3]}}
    write(tmp_path / "a.npz", {"walk": {"gt": gt, "pred": pred}}, meta)
    found = pairs_of(tmp_path / "a.npz")
    assert set(found) == {"walk, 7 frames", "walk, 12 frames"}
    assert found["walk, 7 frames"].groups == ("b", 3)
    assert found["walk, 12 frames"].groups == ("a", None)
    assert npss.score(found["walk, 7 frames"].gt, found["walk, 7 frames"].pred) == npss.score(
        gt[[1, 3], :7], pred[[1, 3], :7]
    )


@pytest.mark.parametrize(
    ("arrays", "meta", "message"),
    [
        ({"walk/gt": 0}, None, "walk: no array pred"),
        ({"walk/gt": 0, "walk/pred": 0, "walk/extra": 0}, None, "walk/extra: expected CONDITION/gt"),
        ({"a/b/gt": 0, "a/b/pred": 0}, None, "a/b/gt: expected CONDITION/gt"),
        ({"a\nb/gt": 0, "a\nb/pred": 0}, None, r"'a\\nb/gt': expected the name of a condition in one line"),
        ({"a  b/gt": 0, "a  b/pred": 0}, None, "'a  b/gt': expected the name of a condition in one line"),
        ({}, None, "no arrays gt and pred in it"),
        ({"walk/gt": 0, "walk/pred": 1}, None, r"walk: pred: its shape .* differs from that of gt"),
        ({"walk/gt": 0, "walk/pred": 2}, None, r"walk: pred: .*nan"),
        ({"walk/gt": 0, "walk/pred": 0}, {"lengths": {"run": [1]}}, "meta: lengths: no condition 'run'"),
        ({"walk/gt": 0, "walk/pred": 0}, {"lengths": {"walk": [1]}}, "lengths: walk: expected one for each of 4"),
        ({"walk/gt": 0, "walk/pred": 0}, {"lengths": {"walk": [13] * 4}}, "13 frames, but the arrays have 12"),
        ({"walk/gt": 0, "walk/pred": 0}, {"lengths": {"walk": [0] * 4}}, "meta: lengths: walk: "),
        ({"walk/gt": 0, "walk/pred": 0}, {"groups": {"walk": [1.5] * 4}}, "meta: groups: walk: expected text"),
        ({"walk/gt": 0, "walk/pred": 0}, {"groups": ["a"]}, "meta: groups: expected an object"),
        ({"walk/gt": 0, "walk/pred": 0}, {"speed": 3}, "meta: unknown field 'speed'"),
        ({"walk/gt": 0, "walk/pred": 0}, {"fps": "30"}, "meta: fps: "),
        ({"walk/gt": 0, "walk/pred": 0}, {"representation": 6}, "meta: representation: expected text"),
        ({"walk/gt": 0, "walk/pred": 0}, {"parents": [0, 1]}, "meta: parents|parents: "),
        ({"walk/gt": 0, "walk/pred": 0}, {"unit": "inch"}, "meta: unit: expected one of m, cm, mm"),
        ({"walk/gt": 0, "walk/pred": 0}, {"quaternions": "flipped"}, "meta: quaternions: expected one of continuous"),
        ({"walk/gt": 0, "walk/pred": 0}, {"joint_names": "hips"}, "meta: joint_names: "),
        ({"walk/gt": 0, "walk/pred": 0}, {"joint_names": ["a", "a"]}, "meta: joint_names: duplicate 'a'"),
        (
            {"walk/gt": 0, "walk/pred": 0},
            {"joint_names": ["a"], "parents": [-1, 0]},
            "meta: joint_names: expected one for each of 2 parents, got 1",
        ),
        ({"walk/gt": 0, "walk/pred": 0}, {"parents": [-1, -1]}, "meta: parents: expected one root"),
        ({"walk/gt": 0, "walk/pred": 0}, {"fps": 10**400}, "meta: fps: expected a positive, finite number"),
        ({"walk/gt": 0, "walk/pred": 0}, [1], "meta: expected a JSON object"),
        ({"gt": 0, "pred": 0, "all/gt": 0}, None, "all/gt: the condition 'all' has this array twice"),
    ],
)
def test_what_is_refused(tmp_path, arrays, meta, message):
    gt, _ = walks()
    bad = gt.copy()
    bad[0, 0, 0, 0] = np.nan
    stored = {name: (gt, gt[:, 1:], bad)[which] for name, which in arrays.items()}
    if meta is not None:
        stored["meta"] = np.array(json.dumps(meta))
    np.savez(tmp_path / "a.npz", **stored)
    with pytest.raises((TypeError, ValueError), match=message) as caught:
        read_results(tmp_path / "a.npz")
    assert str(caught.value).startswith(str(tmp_path / "a.npz"))


def test_other_paths_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"no \.npy files in it"):
        read_results(tmp_path)
    (tmp_path / "a.txt").write_text("", encoding="utf-8")
    with pytest.raises(ValueError, match=r"a\.txt: expected .* samples; otherwise give GT and PRED"):
        read_poses(tmp_path / "a.txt")
    gt, pred = walks(shape=(4, 12, 3, 3))
    np.savez(tmp_path / "a.npz", gt=gt, pred=pred)
    with pytest.raises(ValueError, match=r"a\.npz: all: gt: shape .* may be rotation matrices"):
        read_results(tmp_path / "a.npz")
    np.savez(tmp_path / "a.npz", gt=gt[0, :, 0], pred=pred[0, :, 0], samples=gt[0, :, 0])
    with pytest.raises(ValueError, match=r"a\.npz: all: samples: expected shape \(S, N, T, \.\.\.\), got \(12, 3\)"):
        read_results(tmp_path / "a.npz")
    with pytest.raises(ValueError, match=r"^expected three features for each joint, got 4"):
        Meta(representation="positions", unit="m").millimetres(np.zeros((1, 2, 4)))


def test_meta_must_be_a_text_in_json(tmp_path):
    gt, pred = walks()
    for value, message in ((np.array(3), "meta: expected a text"), (np.array("{"), "meta: invalid JSON")):
        np.savez(tmp_path / "a.npz", gt=gt, pred=pred, meta=value)
        with pytest.raises((TypeError, ValueError), match=message):
            read_results(tmp_path / "a.npz")
    np.savez(tmp_path / "a.npz", gt=gt, pred=pred, meta=np.array({}, dtype=object))
    with pytest.raises(ValueError, match=r"a\.npz"):
        read_results(tmp_path / "a.npz")


def test_positions_are_millimetres_with_y_up():
    motion = np.zeros((1, 2, 6))
    motion[0, 0] = [1, 2, 3, 1, 2, 4]
    motion[0, 1] = [2, 2, 3, 2, 2, 4]
    meta = Meta(representation="positions", fps=30, parents=(-1, 0), unit="m", up="z")
    places = meta.positions(motion)
    # x, y, z with z up become y, z, x: a rotation. The root begins above the origin, at its own height.
    assert np.array_equal(places[0, :, 0], [[0, 3000, 0], [0, 3000, 1000]])
    assert np.array_equal(meta.skeleton(places).offsets, [[0, 0, 0], [0, 1000, 0]])
    assert meta.not_drawn() == ""
    assert Meta(representation="positions", unit="m").not_drawn() == "no parents, fps"
    assert "'euler'" in Meta(representation="euler").not_drawn()
    with pytest.raises(ValueError, match=r"^parents: of 2 joints, but there are 9 features, not 6"):
        meta.positions(np.zeros((1, 2, 9)))


def test_features_are_named_after_joints():
    assert Meta(representation="quaternion", quaternions="w>=0").context() == {
        "representation": "quaternion",
        "quaternions": "w>=0",
    }
    meta = Meta(joint_names=("hips", "knee"))
    assert meta.feature_names(6) == ("hips.x", "hips.y", "hips.z", "knee.x", "knee.y", "knee.z")
    assert meta.feature_names(8)[:4] == ("hips.w", "hips.x", "hips.y", "hips.z")
    assert meta.feature_names(4)[-1] == "knee.1"
    assert meta.feature_names(7) is None
    assert Meta().feature_names(6) is None


@pytest.mark.skipif(not PAGE.exists(), reason="needs the source code")
def test_the_writer_of_the_page_is_read_and_is_old_python(tmp_path, monkeypatch):
    """Both blocks of the page, of which the first is the writer, are valid in Python 3.6 and need numpy alone."""
    writer, example = blocks(PAGE, "python")
    assert len(writer.strip().splitlines()) <= 15
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in (writer, example):
        ast.parse(block, feature_version=(3, 6))
        exec(block, names)
    (pair,) = read_results(tmp_path / "mine.npz")
    assert np.array_equal(pair.gt, names["gt"].reshape(8, 30, 88))
    assert (pair.name, pair.meta.representation, pair.meta.fps) == ("30", "quaternion", 30)


def test_the_writer_takes_tensors(tmp_path):
    torch = pytest.importorskip("torch")
    names = {}
    exec(blocks(PAGE, "python")[0], names)
    gt = torch.ones(2, 3, 4, requires_grad=True)
    names["write_results"](tmp_path / "a.npz", {"walk": (gt, gt * 2)})
    assert pairs_of(tmp_path / "a.npz")["walk"].pred.max() == 2
