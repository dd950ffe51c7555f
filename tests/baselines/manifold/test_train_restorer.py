"""Training of the restorer: its samples, its loss, and the command."""

import numpy as np
import pytest

pytest.importorskip("torch")
import torch

from npss_baselines.__main__ import main
from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications.simple import with_lengths
from npss_baselines.manifold.model.gaussian import fit_gaussian
from npss_baselines.manifold.motion.features import local_positions
from npss_baselines.manifold.motion.scaling import fit_scaling
from npss_baselines.manifold.motion.split import split
from npss_baselines.manifold.restorers import fill, keys
from npss_baselines.manifold.restorers.file import load
from npss_baselines.manifold.restorers.frames import Frames
from npss_baselines.manifold.restorers.net import Net
from npss_baselines.manifold.restorers.samples import CameraSampler, FillSampler, KeysSampler
from npss_baselines.manifold.restorers.training import Distance, Recipe, train_net


@pytest.fixture(scope="module")
def training(motions):
    return split(motions).training


@pytest.fixture(scope="module")
def scaling(training):
    return fit_scaling(training.windows, training.mask, "kind")


@pytest.fixture(scope="module")
def pose(training, scaling):
    return fit_gaussian(training.windows, training.mask, scaling, span=1, ridge=1e-3)


@pytest.fixture(scope="module")
def frames(training, scaling):
    return Frames(training, scaling, JOINTS)


@pytest.fixture
def rng():
    return np.random.default_rng(0)


class TestFrames:
    def test_neighbours_are_of_the_same_clip(self, frames, rng):
        drawn = frames.draw(200, rng)
        around = frames.around(drawn, [-1000, 0, 1000])
        np.testing.assert_array_equal(around[:, 1], frames.scaled[drawn])
        np.testing.assert_array_equal(around[:, 0], frames.scaled[frames.first[drawn]])
        np.testing.assert_array_equal(around[:, 2], frames.scaled[frames.last[drawn]])

    def test_all_clips_and_their_images_are_drawn(self, training, frames, rng):
        starts = np.unique(frames.first[frames.draw(5000, rng)])
        assert len(starts) == 2 * len(training.clips)


class TestSamples:
    def test_fill(self, frames, pose, rng):
        sampler = FillSampler(frames, pose, JOINTS)
        samples = sampler.draw(64, rng)
        known = ~np.repeat(samples.missing, 3, axis=1)
        np.testing.assert_allclose(samples.guess[:, :-3][known], samples.truth[:, :-3][known], atol=1e-5)
        for row in range(0, 64, 9):
            lost = fill.columns_of(samples.missing[row])
            motion = pose.scaling.unnormalize(samples.truth[row : row + 1])
            expected = pose.scaling.normalize(fill.complete(pose, motion, lost))
            np.testing.assert_allclose(samples.guess[row], expected[0], atol=1e-3)

    def test_keys(self, frames, rng):
        samples = KeysSampler(frames, JOINTS).draw(500, rng)
        assert samples.inputs.shape[1] == 1 + 4 + 4 + 4 + 6 * 63
        assert set(samples.kind) == set(range(6))
        # Close to a key, the cubic is close to the truth.
        near = samples.amount[:, 0] < np.median(samples.amount)
        error = np.abs(samples.guess - samples.truth).mean(axis=1)
        assert error[near].mean() < error[~near].mean()

    def test_camera(self, training, scaling, rng):
        gaussian = fit_gaussian(training.windows, training.mask, scaling)
        samples = CameraSampler(training, gaussian, JOINTS, 2, rng).draw(50, rng)
        assert np.isfinite(samples.inputs).all()
        assert np.abs(samples.guess - samples.truth).mean() < 0.2


class TestDistance:
    def test_it_is_the_distance_with_bones(self, frames, pose, rng):
        samples = FillSampler(frames, pose, JOINTS).draw(16, rng)
        change = rng.normal(0, 0.1, (16, 60))
        found = Distance(pose, JOINTS)(samples, torch.from_numpy(change.astype(np.float32)))
        moved = samples.guess.astype(np.float64)
        moved[:, :60] += change
        known = ~np.concatenate([np.repeat(samples.missing, 3, axis=1), np.zeros((16, 3), bool)], axis=1)
        restored = with_lengths(pose.scaling.unnormalize(moved), known, JOINTS)
        away = np.linalg.norm(
            local_positions(restored) - local_positions(pose.scaling.unnormalize(samples.truth)), axis=-1
        )
        expected = [row[missing].mean() for row, missing in zip(away, samples.missing, strict=True)]
        np.testing.assert_allclose(found, expected, atol=1e-4)


class TestTrainNet:
    def test_it_learns_and_is_reproducible(self, frames, pose):
        nets, lines = [], []
        for _ in range(2):
            rng = np.random.default_rng(1)
            sampler = FillSampler(frames, pose, JOINTS)
            nets.append(train_net(sampler, Recipe(32, 0.0, 60, 128), pose, JOINTS, rng, "fill", lines.append))
        assert all(np.array_equal(a, b) for a, b in zip(nets[0].weights, nets[1].weights, strict=True))
        assert lines[0] == lines[1]
        share = float(lines[0].split()[1])
        assert share < 0.9  # of the error of the Gaussian, on generated walks

    def test_a_net_is_its_layers(self, rng):
        weights = [rng.normal(size=shape).astype(np.float32) for shape in ((5, 7), (7, 2))]
        biases = [rng.normal(size=size).astype(np.float32) for size in (7, 2)]
        inputs = rng.normal(size=(3, 5)).astype(np.float32)
        first, last = torch.nn.Linear(5, 7), torch.nn.Linear(7, 2)
        for layer, weight, bias in zip((first, last), weights, biases, strict=True):
            layer.weight.data, layer.bias.data = torch.from_numpy(weight.T), torch.from_numpy(bias)
        expected = last(first(torch.from_numpy(inputs)).relu()).detach()
        np.testing.assert_allclose(Net(tuple(weights), tuple(biases))(inputs), expected, atol=1e-5)


def test_amounts_are_small_near_keys():
    times = np.array([[-5.0, -1, 3, 4], [-50, -20, 20, 50]])
    values = np.zeros((2, 4, 5))
    values[:, 2:] = 0.4
    amounts = keys.amount_of(values, times, np.ones((2, 4), bool))
    motion = 0.4 * np.sqrt(2 / 3) + keys.STILL
    assert amounts[:, 0].tolist() == pytest.approx([0.015 * motion, motion])


class TestCommand:
    def test_it_writes_a_restorer(self, tmp_path, capsys):
        path = tmp_path / "restorer.npz"
        assert main(["train", "restorer", "--quick", "--out", str(path)]) == 0
        restorer = load(path)
        assert capsys.readouterr().out.endswith(f"{path}: {restorer.signature}\n")
        assert restorer.seen["sources"] == ["synthetic"]
        assert "synthetic/0" not in restorer.seen["subjects"]  # held out

    @pytest.mark.parametrize(
        ("options", "message"),
        [
            (["--out", "restorer"], "--out: expected a name that ends in .npz, got restorer"),
            (["--out", "no/restorer.npz"], "--out: no: no such folder"),
        ],
    )
    def test_bad_options(self, options, message, capsys, tmp_path, monkeypatch):
        monkeypatch.chdir(tmp_path)
        assert main(["train", "restorer", "--quick", *options]) != 0
        assert message in capsys.readouterr().err
