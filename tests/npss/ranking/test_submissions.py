"""Folders of models with one bad file, which errors name; hidden files are ignored."""

import csv
import io
import json
import re

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import npss
from npss._pages import Figure
from npss.commands import main
from npss.ranking._results import results_of_record
from npss.ranking._standings import notes, standings
from npss.ranking._submissions import overlapping, read_submissions
from npss.records import measure

pytest.importorskip("pandas")


def samples(path, *, scale=1.0, still=(), short=0, seed=0):
    """Write samples of eight sequences; the ground truth is the same of each seed."""
    rng = np.random.default_rng(seed)
    t = np.arange(50)[:, np.newaxis] / 25
    arrays = {}
    for i in range(8):
        one = np.random.default_rng(i)
        gt = 0.3 * np.sin(2 * np.pi * one.uniform(0.3, 1, 99) * t + one.uniform(0, 6, 99))
        if i in still:
            gt[:] = gt[0]
        arrays[f"expmap/gt/walking_{i}"] = gt
        pred = scale * (gt + 0.05 * rng.normal(size=gt.shape))
        arrays[f"expmap/preds/walking_{i}"] = pred[short:]
    path.parent.mkdir(exist_ok=True)
    np.savez(path, **arrays)
    return path


def error(capsys, *arguments):
    assert main([str(one) for one in arguments]) == 2
    return capsys.readouterr().err


@pytest.fixture
def folder(tmp_path):
    for seed, name in enumerate("ab"):
        samples(tmp_path / "models" / f"{name}.npz", seed=seed)
    return tmp_path / "models"


@settings(max_examples=30)
@given(st.lists(st.integers(0, 60), min_size=2, max_size=6), st.integers(5, 30))
def test_overlapping_windows_are_found(starts, frames):
    """Windows of a clip overlap if two starts are less than a window apart."""
    clip = np.random.default_rng(0).normal(size=(100, 4))
    found = overlapping(np.stack([clip[start : start + frames] for start in starts]))
    apart = min(abs(a - b) for i, a in enumerate(starts) for b in starts[:i])
    assert (found is not None) == (apart < frames - 1)  # a single frame has no motion
    if found:
        i, j, shift = found
        assert starts[j] - starts[i] == shift


def test_nothing_overlaps_that_stands_still_or_is_alone():
    assert overlapping(np.zeros((4, 10, 2, 3))) is None
    assert overlapping(np.random.default_rng(0).normal(size=(1, 10, 2))) is None


class TestBadModels:
    def test_one_that_has_diverged_is_named(self, capsys, folder, tmp_path):
        samples(folder / "c.npz", scale=1e20)
        for command in (["leaderboard"], ["report", "-o", tmp_path / "r.html"]):
            said = error(capsys, *command, folder)
            assert "'c' on 'walking': prediction: poses: an angle of 2**52 rad or more" in said
        assert "'c' on 'walking': poses: " in error(capsys, "study", "page", folder, "-o", tmp_path / "s.html")

    def test_so_is_one_whose_root_alone_has(self, capsys, folder, tmp_path):
        """Which is not scored, but shown."""
        path = samples(folder / "c.npz")
        arrays = dict(np.load(path))
        arrays["expmap/preds/walking_2"][:, 3] = 1e20
        np.savez(path, **arrays)
        assert main(["leaderboard", str(folder)]) == 0
        capsys.readouterr()
        assert "'c' on 'walking': poses: " in error(capsys, "report", folder, "-o", tmp_path / "r.html")

    def test_a_ground_truth_that_cannot_be_converted_is_named_as_such(self, capsys, tmp_path):
        path = samples(tmp_path / "c.npz")
        arrays = dict(np.load(path))
        arrays["expmap/gt/walking_2"][:, 9] = 1e20
        np.savez(path, **arrays)
        assert "'c' on 'walking': ground truth: poses: " in error(capsys, "leaderboard", path)

    def test_one_that_is_shorter_than_its_ground_truth_is_named_with_its_file(self, capsys, folder, tmp_path):
        path = samples(folder / "c.npz", short=20)
        out = ["-o", tmp_path / "page.html"]
        for command in (["leaderboard", folder], ["report", folder, *out], ["study", "page", folder, *out]):
            said = error(capsys, *command)
            assert f"{path}: walking: the predictions have 30 frames, the ground truth 50" in said


class TestHiddenFiles:
    def test_they_are_no_models(self, folder):
        shown = list(read_submissions([folder]))
        samples(folder / ".ipynb_checkpoints" / "samples.npz")
        samples(folder / ".ipynb_checkpoints" / "a.npz")
        (folder / "._a.npz").write_bytes(b"of macOS")
        samples(folder / "c" / "samples.npz")
        (folder / "c" / "._samples.npz").write_bytes(b"of macOS")
        assert list(read_submissions([folder])) == [*shown, "c"]

    def test_alone_they_are_nothing(self, tmp_path):
        (tmp_path / "._a.npz").write_bytes(b"of macOS")
        with pytest.raises(ValueError, match="no results in it"):
            read_submissions([tmp_path])

    def test_one_that_is_asked_for_is_read(self, folder):
        (folder / "a.npz").rename(folder / ".a.npz")
        assert list(read_submissions([folder / ".a.npz"])) == [".a"]


