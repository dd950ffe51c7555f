"""`npss.leaderboard`: its sources, its DataFrame, and its output."""

import csv
import html.parser
import io
import itertools
import json
import pickle
import re
import sys

import numpy as np
import pytest

import npss
from npss import published
from npss.commands import main
from npss.ranking._submissions import read_submissions

pd = pytest.importorskip("pandas")

ANGLES = slice(6, 99)


@pytest.fixture(scope="module")
def poses():
    """Ground truth and the predictions of two models, eight sequences of 50 frames."""
    rng = np.random.default_rng(0)
    gt = 0.02 * rng.normal(size=(8, 50, 99)).cumsum(axis=1)
    return {"gt": gt, "close": gt + 0.02 * rng.normal(size=gt.shape), "far": 0.5 * rng.normal(size=gt.shape)}


def write(path, gt, preds):
    arrays = {}
    for action, motion in preds.items():
        for i, (truth, pred) in enumerate(zip(gt, motion, strict=True)):
            arrays[f"expmap/gt/{action}_{i}"] = truth
            arrays[f"expmap/preds/{action}_{i}"] = pred
    np.savez(path, **arrays)
    return path


@pytest.fixture(scope="module")
def folder(tmp_path_factory, poses):
    """Files of three models; only two of them have all actions."""
    root = tmp_path_factory.mktemp("predictions")
    gt = poses["gt"]
    write(root / "close.npz", gt, {"walking": poses["close"], "eating": poses["far"]})
    write(root / "far_$off.npz", gt, {"walking": poses["far"], "eating": poses["close"]})
    write(root / "half & half.npz", gt, {"walking": (poses["close"] + poses["far"]) / 2})
    (root / "notes.txt").write_text("not a prediction", encoding="utf-8")
    return root


@pytest.fixture(scope="module")
def board(folder):
    return npss.leaderboard(folder, protocol="mine")


class TestFrame:
    def test_is_a_data_frame_of_models_by_actions_and_columns(self, board, poses):
        assert isinstance(board, pd.DataFrame)
        assert list(board.index) == ["close", "far_$off", "half & half"]
        assert list(board.columns.get_level_values("action").unique()) == ["eating", "walking"]
        gt, pred = (npss.poses_to_euler(poses[name]) for name in ("gt", "close"))
        for name in npss.CONVENTIONS:
            assert board.loc["close", ("walking", f"NPSS {name}")] == npss.score(gt, pred, convention=name)
        errors = npss.euler_error(gt, pred)
        for time, error in errors.items():
            assert board.loc["close", ("walking", f"Euler error {time} ms")] == error

    def test_missing_cells_are_nan(self, board):
        assert board.loc["half & half", "eating"].isna().all()
        assert board.drop(index="half & half").notna().all(axis=None)

    def test_results_of_computations_are_plain_frames(self, board):
        assert type(board * 2) is pd.DataFrame
        assert (
            float((board * 2).loc["close", ("walking", "NPSS paper")])
            == 2 * board.loc["close", ("walking", "NPSS paper")]
        )

    def test_tidy_has_a_row_for_each_number(self, board):
        tidy = board.tidy
        assert len(tidy) == board.notna().sum().sum()
        for row in tidy.itertuples():
            assert board.loc[row.model, (row.action, row.column)] == row.value
            assert row.low < row.value < row.high
            assert npss.parse_signature(row.signature)["protocol"] == "mine"
        walking = tidy[(tidy.action == "walking") & (tidy.column == "NPSS paper")].set_index("model")
        assert dict(walking["rank"]) == {"close": 1, "half & half": 2, "far_$off": 3}
        assert list(walking.index[walking["best"]]) == ["close"]
        assert set(walking.index[walking["worse"]]) == {"half & half", "far_$off"}

    def test_prints_as_a_frame_does(self, board):
        assert "close" in repr(board)

    def test_a_pickled_one_is_written_as_before(self, board):
        again = pickle.loads(pickle.dumps(board))
        assert again.to_markdown() == board.to_markdown()
        assert again.to_csv() == board.to_csv()


