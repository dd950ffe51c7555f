"""Files of arrays that are damaged, hostile, or hold more than is needed."""

import os
import tracemalloc
import zipfile
import zlib
from pathlib import Path

import numpy as np
import pytest

import npss
from command_line import run, samples, write_h5
from npss.files._samples import read_pair, read_poses

GIB = 2**30


@pytest.fixture
def poses():
    return np.random.default_rng(6).normal(size=(2, 2, 12, 99)) * 0.3


@pytest.fixture
def h5py():
    return pytest.importorskip("h5py")


def refused(path, message, **options):
    """Make sure that a file is refused in one line that names it, and in little memory."""
    tracemalloc.start()
    with pytest.raises((TypeError, ValueError), match=message) as info:
        read_poses(path, **options)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert str(info.value).startswith(f"{path}: ")
    assert peak < 2**24


class TestOnlyWhatIsNeeded:
    def test_a_large_data_set_beside_samples_is_not_read(self, h5py, tmp_path, poses):
        path = write_h5(tmp_path / "a.h5", samples(poses))
        with h5py.File(path, "a") as file:
            file.create_dataset("train/images", shape=(2**40,), dtype="f4", chunks=True)
            file["expmap/config"] = file["expmap/gt/labels"] = "text"
        (pair,) = read_poses(path)
        assert np.array_equal(pair.gt, poses[0])
        assert np.array_equal(pair.pred, poses[1])

    def test_objects_and_texts_beside_samples_are_not_read(self, tmp_path, poses):
        path = tmp_path / "a.npz"
        np.savez(path, **samples(poses), config=np.array({"lr": 1}, dtype=object), names=["x"], fps=25)
        assert np.array_equal(read_poses(path)[0].pred, poses[1])

    def test_thousands_of_nested_groups(self, h5py, tmp_path, poses):
        path = write_h5(tmp_path / "a.h5", samples(poses))
        with h5py.File(path, "a") as file:
            group = file
            for _ in range(2000):
                group = group.create_group("g")
        assert len(read_poses(path)) == 1

    @pytest.mark.parametrize(
        "beside",
        [{"fps": 25}, {"names": np.array(["x"])}, {"config": np.array([{}], dtype=object)}, {"made": b"bytes"}],
    )
    def test_values_beside_motion(self, capsys, tmp_path, poses, beside):
        for name, motion in zip(("gt", "pred"), poses, strict=True):
            np.savez(tmp_path / f"{name}.npz", motion=motion, **beside)
        (pair,) = read_pair(tmp_path / "gt.npz", tmp_path / "pred.npz")
        assert pair.name == "motion"
        assert np.array_equal(pair.pred, poses[1])

    def test_as_amass(self, capsys, tmp_path, poses):
        for name, motion in zip(("gt", "pred"), poses[:, 0], strict=True):
            stated = {"trans": np.zeros((12, 3)), "mocap_framerate": 120, "gender": "male"}
            np.savez(tmp_path / f"{name}.npz", poses=motion, **stated)
            np.savez(tmp_path / f"{name}_betas.npz", poses=motion, betas=np.zeros(16), **stated)
        gt, pred, gt_betas, pred_betas = (tmp_path / f"{name}.npz" for name in ("gt", "pred", "gt_betas", "pred_betas"))
        status, _, err = run(capsys, "score", gt, pred)
        assert status == 2
        assert err.startswith("npss: error: trans: gt: no power in any feature")
        assert err.endswith("; --key NAME scores a single array\n")
        message = r"not all arrays are motion .*; choose one by --key NAME: poses \(12, 99\) of float64, betas \(16,\)"
        with pytest.raises(ValueError, match=message):
            read_pair(gt_betas, pred_betas)
        for paths in ((gt, pred), (gt_betas, pred_betas)):
            status, out, _ = run(capsys, "score", *paths, "--key", "poses")
            assert (status, out.splitlines()[0]) == (0, "poses")
        assert f"{npss.score(*poses[:, 0]):.4f}" in out

    def test_key(self, capsys, tmp_path, poses):
        gt, pred, path = tmp_path / "gt.npz", tmp_path / "pred.npz", tmp_path / "gt.npy"
        np.savez(gt, a=poses[0], b=poses[1], text="x")
        np.savez(pred, a=poses[1], c=poses[0])
        np.save(path, poses[0])
        assert np.array_equal(read_pair(gt, pred, key="a")[0].pred, poses[1])
        assert np.array_equal(read_pair(path, pred, key="c")[0].pred, poses[0])
        with pytest.raises(ValueError, match=r"pred\.npz: no array 'b' in it; arrays: a \(2, 12, 99\) of float64"):
            read_pair(gt, pred, key="b")
        with pytest.raises(TypeError, match=r"gt\.npz: text: expected real numbers, got strings"):
            read_pair(gt, gt, key="text")
        with pytest.raises(ValueError, match="--key chooses an array of a"):
            read_pair(path, path, key="a")
        assert "is a file of results" in run(capsys, "score", gt, "--key", "a")[2]


