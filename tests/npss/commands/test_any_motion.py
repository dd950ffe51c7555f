"""The commands on results of any motion: the same numbers as functions, and what they refuse."""

import json

import numpy as np
import pytest

import npss
from npss.commands._main import main

FPS, PARENTS = 30, [-1, 0, 1, 2, 0]


@pytest.fixture
def results(tmp_path):
    """A folder with the results of two models: one as a file, one as a folder of arrays."""
    rng = np.random.default_rng(0)
    gt = rng.normal(size=(8, 30, 5, 3)).cumsum(axis=1)
    meta = {"representation": "positions", "fps": FPS, "unit": "cm", "parents": PARENTS, "protocol": "mine"}
    preds = {model: gt + size * rng.normal(size=gt.shape).cumsum(axis=1) for model, size in (("a", 0.1), ("b", 0.5))}
    folder = tmp_path / "results"
    (folder / "b").mkdir(parents=True)
    np.savez(folder / "a.npz", **{"walk/gt": gt, "walk/pred": preds["a"], "meta": json.dumps(meta)})
    np.save(folder / "b" / "walk_gt.npy", gt)
    np.save(folder / "b" / "walk_pred.npy", preds["b"])
    (folder / "b" / "meta.json").write_text(json.dumps(meta), encoding="utf-8")
    return folder, gt, preds


def run(capsys, *arguments):
    status = main([str(argument) for argument in arguments])
    return status, *capsys.readouterr()


def test_score(results, capsys):
    folder, gt, preds = results
    for model, path in (("a", folder / "a.npz"), ("b", folder / "b")):
        status, out, _ = run(capsys, "score", path, "--format", "json")
        (record,) = json.loads(out)
        assert (status, record["action"]) == (0, "walk")
        assert record["npss"] == {name: npss.score(gt, preds[model], convention=name) for name in npss.CONVENTIONS}
        assert record["signatures"]["paper"] == npss.signature(
            "paper", representation="positions", frames=30, fps=30, protocol="mine", unwrap="off"
        )
    status, _, err = run(capsys, "score", folder / "a.npz", "--protocol", "theirs")
    assert status == 2
    assert "protocol: the file states 'mine', not 'theirs'" in err
    assert "a meta states what results are" in run(capsys, "score", folder / "a.npz", "--fps", "25")[2]


def test_samples_are_scored_by_every_reduction(results, capsys, tmp_path):
    folder, gt, preds = results
    samples = np.stack([preds["a"], preds["b"], gt])
    stored = dict(np.load(folder / "a.npz"))
    np.savez(tmp_path / "a.npz", **stored, **{"walk/samples": samples})
    (record,) = json.loads(run(capsys, "score", tmp_path / "a.npz", "--format", "json")[1])
    assert len(record["samples"]) == 9
    for one in record["samples"]:
        expected = npss.stochastic.score(gt, samples, reduction=one["reduction"], convention=one["convention"])
        assert one["npss"] == expected
        assert "|draws:3|" in one["signature"]
        assert f"|reduction:{one['reduction']}" in one["signature"]
    text = run(capsys, "score", tmp_path / "a.npz", "--convention", "released")[1]
    assert "NPSS, best of 3 samples" in text
    assert "not for the samples of walk" in run(capsys, "score", tmp_path / "a.npz", "--unwrap", "target")[2]


def test_score_of_euler_angles_has_their_error(tmp_path, capsys):
    gt, noise = np.random.default_rng(1).normal(size=(2, 4, 25, 6)).cumsum(axis=2) / 20
    meta = json.dumps({"representation": "euler", "fps": 25})
    np.savez(tmp_path / "a.npz", gt=gt, pred=gt + noise, meta=meta)
    (record,) = json.loads(run(capsys, "score", tmp_path / "a.npz", "--format", "json")[1])
    expected = npss.euler_error(gt, gt + noise, fps=25, at_ms=(80, 160, 320, 400, 560, 1000))
    assert record["euler_error"] == {f"{time:g}": value for time, value in expected.items()}


def test_compare(results, capsys):
    folder, gt, preds = results
    status, out, _ = run(capsys, "compare", folder / "a.npz", folder / "b", "--format", "json")
    records = json.loads(out)
    assert (status, len(records)) == (0, 3)
    for record, convention in zip(records, npss.CONVENTIONS, strict=True):
        expected = npss.compare(gt, preds["a"], preds["b"], convention=convention)
        assert record["difference"] == expected.difference
        assert record["interval"] == list(expected.interval())
        assert record["p_value"] == expected.p_value
        assert f"convention:{convention}|representation:positions" in record["signature"]
    text = run(capsys, "compare", folder / "a.npz", folder / "b", "--convention", "released")[1]
    assert text.startswith("a: a\nb: b\n\nwalk, released\n")
    assert "p = 0.00781" in text  # all eight blocks: 2 / 2**8
    groups = folder.parent / "groups.json"
    groups.write_text(json.dumps({"walk": list("aabbccdd")}), encoding="utf-8")
    out = run(capsys, "compare", folder / "a.npz", folder / "b", "--groups", groups, "--format", "json")[1]
    assert {(one["blocks"], one["p_value"], one["interval"]) for one in map(_hashable, json.loads(out))} == {
        (4, None, None)
    }


