"""The registry of file formats: a registered format is read and written wherever files are."""

import json

import numpy as np
import pytest

import npss
from command_line import run, samples
from npss.files import FORMATS, Format, in_memory, listed, read_json, register_format, suffixes, write_samples
from npss.files._samples import read_pair, read_poses
from npss.records import measure
from registered import registered, restored


@pytest.fixture
def poses():
    return np.random.default_rng(6).normal(size=(2, 2, 12, 99)) * 0.3


def read(path):
    arrays = json.loads(path.read_text(encoding="utf-8"))
    return in_memory(arrays)


def write(stream, arrays):
    stream.write(json.dumps({name: array.tolist() for name, array in arrays.items()}).encode())


EVERYTHING = Format((".lists",), arrays=read, samples=read, write=write)


@pytest.fixture
def _lists():
    with registered(FORMATS, **{".lists": EVERYTHING}):
        yield


class TestBuiltIn:
    def test_contents_of_each_format(self):
        assert suffixes("array") == (".npy",)
        assert suffixes("arrays") == (".npz",)
        assert suffixes("samples") == suffixes("write") == (".h5", ".hdf5", ".npz")
        assert suffixes("records") == (".json",)
        assert listed("array", "arrays", "samples") == ".npy, .h5, .hdf5 or .npz"

    @pytest.mark.parametrize("suffix", [".h5", ".hdf5", ".npz"])
    def test_what_is_written_is_read(self, tmp_path, poses, suffix):
        if suffix != ".npz":
            pytest.importorskip("h5py")
        path = tmp_path / f"a{suffix}"
        write_samples(path, samples(poses, np.arange(12.0)))
        (pair,) = read_poses(path)
        assert np.array_equal(pair.gt, poses[0])
        assert np.array_equal(pair.pred, poses[1])
        assert np.array_equal(pair.stored_curve, np.arange(12.0))

    def test_formats_that_cannot_be_written(self, tmp_path):
        with pytest.raises(ValueError, match=r"a\.json: expected a \.h5, \.hdf5 or \.npz file"):
            write_samples(tmp_path / "a.json", {})


@pytest.mark.usefixtures("_lists")
class TestOnesOwn:
    def test_is_read_by_every_command(self, capsys, tmp_path, poses):
        pytest.importorskip("pandas")
        write_samples(tmp_path / "mine.lists", samples(poses))
        write_samples(tmp_path / "other.npz", samples((poses[0], poses[0] + 0.1)))
        expected = f"{npss.score(*map(npss.poses_to_euler, poses)):.4f}"
        assert expected in run(capsys, "score", tmp_path / "mine.lists")[1]
        assert "mine" in run(capsys, "leaderboard", tmp_path)[1]
        assert run(capsys, "study", "page", tmp_path, "-o", tmp_path / "page.html")[0] == 0
        assert "mine" in npss.leaderboard(tmp_path / "mine.lists").to_text()

    def test_arrays_by_name(self, capsys, tmp_path, poses):
        write_samples(tmp_path / "gt.lists", {"a": poses[0], "b": poses[1]})
        np.savez(tmp_path / "pred.npz", a=poses[1])
        (pair,) = read_pair(tmp_path / "gt.lists", tmp_path / "pred.npz", key="a")
        assert (pair.name, np.array_equal(pair.gt, poses[0])) == ("a", True)

    def test_single_arrays_may_be_lists(self, tmp_path):
        (tmp_path / "a.rows").write_text("[[1, 2], [3, 4]]", encoding="utf-8")
        with registered(FORMATS, **{".rows": Format((".rows",), array=read_json)}):
            (pair,) = read_pair(tmp_path / "a.rows", tmp_path / "a.rows")
        assert pair.gt.tolist() == pair.pred.tolist() == [[1, 2], [3, 4]]

    def test_is_in_the_help(self, capsys):
        assert ".h5, .hdf5, .npz or .lists" in " ".join(run(capsys, "score", "--help")[1].split())
        assert ".npz or .lists" in " ".join(run(capsys, "leaderboard", "--help")[1].split())

    def test_is_too_large(self, tmp_path, poses):
        write_samples(tmp_path / "a.lists", samples(poses))
        with pytest.raises(ValueError, match=r"a\.lists: its arrays may take"):
            read_poses(tmp_path / "a.lists", max_size=1e-6)

    @pytest.mark.parametrize(
        ("content", "message"),
        [
            ('{"expmap/gt/walking_0": [[1], [1, 2]]}', "inhomogeneous"),
            ('{"expmap/gt/a_0": [["x"]], "expmap/preds/a_0": [["x"]]}', "expmap/gt/a_0: expected real numbers"),
            ('{"motion": [[1]]}', "motion: expected CONDITION/gt, CONDITION/pred and meta, or expmap/gt/ACTION_i"),
            ("[]", "not a readable .lists file"),
            ("{", "Expecting property name"),
        ],
    )
    def test_is_broken(self, capsys, tmp_path, content, message):
        path = tmp_path / "a.lists"
        path.write_text(content, encoding="utf-8")
        status, out, err = run(capsys, "score", path)
        assert (status, out, err.count("\n")) == (2, "", 1)
        assert err.startswith(f"npss: error: {path}: ")
        assert message in err

    def test_masked_arrays_are_refused(self, tmp_path, poses):
        masked = {name: np.ma.masked_greater(array, 0.5) for name, array in samples(poses).items()}
        (tmp_path / "a.masked").touch()
        with (
            registered(FORMATS, **{".masked": Format((".masked",), samples=lambda path: in_memory(masked))}),
            pytest.raises(TypeError, match="masked"),
        ):
            read_poses(tmp_path / "a.masked")


