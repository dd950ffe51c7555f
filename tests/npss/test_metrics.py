"""The registry of metrics: invalid entries, and custom metrics everywhere that NPSS is."""

import json
import pickle
import re

import numpy as np
import pytest

import npss
from npss._metric.registry import EULER_ERROR, MSE, NPSS, score_heading
from npss.commands import main
from npss.commands._votes import text as votes_text
from npss.metrics import METRICS, Metric, register
from npss.ranking._results import results_of_record
from npss.records import measure, signature_of, summary
from npss.skeleton import poses_to_positions
from npss.study import Question, Vote, model_scores, rank
from npss.study._summary import summary as vote_summary
from pages import PROJECT, marked

pytestmark = pytest.mark.usefixtures("registry")
PAGE = PROJECT / "docs" / "extending.md"
N, T = 8, 25


def poses(seed):
    return np.random.default_rng(seed).normal(scale=0.1, size=(N, T, 99)).cumsum(axis=1)


@pytest.fixture
def samples(tmp_path):
    """Files of three models' predictions, with increasing errors."""
    gt, noise = poses(0), poses(1)
    for name, size in (("near", 0.1), ("far", 1.0), ("afar", 2.0)):
        arrays = {}
        for i in range(N):
            arrays[f"expmap/gt/walking_{i}"] = gt[i]
            arrays[f"expmap/preds/walking_{i}"] = gt[i] + size * noise[i]
        np.savez(tmp_path / f"{name}.npz", **arrays)
    return tmp_path


@pytest.fixture
def page():
    """The example of the documentation, which registers a metric."""
    code = marked(PAGE, "file", "mpjpe.py")
    assert len(code.splitlines()) <= 32
    exec(compile(code, str(PAGE), "exec"), {})
    return METRICS["mpjpe"]


def mpjpe(gt, pred, frame):
    """Compute MPJPE with loops over sequences and joints."""
    truth, prediction = poses_to_positions(gt), poses_to_positions(pred)
    return [
        sum(np.sqrt(sum((a - b) ** 2)) for a, b in zip(truth[i, frame], prediction[i, frame], strict=True)) / 32
        for i in range(len(gt))
    ]


def metric(function=lambda gt, pred: np.abs(gt - pred).max(axis=(1, 2)), **entry):
    return Metric(**{"name": "mine", "function": function, "says": "a metric for tests"} | entry)


def motions(n=N, d=4):
    return np.random.default_rng(3).normal(size=(2, n, T, d)).cumsum(axis=2)


# --- entries ----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("entry", "error", "message"),
    [
        ({"name": "Mine"}, ValueError, "name: expected lower-case letters"),
        ({"name": "a+b"}, ValueError, "name: expected lower-case letters"),
        ({"name": ""}, ValueError, "name: expected lower-case letters"),
        ({"name": 1}, TypeError, "name: expected text"),
        ({"function": None}, TypeError, "function: expected a function"),
        ({"says": ""}, ValueError, "says: expected one line"),
        ({"says": None}, TypeError, "says: expected text"),
        ({"heading": "two\nlines"}, ValueError, "heading: expected one line"),
        ({"heading": " x"}, ValueError, "heading: expected one line"),
        ({"heading": "released"}, ValueError, "heading: 'released' is the name of a convention"),
        ({"name": "paper", "heading": "mine"}, ValueError, "name: 'paper' is the name of a convention"),
        ({"unit": 1}, TypeError, "unit: expected text"),
        ({"aggregation": "sum"}, ValueError, "aggregation: expected one of mean, weighted mean, none"),
        ({"takes": "meshes"}, ValueError, "takes: expected one of angles, poses, positions"),
        ({"options": "fps"}, TypeError, "options: expected a tuple"),
        ({"options": ("seed",)}, ValueError, "options: expected one of"),
        ({"digits": -1}, ValueError, "digits: expected a whole number"),
        ({"digits": 1.5}, ValueError, "digits: expected a whole number"),
        ({"lower_is_better": 1}, TypeError, "lower_is_better: expected True or False"),
        ({"fields": ["a"]}, TypeError, "fields: expected a mapping"),
        ({"fields": {"a b": 1}}, ValueError, "fields: expected names of ASCII letters"),
        ({"fields": {"version": 2}}, ValueError, "fields: the signature states 'version' anyway"),
        ({"fields": {"better": "higher"}}, ValueError, "fields: the signature states 'better' anyway"),
        ({"fields": {"at_ms": 80}}, ValueError, "fields: the signature states 'at_ms' anyway"),
        ({"fields": {"frames": "many"}}, TypeError, "frames: expected a whole number"),
        ({"fields": {"threshold": [1]}}, TypeError, "fields: threshold: expected text"),
    ],
)
def test_invalid_entries(entry, error, message):
    with pytest.raises(error, match=f"^{re.escape(message)}"):
        metric(**entry)


