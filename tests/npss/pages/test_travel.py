"""How figures of a survey travel: where the motion of the root is known, on a level floor."""

import numpy as np
import pytest

from npss import gait
from npss._pages.travel import positions
from npss.skeleton import H36M, poses_to_positions

FEET = [H36M.names.index(name) for name in ("RightToeBase", "LeftToeBase")]


def walks(seed, n=2, frames=40):
    """Upright walks: without the rotations of the root, which add up in generated gaits."""
    poses = gait.gait(n, frames, seed=seed)
    poses[..., 3:6] = 0
    return poses


def shown(root="known", steps=1, **poses):
    return positions("walking", {"ground truth": walks(0), "model": walks(1), **poses}, root=root, steps=steps)


def fixed(poses):
    return poses_to_positions(poses)


def test_known_motion_is_shown():
    travelled, in_place = shown()
    assert in_place == ""
    for name, poses in (("ground truth", walks(0)), ("model", walks(1))):
        path = poses_to_positions(poses, root="path")
        # Turned as a whole: distances, of joints and of frames, stay.
        steps = np.linalg.norm(np.diff(travelled[name][:, :, 0], axis=1), axis=-1)
        np.testing.assert_allclose(steps, np.linalg.norm(np.diff(path[:, :, 0], axis=1), axis=-1), rtol=0, atol=1e-8)
        spread = travelled[name] - travelled[name][:, :1, :1]
        np.testing.assert_allclose(
            np.linalg.norm(spread, axis=-1), np.linalg.norm(path - path[:, :1, :1], axis=-1), rtol=0, atol=1e-8
        )


def test_steps_multiply_it():
    once, twice = (shown(steps=steps)[0]["ground truth"][:, -1, 0] for steps in (1, 2))
    np.testing.assert_allclose(np.linalg.norm(twice, axis=-1), 2 * np.linalg.norm(once, axis=-1), rtol=1e-9)


@pytest.mark.parametrize("unknown", ["ground truth", "model"])
def test_where_one_does_not_know_it_all_stay_in_place(unknown):
    poses = walks(2)
    poses[..., :6] = 0
    placed, in_place = shown(**{unknown: poses})
    assert in_place == f"the root does not move in {unknown!r}"
    for name, of_one in {"ground truth": walks(0), "model": walks(1), unknown: poses}.items():
        np.testing.assert_array_equal(placed[name], fixed(of_one))


def test_fixed_on_request():
    placed, in_place = shown(root="fixed")
    assert in_place == "fixed on request"
    np.testing.assert_array_equal(placed["model"], fixed(walks(1)))


def test_a_recording_that_turns_over_is_not_believed():
    turning = walks(0, frames=100)
    turning[..., 3] = 0.05  # radians in each frame, about an axis through the hips: once around and more
    in_place = positions("walking", {"ground truth": turning, "model": turning}, root="known", steps=1)[1]
    assert in_place == "the recorded person turns over"
    upright = walks(0, frames=100)
    assert not positions("walking", {"ground truth": upright, "model": turning}, root="known", steps=1)[1]


def test_the_floor_is_level():
    """A figure that glides up a slope is turned by it, up to the share that counts as little."""
    for tilt in (0.0, 0.15):
        poses = np.repeat(walks(0)[:, :1], 40, axis=1)
        poses[..., :3] = [0, 40 * np.sin(tilt), 40 * np.cos(tilt)]
        travelled = shown(**{"ground truth": poses})[0]["ground truth"]
        way = travelled[:, -1, 0] - travelled[:, 0, 0]
        np.testing.assert_allclose(np.linalg.norm(way, axis=-1), 39 * 40, rtol=1e-9)
        little = 60**2 / (60**2 + np.var(40 * np.cos(tilt) * np.arange(40)))
        slope = np.tan(tilt) * (1 - little)
        np.testing.assert_allclose(way[:, 1] / 1560, np.sin(tilt - np.arctan(slope)), rtol=0, atol=1e-9)


def test_who_hardly_travels_stays_upright():
    poses = walks(0)
    poses[..., :3] *= 0.01
    path = poses_to_positions(poses, root="path")
    travelled = shown(**{"ground truth": poses})[0]["ground truth"]
    assert np.abs(travelled - path).max() < 200


def test_real_walking(h36m_root):
    """Feet stay on the floor, though the root was tilted in the first frame; with every second step, they slide."""
    clip = np.loadtxt(h36m_root / "dataset" / "S5" / "walking_1.txt", delimiter=",")
    poses = np.stack([clip[first : first + 200 : 2] for first in (100, 600, 1000)])
    truth = positions("walking", {"ground truth": poses, "model": poses}, root="known", steps=2)[0]["ground truth"]
    lowest = truth[..., 1].min(axis=-1)
    assert np.ptp(lowest, axis=1).max() < 60  # mm; 500 before the floor was levelled
    assert np.linalg.norm(truth[:, -1, 0] - truth[:, 0, 0], axis=-1).max() > 1000

    def sliding(motion):
        """Return the speed of the slower foot, in mm per frame."""
        steps = np.diff(motion[:, :, FEET][..., [0, 2]], axis=1)
        return np.median(np.linalg.norm(steps, axis=-1).min(axis=-1))

    half = positions("walking", {"ground truth": poses, "model": poses}, root="known", steps=1)[0]["ground truth"]
    assert sliding(truth) < sliding(half) / 2


def test_errors_name_the_model():
    poses = walks(1)
    poses[0, 3, 20] = np.nan
    for root in ("known", "fixed"):
        with pytest.raises(ValueError, match=r"^'model' on 'walking': "):
            shown(root=root, model=poses)
