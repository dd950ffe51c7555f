"""The error of rotations: against scipy in every representation, units, and what is refused."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import npss
from npss import gait, rotations
from rotation_strategies import FORMS

pytestmark = pytest.mark.numeric


def angles(seed, n=2, frames=4, joints=3):
    """Return random rotation vectors of a truth and a prediction, and the angles between them, ``(N, T, J)``."""
    rng = np.random.default_rng(seed)
    gt, pred = rng.normal(size=(2, n * frames * joints, 3))
    between = (Rotation.from_rotvec(gt).inv() * Rotation.from_rotvec(pred)).magnitude()
    shape = (n, frames, joints)
    return gt.reshape(*shape, 3), pred.reshape(*shape, 3), between.reshape(shape)


def in_form(v, form):
    return v if form == "expmap" else getattr(rotations, f"expmap_to_{form}")(v)


@pytest.mark.parametrize("form", FORMS)
@given(st.integers(0, 2**32 - 1))
def test_equals_the_definition(form, seed):
    *motions, between = angles(seed, joints=2)
    gt, pred = (in_form(v, form) for v in motions)
    curve = between.mean(axis=(0, 2))
    options = {"representation": form, "fps": 10, "at_ms": (100, 400)}
    got = npss.rotation_error(gt, pred, **options)
    assert got == pytest.approx({100: curve[0], 400: curve[3]}, abs=1e-13)
    flat = (x.reshape(2, 4, -1) for x in (gt, pred))
    assert npss.rotation_error(*flat, **options) == got
    degrees = npss.rotation_error(gt, pred, unit="deg", average="up-to", **options)
    assert degrees == pytest.approx({100: np.degrees(curve[0]), 400: np.degrees(curve.mean())}, abs=1e-11)
    summed = npss.rotation_error(gt, pred, average="sum", joints=[1], **options)
    alone = between[:, :, 1].mean(axis=0)
    assert summed == pytest.approx({100: alone[0], 400: alone.sum()}, abs=1e-12)


@given(st.integers(0, 2**32 - 1))
def test_it_ignores_signs_frames_and_order(seed):
    gt, pred, _ = angles(seed)
    options = {"fps": 10, "at_ms": [400]}
    error = npss.rotation_error(gt[:, :, :2], pred[:, :, :2], representation="expmap", **options)[400]
    q, p = (rotations.expmap_to_quaternion(x[:, :, :2]) for x in (gt, pred))
    signs = np.random.default_rng(seed).choice([-1, 1], size=(2, 4, 2, 1))
    same = npss.rotation_error(q, signs * p, representation="quaternion", **options)[400]
    assert same == pytest.approx(error, abs=1e-13)
    swapped = npss.rotation_error(p, q, representation="quaternion", **options)[400]
    assert swapped == pytest.approx(error, abs=1e-13)
    turn = Rotation.random(random_state=seed).as_matrix()
    R, S = (turn @ rotations.quaternion_to_matrix(x) for x in (q, p))
    assert npss.rotation_error(R, S, representation="matrix", **options)[400] == pytest.approx(error, abs=1e-13)
    other = rotations.expmap_to_matrix(rotations.quaternion_to_expmap(p) * 1.1)
    assert abs(npss.rotation_error(R, turn @ other, representation="matrix", **options)[400] - error) > 1e-6


def test_sequences_and_layouts():
    gt, pred, between = angles(0, joints=2)
    options = {"fps": 10, "at_ms": [100]}
    expected = {100: between[:, 0].mean()}
    for seq in ("ZYX", "xyz"):
        pair = (rotations.expmap_to_euler(x, seq=seq) for x in (gt, pred))
        assert npss.rotation_error(*pair, representation="euler", seq=seq, **options) == pytest.approx(expected)
    pair = (rotations.expmap_to_sixd(x, layout="rows") for x in (gt, pred))
    assert npss.rotation_error(*pair, representation="sixd", layout="rows", **options) == pytest.approx(expected)


def test_golden_value_with_its_signature():
    gt = np.zeros((1, 2, 6))
    pred = gt.copy()
    pred[0, 1] = [0, 0, 0.5, 0, -0.25, 0]
    text = "rotation_error|version:1|fps:25|average:at|unit:rad"
    assert npss.signature(None, metric="rotation_error", fps=25, average="at", extra={"unit": "rad"}) == text
    assert npss.rotation_error(gt, pred, representation="expmap", at_ms=[80]) == pytest.approx({80: 0.375}, rel=1e-13)


def test_the_registered_metric_of_poses():
    gt, pred = (gait.gait(3, 8, seed=seed) for seed in (0, 1))
    measured = npss.metrics.METRICS["rotation_error"].measure(gt, pred, fps=25, at_ms=200)
    joints = (x[..., 6:] for x in (gt, pred))
    expected = npss.rotation_error(*joints, representation="expmap", at_ms=[200])[200]
    assert measured.value == pytest.approx(expected, rel=1e-13)
    stated = npss.metrics.METRICS["rotation_error"].stated()
    assert stated == {"average": "at", "extra": {"joints": "all scored", "unit": "rad"}}


@pytest.mark.parametrize(
    ("gt", "options", "error", "message"),
    [
        (
            np.ones((2, 4, 5)),
            {},
            ValueError,
            r"gt: expected \(N, T, J, 4\), \(N, T, 4 J\) or \(T, 4 J\), got \(2, 4, 5\)",
        ),
        (
            np.ones((2, 4, 3, 3)),
            {"representation": "matrix"},
            ValueError,
            r"gt: shape .* may be rotation matrices of one",
        ),
        (
            np.ones((2, 4, 3, 3)),
            {"representation": "expmap"},
            ValueError,
            r"gt: shape .* may be rotation matrices of one",
        ),
        (
            np.ones((2, 4, 2, 3, 3)),
            {"representation": "matrix"},
            ValueError,
            r"gt: not a rotation matrix .* \(0, 0, 0\)",
        ),
        (np.zeros((2, 4, 4)), {}, ValueError, r"gt: a zero quaternion, not a rotation, at index \(0, 0, 0\)"),
        (np.ones((2, 4, 4)), {"unit": "degrees"}, ValueError, "unit: expected one of rad, deg"),
        (np.ones((2, 4, 4)), {"representation": "quat"}, ValueError, "representation: expected one of"),
        (np.ones((2, 4, 4)), {"average": "mean"}, ValueError, "average: expected one of"),
        (np.ones((2, 4, 4)), {"joints": [1]}, ValueError, "joints: expected indices from 0 to 0"),
    ],
)
def test_what_is_refused(gt, options, error, message):
    with pytest.raises(error, match=f"^{message}"):
        npss.rotation_error(gt, gt, **{"representation": "quaternion", "at_ms": [80], **options})


@pytest.mark.parametrize(
    ("features", "representation", "message"),
    [
        (15, "expmap", "gt: expected Human3.6M poses, exponential maps of 99 features, got 15"),
        (99, "euler", "representation: 'rotation_error' takes poses, exponential maps, not 'euler'"),
    ],
)
def test_the_metric_takes_poses_only(features, representation, message):
    gt = np.random.default_rng(0).normal(size=(4, 5, features))
    with pytest.raises(ValueError, match=f"^{message}"):
        npss.compare(gt, gt, gt, metric="rotation_error", representation=representation, fps=25, at_ms=80)