class TestNames:
    @pytest.mark.parametrize("name", ["", "  ", "\n"])
    def test_none_is_empty(self, name):
        gt = np.random.default_rng(0).normal(size=(8, 50, 3))
        report = npss.report(gt, gt + 0.1)
        with pytest.raises(ValueError, match="the name of a model is empty"):
            npss.leaderboard({name: report})
        record = {"model": name, "action": "a", **measure(gt, gt + 0.1, sequences=True, frames=50)}
        with pytest.raises(ValueError, match="the name of a model is empty"):
            npss.leaderboard([record])

    def test_two_published_rows_of_one_model_are_refused(self):
        row = {"model": "m", "action": "a", "npss": {"paper": 1.0}, "signature": npss.signature(frames=50)}
        rows = [row | {"source": source} for source in ("One 2020", "Other 2021")]
        with pytest.raises(ValueError, match=r"^a, NPSS paper: duplicate model 'm \(published\)'$"):
            npss.leaderboard(rows)

    def test_names_of_published_rows_are_taken(self):
        row = {"model": "m", "action": "a", "npss": {"paper": 1.0}, "signature": npss.signature(frames=50)}
        own = row | {"model": "m (published)", "action": "b"}
        with pytest.raises(ValueError, match=r"^'m \(published\)' is the name of a published model"):
            npss.leaderboard([own, row | {"source": "One 2020"}])
        assert list(npss.leaderboard([own]).index) == ["m (published)"]

    def test_files_of_records_with_the_same_model_are_named(self, tmp_path):
        row = {"model": "m", "action": "a", "npss": {"paper": 1.0}, "signature": npss.signature(frames=50)}
        for name, record in (("one", row), ("two", row), ("eating", row | {"action": "eating"})):
            (tmp_path / f"{name}.json").write_text(json.dumps([record]), encoding="utf-8")
        with pytest.raises(ValueError, match=r"two\.json: 'a' of 'm' is also in .*one\.json$"):
            npss.leaderboard([tmp_path / "one.json", tmp_path / "two.json"])
        (tmp_path / "broken.json").write_text(json.dumps([row | {"model": []}]), encoding="utf-8")
        with pytest.raises(ValueError, match="records: expected text as 'model' in each"):
            npss.leaderboard([tmp_path / "one.json", tmp_path / "broken.json"])
        board = npss.leaderboard([tmp_path / "one.json", tmp_path / "eating.json"])
        assert board.shape == (1, 2)

    def test_markdown_shows_them_as_they_are(self):
        gt = np.random.default_rng(0).normal(size=(8, 50, 3))
        board = npss.leaderboard({"~x~": npss.report(gt, gt + 0.1), "$x$": npss.report(gt, gt + 0.2)})
        rows = board.to_markdown().splitlines()
        assert any(r"| \~x\~ " in row for row in rows)
        assert any(r"| \$x\$ " in row for row in rows)


