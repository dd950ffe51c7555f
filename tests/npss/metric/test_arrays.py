"""Arrays as evaluation code holds them: joints, matrices, tensors, arrays of other libraries."""

import re

import numpy as np
import pytest

import npss
from npss.commands import main
from npss.metrics import Metric, register
from npss.validation import motion_pair, real_array

N, T, J, C = 3, 12, 5, 4
FUNCTIONS = {
    "score": npss.score,
    "score_windows": lambda g, p, **o: npss.score_windows(g, p, fps=3, edges_ms=(0, 2000, 4000), **o),
    "report": lambda g, p, **o: float(npss.report(g, p, **o)),
    "compare": lambda g, p, **o: npss.compare(g, p, -2 * np.asarray(p) + 1, **o).difference,
    "diagnose": npss.diagnose,
    "Accumulator": lambda g, p, **o: npss.Accumulator(**o).update(g, p).result(),
}
WITHOUT_REPRESENTATION = {
    "euler_error": lambda g, p: npss.euler_error(g, p, fps=3, at_ms=(1000, 4000)),
    "euler_error_curve": lambda g, p: npss.euler_error_curve(g, p).tolist(),
    "mse": npss.mse,
    "speed_ratio": npss.speed_ratio,
}
EVERY = FUNCTIONS | WITHOUT_REPRESENTATION


def motions(*shape, seed=0):
    return np.random.default_rng(seed).normal(size=(2, *shape)).cumsum(axis=2)


# --- shapes -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", EVERY)
def test_joints_are_flattened_one_by_one(name):
    gt, pred = motions(N, T, J, C)
    flat = [np.stack([motion[:, :, j, c] for j in range(J) for c in range(C)], -1) for motion in (gt, pred)]
    assert EVERY[name](gt, pred) == EVERY[name](*flat)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_matrices_are_flattened_row_by_row(name):
    gt, pred = motions(N, T, J, 3, 3)
    flat = [motion.reshape(N, T, J * 9) for motion in (gt, pred)]
    assert FUNCTIONS[name](gt, pred, representation="matrix") == FUNCTIONS[name](*flat, representation="matrix")


def test_three_axes_are_never_one_sequence_of_joints():
    gt, pred = motions(N, T, J, C)[:, 0]  # (T, J, C), read as T sequences of J frames
    with pytest.raises(ValueError, match=r"^(at_ms|edges_ms)"):  # which are fewer than the times need
        npss.score_windows(gt, pred, fps=3, edges_ms=(0, 4000))
    assert motion_pair(gt, pred)[0].shape == (T, J, C)
    assert motion_pair(gt[None], pred[None])[0].shape == (1, T, J * C)


@pytest.mark.parametrize("name", EVERY)
def test_three_by_three_is_refused_with_advice(name):
    gt, pred = motions(N, T, 3, 3)
    with pytest.raises(ValueError, match=r"^gt: shape \(3, 12, 3, 3\) may be rotation matrices of one joint or posi"):
        EVERY[name](gt, pred)
    text = r"pass x\[:, :, None\] with representation='matrix' for the matrices, x.reshape\(N, T, 9\) for the positions"
    with pytest.raises(ValueError, match=text):
        EVERY[name](gt, pred)
    positions = EVERY[name](gt.reshape(N, T, 9), pred.reshape(N, T, 9))
    if name in FUNCTIONS:
        with pytest.raises(ValueError, match=text):
            FUNCTIONS[name](gt, pred, representation="matrix")
        assert FUNCTIONS[name](gt[:, :, None], pred[:, :, None], representation="matrix") == positions


@pytest.mark.parametrize("name", FUNCTIONS)
def test_matrices_have_five_axes(name):
    joints = motions(N, T, J, C)
    with pytest.raises(
        ValueError, match=r"^gt: expected rotation matrices \(N, T, J, 3, 3\), got shape \(3, 12, 5, 4\)"
    ):
        FUNCTIONS[name](*joints, representation="matrix")
    with pytest.raises(ValueError, match=r"^gt: expected rotation matrices \(N, T, J, 3, 3\), got shape"):
        FUNCTIONS[name](*motions(N, T, J, 3, 4), representation="matrix")
    with pytest.raises(
        ValueError, match=r"^gt: .*got \(3, 12, 5, 3, 3\); for rotation matrices, pass representation='ma"
    ):
        FUNCTIONS[name](*motions(N, T, J, 3, 3))
    for wrong in (3, ["matrix"]):
        with pytest.raises(TypeError, match=r"^representation: expected text, got"):
            FUNCTIONS[name](*joints, representation=wrong)


