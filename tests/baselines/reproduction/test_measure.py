"""The numbers of a record: draws, and blocks in place of sequences."""

import numpy as np
import pytest

import npss
from npss.predictors import zero_velocity
from npss.records import measure as measure_records
from npss_baselines.data.synthetic import synthetic_task
from npss_baselines.reproduction import measure as module
from npss_baselines.reproduction.measure import in_blocks, measure

TASK = synthetic_task(4)


def noisy(action):
    rng = np.random.default_rng(0)

    def predict(seed_frames, n_target):
        return zero_velocity(seed_frames, n_target) + 0.01 * rng.normal(size=(len(seed_frames), n_target, 99))

    return predict


def test_noise_is_averaged_over_draws_that_the_record_lists():
    record = measure("noisy", noisy, TASK, draws=3)
    predictor, scores = noisy("gait"), []
    gt = npss.poses_to_euler(TASK.target)
    for _ in range(3):
        scores.append(npss.score(gt, npss.poses_to_euler(predictor(TASK.seed_frames, 100)), convention="paper"))
    assert record["by_draw"]["npss"]["paper"] == scores
    assert record["npss"]["paper"] == pytest.approx(np.mean(scores), rel=1e-12)
    assert npss.parse_signature(record["signature"])["draws"] == 3
    assert set(record["by_draw"]["euler_error"]) == {"80", "160", "320", "400", "560", "1000"}


def test_few_windows_say_what_the_score_is_made_of_and_how_fast_the_prediction_is():
    record = measure("noisy", noisy, TASK, draws=2)
    predictor, gt = noisy("gait"), npss.poses_to_euler(TASK.target)
    draws = [npss.poses_to_euler(predictor(TASK.seed_frames, 100)) for _ in range(2)]
    reports = [npss.report(gt, pred, convention="released") for pred in draws]
    parts = record["parts"]["released"]
    for name in ("form", "share", "share_floor"):
        assert parts[name] == pytest.approx(np.mean([getattr(report.parts, name) for report in reports]), rel=1e-12)
    assert parts["form"] + parts["share"] == pytest.approx(record["npss"]["released"], rel=1e-12)
    speeds = [npss.speed_ratio(gt, pred, start=25) for pred in draws]
    assert record["speed_ratio"] == pytest.approx(np.mean(speeds), rel=1e-12)


def test_without_noise_one_draw_is_enough():
    record = measure("still", lambda action: zero_velocity, TASK)
    assert "by_draw" not in record
    assert "draws" not in npss.parse_signature(record["signature"])
    assert len(record["sequences"]["npss"]["released"]) == 4


def test_many_windows_are_recorded_by_block(monkeypatch):
    monkeypatch.setattr(module, "MANY", 3)
    task = TASK._replace(groups=("a", "b", None, "a"))
    record = measure("still", lambda action: zero_velocity, task)
    assert record["sequences"]["groups"] == ["a", "b", None]
    assert "euler_error" not in record["sequences"]


def test_blocks_have_the_intervals_and_comparisons_of_their_sequences():
    pytest.importorskip("pandas")
    rng = np.random.default_rng(1)
    gt = rng.normal(size=(40, 30, 3)).cumsum(axis=1)
    groups = [None if i % 13 == 12 else f"block {i % 13}" for i in range(40)]
    records, blocks = [], []
    for model, size in (("a", 0.5), ("b", 1.0)):
        pred = gt + size * rng.normal(size=gt.shape).cumsum(axis=1)
        record = measure_records(gt, pred, conventions=["paper", "released"], sequences=True, groups=groups)
        records.append({"model": model, "action": "walking", **record})
        blocks.append({**records[-1], "sequences": in_blocks(record["sequences"])})
    of_sequences, of_blocks = npss.leaderboard(records), npss.leaderboard(blocks)
    numbers = of_sequences.select_dtypes("number").columns
    np.testing.assert_allclose(of_blocks[numbers], of_sequences[numbers], rtol=1e-9)
