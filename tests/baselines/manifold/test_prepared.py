"""Tests of prepared motion: contents, selection, broken files, the cache, and counts on real motion."""

import dataclasses
import json
import math
import os
import zipfile

import numpy as np
import pytest

from npss_baselines.data import cmu
from npss_baselines.data.motion import JOINTS, Clip
from npss_baselines.data.source import QUICK
from npss_baselines.data.synthetic import synthetic_clips
from npss_baselines.manifold.motion.bones import normalise_lengths
from npss_baselines.manifold.motion.cache import VERSION, cached, load, save
from npss_baselines.manifold.motion.dataset import prepare
from npss_baselines.manifold.motion.features import to_features, to_positions
from npss_baselines.manifold.motion.ground import level, on_ground
from npss_baselines.manifold.motion.prepared import motion_set
from npss_baselines.manifold.motion.resample import resample
from npss_baselines.manifold.motion.split import held_out_subjects


def clips(*lengths, source="synthetic", fps=30.0):
    """Return clips of the given lengths at 30 frames per second, each of another subject."""
    frames = [math.ceil((length - 1) * fps / 30) + 1 for length in lengths]
    walks = synthetic_clips(len(lengths), max(frames), seed=3, fps=fps)
    return [
        dataclasses.replace(walk, source=source, positions=walk.positions[:n_frames])
        for walk, n_frames in zip(walks, frames, strict=True)
    ]


@pytest.fixture(scope="module")
def motion():
    return prepare(clips(500, 100, 160, 330))


def same(first, second):
    assert first.clips == second.clips
    assert len(first.features) == len(second.features)
    for a, b in zip(first.features, second.features, strict=True):
        np.testing.assert_array_equal(a, b)
    for name in ("windows", "mask", "clip_of"):
        a, b = getattr(first, name), getattr(second, name)
        assert a.dtype == b.dtype
        np.testing.assert_array_equal(a, b)
    return True


# Contents of a set


def test_contents(motion):
    assert motion.windows.shape == (5 + 1 + 1 + 3, 160, 63)
    assert motion.windows.dtype == np.float32
    np.testing.assert_array_equal(motion.clip_of, [0, 0, 0, 0, 0, 1, 2, 3, 3, 3])
    assert [len(rows) for rows in motion.features] == [clip.n_frames for clip in motion.clips] == [500, 100, 160, 330]
    np.testing.assert_array_equal(motion.windows[3], motion.features[0][240:400])
    np.testing.assert_array_equal(motion.windows[9], motion.features[3][160:320])
    np.testing.assert_array_equal(motion.mask.sum(axis=1), [160] * 5 + [100] + [160] * 4)
    assert motion.counts() == {"clips": 4, "windows": 9, "padded": 1, "frames": 1090, "left_out": 30}


@pytest.mark.parametrize("fps", [30, 50, 120])
def test_preparation_step_by_step(fps):
    (clip,) = clips(200, fps=float(fps))
    (rows,) = prepare([clip]).features
    expected = to_features(on_ground(normalise_lengths(resample(clip.positions, fps), JOINTS)), JOINTS)
    assert rows.dtype == np.float32
    np.testing.assert_allclose(rows, expected, rtol=0, atol=1e-6)
    positions = to_positions(rows)
    assert np.quantile(positions[..., 1].min(axis=-1), 0.05) == pytest.approx(0, abs=1e-5)
    bones = np.linalg.norm(positions[:, 1:] - positions[:, list(JOINTS.parents[1:])], axis=-1)
    np.testing.assert_allclose(bones, np.tile(np.linalg.norm(JOINTS.offsets[1:], axis=-1), (200, 1)), rtol=0, atol=1e-5)


def test_frame_rates_agree():
    slow, fast = (prepare(clips(200, fps=fps)).features[0] for fps in (30.0, 120.0))
    assert abs(slow - fast)[:, :60].max() < 0.005  # of a walk that is the same at every rate, but for its path


def test_only_sources_without_up_direction_are_levelled():
    (clip,) = clips(200)
    tilted = dataclasses.replace(clip, source="h36m")
    expected = level(normalise_lengths(tilted.positions, JOINTS), JOINTS)
    np.testing.assert_allclose(
        prepare([tilted]).features[0], to_features(on_ground(expected), JOINTS), rtol=0, atol=1e-6
    )
    assert abs(prepare([tilted]).features[0] - prepare([clip]).features[0]).max() > 0.01


