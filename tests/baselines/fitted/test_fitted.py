"""Predictors without networks that are fitted to motion: what they read, what they predict, and their runs."""

import json
from itertools import product
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from safetensors.numpy import load_file, save_file

from npss import poses_to_euler
from npss.gait import gait
from npss.predictors import gated_periodic
from npss.rotations import expmap_to_matrix
from npss.skeleton import H36M
from npss_baselines.data.h36m_source import Human36M
from npss_baselines.data.source import PoseSource, Recording
from npss_baselines.data.synthetic import Synthetic, synthetic_task
from npss_baselines.evaluation.evaluate import evaluate
from npss_baselines.fitted import FITTED
from npss_baselines.fitted.angles import ANGLES, angles_of, mirrored, poses_of
from npss_baselines.fitted.cosine import cosines
from npss_baselines.fitted.motion import FittingClip, Motion, folds, read_motion
from npss_baselines.fitted.nearest import Nearest, NearestSettings
from npss_baselines.fitted.ridge import Ridge, RidgeSettings
from npss_baselines.runs import fitted, folder


class Few(Synthetic):
    """Few walkers with subjects; one lacks a file."""

    name = "few"
    actions = ("gait", "stroll", "march")
    train_subjects = (1, 2, 3)
    fps = 50

    def recordings(self, folder, *, actions, subjects, cache=None):
        for action, subject in product(actions, subjects):
            if (action, subject) in {("stroll", 2), ("march", 1), ("march", 2), ("march", 3)}:
                raise FileNotFoundError(f"nowhere lacks {action} of {subject}")
            seed = 10 * self.actions.index(action) + subject
            yield Recording(f"{subject}/{action}", subject, action, gait(1, 420, fps=50, seed=seed)[0])

    def clips(self, folder, **options):
        raise NotImplementedError


def motion_of(*clips, step=1):
    return Motion(
        ("walk",), 1, tuple(FittingClip("walk", i, clip.astype(np.float32), step) for i, clip in enumerate(clips))
    )


class TestAngles:
    def test_poses_have_the_angles(self):
        poses = gait(3, 40, seed=0)
        restored = poses_of(angles_of(poses), poses[:, -1])
        np.testing.assert_allclose(angles_of(restored), angles_of(poses), atol=1e-12)
        assert np.array_equal(restored[..., :6], np.repeat(poses[:, -1:, :6], 40, axis=1))
        assert np.array_equal(angles_of(poses), poses_to_euler(poses)[..., ANGLES])

    def test_mirror_images_are_reflections(self):
        """In the plane x = 0, a rotation R of a joint becomes M R M of the joint on the other side."""
        poses = gait(2, 9, seed=1)
        poses[..., :6] = 0
        reflected = poses_of(mirrored(angles_of(poses)), np.zeros((2, 99)))
        before, after = (expmap_to_matrix(p[..., 3:].reshape(2, 9, 32, 3)) for p in (poses, reflected))
        plane = np.diag([-1.0, 1, 1])
        for joint, name in enumerate(H36M.names):
            swap = {"Left": "Right", "Right": "Left"}
            side = next((side for side in swap if name.startswith(side)), "")
            other = H36M.names.index(name.replace(side, swap[side])) if side else joint
            np.testing.assert_allclose(after[:, :, other], plane @ before[:, :, joint] @ plane, atol=1e-12)

    def test_a_second_mirror_image_is_the_original(self):
        angles = angles_of(gait(1, 5, seed=2))
        assert np.array_equal(mirrored(mirrored(angles)), angles)

    def test_the_second_angle_stops_before_a_right_angle(self):
        angles = np.zeros((1, 2, 48))
        angles[..., ANGLES.index(7)] = [3.0, -3.0]
        assert np.allclose(
            angles_of(poses_of(angles, np.zeros((1, 99))))[0, :, ANGLES.index(7)], [1.5698, -1.5698], atol=1e-4
        )


@given(n_frames=st.integers(1, 60), data=st.data())
def test_cosines(n_frames, data):
    fft = pytest.importorskip("scipy.fft")
    n = data.draw(st.integers(1, n_frames))
    expected = fft.dct(np.eye(n_frames), norm="ortho", axis=0)[:n]
    np.testing.assert_allclose(cosines(n_frames, n), expected, atol=1e-12)


