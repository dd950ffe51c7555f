"""``npss-baselines lafan1`` on generated files of LaFAN1's skeleton, against definitions without npss."""

import json

import numpy as np
import pytest

import lafan1 as oracle
import npss
from npss.inbetweening import l2p
from npss_baselines.__main__ import main

pytestmark = pytest.mark.slow

TRAIN = {"walk1_subject1": (1, 96), "run2_subject4": (2, 51)}
TEST = {"walk1_subject5": (3, 106), "jump1_subject5": (4, 66)}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    root = tmp_path_factory.mktemp("lafan1")
    for name, (seed, frames) in (TRAIN | TEST).items():
        oracle.write_bvh(root / f"{name}.bvh", *oracle.clip(seed, frames))
    (root / "readme_subject5.txt").touch()
    return root


@pytest.fixture(scope="module")
def expected():
    """The rows by baseline and length, and the statistics."""

    def cut(clips, length, step):
        motion = ((oracle.local_of(angles), root) for angles, root in (oracle.clip(*what) for what in clips))
        return [window for local, root in motion for window in oracle.windows_of(local, root, length, step)]

    stats = oracle.statistics(cut(TRAIN.values(), 50, 20))
    tested = cut(TEST.values(), 65, 40)
    baselines = {"zero-velocity": oracle.zero_velocity, "interpolation": oracle.interpolation}
    lengths = oracle.LENGTHS
    return {(name, n): oracle.row(tested, f, n, *stats) for name, f in baselines.items() for n in lengths}, stats


def run(capsys, *arguments):
    try:
        status = main(["lafan1", *map(str, arguments)])
    except SystemExit as end:
        status = end.code
    captured = capsys.readouterr()
    return status, captured.out, captured.err


def test_rows_and_statistics(capsys, tmp_path, folder, expected):
    path = tmp_path / "stats.npz"
    status, out, err = run(capsys, "--bvh", folder, "--stats", path, "--format", "json", "--sequences")
    assert (status, err) == (0, "")
    rows, (mean, std) = expected
    records = json.loads(out)
    found = {(record["model"], record["action"]): record for record in records}
    assert len(found) == 8
    for (name, n), row in rows.items():
        record = found[name, f"in-betweening, {n} frames"]
        numbers = record["metrics"]["L2Q"], record["metrics"]["L2P"], record["npss"]["released"]
        np.testing.assert_allclose(numbers, row, rtol=1e-9)
        assert record["sequences"]["groups"] == ["jump1_subject5", "walk1_subject5", "walk1_subject5"]
        assert record["verification"]["findings"][0] == "3 windows; lafan1 has 2232"
        assert npss.parse_signature(record["signatures"]["L2P"])["verified"] == "no"
    with np.load(path) as stats:
        np.testing.assert_allclose(stats["mean"].ravel(), mean, atol=1e-9)
        np.testing.assert_allclose(stats["std"].ravel(), std, rtol=1e-9)
    gt = np.zeros((1, 5, 22, 3))
    assert l2p(gt, gt + 1, stats=path) == pytest.approx(np.sqrt((1 / std**2).sum()))


def test_published_rows_stand_beside_the_benchmark_only(capsys, monkeypatch, folder):
    status, out, _ = run(capsys, "--bvh", folder)
    assert status == 0
    assert out.startswith("lafan1: 3 test windows of 2 files, statistics of 2\n\nmodel ")
    assert "(published)" not in out
    assert "Published rows are left out, since this is another ground truth:\n- 3 windows; lafan1 has 2232" in out
    from npss.inbetweening import _measure
    from npss.protocol import Verification, _claims

    for module in (_measure, _claims):
        monkeypatch.setattr(module, "verify", lambda *_, **__: Verification(protocol="lafan1"))
    _, out, _ = run(capsys, "--bvh", folder, "--format", "markdown")
    rows = [line for line in out.splitlines() if line.startswith("| ")]
    assert [row.split("|")[1].strip().replace("\\", "") for row in rows[2:]] == [
        "zero-velocity",
        "interpolation",
        "zero-velocity (published)",
        "interpolation (published)",
        "Delta-interpolator (published)",
        "two-stage transformer (published)",
        "context transformer (published)",
    ]
    assert "left out" not in out


