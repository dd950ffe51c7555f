"""``npss-baselines sensitivity``: distortions of motion, and how the metrics respond."""

import json
import re
import sys
from pathlib import Path

import numpy as np
import pytest

import npss
from npss.predictors import PREDICTORS
from npss_baselines.__main__ import main
from npss_baselines.commands import evaluate
from npss_baselines.data import SOURCES
from npss_baselines.data.h36m_source import Human36M
from npss_baselines.data.synthetic import Synthetic, synthetic_task
from npss_baselines.evaluation import sensitivity

PAGE = Path(__file__).parents[3] / "docs" / "pictures.md"
FRAMES = np.arange(100)
METRICS = ("euler_error", *npss.CONVENTIONS)


def synthetic_motion(n=64):
    return sensitivity.motion_of(Synthetic(n), Path())


def value(record, metric):
    return record["euler_error"] if metric == "euler_error" else record["npss"][metric]


def curve(records, distortion, metric):
    """Return the strengths and values of a distortion."""
    chosen = [record for record in records if record["distortion"] == distortion]
    return {record["strength"]: value(record, metric) for record in chosen}


@pytest.fixture(scope="module")
def gait_records():
    return sensitivity.study(synthetic_motion())


@pytest.fixture(scope="module")
def small():
    return synthetic_motion(3)


@pytest.fixture(scope="module")
def found(small):
    return {(name, strength): pred for name, strength, _, pred in sensitivity.distorted(small)}


@pytest.fixture(scope="module")
def gt(small):
    return np.stack([clip[50:150] for clip in small.clips])


class TestDistortions:
    """Each distortion, computed in another way."""

    @staticmethod
    def interpolated(clip, at):
        return np.stack([np.interp(at, np.arange(len(clip)), column) for column in clip.T], axis=1)

    def test_names_and_units(self, small):
        units = {name: unit for name, _, unit, _ in sensitivity.distorted(small)}
        assert units == {
            "zero-velocity": "",
            "tempo": "times as fast",
            "skipped frames": "share of frames",
            "phase shift": "strides",
            "noise": "standard deviation (rad)",
            "offset": "rad",
        }

    @pytest.mark.parametrize("tempo", sensitivity.TEMPI)
    def test_tempo(self, small, found, tempo):
        for clip, pred in zip(small.clips, found["tempo", tempo], strict=True):
            np.testing.assert_allclose(
                pred, self.interpolated(clip, 49 + tempo * np.arange(1, 101)), rtol=0, atol=1e-12
            )

    @pytest.mark.parametrize("k", sensitivity.SKIP_EVERY)
    def test_skipped_frames(self, small, found, k):
        for clip, pred in zip(small.clips, found["skipped frames", 1 / k], strict=True):
            left = [frame for number, frame in enumerate(clip[50:], 1) if number % k]
            assert np.array_equal(pred, left[:100])

    @pytest.mark.parametrize("shift", sensitivity.SHIFTS)
    def test_phase_shift(self, small, found, shift):
        for clip, pred in zip(small.clips, found["phase shift", shift], strict=True):
            at = 50 + FRAMES + shift * sensitivity.stride(clip)
            np.testing.assert_allclose(pred, self.interpolated(clip, at), rtol=0, atol=1e-12)

    def test_noise_is_one_pattern_in_what_moves(self, found, gt):
        moves = gt.std(axis=1) > 1e-4
        assert 0 < moves.sum() < moves.size
        for deviation in sensitivity.NOISE:
            noise = found["noise", deviation] - gt
            assert not noise.swapaxes(1, 2)[~moves].any()
            np.testing.assert_allclose(noise, deviation / 0.3 * (found["noise", 0.3] - gt), rtol=0, atol=1e-12)
        values = noise.swapaxes(1, 2)[moves] / 0.3
        assert abs(values.mean()) < 4 / np.sqrt(values.size)
        assert abs(values.std() - 1) < 4 / np.sqrt(2 * values.size)
        assert np.abs(np.corrcoef(values[:20]) - np.eye(20)).max() < 0.5

    def test_offset_is_in_what_moves(self, found, gt):
        moves = gt.std(axis=1, keepdims=True) > 1e-4
        for offset in sensitivity.OFFSETS:
            np.testing.assert_allclose(
                found["offset", offset] - gt, np.where(moves, offset, 0) + 0 * gt, rtol=0, atol=1e-12
            )

    def test_the_clip_must_be_long_enough(self, small):
        short = small._replace(clips=[clip[:185] for clip in small.clips])
        with pytest.raises(ValueError, match=r"^clip: 185 frames, but a distortion reads frame 189$"):
            list(sensitivity.distorted(short))


