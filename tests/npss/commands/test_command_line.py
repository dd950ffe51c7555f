"""The command ``npss``, called as a user calls it."""

import json
import os
import platform
import runpy
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest

import npss
from command_line import run, samples, write_h5
from npss.commands import main
from npss.extras import install_hint
from npss.files._system_errors import doing


@pytest.fixture
def motion():
    return np.random.default_rng(5).normal(size=(2, 3, 100, 4)).cumsum(axis=2)


@pytest.fixture
def files(tmp_path, motion):
    for name, array in zip(("gt", "pred"), motion, strict=True):
        np.save(tmp_path / f"{name}.npy", array)
    return tmp_path / "gt.npy", tmp_path / "pred.npy"


@pytest.fixture
def poses():
    return np.random.default_rng(6).normal(size=(2, 3, 50, 99)) * 0.3


def euler(poses):
    return npss.poses_to_euler(poses[0]), npss.poses_to_euler(poses[1])


class TestScore:
    def test_every_convention_with_its_signature(self, capsys, files, motion):
        status, out, err = run(capsys, "score", *files)
        assert (status, err) == (0, "")
        for name in npss.CONVENTIONS:
            line = next(line for line in out.splitlines() if f" {name} " in line)
            assert f"{npss.score(*motion, convention=name):.4f}" in line
            assert line.endswith(npss.signature(name, frames=100, unwrap="off"))

    def test_json_is_unrounded(self, capsys, files, motion):
        _, out, _ = run(capsys, "score", *files, "--format", "json", "--convention", "released")
        (record,) = json.loads(out)
        assert record == {
            "npss": {"released": npss.score(*motion, convention="released")},
            "signature": npss.signature("released", frames=100, unwrap="off"),
            "signatures": {"released": npss.signature("released", frames=100, unwrap="off")},
            "diagnosis": [str(finding) for finding in npss.diagnose(*motion, convention="released")],
        }

    def test_what_unwrap_has_removed_is_not_diagnosed(self, capsys, tmp_path):
        angle = np.linspace(-1, 1, 40)[:, np.newaxis] * [2, 1]
        wrapped = np.where(angle > 1, angle - 2 * np.pi, angle)
        paths = [tmp_path / "gt.npy", tmp_path / "pred.npy"]
        for path, motion in zip(paths, (wrapped, angle), strict=True):
            np.save(path, motion)
        assert "jumps of about 2 pi" in run(capsys, "score", *paths)[1]
        assert "jumps of about 2 pi" not in run(capsys, "score", *paths, "--unwrap", "target")[1]

    def test_markdown(self, capsys, files):
        _, out, _ = run(capsys, "score", *files, "--format", "markdown")
        lines = out.splitlines()
        assert lines[0].startswith("| metric ")
        rows = lines[: lines.index("")]
        assert len(rows) == 5
        assert all(line.replace("\\|", "").count("|") == 5 for line in rows)

    def test_windows_and_times(self, capsys, files, motion):
        options = ["--fps", "25", "--edges-ms", "0", "1000", "4000", "--at-ms", "80", "--protocol", "mine"]
        options += ["--representation", "euler", "--unwrap", "target", "--convention", "paper"]
        _, out, _ = run(capsys, "score", *files, *options, "--format", "json")
        (record,) = json.loads(out)
        unwrapped = [npss.unwrap(array) for array in motion]
        assert record["npss_windows"]["paper"] == npss.score_windows(*unwrapped, fps=25, edges_ms=(0, 1000, 4000))
        assert record["npss"]["paper"] == npss.score(*unwrapped)
        assert record["euler_error"] == {"80": npss.euler_error(*motion, at_ms=(80,))[80]}
        stated = npss.parse_signature(record["signature"])
        assert stated["unwrap"] == "target"
        assert (stated["protocol"], stated["representation"], stated["fps"]) == ("mine", "euler", 25)
        _, out, _ = run(capsys, "score", *files, *options)
        assert "NPSS 1-4 s" in out
        assert "window:1-4" in out
        (error_line,) = (line for line in out.splitlines() if line.startswith("Euler error 80 ms"))
        assert "euler_error|version:1" in error_line
        assert "unwrap:off" in error_line

    def test_unknown_protocols_are_unverified(self, capsys, files):
        _, out, _ = run(capsys, "score", *files, "--protocol", "mine")
        assert "Protocol mine: unverified; names that are verified: lafan1, srnn-8, srnn-8-late." in out
        _, out, _ = run(capsys, "score", *files, "--protocol", "mine", "--format", "json")
        assert json.loads(out)[0]["verification"] == {"protocol": "mine", "ok": None}
        _, out, _ = run(capsys, "score", *files, "--protocol", "srnn-8", "--format", "markdown")
        assert "Protocol srnn-8: undecided whether this is its ground truth:" in out
        assert "protocol:srnn-8\\|unwrap:off`" in out
        assert "verification" not in json.loads(run(capsys, "score", *files, "--format", "json")[1])[0]

    def test_another_ground_truth_stands_beside_no_published_rows(self, capsys, tmp_path, poses):
        np.savez(tmp_path / "samples.npz", **samples(poses))
        command = ["score", tmp_path / "samples.npz", "--protocol", "srnn-8"]
        _, out, _ = run(capsys, *command)
        assert "Protocol srnn-8: NOT its ground truth, so these scores must not stand beside published ones:" in out
        assert f"- {poses.shape[2]} frames; srnn-8 has 100" in out
        (record,) = json.loads(run(capsys, *command, "--format", "json")[1])
        assert record["verification"]["findings"]
        for text in (record["signature"], *record["signatures"].values()):
            assert npss.parse_signature(text)["verified"] == "no"
        assert "the ground truth is not that of srnn-8" in npss.explain(record["signatures"]["released"])
        pytest.importorskip("pandas")
        with pytest.raises(ValueError, match="verified must not be stated, but is no"):
            npss.leaderboard([{"model": "mine", **record}], published=True)

    def test_other_features_are_not_the_benchmarks(self, capsys, files):
        _, out, _ = run(capsys, "score", *files, "--protocol", "lafan1")
        assert "Protocol lafan1: NOT its ground truth" in out
        assert "|verified:no" in out

    def test_verified_ground_truth(self, capsys, tmp_path, h36m_root):
        clips = [np.loadtxt(h36m_root / f"dataset/S5/eating_{k}.txt", delimiter=",")[::2] for k in (1, 2)]
        cut = npss.protocol.srnn_windows([len(clip) for clip in clips])
        gt = np.stack([clips[window.clip][window.target] for window in cut])
        np.save(tmp_path / "gt.npy", gt)
        np.savez(tmp_path / "samples.npz", **samples((gt, gt), action="eating"))
        for files in ([tmp_path / "gt.npy", tmp_path / "gt.npy", "--expmap"], [tmp_path / "samples.npz"]):
            _, out, _ = run(capsys, "score", *files, "--protocol", "srnn-8")
            assert "Protocol srnn-8: verified: 8 windows" in out
            _, out, _ = run(capsys, "score", *files, "--protocol", "srnn-8-late")
            assert "it is eating on time (srnn-8)" in out
        pred = gt.copy()
        pred[:, 1:] = pred[:, :1]
        np.savez(tmp_path / "other.npz", **samples((gt, pred), action="eating"))
        command = ["compare", tmp_path / "samples.npz", tmp_path / "other.npz", "--convention", "paper"]
        with pytest.warns(UserWarning, match=r"eating: sequences \d and \d overlap"):
            _, out, _ = run(capsys, *command)
        assert "p = 0.00781" in out  # too small
        _, out, err = run(capsys, *command, "--protocol", "srnn-8")
        assert (err, "fewer than 6 blocks give no p-value" in out, "|unwrap:off" in out) == ("", True, True)

    def test_archives_pair_by_name(self, capsys, tmp_path, motion):
        for name, array in zip(("gt", "pred"), motion, strict=True):
            np.savez(tmp_path / f"{name}.npz", walking=array, eating=array[:2])
        _, out, _ = run(capsys, "score", tmp_path / "gt.npz", tmp_path / "pred.npz", "--format", "json")
        records = {record["action"]: record for record in json.loads(out)}
        assert records["walking"]["npss"]["paper"] == npss.score(*motion)
        assert records["eating"]["npss"]["paper"] == npss.score(*motion[:, :2])
        _, out, _ = run(capsys, "score", tmp_path / "gt.npz", tmp_path / "pred.npz", "--format", "markdown")
        assert "### walking" in out

    def test_an_archive_of_one_array_beside_an_array(self, capsys, files, tmp_path, motion):
        np.savez(tmp_path / "pred.npz", whatever=motion[1])
        _, out, _ = run(capsys, "score", files[0], tmp_path / "pred.npz", "--format", "json")
        assert json.loads(out)[0]["npss"]["paper"] == npss.score(*motion)

    def test_exponential_maps(self, capsys, tmp_path, poses):
        for name, array in zip(("gt", "pred"), poses, strict=True):
            np.save(tmp_path / f"{name}.npy", array)
        _, out, _ = run(capsys, "score", tmp_path / "gt.npy", tmp_path / "pred.npy", "--expmap", "--format", "json")
        (record,) = json.loads(out)
        assert record["npss"]["paper"] == npss.score(*euler(poses))
        assert "representation:euler" in record["signature"]

    @pytest.mark.parametrize("suffix", [".npz", ".h5"])
    def test_samples(self, capsys, tmp_path, poses, suffix):
        arrays = samples(poses, npss.euler_error_curve(*euler(poses)))
        path = tmp_path / f"samples{suffix}"
        if suffix == ".npz":
            np.savez(path, **arrays)
        else:
            write_h5(path, arrays)
        _, out, _ = run(capsys, "score", path, "--format", "json")
        (record,) = json.loads(out)
        assert record["action"] == "walking"
        assert record["npss"]["released"] == npss.score(*euler(poses), convention="released")
        assert record["euler_error"]["1000"] == npss.euler_error(*euler(poses))[1000]
        assert record["stored_curve_difference"] == 0
        stated = npss.parse_signature(record["signature"])
        assert (stated["fps"], stated["frames"], stated["representation"]) == (25, 50, "euler")
        assert "curve is reproduced: largest difference 0.0e+00 rad" in run(capsys, "score", path)[1]

    def test_a_stored_curve_that_is_another(self, capsys, tmp_path, poses):
        np.savez(tmp_path / "samples.npz", **samples(poses, np.ones(50)))
        assert "curve is NOT reproduced" in run(capsys, "score", tmp_path / "samples.npz")[1]

    def test_short_samples_have_fewer_times(self, capsys, tmp_path, poses):
        np.savez(tmp_path / "samples.npz", **samples(poses[:, :, :10]))
        _, out, _ = run(capsys, "score", tmp_path / "samples.npz", "--format", "json")
        assert list(json.loads(out)[0]["euler_error"]) == ["80", "160", "320", "400"]

    def test_without_h5py(self, capsys, tmp_path, monkeypatch):
        monkeypatch.setitem(sys.modules, "h5py", None)
        monkeypatch.delitem(sys.modules, "npss.files._h5", raising=False)
        (tmp_path / "samples.h5").write_bytes(b"")
        status, _, err = run(capsys, "score", tmp_path / "samples.h5")
        assert status == 2
        assert "needs h5py; in the project's folder: pip install '.[h5]'" in err


