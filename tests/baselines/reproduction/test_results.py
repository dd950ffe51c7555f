"""Results: averages over seeds against numpy, intervals against a report, and what is missing."""

import json

import numpy as np
import pytest

import npss
from npss import poses_to_euler
from npss.predictors import PREDICTORS
from npss_baselines.reproduction.measure import amplitude
from npss_baselines.reproduction.plan import read_plan
from npss_baselines.reproduction.results import Results, read_records
from reproduced import task


def of_row(records, row):
    return [record["measured"][0] for record in records if record["row"] == row]


def test_numbers_are_means_over_seeds(results, of_plan):
    found = results.of("walking")["vgru-d"]
    assert found.seeds == (0, 1, 2)
    assert found.draws == 2
    values = [record["npss"]["released"] for record in of_row(of_plan, "vgru-d")]
    number = found.number("npss", "released")
    assert number.value == pytest.approx(np.mean(values), rel=1e-12)
    assert number.over_seeds == pytest.approx(np.std(values, ddof=1), rel=1e-12)
    spread = [np.std(record["by_draw"]["npss"]["released"]) for record in of_row(of_plan, "vgru-d")]
    assert number.over_draws == pytest.approx(np.mean(spread), rel=1e-9)
    assert number.signature.endswith("|protocol:srnn-8|unwrap:off|draws:2|verified:no")  # of generated walks
    windows = [record["npss_windows"]["paper"]["2-4"] for record in of_row(of_plan, "vgru-d")]
    assert found.number("npss", "paper", "2-4").value == pytest.approx(np.mean(windows), rel=1e-12)
    assert "window:2-4" in found.number("npss", "paper", "2-4").signature


def test_one_seed_without_noise_has_no_spread(results):
    number = results.of("walking")["zero-velocity"].number("euler_error", at="400")
    assert (number.over_seeds, number.over_draws) == (None, None)
    with pytest.raises(ValueError, match="zero-velocity on walking: no euler_error  99"):
        results.of("walking")["zero-velocity"].number("euler_error", at="99")


@pytest.mark.parametrize(("window", "frames"), [("", slice(None)), ("2-4", slice(50, 100))])
def test_spans_are_those_of_a_report(results, window, frames):
    windows = task()
    gt = poses_to_euler(windows.target)[:, frames]
    pred = poses_to_euler(PREDICTORS["repeat-50"](windows.seed_frames, 100))[:, frames]
    expected = npss.report(gt, pred, convention="released", groups=windows.groups).interval()
    span = results.spans("walking", window=window)["repeat-50", "released"]
    assert (span.low, span.high) == pytest.approx(expected, rel=1e-9)
    assert span.kind == "range of blocks"


def test_single_sequences_of_windows_add_up(of_plan):
    """A window's score is the weighted mean of its sequences, jumps of 2 pi removed or not."""
    for record in of_plan:
        for measured in (record["measured"][0], record["measured"][2]):
            for window, parts in measured["sequences_of_windows"].items():
                for convention, values in parts["npss"].items():
                    mean = np.average(values, weights=parts["weight"][convention])
                    assert mean == pytest.approx(measured["npss_windows"][convention][window], rel=1e-9)


def test_amplitude_of_cosines():
    """Of a cosine in a window, all of it is at its frequency; features that do not move are left out."""
    t = np.arange(20)
    motion = np.stack([3 + 0.5 * np.cos(2 * np.pi * 4 * t / 20), 0 * t, -1 + 0.25 * (-1.0) ** t], axis=1)[np.newaxis]
    expected = np.zeros(11)
    expected[[0, 4, 10]] = [(3 + 1) / 2, 0.5 / 2, 0.25 / 2]
    np.testing.assert_allclose(amplitude(motion, np.array([[True, False, True]])), expected, rtol=0, atol=1e-6)


def test_amplitude_of_truth_does_not_depend_on_the_model(of_plan):
    truths = {json.dumps(record["measured"][0]["amplitude"]["truth"]) for record in of_plan}
    assert len(truths) == 1
    held = of_row(of_plan, "zero-velocity")[0]["amplitude"]["prediction"]
    assert max(held[1:]) == 0 < held[0]


def test_missing_runs(results):
    plan = results.plan
    assert results.missing(plan.rows["vgru-d"], "walking") == ()
    assert results.missing(plan.rows["vgru-d"], "eating") == (0, 1, 2)
    assert results.missing(plan.rows["periodic"], "walking") == (0,)
    assert results.missing(plan.rows["noise"], "eating") == ()  # not in the plan


def test_other_motion_takes_the_place_of_the_eight_windows(of_plan):
    text = json.dumps([record for record in of_plan if record["row"] == "zero-velocity"])
    generated = json.loads(text.replace("srnn-8", "walks"))
    for record in generated:
        del record["measured"][1]
    found = Results(read_plan(), generated).of("walking")["zero-velocity"]
    assert found.protocol == "walks"


def test_invalid_records(of_plan):
    with pytest.raises(ValueError, match="records: 'mine' is no row of the plan"):
        Results(read_plan(), [{**of_plan[0], "row": "mine"}])
    with pytest.raises(ValueError, match="records: two of 'zero-velocity' on walking, seed 0"):
        Results(read_plan(), [of_plan[0], of_plan[0]])


def test_records_are_read(tmp_path, of_plan):
    folder = tmp_path / "zero-velocity"
    folder.mkdir()
    (folder / "walking-seed-0.json").write_text(json.dumps(of_plan[0]), encoding="utf-8")
    assert read_records(tmp_path) == of_plan[:1]
    (folder / "walking-seed-1.json").write_text("[]", encoding="utf-8")
    with pytest.raises(ValueError, match=r"walking-seed-1\.json: expected a record, got list"):
        read_records(tmp_path)
    (folder / "walking-seed-1.json").write_text(json.dumps({**of_plan[0], "seed": "1"}), encoding="utf-8")
    with pytest.raises(ValueError, match=r"walking-seed-1\.json: expected int as 'seed', got '1'"):
        read_records(tmp_path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda measured: measured.pop("euler_error"), "expected dict as 'euler_error', got None"),
        (lambda measured: measured.update(action=3), "expected str as 'action', got 3"),
        (lambda measured: measured.update(signature="npss"), "signature: "),
        (
            lambda measured: measured.update(signature="npss|version:1|convention:paper"),
            "signature: no protocol, unwrap",
        ),
        (lambda measured: measured["npss"].update(paper="1.2"), "npss: expected a number as 'paper', got '1.2'"),
        (
            lambda measured: measured["npss_windows"]["paper"].update({"0-1": None}),
            "npss_windows: paper: expected a num",
        ),
    ],
)
def test_damaged_records_are_refused_by_file_and_place(tmp_path, of_plan, change, message):
    record = json.loads(json.dumps(of_plan[0]))
    change(record["measured"][1])
    (tmp_path / "zero-velocity").mkdir()
    (tmp_path / "zero-velocity" / "walking-seed-0.json").write_text(json.dumps(record), encoding="utf-8")
    with pytest.raises(ValueError, match=rf"walking-seed-0\.json: measured\[1\]: {message}"):
        read_records(tmp_path)