def test_entries_cannot_be_changed():
    entry = metric(fields={"a": 1})
    with pytest.raises(AttributeError):
        entry.name = "other"
    with pytest.raises(TypeError):
        entry.fields["a"] = 2
    with pytest.raises(TypeError):
        METRICS["other"] = entry


def test_duplicates_are_refused():
    entry = register(metric())
    assert METRICS["mine"] is entry
    with pytest.raises(ValueError, match=r"^the metric 'mine' is registered already"):
        register(metric())
    with pytest.raises(ValueError, match=r"^metric: the heading 'mine' is ambiguous: 'mine' has the heading 'mine'"):
        register(metric(name="other", heading="mine"))
    with pytest.raises(TypeError, match=r"^metric: expected a Metric"):
        register(lambda gt, pred: 0)
    other = metric()
    assert register(other, replace=True) is other is METRICS["mine"]


@pytest.mark.parametrize("heading", ["NPSS", "NPSS mine", "Euler error 80 ms", "MSE"])
def test_ambiguous_headings(heading):
    with pytest.raises(ValueError, match=f"^metric: the heading '{heading}' is ambiguous"):
        register(metric(heading=heading))


@pytest.mark.parametrize("entry", [{"heading": "euler_error"}, {"heading": "mse"}, {"name": "g", "heading": "G"}])
def test_a_name_is_not_the_heading_of_another_metric(entry):
    register(metric(name="other", heading="g"))
    with pytest.raises(ValueError, match=r"^metric: '(euler_error|mse|g)' is ambiguous"):
        register(metric(**entry))


@pytest.mark.parametrize("name", ["npss", "euler_error", "mse"])
def test_built_in_metrics_are_never_replaced(name):
    with pytest.raises(ValueError, match=f"^the metric '{name}' is registered already"):
        register(metric(name=name), replace=True)


def test_headings_are_in_one_place():
    assert NPSS.column(convention="paper", window="0-1") == "NPSS paper 0-1 s"
    assert EULER_ERROR.column(at_ms=80) == EULER_ERROR.column(at_ms="80") == "Euler error 80 ms"
    assert [score_heading(name) for name in ("literal", "euler_error", "X")] == ["NPSS literal", "Euler error", "X"]
    assert (EULER_ERROR.labelled, NPSS.labelled) == ("Euler error (rad)", "NPSS")


# --- results of functions ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("result", "aggregation", "error", "message"),
    [
        (1.0, "mean", ValueError, "expected a number for each of 8 sequences, shape (8,), got ()"),
        (np.ones(7), "mean", ValueError, "expected a number for each of 8 sequences, shape (8,), got (7,)"),
        (np.ones((8, 1)), "mean", ValueError, "expected a number for each of 8 sequences"),
        (np.full(8, np.nan), "mean", ValueError, "nan at index (0,)"),
        ([1, 2, np.inf, 3, 4, 5, 6, 7], "mean", ValueError, "inf at index (2,)"),
        (np.arange(8) - 1.0, "mean", ValueError, "-1.0 at index (0,); expected numbers >= 0"),
        (np.ones(8) > 0, "mean", TypeError, "expected real numbers, got booleans"),
        (None, "mean", TypeError, "expected real numbers"),
        (np.full(8, 1e308), "mean", ValueError, "its sum over sequences is beyond float64"),
        ((np.ones(8), np.full(8, 1e308)), "weighted mean", ValueError, "its sum over sequences is beyond float64"),
        ((np.full(8, 1e200), np.full(8, 1e200)), "weighted mean", ValueError, "its sum over sequences is beyond"),
        (np.ones(8), "weighted mean", TypeError, "expected a tuple of numbers and weights"),
        ((np.ones(8), np.ones(3)), "weighted mean", ValueError, "weights: expected a number for each of 8 sequences"),
        ((np.ones(8), np.zeros(8)), "weighted mean", ValueError, "all weights are 0"),
        ((np.ones(8), -np.ones(8)), "weighted mean", ValueError, "weights: -1.0 at index (0,)"),
        (np.ones(8), "none", TypeError, "expected one number for all sequences"),
        ("1", "none", TypeError, "expected one number for all sequences"),
        (-1.0, "none", ValueError, "-1.0 at index (0,)"),
    ],
)
def test_invalid_results(result, aggregation, error, message):
    register(metric(lambda gt, pred: result, aggregation=aggregation))
    with pytest.raises(error, match=re.escape(message)) as raised:
        measure(*motions(), metrics=["mine"])
    assert str(raised.value).startswith("metric 'mine'")