def broken(tmp_path, poses):
    """Yield arguments of ``npss score`` that cannot be done, with a part of the message."""
    good = np.random.default_rng(0).normal(size=(2, 10, 3))
    np.save(tmp_path / "good.npy", good)
    np.save(tmp_path / "other.npy", good[:1])
    np.save(tmp_path / "nan.npy", np.where(good == good[1, 2, 0], np.nan, good))
    np.save(tmp_path / "one_axis.npy", np.ones(3))
    np.save(tmp_path / "object.npy", np.array([{}, []], dtype=object), allow_pickle=True)
    np.savez(tmp_path / "a.npz", a=good, b=good)
    np.savez(tmp_path / "c.npz", a=good, c=good)
    np.savez(tmp_path / "empty.npz")
    np.savez(tmp_path / "object.npz", a=np.array([{}, []], dtype=object))
    arrays = samples(poses)
    np.savez(tmp_path / "short_curve.npz", **arrays, mean_walking_error=np.ones(3))
    np.savez(tmp_path / "unpaired.npz", **{k: v for k, v in arrays.items() if k != "expmap/preds/walking_1"})
    np.savez(tmp_path / "uneven.npz", **{**arrays, "expmap/gt/walking_1": np.ones((3, 99))})
    np.savez(tmp_path / "columns.npz", **{k: v[:, :3] for k, v in arrays.items()})
    np.savez(tmp_path / "one_axis.npz", **{k: v[0] for k, v in arrays.items()})
    np.savez(tmp_path / "complex.npz", **{**arrays, "expmap/gt/walking_1": arrays["expmap/gt/walking_1"] + 1j})
    np.savez(tmp_path / "nan.npz", **{**arrays, "expmap/preds/walking_1": np.full((50, 99), np.nan)})
    np.savez(tmp_path / "diverged.npz", **{**arrays, "expmap/preds/walking_1": np.full((50, 99), 1e20)})
    np.savez(tmp_path / "poses.npz", a=np.full((50, 99), 1e20))
    np.savez(tmp_path / "twice.npz", **arrays, **{"expmap/gt/walking_01": arrays["expmap/gt/walking_1"]})
    np.savez(tmp_path / "nan_curve.npz", **arrays, mean_walking_error=np.full(50, np.nan))
    np.savez(tmp_path / "samples.npz", **arrays)
    np.savez(tmp_path / "a_nan.npz", a=np.full_like(good, np.nan), b=good)
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "empty.h5", "w") as file:
        file["expmap/gt/walking_0"] = file["expmap/preds/walking_0"] = h5py.Empty("f")
    for suffix in (".npy", ".npz", ".h5"):
        (tmp_path / f"text{suffix}").write_text("not what its name says\n", encoding="utf-8")
        (tmp_path / f"nothing{suffix}").write_text("", encoding="utf-8")
    (tmp_path / "folder.npy").mkdir()
    yield ["good.npy"], "expected .h5, .hdf5 or .npz results, or a folder"
    yield ["good.npy", "good.npy", "good.npy"], "expected GT and PRED, or RESULTS alone, got 3 files"
    yield ["good.npy", "missing.npy"], "missing.npy: No such file"
    yield ["good.npy", "folder.npy"], "folder.npy: expected a file, got a folder"
    yield ["good.npy", "other.npy"], "pred: its shape (1, 10, 3) differs"
    yield ["good.npy", "nan.npy"], "pred: nan at index (1, 2, 0)"
    yield ["one_axis.npy", "one_axis.npy"], "gt: expected shape (N, T, D) or (T, D)"
    yield ["good.npy", "text.csv"], "text.csv: expected a .npy or .npz file"
    for name in ("text.npy", "text.npz", "nothing.npy", "nothing.npz", "object.npy"):
        yield ["good.npy", name], f"{name}: not a readable {name[-4:]} file"
    yield ["good.npy", "object.npz"], "object.npz: no motion in it, an array (N, T, D) or (T, D) of numbers; arrays: a"
    yield ["good.npy", "empty.npz"], "empty.npz: no motion in it, an array (N, T, D) or (T, D) of numbers; arrays: none"
    yield ["a.npz", "c.npz"], "unpaired: b, c; choose one by --key NAME"
    yield ["text.h5"], "text.h5: "
    yield ["nothing.h5"], "nothing.h5: "
    yield ["a.npz"], "a.npz: a: expected CONDITION/gt, CONDITION/pred and meta, or expmap/gt/ACTION_i"
    yield ["short_curve.npz"], "mean_walking_error has shape (3,), expected (50,)"
    yield ["unpaired.npz"], "walking_1 is not in both"
    yield ["uneven.npz"], "the samples of walking differ in shape"
    yield ["columns.npz"], "columns.npz: expmap/gt/walking_0: expected shape (T, 99), got (50, 3)"
    yield ["one_axis.npz"], "one_axis.npz: expmap/gt/walking_0: expected shape (T, 99), got (99,)"
    yield ["complex.npz"], "complex.npz: expmap/gt/walking_1: expected real numbers, got complex"
    yield ["nan.npz"], "nan.npz: expmap/preds/walking_1: nan at index (0, 0)"
    yield ["diverged.npz"], "diverged.npz: walking: prediction: poses: an angle of 2**52 rad or more at index (1, 0, 6)"
    yield ["good.npy", "good.npy", "--expmap"], "ground truth: poses: expected shape (..., 99), got (2, 10, 3)"
    yield (
        ["poses.npz", "poses.npz", "--expmap"],
        "a: ground truth: poses: an angle of 2**52 rad or more at index (0, 6)",
    )
    yield ["twice.npz"], "duplicate sample expmap/gt/walking_01"
    yield ["nan_curve.npz"], "mean_walking_error: nan at index (0,)"
    yield ["empty.h5"], "empty.h5: expmap/gt/walking_0: the data set has no values"
    yield ["samples.npz", "--fps", "30"], "leave out --expmap, --representation, --quaternions and --fps"
    yield ["samples.npz", "--expmap"], "leave out --expmap, --representation, --quaternions and --fps"
    yield (
        ["good.npy", "good.npy", "--expmap", "--representation", "quaternions"],
        "--expmap implies euler",
    )
    yield ["a.npz", "a_nan.npz"], "a: pred: nan at index (0, 0, 0)"
    yield ["good.npy", "a.npz"], "unpaired: a, b, the unnamed array"
    yield (
        ["good.npy", "good.npy", "--edges-ms", "0", "1000"],
        "--fps: expected the frames per second, which times in milliseconds need, got None",
    )
    yield (
        ["good.npy", "good.npy", "--at-ms", "80"],
        "--fps: expected the frames per second, which times in milliseconds need, got None",
    )
    yield ["good.npy", "good.npy", "--fps", "25", "--at-ms", "90"], "nearest: 80 and 120 ms"
    yield ["good.npy", "good.npy", "--fps", "0"], "--fps: expected a positive, finite number, got 0.0"