class TestLinks:
    def test_soft_links_inside_the_file(self, h5py, tmp_path, poses):
        path = tmp_path / "a.h5"
        with h5py.File(path, "w") as file:
            file["data/truth/0"], file["data/truth/1"] = poses[0]
            file["all/expmap/preds/walking_0"] = poses[1, 0]
            file["all/expmap/preds/walking_1"] = poses[1, 1]
            file["curve"] = np.zeros(12)
            file["expmap"] = h5py.SoftLink("./all/expmap")
            for i in range(2):
                file[f"all/expmap/gt/walking_{i}"] = h5py.SoftLink(f"/data/truth/{i}")
            file["mean_walking_error"] = h5py.SoftLink("curve")
        (pair,) = read_poses(path)
        assert np.array_equal(pair.gt, poses[0])
        assert np.array_equal(pair.pred, poses[1])
        assert np.array_equal(pair.stored_curve, np.zeros(12))

    @pytest.mark.parametrize(
        ("name", "target", "message"),
        [
            ("expmap/gt/walking_1", "/nowhere", "expmap/gt/walking_1: broken link"),
            ("expmap/gt/walking_1", "walking_0/x", "expmap/gt/walking_1: broken link"),
            ("expmap/gt/walking_1", "walking_1", "expmap/gt/walking_1: circular link"),
            ("expmap/gt/walking_1", "/out/expmap/gt/walking_1", "expmap/gt/walking_1: link to another file"),
            ("expmap/gt/walking_1", "/expmap", "expmap/gt/walking_1: expected a data set"),
            ("mean_walking_error", "/nowhere", "mean_walking_error: broken link"),
        ],
    )
    def test_soft_links_that_lead_nowhere(self, h5py, tmp_path, poses, name, target, message):
        whole = write_h5(tmp_path / "whole.h5", samples(poses))
        path = write_h5(tmp_path / "a.h5", samples(poses, np.zeros(12)))
        with h5py.File(path, "a") as file:
            del file[name]
            file["out"] = h5py.ExternalLink(str(whole), "/")
            file[name] = h5py.SoftLink(target)
        refused(path, message)

    @pytest.mark.parametrize("name", ["expmap/gt/walking_1", "expmap/preds", "expmap"])
    def test_external_links(self, h5py, tmp_path, poses, name):
        whole = write_h5(tmp_path / "whole.h5", samples(poses))
        path = write_h5(tmp_path / "a.h5", samples(poses))
        with h5py.File(path, "a") as file:
            del file[name]
            file[name] = h5py.ExternalLink(str(whole), name)
        refused(path, rf"{name}[^:]*: link to another file")

    def test_an_external_link_to_a_pipe_is_not_opened(self, h5py, tmp_path, poses):
        os.mkfifo(tmp_path / "pipe")
        path = write_h5(tmp_path / "a.h5", samples(poses))
        with h5py.File(path, "a") as file:
            file["expmap/gt/walking_2"] = h5py.ExternalLink(str(tmp_path / "pipe"), "x")
            file["expmap/preds/walking_2"] = h5py.SoftLink("/expmap/gt/walking_2")
        refused(path, "expmap/gt/walking_2: link to another file")

    def test_values_in_another_file(self, h5py, tmp_path, poses):
        (tmp_path / "secret").write_bytes(poses[0, 0].tobytes())
        whole = write_h5(tmp_path / "whole.h5", samples(poses))
        for way in ("external", "virtual", "virtual of no stated length"):
            path = write_h5(tmp_path / f"{way}.h5", samples(poses))
            name = "expmap/gt/walking_1"
            with h5py.File(path, "a") as file:
                del file[name]
                if way == "external":
                    stored = [(str(tmp_path / "secret"), 0, h5py.h5f.UNLIMITED)]
                    file.create_dataset(name, shape=(12, 99), dtype="f8", external=stored)
                else:
                    most = (12 if way == "virtual" else None, 99)
                    source = h5py.VirtualSource(str(whole), name, shape=(12, 99), maxshape=most)
                    layout = h5py.VirtualLayout(shape=(12, 99), maxshape=most, dtype="f8")
                    if way == "virtual":
                        layout[:] = source
                    else:
                        layout[: h5py.h5s.UNLIMITED] = source[: h5py.h5s.UNLIMITED]
                    file.create_virtual_dataset(name, layout)
            refused(path, f"{name}: the values are in another file; copy them into this one")

    def test_a_group_is_no_data_set(self, h5py, tmp_path, poses):
        path = write_h5(tmp_path / "a.h5", {**samples(poses), "expmap/gt/walking_2/x": np.ones(3)})
        refused(path, "walking_2")
        path = write_h5(tmp_path / "b.h5", {"expmap/gt": np.ones(3)})
        refused(path, "expmap/gt/: expected a group")
        refused(write_h5(tmp_path / "c.h5", {"expmap": np.ones(3)}), "no arrays expmap/gt/ACTION_i")
        refused(write_h5(tmp_path / "d.h5", {}), "no arrays expmap/gt/ACTION_i")


