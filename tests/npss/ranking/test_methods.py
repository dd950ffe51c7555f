"""Methods as averages of runs, in leaderboards."""

import itertools

import numpy as np
import pytest

import npss
from npss.commands import main
from npss.ranking._methods import averaged, read_methods
from npss.ranking._results import Result
from npss.ranking._standings import notes, standings

RUNS = ("run-1", "run-2", "run-3")


def result(model, parts, *, column="NPSS paper", groups=None, **fields):
    numerator = np.array(parts, float)
    weight = np.full(len(numerator), 2.0)
    named = {"model": model, "action": "walking", "column": column, "signature": "npss|version:1"} | fields
    return Result(value=numerator.sum() / weight.sum(), numerator=numerator, weight=weight, groups=groups, **named)


@pytest.fixture
def runs():
    rng = np.random.default_rng(0)
    return [result(name, rng.uniform(2, 4, 12)) for name in (*RUNS, "other")]


def test_a_method_is_the_mean_of_its_runs_in_every_sequence(runs):
    found = {one.model: one for one in averaged(runs, {"net": RUNS})}
    assert set(found) == {"net", "other"}
    net = found["net"]
    np.testing.assert_allclose(net.numerator, np.mean([run.numerator for run in runs[:3]], axis=0))
    assert net.value == pytest.approx(np.mean([run.value for run in runs[:3]]))
    assert net.value == pytest.approx(net.numerator.sum() / net.weight.sum())
    assert net.seeds == tuple(run.value for run in runs[:3])
    said = notes(standings(list(found.values())))
    assert any(line.startswith("net: the mean of 3 seeds") for line in said)


def test_runs_without_their_sequences_are_a_number_alone(runs):
    bare = [Result(**{**vars(run), "numerator": None, "weight": None}) for run in runs]
    (net,) = (one for one in averaged([*runs[:2], *bare[2:]], {"net": RUNS}) if one.model == "net")
    assert (net.numerator, net.weight) == (None, None)
    assert len(net.seeds) == 3


def test_published_rows_stay(runs):
    row = Result(
        model="run-1", action="walking", column="NPSS paper", value=1.0, signature="npss|version:1", source="x"
    )
    assert averaged([*runs, row], {"net": RUNS})[-1] is row


@pytest.mark.parametrize(
    ("methods", "error", "message"),
    [
        ({"net": RUNS[:2]}, ValueError, "methods: 'net' has 2 runs; a method needs 3 or more"),
        ({"net": ("run-1", "run-2", "run-2")}, ValueError, "methods: duplicate run 'run-2'"),
        ({"net": RUNS, "same": RUNS}, ValueError, "methods: duplicate run 'run-1'"),
        ({"net": "run-1"}, TypeError, "methods: expected a sequence of names of models, got 'run-1'"),
        ({"net": (1, 2, 3)}, TypeError, "methods: expected names of models, got 1"),
        ({" ": RUNS}, ValueError, "methods: the name of a method is empty: ' '"),
        ({7: RUNS}, TypeError, "methods: expected names of models, got 7"),
        (["net"], TypeError, "methods: expected a mapping of names to models, got"),
    ],
)
def test_invalid_methods(methods, error, message):
    with pytest.raises(error, match=f"^{message}"):
        read_methods(methods)


def test_runs_that_do_not_belong_together(runs):
    def refused(message, results, methods=None):
        with pytest.raises(ValueError, match=message):
            averaged(results, methods or {"net": RUNS})

    refused("methods: unknown model 'run-3'; expected one of other, run-1, run-2", [*runs[:2], runs[3]])
    refused("methods: 'other' is also the name of a model", runs, {"other": RUNS})
    more = result("run-1", [1.0] * 12, column="NPSS released")
    refused("methods: 'net' on 'walking', NPSS released: 'run-2' has no such number", [*runs, more])
    refused("methods: .*: duplicate run 'run-1'", [*runs, runs[0]])
    strange = result("run-3", [1.0] * 12, signature="npss|version:1|frames:9")
    refused(
        "methods: .*: runs have different numbers: npss.version:1 and npss.version:1.frames:9", [*runs[:2], strange]
    )
    apart = result("run-3", [1.0] * 12, groups=tuple("aabbccddeeff"))
    refused("methods: .*: runs were scored in different blocks", [*runs[:2], apart])


def test_in_leaderboards(tmp_path, capsys):
    pytest.importorskip("pandas")
    rng = np.random.default_rng(1)
    gt = rng.normal(size=(12, 20, 3)).cumsum(axis=1)
    reports = {name: npss.report(gt, gt + k * rng.normal(size=gt.shape)) for k, name in enumerate((*RUNS, "other"), 1)}
    board = npss.leaderboard(reports, methods={"net": RUNS})
    assert list(board.index) == ["other", "net"]
    (row,) = (row for row in board.tidy.itertuples() if row.model == "net")
    scores = [float(reports[run]) for run in RUNS]
    assert (row.seeds, row.seed_low, row.seed_high) == (3, min(scores), max(scores))
    assert row.value == pytest.approx(np.mean(scores))
    assert f"seeds {min(scores):.3f}–{max(scores):.3f})" in board.to_text()
    assert board.tidy.set_index("model")["seeds"].isna()["other"]
    other = npss.report(2 * gt, gt)
    with pytest.raises(ValueError, match="different ground truth"):
        npss.leaderboard({**reports, "run-3": other}, methods={"net": RUNS})


def test_on_the_command_line(tmp_path, capsys):
    pytest.importorskip("pandas")
    rng = np.random.default_rng(2)
    gt = 0.02 * rng.normal(size=(6, 30, 99)).cumsum(axis=1)
    for name in (*RUNS, "other"):
        arrays = {}
        for i, truth in enumerate(gt):
            arrays |= {
                f"expmap/gt/walking_{i}": truth,
                f"expmap/preds/walking_{i}": truth + 0.01 * rng.normal(size=(30, 99)),
            }
        np.savez(tmp_path / f"{name}.npz", **arrays)
    assert main(["leaderboard", str(tmp_path), "--method", "net", *RUNS]) == 0
    text = capsys.readouterr().out
    assert "net: the mean of 3 seeds" in text
    assert not any(run in text for run in RUNS)
    twice = [*itertools.chain(*(["--method", "net", *RUNS] for _ in range(2)))]
    assert main(["leaderboard", str(tmp_path), *twice]) == 2
    assert capsys.readouterr().err == "npss: error: --method net: duplicate method\n"
    pytest.importorskip("matplotlib")
    page = tmp_path / "page.html"
    only = [str(tmp_path / f"{run}.npz") for run in RUNS]
    assert main(["report", *only, "-o", str(page), "--method", "net", *RUNS]) == 0  # a method has no motion to show
    assert "where the score of run-1 comes from" in page.read_text(encoding="utf-8")
