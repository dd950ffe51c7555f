"""Human3.6M poses as Euler angles."""

import tracemalloc

import numpy as np
import pytest

from npss import euler_error_curve, poses_to_euler
from npss.files._samples import read_poses
from npss.rotations import expmap_to_euler

pytestmark = pytest.mark.numeric

both = pytest.mark.parametrize("legacy", [False, True])


def sample(leading, dtype=np.float64):
    poses = np.random.default_rng(6).normal(size=(*leading, 99))
    poses[..., :3] *= 1000  # millimetres
    return poses.astype(dtype)


@both
@pytest.mark.parametrize("leading", [(), (1,), (7,), (2, 3), (0,), (3, 0)])
@pytest.mark.parametrize("dtype", [np.float64, np.float32])
def test_joints_are_converted_and_the_root_is_zeroed(leading, dtype, legacy):
    poses = sample(leading, dtype)
    got = poses_to_euler(poses, legacy=legacy)
    assert got.shape == poses.shape
    assert got.dtype == np.float64
    assert got.flags.c_contiguous
    assert not got[..., :6].any()
    joints = poses.astype(np.float64).reshape(*leading, 33, 3)[..., 2:, :]
    expected = expmap_to_euler(np.ascontiguousarray(joints), legacy=legacy)
    assert got.reshape(*leading, 33, 3)[..., 2:, :].tobytes() == expected.tobytes()


@both
def test_other_precisions(legacy):
    poses = np.round(sample((4,)))
    expected = poses_to_euler(poses, legacy=legacy)
    for dtype in (np.int64, np.float16, np.float32, np.longdouble, ">f8"):
        for part in (np.s_[:], np.s_[:1], np.s_[2]):
            got = poses_to_euler(poses[part].astype(dtype), legacy=legacy)
            assert got.dtype == np.float64
            assert np.array_equal(got, expected[part])
    assert np.array_equal(poses_to_euler(poses.tolist(), legacy=legacy), expected)


@both
def test_single_precision_poses_reproduce_the_curves_of_samples(samples_root, legacy):
    """The remaining difference is the released code's axis, with a relative error of 1.2e-7, as in `legacy`."""
    pytest.importorskip("h5py", reason="needs h5py")
    for path in samples_root.glob("*.h5"):
        for pair in read_poses(path):
            gt, pred = (poses_to_euler(poses.astype(np.float32), legacy=legacy) for poses in (pair.gt, pair.pred))
            curve = euler_error_curve(gt, pred)
            assert np.abs(curve - pair.stored_curve).max() < (2e-7 if legacy else 5e-7)


@both
def test_strides_and_writing(legacy):
    poses = sample((300, 4))
    before = poses.copy()
    poses.flags.writeable = False
    expected = poses_to_euler(poses, legacy=legacy)
    wide = np.zeros((4, 600, 198))
    strided = np.moveaxis(wide, 0, 1)[::2, :, ::2]
    strided[:] = poses
    for same in (strided, np.asfortranarray(poses), poses[::-1][::-1]):
        assert np.array_equal(poses_to_euler(same, legacy=legacy), expected)
    assert np.array_equal(poses, before)
    assert np.array_equal(poses_to_euler(poses[17:19], legacy=legacy), expected[17:19])


@both
@pytest.mark.parametrize("column", [0, 4, 6, 50, 98])
def test_every_column_must_be_finite(column, legacy):
    poses = sample((2, 400))
    poses[1, 390, column] = np.nan
    poses[1, 391, 0] = np.inf
    with pytest.raises(ValueError, match=rf"^poses: nan at index \(1, 390, {column}\);"):
        poses_to_euler(poses, legacy=legacy)


@both
@pytest.mark.parametrize("column", [6, 7, 98])
def test_angle_too_large(column, legacy):
    poses = sample((2, 400))
    poses[:, :, :3] = 1e300  # translations may have any size
    poses[1, 390, column] = 1e300
    joint = column - column % 3
    message = rf"^poses: an angle of 2\*\*52 rad or more at index \(1, 390, {joint}\)$"
    with pytest.raises(ValueError, match=message):
        poses_to_euler(poses, legacy=legacy)
    with pytest.raises(ValueError, match=rf"at index \({joint},\)$"):
        poses_to_euler(poses[1, 390], legacy=legacy)


def test_wrong_shape_and_kind():
    for shape in ((), (98,), (99, 1), (5, 54)):
        with pytest.raises(ValueError, match=r"^poses: expected shape \(\.\.\., 99\), got"):
            poses_to_euler(np.zeros(shape))
    with pytest.raises(TypeError, match=r"^poses: .*complex"):
        poses_to_euler(np.zeros(99, complex))


def test_memory_does_not_grow():
    poses = sample((20_000,), np.float32)
    tracemalloc.start()
    try:
        out = poses_to_euler(poses)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak - out.nbytes < 4e6
