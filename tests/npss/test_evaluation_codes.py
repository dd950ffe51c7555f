"""What public evaluation codes hold goes in as it is: one call gives the number of each.

Shapes and definitions are written from descriptions of the codes, without npss. Motion is generated.
"""

import numpy as np
import pytest

import npss
from npss.commands import main
from npss.rotations import quaternion_to_euler

RNG = np.random.default_rng


# --- motion -----------------------------------------------------------------------------------------------------------


def quaternions(*shape, seed=0):
    """Return unit quaternions ``(..., T, J, 4)`` that turn smoothly, without jumps of sign."""
    rng = RNG(seed)
    steps = rng.normal(size=(*shape, 4)) * 0.15
    q = rng.normal(size=(*shape[:-2], 1, shape[-1], 4)) + steps.cumsum(axis=-3)
    return q / np.linalg.norm(q, axis=-1, keepdims=True)


def walk(*shape, seed=0):
    return RNG(seed).normal(size=shape).cumsum(axis=-2 if len(shape) < 4 else 1)


# --- definitions ------------------------------------------------------------------------------------------------------


def spectra(x, *, part="real", one_sided=False):
    """Return the power of the bins of ``(N, T, D)``."""
    transform = (np.fft.rfft if one_sided else np.fft.fft)(np.asarray(x, np.float64), axis=1)
    return transform.real**2 if part == "real" else np.abs(transform) ** 2


def distances(gt, pred, *, cumulated=True, **options):
    """Return the L1 distances and the weights of all columns, ``(N, D)``."""
    p, q = spectra(gt, **options), spectra(pred, **options)
    difference = p / p.sum(axis=1, keepdims=True) - q / q.sum(axis=1, keepdims=True)
    if cumulated:
        difference = difference.cumsum(axis=1)
    return np.abs(difference).sum(axis=1), p.sum(axis=1)


def weighted(gt, pred, **options):
    """Return the weighted mean over all columns of the set."""
    emd, weight = distances(gt, pred, **options)
    return (emd * weight / weight.sum()).sum()


def flat(x):
    """Put the coordinates of joints side by side."""
    x = np.asarray(x, np.float64)
    return np.concatenate([x[:, :, j] for j in range(x.shape[2])], axis=-1)


def same(value, expected):
    assert value == pytest.approx(expected, rel=1e-9)


@pytest.fixture
def torch():
    return pytest.importorskip("torch")


# --- codes ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("n_frames", [5, 15, 30, 45])
def test_1_the_lafan1_benchmark(n_frames):
    """Numpy global quaternions (N, T, 22, 4)."""
    gt, pred = quaternions(6, n_frames, 22), quaternions(6, n_frames, 22, seed=1)
    same(npss.score(gt, pred, convention="released"), weighted(flat(gt), flat(pred)))


def test_2_delta_interpolator(torch):
    """Batches of 64 of float32 tensors (N, T, J, 4), a class of torchmetrics that takes the prediction first."""
    pytest.importorskip("torchmetrics")
    from npss.torchmetrics import NPSS

    gt, pred = (torch.tensor(quaternions(150, 15, 22, seed=seed), dtype=torch.float32) for seed in (0, 1))
    metric = NPSS(convention="released")
    for rows in (slice(0, 64), slice(64, 128), slice(128, None)):
        metric.update(pred[rows], gt[rows])
    same(metric.compute().item(), weighted(flat(gt), flat(pred)))


def test_3_two_stage_transformer(torch):
    """Batches of float32 tensors (N, T, J, 4) with gradients, normalised over the set; a ranking of clips."""
    gt, pred = (torch.tensor(quaternions(20, 30, 22, seed=seed), dtype=torch.float32) for seed in (0, 1))
    pred.requires_grad_()
    total = npss.Accumulator(convention="released")
    for rows in (slice(0, 12), slice(12, None)):
        total.update(gt[rows], pred[rows])
    arrays = flat(gt), flat(pred.detach())
    same(total.result(), weighted(*arrays))
    emd, weight = distances(*arrays)
    ranking = npss.report(gt, pred, convention="released").per_sequence.argsort()
    np.testing.assert_array_equal(ranking, ((emd * weight).sum(axis=1) / weight.sum(axis=1)).argsort())


def test_4_conditional_in_betweening(torch):
    """Tensors with both key frames, which are true, of the joints that have children."""
    gt, pred = (torch.tensor(quaternions(8, 32, 17, seed=seed), dtype=torch.float32) for seed in (0, 1))
    pred[:, [0, -1]] = gt[:, [0, -1]]
    same(npss.score(gt, pred, convention="released"), weighted(flat(gt), flat(pred)))