def test_records(capsys, tmp_path, poses):
    pytest.importorskip("pandas")
    measured = measure(*map(npss.poses_to_euler, poses), fps=25, sequences=True, frames=12)
    record = {"model": "mine", "action": "walking", **measured}
    (tmp_path / "a.lines").write_text(json.dumps(record) + "\n", encoding="utf-8")

    def read_lines(path):
        return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()]

    assert "a.lines: expected .h5, .hdf5 or .npz samples" in run(capsys, "leaderboard", tmp_path / "a.lines")[2]
    with registered(FORMATS, **{".lines": Format((".lines",), records=read_lines)}):
        (tmp_path / "a.json").write_text(json.dumps([record]), encoding="utf-8")
        first, second = (run(capsys, "leaderboard", tmp_path / name) for name in ("a.lines", "a.json"))
    assert first == second
    assert f"{measured['npss']['paper']:.3f}" in first[1]


class TestRegistration:
    def test_every_suffix_is_registered(self):
        form = Format((".one", ".two"), array=np.load)
        with restored(FORMATS):
            register_format(form)
            assert FORMATS[".one"] is FORMATS[".two"] is form
            register_format(Format((".two",), array=np.load), replace=True)
            assert FORMATS[".two"] is not form

    def test_none_is_replaced(self):
        with pytest.raises(ValueError, match=r"^the suffix '\.npz' is registered already$"):
            register_format(Format((".npz",), array=np.load))

    def test_all_suffixes_or_none(self):
        with pytest.raises(ValueError, match=r"^the suffix '\.npz' is registered already$"):
            register_format(Format((".one", ".npz"), array=np.load))
        assert ".one" not in FORMATS

    def test_invalid_formats(self):
        with pytest.raises(TypeError, match=r"^form: expected a Format, got None"):
            register_format(None)

    @pytest.mark.parametrize("form", [(), ("npz",), (".tar.gz",), (".",), (1,), (".a b",)])
    def test_suffixes(self, form):
        with pytest.raises(ValueError, match=r"^suffixes: expected a dot and letters each, such as \.npz, got "):
            Format(form, array=np.load)

    def test_one_suffix_is_a_tuple_too(self):
        with pytest.raises(TypeError, match=r"^suffixes: expected a sequence of texts"):
            Format(".npz", array=np.load)

    def test_functions(self):
        with pytest.raises(ValueError, match=r"^\.a: expected at least one function of array, arrays, samples, "):
            Format((".a",))
        with pytest.raises(TypeError, match=r"^samples: expected a function, got 'read'"):
            Format((".a",), samples="read")


@pytest.mark.parametrize(
    ("extra", "hint"), [("h5", "; in the project's folder: pip install '.[h5]'"), (None, ", which is not installed")]
)
def test_a_package_that_is_missing(capsys, tmp_path, extra, hint):
    def missing(*arguments):
        import nowhere_to_be_found  # noqa: F401

    form = Format((".x",), array=missing, arrays=missing, samples=missing, write=missing, extra=extra)
    path = tmp_path / "a.x"
    path.touch()
    with registered(FORMATS, **{".x": form}):
        for command in (["score", path], ["score", path, path]):
            message = f"npss: error: {path}: reading .x needs nowhere_to_be_found{hint}\n"
            assert run(capsys, *command) == (2, "", message)
        with pytest.raises(ValueError, match=r"^writing \.x needs nowhere_to_be_found"):
            write_samples(path, {})