@pytest.mark.parametrize("length", [21, 25, 30, 44])
def test_a_stride_is_found_where_half_a_stride_looks_alike(length):
    angles = 2 * np.pi * np.arange(200) / length
    legs = np.stack([np.sin(angles), np.sin(angles + np.pi), 0.4 * np.cos(2 * angles)], axis=1)
    assert sensitivity.stride(legs + [0, 5, -3]) == length


class TestRecords:
    def test_windows_are_those_of_evaluate(self):
        task, motion = synthetic_task(), synthetic_motion()
        gt = npss.poses_to_euler(task.target)
        assert motion.protocol == task.protocol
        assert np.array_equal(motion.at([start + FRAMES for start in motion.starts]), gt)

    def test_zero_velocity_is_that_of_evaluate(self, gait_records):
        record = evaluate.evaluate("", PREDICTORS["zero-velocity"], synthetic_task())
        assert gait_records[0]["distortion"] == "zero-velocity"
        assert gait_records[0]["npss"] == record["npss"]

    def test_each_number_is_what_its_signature_says(self, small, gt):
        records = sensitivity.study(small)
        context = {"representation": "euler", "frames": 100, "fps": 25, "protocol": "synthetic-3", "unwrap": "off"}
        for record, (name, strength, unit, pred) in zip(records, sensitivity.distorted(small), strict=True):
            assert (record["distortion"], record["strength"], record["unit"]) == (name, strength, unit)
            assert record["npss"] == {c: npss.score(gt, pred, convention=c) for c in npss.CONVENTIONS}
            assert record["euler_error"] == pytest.approx(npss.euler_error_curve(gt, pred).mean(), rel=1e-12)
            assert record["signatures"] == {
                **{c: npss.signature(c, **context) for c in npss.CONVENTIONS},
                "euler_error": npss.signature(
                    None, metric="euler_error", columns="gt", average="up-to", at_ms=4000, **context
                ),
            }


class TestClaims:
    """The statements of docs/pictures.md on the generated gait, relative to zero-velocity."""

    @pytest.mark.parametrize("metric", METRICS)
    @pytest.mark.parametrize(
        ("distortion", "nothing"),
        [("tempo", 1), ("skipped frames", 0), ("phase shift", 0), ("noise", 0), ("offset", 0)],
    )
    def test_every_distortion_costs_something(self, gait_records, distortion, nothing, metric):
        values = curve(gait_records, distortion, metric)
        assert values.pop(nothing) == 0
        assert min(values.values()) > 0.01

    @pytest.mark.parametrize("metric", METRICS)
    @pytest.mark.parametrize("distortion", ["noise", "offset"])
    def test_more_noise_or_offset_costs_more(self, gait_records, distortion, metric):
        values = list(curve(gait_records, distortion, metric).values())
        assert (np.diff(values) > 0).all()

    def test_noise_costs_the_euler_error_in_proportion_and_paper_less_at_first(self, gait_records):
        error, paper = (curve(gait_records, "noise", metric) for metric in ("euler_error", "paper"))
        assert error[0.02] == pytest.approx(2 * error[0.01], rel=1e-9)
        assert paper[0.02] > 2.5 * paper[0.01]

    def share(self, records, distortion, strength, metric):
        return curve(records, distortion, metric)[strength] / value(records[0], metric)

    def test_half_a_stride_late_is_worse_than_standing_still_by_the_euler_error_alone(self, gait_records):
        assert self.share(gait_records, "phase shift", 0.5, "euler_error") > 1.3
        assert self.share(gait_records, "phase shift", 0.5, "paper") < 0.1

    def test_released_responds_to_phase_and_paper_hardly(self, gait_records):
        quarters = [0.25, 0.75]
        assert all(self.share(gait_records, "phase shift", s, "released") > 0.6 for s in quarters)
        assert self.share(gait_records, "phase shift", 0.5, "released") < 0.15
        assert max(curve(gait_records, "phase shift", "paper").values()) < 0.1 * gait_records[0]["npss"]["paper"]

    @pytest.mark.parametrize("tempo", [0.7, 0.8, 1.2, 1.3, 1.4])
    def test_another_tempo_is_as_bad_as_standing_still_by_the_euler_error_alone(self, gait_records, tempo):
        assert self.share(gait_records, "tempo", tempo, "euler_error") > 0.95
        assert self.share(gait_records, "tempo", tempo, "paper") < 0.1

    def test_what_the_page_says(self, gait_records):
        worst = max(
            value(r, "paper") for r in gait_records if r["distortion"] in ("tempo", "skipped frames", "phase shift")
        )
        assert worst < 0.1 * gait_records[0]["npss"]["paper"]
        shifts, tempi = (curve(gait_records, distortion, "released") for distortion in ("phase shift", "tempo"))
        assert [f"{shifts[s]:.2f}" for s in (0.25, 0.5)] == ["0.69", "0.14"]
        assert [round(100 * self.share(gait_records, "phase shift", s, "released")) for s in (0.25, 0.5)] == [64, 13]
        assert [f"{tempi[tempo]:.2f}" for tempo in (1.1, 1.3)] == ["0.62", "0.28"]

    def test_a_small_offset_costs_paper_more_than_any_tempo_or_phase(self, gait_records):
        in_time = [v for d in ("tempo", "phase shift") for v in curve(gait_records, d, "paper").values()]
        assert curve(gait_records, "offset", "paper")[0.1] > 4 * max(in_time)


