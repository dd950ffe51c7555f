"""Batches and validation windows: random draws, and no test frames."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from npss.protocol import COLUMNS, TEST_SUBJECT, normalization, srnn_windows
from npss_baselines.data import h36m, windows
from npss_baselines.data.h36m_source import Human36M
from npss_baselines.data.synthetic import synthetic_task, synthetic_training_set, synthetic_validation
from npss_baselines.data.windows import Batches, TrainingClip, TrainingSet


def marked(lengths, n_actions=2):
    """Return clips whose values encode the clip and the frame."""
    clips = []
    for i, length in enumerate(lengths):
        poses = np.zeros((length, 54), np.float32)
        poses[:, 0], poses[:, 1] = i, np.arange(length)
        clips.append(TrainingClip(f"S1/clip_{i}.txt", i % n_actions, poses))
    return TrainingSet(tuple("ab"[:n_actions]), tuple(clips), synthetic_training_set(2, 20).normalization)


@given(
    lengths=st.lists(st.integers(40, 90), min_size=1, max_size=5),
    n_seed=st.integers(1, 12),
    n_target=st.integers(1, 11),
    batch=st.integers(1, 40),
    seed=st.integers(0, 2**32 - 1),
    iteration=st.integers(0, 10**6),
)
def test_windows_and_labels_are_those_of_the_clips(lengths, n_seed, n_target, batch, seed, iteration):
    poses, label = Batches(marked(lengths), batch=batch, n_seed=n_seed, n_target=n_target, seed=seed)[iteration]
    n_frames = n_seed + n_target + 1
    assert poses.shape == (batch, n_frames, 54)
    assert poses.dtype == label.dtype == np.float32
    clips, frames = poses[:, :, 0].astype(int), poses[:, :, 1].astype(int)
    assert (clips == clips[:, :1]).all()
    assert (np.diff(frames, axis=1) == 1).all()
    assert (frames >= windows.FIRST).all()
    assert (frames < np.array(lengths)[clips]).all()
    assert (label == np.eye(2)[clips[:, 0] % 2]).all()


def test_clips_and_first_frames_are_uniform():
    lengths = (60, 45, 90)
    batches = Batches(marked(lengths), batch=1000, n_seed=8, n_target=7, seed=3)
    poses = np.concatenate([batches[i].poses for i in range(30)])
    clips, starts = poses[:, 0, 0].astype(int), poses[:, 0, 1].astype(int)
    assert stats.chisquare(np.bincount(clips)).pvalue > 0.001
    for clip, length in enumerate(lengths):
        # The paper's code: randint(16, T - n_seed - n_target), which excludes the end.
        counts = np.bincount(starts[clips == clip], minlength=length)
        assert counts[: windows.FIRST].sum() == counts[length - 15 :].sum() == 0
        assert stats.chisquare(counts[windows.FIRST : length - 15]).pvalue > 0.001


def test_a_batch_is_a_function_of_seed_and_iteration_alone():
    def drawn(seed, iteration):
        return Batches(marked((60, 70)), batch=16, n_seed=5, n_target=5, seed=seed)[iteration].poses

    batches = Batches(marked((60, 70)), batch=16, n_seed=5, n_target=5, seed=1)
    backwards = [batches[i].poses for i in (5, 0, 3)]
    assert all(np.array_equal(a, drawn(1, i)) for a, i in zip(backwards, (5, 0, 3), strict=True))
    several = [drawn(seed, iteration)[:, 0, 1] for seed in (0, 1, 2) for iteration in (0, 1, 2)]
    assert len({tuple(starts) for starts in several}) == 9


@pytest.mark.parametrize("length", [0, 1, 26, 27])
def test_errors_name_a_short_clip(length):
    training_set = marked((60, 60))
    clips = (*training_set.clips[:1], TrainingClip("S6/eating_2.txt", 0, np.zeros((length, 54), np.float32)))
    short = dataclasses.replace(training_set, clips=clips)
    if length == 27:  # one window fits, and is drawn
        frames = Batches(short, batch=50, n_seed=5, n_target=5, seed=0)[0].poses
        assert frames.shape == (50, 11, 54)
        return
    with pytest.raises(ValueError, match=rf"^clips: S6/eating_2.txt has {length} frames .* need at least 27"):
        Batches(short, batch=2, n_seed=5, n_target=5, seed=0)


@pytest.mark.parametrize(
    ("wrong", "error", "message"),
    [
        ({"batch": 0}, ValueError, "batch: expected a positive integer"),
        ({"n_seed": 2.5}, TypeError, "n_seed: expected a positive integer"),
        ({"n_target": -1}, ValueError, "n_target: "),
        ({"seed": -1}, ValueError, r"seed: expected an integer from 0 to 2\*\*32 - 1, got -1"),
        ({"seed": 2**32}, ValueError, "seed: "),
        ({"seed": True}, TypeError, "seed: expected an integer, got True"),
    ],
)
def test_bad_numbers_are_refused(wrong, error, message):
    with pytest.raises(error, match=f"^{message}"):
        Batches(marked((60,)), **{"batch": 2, "n_seed": 5, "n_target": 5, "seed": 0} | wrong)


def test_synthetic_sets_share_no_walker():
    training_set = synthetic_training_set()
    (task,) = synthetic_validation()
    assert training_set.actions == (task.action,) == (synthetic_task().action,)
    assert training_set.normalization.columns == COLUMNS
    rows = np.concatenate([clip.poses for clip in training_set.clips])
    np.testing.assert_allclose(rows.mean(axis=0), 0, rtol=0, atol=1e-5)
    np.testing.assert_allclose(rows.std(axis=0), 1, rtol=0, atol=1e-4)
    firsts = [
        task.seed_frames[:, 0],
        synthetic_task().seed_frames[:, 0],
        training_set.normalization.unnormalize(rows[::500]),
    ]
    together = np.concatenate(firsts)[:, COLUMNS].round(3)
    assert len(np.unique(together, axis=0)) == len(together)
    again = synthetic_training_set()
    assert all(np.array_equal(a.poses, b.poses) for a, b in zip(training_set.clips, again.clips, strict=True))


@given(seed=st.integers(0, 10**6))
def test_normalised_poses_are_reconstructed(seed):
    statistics = synthetic_training_set(2, 20).normalization
    poses = np.random.default_rng(seed).normal(size=(3, 4, 99))
    back = statistics.unnormalize(statistics.normalize(poses))
    kept = list(COLUMNS)
    np.testing.assert_allclose(back[..., kept], poses[..., kept], rtol=0, atol=1e-9)
    dropped = sorted(set(range(99)) - set(kept))
    assert (back[..., dropped] == statistics.mean[dropped]).all()


def test_clips_in_which_other_columns_vary_are_refused():
    poses = np.zeros((30, 99))
    poses[:, COLUMNS[1:]] = np.arange(30)[:, None]
    message = r"^clips: models read the 54 columns npss.protocol.COLUMNS: column 0 does not vary; train on more"
    with pytest.raises(ValueError, match=message):
        windows.training_set_of(["a"], [("a_1", "a", poses)])
    poses[:, [0, 10]] = np.arange(30)[:, None]
    with pytest.raises(ValueError, match=r"COLUMNS: column 10 varies, but models do not read it$"):
        windows.training_set_of(["a"], [("a_1", "a", poses)])


@given(lengths=st.tuples(st.integers(167, 3000), st.integers(167, 3000)))
def test_no_frame_of_a_validation_window_is_in_a_test_window(lengths):
    tested = {
        (w.clip, frame) for w in srnn_windows(lengths) for frame in range(w.start, w.start + 151)
    }  # late ones too
    found = windows.validation_windows(lengths)
    for window in found:
        assert (window.n_seed, window.n_target) == (50, 100)
        assert window.start >= windows.FIRST
        assert (window.start - windows.FIRST) % windows.STRIDE == 0
        assert window.target.stop <= lengths[window.clip]
        assert not tested & {(window.clip, frame) for frame in range(window.start, window.target.stop)}
    # Brute force: no valid window of the grid is left out.
    places = {(window.clip, window.start) for window in found}
    for clip, length in enumerate(lengths):
        for start in range(windows.FIRST, length - 149, windows.STRIDE):
            free = not tested & {(clip, frame) for frame in range(start, start + 150)}
            assert ((clip, start) in places) == free


def test_real_training_clips(h36m_root):
    training_set = Human36M().training_set(h36m_root, ["eating", "walking"], subjects=[11, 1])
    assert [(clip.name, clip.action) for clip in training_set.clips] == [
        *((f"S11/{action}_{i}.txt", label) for label, action in enumerate(("eating", "walking")) for i in (1, 2)),
        *((f"S1/{action}_{i}.txt", label) for label, action in enumerate(("eating", "walking")) for i in (1, 2)),
    ]
    assert training_set.normalization.columns == COLUMNS
    # From first principles: numpy reads the text; all rows for the statistics, every second row for windows.
    files = [h36m_root / "dataset" / clip.name for clip in training_set.clips]
    rows = [np.loadtxt(file, delimiter=",", dtype=np.float32) for file in files]
    whole = np.concatenate(rows).astype(np.float64)[:, list(COLUMNS)]
    for clip, poses in zip(training_set.clips, rows, strict=True):
        expected = (poses[::2, list(COLUMNS)] - whole.mean(axis=0)) / whole.std(axis=0)
        np.testing.assert_allclose(clip.poses, expected, rtol=0, atol=1e-4)
    batch = Batches(training_set, batch=64, n_seed=50, n_target=100, seed=0)[0]
    assert batch.poses.shape == (64, 151, 54)
    assert set(batch.label.argmax(axis=1)) == {0, 1}


def test_real_validation_windows_share_no_frame_with_test_windows(h36m_root):
    data = h36m.open_root(h36m_root)
    tasks = Human36M().validation_tasks(h36m_root, ["walking", "eating", "smoking"])
    assert [(task.action, len(task.seed_frames)) for task in tasks] == [
        ("walking", 28),
        ("eating", 48),
        ("smoking", 57),
    ]
    for task in tasks:
        (test,) = Human36M().tasks(h36m_root, [task.action])
        tested = np.concatenate([test.seed_frames, test.target], axis=1).reshape(-1, 99).astype(np.float32)
        mine = np.concatenate([task.seed_frames, task.target], axis=1).reshape(-1, 99)
        assert task.seed_frames.shape[1:] == (50, 99)
        assert task.target.shape[1:] == (100, 99)
        assert not {row.tobytes() for row in mine.astype(np.float32)} & {row.tobytes() for row in tested}
        clips = np.concatenate([h36m.load(data, TEST_SUBJECT, task.action, i, fps=25) for i in (1, 2)])
        assert {row.tobytes() for row in mine.astype(np.float32)} <= {row.tobytes() for row in clips}


def test_errors_name_an_action_without_validation_windows(monkeypatch):
    clip = np.zeros((180, 99), np.float32)
    monkeypatch.setattr(Human36M, "test_clips", lambda *_, **__: [clip, clip])
    with pytest.raises(ValueError, match=r"^actions: the test windows of posing leave no room"):
        Human36M().validation_tasks(Path(), ["posing"])


def test_statistics_are_those_of_the_protocol(h36m_root):
    data = h36m.open_root(h36m_root)
    of_protocol = normalization(h36m.training_clips(data, ["walking"]).values())
    mine = Human36M().training_set(h36m_root, ["walking"]).normalization
    assert np.array_equal(mine.mean, of_protocol.mean)
    assert np.array_equal(mine.std, of_protocol.std)