def test_errors_are_one_line_and_status_2(capsys, tmp_path, poses, monkeypatch):
    pytest.importorskip("h5py")
    cases = list(broken(tmp_path, poses))
    monkeypatch.chdir(tmp_path)
    for arguments, message in cases:
        status, out, err = run(capsys, "score", *arguments)
        assert (status, out) == (2, ""), arguments
        assert err.startswith("npss: error: "), err
        assert message in err
        assert err.count("\n") == 1, err


def test_explain(capsys):
    status, out, _ = run(capsys, "explain", "npss|version:1|convention:released|frames:100")
    assert status == 0
    assert "the square of the real part" in out
    status, _, err = run(capsys, "explain", "released")
    assert status == 2
    assert "SIGNATURE:" in err


def test_demo(capsys):
    status, out, err = run(capsys, "demo")
    assert (status, err) == (0, "")
    for text in ("zero-velocity", "repeat-50", "running-average-2", "NPSS paper", "NPSS released", "NPSS literal"):
        assert text in out
    for name in npss.CONVENTIONS:
        assert f"npss|version:1|convention:{name}|" in out


def test_version_and_help(capsys):
    status, out, _ = run(capsys, "--version")
    assert (status, out) == (
        0,
        f"npss {npss.__version__} (numpy {np.__version__}, Python {platform.python_version()})\n",
    )
    status, out, _ = run(capsys, "score", "--help")
    assert status == 0
    assert "two .npy files" in out
    assert run(capsys)[0] == 2