def test_unit_does_not_matter():
    (clip,) = clips(200)
    inches = dataclasses.replace(clip, positions=clip.positions / 25.4)
    np.testing.assert_allclose(prepare([inches]).features[0], prepare([clip]).features[0], rtol=0, atol=1e-6)


def test_invalid_clips_are_named():
    with pytest.raises(ValueError, match=r"^clips: expected at least one"):
        prepare([])
    with pytest.raises(ValueError, match=r"^clips: synthetic gait/0: duplicate clip"):
        prepare(clips(100) * 2)
    both = [*clips(100), *clips(100, source="h36m")]  # one name, two sources
    assert prepare(both).counts()["clips"] == 2
    (clip,) = clips(100)
    broken = clip.positions.copy()
    broken[7, 3] = broken[7, 2]
    with pytest.raises(ValueError, match=r"^synthetic gait/0: positions: LeftFoot coincides with .* at frame 7"):
        prepare([dataclasses.replace(clip, positions=broken)])


# Parts


def part(name, source, subject, n_frames=100):
    (clip,) = clips(n_frames)
    return Clip(name, source, subject, "walk", clip.fps, clip.positions)


def test_selection_by_subject_and_source():
    whole = prepare(
        [
            part("02_01", "cmu", "cmu/02"),
            part("05_01", "cmu", "cmu/05", 250),
            part("salsa/1", "cmu-styles", ""),
            part("S5/a_1", "h36m", "h36m/S5"),
            part("S5/a_2", "h36m", "h36m/S5"),
        ]
    )
    names = lambda **options: [clip.name for clip in whole.only(**options).clips]  # noqa: E731
    assert names() == ["02_01", "05_01", "salsa/1", "S5/a_1", "S5/a_2"]
    assert names(exclude_subjects=held_out_subjects()) == ["05_01", "salsa/1"]
    assert names(subjects=held_out_subjects()) == ["02_01", "S5/a_1", "S5/a_2"]
    assert names(subjects=held_out_subjects(), sources=["h36m"]) == ["S5/a_1", "S5/a_2"]
    assert names(sources={"cmu", "cmu-styles"}, exclude_subjects=["cmu/05"]) == ["02_01", "salsa/1"]
    train = whole.only(exclude_subjects=held_out_subjects())
    np.testing.assert_array_equal(train.windows, whole.windows[[1, 2, 3]])
    np.testing.assert_array_equal(train.mask, whole.mask[[1, 2, 3]])
    np.testing.assert_array_equal(train.clip_of, [0, 0, 1])
    assert train.counts() == {"clips": 2, "windows": 2, "padded": 1, "frames": 350, "left_out": 10}


def test_invalid_selection(motion):
    with pytest.raises(ValueError, match=r"^none of 4 clips matches: subjects \['cmu/02'\]"):
        motion.only(subjects=["cmu/02"])
    with pytest.raises(TypeError, match=r"^subjects: expected a sequence of names, got 'cmu/02'"):
        motion.only(subjects="cmu/02")
    with pytest.raises(TypeError, match=r"^exclude_subjects: expected a sequence of names"):
        motion.only(exclude_subjects="cmu/02")


# Files


def test_save_and_load(motion, tmp_path):
    save(tmp_path / "set.npz", motion)
    assert [path.name for path in tmp_path.iterdir()] == ["set.npz"]
    same(load(tmp_path / "set.npz"), motion)
    size = (tmp_path / "set.npz").stat().st_size
    assert size < motion.counts()["frames"] * 63 * 4 + 10_000  # whole clips only: windows overlap


def arrays(motion):
    header = {"version": VERSION, "clips": [dataclasses.asdict(clip) for clip in motion.clips]}
    return header, np.concatenate(motion.features)