class TestColumns:
    def test_columns_are_chosen_by_name_or_beginning(self, folder, board):
        chosen = npss.leaderboard(folder, protocol="mine", columns=["Euler error 400 ms", "NPSS"])
        assert list(chosen["walking"].columns) == ["Euler error 400 ms", "NPSS paper", "NPSS released", "NPSS literal"]
        place = ["action", "column", "model"]
        expected = board.tidy[board.tidy["column"].isin(set(chosen.tidy["column"]))]
        pd.testing.assert_frame_equal(
            chosen.tidy.sort_values(place, ignore_index=True), expected.sort_values(place, ignore_index=True)
        )
        with pytest.raises(ValueError, match=r"^columns: expected some of NPSS paper, .*; got 'NPSS pap'"):
            npss.leaderboard(folder, columns=["NPSS pap"])
        with pytest.raises(ValueError, match=r"^by: expected one of NPSS paper; got 'NPSS released'"):
            npss.leaderboard(folder, columns=["NPSS paper"], by="NPSS released")

    def test_windows_of_time_are_scored(self, folder, poses):
        board = npss.leaderboard(folder, columns=["NPSS released"], edges_ms=(0, 1000, 2000))
        gt, pred = (npss.poses_to_euler(poses[name]) for name in ("gt", "close"))
        windows = npss.score_windows(gt, pred, fps=25, edges_ms=(0, 1000, 2000), convention="released")
        assert len(windows) == 2
        for window, value in windows.items():
            assert board.loc["close", ("walking", f"NPSS released {window} s")] == value

    def test_windows_are_only_for_files(self, tmp_path):
        (tmp_path / "records.json").write_text("[]", encoding="utf-8")
        with pytest.raises(ValueError, match=r"^edges_ms: only for files of results"):
            npss.leaderboard(tmp_path / "records.json", edges_ms=(0, 1000))

    def test_a_wide_table_has_actions_side_by_side(self, board):
        text = board.to_text(wide=True)
        assert text.count("(ranked by eating)") == len(board["walking"].columns)
        lines = text.splitlines()
        place = lines.index("NPSS paper (ranked by eating)")
        assert lines[place + 2].split() == ["rank", "model", "eating", "walking"]
        row = next(line for line in lines[place:] if " close " in line)
        for action in ("eating", "walking"):
            assert f"{board.loc['close', (action, 'NPSS paper')]:.3f}" in row
        assert "### NPSS paper (ranked by eating)" in board.to_markdown(wide=True)
        assert "<caption>NPSS paper, ranked by eating</caption>" in board.to_html(wide=True)

    def test_latex_has_a_label_a_caption_and_few_notes(self, board):
        text = board.to_latex(caption=r"My \emph{results}.", label="tab:mine")
        assert r"\caption{My \emph{results}. eating, ranked by NPSS paper" in text
        labels = [line for line in text.splitlines() if line.startswith(r"\label")]
        assert labels == [r"\label{tab:mine}", r"\label{tab:mine-2}"]
        for part in text.split(r"\begin{table}")[1:]:
            notes = part.split(r"\scriptsize\raggedright")[1].splitlines()
            assert sum(line.endswith(r"\par") and not line.startswith(r"\texttt") for line in notes) <= 3
        assert text.splitlines()[1].startswith("% Cite A. Gopalakrishnan")
        assert r"\label" not in board.to_latex()

    def test_published_rows_choose_the_column_to_sort_by(self):
        context = {"representation": "euler", "frames": 100, "fps": 25, "protocol": "srnn-8", "unwrap": "off"}
        signatures = {name: npss.signature(name, **context) for name in ("paper", "released")}
        records = [
            {
                "model": name,
                "action": "walking",
                "npss": {"paper": score, "released": 1 - score},
                "signature": signatures["paper"],
                "signatures": signatures,
            }
            for name, score in (("a", 0.1), ("b", 0.2))
        ]
        assert npss.leaderboard(records).by is None
        board = npss.leaderboard(records, published=True)
        assert board.by == "NPSS released"
        assert "Published numbers, not ranked: " in board.to_latex()