def test_functions_receive_whole_read_only_sequences():
    seen = []

    def function(gt, pred):
        seen.append((gt.shape, gt.dtype, gt.flags.writeable, pred.flags.writeable))
        return np.zeros(len(gt))

    gt, pred = motions()
    register(metric(function))
    measure(gt[0].astype(np.float32), pred[0].astype(np.float32), metrics=["mine"])
    assert seen == [((1, T, 4), np.float64, False, False)]
    measure(gt, pred, metrics=["mine"])
    assert gt.flags.writeable
    with pytest.raises(ValueError, match=r"^pred: nan at index \(0, 0, 0\)"):
        METRICS["mine"].measure(gt, np.full_like(gt, np.nan))
    with pytest.raises(ValueError, match=r"^pred: its shape .* differs"):
        METRICS["mine"].measure(gt, pred[:1])


@pytest.mark.parametrize("values", [np.ones((2, 3)), np.ones((2, 3, 4)), np.ones((0, 3, 3)), np.ones((1, 1, 2, 3, 3))])
def test_invalid_positions(values):
    with pytest.raises(ValueError, match=r"^gt: expected positions \(N, T, J, 3\) or \(T, J, 3\)"):
        metric(takes="positions").measure(values, values)


def test_aggregations():
    gt, pred = motions()
    values, weights = np.arange(8.0), np.arange(8.0)[::-1]
    register(metric(lambda gt, pred: values))
    register(metric(lambda gt, pred: (values, weights), name="weighted", aggregation="weighted mean"))
    register(metric(lambda gt, pred: np.float64(2.5), name="whole", aggregation="none"))
    record = measure(gt, pred, metrics=["mine", "weighted", "whole"], sequences=True, frames=T)
    assert record["metrics"] == {"mine": 3.5, "weighted": np.average(values, weights=weights), "whole": 2.5}
    alone = json.loads(json.dumps(record["sequences"]))
    assert alone["metrics"]["mine"] == values.tolist()
    np.testing.assert_allclose(alone["metrics"]["weighted"], [*values[:-1], 0])  # the last has no weight
    assert alone["weight"]["weighted"] == weights.tolist()
    assert "mine" not in alone["weight"]
    assert "whole" not in alone["metrics"]
    results = {result.column: result for result in results_of_record({"model": "m", "action": "a", **record})}
    assert results["weighted"].value == pytest.approx(np.average(values, weights=weights))
    assert results["whole"].numerator is None


def test_mse_is_registered():
    gt, pred = motions()
    record = measure(gt, pred, metrics=["mse"], sequences=True)
    assert record["metrics"] == {"MSE": npss.mse(gt, pred)}
    assert record["sequences"]["metrics"]["MSE"] == [npss.mse(*pair) for pair in zip(gt, pred, strict=True)]
    assert npss.compare(gt, pred, gt * 0.5, metric="mse").a == npss.mse(gt, pred)
    assert npss.explain(record["signatures"]["MSE"]).startswith(f"MSE: {MSE.says}.")


# --- a custom metric, everywhere --------------------------------------------------------------------------------------


def test_records(page):
    gt, pred = poses(0), poses(1)
    angles = npss.poses_to_euler(gt), npss.poses_to_euler(pred)
    options = {"fps": 25, "representation": "euler", "frames": T, "protocol": "p", "extra": {"data": "v2"}}
    record = measure(*angles, at_ms=(80, 400.0), metrics=["mpjpe"], poses=(gt, pred), sequences=True, **options)
    for column, frame in (("MPJPE 80 ms", 1), ("MPJPE 400 ms", 9)):
        np.testing.assert_allclose(record["sequences"]["metrics"][column], mpjpe(gt, pred, frame), rtol=1e-12)
        np.testing.assert_allclose(record["metrics"][column], np.mean(mpjpe(gt, pred, frame)), rtol=1e-12)
    line = "mpjpe|version:1|frames:25|fps:25|protocol:p|at_ms:80|data:v2|root:fixed"
    assert record["signatures"]["MPJPE 80 ms"] == line
    assert npss.explain(line).startswith("MPJPE: the mean Euclidean distance between predicted and true joints")
    others = measure(*angles, at_ms=(80, 400.0), sequences=True, **options)
    del record["metrics"], record["sequences"]["metrics"]
    record["signatures"] = {name: record["signatures"][name] for name in others["signatures"]}
    assert record == others  # everything else is unchanged
    assert measure(*angles, metrics=["MPJPE"], poses=(gt, pred), at_ms=[80], fps=25)["metrics"].keys() == {
        "MPJPE 80 ms"
    }


