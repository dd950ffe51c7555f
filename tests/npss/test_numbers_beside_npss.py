"""The numbers that public evaluation codes print beside NPSS: from what they hold, each in one call.

The numbers of the tests are those of the codes, as in test_evaluation_codes.py. Each definition is written from the
description of the code, without npss. Motion is generated.
"""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import npss
from npss import stochastic
from npss.rotations import matrix_to_euler
from npss.skeleton import H36M, poses_to_positions

pytestmark = pytest.mark.numeric


@pytest.fixture
def rng():
    return np.random.default_rng(0)


def tensor(array):
    """Return a torch tensor, as most codes hold, or the array where torch is missing."""
    try:
        import torch
    except ImportError:
        return array
    return torch.from_numpy(np.ascontiguousarray(array)).requires_grad_()


def released(gt, pred):
    """Return NPSS by the released code, for ``(N, T, D)``."""
    x, y = (np.square(np.fft.fft(motion, axis=1).real) for motion in (gt, pred))
    weight = x.sum(axis=1)
    shares = [power / power.sum(axis=1, keepdims=True) for power in (x, y)]
    distance = np.abs(np.cumsum(shares[0], axis=1) - np.cumsum(shares[1], axis=1)).sum(axis=1)
    return (weight * distance).sum() / weight.sum()


def mean_distance(gt, pred):
    """Return the mean distance of joints in every frame."""
    return np.sqrt(np.square(gt - pred).sum(axis=-1)).mean(axis=(0, 2))


def rotations(rng, *leading):
    flat = Rotation.random(math.prod(leading), random_state=rng).as_matrix()
    return flat.reshape(*leading, 3, 3)


def angles(gt, pred):
    """Return the angles between matrices ``(N, T, J, 3, 3)``, by their trace."""
    trace = np.einsum("...ij,...ij->...", gt, pred)
    return np.arccos(np.clip((trace - 1) / 2, -1, 1))


def test_5_in_between_of_styles(rng):
    """RSMT: global positions by condition and method; position error of all and of the last frame."""
    for n_frames in (10, 20, 40):
        quaternions, positions = rng.normal(size=(2, 3, n_frames, 23, 4)), rng.normal(size=(2, 3, n_frames, 23, 3))
        results = {
            "style": {"truth": map(tensor, (quaternions[0], positions[0])), "model": (quaternions[1], positions[1])}
        }
        (gt, places), (pred, predicted) = results["style"].values()
        expected = released(*(x.reshape(3, n_frames, 92) for x in quaternions))
        assert npss.score(gt, pred, convention="released") == pytest.approx(expected, rel=1e-10)
        curve = mean_distance(*positions)
        end = {"fps": 30, "at_ms": [n_frames * 1000 / 30]}
        assert [*npss.position_error(places, predicted, **end).values()] == pytest.approx([curve[-1]])
        assert [*npss.position_error(places, predicted, average="up-to", **end).values()] == pytest.approx(
            [curve.mean()]
        )


def test_6_long_in_between(rng):
    """Local 6D of all joints and the root behind; the path on the floor."""
    gt, pred = rng.normal(size=(2, 4, 30, 22 * 6 + 3))
    floor = np.sqrt(np.square(gt - pred)[..., [-3, -1]].sum(axis=-1)).mean()
    got = npss.trajectory_error(
        tensor(gt)[..., -3:], tensor(pred)[..., -3:], up="y", fps=30, at_ms=[1000], average="up-to"
    )
    assert got[1000] == pytest.approx(floor)


def test_9_hands(rng):
    """6D of 15 joints, ``(N, T, 90)``: the angle in degrees."""
    for n_frames in (5, 10, 20, 30):
        gt, pred = rotations(rng, 2, n_frames, 15), rotations(rng, 2, n_frames, 15)
        sixd = (x[..., :2].swapaxes(-1, -2).reshape(2, n_frames, 90) for x in (gt, pred))
        got = npss.rotation_error(
            *map(tensor, sixd),
            representation="sixd",
            unit="deg",
            fps=30,
            at_ms=[n_frames * 1000 / 30],
            average="up-to",
        )
        assert [*got.values()] == pytest.approx([np.degrees(angles(gt, pred)).mean()], rel=1e-6)


def spectra(motion):
    """Return the shares of power of each feature, of the whole set."""
    power = np.square(np.abs(np.fft.fft(motion, axis=1))).sum(axis=0) + 1e-8
    return power / power.sum(axis=0)


def test_10_motion_transformer(rng):
    """A dict of ``(T, 96)``: KL and entropy of each second, predictions longer than targets."""
    targets = {f"{i}/walking": rng.normal(size=(50, 96)) for i in range(4)}
    predictions = {key: rng.normal(size=(100, 96)) for key in targets}
    for second in range(2):
        frames = slice(25 * second, 25 * second + 25)
        gt = [motion[frames] for motion in targets.values()]
        pred = [motion[frames] for motion in predictions.values()]
        p, q = spectra(np.stack(gt)), spectra(np.stack(pred))
        assert npss.spectrum_divergence(gt, pred) == pytest.approx((p * np.log(p / q)).sum(axis=0).mean(), rel=1e-10)
        backwards = npss.spectrum_divergence(gt, pred, direction="pred-gt")
        assert backwards == pytest.approx((q * np.log(q / p)).sum(axis=0).mean(), rel=1e-10)
        assert npss.spectrum_entropy(pred) == pytest.approx(-(q * np.log(q)).sum(axis=0).mean(), rel=1e-12)
    training = rng.normal(size=(9, 25, 96))
    p = spectra(training)
    assert npss.spectrum_divergence(training, pred) == pytest.approx((p * np.log(p / q)).sum(axis=0).mean(), rel=1e-10)