def test_a_closed_pipe_is_no_error(monkeypatch, capfd):
    def closed(signature):
        raise BrokenPipeError

    redirected = []
    monkeypatch.setattr("npss.commands._explain.explain", closed)
    monkeypatch.setattr(
        "npss.console._run.os", SimpleNamespace(**vars(os) | {"dup2": lambda *ends: redirected.append(ends)})
    )
    assert main(["explain", "npss|version:1"]) == 0
    assert len(redirected) == 1


def test_as_a_module_in_this_process(monkeypatch, capsys):
    monkeypatch.setattr(sys, "argv", ["npss", "explain", "mse|version:1"])
    with pytest.raises(SystemExit) as end:
        runpy.run_module("npss", run_name="__main__")
    assert end.value.code == 0
    assert "MSE" in capsys.readouterr().out


def test_as_a_module_and_in_a_pipe_that_closes(files):
    command = [sys.executable, "-m", "npss", "score", *map(str, files)]
    whole = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
    assert "convention:paper" in whole.stdout
    closed = subprocess.run(
        ["bash", "-c", '"$@" | true; echo "${PIPESTATUS[0]}"', "-", *command],
        capture_output=True,
        encoding="utf-8",
        check=True,
    )
    assert closed.stderr == ""
    assert closed.stdout.strip() == "0"