class TestStillSequences:
    """Nothing moves in the ground truth of one, so it has no Euler error. It has an NPSS, and so have the others."""

    GT, PRED = np.random.default_rng(0).normal(size=(2, 8, 25, 5)).cumsum(axis=2)
    GT[3] = GT[3, 0]
    MOVES = np.arange(8) != 3

    def record(self, gt=GT, pred=PRED, **options):
        return measure(gt, pred, fps=25, at_ms=(80, 400), sequences=True, frames=25, **options)

    def test_the_euler_error_is_the_mean_over_the_others(self):
        record = self.record()
        assert record["still"] == [3]
        expected = npss.euler_error(self.GT[self.MOVES], self.PRED[self.MOVES], at_ms=(80, 400))
        assert record["euler_error"] == {str(time): error for time, error in expected.items()}
        assert [record["sequences"]["euler_error"]["80"][i] is None for i in range(8)] == [i == 3 for i in range(8)]
        assert json.loads(json.dumps(record, allow_nan=False)) == record

    def test_npss_is_of_all(self):
        record = self.record()
        for name in npss.CONVENTIONS:
            assert record["npss"][name] == npss.score(self.GT, self.PRED, convention=name)
            assert "still" not in record["signatures"][name]
        assert npss.parse_signature(record["signatures"]["euler_error"])["still"] == 1

    def test_without_one_nothing_is_said(self):
        record = self.record(self.GT[self.MOVES], self.PRED[self.MOVES])
        assert "still" not in json.dumps(record)

    @pytest.mark.parametrize("shape", [(8, 25, 5), (25, 5)])
    def test_where_all_are_still_there_is_no_euler_error(self, shape):
        gt, pred = np.ones(shape), self.PRED.reshape(-1)[: np.prod(shape)].reshape(shape)
        record = self.record(gt, pred)
        assert record["euler_error"] == {}
        assert record["still"] == list(range(8 if len(shape) == 3 else 1))
        assert "euler_error" not in record["sequences"]
        assert record["signature"].startswith("npss|")
        assert record["signatures"].keys() == npss.CONVENTIONS.keys()
        assert record["npss"]["paper"] == npss.score(gt, pred)

    @pytest.mark.parametrize("where", ["gt", "pred"])
    def test_nan_is_not_still_and_its_place_is_right(self, where):
        gt, pred = self.GT.copy(), self.PRED.copy()
        {"gt": gt, "pred": pred}[where][5, 2, 1] = np.nan
        with pytest.raises(ValueError, match=rf"^{where}: nan at index \(5, 2, 1\)"):
            self.record(gt, pred)
        gt[5] = np.nan
        with pytest.raises(ValueError, match=r"^gt: nan at index \(5, 0, 0\)"):
            self.record(gt, pred)

    def test_the_functions_refuse_it(self):
        for function in (npss.euler_error, npss.euler_error_curve):
            with pytest.raises(ValueError, match="gt: no feature of sequence 3 moves"):
                function(self.GT, self.PRED)

    def test_a_leaderboard_counts_and_says_so(self):
        record = {"model": "m", "action": "a", **self.record()}
        results = {one.column: one for one in results_of_record(record)}
        euler = results["Euler error 400 ms"]
        np.testing.assert_array_equal(euler.weight, self.MOVES)
        assert euler.value == pytest.approx(euler.numerator[self.MOVES].mean(), rel=1e-12)
        other = {"model": "other", "action": "a", **self.record(pred=self.GT + 0.1)}
        found = standings(results_of_record(record) + results_of_record(other))
        (said,) = (line for line in notes(found) if "no Euler error" in line)
        assert said == "a: no Euler error for 1 of 8 sequences, since nothing moves in the ground truth."
        without = {one.result.column: one for one in standings(self.results_of_the_others())}
        for one in found:
            if one.result.model == "m" and one.result.column.startswith("Euler"):
                same = without[one.result.column]
                assert (one.low, one.high, one.result.value) == (same.low, same.high, same.result.value)

    def results_of_the_others(self):
        record = self.record(self.GT[self.MOVES], self.PRED[self.MOVES])
        return results_of_record({"model": "m", "action": "a", **record})

    def test_the_picture_leaves_it_out(self):
        pytest.importorskip("matplotlib")
        import npss.plot

        figure = npss.plot.errors(self.GT, {"m": self.PRED}, fps=25)
        (line,) = (line for line in figure.axes[0].get_lines() if line.get_label() == "m")
        curve = npss.euler_error_curve(self.GT[self.MOVES], self.PRED[self.MOVES])
        np.testing.assert_allclose(line.get_ydata(), curve, rtol=1e-12)
        assert "mean of 7 sequences" in figure.get_supxlabel()
        assert "still:1" in figure.get_supxlabel()
        with pytest.raises(ValueError, match=r"no feature of sequence 0 moves .*; for 'm' of preds"):
            npss.plot.errors(np.ones((2, 9, 3)), {"m": np.ones((2, 9, 3))}, fps=25)

    def test_a_command_goes_on_and_says_so(self, capsys, tmp_path):
        folder = samples(tmp_path / "models" / "a.npz", still=(3,)).parent
        samples(folder / "b.npz", still=(3,), seed=1)
        assert main(["leaderboard", str(folder)]) == 0
        printed = capsys.readouterr().out
        assert "walking: no Euler error for 1 of 8 sequences, since nothing moves in the ground truth." in printed
        assert main(["score", str(folder / "a.npz")]) == 0
        printed = capsys.readouterr().out
        assert "No Euler error, since nothing moves in the ground truth: sequence 3." in printed
        assert re.search(r"Euler error 80 ms .*\|still:1$", printed, re.M)

    def test_a_page_of_still_motion_has_no_picture_of_the_euler_error(self, capsys, tmp_path, monkeypatch):
        pytest.importorskip("matplotlib")
        # Writing pictures takes long, and is not what is looked at.
        monkeypatch.setattr(
            "npss.commands._report._Action._figure", lambda self, title, *_: Figure(title, "<svg/>", "")
        )
        path, page = samples(tmp_path / "a.npz", still=range(8)), tmp_path / "r.html"
        assert main(["report", str(path), "-o", str(page), "--format", "csv"]) == 0
        assert {row["column"] for row in csv.DictReader(io.StringIO(capsys.readouterr().out))} == {
            f"NPSS {name}" for name in npss.CONVENTIONS
        }
        titles = re.findall(r"<figure><h3>(.*?)</h3>", page.read_text(encoding="utf-8"))
        assert titles == ["the first sequence", "where the score of a comes from", "the spectra behind it, a"]
        assert main(["score", str(path)]) == 0
        assert "No Euler error, since nothing moves in the ground truth: sequence 0, 1" in capsys.readouterr().out

    def test_a_curve_of_the_file_is_not_compared_then(self, capsys, tmp_path):
        for still in ((), (3,)):
            path = samples(tmp_path / "a.npz", still=still)
            np.savez(path, **dict(np.load(path)), mean_walking_error=np.ones(50))
            assert main(["score", str(path), "--format", "json"]) == 0
            (record,) = json.loads(capsys.readouterr().out)
            assert ("stored_curve_difference" in record) == (not still)