def test_joints_that_differ_are_not_the_same_features():
    gt, pred = motions(N, T, J, C)
    for function in (npss.score, npss.report, npss.diagnose, npss.euler_error):
        with pytest.raises(
            ValueError, match=r"^pred: its shape \(3, 12, 4, 5\) differs from that of gt, \(3, 12, 5, 4\)"
        ):
            function(gt, pred.reshape(N, T, C, J))
    with pytest.raises(ValueError, match=r"^pred_b: its shape \(3, 12, 20\) differs from that of gt, \(3, 12, 5, 4\)"):
        npss.compare(gt, pred, pred.reshape(N, T, J * C))


@pytest.mark.parametrize("name", EVERY)
def test_a_bad_value_of_a_joint_has_its_own_index(name):
    gt, pred = motions(N, T, J, C)
    gt[1, 2, 3, 0] = np.nan
    with pytest.raises(ValueError, match=r"^gt: nan at index \(1, 2, 3, 0\)"):
        EVERY[name](gt, pred)


def test_metrics_of_positions_keep_their_joints():
    def largest(gt, pred):
        assert gt.shape == (N, T, 3, 3)
        return np.abs(gt - pred).max(axis=(1, 2, 3))

    metric = register(Metric(name="largest_joint", function=largest, says="x", takes="positions"), replace=True)
    assert npss.compare(*motions(N, T, 3, 3), np.zeros((N, T, 3, 3)), metric=metric.name).a > 0


def test_accumulators_state_their_representation():
    matrices = npss.Accumulator(representation="matrix").update(*motions(N, T, J, 3, 3))
    assert matrices.report()["signature"] == "npss|version:1|convention:paper|representation:matrix|frames:12"
    assert npss.Accumulator.from_state(matrices.state()).state() == matrices.state()
    assert (matrices | matrices).report()["sequences"] == 2 * N
    with pytest.raises(ValueError, match=r"^representation: matrix cannot be merged into None"):
        npss.Accumulator() | matrices


@pytest.mark.parametrize("shape", [(N, T, J, C), (N, T, J, 3, 3)])
def test_files(tmp_path, capsys, shape):
    paths = [tmp_path / "gt.npy", tmp_path / "pred.npy"]
    for path, motion in zip(paths, motions(*shape), strict=True):
        np.save(path, motion)
    options = ["--representation", "matrix"] if len(shape) == 5 else []
    assert main(["score", *map(str, paths), "--convention", "paper", *options]) == 0
    expected = npss.score(*(motion.reshape(N, T, -1) for motion in motions(*shape)))
    assert re.search(rf"paper +{expected:.4f} .*frames:{T}", capsys.readouterr().out)
    np.savez(tmp_path / "gt.npz", a=motions(*shape)[0])
    assert main(["score", str(tmp_path / "gt.npz"), str(paths[1]), *options]) == 0


def test_unwrapping_keeps_joints():
    angles = motions(N, T, J, C)[0] % (2 * np.pi)
    expected = npss.unwrap(angles.reshape(N, T, -1))
    np.testing.assert_array_equal(npss.unwrap(angles), expected.reshape(N, T, J, C))
    late = npss.unwrap(angles[:, 4:], seed_frames=angles[:, :4])
    np.testing.assert_array_equal(late, expected.reshape(N, T, J, C)[:, 4:])


# --- arrays of other libraries ----------------------------------------------------------------------------------------


class OnADevice:
    """An array of the array API on an accelerator: DLPack copies it to the CPU, if asked for."""

    def __init__(self, values):
        self._values = values

    def __dlpack_device__(self):
        return (1, 0) if self._values is None else (2, 0)

    def __dlpack__(self, *, stream=None, max_version=None, dl_device=None, copy=None):
        if dl_device != (1, 0):
            raise BufferError("on another device")
        return self._values.__dlpack__()


class OnlyDLPack:
    def __init__(self, values):
        self._values = values

    def __dlpack_device__(self):
        return self._values.__dlpack_device__()

    def __dlpack__(self, **options):
        return self._values.__dlpack__(**options)


class Cupy(OnlyDLPack):
    """An array that never converts implicitly."""

    __cuda_array_interface__ = None

    def __array__(self, dtype=None, copy=None):
        raise TypeError("Implicit conversion to a NumPy array is not allowed")

    def get(self):
        return self._values