class TestSize:
    @pytest.mark.parametrize("suffix", [".npz", ".h5"])
    def test_invalid_layouts_are_refused_before_reading(self, tmp_path, poses, suffix):
        big = np.broadcast_to(np.float32(0), (2**17, 99))
        arrays = {**samples(poses), "expmap/gt/walking_0": big}
        path = tmp_path / f"a{suffix}"
        if suffix == ".npz":
            np.savez_compressed(path, **arrays)
        else:
            h5py = pytest.importorskip("h5py")
            with h5py.File(path, "w") as file:
                for name, array in arrays.items():
                    file.create_dataset(name, shape=array.shape, dtype=array.dtype, chunks=True, compression="gzip")
        refused(path, "the samples of walking differ in shape")

    def test_declared_sizes(self, h5py, tmp_path):
        path = tmp_path / "a.h5"
        with h5py.File(path, "w") as file:
            for kind in ("gt", "preds"):
                file.create_dataset(f"expmap/{kind}/walking_0", shape=(2**21, 99), dtype="f4", chunks=(2**16, 99))
        assert path.stat().st_size < 2**16
        refused(path, r"its arrays may take 3\.12 GiB of memory, more than 2; raise --max-size")

    def test_max_size_allows_more_or_less(self, capsys, tmp_path, poses):
        for name in ("one", "two"):
            np.savez(tmp_path / f"{name}.npz", **samples(poses))
        size = 4 * 12 * 99 * 8 / GIB
        assert len(read_poses(tmp_path / "one.npz", max_size=size)) == 1
        refused(tmp_path / "one.npz", "may take 3.54e-05 GiB of memory, more than 3.5", max_size=size * 0.99)
        page = tmp_path / "page.html"
        for command in (
            ["score", tmp_path / "one.npz"],
            ["score", tmp_path / "one.npz", tmp_path / "two.npz"],
            ["leaderboard", tmp_path],
            ["report", tmp_path, "-o", page],
            ["study", "page", tmp_path, "-o", page],
        ):
            status, out, err = run(capsys, *command, "--max-size", size / 2)
            assert (status, out) == (2, "")
            assert "one.npz: its arrays may take" in err
            assert not page.exists()
        assert run(capsys, "leaderboard", tmp_path, "--max-size", 1)[0] == 0
        assert run(capsys, "study", "page", tmp_path, "-o", page, "--max-size", 1)[0] == 0
        for text in ("0", "-1", "nan", "inf", "much"):
            message = run(capsys, "leaderboard", tmp_path, "--max-size", text)[2]
            assert f"argument --max-size: invalid: expected a positive, finite number of GiB, got {text!r}" in message
        with pytest.raises(ValueError, match="max_size: expected a positive"):
            npss.leaderboard(tmp_path, max_size=0)

    def test_a_chunk_that_is_larger_than_its_data_set(self, h5py, tmp_path, poses):
        path = write_h5(tmp_path / "a.h5", samples(poses))
        with h5py.File(path, "a") as file:
            del file["expmap/gt/walking_1"]
            dataset = file.create_dataset(
                "expmap/gt/walking_1", shape=(12, 99), dtype="f8", chunks=(2**20, 300), maxshape=(None, None)
            )
            assert dataset.id.get_storage_size() == 0
        refused(path, r"its arrays may take 2\.34 GiB")

    def test_a_chunk_that_inflates_to_more_than_is_declared(self, h5py, tmp_path, poses):
        path = write_h5(tmp_path / "a.h5", samples(poses))
        with h5py.File(path, "a") as file:
            del file["expmap/gt/walking_1"]
            properties = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
            properties.set_chunk((12, 99))
            for _ in range(2):
                properties.set_deflate(9)
            space = h5py.h5s.create_simple((12, 99))
            dataset = h5py.h5d.create(
                file["expmap/gt"].id, b"walking_1", h5py.h5t.NATIVE_DOUBLE, space, dcpl=properties
            )
            dataset.write_direct_chunk((0, 0), zlib.compress(zlib.compress(bytes(2**22), 9), 9))
        refused(path, "its arrays may take", max_size=0.001)

    def test_compressed_samples_are_read(self, h5py, tmp_path, poses):
        path = tmp_path / "a.h5"
        with h5py.File(path, "w") as file:
            for name, array in samples(poses).items():
                file.create_dataset(name, data=array, compression="gzip", shuffle=True, fletcher32=True)
        assert np.array_equal(read_poses(path)[0].pred, poses[1])

    def test_array_types_hide_no_values(self, h5py, tmp_path, poses):
        path = write_h5(tmp_path / "a.h5", samples(poses))
        with h5py.File(path, "a") as file:
            del file["expmap/gt/walking_1"]
            file.create_dataset("expmap/gt/walking_1", shape=(12, 99), dtype=np.dtype(("f4", (2**20,))), chunks=(1, 1))
        refused(path, "walking_1: expected real numbers, got records")