class TestSources:
    def test_one_file_and_several(self, folder, board):
        one = npss.leaderboard(folder / "close.npz", protocol="mine")
        assert list(one.index) == ["close"]
        several = npss.leaderboard([folder / "close.npz", str(folder / "far_$off.npz")], protocol="mine")
        pd.testing.assert_frame_equal(pd.DataFrame(several), pd.DataFrame(board.loc[["close", "far_$off"]]))

    def test_records_and_files_of_records(self, capsys, tmp_path):
        from npss_baselines.__main__ import main as baselines

        command = ["evaluate", "zero-velocity", "repeat-50", "--synthetic", "--format", "json"]
        assert baselines([*command, "--sequences"]) == 0
        printed = capsys.readouterr().out
        records = json.loads(printed)
        board = npss.leaderboard(records)
        assert board.loc["repeat-50", ("gait", "NPSS paper")] == records[1]["npss"]["paper"]
        assert board.tidy.set_index(["model", "column"]).loc[("repeat-50", "NPSS paper"), "low"] > 0
        (tmp_path / "records.json").write_text(printed, encoding="utf-8")
        pd.testing.assert_frame_equal(npss.leaderboard(tmp_path / "records.json").tidy, board.tidy)
        with pytest.raises(ValueError, match="protocol: only for files of results; records state their own"):
            npss.leaderboard(tmp_path / "records.json", protocol="srnn-8")

        assert baselines(command) == 0  # without --sequences
        plain = npss.leaderboard(json.loads(capsys.readouterr().out))
        pd.testing.assert_frame_equal(pd.DataFrame(plain), pd.DataFrame(board))
        assert plain.tidy["low"].isna().all()
        assert any("ranked by value" in note for note in plain.notes)

    def test_reports(self, poses):
        gt = poses["gt"][..., ANGLES]
        reports = {
            name: {"walking": npss.report(gt, poses[name][..., ANGLES], convention="released", fps=25)}
            for name in ("close", "far")
        }
        board = npss.leaderboard(reports)
        assert board.loc["far", ("walking", "NPSS released")] == float(reports["far"]["walking"])
        without_actions = npss.leaderboard({name: of["walking"] for name, of in reports.items()})
        assert list(without_actions.columns) == [("", "NPSS released")]
        assert "all (ranked by NPSS released)" in without_actions.to_text()

    @pytest.mark.parametrize("source", [3, None, [3], [None]])
    def test_other_things_are_refused(self, source):
        with pytest.raises(TypeError, match="source: expected paths"):
            npss.leaderboard(source)

    @pytest.mark.parametrize("reports", [{"a": 5}, {"a": {"walking": 5}}, {"a": [5]}])
    def test_invalid_reports(self, reports):
        with pytest.raises(TypeError, match="source: expected"):
            npss.leaderboard(reports)

    def test_invalid_names(self, poses):
        report = npss.report(poses["gt"][..., ANGLES], poses["far"][..., ANGLES])
        for reports in ({3: report}, {"a": {3: report}}):
            with pytest.raises(TypeError, match="source: expected"):
                npss.leaderboard(reports)

    def test_records_and_reports_state_their_own_context(self, poses):
        report = npss.report(poses["gt"][..., ANGLES], poses["far"][..., ANGLES])
        for source in ({"a": report}, [TestPublished().record()]):
            with pytest.raises(ValueError, match="protocol: only for files of samples; records and reports"):
                npss.leaderboard(source, protocol="mine")

    def test_the_same_ground_truth_by_every_convention(self, poses):
        gt = poses["gt"][..., ANGLES]
        reports = {
            "one": npss.report(gt, poses["close"][..., ANGLES], convention="literal"),
            "other": npss.report(2 * gt, poses["far"][..., ANGLES], convention="literal"),
        }
        with pytest.raises(ValueError, match="all: 'one' and 'other' were scored on different ground truth"):
            npss.leaderboard(reports)

    @pytest.mark.parametrize("name", ["nowhere", "nowhere.h5", "nowhere.json"])
    def test_files_that_are_not_there(self, tmp_path, name):
        with pytest.raises((ValueError, FileNotFoundError), match=name):
            npss.leaderboard(tmp_path / name)

    def test_files_of_another_kind(self, tmp_path):
        (tmp_path / "notes.txt").write_text("", encoding="utf-8")
        with pytest.raises(ValueError, match=r"notes\.txt: expected .* samples"):
            npss.leaderboard(tmp_path / "notes.txt")

    def test_no_model_is_the_ground_truth(self, tmp_path, poses):
        with pytest.raises(ValueError, match="a model must not be called 'ground truth'"):
            npss.leaderboard(write(tmp_path / "ground truth.npz", poses["gt"], {"walking": poses["far"]}))

    @pytest.mark.parametrize("source", [{}, []])
    def test_an_empty_source(self, source):
        with pytest.raises(ValueError, match="source: it has nothing to rank"):
            npss.leaderboard(source)

    def test_without_pandas(self, monkeypatch):
        monkeypatch.setitem(sys.modules, "pandas", None)
        monkeypatch.delitem(sys.modules, "npss.ranking._frame")
        monkeypatch.delitem(vars(npss), "Leaderboard", raising=False)
        for what in (lambda: npss.leaderboard([TestPublished().record()]), lambda: npss.Leaderboard):
            with pytest.raises(ImportError, match=r"need pandas; in the project's folder: pip install '\.\[pandas\]'"):
                what()

    def test_empty_folders(self, tmp_path):
        with pytest.raises(ValueError, match="no results in it"):
            npss.leaderboard(tmp_path)

    def test_a_folder_for_each_model(self, folder, board, tmp_path):
        for name in ("close", "far_$off"):
            (tmp_path / name).mkdir()
            (tmp_path / name / "samples.npz").write_bytes((folder / f"{name}.npz").read_bytes())
            (tmp_path / name / "other.npz").write_bytes(b"not read")
        several = npss.leaderboard(tmp_path, protocol="mine")
        pd.testing.assert_frame_equal(pd.DataFrame(several), pd.DataFrame(board.loc[["close", "far_$off"]]))

    def test_two_files_of_one_model(self, folder, tmp_path, poses):
        other = write(tmp_path / "close.npz", poses["gt"], {"walking": poses["far"]})
        found = read_submissions([folder, other])
        assert list(found) == [f"{folder.name}/close", "far_$off", "half & half", f"{tmp_path.name}/close"]
        np.testing.assert_array_equal(found[f"{tmp_path.name}/close"]["walking"].pred, poses["far"])
        with pytest.raises(ValueError, match=r"close\.npz: duplicate model 'close'"):
            read_submissions([folder, folder / "close.npz"])

    def test_ground_truths_that_differ(self, folder, tmp_path, poses):
        other = write(tmp_path / "odd.npz", poses["gt"] + 0.01, {"walking": poses["far"]})
        with pytest.raises(
            ValueError, match=r"walking: the ground truths of 'close' and 'odd' differ \(by up to 0.01, in sequence \d"
        ):
            npss.leaderboard([folder, other])
        short = write(tmp_path / "short.npz", poses["gt"][:5], {"walking": poses["far"][:5]})
        with pytest.raises(ValueError, match=r"differ \(shapes \(8, 50, 99\) and \(5, 50, 99\)\)"):
            npss.leaderboard([folder, short])

    @pytest.mark.parametrize("text", ["", "{", "3", "[3]", '{"model": "m"}', "\xff"])
    def test_broken_records(self, tmp_path, text):
        path = tmp_path / "records.json"
        path.write_bytes(text.encode("latin-1"))
        with pytest.raises(ValueError, match=r"records\.json: (invalid JSON|expected a list of records|line 1 is not)"):
            npss.leaderboard(path)

    def test_how_records_are_written(self, capsys, tmp_path):
        path = tmp_path / "records.json"
        text = json.dumps([TestPublished().record()])
        path.write_text(text, encoding="utf-8-sig")
        assert len(npss.leaderboard(path)) == 1
        for encoding, written, message in (
            ("utf-16", text, "the text is UTF-16; save it as UTF-8"),
            ("utf-8", "[" * 100_000, "invalid JSON: nested too deeply"),
        ):
            path.write_text(written, encoding=encoding)
            assert main(["leaderboard", str(path)]) == 2
            assert capsys.readouterr().err == f"npss: error: {path}: {message}\n"

    def test_sorted_by_a_column(self, folder):
        board = npss.leaderboard(folder, by="Euler error 80 ms")
        assert "ranked by Euler error 80 ms" in board.to_text()
        with pytest.raises(ValueError, match=r"by: expected one of NPSS paper, .*; got 'NPSS'"):
            npss.leaderboard(folder, by="NPSS")