def test_7_a_folder_of_bvh_pairs():
    """(1, 50, 22, 4) for each pair, of which the mean is taken."""
    pairs = [(quaternions(1, 50, 22, seed=i), quaternions(1, 50, 22, seed=100 + i)) for i in range(5)]
    for gt, pred in pairs:
        pred[:, :10], pred[:, -25:] = gt[:, :10], gt[:, -25:]  # context
    values = [npss.score(gt, pred, convention="released") for gt, pred in pairs]
    same(np.mean(values), np.mean([weighted(flat(gt), flat(pred)) for gt, pred in pairs]))


def test_8_the_rfft_version(torch):
    """bfloat16 tensors, squared magnitude of the one-sided transform; the mean of batches."""
    gt, pred = (torch.tensor(quaternions(12, 30, 22, seed=seed)).bfloat16() for seed in (0, 1))
    pred.requires_grad_()
    theirs = {"part": "magnitude", "one_sided": True}
    batches = [slice(0, 8), slice(8, None)]
    convention = npss.Convention(bins="one-sided")
    values = [npss.score(gt[rows], pred[rows], convention=convention) for rows in batches]
    arrays = [(flat(gt[rows].double()), flat(pred[rows].detach().double())) for rows in batches]
    same(np.mean(values), np.mean([weighted(*pair, **theirs) for pair in arrays]))


@pytest.mark.parametrize("n_frames", [5, 10, 20, 30])
def test_9_hands(torch, n_frames):
    """(N, T, 90), 6D of 15 joints; spectra that are not cumulated, weighted within a sequence."""
    gt, pred = (torch.tensor(walk(7, n_frames, 90, seed=seed), dtype=torch.float32) for seed in (0, 1))
    convention = npss.Convention(power="real", distance="spectrum", zero="empty")
    emd, weight = distances(gt, pred, cumulated=False)
    theirs = (emd * weight).sum(axis=1) / weight.sum(axis=1)
    np.testing.assert_allclose(npss.report(gt, pred, convention=convention).per_sequence, theirs, rtol=1e-9)


@pytest.mark.usefixtures("gpu")
def test_9_hands_on_a_gpu(torch):
    gt, pred = (torch.tensor(walk(7, 20, 90, seed=seed), dtype=torch.float32, device="cuda") for seed in (0, 1))
    same(npss.score(gt, pred.requires_grad_(), convention="released"), weighted(gt.cpu(), pred.detach().cpu()))


@pytest.mark.parametrize("seconds", [0.4, 1, 4])
def test_10_motion_transformer(seconds):
    """A dict of Euler angles (T, 96); horizons from frame 0; predictions longer than targets."""
    n = round(seconds * 25)
    gt = {f"{i}/walking": walk(100 + 7 * i, 96, seed=i) for i in range(4)}
    pred = {name: walk(250, 96, seed=len(motion)) for name, motion in gt.items()}
    value = npss.score([*gt.values()], [*pred.values()], lengths=[n] * len(gt), convention="released")
    first = [np.stack([motion[:n] for motion in motions.values()]) for motions in (gt, pred)]
    same(value[n], weighted(*first))


def test_11_the_npss_authors(tmp_path, capsys):
    """A file of samples: exponential maps (8, 100, 99), and the curve of the Euler error."""
    rng = RNG(0)
    maps = {kind: walk(8, 100, 99, seed=seed) * 0.05 for seed, kind in enumerate(("gt", "preds"))}
    for motions in maps.values():
        motions[:, :, 6:] += rng.normal(size=93) * 0.2
    angles = [euler_of_maps(motions) for motions in maps.values()]
    norms = np.sqrt(np.square(angles[0] - angles[1]).sum(axis=-1)).mean(axis=0)
    arrays = {
        f"expmap/{kind}/walking_{i}": motion for kind, several in maps.items() for i, motion in enumerate(several)
    }
    np.savez(tmp_path / "samples.npz", mean_walking_error=norms, **arrays)
    assert main(["score", str(tmp_path / "samples.npz")]) == 0
    out = capsys.readouterr().out
    emd, weight = distances(angles[0][..., 6:], angles[1][..., 6:])
    assert f"{(emd * weight).sum() / weight.sum():.4f}" in out.partition("released")[2].splitlines()[0]
    assert f"{norms[1]:.3f}" in out.partition("Euler error 80 ms")[2].splitlines()[0]
    assert "curve is reproduced" in out


def euler_of_maps(maps):
    """Return Euler angles by Rodrigues' formula, the first six columns zero; the field's angles of rows of matrices."""
    vectors = maps.reshape(*maps.shape[:-1], 33, 3)
    angle = np.linalg.norm(vectors, axis=-1)[..., None, None]
    x, y, z = np.moveaxis(vectors / angle[..., 0], -1, 0)
    zero = np.zeros_like(x)
    cross = np.stack([np.stack(row, -1) for row in ((zero, -z, y), (z, zero, -x), (-y, x, zero))], -2)
    matrix = np.eye(3) + np.sin(angle) * cross + (1 - np.cos(angle)) * cross @ cross
    second = -np.arcsin(matrix[..., 0, 2])
    first = np.arctan2(matrix[..., 1, 2], matrix[..., 2, 2])
    third = np.arctan2(matrix[..., 0, 1], matrix[..., 0, 0])
    angles = np.stack([first, second, third], -1).reshape(maps.shape)
    angles[..., :6] = 0
    return angles


