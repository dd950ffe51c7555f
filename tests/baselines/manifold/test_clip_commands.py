"""Commands on clips of one's own: a file of each of four programs goes through each, and opens again."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from dialects import walking
from npss.skeleton import Skeleton
from npss_baselines.__main__ import main
from npss_baselines.data import bvh, bvh_writer, mapping
from npss_baselines.data.motion import NAMES
from npss_baselines.manifold import damaged, example, repair
from npss_baselines.manifold.clips.repair import _own_names
from npss_baselines.manifold.model.gaussian import fit_gaussian
from npss_baselines.manifold.motion.scaling import fit_scaling
from npss_baselines.manifold.restorers import file
from npss_baselines.manifold.restorers.conditional import Conditional
from npss_baselines.manifold.restorers.interpolation import Interpolation

#: Four programs, and frame rates of their files.
PROGRAMS = {"mixamo": 30.0, "lafan1": 30.0, "xsens": 60.0, "rokoko": 100.0}
#: A file has six digits after the point: half a unit of the last in degrees, and the same of three angles in a matrix.
PRECISION = 3 * np.radians(0.5e-6)


@pytest.fixture(scope="module", params=PROGRAMS)
def clip(request, tmp_path_factory):
    """Return the file of a generated walk."""
    path = tmp_path_factory.mktemp("clips") / f"{request.param}.bvh"
    fps = PROGRAMS[request.param]
    bvh_writer.write(path, walking(request.param, round(1.5 * fps), fps=fps))
    return path


@pytest.fixture(scope="module")
def restorer(motions):
    scaling = fit_scaling(motions.windows, motions.mask, "kind")
    return Conditional(fit_gaussian(motions.windows, motions.mask, scaling))


@pytest.fixture
def _restorer(monkeypatch, restorer):
    """Let the package have a restorer."""
    monkeypatch.setattr(file, "default", lambda: restorer)


def call(*words):
    return main(["manifold", *map(str, words)])


def opened(path, original):
    """Open a file that was written, and compare what must not change."""
    before, after = bvh.read(original), bvh.read(path)
    assert after.skeleton.names == before.skeleton.names
    assert after.skeleton.parents == before.skeleton.parents
    np.testing.assert_allclose(after.skeleton.offsets, before.skeleton.offsets, rtol=0, atol=1e-6)
    assert after.channels == before.channels
    assert after.fps == before.fps
    parents = [max(parent, 0) for parent in after.skeleton.parents]
    places, lengths = after.positions(), np.linalg.norm(before.skeleton.offsets, axis=-1)
    bones = np.linalg.norm(places - places[:, parents], axis=-1)
    moving = before.skeleton.parents.index(-1)
    np.testing.assert_allclose(
        np.delete(bones, moving, 1), np.tile(np.delete(lengths, moving), (len(bones), 1)), atol=1e-5
    )
    return before, after


@pytest.mark.usefixtures("_restorer")
def test_repair_what_is_given(clip, tmp_path, capsys):
    fixed, page = tmp_path / "fixed.bvh", tmp_path / "fixed.html"
    options = ["--missing", "RightForeArm", "--from", "0.5s", "--to", "0.8s", "--truth", clip]
    assert call("repair", clip, *options, "-o", fixed, "-o", page) == 0
    before, after = opened(fixed, clip)
    start, end = round(0.5 * before.fps), round(0.8 * before.fps)
    outside = np.r_[:start, end : len(before.rotations)]
    np.testing.assert_allclose(after.rotations[outside], before.rotations[outside], rtol=0, atol=PRECISION)
    np.testing.assert_allclose(after.translations, before.translations, rtol=0, atol=1e-6)
    own = mapping.guess(before.skeleton).joints["RightArm"]  # turns, so that the forearm comes to its place
    changed = np.abs(after.rotations - before.rotations).max(axis=(0, 2, 3)) > 1e-4
    arm = mapping.guess(before.skeleton).joints["RightArm"]
    assert changed[before.skeleton.names.index(arm)]
    assert all("Right" in name or "r" in name.lower() for name in np.array(before.skeleton.names)[changed])
    printed, said = capsys.readouterr()
    assert f"missing: frames {start} to {end - 1} (0.50 to 0.80 s): " in printed
    assert "restored by the restorer of the package" in printed
    error, cm = map(float, re.search(r"are (\S+) body heights \((\S+) cm .*\) from the truth on av", printed).groups())
    assert error < 0.1
    assert cm == pytest.approx(170 * error, abs=0.1)
    assert "; before, " not in printed  # what was given may have been right
    assert re.search(
        r"so joints are \d\.\d cm from the places that were made for them on average, \d+\.\d at most", printed
    )
    assert re.search(rf"turn otherwise than before \(by up to so many degrees\): .*{re.escape(own)} \(\d+\)", printed)
    assert said.split() == [str(fixed), str(page)]
    text = page.read_text(encoding="utf-8")
    assert "<li>restored by gaussian-12-" in text
    shown = json.loads(re.search(r'id="data">(.*?)</script>', text)[1])
    assert [(panel["label"], panel["truth"]) for panel in shown["panels"]] == [
        *[("truth", True), ("before", False), ("after", False)]
    ]
    assert shown["figure"]["fps"] == 30
    assert shown["figure"]["rate"] == before.fps
    np.testing.assert_allclose(shown["spans"], [[0.5, 0.8]], atol=0.5 / before.fps)


@pytest.mark.usefixtures("_restorer")
def test_repair_what_is_found(clip, tmp_path, capsys):
    motion = bvh.read(clip)
    knee = motion.skeleton.names.index(mapping.guess(motion.skeleton).joints["LeftLeg"])
    start = round(0.6 * motion.fps)
    motion.rotations[start : start + 2, knee] = (
        motion.rotations[start : start + 2, knee] @ Rotation.from_rotvec([0, 0, 1]).as_matrix()
    )
    bvh_writer.write(damaged := tmp_path / "damaged.bvh", motion)
    lines = damaged.read_text(encoding="utf-8").splitlines()
    frames = lines.index("MOTION") + 3
    row = lines[frames + 5].split()
    lines[frames + 5] = " ".join([*row[:-3], "nan", "nan", "nan"])
    damaged.write_text("\n".join(lines) + "\n", encoding="utf-8")
    assert call("repair", damaged, "-o", tmp_path / "fixed.bvh", "--truth", clip) == 0
    before, after = opened(tmp_path / "fixed.bvh", clip)
    printed = capsys.readouterr().out
    assert f"frames {start} to {start + 1} " in printed
    assert f"{motion.skeleton.names[knee]}: jump" in printed
    assert "frames 5 to 5 " in printed
    assert ": not a number" in printed
    np.testing.assert_allclose(after.rotations[:, knee], before.rotations[:, knee], rtol=0, atol=0.3)
    assert call("repair", clip, "-o", tmp_path / "same.bvh") == 0
    assert "no damage found: the clip stays as it is" in capsys.readouterr().out
    before, after = opened(tmp_path / "same.bvh", clip)
    np.testing.assert_allclose(after.rotations, before.rotations, rtol=0, atol=PRECISION)


@pytest.mark.usefixtures("_restorer")
def test_fill(clip, tmp_path):
    assert call("fill", clip, "--joint", "RightHand", "-o", tmp_path / "filled.bvh", "-o", tmp_path / "page.html") == 0
    before, after = opened(tmp_path / "filled.bvh", clip)
    np.testing.assert_allclose(after.translations, before.translations, rtol=0, atol=1e-6)
    elbow = before.skeleton.names.index(mapping.guess(before.skeleton).joints["RightForeArm"])
    np.testing.assert_allclose(after.rotations[:, elbow - 1], before.rotations[:, elbow - 1], rtol=0, atol=PRECISION)


@pytest.mark.usefixtures("_restorer")
def test_inbetween(clip, tmp_path, capsys):
    every = round(PROGRAMS[clip.stem] / 6)
    assert call("inbetween", clip, "--every", every, "-o", tmp_path / "smooth.bvh") == 0
    before, after = opened(tmp_path / "smooth.bvh", clip)
    np.testing.assert_allclose(after.rotations[::every], before.rotations[::every], rtol=0, atol=PRECISION)
    np.testing.assert_allclose(after.translations[::every], before.translations[::every], rtol=0, atol=1e-6)
    n_frames, n_keys = len(before.rotations), len(range(0, len(before.rotations), every))
    assert f"missing: {n_frames - n_keys} frames around {n_keys} keys, at most {every - 1} in a row" in (
        capsys.readouterr().out
    )
    assert call("inbetween", clip, "--keys", 0, every, 2 * every) == 0
    assert call("inbetween", clip) == 2
    assert "no frame is held" in capsys.readouterr().err


def test_interpolate(clip, run, tmp_path, capsys):
    other = tmp_path / "other.bvh"
    bvh_writer.write(other, walking("bandai", 45, seed=1))
    half, page = tmp_path / "half.bvh", tmp_path / "half.html"
    assert call("interpolate", clip, other, "--share", ".5", "-o", half, "-o", page) == 0
    opened(half, clip)
    assert re.search(
        r"interpolated with 0.5 of .* both are stretched to \d+ frames \(1\.[45]\d s\)", capsys.readouterr().out
    )
    shown = json.loads(re.search(r'id="data">(.*?)</script>', page.read_text(encoding="utf-8"))[1])
    assert [panel["label"] for panel in shown["panels"]] == [f"0: {clip.stem}", "between: 0.5", "1: other"]
    assert call("interpolate", clip, other, "--manifold", run, "-o", half) == 0
    opened(half, clip)
    assert call("interpolate", clip, other, "--share", "2") == 2
    assert "--share" in capsys.readouterr().err


def test_nearest(clip, run, tmp_path, capsys):
    folder = tmp_path / "clips" / "deeper"
    folder.mkdir(parents=True)
    for seed in (0, 3):
        bvh_writer.write(folder / f"{seed}.BVH", walking("bandai", 45, seed=seed))
    assert call("nearest", clip, folder.parent, "-o", tmp_path / "near.html") == 0
    printed = capsys.readouterr().out
    assert "of 2 clips, by extremes of positions and velocities; smaller is more alike" in printed
    assert printed.index("deeper/0.BVH") < printed.index("deeper/3.BVH")
    assert call("nearest", clip, folder.parent, "-n", "1", "--manifold", run) == 0
    printed = capsys.readouterr().out
    assert "by distance G of the manifold; " in printed
    assert printed.count(".BVH") == 1
    assert call("nearest", clip, tmp_path / "clips", "-o", tmp_path / "near.bvh") == 2
    assert "near.bvh: expected a name that ends in .html, .svg, .pdf, .png" in capsys.readouterr().err
    (folder / "bad.bvh").write_text("HIERARCHY\n", encoding="utf-8")
    assert call("nearest", clip, folder.parent) == 0
    printed, said = capsys.readouterr()
    assert "of 2 clips" in printed
    assert re.search(r"left out: deeper/bad.bvh: .*the file ends at line 1", said)
    (tmp_path / "empty").mkdir()
    assert call("nearest", clip, tmp_path / "empty") == 2
    assert "empty: expected a folder with other BVH files" in capsys.readouterr().err


def test_project(clip, run, tmp_path, capsys):
    assert call("project", clip, run, "-o", tmp_path / "projected.bvh", "-o", tmp_path / "projected.html") == 0
    opened(tmp_path / "projected.bvh", clip)
    assert "projected by manifold-" in capsys.readouterr().out


def test_sample(clip, run, tmp_path, capsys):
    sampled = tmp_path / "sample.bvh"
    assert call("sample", run, "--like", clip, "--frames", 16, "-o", sampled, "-o", tmp_path / "sample.html") == 0
    assert "sampled by local of manifold-" in capsys.readouterr().out
    motion = bvh.read(sampled)
    assert len(motion.rotations) == 16
    assert motion.skeleton.names[: len(NAMES)] != ()
    assert mapping.guess(motion.skeleton).joints["Head"] == "Head"
    assert call("sample", run, "--like", clip, "--frames", 44) == 2
    assert "--like: the clips give 1 window of 44 frames" in capsys.readouterr().err
    with pytest.raises(SystemExit):  # the paper's prior gives no plausible motion
        call("sample", run)


def test_pictures(run, tmp_path):
    first, second, picture = (tmp_path / name for name in ("first.bvh", "second.bvh", "picture.svg"))
    bvh_writer.write(first, walking("lafan1", 40))
    bvh_writer.write(second, walking("lafan1", 50, seed=1))
    for command in (
        ("repair", first, "--missing", "Head", "--to", 9, "--truth", first),
        ("interpolate", first, second),
        ("nearest", first, tmp_path),
        ("sample", run, "--like", first, "--frames", 16),
    ):
        assert call(*command, "-o", picture) == 0
        assert picture.stat().st_size > 5000
        picture.unlink()


def test_mapping(clip, tmp_path, capsys):
    path = tmp_path / "mapping.json"
    assert call("mapping", clip, "-o", path) == 0
    printed = capsys.readouterr().out
    own = mapping.read(path)
    assert json.loads(printed) == own.joints
    options = ["--missing", own.joints["RightHand"], "--from", 0, "--to", 5, "--mapping", path]
    assert call("repair", clip, *options) == 0
    path.write_text(json.dumps({**own.joints, "Head": "Tail"}), encoding="utf-8")
    assert call("repair", clip, *options) == 2
    assert "Head: the skeleton has no joint 'Tail'" in capsys.readouterr().err


def test_a_mapping_to_fill_in(tmp_path, capsys):
    """Where names say nothing, there is something to edit."""
    rest = walking("lafan1", 20)
    names = [f"Bone{number:03}" for number in range(len(rest.skeleton.names))]
    skeleton = Skeleton(names, rest.skeleton.parents, rest.skeleton.offsets)
    bvh_writer.write(clip := tmp_path / "bones.bvh", replace(rest, skeleton=skeleton))
    assert call("mapping", clip) == 2
    path = tmp_path / "bones.json"
    assert call("mapping", clip, "-o", path) == 0
    printed, said = capsys.readouterr()
    assert re.search(r"^  Bone000\n    Bone001$", printed, re.MULTILINE)
    assert "bones.json: fill in the blanks" in said
    blank = json.loads(path.read_text(encoding="utf-8"))
    assert list(blank) == list(NAMES)
    assert call("repair", clip, "--mapping", path) == 2
    assert "Hips: blank; fill in the name of a joint" in capsys.readouterr().err
    own = mapping.guess(rest.skeleton).joints
    filled = {name: own[name] and names[rest.skeleton.names.index(own[name])] for name in blank}
    path.write_text(json.dumps(filled), encoding="utf-8")
    assert call("repair", clip, "--mapping", path) == 0


@pytest.fixture
def walk(tmp_path, monkeypatch):
    monkeypatch.setattr(file, "default", lambda: Interpolation("hermite"))  # whether or not the package has one
    bvh_writer.write(path := tmp_path / "walk.bvh", walking("lafan1", 40))
    return path


def test_frames_that_were_deleted_are_inserted(walk, tmp_path, capsys):
    motion = walking("lafan1", 90)
    kept = np.r_[:30, 45:90]
    bvh_writer.write(
        cut := tmp_path / "cut.bvh",
        replace(motion, rotations=motion.rotations[kept], translations=motion.translations[kept]),
    )
    assert call("repair", cut) == 0
    printed, said = capsys.readouterr()
    assert "no damage found" in printed
    assert "the figure leaps to frame 30 (1.00 s) and stays; if N frames were deleted there, give --insert N" in printed
    assert "nothing is written; give -o FILE" in said
    assert call("repair", cut, "--insert", ".5s", "--at", 30, "-o", tmp_path / "whole.bvh") == 0
    printed, said = capsys.readouterr()
    assert "missing: frames 30 to 44 (1.00 to 1.50 s): " in printed
    assert "nothing is written" not in said
    whole = bvh.read(tmp_path / "whole.bvh")
    assert len(whole.rotations) == 90
    np.testing.assert_allclose(whole.rotations[np.r_[:30, 45:90]], motion.rotations[kept], rtol=0, atol=PRECISION)


def test_frames_are_not_taken_for_seconds(walk, capsys):
    assert call("repair", walk, "--missing", "Head", "--from", 1, "--to", 2) == 0
    assert "--from 1 --to 2: 1 frame; write 1s and 2s for seconds" in capsys.readouterr().err
    for times in (("1", "9"), (".1s", ".12s")):
        assert call("repair", walk, "--missing", "Head", "--from", times[0], "--to", times[1]) == 0
        assert "for seconds" not in capsys.readouterr().err


class TestRefusals:
    @pytest.mark.parametrize(
        ("options", "message"),
        [
            (["--missing", "Tail"], "--missing: 'Tail' is not one of the joints Hips"),
            (
                ["--missing", "Head", "--from", "2x"],
                "--from: expected seconds such as 2.5s, or a frame such as 75, got '2x'",
            ),
            (
                ["--missing", "Head", "--from", "5", "--to", "4"],
                "expected frames from 0 to 40, the first before the last",
            ),
            (["--missing", "Head", "--to", "2s"], "got 0 to 60"),
            (["--missing", "right_hand"], "; did you mean RightHand?"),
            (["--insert", "9"], "--insert: expected --insert and --at together"),
            (["--insert", "9", "--at", "0"], "--at: expected a frame from 1 to 39, got 0"),
            (["--insert", "9", "--at", "5", "--missing", "Head"], "--insert: expected no --missing, --from or --to"),
            (["--missing", "Head", "--shortest", "1s"], "--only, --shortest: choose from what is found"),
            (["--shortest", "0"], "--shortest: "),
            (["--only", "Tail"], "--only: 'Tail' is not one of the joints Hips"),
            (["--from", "5"], "--missing JOINT: needed with --from and --to"),
            (["-o", "fixed.fbx"], "fixed.fbx: expected a name that ends in .bvh, .html, .svg, .pdf, .png"),
            (["-o", "walk.bvh"], "walk.bvh: would overwrite an input"),
            (["--restorer", "none.npz"], "none.npz"),
            (["--mapping", "a", "b"], "--mapping: expected one file"),
            (["--missing", "Head"], "--missing: Head: missing in all frames, so there is nothing to interpolate"),
        ],
    )
    def test_repair(self, walk, options, message, tmp_path, monkeypatch, capsys):
        monkeypatch.chdir(tmp_path)
        assert call("repair", walk, *options) == 2
        assert message in capsys.readouterr().err

    def test_truth_of_another_length(self, walk, tmp_path, capsys):
        bvh_writer.write(other := tmp_path / "other.bvh", walking("lafan1", 30))
        options = ["--missing", "Head", "--to", "5", "--truth"]
        assert call("repair", walk, *options, other) == 2
        assert "--truth: 30 frames, but the clip has 40" in capsys.readouterr().err
        bvh_writer.write(other, walking("xsens", 40))
        assert call("repair", walk, *options, other) == 2
        assert "--truth: expected the joints of the clip" in capsys.readouterr().err

    def test_values_that_are_no_numbers_are_for_repair_alone(self, walk, tmp_path, capsys):
        text = walk.read_text(encoding="utf-8").splitlines()
        text[-1] = text[-1].replace(text[-1].split()[7], "nan", 1)
        walk.write_text("\n".join(text) + "\n", encoding="utf-8")
        assert call("interpolate", walk, walk) == 2
        assert "'nan' is not a number" in capsys.readouterr().err
        assert call("repair", walk) == 0


def test_the_example_is_repaired(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert call("example", "-o", "walk.bvh") == 0
    assert call("example", "--damaged", "-o", "broken.bvh") == 0
    walk, broken = bvh.read("walk.bvh"), bvh.read("broken.bvh")
    changed = np.any(walk.rotations != broken.rotations, axis=(2, 3))
    assert {walk.skeleton.names[j] for j in np.flatnonzero(changed.any(axis=0))} == {"Neck", "LeftLeg", "LeftFoot"}
    assert np.flatnonzero(changed.any(axis=1)).tolist() == [*range(61, 105), *range(130, 133)]
    capsys.readouterr()
    assert call("repair", "broken.bvh", "--truth", "walk.bvh", "-o", "fixed.bvh") == 0
    printed = capsys.readouterr().out
    assert "frames 61 to 104 (2.03 to 3.50 s): LeftLeg, LeftFoot: held" in printed
    assert "frames 130 to 132 (4.33 to 4.43 s): Neck: jump" in printed
    after, before = map(float, re.search(r"are ([\d.]+) body heights .* before, ([\d.]+)", printed).groups())
    assert after < before
    fixed = bvh.read("fixed.bvh")
    same = ~changed.any(axis=1)
    np.testing.assert_allclose(fixed.rotations[same], broken.rotations[same], rtol=0, atol=PRECISION)


def test_a_short_walk_is_not_damaged():
    with pytest.raises(ValueError, match=r"^walk: expected more than 133 frames, got 90"):
        damaged(example(90))


def test_what_is_found_but_not_chosen_is_said(walk, tmp_path, capsys):
    """Damage that --only leaves out is named, and the way out of it is no leap that stays."""
    assert call("example", "--damaged", "-o", tmp_path / "broken.bvh") == 0
    capsys.readouterr()
    assert call("repair", tmp_path / "broken.bvh", "--only", "RightLeg") == 0
    printed = capsys.readouterr().out
    assert "found, but not chosen: LeftLeg, LeftFoot, Neck" in printed
    assert "nothing to restore: the clip stays as it is" in printed
    assert "the figure leaps" not in printed


def test_what_cannot_be_read_is_left_out(walk, tmp_path, capsys):
    folder = tmp_path / "folder"
    (folder / "folder.bvh").mkdir(parents=True)
    (folder / "bad.bvh").write_text("HIERARCHY", encoding="utf-8")
    assert call("nearest", walk, folder) == 2
    printed = capsys.readouterr().err
    assert "left out: bad.bvh: the file ends at line 1" in printed
    assert "none of its BVH files can be read" in printed


def test_the_name_of_the_file_goes_first():
    """LaFAN1's Spine1 is not the common one: a name that was printed can be given, and none stands for two joints."""
    joints = mapping.JointMapping({name: name for name in NAMES} | {"Spine1": "Spine2"})
    assert _own_names("only", ["Spine1"], joints, ["Spine1", "Spine2"]) == ["Spine1"]
    assert _own_names("missing", ["Spine2"], joints) == ["Spine2"]
    walk = walking("lafan1", 5)
    twisted = mapping.JointMapping({**mapping.guess(walk.skeleton).joints, "Spine1": "Spine2"})
    with pytest.raises(ValueError, match=r"missing: 'Spine1' is not restored; .* is the file's 'Spine2'"):
        repair(walk, missing=["Spine1"], mapping=twisted)
