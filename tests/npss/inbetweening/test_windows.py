"""Windows and their parts: places, refused input, and the protocol's numbers."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

import npss
from npss.inbetweening import Local, Transition, forward, interpolation, train_statistics, transition, windows
from npss.protocol import InBetweening, lafan1
from npss.skeleton import Skeleton

BONE = Skeleton(["hips", "head"], [-1, 0], [[0, 0, 0], [0, 10, 0]])
LYING = np.sqrt([0.5, 0.5, 0, 0])  # a quarter turn about x: y points along z


def clip(frames, joints=2, turn=LYING):
    return Local(np.tile(turn, (frames, joints, 1)), np.arange(3.0 * frames).reshape(frames, 3))


class TestProtocol:
    def test_numbers_of_the_benchmark(self):
        assert (lafan1.name, lafan1.fps, lafan1.joints, lafan1.windows) == ("lafan1", 30, 22, 2232)
        assert (lafan1.test_length, lafan1.test_step, lafan1.test_subjects) == (65, 40, (5,))
        assert (lafan1.train_length, lafan1.train_step, lafan1.train_subjects) == (50, 20, (1, 2, 3, 4))
        assert (lafan1.past, lafan1.transitions, lafan1.future, lafan1.facing) == (10, (5, 15, 30, 45), 10, "y")
        assert lafan1.past + max(lafan1.transitions) + lafan1.future == lafan1.test_length
        assert npss.inbetweening.lafan1 is lafan1

    def test_the_bound_is_strict(self):
        assert [len(lafan1.starts(n)) for n in (1, 65, 66, 105, 106)] == [0, 0, 1, 1, 2]
        assert list(lafan1.starts(91, part="train")) == [0, 20, 40]

    def test_its_published_row_is_its_checksum(self):
        rows = npss.published.records("Harvey et al. 2020")
        of_model = [row for row in rows if row["model"] == "zero-velocity"]
        assert lafan1.zero_velocity["npss"] == tuple(row["npss"]["released"] for row in of_model)
        assert lafan1.zero_velocity["l2q"] == tuple(row["metrics"]["L2Q"] for row in of_model)

    def test_published_numbers_have_its_fields(self):
        for record in npss.published.records(protocol="lafan1"):
            for name, text in record["signatures"].items():
                metric = "npss" if name == "released" else name.lower()
                stated = npss.parse_signature(text)
                assert {name: stated[name] for name in lafan1.fields(metric)} == lafan1.fields(metric)
                assert (
                    f"{stated['metric'].upper()}: comparable with the LaFAN1 in-betweening tables: fact"
                    in npss.explain(text)
                )

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            (
                {"test_step": 20},
                "name: 'lafan1' is the benchmark's, with other values of test_step; choose another name",
            ),
            (
                {"name": "mine", "test_length": 64},
                "test_length: expected 65 frames or more for a transition of 45 frames",
            ),
            ({"name": "mine", "train_length": 9}, "train_length: expected 10 frames or more, the past"),
            ({"name": "mine", "transitions": (15, 5)}, "transitions: expected increasing lengths"),
            ({"name": "mine", "transitions": (5, 15)}, "zero_velocity: expected a number for each of the transitions"),
            ({"name": "mine", "facing": "-y"}, "facing: expected one of x, y, z, got '-y'"),
            ({"name": "mine", "past": 0}, "past: expected"),
        ],
    )
    def test_refuses(self, change, message):
        with pytest.raises(ValueError, match=message):
            replace(lafan1, **change)

    @pytest.mark.parametrize(
        ("change", "message"),
        [
            ({"zero_velocity": [1.0]}, "zero_velocity: expected a mapping of metrics to rows"),
            ({"name": 5}, "name: expected text, got 5"),
            ({"test_subjects": ("five",)}, "test_subjects: expected whole numbers"),
            ({"past": 9.5}, "past: expected"),
        ],
    )
    def test_refuses_other_types(self, change, message):
        with pytest.raises(TypeError, match=message):
            replace(lafan1, **change)

    def test_another_one(self):
        mine = replace(lafan1, name="mine", transitions=(10, 20), joints=2, windows=None, zero_velocity={}, facing="z")
        assert isinstance(mine, InBetweening)
        assert mine.fields()["protocol"] == "mine"
        cut = windows([clip(66, turn=[1, 0, 0, 0])], protocol=mine)
        turned = forward(cut, BONE).positions[0, :, 1] - forward(cut, BONE).positions[0, :, 0]
        np.testing.assert_allclose(turned, [[0, 10, 0]] * 65, atol=1e-12)  # about the vertical only
        with pytest.raises(ValueError, match="the y axis of the root is vertical at the last past frame of window 0"):
            windows([clip(66, turn=[1, 0, 0, 0])])


def test_windows_are_centred_and_turned():
    cut = windows([clip(106)])
    assert cut.root.shape == (2, 65, 3)
    np.testing.assert_allclose(cut.root[..., [0, 2]].mean(axis=1), 0, atol=1e-12)
    np.testing.assert_allclose(cut.root[0, :, 1], np.arange(65) * 3 + 1)  # the height stays
    head = forward(cut, BONE).positions
    np.testing.assert_allclose(head[:, :, 1] - head[:, :, 0], np.tile([10.0, 0, 0], (2, 65, 1)), atol=1e-12)


def test_quaternions_are_continuous_over_the_clip():
    """A sign that flips between windows, where no window shows it, is removed, too."""
    motion = clip(106)
    motion.quaternions[50:] *= -1
    first, second = windows([motion]).quaternions
    np.testing.assert_array_equal(first[:, 1], second[:, 1])


def test_transition_begins_at_frame_10():
    cut = windows([clip(66)])
    for n in lafan1.transitions:
        parts = transition(cut, n)
        assert isinstance(parts, Transition)
        assert parts.n_frames == n
        joined = np.concatenate([part.root for part in parts], axis=1)
        np.testing.assert_array_equal(joined, cut.root[:, : 10 + n + 10])
        np.testing.assert_array_equal(parts.truth.quaternions, transition(cut, 45).truth.quaternions[:, :n])
    with pytest.raises(ValueError, match="n: 46 frames between 10 and 10 do not fit into 65 frames"):
        transition(cut, 46)


def test_interpolation_takes_the_shorter_arc():
    cut = windows([clip(66)])
    parts = transition(cut, 5)
    parts.future.quaternions[:, 0] *= -1
    np.testing.assert_allclose(interpolation(parts).quaternions, parts.truth.quaternions, atol=1e-12)


def test_statistics_pool_clips():
    clips = [clip(71), clip(91), clip(50)]  # the last has no window
    positions = forward(windows(clips, part="train"), BONE).positions.reshape(-1, 2, 3)
    mean, std = train_statistics(iter(clips), BONE)
    np.testing.assert_allclose(mean, positions.mean(axis=0), atol=1e-12)
    np.testing.assert_allclose(std, positions.std(axis=0), rtol=1e-12)


@pytest.mark.parametrize(
    ("call", "error", "message"),
    [
        (lambda: windows([]), ValueError, "clips: none is longer than 65 frames, a window"),
        (lambda: windows([clip(65)]), ValueError, "clips: none is longer than 65 frames"),
        (lambda: windows([clip(66), clip(66, 3)]), ValueError, "clips: clip 1: 3 joints, but clip 0 has 2"),
        (lambda: windows([clip(66)], part="all"), ValueError, "part: expected one of train, test, got 'all'"),
        (lambda: windows([clip(66).quaternions]), TypeError, r"clips: clip 0: expected Local\(quaternions, root\)"),
        (
            lambda: windows([clip(66, turn=[0, 0, 0, 0])]),
            ValueError,
            r"clip 0: quaternions: a zero quaternion.*\(0, 0\)",
        ),
        (
            lambda: windows([Local(clip(66).quaternions, clip(65).root)]),
            ValueError,
            r"clips: clip 0: root: expected shape \(66, 3\), got \(65, 3\)",
        ),
        (lambda: train_statistics([clip(50)], BONE), ValueError, "clips: none is longer than 50 frames"),
        (lambda: forward(clip(5, 3), BONE), ValueError, "motion: expected the 2 joints of the skeleton, got 3"),
        (lambda: transition(clip(66), 5), ValueError, r"windows: expected quaternions of shape \(N, T, J, 4\)"),
    ],
)
def test_refuses(call, error, message):
    with pytest.raises(error, match=message):
        call()


def test_a_protocol_can_be_copied_and_pickled():
    for protocol in (lafan1, replace(lafan1, name="mine", joints=31)):
        assert copy.deepcopy(protocol) == pickle.loads(pickle.dumps(protocol)) == protocol


def test_what_is_no_motion_is_refused():
    quaternions, root = np.ones((2, 3, 4)), np.zeros((2, 3))
    with pytest.raises(ValueError, match=r"quaternions: expected shape \(\.\.\., T, J, 4\), got \(2, 3, 3\)"):
        windows([Local(quaternions[..., :3], root)])
    with pytest.raises(
        ValueError, match=r"^clips: clip 0: expected quaternions of shape \(T, J, 4\), got \(1, 2, 3, 4\)"
    ):
        windows([Local(quaternions[np.newaxis], root[np.newaxis])])