def test_csv_in_the_home_folder(monkeypatch, tmp_path):
    monkeypatch.setenv("HOME", str(tmp_path))
    gt = np.random.default_rng(0).normal(size=(2, 20, 3))
    board = npss.leaderboard({"m": npss.report(gt, gt + 0.1)})
    board.to_csv("~/board.csv")  # as pandas takes it
    assert (tmp_path / "board.csv").read_text(encoding="utf-8") == board.to_csv()


LABELS = ["a", "a", "b", "b", "c", "d", "e", None]  # five blocks, and a sequence in none


@pytest.fixture(scope="module")
def reports(poses):
    gt = poses["gt"][..., ANGLES]
    return {name: npss.report(gt, poses[name][..., ANGLES], groups=LABELS) for name in ("close", "far")}


class TestGroups:
    def test_reports_and_records_state_theirs(self, reports, poses):
        board = npss.leaderboard(reports)
        assert set(board.tidy["blocks"]) == {5}
        assert board.tidy["p_value"].isna().all()
        assert list(board.tidy["behind"].dropna()) == [1.0]
        assert set(board.tidy["interval"]) == {"range of blocks"}
        text = board.to_text()
        far = board.tidy.set_index("model").loc["far"]
        assert f"({far.in_blocks:.3f}: range {far.low:.3f}–{far.high:.3f}, 5/5)" in text
        assert "all: 5 blocks, 1 of 8 sequences in none." in text
        assert "the best is better in 4 of 5 blocks" in text
        for written in (board.to_markdown(), board.to_html()):
            assert f"range {far.low:.3f}–{far.high:.3f}, 5/5" in written
        assert f"range {far.low:.3f}--{far.high:.3f}, 5/5" in board.to_latex()

    def test_given_ones_come_before_those_stated(self, reports):
        board = npss.leaderboard(reports, groups=[*"abcdef", "f", "f"])
        assert set(board.tidy["blocks"]) == {6}
        assert board.tidy["p_value"].max() == 2 / 2**6
        by_action = npss.leaderboard({"a": {"walking": reports["close"]}}, groups={"walking": [*"aabbccdd"]})
        assert set(by_action.tidy["blocks"]) == {4}

    def test_of_files(self, folder):
        board = npss.leaderboard(folder, groups={"walking": LABELS})
        blocks = board.tidy.groupby("action")["blocks"].unique()
        assert (list(blocks["walking"]), list(blocks["eating"])) == ([5], [8])
        text = board.to_text()
        assert "eating: 8 sequences, each its own block, assumed independent." in text
        assert "walking: 5 blocks, 1 of 8 sequences in none." in text

    def test_protocols_know_theirs(self, folder):
        board = npss.leaderboard(folder / "close.npz", protocol="srnn-8")
        blocks = board.tidy.groupby("action")["blocks"].unique()
        assert list(blocks["walking"]) == [7]  # of 50 frames, two windows still overlap
        with pytest.raises(ValueError, match="eating: the protocol random-256 has 256 windows, got 8 sequences"):
            npss.leaderboard(folder, protocol="random-256")

    def test_invalid_groups(self, folder, reports):
        with pytest.raises(ValueError, match="groups: unknown action 'sitting'; expected one of eating, walking"):
            npss.leaderboard(folder, groups={"sitting": LABELS})
        with pytest.raises(TypeError, match="groups: expected labels for each action: eating, walking"):
            npss.leaderboard(folder, groups=LABELS)
        with pytest.raises(ValueError, match="groups: all: expected 8 labels, one for each sequence, got 3"):
            npss.leaderboard(reports, groups=["a", "b", "c"])
        with pytest.raises(TypeError, match="groups: all: expected text, a whole number, or None for no block"):
            npss.leaderboard(reports, groups=[0.5] * 8)
        for single in ("abcdefgh", 5, {"": "abcdefgh"}):
            with pytest.raises(TypeError, match="groups: all: expected a sequence of labels, got"):
                npss.leaderboard(reports, groups=single)

    def test_labels_that_can_be_read_once(self, reports):
        for groups in (iter(LABELS), {"": iter(LABELS)}):
            assert set(npss.leaderboard(reports, groups=groups).tidy["blocks"]) == {5}

    def test_of_numbers_without_sequences(self, poses):
        from npss.records import measure

        record = {"model": "m", "action": "a", **measure(poses["gt"][..., ANGLES], poses["far"][..., ANGLES])}
        with pytest.raises(ValueError, match="groups: a: the values of single sequences are unknown"):
            npss.leaderboard([record], groups=LABELS)

    def test_files_of_groups(self, capsys, tmp_path, folder):
        path = tmp_path / "groups.json"
        path.write_text(json.dumps({"walking": LABELS}), encoding="utf-8")
        assert main(["leaderboard", str(folder), "--groups", str(path)]) == 0
        assert capsys.readouterr().out == npss.leaderboard(folder, groups={"walking": LABELS}).to_text() + "\n"
        for text in ("{", "[1]", '{"walking": "aab"}', "[" * 100_000):
            path.write_text(text, encoding="utf-8")
            assert main(["leaderboard", str(folder), "--groups", str(path)]) == 2
            assert re.match(r"npss: error: .*groups\.json: (invalid JSON|expected an object)", capsys.readouterr().err)

    def test_records_that_contradict_themselves(self, reports, poses):
        from npss.records import measure

        gt, pred = (poses[name][..., ANGLES] for name in ("gt", "far"))
        record = {"model": "m", "action": "a", **measure(gt, pred, sequences=True, groups=LABELS, frames=50)}
        again = json.loads(json.dumps(record))
        assert set(npss.leaderboard([again]).tidy["blocks"]) == {5}
        old = json.loads(json.dumps(record))
        del old["sequences"]["groups"], old["sequences"]["statistics"], old["sequences"]["fingerprint"]
        board = npss.leaderboard([old])  # by the rules of its time
        assert "a: 8 sequences, each its own block, assumed independent." in board.notes
        with pytest.raises(ValueError, match="were scored in different blocks"):
            npss.leaderboard([again, {**old, "model": "old"}])
        for bad, message in (
            (LABELS[1:], "groups: expected 8 labels"),
            ([1.5] * 8, "groups: expected text"),
            ("a", "groups"),
        ):
            again["sequences"]["groups"] = bad
            with pytest.raises(ValueError, match=f"records: 'm' on 'a': sequences: {message}"):
                npss.leaderboard([again])
        again["sequences"]["statistics"] = 3
        with pytest.raises(ValueError, match="expected a version from 1 to 2, got 3"):
            npss.leaderboard([again])