def _hashable(record):
    return {
        name: tuple(value) if isinstance(value, list) else str(value) if isinstance(value, dict) else value
        for name, value in record.items()
    }


def test_compare_refuses(results, capsys, tmp_path):
    folder, gt, preds = results
    assert "duplicate" in run(capsys, "compare", folder / "a.npz", folder / "a.npz")[2]
    assert (
        "mse has none"
        in run(capsys, "compare", folder / "a.npz", folder / "b", "--metric", "mse", "--convention", "paper")[2]
    )
    other = tmp_path / "c.npz"
    np.savez(other, **dict(np.load(folder / "a.npz")))
    assert "expected the results of two models, got 3: a, b, c" in run(capsys, "compare", folder, other)[2]
    np.savez(other, **{"run/gt": gt, "run/pred": preds["b"]})
    assert "only one of 'a' and 'c' has run, walk" in run(capsys, "compare", folder / "a.npz", other)[2]
    np.savez(other, **{"walk/gt": gt, "walk/pred": preds["b"]})
    assert (
        "the ground truths of 'a' and 'c' differ (representation of their meta)"
        in run(capsys, "compare", folder / "a.npz", other)[2]
    )
    np.savez(
        other,
        **{
            "walk/gt": gt[::-1],
            "walk/pred": preds["b"],
            "meta": json.dumps({"representation": "positions", "fps": 30}),
        },
    )
    assert "the ground truths of 'a' and 'c' differ (by up to" in run(capsys, "compare", folder / "a.npz", other)[2]
    small = [tmp_path / "d.npz", tmp_path / "e.npz"]
    for path, motion in zip(small, (1e-6 * gt, 1e-6 * gt[::-1]), strict=True):  # of a large unit
        np.savez(path, gt=motion, pred=1e-6 * preds["b"])
    assert "the ground truths of 'd' and 'e' differ (by up to" in run(capsys, "compare", *small)[2]


def test_positions_have_their_errors_in_millimetres(results, capsys):
    pytest.importorskip("pandas")
    folder, gt, preds = results
    expected = npss.position_error(10 * gt, 10 * preds["a"], fps=FPS, at_ms=(400, 1000))
    (record,) = json.loads(run(capsys, "score", folder / "a.npz", "--metrics", "position_error", "--format", "json")[1])
    assert [*record["metrics"].values()] == [expected[400], expected[1000]]
    assert "euler_error" not in record
    heading = next(iter(record["metrics"]))
    assert "|root:given" in record["signatures"][heading]
    status, out, _ = run(capsys, "leaderboard", folder, "--metrics", "position_error", "--format", "csv")
    assert status == 0
    assert repr(expected[400])[:12] in out
    options = ["--metric", "position_error", "--at-ms", "400", "--format", "json"]
    (record,) = json.loads(run(capsys, "compare", folder / "a.npz", folder / "b", *options)[1])
    other = npss.position_error(10 * gt, 10 * preds["b"], fps=FPS, at_ms=(400,))
    assert record["difference"] == pytest.approx(expected[400] - other[400], rel=1e-12)


def test_other_motion_has_no_positions(tmp_path, capsys):
    gt, noise = np.random.default_rng(1).normal(size=(2, 4, 25, 6)).cumsum(axis=2) / 20
    for meta, got in (({"representation": "euler", "fps": 25}, "'euler' and None"), ({"fps": 25}, "None and None")):
        np.savez(tmp_path / "a.npz", gt=gt, pred=gt + noise, meta=json.dumps(meta))
        error = run(capsys, "score", tmp_path / "a.npz", "--metrics", "position_error")[2]
        assert "metrics: position_error: it takes positions: a meta with the representation 'positions'" in error
        assert got in error


def test_diagnose(results, capsys, tmp_path):
    folder, gt, _ = results
    status, out, _ = run(capsys, "diagnose", folder / "a.npz", "--format", "json")
    assert status == 0
    (record,) = json.loads(out)
    assert record["condition"] == "walk"
    flat = gt.reshape(8, 30, 15)
    np.save(tmp_path / "gt.npy", flat)
    np.save(tmp_path / "pred.npy", np.repeat(flat[:, :1], 30, axis=1))
    text = run(capsys, "diagnose", tmp_path / "gt.npy", tmp_path / "pred.npy")[1]
    expected = npss.diagnose(flat, np.repeat(flat[:, :1], 30, axis=1))
    assert text.splitlines() == [f"{len(expected)} findings", *(f"- {finding}" for finding in expected)]
    assert {finding.pitfall for finding in expected} >= {"constant"}
    assert "leave out --key" in run(capsys, "diagnose", folder / "a.npz", "--key", "x")[2]
    assert "got 3 files" in run(capsys, "diagnose", "a", "b", "c")[2]