@pytest.mark.parametrize("program", ["npss", "npss-baselines"])
def test_control_c_is_one_line(monkeypatch, capsys, program):
    """In every command, since all are run by the same function."""
    from npss.commands import _explain as explain
    from npss_baselines.__main__ import main as baselines_main
    from npss_baselines.commands import evaluate

    def interrupted(options):
        raise KeyboardInterrupt

    for module in (explain, evaluate):
        monkeypatch.setattr(module, "run", interrupted)
    status = main(["explain", "npss"]) if program == "npss" else baselines_main(["evaluate"])
    assert status == 130
    assert capsys.readouterr() == ("", f"{program}: interrupted\n")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            ["score", "--edge-m", "0", "1000"],
            "npss score: error: unrecognized arguments: --edge-m; did you mean --edges-ms?",
        ),
        (["demo", "--fast"], "npss demo: error: unrecognized arguments: --fast (see npss demo --help)"),
        (["demo", "x"], "npss demo: error: unrecognized arguments: x (see"),
        (["scroe"], "npss: error: argument COMMAND: invalid choice: 'scroe'"),
        ([], "npss: error: the following arguments are required: COMMAND (see npss --help)"),
    ],
)
def test_a_misspelt_option_gets_a_suggestion(capsys, arguments, message):
    status, out, err = run(capsys, *arguments)
    assert (status, out) == (2, "")
    assert err.startswith(message), err
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("error", "message"),
    [
        (FileNotFoundError(2, "No such file or directory", "gt.npy"), "gt.npy: No such file or"),
        (OSError(28, "cannot write page.html: No space left on device"), "cannot write page.html: No space left on"),
        (
            ModuleNotFoundError("No module named 'scipy'", name="scipy.stats"),
            "this needs scipy, which is not",
        ),
        (ModuleNotFoundError("No module named 'torch'", name="torch"), "this needs torch, which is not"),
        (ImportError("two\nlines"), "two lines"),
    ],
)
def test_error_messages_are_one_line(monkeypatch, capsys, error, message):
    from npss.commands import _explain as explain

    def broken(options):
        raise error

    monkeypatch.setattr(explain, "run", broken)
    status, _, err = run(capsys, "explain", "npss")
    assert status == 2
    assert err.startswith(f"npss: error: {message}"), err
    assert "Errno" not in err
    assert err.count("\n") == 1
    if isinstance(error, ModuleNotFoundError):
        hint = install_hint("study") if "scipy" in message else install_hint("all", baselines=True)
        assert err.endswith(f"; {hint}\n")


def test_a_system_error_names_the_operation(tmp_path):
    with (
        pytest.raises(PermissionError, match=r"votes\.csv: reading the votes: Permission denied$"),
        doing("reading the votes"),
    ):
        raise PermissionError(13, "Permission denied", "votes.csv")
    with pytest.raises(OSError, match=r"reading the votes: nothing there$"), doing("reading the votes"):
        raise OSError("nothing there")