def test_other_files_and_windows(capsys, tmp_path):
    """Every second frame of 60, other lengths and axis; the same numbers as of the files with these frames alone."""
    for name, (seed, frames) in {"a": (5, 120), "b": (6, 140)}.items():
        angles, root = oracle.clip(seed, frames)
        oracle.write_bvh(tmp_path / f"{name}.bvh", angles, root, fps=60)
        oracle.write_bvh(tmp_path / f"{name}30.bvh", angles[::2], root[::2], fps=30)
    windows = ["--facing", "y", "--past", "4", "--future", "1", "--transitions", "10", "20"]
    windows += ["--train-windows", "25", "5", "--test-windows", "30", "10", "--name", "mine", "--format", "json"]
    twice = []
    for names in (("a", "b"), ("a30", "b30")):
        chosen = ["--train", f"{names[0]}.bvh", "--test", f"{names[1]}.bvh", "--fps", "30"]
        status, out, err = run(capsys, "--bvh", tmp_path, *chosen, *windows)
        assert (status, err) == (0, "")
        twice.append(json.loads(out))
    assert twice[0] == twice[1]
    for record in twice[0]:
        stated = npss.parse_signature(record["signatures"]["L2Q"])
        assert (stated["protocol"], stated["fps"]) == ("mine", 30)
        assert "verified" not in stated
    assert [record["action"][-9:] for record in twice[0]] == ["10 frames"] * 2 + ["20 frames"] * 2


def test_files_of_other_bones_are_named(capsys, tmp_path, folder):
    for path in folder.glob("*.bvh"):
        (tmp_path / path.name).write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
    offsets = oracle.OFFSETS.copy()
    offsets[0] += 9  # the root's does not count
    oracle.write_bvh(tmp_path / "run2_subject4.bvh", *oracle.clip(2, 51), offsets=offsets)
    assert run(capsys, "--bvh", tmp_path)[1] == run(capsys, "--bvh", folder)[1]
    oracle.write_bvh(tmp_path / "walk1_subject5.bvh", *oracle.clip(3, 106), offsets=1.1 * offsets)
    _, out, _ = run(capsys, "--bvh", tmp_path)
    first = tmp_path / "run2_subject4.bvh"
    assert f"Bones of {tmp_path / 'walk1_subject5.bvh'} differ; all have those of {first}." in out


def renamed(j, name):
    return [name if i == j else other for i, other in enumerate(oracle.NAMES)]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (["--bvh", "nowhere"], "--bvh nowhere: expected a folder"),
        (["--past", "5"], "--past: not the benchmark's; give --name NAME, a name of your own"),
        (["--test-windows", "65", "20"], "--test-windows: not the benchmark's; give --name NAME"),
        (["--name", "mine"], "--train: expected patterns of files, which --name needs"),
        (["--name", "mine", "--train", "x*"], "no files to train: x*"),
        (["--name", "mine", "--train", "walk1*.bvh", "--test", "*.bvh"], "is also a training file"),
        (
            ["--name", "lafan1", "--train", "*t1.bvh", "--test", "j*.bvh"],
            "'lafan1' is the benchmark's, with other values",
        ),
        (["--name", "m", "--train", "*t1.bvh", "--test", "j*.bvh", "--fps", "20"], "30 frames per second, expected 20"),
    ],
)
def test_errors_are_one_line(capsys, folder, options, message):
    status, out, err = run(capsys, *(options if "--bvh" in options else ["--bvh", folder, *options]))
    assert (status, out) == (2, "")
    assert err.count("\n") == 1
    assert message in err


def test_other_skeletons_are_refused(capsys, tmp_path, folder):
    for path in folder.glob("*.bvh"):
        (tmp_path / path.name).write_text(path.read_text(encoding="utf-8"), encoding="utf-8")
    oracle.write_bvh(tmp_path / "jump1_subject5.bvh", *oracle.clip(4, 66), names=renamed(3, "Foot"))
    assert "names Foot, not LeftFoot, at joint 3" in run(capsys, "--bvh", tmp_path)[2]
    angles, root = oracle.clip(4, 66)
    fewer = {"names": oracle.NAMES[:-1], "parents": oracle.PARENTS[:-1], "offsets": oracle.OFFSETS[:-1]}
    oracle.write_bvh(tmp_path / "jump1_subject5.bvh", angles[:, :-1], root, **fewer)
    assert "names of 21 joints, not 22" in run(capsys, "--bvh", tmp_path)[2]
    for path in tmp_path.glob("*.bvh"):
        oracle.write_bvh(path, angles[:, :-1], root, **fewer)
    assert "lafan1 has 22 joints, got 21" in run(capsys, "--bvh", tmp_path)[2]