@pytest.mark.parametrize(
    ("options", "error", "message"),
    [
        ({"metrics": ["nope"]}, ValueError, "metrics: unknown metric 'nope'; known: npss, euler_error, mse"),
        ({"metrics": [1]}, TypeError, "metrics: expected the name of a metric"),
        ({"metrics": "mse"}, TypeError, "metrics: expected a sequence of names"),
        ({"metrics": ["npss"]}, ValueError, "metrics: 'npss' is always measured, by each of the conventions"),
        ({"metrics": ["euler_error"]}, ValueError, "metrics: 'euler_error' is always measured, at the times of at_ms"),
        ({"metrics": ["mse", "MSE"]}, ValueError, "metrics: 'MSE' is a duplicate"),
        ({"metrics": ["mpjpe"], "at_ms": [80], "fps": 25}, ValueError, "metrics: 'mpjpe' takes positions; give"),
        ({"metrics": ["mpjpe"], "poses": (0, 0)}, ValueError, "metrics: 'mpjpe' is measured at the times of at_ms"),
        ({"metrics": ["timed"]}, ValueError, "fps: required by timed"),
        ({"metrics": ["spectral"]}, ValueError, "metrics: 'spectral' has conventions"),
        ({"metrics": ["known"], "extra": {"own": 1}}, TypeError, "own: the signature states it anyway; leave it out"),
        ({"metrics": ["known"], "manifold": "x"}, TypeError, "manifold: the signature states it anyway"),
    ],
)
def test_invalid_options_of_records(page, options, error, message):
    register(metric(name="timed", options=("fps",)))
    register(metric(name="spectral", options=("convention",)))
    register(metric(name="known", fields={"own": 2, "manifold": "m"}))
    with pytest.raises(error, match=f"^{re.escape(message)}"):
        measure(*motions(), **options)


def test_scores(page, samples, capsys):
    assert main(["score", str(samples / "near.npz"), "--metrics", "mpjpe", "mse", "--at-ms", "80"]) == 0
    printed = capsys.readouterr().out
    assert re.search(
        r"^MPJPE 80 ms +\d+\.\d  mpjpe\|version:1\|frames:25\|fps:25\|at_ms:80\|root:fixed$", printed, re.M
    )
    assert re.search(r"^MSE +0\.\d{4}  mse\|version:1\|representation:euler", printed, re.M)
    gt = str(samples / "gt.npy")
    np.save(gt, poses(0))
    assert main(["score", gt, gt, "--metrics", "mpjpe", "--at-ms", "80", "--fps", "25"]) == 2
    assert "metrics: 'mpjpe' takes positions; give poses" in capsys.readouterr().err
    assert main(["score", gt, gt, "--metrics", "mpjpe", "--at-ms", "80", "--fps", "25", "--expmap"]) == 0
    assert re.search(r"^MPJPE 80 ms +0\.0  ", capsys.readouterr().out, re.M)


def test_leaderboards(page, samples, capsys):
    board = npss.leaderboard(samples, metrics=["mpjpe", "mse"], by="MPJPE 400 ms")
    ranks = board.tidy.set_index(["column", "model"])["value"]
    assert list(board.index) == ["afar", "far", "near"]
    assert ranks["MPJPE 400 ms", "near"] < ranks["MPJPE 400 ms", "far"] < ranks["MPJPE 400 ms", "afar"]
    text = board.to_text()
    (header,) = (line for line in text.splitlines() if line.startswith("rank"))
    # Two metrics have times, so the times alone do not identify one.
    assert all(words in header for words in ("MPJPE 400 ms", "Euler error 400 ms"))
    assert all(note in text for note in ("MPJPE: in mm.", "Euler error: in rad."))
    assert re.search(rf"^ *1  near .* {ranks['MPJPE 400 ms', 'near']:.1f}\* ", text, re.M)
    assert f"{ranks['MPJPE 400 ms', 'near']:.4f}" in board.to_text(digits=4)
    assert board.to_latex().count("\\toprule") == 2
    with pytest.raises(ValueError, match=r"^metrics: only for files of samples; records and reports state their own"):
        npss.leaderboard([{"model": "m", "action": "a"}], metrics=["mse"])
    (samples / "records.json").write_text("[]", encoding="utf-8")
    with pytest.raises(ValueError, match=r"^metrics: only for files of results; records state their own"):
        npss.leaderboard([samples / "records.json"], metrics=["mse"])
    assert main(["leaderboard", str(samples), "--metrics", "mse"]) == 0
    assert "MSE" in capsys.readouterr().out


