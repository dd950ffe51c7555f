"""Errors of positions: definitions in loops, alignment by scipy, properties, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import npss
from npss import gait, records
from npss.skeleton import poses_to_positions

pytestmark = pytest.mark.numeric

seeds = st.integers(0, 2**32 - 1)


def motions(seed, n=2, frames=5, joints=4):
    gt, pred = np.random.default_rng(seed).normal(size=(2, n, frames, joints, 3))
    return gt, pred


def umeyama(truth, prediction):
    """Align one frame: the rotation by scipy, the scale by least squares."""
    x, y = truth - truth.mean(axis=0), prediction - prediction.mean(axis=0)
    turned = Rotation.align_vectors(x, y)[0].apply(y)
    return truth.mean(axis=0) + (x * turned).sum() / (turned * turned).sum() * turned


def by_definition(gt, pred, align, root=0):
    curve = np.zeros(gt.shape[1])
    for i in range(gt.shape[0]):
        for t in range(gt.shape[1]):
            truth, prediction = gt[i, t], pred[i, t]
            if align == "root":
                truth, prediction = truth - truth[root], prediction - prediction[root]
            elif align == "procrustes":
                prediction = umeyama(truth, prediction)
            norms = [
                sum((a - b) ** 2 for a, b in zip(*pair, strict=True)) ** 0.5
                for pair in zip(truth, prediction, strict=False)
            ]
            curve[t] += sum(norms) / len(norms) / gt.shape[0]
    return curve


@pytest.mark.parametrize("align", [None, "root", "procrustes"])
@given(seeds, st.integers(0, 3))
def test_equals_the_definition(align, seed, root):
    gt, pred = motions(seed)
    expected = by_definition(gt, pred, align, root)
    got = npss.position_error_curve(gt, pred, align=align, root=root)
    np.testing.assert_allclose(got, expected, rtol=1e-9)
    flat = (x.reshape(2, 5, 12) for x in (gt, pred))
    np.testing.assert_array_equal(npss.position_error_curve(*flat, align=align, root=root), got)
    times = {"fps": 10, "at_ms": (100, 300), "align": align, "root": root}
    assert npss.position_error(gt, pred, **times) == {100: got[0], 300: got[2]}
    assert npss.position_error(gt, pred, average="up-to", **times) == {100: got[0], 300: got[:3].mean()}
    assert npss.position_error(gt, pred, average="sum", **times) == {100: got[0], 300: got[:3].sum()}
    one = npss.position_error_curve(gt[0].reshape(5, 12), pred[0].reshape(5, 12), align=align, root=root)
    np.testing.assert_array_equal(one, npss.position_error_curve(gt[:1], pred[:1], align=align, root=root))


def test_at_and_up_to_rank_differently():
    gt = np.zeros((1, 2, 4, 3))
    late, early = gt.copy(), gt.copy()
    late[:, 1, :, 0], early[:, 0, :, 0], early[:, 1, :, 0] = 3, 4, 2
    times = {"fps": 10, "at_ms": [200]}
    assert npss.position_error(gt, early, **times)[200] < npss.position_error(gt, late, **times)[200]
    early_mean, late_mean = (npss.position_error(gt, x, average="up-to", **times)[200] for x in (early, late))
    assert early_mean > late_mean


@given(seeds)
def test_what_each_alignment_ignores(seed):
    gt, _ = motions(seed)
    rng = np.random.default_rng(seed)
    shift = rng.normal(size=(2, 5, 1, 3))
    turn = Rotation.random(10, random_state=seed).as_matrix().reshape(2, 5, 1, 3, 3)
    turned = (turn @ gt[..., np.newaxis])[..., 0]
    size = rng.uniform(0.1, 10, (2, 5, 1, 1))

    def error(pred, align):
        return npss.position_error_curve(gt, pred, align=align).max()

    assert error(gt + shift, None) > 1e-3
    assert error(gt + shift, "root") < 1e-12
    assert error(turned, "root") > 1e-3
    assert error(size * turned + shift, "procrustes") < 1e-10
    assert error(gt * [1, 1, -1], "procrustes") > 1e-3  # a mirror image stays one


@given(seeds, st.floats(0.1, 10))
def test_units_order_and_symmetry(seed, unit):
    gt, pred = motions(seed)
    for align in (None, "root", "procrustes"):
        one = npss.position_error_curve(gt, pred, align=align)
        np.testing.assert_allclose(
            npss.position_error_curve(unit * gt, unit * pred, align=align), unit * one, rtol=1e-10
        )
        np.testing.assert_allclose(npss.position_error_curve(gt[::-1], pred[::-1], align=align), one, rtol=1e-12)
        assert npss.position_error_curve(gt, gt, align=align).max() < 1e-12
    for align in (None, "root"):
        one, other = (npss.position_error_curve(*pair, align=align) for pair in ((gt, pred), (pred, gt)))
        np.testing.assert_allclose(one, other, rtol=1e-12)
    # Aligning is not symmetric: the scale is that of the truth.
    one, other = (npss.position_error_curve(*pair, align="procrustes") for pair in ((gt, 2 * pred), (2 * pred, gt)))
    assert not np.allclose(one, other)


@given(seeds)
def test_alignment_is_the_best_by_least_squares(seed):
    gt, pred = motions(seed, n=1, frames=1)
    aligned = umeyama(gt[0, 0], pred[0, 0])
    least = np.square(gt[0, 0] - aligned).sum()
    rng = np.random.default_rng(seed)
    for _ in range(20):
        other = Rotation.random(random_state=rng).apply(pred[0, 0]) * rng.uniform(0, 2) + rng.normal(size=3)
        assert np.square(gt[0, 0] - other).sum() > least


@pytest.mark.parametrize("scale", [1e-300, 1e-160, 1e150, 1e300])
@pytest.mark.parametrize("align", [None, "root", "procrustes"])
def test_huge_and_tiny_positions(scale, align):
    gt, pred = motions(0)
    expected = npss.position_error_curve(gt, pred, align=align)
    got = npss.position_error_curve(scale * gt, scale * pred, align=align) / scale
    np.testing.assert_allclose(got, expected, rtol=1e-6 if scale == 1e-300 else 1e-12)


def test_a_collapsed_pose_is_aligned_to_the_middle():
    gt, _ = motions(3, n=1, frames=1)
    middle = gt[0, 0] - gt[0, 0].mean(axis=0)
    expected = np.linalg.norm(middle, axis=-1).mean()
    got = npss.position_error_curve(gt, np.ones_like(gt), align="procrustes")
    np.testing.assert_allclose(got, [expected], rtol=1e-12)


def test_some_joints():
    gt, pred = motions(1, joints=6)
    for align in (None, "procrustes"):
        taken = (x[:, :, [0, 2, 3, 5]] for x in (gt, pred))
        got = npss.position_error_curve(gt, pred, joints=[3, 0, 5, 2], align=align)
        np.testing.assert_allclose(got, npss.position_error_curve(*taken, align=align), rtol=1e-12)
    taken = (x[:, :, [3, 1, 2, 0]] for x in (gt, pred))
    got = npss.position_error_curve(gt, pred, joints=[1, 2], align="root", root=3)
    np.testing.assert_array_equal(got, npss.position_error_curve(*taken, joints=[1, 2], align="root"))


def test_root_and_trajectory():
    gt, pred = motions(2)
    times = {"fps": 10, "at_ms": (100, 500)}
    expected = np.linalg.norm(gt[:, :, 1] - pred[:, :, 1], axis=-1).mean(axis=0)
    assert npss.root_error(gt, pred, root=1, **times) == pytest.approx({100: expected[0], 500: expected[4]}, rel=1e-12)
    assert npss.root_error(gt, pred, root=1, **times) == npss.position_error(gt, pred, joints=[1], **times)
    for up, kept in (("x", [1, 2]), ("y", [0, 2]), ("z", [0, 1])):
        floor = np.linalg.norm((gt - pred)[:, :, 0][..., kept], axis=-1).mean(axis=0)
        got = npss.trajectory_error(gt, pred, up=up, average="sum", **times)
        assert got == pytest.approx({100: floor[0], 500: floor.sum()}, rel=1e-12)
    still = gt - gt[:, :, :1] + 5
    for call in (npss.root_error, lambda *pair, **options: npss.trajectory_error(*pair, up="y", **options)):
        with pytest.raises(ValueError, match=r"^gt: the root never moves"):
            call(still, pred, **times)


GOLDEN = {
    "position_error|version:1|fps:25|align:none|average:at": 5.0,
    "position_error|version:1|fps:25|align:none|average:up-to": 3.75,
    "position_error|version:1|fps:25|align:none|average:sum": 7.5,
    "position_error|version:1|fps:25|align:root|average:at": 10.0,
}


@pytest.mark.parametrize("signature", GOLDEN)
def test_golden_values(signature):
    """Two joints: the second is 5 and then 10 units off, the root is not; by hand."""
    gt = np.zeros((1, 2, 2, 3))
    pred = gt.copy()
    pred[0, 0, 1], pred[0, 1, 1] = [3, 4, 0], [6, 0, 8]
    values = npss.parse_signature(signature)
    align = values["extra"]["align"]
    if align == "root":
        pred[0, 1, 0], pred[0, 1, 1] = [6, 0, 8], [0, 0, 0]
        expected = {80: GOLDEN[signature] / 2}
    else:
        expected = {80: GOLDEN[signature]}
    options = {"average": values["average"], "align": None if align == "none" else align}
    assert npss.position_error(gt, pred, at_ms=[80], **options) == pytest.approx(expected, rel=1e-12)
    again = npss.signature(None, metric="position_error", fps=25, average=options["average"], extra={"align": align})
    assert again == signature


@pytest.mark.parametrize(
    ("arrays", "options", "error", "message"),
    [
        ((np.ones((2, 5, 7)),) * 2, {}, ValueError, r"gt: expected \(N, T, J, 3\), \(N, T, 3 J\) or \(T, 3 J\), got"),
        ((np.ones((2, 5, 4, 2)),) * 2, {}, ValueError, r"gt: expected \(N, T, J, 3\)"),
        (
            (np.ones((2, 5, 3, 3)),) * 2,
            {},
            ValueError,
            r"gt: shape \(2, 5, 3, 3\) may be rotation matrices of one",
        ),
        ((np.ones((2, 0, 4, 3)),) * 2, {}, ValueError, "gt: no frames in an array of shape"),
        ((np.ones((2, 5, 6)), np.ones((2, 5, 9))), {}, ValueError, r"pred: its shape .* nothing is broadcast"),
        ((np.ones((2, 5, 6)), np.full((2, 5, 6), np.nan)), {}, ValueError, r"pred: nan at index \(0, 0, 0\)"),
        ((np.ones((2, 5, 6), bool),) * 2, {}, TypeError, "gt: expected real numbers, got booleans"),
        ((np.ones((2, 5, 6)),) * 2, {"align": "PA"}, ValueError, "align: expected one of root, procrustes, got 'PA'"),
        ((np.ones((2, 5, 6)),) * 2, {"align": 1}, TypeError, "align: expected one of"),
        ((np.ones((2, 5, 6)),) * 2, {"align": "procrustes"}, ValueError, "joints: expected at least 3 to align, got 2"),
        ((np.ones((2, 5, 6)),) * 2, {"align": "root", "root": 2}, ValueError, "root: expected indices from 0 to 1"),
        ((np.ones((2, 5, 6)),) * 2, {"align": "root", "root": "x"}, TypeError, "root: expected the index of a joint"),
        ((np.ones((2, 5, 6)),) * 2, {"joints": [2]}, ValueError, "joints: expected indices from 0 to 1, got 2"),
        ((np.ones((2, 5, 6)),) * 2, {"joints": [-1]}, ValueError, "joints: expected indices from 0 to 1, got -1"),
        ((np.ones((2, 5, 6)),) * 2, {"joints": [0, 0]}, ValueError, "joints: expected different indices"),
        ((np.ones((2, 5, 6)),) * 2, {"joints": []}, ValueError, "joints: expected different indices"),
        ((np.ones((2, 5, 6)),) * 2, {"joints": 1}, TypeError, "joints: expected a sequence of"),
        ((np.ones((2, 5, 6)),) * 2, {"joints": [0.0]}, TypeError, "joints: expected indices of joints, got 0.0"),
        ((np.ones((2, 5, 6)),) * 2, {"average": "mean"}, ValueError, "average: expected one of at, up-to, sum"),
        ((np.ones((2, 5, 6)),) * 2, {"at_ms": [90]}, ValueError, "at_ms: 90 ms is not a whole number of frames"),
        ((np.ones((2, 5, 6)),) * 2, {"at_ms": [400]}, ValueError, "at_ms: 400 ms is out of range"),
        (
            (np.full((1, 5, 6), 1e308), np.full((1, 5, 6), -1e308)),
            {},
            ValueError,
            "pred: its distance from gt is beyond",
        ),
    ],
)
def test_what_is_refused(arrays, options, error, message):
    with pytest.raises(error, match=f"^{message}"):
        npss.position_error(*arrays, **{"at_ms": [80], **options})


# ---- as metrics of records, tables and comparisons


def test_records_of_positions():
    gt, pred = (gait.gait(3, 12, seed=seed) for seed in (0, 1))
    names = ["position_error", "aligned_position_error", "rotation_error"]
    angles = [npss.poses_to_euler(x) for x in (gt, pred)]
    record = records.measure(*angles, fps=25, at_ms=[80, 400], metrics=names, poses=(gt, pred), sequences=True)
    positions = [poses_to_positions(x) for x in (gt, pred)]
    for heading, align in (("Position error", None), ("Aligned position error", "procrustes")):
        for time, error in npss.position_error(*positions, at_ms=[80, 400], align=align).items():
            column = f"{heading} {time} ms"
            assert record["metrics"][column] == pytest.approx(error, rel=1e-12)
            assert np.mean(record["sequences"]["metrics"][column]) == pytest.approx(error, rel=1e-12)
            values = npss.parse_signature(record["signatures"][column])
            assert values["average"] == "at"
            assert values["extra"] == {"align": align or "none", "root": "fixed"}
    with pytest.raises(ValueError, match=r"^gt: the root never moves"):
        records.measure(*angles, fps=25, at_ms=[80], metrics=["root_error"], poses=(gt, pred))
    comparison = npss.compare(positions[0], positions[1], positions[0], metric="position_error", fps=25, at_ms=400)
    assert comparison.difference == pytest.approx(record["metrics"]["Position error 400 ms"])
    assert "root" not in comparison.signature


def test_root_errors_of_positions():
    gt, pred = motions(4)
    metrics = npss.metrics.METRICS
    measured = metrics["root_error"].measure(gt, pred, fps=25, at_ms=80)
    assert measured.value == pytest.approx(npss.root_error(gt, pred, at_ms=[80])[80], rel=1e-12)
    measured = metrics["trajectory_error"].measure(gt, pred, fps=25, at_ms=80)
    assert measured.value == pytest.approx(npss.trajectory_error(gt, pred, up="y", at_ms=[80])[80], rel=1e-12)


def test_a_path_beyond_float64_is_refused():
    gt = np.zeros((1, 3, 1, 3))
    gt[0, :, 0, 0] = [0, 1e308, 1.5e308]
    with pytest.raises(ValueError, match=r"^pred: the distance of its root from that of gt is beyond float64"):
        npss.trajectory_error(gt, -gt, up="y", fps=25, at_ms=[80])