class TestPublished:
    def record(self, **changed):
        stated = {"representation": "euler", "frames": 100, "fps": 25, "protocol": "srnn-8", "unwrap": "off"} | changed
        return {
            "model": "mine",
            "action": "walking",
            "npss": {"paper": 2.0, "released": 0.5},
            "signature": npss.signature(("paper", "released"), **stated),
        }

    def test_published_rows_are_shown(self):
        board = npss.leaderboard([self.record()], published=True)
        assert board.loc["VGRU-d (published)", ("walking", "NPSS released")] == 0.887
        assert board["walking", "NPSS paper"].notna().sum() == 1  # of which nothing was published
        theirs = board.tidy[board.tidy.model == "VGRU-d"]
        assert theirs["rank"].isna().all()
        assert not theirs["best"].any()
        assert theirs["source"].str.contains("Gopalakrishnan").all()
        assert "Gopalakrishnan" in board.to_markdown()

    @pytest.mark.parametrize(
        ("changed", "difference"),
        [
            ({"frames": 50}, "frames must be 100, not 50"),
            ({"protocol": "random-256"}, "protocol must be srnn-8, not random-256"),
            ({"unwrap": "target", "fps": 50}, "fps must be 25, not 50; unwrap must be off, not target"),
            ({"draws": 3}, "draws must not be stated, but is 3"),
        ],
    )
    def test_none_of_another_meaning(self, changed, difference):
        message = f"^published: no published number means the same as yours: NPSS released of mine: {difference}$"
        with pytest.raises(ValueError, match=message):
            npss.leaderboard([self.record(**changed)], published=True)

    def test_reports_of_in_betweening(self, monkeypatch):
        """The action follows from the signature; what is not stated is named."""
        from npss.protocol import _claims, _verify

        monkeypatch.setattr(_claims, "verify", lambda gt, name, fps: _verify.Verification(protocol=name))
        motion = npss.rotations.continuous(np.random.default_rng(0).normal(size=(2, 3, 30, 22, 4)), axis=2)
        report = npss.report(*motion, convention="released", **npss.protocol.lafan1.fields())
        for source in ({"mine": report}, {"mine": {"in-betweening, 30 frames": report}}):
            board = npss.leaderboard(source, published=True)
            assert board.loc["interpolation (published)", ("in-betweening, 30 frames", "NPSS released")] == 0.2013
        with pytest.raises(ValueError, match=r"mine: the action must be 'in-betweening, 30 frames', not 'walking'$"):
            npss.leaderboard({"mine": {"walking": report}}, published=True)
        fields = npss.protocol.lafan1.fields()
        del fields["unwrap"]
        report = npss.report(*motion, convention="released", **fields)
        with pytest.raises(ValueError, match=r"NPSS released of mine: unwrap must be off, but is not stated$"):
            npss.leaderboard({"mine": report}, published=True)
        report = npss.report(*motion, **fields)
        with pytest.raises(ValueError, match=r"means the same as yours: theirs are NPSS released, "):
            npss.leaderboard({"mine": report}, published=True)

    def test_other_actions_have_none(self):
        with pytest.raises(ValueError, match="published: no published number"):
            npss.leaderboard([{**self.record(), "action": "posing"}], published=True)