def test_comparisons(page):
    gt, a, b = (poses_to_positions(poses(seed)) for seed in (0, 1, 2))
    comparison = npss.compare(gt, a, b, metric="mpjpe", fps=25, at_ms=400)
    assert comparison.a == pytest.approx(np.mean(mpjpe(poses(0), poses(1), 9)))
    assert comparison.signature == "mpjpe|version:1|frames:25|fps:25|at_ms:400|root:fixed"
    assert 0 < comparison.p_value <= 1
    with pytest.raises(ValueError, match=r"^pred_b: nan at index"):
        npss.compare(gt, a, b * np.nan, metric="mpjpe", fps=25, at_ms=400)
    with pytest.raises(ValueError, match=r"^gt: expected shape \(N, T, J, 3\) with N >= 2"):
        npss.compare(gt[0], a[0], b[0], metric="mpjpe", fps=25, at_ms=400)
    with pytest.raises(ValueError, match=r"^at_ms: 10 ms is not a whole number of frames"):
        npss.compare(gt, a, b, metric="mpjpe", fps=25, at_ms=10)
    register(metric(lambda gt, pred: 1.0, aggregation="none"))
    with pytest.raises(ValueError, match=r"^metric: 'mine' has no values for single sequences"):
        npss.compare(*motions(), motions()[0], metric="mine")
    weighted = metric(lambda gt, pred: (np.ones(8), pred[:, 0, 0] ** 2), name="bad", aggregation="weighted mean")
    register(weighted)
    with pytest.raises(ValueError, match=r"^metric: the weights of 'bad'"):
        npss.compare(*motions(), motions()[0], metric="bad")


def test_the_prediction_that_is_beyond_float64_is_named():
    gt = motions()[0]
    gt *= 1.7e308 / np.abs(gt).max()
    for name, options in (("euler_error", {"fps": 25, "at_ms": 80}), ("mse", {})):
        with pytest.raises(ValueError, match=r"^pred_b: its (mean squared )?difference from gt is beyond"):
            npss.compare(gt, gt, -gt, metric=name, **options)


# --- higher is better -------------------------------------------------------------------------------------------------


def share(gt, pred):
    return (np.abs(gt - pred) < 1).mean(axis=(1, 2))


@pytest.fixture
def shares():
    """Records of three models by a metric for which higher is better."""
    register(metric(share, name="share", heading="PCK", lower_is_better=False))
    gt, noise = motions(12)
    return [
        {"model": name, "action": "a", **measure(gt, gt + size * noise, metrics=["share"], sequences=True, frames=T)}
        for name, size in (("far", 0.8), ("near", 0.1), ("middle", 0.4))
    ]


def check_ranks(records):
    board = npss.leaderboard(records, by="PCK")
    tidy = board.tidy[board.tidy["column"] == "PCK"].set_index("model")
    assert list(tidy["rank"].loc[["near", "middle", "far"]]) == [1, 2, 3]
    assert list(tidy["best"].loc[["near", "middle", "far"]]) == [True, False, False]
    assert list(tidy["worse"].loc[["near", "middle", "far"]]) == [False, True, True]
    assert tidy["behind"].loc["far"] == 1
    text = board.to_text()
    assert "Lower is better, except for PCK." in text
    order = [re.search(r"^ *\d  (\w+)", line).group(1) for line in text.splitlines() if re.match(r" *\d  \w", line)]
    assert order == ["near", "middle", "far"]
    assert "lower is better, except for PCK, best in bold" in board.to_latex()