class TestNpz:
    def write(self, path: Path, members):
        with zipfile.ZipFile(path, "w") as archive:
            for name, content in members:
                archive.writestr(name, content)
        return path

    def npy(self, array):
        from io import BytesIO

        content = BytesIO()
        np.save(content, array)
        return content.getvalue()

    @pytest.mark.parametrize("content", [b"hello", b"", b"\x93NUMPY\x03\x00", b"\x93NUMPY\x01\x00\x05\x00{1:2}"])
    def test_a_member_that_is_not_an_array(self, tmp_path, content):
        path = self.write(tmp_path / "a.npz", [("a.npy", content)])
        with pytest.raises(ValueError, match=r"a\.npz: a: not a \.npy array"):
            read_pair(path, path)

    def test_a_header_that_claims_to_be_long(self, tmp_path):
        bomb = b"\x93NUMPY\x02\x00" + (2**25).to_bytes(4, "little") + bytes(2**25)
        names = ("expmap/gt/walking_0.npy", "expmap/preds/walking_0.npy")
        path = self.write(tmp_path / "a.npz", [(name, bomb) for name in names])
        refused(path, r"expmap/gt/walking_0: not a \.npy array")

    def test_other_members_are_no_arrays(self, tmp_path, poses):
        path = self.write(tmp_path / "a.npz", [("readme.txt", "x"), ("a.npy", self.npy(poses[0]))])
        assert read_pair(path, path)[0].name == "a"

    def test_a_shape_larger_than_the_file(self, tmp_path, poses):
        whole = self.npy(poses[0])
        lying = whole.replace(b"(2, 12, 99)", b"(2, 99, 99)")
        path = self.write(tmp_path / "a.npz", [("a.npy", lying)])
        with pytest.raises(ValueError, match=r"a\.npz: a: its shape \(2, 99, 99\) needs 156816 bytes, but there are"):
            read_pair(path, path)

    @pytest.mark.filterwarnings("ignore:Duplicate name")
    def test_a_duplicate_member(self, tmp_path, poses):
        path = self.write(tmp_path / "a.npz", 2 * [("a.npy", self.npy(poses[0]))])
        with pytest.raises(ValueError, match=r"a\.npz: duplicate array a\.npy"):
            read_pair(path, path)

    def test_compressors_that_numpy_does_not_use(self, tmp_path, poses):
        path = tmp_path / "a.npz"
        with zipfile.ZipFile(path, "w", zipfile.ZIP_LZMA) as archive:
            archive.writestr("a.npy", self.npy(poses[0]))
        with pytest.raises(ValueError, match=r"a\.npz: a: unsupported compression"):
            read_pair(path, path)


class TestFiles:
    @pytest.mark.parametrize("suffix", [".npy", ".npz", ".h5", ".json"])
    def test_a_named_pipe_is_no_file(self, capsys, tmp_path, suffix):
        path = tmp_path / f"pipe{suffix}"
        os.mkfifo(path)
        for command in (["score", path, path], ["score", path], ["leaderboard", path]):
            status, out, err = run(capsys, *command)
            assert (status, out) == (2, "")
            assert f"{path}: " in err
            assert err.count("\n") == 1

    @pytest.mark.parametrize("suffix", [".npz", ".h5"])
    def test_files_that_are_cut_off(self, tmp_path, poses, suffix):
        path = tmp_path / f"a{suffix}"
        if suffix == ".npz":
            np.savez(path, **samples(poses))
        else:
            write_h5(path, samples(poses))
        whole = path.read_bytes()
        for length in range(0, len(whole), 997):
            path.write_bytes(whole[:length])
            with pytest.raises(ValueError, match=f"a{suffix}: ") as info:
                read_poses(path)
            assert str(info.value).startswith(f"{path}: ")