class Cells(html.parser.HTMLParser):
    """The cells of the tables of a page."""

    def __init__(self):
        super().__init__()
        self.tables, self.open = [], []

    def handle_starttag(self, tag, attrs):
        if tag == "br":
            return
        self.open.append(tag)
        if tag == "table":
            self.tables.append([])
        if tag == "tr":
            self.tables[-1].append([])
        if tag in ("td", "th"):
            self.tables[-1][-1].append("")

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if "td" in self.open or "th" in self.open:
            self.tables[-1][-1][-1] += data if "small" not in self.open else ""


class TestWritten:
    def test_text(self, board):
        text = board.to_text()
        row = next(line for line in text.splitlines() if re.match(r" +1  close ", line))
        value = board.loc["close", ("walking", "NPSS paper")]
        assert f"{value:.3f}*" in row
        marked = next(line for line in text.splitlines() if re.match(r" +3  far_\$off", line))
        assert "†" in marked
        for signature in board.tidy["signature"].unique():
            assert signature in text
        assert "Cite A. Gopalakrishnan" in text
        eating, walking = text.split("walking (ranked")
        assert "half & half" in walking
        assert "half & half" not in eating  # it has no numbers there

    def test_digits(self, board):
        value = board.loc["close", ("walking", "NPSS paper")]
        assert f"{value:.5f}*" in board.to_text(digits=5)

    def test_markdown_tables_are_regular(self, board):
        lines = board.to_markdown().splitlines()
        tables = [list(rows) for is_row, rows in itertools.groupby(lines, lambda line: line.startswith("|")) if is_row]
        assert len(tables) == 2
        for rows in tables:
            assert len({row.replace("\\|", "").count("|") for row in rows}) == 1
        assert "far\\_\\$off" in tables[0][2]  # in eating, the better one
        assert "**" in tables[0][2]

    def test_latex_is_escaped_and_balanced(self, board):
        text = board.to_latex()
        assert "far\\_\\$off" in text
        assert "half \\& half" in text
        assert text.count("\\begin{table}") == text.count("\\end{table}") == 2
        assert text.count("\\toprule") == text.count("\\bottomrule") == 4  # NPSS and Euler error
        widths = []
        for line in text.splitlines():
            if line.startswith("\\begin{tabular}"):
                widths.append(line.count("r", len("\\begin{tabular}")))
            if line.endswith("\\\\"):
                assert len(re.findall(r"(?<!\\)&", line)) == widths[-1]
        assert widths == [4, 7, 4, 7]
        assert "\\tiny" in text
        bare = re.sub(r"\\[&%$#_{}]", "", text.replace("\\textbackslash{}", ""))
        assert bare.count("{") == bare.count("}")
        assert not re.search(r"[†–∞]|\|(?!\\allowbreak)", text)
        assert "\\textbf{" in text
        assert "\\textsuperscript{\\dag}" in text

    def test_latex_states_the_blocks_of_its_actions(self, board):
        text = board.to_latex()
        for table, action in zip(text.split("\\end{table}"), ("eating", "walking"), strict=False):
            assert f"{action}: " in table or f"{action}, " in table or f", {action}: " in table
            assert "assumed independent. Inferred: other blocks of this kind" in table
        assert r"\caption{Mine. " in board.to_latex(caption="Mine")
        assert board.to_latex(caption="") == text

    def test_published_rows_follow_a_rule_in_latex(self):
        board = npss.leaderboard([TestPublished().record()], published=True)
        lines = board.to_latex().splitlines()
        first = next(i for i, line in enumerate(lines) if "\\textit{" in line)
        assert lines[first - 1] == "\\midrule"
        assert sum(line.startswith("In italics: published. Published numbers, not ranked: ") for line in lines) == 1
        assert '<tr class="published">' in board.to_html()

    def test_html_holds_the_same_numbers_and_escapes_names(self, board):
        cells = Cells()
        cells.feed(board.to_html())
        assert not cells.open
        assert len(cells.tables) == 2
        for table in cells.tables:
            assert len({len(row) for row in table}) == 1
        by_model = {row[0]: row for table in cells.tables for row in table if row[1] == "1"}
        assert by_model["close"][2].startswith(f"{board.loc['close', ('walking', 'NPSS paper')]:.3f}")
        assert "half & half" not in board.to_html()
        assert "half &amp; half" in board.to_html()

    def test_published_numbers_have_no_more_digits_than_were_published(self):
        board = npss.leaderboard([TestPublished().record()], published=True)
        row = next(line for line in board.to_text(digits=5).splitlines() if "VGRU-d (published)" in line)
        assert row.split()[-1] == "0.887"

    def test_names_cannot_break_a_table(self):
        hostile = {**TestPublished().record(), "model": "a|b\n<script>&_$x$", "action": "walk|\n\n_<b>&"}
        board = npss.leaderboard([hostile, {**hostile, "model": "other"}])
        rows = [line for line in board.to_markdown().splitlines() if line.startswith("|")]
        assert len(rows) == 4
        assert len({row.replace("\\|", "").count("|") for row in rows}) == 1
        assert "<" not in board.to_markdown().replace("\\<", "")
        assert "### walk\\| \\_\\<b\\>&amp;" in board.to_markdown()
        assert "a\\textbar{}b \\textless{}script\\textgreater{}\\&\\_\\$x\\$" in board.to_latex()
        assert "\n\n" not in board.to_latex().replace("\n\n\\begin", "")
        assert "<script>" not in board.to_html()

    def test_csv_is_unrounded(self, board, tmp_path):
        rows = list(csv.DictReader(io.StringIO(board.to_csv())))
        assert [float(row["value"]) for row in rows] == list(board.tidy["value"])
        board.to_csv(tmp_path / "board.csv")
        assert (tmp_path / "board.csv").read_text(encoding="utf-8") == board.to_csv()

    def test_an_infinite_end_is_written(self, poses):
        # Of ten blocks nine are the same: many draws have no spread, and know of no error.
        rows = [0] * 9 + [1]
        reports = {
            name: npss.report(*(poses[which][rows][..., ANGLES] for which in ("gt", name))) for name in ("close", "far")
        }
        board = npss.leaderboard(reports)
        assert "–∞)" in board.to_text()
        assert "--$\\infty$" in board.to_latex()