def test_the_highest_is_ranked_first(shares):
    check_ranks(shares)
    assert "|better:higher" in shares[0]["signatures"]["PCK"]
    assert re.search(r"^near .*\*$", summary(shares), re.M)
    assert summary(shares).startswith("a (lower is better, except for PCK, * best; ")
    del shares[0]["metrics"]
    with pytest.raises(ValueError, match=r"^records: 'far' on 'a' lacks metrics PCK"):
        summary(shares)


def test_records_state_the_direction(shares):
    METRICS._entries.pop("share")  # as if unknown
    check_ranks(json.loads(json.dumps(shares)))


def test_the_highest_is_ranked_first_without_samples(shares):
    for record in shares:
        del record["sequences"]
    board = npss.leaderboard(shares, by="PCK")
    tidy = board.tidy[board.tidy["column"] == "PCK"].set_index("model")
    assert list(tidy["rank"].loc[["near", "middle", "far"]]) == [1, 2, 3]


def test_the_first_of_two_is_better_where_it_is_higher():
    register(metric(share, name="share", lower_is_better=False))
    gt, noise = motions(12)
    comparison = npss.compare(gt, gt + 0.1 * noise, gt + 0.8 * noise, metric="share")
    assert (comparison.better, comparison.difference > 0) == (12, True)


def test_a_study_ranks_by_it(shares):
    scores = model_scores(shares, ["far", "near", "middle"], action="a", metric="PCK")
    assert list(rank(scores, lower_is_better=False)) == ["near", "middle", "far"]
    assert rank({"a": 1.0, "b": 1.0, "c": 2.0}, lower_is_better=False) == {"c": 1, "a": 2, "b": 2}


def test_votes_are_compared_with_it(shares):
    question = Question(1, 1, "far", "near")
    votes = [Vote(participant=str(i), question=question, action="a", choice="B") for i in range(3)]
    result = vote_summary(votes, shares)
    (ranking,) = result["metrics"]["PCK"]["rankings"].values()
    assert [place["model"] for place in ranking] == ["near", "far"]
    assert result["metrics"]["PCK"]["overall"]["agreed"] == 1
    assert "PCK" in votes_text(result)


def test_leaderboards_can_be_pickled_with_any_function(shares):
    board = npss.leaderboard(shares)
    assert pickle.loads(pickle.dumps(board)).to_text() == board.to_text()


def test_signatures_of_a_record_state_the_input_of_the_metric():
    gt, pred = motions()
    register(metric())
    record = measure(gt, pred, unwrapped="target", metrics=["mine"], representation="euler", frames=T)
    assert record["signatures"]["mine"] == "mine|version:1|representation:euler|frames:25|unwrap:off"
    assert signature_of(record, "npss", "paper").endswith("|unwrap:target")
    assert record["metrics"]["mine"] == pytest.approx(np.abs(gt - pred).max(axis=(1, 2)).mean())
    with pytest.raises(ValueError, match=r"^metric: unknown metric 'nope'"):
        signature_of(record, "nope")
    with pytest.raises(ValueError, match=r"^convention: mine has none"):
        npss.signature("paper", metric="mine")


def test_weights_that_depend_on_the_prediction_are_refused():
    register(metric(lambda gt, pred: (np.ones(8), pred[:, 0, 0] ** 2), name="bad", aggregation="weighted mean"))
    gt, pred = motions()
    records = [
        {"model": name, "action": "a", **measure(gt, motion, metrics=["bad"], sequences=True, frames=T)}
        for name, motion in (("one", pred), ("other", gt))
    ]
    with pytest.raises(ValueError, match=r"^a, bad: 'one' and 'other' have sequences of different weights"):
        npss.leaderboard(records)


def test_columns_of_records_match_their_signatures(shares):
    shares[0]["signatures"]["PCK"] = "other|version:1"
    with pytest.raises(
        ValueError, match=r"metrics: 'PCK' is a column of 'share', but its signature is other\|version:1"
    ):
        npss.leaderboard(shares)


@pytest.mark.parametrize("at_ms", [40, 400, 1000])
def test_the_euler_error_is_that_of_its_own_function(at_ms):
    gt, pred = poses(2), poses(3)
    measured = EULER_ERROR.measure(gt, pred, fps=25, at_ms=at_ms)
    assert measured.value == pytest.approx(npss.euler_error(gt, pred, fps=25, at_ms=[at_ms])[at_ms], rel=1e-14)


def test_a_metric_may_have_no_decimal_places():
    assert Metric(name="count", function=lambda gt, pred: np.ones(len(gt)), says="a count", digits=0).digits == 0
