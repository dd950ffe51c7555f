"""The speed of a prediction: against a loop, and what does and does not change it."""

import numpy as np
import pytest

import npss
from npss._metric import euler_error
from npss.predictors import repeat, zero_velocity


def walks(n=3, n_frames=40, d=5, seed=0):
    return 0.2 * np.random.default_rng(seed).normal(size=(2, n, n_frames, d)).cumsum(axis=2)


def slow(gt, pred, start):
    """Return the ratio of mean speeds, step by step."""
    speeds = []
    for motion in (gt, pred):
        steps = []
        for i, d in np.ndindex(gt[:, 0].shape):
            if np.std(gt[i, :, d]) > 1e-4:
                for t in range(start, gt.shape[1]):
                    step = motion[i, t, d] - motion[i, t - 1, d]
                    steps.append(abs(np.arctan2(np.sin(step), np.cos(step))))
        speeds.append(np.mean(steps))
    return speeds[1] / speeds[0]


@pytest.mark.parametrize("start", [1, 25, 39])
@pytest.mark.parametrize("scale", [1, 20])  # of 20, many steps are longer than pi
def test_equals_a_loop(start, scale, monkeypatch):
    gt, pred = scale * walks()
    gt[0, :, 1] = 0.3
    gt[2, :, 2] = 1e-5 * gt[1, :, 2]
    assert npss.speed_ratio(gt, pred, start=start) == pytest.approx(slow(gt, pred, start), rel=1e-12)
    monkeypatch.setattr(euler_error, "_BLOCK", 1)  # a block for each sequence
    assert npss.speed_ratio(gt, pred, start=start) == pytest.approx(slow(gt, pred, start), rel=1e-12)


def test_the_truth_and_its_mirror_image_have_the_true_speed():
    gt, _ = walks()
    assert npss.speed_ratio(gt, gt) == npss.speed_ratio(gt, -gt) == npss.speed_ratio(gt[0], gt[0]) == 1
    assert npss.speed_ratio(gt, gt[:, ::-1]) == pytest.approx(1, rel=1e-12)


@pytest.mark.parametrize("factor", [0.0, 0.25, 0.5])
def test_a_smaller_motion_is_slower_and_a_constant_has_no_speed(factor):
    gt, _ = walks()
    assert npss.speed_ratio(gt, 7 + factor * gt) == pytest.approx(factor, rel=1e-12)
    assert npss.score(gt, factor * gt) == pytest.approx(0, abs=1e-12) or factor == 0  # what NPSS does not see


def test_jumps_of_two_pi_do_not_count_unless_asked():
    gt, pred = walks()
    wrapped = (pred + np.pi) % (2 * np.pi) - np.pi
    jumped = pred.copy()
    jumped[:, 20:] += 2 * np.pi
    for other in (wrapped, jumped):
        assert npss.speed_ratio(gt, other) == pytest.approx(npss.speed_ratio(gt, pred), rel=1e-12)
    assert npss.speed_ratio(gt, jumped, wrap=False) > npss.speed_ratio(gt, pred, wrap=False) + 0.5
    assert npss.speed_ratio(100 * gt, 300 * gt, wrap=False) == pytest.approx(3, rel=1e-12)


def test_frames_before_the_start_do_not_count():
    gt, pred = walks()
    other = pred.copy()
    other[:, :24] = 9.0
    assert npss.speed_ratio(gt, other, start=25) == npss.speed_ratio(gt, pred, start=25)


def test_what_is_still_in_the_ground_truth_does_not_count():
    gt, pred = walks()
    gt[1] = gt[0, :, 0] = 0.5
    other = pred.copy()
    other[1] *= 3
    assert npss.speed_ratio(gt, other) == npss.speed_ratio(gt, pred)
    with pytest.raises(ValueError, match=r"^gt: nothing moves from frame 1 on"):
        npss.speed_ratio(gt[1], pred[1])
    late = gt.copy()
    late[:, 10:] = 0.0
    with pytest.raises(ValueError, match=r"^gt: nothing moves from frame 12 on"):
        npss.speed_ratio(late, pred, start=12)


def test_invalid_input():
    gt, pred = walks()
    for start in (0, 40, -1):
        with pytest.raises(ValueError, match=rf"^start: expected a frame from 1 to 39, got {start}"):
            npss.speed_ratio(gt, pred, start=start)
    for start in (1.0, True, None, "1"):
        with pytest.raises(TypeError, match=r"^start: expected a whole number"):
            npss.speed_ratio(gt, pred, start=start)
    with pytest.raises(TypeError, match=r"^wrap: expected True or False"):
        npss.speed_ratio(gt, pred, wrap=1)
    with pytest.raises(ValueError, match=r"^start: "):
        npss.speed_ratio(gt[:, :1], pred[:, :1])
    with pytest.raises(ValueError, match=r"^pred: "):
        npss.speed_ratio(gt, pred[:, 1:])


@pytest.mark.parametrize("bad", [np.nan, np.inf])
@pytest.mark.parametrize("name", ["gt", "pred"])
@pytest.mark.parametrize("wrap", [True, False])
def test_invalid_values_are_named(bad, name, wrap):
    both = dict(zip(("gt", "pred"), walks(), strict=True))
    for frame in (3, 30):
        motion = both[name].copy()
        motion[1, frame, 2] = bad
        with pytest.raises(ValueError, match=rf"^{name}: {bad} at index \(1, {frame}, 2\)"):
            npss.speed_ratio(**{**both, name: motion}, start=20, wrap=wrap)


@pytest.mark.parametrize("name", ["gt", "pred"])
def test_speeds_beyond_float64_are_refused(name):
    both = dict(zip(("gt", "pred"), walks(), strict=True))
    both[name] = np.sign(np.random.default_rng(0).normal(size=both[name].shape)) * 1.7e308
    with pytest.raises(ValueError, match=rf"^{name}: its speed is beyond the largest float64"):
        npss.speed_ratio(**both)


@pytest.mark.parametrize(("action", "expected"), [("walking", 1.1300), ("eating", 1.0810), ("smoking", 1.3324)])
def test_the_speed_of_repeated_frames(h36m_root, action, expected):
    """As docs/conventions.md says."""
    from npss_baselines.data.h36m_source import Human36M  # needs torch

    (task,) = Human36M().tasks(h36m_root, [action])
    gt = npss.poses_to_euler(task.target)
    repeated, held = (npss.poses_to_euler(f(task.seed_frames, 100)) for f in (repeat, zero_velocity))
    assert npss.speed_ratio(gt, repeated, start=25) == pytest.approx(expected, abs=6e-5)
    assert npss.speed_ratio(gt, held, start=25) == 0