def test_leaderboard(results, capsys):
    pytest.importorskip("pandas")
    folder, gt, preds = results
    status, out, _ = run(capsys, "leaderboard", folder)
    assert status == 0
    for model, pred in preds.items():
        assert f"{model}      {npss.score(gt, pred):.3f}" in out
    assert "npss|version:1|convention:paper|representation:positions|frames:30|fps:30|protocol:mine|unwrap:off" in out


def test_options_of_tables(results, capsys):
    pytest.importorskip("pandas")
    folder, *_ = results
    text = run(capsys, "leaderboard", folder, "--columns", "NPSS released", "--wide")[1]
    assert text.startswith("NPSS released (ranked by walk)")
    assert "NPSS paper" not in text
    options = ["--format", "latex", "--caption", "Mine.", "--label", "tab:mine"]
    text = run(capsys, "leaderboard", folder, *options)[1]
    assert "\\caption{Mine. walk" in text
    assert "\\label{tab:mine}" in text
    assert "--label: only with --format latex" in run(capsys, "leaderboard", folder, "--label", "x")[2]
    assert "--wide: not with --format csv" in run(capsys, "leaderboard", folder, "--wide", "--format", "csv")[2]
    text = run(capsys, "leaderboard", folder, "--edges-ms", "0", "500", "1000", "--columns", "NPSS literal")[1]
    assert "NPSS literal 0-0.5 s" in text


def test_a_protocol_may_be_stated_twice(results, capsys):
    folder, *_ = results
    assert run(capsys, "score", folder / "a.npz", "--protocol", "mine")[0] == 0


def test_other_features_are_not_those_of_lafan1(tmp_path, capsys):
    gt, noise = np.random.default_rng(1).normal(size=(2, 4, 30, 6)).cumsum(axis=2)
    np.savez(tmp_path / "a.npz", gt=gt, pred=gt + noise, meta=json.dumps({"protocol": "lafan1", "fps": 30}))
    (record,) = json.loads(run(capsys, "score", tmp_path / "a.npz", "--format", "json")[1])
    assert record["verification"]["ok"] is False
    assert "|verified:no" in record["signatures"]["released"]


def test_report(results, capsys, tmp_path):
    pytest.importorskip("pandas")
    pytest.importorskip("matplotlib")
    folder, *_ = results
    page = tmp_path / "report.html"
    assert run(capsys, "report", folder, "-o", page)[0] == 0
    text = page.read_text(encoding="utf-8")
    assert f'"fps":{FPS:.1f}' in text
    assert 'class="field"' in text  # the player
    meta = json.dumps({"representation": "positions", "fps": FPS})
    stored = dict(np.load(folder / "a.npz"))
    np.savez(tmp_path / "a.npz", **{**stored, "meta": meta})
    assert run(capsys, "report", tmp_path / "a.npz", "-o", page)[0] == 0
    text = page.read_text(encoding="utf-8")
    assert "no moving figures: no parents, unit" in text
    assert 'id="player"' not in text
    np.savez(tmp_path / "a.npz", **{**stored, "meta": "{}"})
    assert run(capsys, "report", tmp_path / "a.npz", "-o", page)[0] == 0
    assert "no spectra: no fps" in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("command", ["score", "compare", "leaderboard"])
def test_every_command_verifies_the_protocol_that_a_file_states(command, capsys, tmp_path):
    if command == "leaderboard":
        pytest.importorskip("pandas")
    angle = np.random.default_rng(0).normal(size=(8, 30, 22)).cumsum(axis=1) / 9
    gt = np.stack([np.cos(angle), np.sin(angle), 0 * angle, 0 * angle], axis=-1)
    meta = {"representation": "global-quaternions", "quaternions": "continuous", "fps": 30, "protocol": "lafan1"}
    name = "in-betweening, 30 frames"
    for model, step in (("a", 1), ("b", 2)):
        pred = npss.rotations.continuous(np.roll(gt, step, axis=1), axis=1)
        arrays = {"gt": gt, "pred": pred} | ({"samples": pred[np.newaxis]} if command == "score" else {})
        arrays = {f"{name}/{kind}": motion for kind, motion in arrays.items()}
        np.savez(tmp_path / f"{model}.npz", meta=json.dumps(meta), **arrays)
    files = [tmp_path / "a.npz", tmp_path / "b.npz"][: 1 if command == "score" else 2]
    status, out, _ = run(capsys, command, *files)
    signatures = [line for line in out.splitlines() if "|protocol:lafan1|" in line]
    assert (status, len(signatures) >= 3) == (0, True)
    for signature in signatures:
        assert "|unwrap:off|" in signature or command == "compare"
        assert "|verified:no" in signature
    if command == "leaderboard":
        assert "verified must not be stated, but is no" in run(capsys, command, *files, "--published")[2]