@pytest.fixture(scope="module")
def records(h36m_root):
    return sensitivity.study(sensitivity.motion_of(Human36M(), h36m_root))


class TestCommand:
    @pytest.fixture(autouse=True)
    def quick(self, monkeypatch):
        monkeypatch.delenv("NPSS_H36M", raising=False)
        monkeypatch.setitem(SOURCES._entries, "synthetic", Synthetic(1))

    @pytest.fixture
    def run(self, capsys):
        def run(*arguments):
            status = main(["sensitivity", *map(str, arguments)])
            return status, *capsys.readouterr()

        return run

    def test_json_is_the_default_of_a_pipe(self, run):
        status, out, err = run("--synthetic")
        assert (status, err) == (0, "")
        assert json.loads(out) == sensitivity.study(SMALL)

    def test_table(self, run, monkeypatch):
        monkeypatch.setattr(sys.stdout, "isatty", lambda: True)
        _, out, _ = run("--synthetic")
        header, _, *rows = out.splitlines()
        assert re.split("  +", header)[3:] == ["Euler error (rad)", "NPSS paper", "NPSS released", "NPSS literal"]
        records = sensitivity.study(SMALL)
        for row, record in zip(rows, records, strict=False):
            assert row.startswith(record["distortion"])
            assert row.split()[-4:] == [f"{value(record, metric):.4f}" for metric in METRICS]
        assert [line.strip() for line in rows[len(records) + 1 :]] == list(records[0]["signatures"].values())

    def test_markdown(self, run):
        _, out, _ = run("--synthetic", "--format", "markdown")
        assert out.startswith("| distortion ")
        assert "protocol:synthetic-1|" in out

    def test_picture(self, run, tmp_path):
        pytest.importorskip("matplotlib")
        status, out, _ = run("--synthetic", "-o", tmp_path / "picture.svg")
        assert status == 0
        assert json.loads(out)
        assert "<svg" in (tmp_path / "picture.svg").read_text(encoding="utf-8")

    def test_an_unknown_picture_format(self, run, tmp_path):
        pytest.importorskip("matplotlib")
        status, out, err = run("--synthetic", "-o", tmp_path / "picture.xyz")
        assert (status, out) == (2, "")
        assert "expected the suffix of a picture, such as .svg, .pdf or .png" in err

    def test_a_picture_without_matplotlib(self, run, tmp_path, monkeypatch):
        monkeypatch.delitem(sys.modules, "npss.plot._figure", raising=False)  # another test may have imported it
        monkeypatch.setitem(sys.modules, "matplotlib.figure", None)
        status, out, err = run("--synthetic", "-o", tmp_path / "picture.svg")
        assert (status, out) == (2, "")
        assert err.endswith("error: -o: npss.plot needs matplotlib; in the project's folder: pip install '.[plot]'\n")

    def test_human36m(self, run, h36m_root, records):
        status, out, _ = run("--h36m", h36m_root)
        assert status == 0
        assert json.loads(out) == records

    def test_missing_data(self, run):
        status, out, err = run("--h36m", "nowhere")
        assert (status, out) == (2, "")
        assert "nowhere: no Human3.6M in it" in err

    def test_data_are_required(self, run):
        status, out, err = run()
        assert (status, out) == (2, "")
        assert (
            "no source of motion: give --h36m DIR (the folder of Human3.6M, with dataset/ in it) or --synthetic" in err
        )


SMALL = synthetic_motion(1)

