"""The loader of Human3.6M: on generated files in its layout, and on the data set if available."""

import shutil

import numpy as np
import pytest

from h36m_files import write
from npss.protocol import ACTIONS, TEST_LENGTHS, TRAIN_SUBJECTS, random_windows, srnn_windows
from npss_baselines.data import h36m
from npss_baselines.data.h36m_source import Human36M

MISSING = {
    "S5": "directions_1 discussion_1 discussion_2 sittingdown_1 waiting_1 waiting_2",
    "S7": "discussion_1 discussion_2 phoning_1 sitting_1 sittingdown_1 sittingdown_2 "
    "smoking_1 smoking_2 waiting_1 waiting_2",
    "S9": "discussion_1 discussion_2 smoking_1 smoking_2",
}


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Walking of all subjects but clip 2 of subject 7, posing of subject 6, and waiting of subject 5."""
    root = tmp_path_factory.mktemp("made")
    rng = np.random.default_rng(0)
    for subject in h36m.SUBJECTS:
        for clip in (1, 2):
            if (subject, clip) != (7, 2):
                rows = rng.normal(size=(340 + subject if subject == 5 else 20 + subject, 99))
                write(root / "dataset" / f"S{subject}" / f"walking_{clip}.txt", rows)
    write(root / "dataset/S6/posing_1.txt", rng.normal(size=(1, 99)))
    for clip in (1, 2):  # of unknown expected length
        write(root / f"dataset/S5/waiting_{clip}.txt", rng.normal(size=(345 + clip, 99)))
    return root


@pytest.fixture
def broken(made, tmp_path):
    """Return a function that copies the data set, writes a text to one file, and opens the copy."""

    def make(text, **options):
        root = tmp_path / "copy"
        shutil.copytree(made, root)
        (root / "dataset/S1/walking_1.txt").write_bytes(text if isinstance(text, bytes) else text.encode())
        return h36m.open_root(root, **options)

    return make


def row(**changes):
    fields = ["0.5000000"] * 99
    for column, text in changes.items():
        fields[int(column[1:])] = text
    return ",".join(fields)


class TestOpening:
    def test_either_folder(self, made):
        for root in (made, made / "dataset", str(made)):
            assert h36m.open_root(root) == h36m.H36M(made / "dataset")

    @pytest.mark.parametrize("name", ["", "nowhere"])
    def test_no_data(self, tmp_path, name):
        with pytest.raises(
            FileNotFoundError, match=r": no Human3.6M in it; expected files such as dataset/S5/walking_1.txt"
        ):
            h36m.open_root(tmp_path / name)

    def test_a_copy_that_leaks_the_test_set_is_refused(self, made, tmp_path):
        shutil.copytree(made, tmp_path / "leak")
        folder = tmp_path / "leak/dataset"
        shutil.copy(folder / "S5/walking_2.txt", folder / "S6/posing_1.txt")
        with pytest.raises(ValueError, match=r"S6.posing_1.txt is a copy of .*S5.walking_2.txt: .* leaks its test set"):
            h36m.open_root(folder)

    def test_files_of_the_same_size_are_no_leak(self, made, tmp_path):
        shutil.copytree(made, tmp_path / "same")
        folder = tmp_path / "same/dataset"
        text = (folder / "S5/walking_2.txt").read_text(encoding="utf-8")
        (folder / "S6/posing_1.txt").write_text(text[:-2] + str((int(text[-2]) + 1) % 10) + "\n", encoding="utf-8")
        assert (folder / "S6/posing_1.txt").stat().st_size == (folder / "S5/walking_2.txt").stat().st_size
        h36m.open_root(folder)

    def test_missing_files(self, made):
        absent = h36m.missing(h36m.open_root(made))
        assert len(absent) == 210 - 16
        assert "S7/walking_2.txt" in absent
        assert "S5/walking_2.txt" not in absent
        assert len(set(absent)) == len(absent)


class TestReading:
    def test_the_numbers(self, made):
        rows = h36m.load(h36m.open_root(made), 5, "walking", 1)
        path = made / "dataset/S5/walking_1.txt"
        expected = [
            [float(field) for field in line.split(",")] for line in path.read_text(encoding="utf-8").splitlines()
        ]
        assert rows.dtype == np.float32
        assert np.array_equal(rows, np.array(expected).astype(np.float32))

    def test_every_second_row(self, made):
        data = h36m.open_root(made)
        half = h36m.load(data, 6, "walking", 1, fps=25)
        assert np.array_equal(half, h36m.load(data, 6, "walking", 1)[::2])
        assert half.flags["C_CONTIGUOUS"]

    def test_a_byte_order_mark_is_skipped(self, broken):
        data = broken("\ufeff" + row())
        marked = h36m.load(data, 1, "walking", 1)
        (data.folder / "S1/walking_1.txt").write_text(row(), encoding="utf-8")
        assert np.array_equal(marked, h36m.load(data, 1, "walking", 1))

    def test_one_row(self, made):
        assert h36m.load(h36m.open_root(made), 6, "posing", 1).shape == (1, 99)

    def test_other_notations_of_numbers_and_line_endings(self, broken):
        data = broken(row(_3="1e-3", _4=" -2 ") + "\r\n" + row(_98="+12.5"))
        rows = h36m.load(data, 1, "walking", 1)
        assert rows.shape == (2, 99)
        assert (rows[0, 3], rows[0, 4], rows[1, 98]) == (np.float32(1e-3), -2, 12.5)

    @pytest.mark.parametrize(
        ("text", "message"),
        [
            ("", "no rows"),
            ("\n \n", "no rows"),
            (row() + "\n" + row() + ",1\n", "line 2 has 100 columns, not 99"),
            (row()[:-10] + "\n", "line 1 has 98 columns, not 99"),
            (row() + ",\n", "line 1 has 100 columns, not 99"),
            (row() + "\n0.5\n", "line 2 has 1 columns, not 99"),
            (row() + "\n" + row(_7="0.1.2"), r"line 2, column 7 \(of 0 to 98\): '0.1.2' is not a number"),
            (row(_0=""), "line 1, column 0 .*: '' is not a number"),
            (row(_5="nan"), "line 1, column 5 .*: 'nan' is not a finite number"),
            (row() + "\n\n" + row(_5="-inf"), "line 3, column 5 .*: '-inf' is not a finite number"),
            (row(_98="1e39"), "line 1, column 98 .*: '1e39' is not a finite number"),
            (row(_2="1_0"), "could not convert string '1_0'"),
            (row(_2="# 3"), "line 1, column 2 .*: '# 3' is not a number"),
            (b"\xff\xfe\x00", "the text is UTF-16; save it as UTF-8"),
            (row().encode() + b"\n\xff", "line 2 is not UTF-8 text"),
        ],
    )
    @pytest.mark.filterwarnings("error")
    def test_broken_files(self, broken, text, message):
        with pytest.raises(ValueError, match=rf"S1.walking_1.txt: {message}"):
            h36m.load(broken(text), 1, "walking", 1)

    @pytest.mark.parametrize(
        ("error", "change", "message"),
        [
            (ValueError, {"subject": 2}, "subject: expected one of 1, 5, 6, 7, 8, 9, 11, got 2"),
            (TypeError, {"subject": "S1"}, "subject: expected a positive integer, got 'S1'"),
            (ValueError, {"clip": 3}, "clip: expected one of 1, 2, got 3"),
            (TypeError, {"clip": True}, "clip: expected a positive integer, got True"),
            (ValueError, {"action": "Walking"}, "action: expected one of directions, .*, got 'Walking'"),
            (TypeError, {"action": 3}, "action: expected one of directions"),
            (ValueError, {"fps": 30}, "fps: expected 50 or 25 frames per second, got 30"),
            (FileNotFoundError, {"subject": 7}, "lacks S7/walking_2.txt$"),
        ],
    )
    def test_bad_arguments(self, made, error, change, message):
        with pytest.raises(error, match=message):
            h36m.load(h36m.open_root(made), **{"subject": 1, "action": "walking", "clip": 2} | change)


class TestCache:
    def test_the_cache_holds_the_numbers_of_the_text(self, made, tmp_path, monkeypatch):
        plain = h36m.open_root(made)
        data = h36m.open_root(made, cache=tmp_path / "new" / "cache")
        first = h36m.load(data, 5, "walking", 1)
        monkeypatch.setattr(h36m, "_parse", None)  # from here on, the text must not be parsed again
        second = h36m.load(data, 5, "walking", 1)
        monkeypatch.undo()
        for rows in (first, second):
            assert rows.dtype == np.float32
            assert np.array_equal(rows, h36m.load(plain, 5, "walking", 1))
            rows[0] = 0  # the caller's copy
        assert len(list((tmp_path / "new" / "cache").iterdir())) == 1

    def test_the_cache_never_goes_stale(self, broken, tmp_path):
        data = broken(row(), cache=tmp_path / "cache")
        assert h36m.load(data, 1, "walking", 1)[0, 0] == 0.5
        (data.folder / "S1/walking_1.txt").write_text(row(_0="0.6000000"), encoding="utf-8")
        assert h36m.load(data, 1, "walking", 1)[0, 0] == np.float32(0.6)

    @pytest.mark.parametrize("damage", ["empty", "cut", "other", "pickle"])
    def test_a_damaged_cache_is_repaired(self, made, tmp_path, damage):
        data = h36m.open_root(made, cache=tmp_path)
        expected = h36m.load(data, 1, "walking", 1)
        (kept,) = tmp_path.iterdir()
        if damage == "empty":
            kept.write_bytes(b"")
        elif damage == "cut":
            kept.write_bytes(kept.read_bytes()[:-1])
        elif damage == "other":
            np.save(kept, np.zeros((3, 98), np.float32))
        else:
            np.save(kept, np.array([{}], object), allow_pickle=True)
        for _ in range(2):
            assert np.array_equal(h36m.load(data, 1, "walking", 1), expected)
        assert np.array_equal(np.load(kept), expected)
        assert list(tmp_path.iterdir()) == [kept]

    def test_by_default_nothing_is_written(self, broken):
        data = broken(row())
        before = sorted(data.folder.rglob("*"))
        h36m.load(data, 1, "walking", 1)
        assert sorted(data.folder.rglob("*")) == before


class TestTraining:
    def test_both_clips_of_the_subjects(self, made):
        data = h36m.open_root(made)
        clips = h36m.training_clips(data, ["walking"], subjects=(6, 1), fps=25)
        assert list(clips) == [f"S{subject}/walking_{clip}.txt" for subject in (6, 1) for clip in (1, 2)]
        assert np.array_equal(clips["S6/walking_2.txt"], h36m.load(data, 6, "walking", 2, fps=25))

    def test_errors_name_all_missing_files(self, made):
        data = h36m.open_root(made)
        message = r"lacks S7/walking_2.txt; subjects with all files: \(1, 6, 8, 9, 11\)$"
        with pytest.raises(FileNotFoundError, match=message):
            h36m.training_clips(data, ["walking"])
        with pytest.raises(
            FileNotFoundError, match=r"lacks S1/posing_1.txt S1/posing_2.txt S6/posing_2.txt S7.*: \(\)$"
        ):
            h36m.training_clips(data, ["walking", "posing"])

    @pytest.mark.parametrize(
        ("actions", "subjects", "message"),
        [
            ([], TRAIN_SUBJECTS, "actions: expected a sequence of actions"),
            ("walking", TRAIN_SUBJECTS, "actions: expected a sequence of actions, got 'walking'"),
            (["walking"], (), "subjects: expected one or more of the training subjects"),
            (["walking"], (1, 5), r"subjects: expected one or more of the training subjects .*, got \(1, 5\)"),
            (["running"], (1,), "action: expected one of .* got 'running'"),
        ],
    )
    def test_bad_arguments(self, made, actions, subjects, message):
        with pytest.raises(ValueError, match=message):
            h36m.training_clips(h36m.open_root(made), actions, subjects=subjects)


@pytest.mark.filterwarnings("ignore:.*length not checked")
class TestTestWindows:
    @pytest.mark.parametrize(
        ("windows", "draw", "count"),
        [
            ("srnn-8", srnn_windows, 8),
            ("srnn-8-late", lambda lengths, **options: srnn_windows(lengths, late=True, **options), 8),
            ("random-256", random_windows, 256),
        ],
    )
    def test_windows_follow_the_protocol(self, made, windows, draw, count):
        (task,) = Human36M().tasks(made, ["waiting"], windows)
        assert (task.action, task.protocol) == ("waiting", windows)
        assert task.seed_frames.shape == (count, 50, 99)
        assert task.target.shape == (count, 100, 99)
        clips = [h36m.load(h36m.open_root(made), 5, "waiting", clip, fps=25) for clip in (1, 2)]
        places = draw([len(clip) for clip in clips], n_seed=50, n_target=100)
        for place, before, after in zip(places, task.seed_frames, task.target, strict=True):
            both = np.concatenate([before, after])
            assert np.array_equal(both, clips[place.clip][place.start : place.start + 150])

    def test_bad_arguments(self, made):
        with pytest.raises(ValueError, match=r"^protocol: expected one of srnn-8, srnn-8-late, random-256, got 'all'"):
            next(Human36M().tasks(made, ["walking"], "all"))
        with pytest.raises(FileNotFoundError, match=r"lacks S5/eating_1.txt S5/eating_2.txt$"):
            next(Human36M().tasks(made, ["eating"]))


class TestLengths:
    def test_a_truncated_clip_is_refused(self, made):
        message = r"S5.walking_1.txt: 173 frames at 25 frames per second, expected 1500; test windows depend on"
        for windows in h36m.WINDOWS:
            with pytest.raises(ValueError, match=message):
                next(Human36M().tasks(made, ["walking"], windows))

    def test_validation_and_sensitivity_check_the_length(self, made):
        pytest.importorskip("torch")
        from npss_baselines.evaluation.sensitivity import motion_of

        with pytest.raises(ValueError, match="173 frames at 25 frames per second, expected 1500"):
            motion_of(Human36M(), made)
        with pytest.raises(ValueError, match="173 frames at 25 frames per second, expected 1500"):
            Human36M().validation_tasks(made, ["walking"])

    def test_an_unknown_length_warns(self, made):
        message = r"S5.waiting_[12].txt: length not checked, because the expected length is unknown"
        with pytest.warns(UserWarning, match=message) as caught:
            h36m.load_test_clips(h36m.open_root(made), "waiting")
        assert len(caught) == 2

    @pytest.mark.parametrize(("clip", "length"), [(1, 1500), (2, 1261)])
    def test_one_row_matters(self, monkeypatch, clip, length):
        rows = {f"S5/walking_{i}.txt": np.zeros((n, 99), np.float32) for i, n in enumerate((1500, 1261), 1)}
        monkeypatch.setattr(h36m, "_load", lambda *_: rows)
        data = h36m.H36M(h36m.Path("dataset"))
        assert [len(clip) for clip in h36m.load_test_clips(data, "walking")] == [1500, 1261]
        for other in (length - 1, length + 1):
            rows[f"S5/walking_{clip}.txt"] = np.zeros((other, 99), np.float32)
            with pytest.raises(ValueError, match=f"walking_{clip}.txt: {other} frames .*, expected {length};"):
                h36m.load_test_clips(data, "walking")


class TestHuman36M:
    def test_the_known_missing_files(self, h36m_root):
        expected = [f"{subject}/{name}.txt" for subject, names in MISSING.items() for name in names.split()]
        assert h36m.missing(h36m.open_root(h36m_root)) == expected

    @pytest.mark.parametrize("name", ["S5/walking_1", "S1/eating_2", "S11/posing_1"])
    def test_the_numbers(self, h36m_root, name):
        data = h36m.open_root(h36m_root)
        subject, action, clip = name.replace("_", "/").split("/")
        rows = h36m.load(data, int(subject[1:]), action, int(clip))
        text = (data.folder / f"{name}.txt").read_text(encoding="utf-8").replace("\n", ",").rstrip(",")
        assert np.array_equal(rows.ravel(), np.array([float(field) for field in text.split(",")]).astype(np.float32))
        assert np.array_equal(rows, np.loadtxt(data.folder / f"{name}.txt", delimiter=",", dtype=np.float32))

    def test_lengths_of_the_test_clips(self, h36m_root):
        data = h36m.open_root(h36m_root)
        for action, lengths in TEST_LENGTHS.items():
            for clip, length in enumerate(lengths, 1):
                if length is not None:
                    assert len(h36m.load(data, 5, action, clip, fps=25)) == length
                else:
                    assert f"S5/{action}_{clip}.txt" in h36m.missing(data)

    @pytest.mark.parametrize("action", ACTIONS)
    def test_windows_of_every_action_that_has_a_test_set(self, h36m_root, action):
        data = h36m.open_root(h36m_root)
        if any(f"S5/{action}_{clip}.txt" in h36m.missing(data) for clip in (1, 2)):
            with pytest.raises(FileNotFoundError, match=f"lacks S5/{action}"):
                next(Human36M().tasks(h36m_root, [action]))
        else:
            (task,) = Human36M().tasks(h36m_root, [action])
            assert (task.seed_frames.shape, task.target.shape) == ((8, 50, 99), (8, 100, 99))
            moving = task.target[..., 6:].std(axis=1) > 1e-4
            assert (moving.sum(axis=1) == 48).all()

    def test_smoking_has_four_training_subjects(self, h36m_root):
        with pytest.raises(FileNotFoundError, match=r"lacks S7/smoking_1.* with all files: \(1, 6, 8, 11\)$"):
            h36m.training_clips(h36m.open_root(h36m_root), ["smoking"])
