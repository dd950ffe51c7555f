"""Ties: constant predictions, equal in theory, share a rank in spite of rounding."""

import numpy as np
import pytest

import npss
from npss import study
from npss._analysis.ties import tied
from npss.ranking._results import Result
from npss.ranking._standings import standings


@pytest.mark.parametrize("convention", ["paper", "released", "literal"])
@pytest.mark.parametrize(("n_frames", "scale", "level"), [(2, 1e-3, 5), (100, 1, 0), (101, 1e-3, 5), (10007, 0.1, 10)])
def test_constant_predictions_share_a_rank(convention, n_frames, scale, level):
    """Whatever a motion is predicted to stay at, all power is in bin 0; that is so of no other one."""
    rng = np.random.default_rng(n_frames)
    gt = level + scale * rng.normal(size=(2, n_frames, 5)).cumsum(axis=1)
    poses = {"last": gt[:, :1], "mean": gt.mean(axis=1, keepdims=True), "anything": rng.normal(size=(2, 1, 5))}
    scores = {
        name: npss.score(gt, np.broadcast_to(pose, gt.shape), convention=convention) for name, pose in poses.items()
    }
    moving = gt[:, :1] + (gt - gt[:, :1]) * np.linspace(0, 1, n_frames)[:, np.newaxis]
    scores["moves"] = npss.score(gt, moving, convention=convention)
    ranks = study.rank(scores)
    assert len({ranks[name] for name in poses}) == 1
    assert ranks["moves"] not in {ranks[name] for name in poses}


def test_the_tolerance():
    for a, b in ((1, 1 + 9e-10), (1000, 1000 + 9e-7), (0, 9e-13), (1e-6, 1e-6 + 9e-13), (2.5, 2.5)):
        assert tied(a, b)
        assert tied(b, a)
    for a, b in ((1, 1 + 2e-9), (1000, 1000 + 2e-6), (0, 2e-12), (1e-6, 1e-6 + 2e-12), (0.887, 0.888)):
        assert not tied(a, b)
        assert not tied(b, a)


@pytest.mark.parametrize(("gap", "expected"), [(5e-10, [1, 2, 2]), (5e-9, [1, 2, 3])])
def test_one_tolerance_for_every_rank(gap, expected):
    """Leaderboards of numbers without single sequences rank as a user study does."""
    scores = {"best": 0.25, "second": 0.5, "third": 0.5 * (1 + gap)}
    assert list(study.rank(scores).values()) == expected
    results = [
        Result(model=model, action="walking", column="NPSS paper", value=value, signature="npss|version:1")
        for model, value in scores.items()
    ]
    assert [standing.rank for standing in standings(results)] == expected
    first_twice = [standing.best for standing in standings(results[1:])]
    assert first_twice == [True, expected == [1, 2, 2]]