def test_12_phase_based_in_betweening(torch):
    """Clips (T, 22, 4) that differ in length; the plain mean over clips."""
    clips = [
        (torch.tensor(quaternions(n, 22, seed=n)), torch.tensor(quaternions(n, 22, seed=n + 1)))
        for n in (24, 30, 24, 51)
    ]
    theirs = [weighted(flat(gt[None]), flat(pred[None])) for gt, pred in clips]
    values = [npss.score(gt[None], pred[None], convention="released") for gt, pred in clips]
    same(np.mean(values), np.mean(theirs))
    gt, pred = map(list, zip(*clips, strict=True))
    reports = npss.report(gt, pred, convention="released")
    np.testing.assert_allclose(reports[24].per_sequence, [theirs[0], theirs[2]], rtol=1e-9)
    assert {n: len(report.per_sequence) for n, report in reports.items()} == {24: 2, 30: 1, 51: 1}
    emd, weight = zip(*(distances(flat(x[None]), flat(y[None])) for x, y in clips), strict=True)
    lengths = [len(x) for x in gt]
    fair = [w / n**2 for w, n in zip(weight, lengths, strict=True)]
    whole = sum((e / (n / 2) * w).sum() for e, w, n in zip(emd, fair, lengths, strict=True)) / sum(
        w.sum() for w in fair
    )
    same(npss.score(gt, pred, convention="released", normalize="bound"), whole)


def test_13_point_clouds():
    """(1, 128, J * 7): global positions and quaternions together, key frames included."""
    both = [
        np.concatenate([walk(1, 128, 20, 3, seed=seed), quaternions(1, 128, 20, seed=seed)], axis=-1) for seed in (0, 1)
    ]
    side_by_side = [motion.reshape(1, 128, 140) for motion in both]
    expected = weighted(flat(both[0]), flat(both[1]))
    same(npss.score(*side_by_side, convention="released"), expected)
    same(npss.score(*both, convention="released"), expected)


def test_15_text_conditioned_in_betweening():
    """(N, 263, 1, 196), padded, with lengths beside it: time is the last axis."""
    lengths = [40, 196, 120, 40]
    gt, pred = (np.moveaxis(walk(4, 196, 263, seed=seed), 1, 2)[:, :, np.newaxis] for seed in (0, 1))
    assert gt.shape == (4, 263, 1, 196)
    for motions in (gt, pred):
        for motion, n in zip(motions, lengths, strict=True):
            motion[..., n:] = np.nan
    with pytest.raises(ValueError, match=r"^gt: shape \(4, 263, 1, 196\) would be joints of 196 numbers each"):
        npss.score(gt, pred, lengths=lengths)
    gt, pred = gt[:, :, 0].swapaxes(1, 2), pred[:, :, 0].swapaxes(1, 2)
    scores = npss.score(gt, pred, lengths=lengths)
    for n in set(lengths):
        rows = [i for i, length in enumerate(lengths) if length == n]
        same(scores[n], weighted(gt[rows, :n], pred[rows, :n], part="magnitude"))
    assert 0 < npss.score(gt, pred, lengths=lengths, normalize="bound") < 1


def test_16_trajectory_dependencies(torch):
    """Tensors of exponential maps (N, T, 99), all columns compared at frames 1 3 7 9 13 24."""
    maps = [torch.tensor(walk(5, 25, 99, seed=seed) * 0.05, requires_grad=True) for seed in (0, 1)]
    errors = npss.euler_error(*map(npss.poses_to_euler, maps), columns="all")
    angles = [euler_of_maps(motion.detach().numpy()) for motion in maps]
    norms = np.sqrt(np.square(angles[0] - angles[1]).sum(axis=-1)).mean(axis=0)
    for error, frame in zip(errors.values(), (1, 3, 7, 9, 13, 24), strict=True):
        same(error, norms[frame])


def test_18_quaternet(torch):
    """Local quaternions (T, 32, 4), turned to Euler angles (T, 32, 3), of which the first joint is left out."""
    local = [torch.tensor(quaternions(25, 32, seed=seed)) for seed in (0, 1)]
    angles = [quaternion_to_euler(q, seq="ZYX")[np.newaxis, :, 1:] for q in local]
    value = npss.euler_error(*angles, at_ms=[80, 400])
    w, x, y, z = (np.stack([q.numpy()[:, 1:, i] for q in local]) for i in range(4))
    first = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    second = np.arcsin(2 * (w * y - x * z))
    third = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    square = sum(np.square(angle[0] - angle[1]) for angle in (first, second, third))
    norms = np.sqrt(square.sum(axis=-1))
    same(value[80], norms[1])
    same(value[400], norms[9])