class TestMotion:
    def test_windows(self):
        clip = np.arange(340)[:, np.newaxis] * 1e-3 + np.arange(48)
        windows = motion_of(clip, step=2).windows(stride=10)
        starts = [0, 20, 40]  # the last window ends with row 40 + 2 * 149 = 338
        expected = np.stack([clip[start : start + 299 : 2] for start in starts]).astype(np.float32)
        assert np.array_equal(np.concatenate([windows.seed, windows.target], axis=1), expected)
        assert (windows.seed.shape, windows.target.shape) == ((3, 50, 48), (3, 100, 48))

    def test_windows_with_a_jump_are_left_out(self):
        clip = np.zeros((180, 48))
        clip[155:, 7] = 3.2  # windows from frame 10 on hold it
        assert len(motion_of(clip).windows().seed) == 1
        clip[100:, 3] = -3.2
        with pytest.raises(ValueError, match=r"^no window of 150 frames without a jump of a whole turn"):
            motion_of(clip).windows()

    def test_groups_and_actions_can_be_left_out(self):
        motion, read = read_motion(Few(), Path(), ["gait", "stroll"])
        assert read == {"gait": (1, 2, 3), "stroll": (1, 3)}
        assert motion.groups == (1, 2, 3)
        assert motion.of(without=[1]).groups == (2, 3)
        assert {clip.action for clip in motion.of(actions=["stroll"]).clips} == {"stroll"}
        windows = motion.windows()
        assert set(zip(windows.action.tolist(), windows.group.tolist(), strict=True)) == {
            (0, 0),
            (0, 1),
            (0, 2),
            (1, 0),
            (1, 2),
        }

    def test_other_actions(self):
        motion, read = read_motion(Few(), Path(), ["stroll"], others=True)
        assert read == {"stroll": (1, 3), "gait": (1, 2, 3)}
        assert (motion.actions, motion.n_predicted) == (("stroll", "gait"), 1)

    def test_subjects_of_each_action(self):
        subjects = {"gait": (2,), "stroll": (1, 3)}
        assert read_motion(Few(), Path(), ["stroll"], subjects=subjects)[1] == {"stroll": (1, 3)}
        motion, read = read_motion(Few(), Path(), ["stroll"], subjects=subjects, others=True)
        assert read == {"stroll": (1, 3), "gait": (2,)}
        assert motion.actions == ("stroll", "gait")
        with pytest.raises(FileNotFoundError, match="lacks stroll of 2"):  # one of the others: none is left out
            read_motion(Few(), Path(), ["gait"], subjects={"gait": (1,), "stroll": (2,)}, others=True)

    def test_generated_walkers_are_their_own_groups(self):
        motion, read = read_motion(Synthetic(), Path(), ["gait"])
        assert read == {"gait": ()}
        assert len(motion.groups) == 32

    @pytest.mark.parametrize(
        ("error", "actions", "subjects", "message"),
        [
            (ValueError, ["gait", "gait"], None, "^actions: expected one or more, without duplicates, got gait, gait"),
            (ValueError, [], None, "^actions: expected one or more, without duplicates, got none"),
            (ValueError, ["sit"], None, "^actions: expected one of gait, stroll, march, got 'sit'"),
            (ValueError, ["gait"], [4], "^subjects: expected some of 1, 2, 3, without duplicates; got 4"),
            (FileNotFoundError, ["stroll"], [1, 2], "lacks stroll of 2"),
            (ValueError, ["gait"], {"gait": [4]}, "^subjects: expected some of 1, 2, 3, without duplicates; got 4"),
            (ValueError, ["gait", "stroll"], {"gait": [1]}, "^subjects: expected those of gait, stroll, got none of"),
            (FileNotFoundError, ["march"], None, "no training subject has all recordings of march"),
        ],
    )
    def test_errors(self, error, actions, subjects, message):
        with pytest.raises(error, match=message):
            read_motion(Few(), Path(), actions, subjects=subjects)

    @given(n=st.integers(1, 12), k=st.integers(1, 5))
    def test_folds_are_a_partition(self, n, k):
        parts = folds(range(n), k)
        assert [group for part in parts for group in part] == list(range(n))
        assert max(map(len, parts)) - min(map(len, parts)) <= 1
        assert len(parts) == min(n, k)


def random_clips(n=2, frames=170, seed=0):
    rng = np.random.default_rng(seed)
    return [np.cumsum(rng.normal(scale=0.05, size=(frames, 48)), axis=0) for _ in range(n)]