class TestCommands:
    @pytest.mark.parametrize("form", ["text", "markdown", "latex", "html", "csv"])
    def test_prints_what_the_function_returns(self, capsys, folder, form, board):
        assert main(["leaderboard", str(folder), "--protocol", "mine", "--format", form]) == 0
        assert capsys.readouterr().out == getattr(board, f"to_{form}")() + "\n"

    def test_errors_are_one_line(self, capsys, folder):
        assert main(["leaderboard", str(folder), "--published"]) == 2
        assert capsys.readouterr().err.startswith("npss: error: --published: no published number means the same")

    def test_baselines_and_files_on_the_same_windows(self, capsys, tmp_path):
        from npss_baselines.__main__ import main as baselines
        from npss_baselines.data.synthetic import synthetic_task

        task = synthetic_task()
        file = write(tmp_path / "perfect.npz", task.target, {"gait": task.target, "other": task.target})
        assert baselines(["leaderboard", "zero-velocity", str(file), "--synthetic", "--format", "csv"]) == 0
        rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
        assert {row["action"] for row in rows} == {"gait"}
        paper = {row["model"]: row for row in rows if row["column"] == "NPSS paper"}
        assert float(paper["perfect"]["value"]) == 0
        assert paper["perfect"]["rank"] == "1"
        assert paper["zero-velocity"]["worse"] == "True"

    def test_files_of_other_windows(self, capsys, tmp_path):
        from npss_baselines.__main__ import main as baselines
        from npss_baselines.data.synthetic import synthetic_task

        target = synthetic_task().target
        moved = write(tmp_path / "moved.npz", target + 0.1, {"gait": target})
        assert baselines(["leaderboard", str(moved), "--synthetic"]) == 2
        assert "the ground truths of 'the test windows' and 'moved' differ" in capsys.readouterr().err
        other = write(tmp_path / "other.npz", target, {"walking": target})
        assert baselines(["leaderboard", str(other), "--synthetic"]) == 2
        assert "'other' has none of the actions gait" in capsys.readouterr().err
        assert baselines(["leaderboard", "zero-veloctiy", "--synthetic"]) == 2
        assert "'zero-veloctiy' is neither one of" in capsys.readouterr().err