class Broken:
    """Like an array of a device that is not there."""

    def __dlpack_device__(self):
        return (2, 0)

    def __dlpack__(self, **options):
        raise RuntimeError("no device")


@pytest.mark.parametrize("kind", [OnlyDLPack, Cupy, OnADevice])
def test_arrays_of_other_libraries(kind):
    if kind is OnADevice and np.lib.NumpyVersion(np.__version__) < "2.1.0":
        pytest.skip("numpy copies from devices from 2.1 on")
    gt, pred = motions(N, T, J, C)
    assert npss.score(kind(gt), kind(pred)) == npss.score(gt, pred)
    assert npss.score([kind(part) for part in gt], pred) == npss.score(gt, pred)
    assert npss.euler_error_curve(kind(gt), pred).tolist() == npss.euler_error_curve(gt, pred).tolist()


def test_an_array_that_nobody_can_read():
    with pytest.raises(TypeError, match=r"^gt: numpy cannot read this Broken \(.*\); pass a CPU array, e\.g\. tensor"):
        npss.score(Broken(), np.ones((2, 3, 4)))


@pytest.mark.parametrize("dtype", ["float64", "float32", "float16", "bfloat16"])
def test_tensors_of_torch(dtype):
    torch = pytest.importorskip("torch")
    tensors = [torch.tensor(motion, dtype=getattr(torch, dtype), requires_grad=True) for motion in motions(N, T, J, C)]
    arrays = [tensor.detach().double().numpy() for tensor in tensors]
    for function in EVERY.values():
        if function is not FUNCTIONS["compare"]:
            assert function(*tensors) == function(*arrays)
    assert npss.compare(tensors[0], *tensors).b == npss.score(*arrays)
    assert npss.score(*map(list, tensors)) == npss.score(*arrays)
    assert npss.score(tensors[0].transpose(2, 3), tensors[1].transpose(2, 3)) == npss.score(*arrays)
    negative = torch.complex(tensors[1].detach().double() * 0, tensors[1].detach().double()).conj().imag
    assert npss.score(arrays[0], negative) == npss.score(arrays[0], -arrays[1])


def test_integer_tensors_and_those_that_are_refused():
    torch = pytest.importorskip("torch")
    whole = torch.arange(24).reshape(2, 4, 3)
    assert npss.score(whole, whole) == 0
    with pytest.raises(TypeError, match=r"^gt: expected real numbers, got booleans"):
        npss.score(whole > 3, whole)
    with pytest.raises(TypeError, match=r"^pred: numpy cannot read this Tensor"):
        npss.score(whole, whole.to("meta"))


@pytest.mark.usefixtures("gpu")
def test_tensors_on_a_gpu():
    import torch

    gt, pred = motions(N, T, J, C)
    for dtype in (torch.float64, torch.bfloat16):
        there = [torch.tensor(motion, dtype=dtype, device="cuda", requires_grad=True) for motion in (gt, pred)]
        assert npss.score(*there) == npss.score(*(tensor.detach().cpu().double().numpy() for tensor in there))
        assert npss.score(*map(list, there)) == npss.score(*there)


def test_arrays_of_jax():
    jnp = pytest.importorskip("jax.numpy")
    for dtype in (jnp.float32, jnp.float16, jnp.bfloat16):
        arrays = [jnp.asarray(motion, dtype=dtype) for motion in motions(N, T, J, C)]
        assert npss.score(*arrays) == npss.score(*(np.asarray(array).astype(np.float64) for array in arrays))


def test_arrays_of_the_array_api():
    xp = pytest.importorskip("array_api_strict")
    for device in xp.__array_namespace_info__().devices():
        single = [motion.astype(np.float32) for motion in motions(N, T, J, C)]  # one device has no float64
        assert npss.score(*(xp.asarray(motion, device=device) for motion in single)) == npss.score(*single)


def test_masked_arrays_are_refused_with_advice():
    gt, pred = motions(N, T, J)
    masked = np.ma.masked_greater(gt, 1)
    for values in (masked, list(masked)):
        with pytest.raises(TypeError, match=r"^gt: masked arrays are refused, .*pass lengths=, one for each sequence"):
            npss.score(values, pred)
    with pytest.raises(TypeError, match=r"^counts: masked arrays are refused, .*fill it"):
        real_array("counts", masked)