def test_ridge_against_least_squares():
    """The penalty as further rows of an ordinary least-squares problem, whose windows are centred."""
    fft = pytest.importorskip("scipy.fft")
    motion, settings = motion_of(*random_clips()), RidgeSettings(3, 4, 0.01)
    windows = motion.windows()
    frames = np.concatenate([windows.seed, windows.target], axis=1).astype(float)
    frames = np.concatenate([frames, mirrored(frames)])

    def dct(x, n):
        return fft.dct(x, axis=1, norm="ortho")[:, :n].reshape(len(x), -1)

    def read(seed):
        return np.concatenate([dct(seed - seed[:, -1:], 3), seed[:, -1]], axis=1)

    x, y = read(frames[:, :50]), dct(frames[:, 50:] - frames[:, 49:50], 4)
    penalty = np.sqrt(0.01 * len(x)) * np.eye(x.shape[1])
    solution, *_ = np.linalg.lstsq(
        np.concatenate([x - x.mean(0), penalty]), np.concatenate([y - y.mean(0), np.zeros((len(penalty), y.shape[1]))])
    )
    seed = np.stack(random_clips(5, 50, seed=9))
    predicted = ((read(seed) - x.mean(0)) @ solution + y.mean(0)).reshape(5, 4, 48)
    expected = seed[:, -1:] + fft.idct(np.pad(predicted, ((0, 0), (0, 96), (0, 0))), axis=1, norm="ortho")
    ridge = Ridge.fit(motion, settings, seed=0, progress=lambda share: None)
    np.testing.assert_allclose(ridge.predict(seed, 0), expected, rtol=1e-8, atol=1e-8)


def test_nearest_against_a_search():
    motion, settings = motion_of(*random_clips(3)), NearestSettings(4, 6, 0.7)
    windows = motion.windows()
    frames = np.concatenate([windows.seed, windows.target], axis=1).astype(float)
    frames = [*frames, *mirrored(frames)]
    seeds = np.stack(random_clips(70, 50, seed=5))
    predicted = Nearest.fit(motion, settings, seed=0, progress=lambda share: None).predict(seeds, 0)
    for seed, result in zip(seeds, predicted, strict=True):

        def distance(window, seed=seed):
            moved = sum(np.sum((seed[t] - seed[49] - window[t] + window[49]) ** 2) for t in range(44, 49))
            return moved + 6 * 0.7**2 * np.sum((seed[49] - window[49]) ** 2)

        nearest = sorted(frames, key=distance)[:4]
        expected = np.mean([seed[49] + window[50:] - window[49] for window in nearest], axis=0)
        np.testing.assert_allclose(result, expected, rtol=1e-9, atol=1e-9)


@pytest.fixture(scope="module")
def runs(tmp_path_factory):
    """Return a function that fits a predictor to few walkers once, and returns the run and its folder."""
    made = {}

    def run(name):
        if name not in made:
            out = tmp_path_factory.mktemp(name)
            made[name] = fitted.fit(name, Synthetic(), Path(), ["gait"], seed=3), out
            made[name][0].save(out)
        return made[name]

    return run