@pytest.mark.parametrize(
    "spoil",
    [
        lambda header, rows: ({**header, "version": 0}, rows),
        lambda header, rows: ({"clips": header["clips"]}, rows),
        lambda header, rows: ({**header, "clips": []}, rows[:0]),
        lambda header, rows: ({**header, "clips": header["clips"][1:]}, rows),
        lambda header, rows: ({**header, "clips": [{**header["clips"][0], "n_frames": 1090}]}, rows[:-1]),
        lambda header, rows: ({**header, "clips": [{**header["clips"][0], "n_frames": -1}]}, rows),
        lambda header, rows: ({**header, "clips": [{**header["clips"][0], "n_frames": 1090, "name": 3}]}, rows),
        lambda header, rows: ({**header, "clips": [{**header["clips"][0], "n_frames": 1090, "more": 3}]}, rows),
        lambda header, rows: ({**header, "clips": 7}, rows),
        lambda header, rows: ([header], rows),
        lambda header, rows: (header, rows.astype(float)),
        lambda header, rows: (header, rows[:, :, np.newaxis]),
        lambda header, rows: (header, rows[:, :0]),
        lambda header, rows: (header, np.where(np.arange(63) == 5, np.float32(np.nan), rows)),
    ],
)
def test_invalid_files_are_refused(motion, tmp_path, spoil):
    header, rows = spoil(*arrays(motion))
    np.savez(tmp_path / "set.npz", header=json.dumps(header), features=rows)
    with pytest.raises(ValueError, match=r"set\.npz: not a valid set of prepared motion: "):
        load(tmp_path / "set.npz")


def test_damaged_files_are_refused(motion, tmp_path):
    path = tmp_path / "set.npz"
    save(path, prepare(clips(3)))
    whole = path.read_bytes()
    expected = load(path)
    rng = np.random.default_rng(0)
    refused = 0
    for trial in range(400):
        content = bytearray(whole)
        if trial % 2:
            content = content[: rng.integers(len(content))]
        else:
            content[rng.integers(len(content))] ^= 1 << rng.integers(8)
        path.write_bytes(content)
        try:
            read = load(path)
        except ValueError as error:
            refused += str(error).startswith(f"{path}: not a valid set of prepared motion")
        else:
            same(read, expected)
    assert refused > 300  # some bytes of an archive do not matter
    path.write_bytes(b"")
    with pytest.raises(ValueError, match="not a valid set of prepared motion"):
        load(path)
    np.save(tmp_path / "one.npy", np.zeros(3))
    with pytest.raises(ValueError, match="not a valid set of prepared motion"):
        load(tmp_path / "one.npy")
    with zipfile.ZipFile(path, "w") as archive:
        archive.writestr("header.npy", b"cos\nsystem\n(S'true'\ntR.")
    with pytest.raises(ValueError, match="not a valid set of prepared motion"):
        load(path)
    with pytest.raises(FileNotFoundError):
        load(tmp_path / "nowhere.npz")


def test_pickles_are_not_read(tmp_path):
    np.savez(tmp_path / "set.npz", header=np.array({"version": VERSION}, dtype=object), features=np.zeros(3))
    with pytest.raises(ValueError, match="not a valid set of prepared motion"):
        load(tmp_path / "set.npz")


# The cache


def test_cache_replaces_broken_files(motion, tmp_path):
    calls = []

    def make():
        calls.append(1)
        return motion

    folder = tmp_path / "new" / "folder"
    same(cached(folder, "a", make), motion)
    same(cached(folder, "a", make), motion)
    assert len(calls) == 1
    cached(folder, "b", make)
    assert len(calls) == 2
    for path in folder.iterdir():
        path.write_bytes(path.read_bytes()[:-1000])
    same(cached(folder, "a", make), motion)
    assert len(calls) == 3
    same(cached(folder, "a", make), motion)
    assert len(calls) == 3


def test_cache_depends_on_version_and_skeleton(motion, tmp_path, monkeypatch):
    cached(tmp_path, "a", lambda: motion)
    monkeypatch.setattr("npss_baselines.manifold.motion.cache.VERSION", 2)
    cached(tmp_path, "a", lambda: motion)
    monkeypatch.setattr(
        "npss_baselines.manifold.motion.cache.JOINTS", type(JOINTS)(JOINTS.names, JOINTS.parents, 2 * JOINTS.offsets)
    )
    cached(tmp_path, "a", lambda: motion)
    assert len(list(tmp_path.iterdir())) == 3


def test_failed_preparation_leaves_no_file(tmp_path):
    with pytest.raises(ValueError, match="expected at least one"):
        cached(tmp_path, "a", lambda: prepare([]))
    assert not list(tmp_path.iterdir())