# From a program that shares no code with npss: pandas, scipy's rotations and splines, numpy.fft.
EULER_PAPER_RELEASED_LITERAL = {
    ("zero-velocity", 0): ("1.2685", "2.3341", "1.1413", "0.6119"),
    ("tempo", 0.7): ("1.2002", "0.3933", "0.4965", "0.4033"),
    ("tempo", 1.4): ("1.2447", "0.6724", "0.6540", "0.4209"),
    ("skipped frames", 0.1): ("0.7904", "0.2181", "0.4126", "0.2144"),
    ("skipped frames", 1 / 3): ("1.2620", "0.8532", "0.8244", "0.4746"),
    ("phase shift", 0.5): ("1.4498", "0.4655", "0.3850", "0.1892"),
    ("phase shift", 1): ("0.9826", "0.8563", "0.5557", "0.2339"),
    ("noise", 0.1): ("0.6883", "0.8050", "0.4905", "0.4612"),
    ("offset", 0.1): ("0.6928", "0.9698", "0.6150", "0.4547"),
    ("offset", 0.5): ("3.4641", "2.3997", "1.2550", "0.5546"),
}
SIGNATURES = {
    "paper": "npss|version:1|convention:paper|representation:euler|frames:100|fps:25|protocol:srnn-8|unwrap:off",
    "released": "npss|version:1|convention:released|representation:euler|frames:100|fps:25|protocol:srnn-8|unwrap:off",
    "literal": "npss|version:1|convention:literal|representation:euler|frames:100|fps:25|protocol:srnn-8|unwrap:off",
    "euler_error": "euler_error|version:1|representation:euler|frames:100|fps:25|protocol:srnn-8|unwrap:off"
    "|at_ms:4000|average:up-to|columns:gt",
}


@pytest.fixture(scope="module")
def windows(h36m_root):
    motion = sensitivity.motion_of(Human36M(), h36m_root)
    return motion.at([start + FRAMES for start in motion.starts])


class TestWalking:
    def test_golden_values(self, records):
        found = {(record["distortion"], record["strength"]): record for record in records}
        for place, expected in EULER_PAPER_RELEASED_LITERAL.items():
            assert tuple(f"{value(found[place], metric):.4f}" for metric in METRICS) == expected, place
            assert found[place]["signatures"] == SIGNATURES

    def test_strides(self, h36m_root):
        motion = sensitivity.motion_of(Human36M(), h36m_root)
        around = [clip[start - 50 : start + 150] for clip, start in zip(motion.clips, motion.starts, strict=True)]
        assert [sensitivity.stride(clip) for clip in around] == [35, 36, 37, 39, 37, 39, 35, 38]

    def test_the_documented_table(self, records):
        assert documented("Human3.6M") <= rows_of(records)

    def test_what_the_page_says(self, records):
        """Return values relative to zero-velocity."""

        def share(distortion, strength, metric):
            return round(100 * curve(records, distortion, metric)[strength] / value(records[0], metric))

        assert [share("phase shift", 0.5, metric) for metric in METRICS] == [114, 20, 34, 31]
        assert share("phase shift", 1.0, "paper") == 37
        assert [share("tempo", tempo, "euler_error") for tempo in (0.7, 1.4)] == [95, 98]
        assert [share("tempo", tempo, "paper") for tempo in (0.7, 1.4)] == [17, 29]
        assert share("tempo", 0.7, "literal") == 66
        assert [share("noise", 0.02, metric) for metric in METRICS[:3]] == [11, 2, 3]
        assert min(share("noise", 0.2, metric) for metric in METRICS) > 100
        assert [share("offset", 0.5, metric) for metric in METRICS] == [273, 103, 110, 91]

    def test_no_convention_is_blind_to_a_shift_that_is_not_circular(self, records, windows):
        paper = list(curve(records, "phase shift", "paper").values())
        assert (np.diff(paper) > 0).all()
        around = np.roll(windows, 18, axis=1)
        assert npss.score(windows, around) < 1e-12
        assert round(npss.score(windows, around, convention="released"), 2) == 0.38

    def test_the_cumulation_is_what_forgives_a_tempo(self, h36m_root, windows):
        preds = {(name, s): p for name, s, _, p in sensitivity.distorted(sensitivity.motion_of(Human36M(), h36m_root))}
        slow, still = (
            npss.score(windows, preds[place], convention=npss.Convention(distance="spectrum"))
            for place in (("tempo", 0.7), ("zero-velocity", 0))
        )
        assert round(100 * slow / still) == 64

    def test_dc_is_most_of_the_power(self, windows):
        power = np.abs(np.fft.fft(windows, axis=1)) ** 2
        assert round(100 * power[:, 0].sum() / power.sum()) == 95


def rows_of(records):
    lines = sensitivity.tabulate(records, markdown=True).splitlines()
    return {tuple(cell.strip() for cell in line.strip("|").split("|")) for line in lines if line.startswith("|")}


def documented(section):
    """Return the rows of the table in a section of the page."""
    text = PAGE.read_text(encoding="utf-8").partition(f"### {section}\n")[2].partition("\n#")[0]
    rows = [line for line in text.splitlines() if re.match(r"\| (zero|tempo|skip|phase|noise|offset)", line)]
    assert len(rows) > 8
    return {tuple(cell.strip() for cell in row.strip("|").split("|")) for row in rows}


@pytest.mark.skipif(not PAGE.exists(), reason="the documentation is not beside the tests")
def test_the_documented_table_of_the_gait(gait_records):
    assert documented("A generated gait") <= rows_of(gait_records)