@pytest.mark.parametrize("name", ["ridge", "nearest-10"])
class TestRuns:
    def test_a_folder_holds_all_of_it(self, name, runs):
        run, out = runs(name)
        loaded = folder.load(out)
        assert loaded.configuration == run.configuration
        seed = synthetic_task(3).seed_frames
        expected = run.predictor("gait")(seed, 100)
        assert np.array_equal(loaded.predictor("gait", seed=5)(seed, 100), expected)
        assert np.array_equal(folder.predictor_of(out, "gait", seed=5)(seed, 100), expected)

    def test_what_it_predicts(self, name, runs):
        predictor = runs(name)[0].predictor("gait")
        seed = synthetic_task(3).seed_frames
        predicted = predictor(seed, 100)
        assert predicted.shape == (3, 100, 99)
        assert np.array_equal(predictor(seed, 40), predicted[:, :40])
        assert np.array_equal(predictor(np.concatenate([seed[:, :9] + 1, seed], axis=1), 100), predicted)
        np.testing.assert_allclose(predictor(seed[:1], 100), predicted[:1], rtol=1e-9, atol=1e-11)
        assert np.array_equal(predicted[..., :6], gated_periodic(seed, 100)[..., :6])
        constant = [column for column in range(6, 99) if column not in ANGLES]
        np.testing.assert_allclose(predicted[..., constant], np.repeat(seed[:, -1:, constant], 100, axis=1), atol=1e-15)
        assert predictor(seed.astype(np.float32), 3).dtype == np.float32
        assert predictor(seed.astype(np.float64), 3).dtype == np.float64

    def test_it_is_ahead_of_zero_velocity(self, name, runs):
        task = synthetic_task(16)
        predicted = runs(name)[0].predictor("gait")(task.seed_frames, 100)
        error = np.square(angles_of(predicted) - angles_of(task.target)).mean()
        assert error < 0.6 * np.square(angles_of(task.seed_frames[:, -1:]) - angles_of(task.target)).mean()

    @pytest.mark.parametrize(
        ("error", "seed", "n_target", "message"),
        [
            (ValueError, np.zeros((1, 49, 99)), 1, "^seed_frames: 49 frames, but the predictor uses the last 50"),
            (ValueError, np.zeros((50, 99)), 1, r"^seed_frames: expected shape \(N, S, 99\), got \(50, 99\)"),
            (ValueError, np.zeros((1, 50, 98)), 1, r"^seed_frames: expected shape \(N, S, 99\), got \(1, 50, 98\)"),
            (ValueError, np.full((1, 50, 99), np.nan), 1, "^seed_frames: nan at index"),
            (TypeError, np.zeros((1, 50, 99), bool), 1, "^seed_frames: expected real numbers"),
            (ValueError, np.zeros((1, 50, 99)), 101, "^n_target: expected at most 100 frames"),
            (ValueError, np.zeros((1, 50, 99)), 0, "^n_target: expected a positive integer"),
        ],
    )
    def test_bad_input(self, name, runs, error, seed, n_target, message):
        with pytest.raises(error, match=message):
            runs(name)[0].predictor("gait")(seed, n_target)

    def test_another_action(self, name, runs):
        with pytest.raises(ValueError, match=r"^action: this predictor was fitted to gait, not to 'walking'"):
            runs(name)[0].predictor("walking")

    @pytest.mark.parametrize(
        ("field", "value", "message"),
        [
            ("seed", -1, "seed: expected an integer from 0"),
            ("seed", "0", "seed: expected an integer"),
            ("data", "nowhere", "data: expected one of"),
            ("actions", "gait", "actions: expected a list"),
            ("actions", [], "actions: expected one or more"),
            ("actions", ["sit"], "actions: expected one of gait, got 'sit'"),
            ("subjects", {}, "subjects: expected those of gait first"),
            ("subjects", {"gait": 1}, "subjects: expected an object of lists"),
            ("settings", {}, "settings: "),
            ("more", 1, "unknown field 'more'"),
        ],
    )
    def test_a_broken_configuration(self, name, runs, tmp_path, field, value, message):
        _, out = runs(name)
        values = json.loads((out / "config.json").read_text(encoding="utf-8"))
        (tmp_path / "config.json").write_text(json.dumps(values | {field: value}), encoding="utf-8")
        with pytest.raises(ValueError, match=message) as caught:
            folder.load(tmp_path)
        assert str(tmp_path / "config.json") in str(caught.value)

    def test_broken_weights(self, name, runs, tmp_path):
        _, out = runs(name)
        (tmp_path / "config.json").write_text((out / "config.json").read_text(encoding="utf-8"), encoding="utf-8")
        with pytest.raises(FileNotFoundError, match=r"model\.safetensors: no such file"):
            folder.load(tmp_path)
        file = tmp_path / "model.safetensors"
        file.write_bytes((out / "model.safetensors").read_bytes()[:-1])
        with pytest.raises(ValueError, match="not what was fitted by"):
            folder.load(tmp_path)
        arrays = load_file(out / "model.safetensors")
        first = next(iter(arrays))
        for broken in ({first: arrays[first][..., :-1]}, {"more": np.zeros(1)}, {"more": arrays.pop(first)}):
            save_file({name: np.ascontiguousarray(value) for name, value in (arrays | broken).items()}, file)
            with pytest.raises(ValueError, match="not what was fitted by"):
                folder.load(tmp_path)


def test_subjects_of_every_action_are_recorded(monkeypatch):
    from npss_baselines.data import SOURCES

    monkeypatch.setitem(SOURCES._entries, "few", Few())
    run = fitted.fit("ridge", Few(), Path(), ["stroll", "gait"])
    assert run.configuration.subjects == {"stroll": (1, 3), "gait": (1, 2, 3)}
    seed = synthetic_task(1).seed_frames
    assert not np.array_equal(run.predictor("gait")(seed, 9), run.predictor("stroll")(seed, 9))


def test_every_name_has_a_description():
    assert all(spec.name == name and spec.description for name, spec in FITTED.items())
    assert issubclass(Few, PoseSource)


# On the eight windows of walking, fitted to all training subjects: NPSS `released` and `paper`, Euler errors at 80, 400
# and 1000 ms. A solver's rounding moves ridge by far less than the tolerance.
WALKING = {
    "ridge": (0.8750, 1.6235, 0.256, 0.626, 0.749),
    "nearest-10": (0.8115, 1.4715, 0.266, 0.739, 0.859),
}


@pytest.mark.parametrize("name", WALKING)
def test_walking(name, h36m_root):
    run = fitted.fit(name, Human36M(), h36m_root, ["walking"])
    assert run.configuration.subjects == {"walking": (1, 6, 7, 8, 9, 11)}
    (task,) = Human36M().tasks(h36m_root, ["walking"])
    record = evaluate(name, run.predictor("walking"), task)
    errors = [record["euler_error"][time] for time in ("80", "400", "1000")]
    measured = [record["npss"]["released"], record["npss"]["paper"], *errors]
    np.testing.assert_allclose(measured, WALKING[name], atol=1e-3)
    assert record["signature"].endswith("|protocol:srnn-8|unwrap:off|average:at|columns:gt")