@pytest.fixture
def two_files(tmp_path, monkeypatch):
    """Register a source of two files, and count its reads."""
    root = tmp_path / "cmu"
    (root / "02").mkdir(parents=True)
    for name in ("02/02_01.bvh", "02/02_02.bvh"):
        (root / name).write_text("HIERARCHY", encoding="utf-8")
        os.utime(root / name, (1e9, 1e9))
    reads = []

    def read(root, *, subjects=None, progress):
        reads.append(subjects)
        for i, clip in enumerate(clips(170, 180)):
            progress((i + 1) / 2)
            yield dataclasses.replace(clip, source="cmu", subject="cmu/02")

    monkeypatch.setattr(cmu, "cmu_clips", read)
    return root, tmp_path / "cache", reads


def test_cache_notices_changed_files(two_files):
    root, cache, reads = two_files
    first = motion_set({"cmu": root}, cache=cache)
    same(motion_set({"cmu": str(root)}, cache=str(cache)), first)
    assert reads == [None]
    os.utime(root / "02/02_01.bvh", (1e9, 1e9 + 1))
    motion_set({"cmu": root}, cache=cache)
    assert len(reads) == 2
    (root / "02/02_01.bvh").write_text("HIERARCH", encoding="utf-8")
    os.utime(root / "02/02_01.bvh", (1e9, 1e9 + 1))
    motion_set({"cmu": root}, cache=cache)
    assert len(reads) == 3
    (root / "02/02_01.bvh").rename(root / "02/02_03.bvh")
    motion_set({"cmu": root}, cache=cache)
    assert len(reads) == 4
    motion_set({"cmu": root}, cache=cache, quick=True)
    assert reads[4] == cmu.QUICK_SUBJECTS
    motion_set({"cmu": root})
    assert len(reads) == 6


def test_without_data_motion_is_generated(tmp_path):
    walks = motion_set(quick=True, cache=tmp_path)
    assert walks.counts() == {"clips": 8, "windows": 40, "padded": 0, "frames": 4000, "left_out": 160}
    assert {clip.subject for clip in walks.only(subjects=held_out_subjects()).clips} == {"synthetic/0", "synthetic/1"}
    same(walks, motion_set(quick=True))
    assert not list(tmp_path.iterdir())


# Real motion


def test_cmu(cmu_root):
    part = motion_set({"cmu": cmu_root}, quick=True)
    assert {clip.subject for clip in part.clips} == {f"cmu/{subject}" for subject in cmu.QUICK_SUBJECTS}
    check_real(part)


def test_dances_and_martial_arts(cmu_styles_root):
    part = motion_set({"cmu-styles": cmu_styles_root}, quick=True)
    assert [clip.source for clip in part.clips] == ["cmu-styles"] * QUICK
    check_real(part)


def test_human36m(h36m_root, tmp_path):
    part = motion_set({"h36m": h36m_root}, quick=True, cache=tmp_path)
    assert [clip.subject for clip in part.clips] == ["h36m/S1", "h36m/S1", "h36m/S5", "h36m/S5"]
    check_real(part)
    same(motion_set({"h36m": h36m_root}, quick=True, cache=tmp_path), part)


def check_real(motion):
    """Check that figures face +z, stand on the ground, and are recovered."""
    joint = JOINTS.names.index
    for clip, rows in zip(motion.clips, motion.features, strict=True):
        local = rows[:, :60].reshape(-1, 20, 3)
        assert abs(local[:, 0, [0, 2]]).max() < 1e-6
        left, right = (np.median(local[:, joint(f"{side}UpLeg"), 0]) for side in ("Left", "Right"))
        assert left > 0.02 > -0.02 > right, clip
        toes = [local[:, joint(f"{side}ToeBase"), 2] - local[:, joint(f"{side}Foot"), 2] for side in ("Left", "Right")]
        assert np.median(toes) > 0.02, clip
        assert 0.3 < np.median(local[:, 0, 1]) < 0.8, clip
        positions = to_positions(rows)
        again = to_features(positions, JOINTS)
        assert abs(again - rows)[:, :60].max() < 1e-5
        assert abs(again - rows)[1:].max() < 1e-5
        carried = positions - positions[0, 0] * (1, 0, 1)
        assert abs(to_positions(again) - carried).max() < 1e-5