def test_one_command_ranks_baselines_and_sample_models(capsys, h36m_root, samples_root):
    """The samples are of the published windows, so the baselines stand beside them, with their known scores."""
    from npss_baselines.__main__ import main as baselines

    files = [str(samples_root / name) for name in ("wookay_walking_10000.h5", "wookay_eating_1000.h5")]
    command = ["leaderboard", "zero-velocity", "repeat-50", *files, "--h36m", str(h36m_root)]
    assert baselines([*command, "--actions", "walking", "eating", "--format", "csv"]) == 0
    rows = list(csv.DictReader(io.StringIO(capsys.readouterr().out)))
    values = {(row["model"], row["action"], row["column"]): float(row["value"]) for row in rows}
    known = {
        ("zero-velocity", "walking", "NPSS paper"): 2.3341,
        ("zero-velocity", "eating", "NPSS released"): 0.8677,
        ("repeat-50", "walking", "NPSS released"): 0.8283,
        ("repeat-50", "eating", "NPSS paper"): 1.8136,
    }
    for key, value in known.items():
        assert values[key] == pytest.approx(value, abs=5e-5)
    assert ("wookay_eating_1000", "walking", "NPSS paper") not in values
    assert {(row["action"], row["blocks"]) for row in rows} == {("walking", "6"), ("eating", "5")}
    behind = {(row["model"], row["action"], row["column"]): row["behind"] for row in rows}
    assert behind["zero-velocity", "eating", "NPSS paper"] == "1.0"  # in all five blocks, which is no claim
    assert not any(row["worse"] == "True" for row in rows)  # nor can six blocks tell three models apart
    assert {row["rank"] for row in rows} == {"1"}
    assert {row["p_value"] for row in rows if row["action"] == "eating"} == {""}


class TestReference:
    """Rows that this project measured, beside one's own."""

    def record(self, **changed):
        (row,) = (row for row in published.reference() if (row["model"], row["action"]) == ("zero-velocity", "walking"))
        own = {name: row[name] for name in ("action", "npss", "npss_windows", "euler_error", "signature", "signatures")}
        return {**own, "model": "mine", **changed}

    def test_they_are_marked_and_not_ranked(self):
        board = npss.leaderboard([self.record()], reference=True)
        assert {"mine", "zero-velocity (reference)", "repeat-50 (reference)"} <= set(board.index)
        assert board.loc["repeat-50 (reference)", ("walking", "NPSS released")] == pytest.approx(0.828, abs=5e-4)
        ranks = board.tidy.groupby("model")["rank"].first()
        assert ranks["mine"] == 1
        assert ranks.drop("mine").isna().all()
        assert any(note.startswith("Reference numbers, not ranked: npss-baselines, recipe") for note in board.notes)
        assert not any(note.startswith("Published numbers") for note in board.notes)

    def test_beside_published_rows_of_the_same_name(self):
        board = npss.leaderboard([self.record()], reference=True, published=True)
        assert {"zero-velocity (reference)", "zero-velocity (published)"} <= set(board.index)
        assert "In italics: published and reference. " in board.to_latex()
        text = board.to_text()
        assert text.index("mine") < text.index("(published)") < text.index("(reference)")

    def test_draws_do_not_hide_them(self, monkeypatch):
        own = self.record()
        meaning = own["signature"]
        noisy = {**own, "model": "noisy", "source": "elsewhere", "reference": True, "signature": f"{meaning}|draws:30"}
        monkeypatch.setattr(published, "reference", lambda: [noisy])
        board = npss.leaderboard([own], reference=True)
        assert "noisy (reference)" in board.index
        assert "draws:30" in board.to_text()
        drawn = {**own, "signature": f"{meaning}|draws:5"}
        assert "noisy (reference)" in npss.leaderboard([drawn], reference=True).index

    def test_a_name_that_is_taken(self):
        with pytest.raises(ValueError, match=r"'zero-velocity \(reference\)' is the name of a reference model"):
            npss.leaderboard([self.record(model="zero-velocity (reference)")], reference=True)

    def test_other_windows_have_none(self):
        signature = self.record()["signature"].replace("srnn-8", "random-256")
        with pytest.raises(ValueError, match=r"reference: no reference number means the same as yours: .*srnn-8"):
            npss.leaderboard([self.record(signature=signature)], reference=True)

    def test_on_the_command_line(self, tmp_path, capsys):
        path = tmp_path / "records.json"
        path.write_text(json.dumps([self.record()]), encoding="utf-8")
        assert main(["leaderboard", str(path), "--reference"]) == 0
        assert "zero-velocity (reference)" in capsys.readouterr().out