def test_14_stochastic_prediction(rng):
    """50 samples of positions without the root: NPSS, and the five distances."""
    gt, samples, contexts = rng.normal(size=(3, 20, 48)), rng.normal(size=(50, 3, 20, 48)), rng.normal(size=(3, 48))
    truth, drawn = tensor(gt), tensor(samples)
    scores = [released(gt, sample) for sample in samples]
    assert stochastic.score(truth, drawn, convention="released") == pytest.approx(np.mean(scores), rel=1e-10)
    norms = np.sqrt(np.square(samples - gt).sum(axis=-1))
    assert stochastic.ade(truth, drawn) == pytest.approx(norms.mean(axis=-1).min(axis=0).mean())
    assert stochastic.fde(truth, drawn) == pytest.approx(norms[..., -1].min(axis=0).mean())
    pairs = [np.sqrt(np.square(a - b).sum(axis=(1, 2))).mean() for i, a in enumerate(samples) for b in samples[:i]]
    assert stochastic.apd(drawn) == pytest.approx(np.mean(pairs))
    threshold = np.linalg.norm(contexts[0] - contexts[1]) * 1.0001  # the first two, and any that are nearer
    similar = [[j for j in range(3) if np.linalg.norm(contexts[i] - contexts[j]) < threshold] for i in range(3)]
    to = np.sqrt(np.square(samples[:, :, np.newaxis] - gt).sum(axis=-1))  # (S, N, M, T)
    for metric, over_frames in ((stochastic.mmade, to.mean(axis=-1)), (stochastic.mmfde, to[..., -1])):
        expected = np.mean([over_frames[:, i, similar[i]].min(axis=0).mean() for i in range(3)])
        assert metric(truth, drawn, contexts, threshold=threshold) == pytest.approx(expected)


def forward(pose):
    """Return the joints of a Human3.6M pose, with row vectors as the files are made for; the root stays in place."""
    turned, places = [], []
    for j, parent in enumerate(H36M.parents):
        if parent < 0:
            turned.append(np.eye(3))
            places.append(np.zeros(3))
        else:
            turned.append(Rotation.from_rotvec(pose[3 + 3 * j : 6 + 3 * j]).as_matrix() @ turned[parent])
            places.append(H36M.offsets[j] @ turned[parent] + places[parent])
    return np.array(places)


def test_16_trajectory_dependencies(rng):
    """Exponential maps, columns 0-5 zeroed, all joints: MPJPE in millimetres at frames 1 3 7 9 13 24."""
    gt, pred = rng.normal(size=(2, 2, 25, 99)) * 0.3
    gt[..., :6] = pred[..., :6] = 0
    places = [np.array([[forward(pose) for pose in sequence] for sequence in poses]) for poses in (gt, pred)]
    curve = mean_distance(*places)
    got = npss.position_error(poses_to_positions(tensor(gt)), poses_to_positions(tensor(pred)))
    assert list(got) == [80, 160, 320, 400, 560, 1000]
    assert list(got.values()) == pytest.approx(curve[[1, 3, 7, 9, 13, 24]])


def test_17_structured_prediction(rng):
    """AMASS: matrices at 60 frames per second; Euler columns of the set, sums up to a frame, still windows count 0."""
    gt, pred = rotations(rng, 5, 24, 15), rotations(rng, 5, 24, 15)
    gt[:, :, 3] = gt[0, 0, 3]  # a joint that never moves
    gt[2] = gt[2, :1]  # a still window ...
    times = {"fps": 60, "at_ms": [100, 200, 300, 400]}
    frames = np.array([6, 12, 18, 24]) - 1
    x, y = (matrix_to_euler(motion).reshape(5, 24, 45) for motion in (gt, pred))
    columns = x.reshape(-1, 45).std(axis=0) > 1e-4
    assert columns.sum() == 42
    curve = np.sqrt(np.square(x - y)[..., columns].sum(axis=-1)).mean(axis=0)
    got = npss.euler_error(matrix_to_euler(gt), matrix_to_euler(pred), columns="set", average="sum", **times)
    assert list(got.values()) == pytest.approx(np.cumsum(curve)[frames])
    # ... which counts 0 where columns are chosen by window.
    moving = x.std(axis=1) > 1e-4
    assert not moving[2].any()
    by_window = np.sqrt((np.square(x - y) * moving[:, np.newaxis]).sum(axis=-1)).mean(axis=0)
    got = npss.euler_error(matrix_to_euler(gt), matrix_to_euler(pred), still="zero", average="sum", **times)
    assert list(got.values()) == pytest.approx(np.cumsum(by_window)[frames])
    got = npss.rotation_error(gt, pred, representation="matrix", average="sum", **times)
    assert list(got.values()) == pytest.approx(np.cumsum(angles(gt, pred).mean(axis=(0, 2)))[frames], rel=1e-6)
    places, predicted = rng.normal(size=(2, 5, 24, 15, 3))
    got = npss.position_error(places, predicted, average="sum", **times)
    assert list(got.values()) == pytest.approx(np.cumsum(mean_distance(places, predicted))[frames])


def test_19_a_user_of_6d(rng):
    """Clips of 6D with a root: RMSE, and the error of the root."""
    gt, pred = rng.normal(size=(2, 1, 40, 135))
    assert math.sqrt(npss.mse(tensor(gt), tensor(pred))) == pytest.approx(np.sqrt(np.square(gt - pred).mean()))
    root = np.sqrt(np.square(gt - pred)[..., -3:].sum(axis=-1)).mean()
    got = npss.root_error(tensor(gt)[..., -3:], tensor(pred)[..., -3:], fps=30, at_ms=[40 * 1000 / 30], average="up-to")
    assert [*got.values()] == pytest.approx([root])
