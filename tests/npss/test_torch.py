"""The torch function and the metric of torchmetrics: the same numbers as `npss.score`, and correct gradients."""

import copy
import itertools
import pickle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import npss
import oracles
from strategies import pairs

torch = pytest.importorskip("torch", reason="needs torch")

import npss.torch  # noqa: E402
from npss._metric.convention import CHOICES  # noqa: E402

NAMES = tuple(npss.CONVENTIONS)
EVERY_CONVENTION = [
    npss.Convention(**dict(zip(CHOICES, choices, strict=True))) for choices in itertools.product(*CHOICES.values())
]
SHAPE = (2, 6, 3)
pytestmark = pytest.mark.usefixtures("one_thread")


def tensors(pair, dtype=torch.float64, **kwargs):
    return tuple(torch.tensor(motion, dtype=dtype, **kwargs) for motion in pair)


def noise(seed=0, shape=SHAPE):
    return np.random.default_rng(seed).normal(size=(2, *shape)) + 0.5


@pytest.fixture
def motion():
    return tensors(noise(), requires_grad=True)


# --- the number -------------------------------------------------------------------------------------------------------


@pytest.mark.numeric
@given(pair=pairs(), convention=st.sampled_from([*NAMES, *EVERY_CONVENTION]))
def test_equals_the_score_of_arrays(pair, convention):
    expected = npss.score(*pair, convention=convention)
    value = npss.torch.score(*tensors(pair), convention=convention)
    assert value.shape == ()
    assert value.dtype == torch.float64
    assert value.item() == pytest.approx(expected, rel=1e-10, abs=1e-10)


@given(pair=pairs(), convention=st.sampled_from([*NAMES, *EVERY_CONVENTION]))
def test_single_precision(pair, convention):
    gt, pred = tensors(pair, torch.float32)
    value = npss.torch.score(gt, pred, convention=convention)
    assert value.dtype == torch.float32
    assert value.item() == pytest.approx(npss.score(gt, pred, convention=convention), rel=1e-4, abs=1e-5)


@pytest.mark.numeric
@pytest.mark.parametrize("name", NAMES)
@given(pair=pairs(max_n=2, max_t=12, max_d=2))
def test_equals_the_definition(name, pair):
    value = npss.torch.score(*tensors(pair), convention=name).item()
    assert value == pytest.approx(oracles.npss(*pair, name), rel=1e-10, abs=1e-10)


@pytest.mark.numeric
@pytest.mark.parametrize("convention", EVERY_CONVENTION)
@pytest.mark.parametrize("n_frames", [2, 3, 8, 9])
def test_every_convention(convention, n_frames):
    gt, pred = noise(n_frames, (3, n_frames, 4))
    gt[0, :, 1] = gt[:, :, 2] = pred[1, :, 0] = pred[:, :, 2] = 0
    gt[2, :, 3], pred[0, :, 3] = 0.7, -2.5
    expected = npss.score(gt, pred, convention=convention)
    value = npss.torch.score(*tensors((gt, pred)), convention=convention).item()
    assert value == pytest.approx(expected, rel=1e-12, abs=1e-12)


@pytest.mark.parametrize("name", NAMES)
def test_two_axes_are_one_sequence_and_equal_motions_score_zero(name, motion):
    gt, pred = motion
    one = npss.torch.score(gt[0], pred[0], convention=name)
    assert one.item() == pytest.approx(npss.torch.score(gt[:1], pred[:1], convention=name).item(), rel=1e-14)
    assert npss.torch.score(gt, gt, convention=name).item() == 0.0


@pytest.mark.parametrize(("dtype", "scale"), [(torch.float32, 1e-36), (torch.float32, 1e37), (torch.float64, 1e307)])
@pytest.mark.parametrize("name", NAMES)
def test_range(dtype, scale, name):
    gt, pred = noise()
    gt[..., 1] *= 1e-3
    expected = npss.score(gt, pred, convention=name)
    for scales in ((scale, 1.0), (1.0, scale), (scale, scale)):
        # scaled in numpy's float64 first, so that no tensor overflows
        gradients = [
            torch.tensor(m * s, dtype=dtype, requires_grad=True) for m, s in zip((gt, pred), scales, strict=True)
        ]
        value = npss.torch.score(*gradients, convention=name)
        assert value.item() == pytest.approx(expected, rel=1e-4)
        value.backward()
        assert all(m.grad.isfinite().all() for m in gradients)


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_a_huge_feature_without_power_sets_no_scale(dtype):
    gt, pred = noise(shape=(8, 2))
    gt[:, 0] = 1e30 * np.array([0, 1, 0, -1, 0, 1, 0, -1])  # a sine: no real power
    expected = npss.score(gt, pred, convention="released")
    assert expected == pytest.approx(npss.score(gt[:, 1:], pred[:, 1:], convention="released"))
    value = npss.torch.score(*tensors((gt, pred), dtype), convention="released").item()
    assert value == pytest.approx(expected, rel=1e-4)


@pytest.mark.usefixtures("gpu")
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
@pytest.mark.parametrize("name", NAMES)
def test_on_a_gpu(dtype, name):
    gt, pred = noise(shape=(8, 100, 54))
    gt[..., 1] = pred[..., 2] = 0
    both = [tensors((gt, pred), dtype, device=device, requires_grad=True) for device in ("cpu", "cuda")]
    for pair in both:
        value = npss.torch.score(*pair, convention=name)
        assert value.device == pair[0].device
        assert value.item() == pytest.approx(npss.score(gt, pred, convention=name), rel=1e-4)
        value.backward()
    for cpu, cuda in zip(*both, strict=True):
        # on average: a cumulative difference near zero may have either sign, and so either slope
        assert (cuda.grad.cpu() - cpu.grad).norm() < 1e-3 * cpu.grad.norm()
    with pytest.raises(ValueError, match=r"^pred: on cuda:0, but gt is on cpu"):
        npss.torch.score(both[0][0], both[1][1])
    with pytest.raises(ValueError, match=r"^gt: nan at index \(0, 0, 0\)"):
        npss.torch.score(both[1][0] * float("nan"), both[1][1])


# --- gradients --------------------------------------------------------------------------------------------------------


@pytest.mark.numeric
@pytest.mark.parametrize("convention", [*NAMES, *EVERY_CONVENTION[1::5]])
@pytest.mark.parametrize("n_frames", [6, 7])
def test_gradients_equal_finite_differences(convention, n_frames):
    pair = tensors(noise(1, (2, n_frames, 2)), requires_grad=True)
    assert torch.autograd.gradcheck(lambda gt, pred: npss.torch.score(gt, pred, convention=convention), pair)


@pytest.mark.parametrize("convention", [*NAMES, npss.Convention(power="real"), npss.Convention(zero="empty")])
@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_gradients_are_finite_where_there_is_no_power(convention, dtype):
    gt, pred = noise(shape=(2, 8, 5))
    gt[..., 0] = pred[..., 1] = gt[..., 2] = pred[..., 2] = 0
    gt[..., 3], pred[..., 4] = 1.0, -2.0
    gt[1], pred[1] = 0, 0
    gt, pred = tensors((gt, pred), dtype, requires_grad=True)
    npss.torch.score(gt, pred, convention=convention).backward()
    for motion in (gt, pred):
        assert motion.grad.isfinite().all()
        assert not motion.grad[(motion == 0).all(dim=1, keepdim=True).expand_as(motion)].any()
    assert pred.grad[0, :, 4].abs().max() < 1e-5  # a constant is a stationary point
    assert pred.grad.abs().max() > 1e-3


def test_gradients_at_the_minimum_are_finite(motion):
    gt = motion[0].detach()
    pred = gt.clone().requires_grad_()
    npss.torch.score(gt, pred).backward()
    assert pred.grad.isfinite().all()


@pytest.mark.parametrize("name", NAMES)
def test_descent_lowers_the_score(name):
    gt, pred = tensors(noise(shape=(2, 20, 4)).cumsum(axis=2))
    pred.requires_grad_()
    optimiser = torch.optim.Adam([pred], lr=0.02)
    scores = []
    for _ in range(100):
        optimiser.zero_grad()
        loss = npss.torch.score(gt, pred, convention=name)
        loss.backward()
        optimiser.step()
        scores.append(loss.item())
    assert min(scores[-10:]) < 0.5 * scores[0]


def test_inputs_are_not_written_to(motion):
    before = [m.detach().clone() for m in motion]
    npss.torch.score(*motion).backward()
    assert all(torch.equal(m, b) for m, b in zip(motion, before, strict=True))


# --- invalid input ----------------------------------------------------------------------------------------------------

GOOD = torch.ones(2, 4, 3)
REFUSED = {
    "an array": (np.ones((2, 4, 3)), TypeError, "expected a torch tensor, got ndarray"),
    "None": (None, TypeError, "expected a torch tensor, got NoneType"),
    **{
        str(dtype): (GOOD.to(dtype), TypeError, f"expected floating-point numbers, got {dtype}")
        for dtype in (torch.int64, torch.bool, torch.complex64)
    },
    "one axis": (torch.ones(4), ValueError, r"expected shape \(N, T, D\) or \(T, D\)"),
    "three by three": (torch.ones(1, 2, 3, 3), ValueError, r"shape \(1, 2, 3, 3\) may be rotation matrices"),
    "five axes": (torch.ones(1, 2, 3, 4, 5), ValueError, r"expected shape \(N, T, D\) or \(T, D\)"),
    "matrices": (torch.ones(1, 2, 1, 3, 3), ValueError, "expected shape .*pass representation='matrix'"),
    "no sequences": (torch.ones(0, 4, 3), ValueError, r"no sequences in an array of shape \(0, 4, 3\)"),
    "no frames": (torch.ones(2, 0, 3), ValueError, "no frames"),
    "no features": (torch.ones(2, 4, 0), ValueError, "no features"),
}


@pytest.mark.parametrize("kind", REFUSED)
def test_invalid_inputs(kind):
    bad, error, message = REFUSED[kind]
    with pytest.raises(error, match=f"^gt: {message}"):
        npss.torch.score(bad, GOOD)
    with pytest.raises(error, match=f"^pred: {message}"):
        npss.torch.score(GOOD, bad)


@pytest.mark.parametrize(
    ("bad", "error", "message"),
    [
        (torch.ones(2, 4, 1), ValueError, r"its shape \(2, 4, 1\) differs from that of gt, \(2, 4, 3\)"),
        (torch.ones(4, 3), ValueError, r"its shape \(4, 3\) differs"),
        (GOOD.to("meta"), ValueError, "on meta, but gt is on cpu"),
    ],
)
def test_invalid_pairs(bad, error, message):
    with pytest.raises(error, match=f"^pred: {message}"):
        npss.torch.score(GOOD, bad)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_values_that_are_not_finite(name, value):
    bad = GOOD.clone()
    bad[1, 2, 0] = bad[1, 3, 1] = value
    with pytest.raises(ValueError, match=rf"^gt: {value} at index \(1, 2, 0\); every value must be finite"):
        npss.torch.score(bad.requires_grad_(), GOOD, convention=name)
    with pytest.raises(ValueError, match=rf"^pred: {value} at index \(2, 0\); every value must be finite"):
        npss.torch.score(GOOD[1], bad[1], convention=name)
    with pytest.raises(ValueError, match=r"^pred: "):  # even with a ground truth without power
        npss.torch.score(torch.cat([GOOD, 0 * GOOD]), torch.cat([GOOD, bad]), convention=name)


HALVES = (torch.float16, torch.bfloat16)


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("gt_dtype", [torch.float64, torch.float32, *HALVES])
@pytest.mark.parametrize("pred_dtype", [torch.float64, torch.float32, *HALVES])
def test_half_and_mixed_precision_are_computed_in_single_precision_at_least(gt_dtype, pred_dtype, name):
    """The output of a network under bf16-mixed, with a ground truth in single precision, is scored exactly."""
    gt, pred = (motion.to(dtype) for motion, dtype in zip(tensors(noise()), (gt_dtype, pred_dtype), strict=True))
    pred.requires_grad_()
    double = torch.float64 in (gt_dtype, pred_dtype)
    value = npss.torch.score(gt, pred, convention=name)
    assert value.dtype == (torch.float64 if double else torch.float32)
    expected = npss.score(gt.double(), pred.detach().double(), convention=name)
    assert value.item() == pytest.approx(expected, rel=1e-10 if double else 1e-4)
    assert npss.score(gt, pred.detach(), convention=name) == expected  # for tensors, too, including bfloat16
    value.backward()
    assert pred.grad.dtype == pred_dtype
    assert pred.grad.isfinite().all()
    assert pred.grad.any()


@pytest.mark.parametrize("dtype", HALVES)
def test_half_precision_that_is_not_finite(dtype):
    bad = GOOD.to(dtype)
    bad[1, 2, 0] = torch.nan
    for score in (npss.torch.score, npss.score):
        with pytest.raises(ValueError, match=r"^pred: nan at index \(1, 2, 0\)"):
            score(GOOD.cumsum(1), bad)


def test_joints_and_matrices(make):
    joints, matrices = (tensors(noise(shape=(2, 6, 4, *axes))) for axes in ((5,), (3, 3)))
    for (gt, pred), options in ((joints, {}), (matrices, {"representation": "matrix"})):
        expected = npss.score(gt.flatten(2), pred.flatten(2))
        assert npss.torch.score(gt, pred, **options).item() == pytest.approx(expected, rel=1e-12)
        assert filled(make(**options), gt, pred).compute().item() == pytest.approx(expected, rel=1e-12)
    bad = joints[1].clone()
    bad[0, 1, 2, 3] = torch.nan
    for refused in (lambda: npss.torch.score(joints[0], bad), lambda: make().update(bad, joints[0])):
        with pytest.raises(ValueError, match=r"^preds?: nan at index \(0, 1, 2, 3\)"):
            refused()
    with pytest.raises(TypeError, match=r"^representation: expected text"):
        make(representation=6)


@pytest.mark.parametrize("name", NAMES)
def test_ground_truth_without_power(name):
    with pytest.raises(ValueError, match=r"^gt: no power in any feature of any sequence"):
        npss.torch.score(0 * GOOD, GOOD, convention=name)


def test_one_frame_and_no_convention():
    with pytest.raises(ValueError, match=r"^gt: one frame"):
        npss.torch.score(GOOD[:, :1], GOOD[:, :1])
    with pytest.raises(ValueError, match=r"^convention: expected one of paper"):
        npss.torch.score(GOOD, GOOD, convention="novel")
    with pytest.raises(TypeError, match=r"^convention: "):
        npss.torch.score(GOOD, GOOD, convention=None)


# --- the metric -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def make():
    """The metric's class."""
    pytest.importorskip("torchmetrics", reason="needs torchmetrics")
    from npss.torchmetrics import NPSS

    return NPSS


def filled(metric, gt, pred):
    metric.update(pred, gt)
    return metric


@given(pair=pairs(max_n=6), convention=st.sampled_from([*NAMES, *EVERY_CONVENTION]), data=st.data())
def test_any_batches_give_the_score_of_the_whole(make, pair, convention, data):
    gt, pred = tensors(pair, data.draw(st.sampled_from([torch.float32, torch.float64])))
    cuts = sorted(data.draw(st.sets(st.integers(1, len(gt) - 1)))) if len(gt) > 1 else []
    metric = make(convention=convention)
    for rows in map(slice, [0, *cuts], [*cuts, None]):
        metric.update(preds=pred[rows], target=gt[rows])
    value = metric.compute()
    assert value.dtype == torch.float64
    assert value.item() == pytest.approx(npss.score(gt, pred, convention=convention), rel=1e-12, abs=1e-12)


def test_the_prediction_comes_first(make):
    gt, pred = tensors(noise())
    pred[..., 0] = 7.0
    assert npss.score(gt, pred) != pytest.approx(npss.score(pred, gt))
    metric = make()
    metric.update(pred, gt)
    assert metric.compute().item() == pytest.approx(npss.score(gt, pred))
    assert metric.higher_is_better is False


def test_parts_merge(make):
    gt, pred = tensors(noise(shape=(5, 6, 3)))
    parts = [filled(make(), gt[rows], pred[rows]) for rows in (slice(0, 2), slice(2, 5))]
    parts[0].merge_state(parts[1])
    assert parts[0].compute().item() == pytest.approx(npss.score(gt, pred), rel=1e-12)
    fresh = make()
    fresh.merge_state(parts[0])
    assert int(fresh.kind[0]) == 6


def test_processes_add_up(make):
    gt, pred = tensors(noise(shape=(5, 6, 3)))
    other = filled(make(), gt[2:], pred[2:])
    others = iter([other.kind, other.numerator, other.denominator])
    metric = make(dist_sync_fn=lambda state, group: [state, next(others)], distributed_available_fn=lambda: True)
    filled(metric, gt[:2], pred[:2])
    assert metric.compute().item() == pytest.approx(npss.score(gt, pred), rel=1e-12)


def test_parts_of_different_kinds_do_not_merge(make):
    gt, pred = tensors(noise())
    metric = filled(make(), gt, pred)
    refused = r"^batches: scores of 5 and 6 frames are not comparable, .*; pass normalize='bound', or keep one metric"
    with pytest.raises(ValueError, match=refused):
        metric.update(pred[:, :5], gt[:, :5])
    assert metric.compute().item() == pytest.approx(npss.score(gt, pred))
    with pytest.raises(ValueError, match=refused):
        metric.merge_state(filled(make(), gt[:, :5], pred[:, :5]))
    with pytest.raises(ValueError, match=refused):
        metric(pred[:, :5], gt[:, :5])
    for convention in EVERY_CONVENTION[1:]:
        with pytest.raises(ValueError, match=r"^batches: different conventions"):
            filled(make(), gt, pred).merge_state(filled(make(convention=convention), gt, pred))


def test_a_collection_keeps_conventions_apart(make):
    from torchmetrics import MetricCollection

    gt, pred = tensors(noise())
    still = torch.zeros_like(gt)
    conventions = {"dc": npss.Convention(), "empty": npss.Convention(zero="empty")}
    both = MetricCollection({name: make(convention=convention) for name, convention in conventions.items()})
    both.update(pred, gt)  # the two conventions agree here ...
    both.update(still, gt)  # ... and not here
    whole = torch.cat([gt, gt]), torch.cat([pred, still])
    for name, value in both.compute().items():
        assert value.item() == pytest.approx(npss.score(*whole, convention=conventions[name]))


def test_forward_returns_the_differentiable_score_of_the_batch(make, motion):
    gt, pred = motion
    metric = make()
    for rows in (slice(0, 1), slice(1, 2)):
        value = metric(pred[rows], gt[rows])
        assert value.item() == pytest.approx(npss.torch.score(gt[rows], pred[rows]).item(), rel=1e-12)
    value.backward()
    gradient = pred.grad.clone()
    pred.grad = None
    npss.torch.score(gt[1:], pred[1:]).backward()
    torch.testing.assert_close(gradient, pred.grad)
    assert metric.compute().item() == pytest.approx(npss.score(*(m.detach() for m in motion)), rel=1e-12)
    assert not metric.compute().requires_grad


def test_reset(make):
    gt, pred = tensors(noise())
    metric = filled(make(convention="released"), gt, 0 * pred)
    metric.reset()
    filled(metric, gt[:, :5], pred[:, :5])  # with another number of frames
    assert metric.compute().item() == pytest.approx(npss.score(gt[:, :5], pred[:, :5], convention="released"))


@pytest.mark.parametrize(
    "cast",
    [
        lambda m: m.set_dtype(torch.float16),
        lambda m: m.half(),
        lambda m: m.float(),
        lambda m: m.to(torch.bfloat16),
        lambda m: m.to("cpu", torch.float32),
        lambda m: torch.nn.ModuleList([m]).half()[0],
        lambda m: torch.nn.ModuleList([m]).to(torch.float16)[0],
    ],
)
def test_the_sums_stay_double(make, cast):
    gt, pred = tensors(noise())
    metric = filled(make(), gt, pred)
    expected = metric.compute().item()
    for same in (metric, copy.deepcopy(metric)):
        cast(same)
        assert same.numerator.dtype == same.denominator.dtype == torch.float64
        assert same.kind.dtype == torch.int64
        assert same.compute().item() == expected
        same.reset()
        assert same.numerator.dtype == torch.float64


def test_the_sums_move(make):
    metric = make().to("meta", torch.float32)
    assert metric.numerator.device.type == metric.kind.device.type == metric.device.type == "meta"
    assert metric.numerator.dtype == torch.float64


@pytest.mark.usefixtures("gpu")
def test_the_metric_on_a_gpu(make):
    gt, pred = tensors(noise(), torch.float32, device="cuda")
    metric = filled(make().to("cuda"), gt, pred)
    assert metric.compute().device.type == "cuda"
    assert metric.compute().item() == pytest.approx(npss.score(gt.cpu(), pred.cpu()), rel=1e-12)


def test_pickling_and_state(make):
    gt, pred = tensors(noise())
    metric = filled(make(convention="released"), gt, pred)
    again = pickle.loads(pickle.dumps(metric))
    assert again.compute() == metric.compute()
    assert again.convention == npss.CONVENTIONS["released"]
    assert not metric.state_dict()  # the default of torchmetrics
    metric.persistent(True)
    loaded = make(convention="released")
    loaded.load_state_dict(metric.state_dict(), strict=False)
    again.update(gt, pred)
    loaded.update(gt, pred)
    assert loaded.compute() == again.compute()
    assert "power='real'" in repr(metric)


def test_invalid_input_of_the_metric(make):
    gt, pred = tensors(noise())
    metric = filled(make(), gt, pred)
    expected = metric.compute().item()
    with pytest.raises(TypeError, match=r"^target: expected a torch tensor, got ndarray"):
        metric.update(pred, gt.numpy())
    with pytest.raises(TypeError, match=r"^preds: expected floating-point numbers, got torch.int64"):
        metric.update(pred.long(), gt)
    with pytest.raises(ValueError, match=r"^preds: its shape .* differs from that of target"):
        metric.update(pred[:1], gt)
    with pytest.raises(ValueError, match=r"^preds: nan at index \(0, 0, 0\)"):
        metric.update(pred * np.nan, gt)
    with pytest.raises(ValueError, match=r"^target: inf at index \(0, 0, 0\)"):
        metric.update(pred, gt.abs() * np.inf)
    with pytest.raises(ValueError, match=r"^target: its power is beyond float64"):
        metric.update(pred, gt * 1e200)
    assert metric.compute().item() == expected
    with pytest.raises(ValueError, match=r"^convention: "):
        make(convention="novel")
    with pytest.raises(ValueError, match=r"^nan_policy: expected one of raise, propagate, got 'omit'"):
        make(nan_policy="omit")


@pytest.mark.parametrize("scale", [0.0, 1e-200])
def test_batches_without_power(make, scale):
    gt, pred = tensors(noise())
    metric = filled(make(), scale * gt, pred)
    with pytest.raises(ValueError, match=r"^target: no power in any feature of any sequence so far"):
        metric.compute()
    assert filled(metric, gt, pred).compute().item() == pytest.approx(npss.score(gt, pred))


@given(seed=st.integers(0, 99), dtypes=st.tuples(*[st.sampled_from([torch.float64, torch.float32, *HALVES])] * 2))
def test_the_metric_in_any_precision(make, seed, dtypes):
    gt, pred = (motion.to(dtype) for motion, dtype in zip(tensors(noise(seed=seed)), dtypes, strict=True))
    value = filled(make(), gt, pred).compute()
    assert value.dtype == torch.float64
    assert value.item() == pytest.approx(npss.score(gt, pred), rel=1e-12)


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
@pytest.mark.parametrize("argument", ["preds", "target"])
@pytest.mark.parametrize("dtype", [torch.float32, torch.bfloat16])
def test_values_that_are_not_finite_raise_or_propagate(make, bad, argument, dtype):
    gt, pred = tensors(noise(), dtype)
    broken = {"preds": pred.clone(), "target": gt.clone()}
    broken[argument][1, 2, 0] = bad
    careful, tolerant = filled(make(), gt, pred), filled(make(nan_policy="propagate"), gt, pred)
    expected = careful.compute().item()
    for call in (careful.update, careful):
        with pytest.raises(ValueError, match=rf"^{argument}: {bad} at index \(1, 2, 0\)"):
            call(**broken)
        assert careful.compute().item() == expected
    assert tolerant.compute().item() == expected
    assert tolerant(**broken).isnan()
    for _ in range(2):
        tolerant.update(pred, gt)  # later batches do not make it a number again
        assert tolerant.compute().isnan()
    merged = filled(make(nan_policy="propagate"), gt, pred)
    merged.merge_state(tolerant)
    assert merged.compute().isnan()
    tolerant.reset()
    assert filled(tolerant, gt, pred).compute().item() == expected


def test_only_what_is_not_finite_propagates(make):
    gt, pred = tensors(noise())
    metric = make(nan_policy="propagate")
    with pytest.raises(ValueError, match=r"^target: its power is beyond float64"):
        metric.update(pred, gt * 1e200)
    with pytest.raises(ValueError, match=r"^target: no power in any feature"):
        filled(metric, 0 * gt, pred).compute()
    assert "nan_policy='propagate'" in repr(metric)


def test_policies_are_not_mixed(make):
    from torchmetrics import MetricCollection

    gt, pred = tensors(noise())
    with pytest.raises(ValueError, match=r"^batches: different"):
        filled(make(), gt, pred).merge_state(filled(make(nan_policy="propagate"), gt, pred))
    both = MetricCollection({policy: make(nan_policy=policy) for policy in ("propagate", "raise")})
    both.update(pred, gt)
    with pytest.raises(ValueError, match=r"^preds: nan at index"):
        both.update(pred * np.nan, gt)


@pytest.mark.parametrize("options", [{}, {"dist_sync_on_step": True}, {"compute_on_cpu": True}])
def test_an_error_in_forward_changes_nothing(make, options):
    gt, pred = tensors(noise())
    metric = make(**options)
    for _ in range(2):
        metric(pred, gt)
        before = {name: str(value) for name, value in metric.__dict__.items()}
        for bad_pred, bad_gt in ((pred * np.nan, gt), (pred, 0 * gt), (pred[:, :5], gt[:, :5]), (pred[:1], gt)):
            with pytest.raises(ValueError, match=r"^(preds|target|batches)"):
                metric(bad_pred, bad_gt)
            assert {name: str(value) for name, value in metric.__dict__.items()} == before
    assert metric.compute().item() == pytest.approx(npss.score(gt, pred), rel=1e-12)


@pytest.mark.filterwarnings("ignore")  # lightning warns about torch, and about such a small loop
def test_lightning_in_mixed_precision(make, tmp_path):
    """A network with bfloat16 output, the score as loss, and the metric."""
    lightning = pytest.importorskip("lightning")
    dtypes = set()

    class Model(lightning.LightningModule):
        def __init__(self):
            super().__init__()
            self.layer = torch.nn.Linear(3, 3)
            self.npss = make()

        def training_step(self, batch, index):
            gt, seen = batch
            pred = self.layer(seen)
            dtypes.add((gt.dtype, pred.dtype))
            self.npss.update(pred, gt)
            self.log("npss", self.npss, on_step=False, on_epoch=True)
            return npss.torch.score(gt, pred)

        def configure_optimizers(self):
            return torch.optim.SGD(self.parameters(), lr=0.01)

    gt, seen = tensors(noise(shape=(8, 6, 3)), torch.float32)
    batches = torch.utils.data.DataLoader(torch.utils.data.TensorDataset(gt, seen), batch_size=4)
    quiet = {
        "logger": False,
        "enable_checkpointing": False,
        "enable_progress_bar": False,
        "enable_model_summary": False,
    }
    trainer = lightning.Trainer(
        max_epochs=1, accelerator="cpu", precision="bf16-mixed", default_root_dir=tmp_path, **quiet
    )
    model = Model()
    trainer.fit(model, batches)
    assert dtypes == {(torch.float32, torch.bfloat16)}
    assert np.isfinite(trainer.callback_metrics["npss"].item())


# --- sequences of unequal length --------------------------------------------------------------------------------------

LENGTHS = [6, 3, 6, 4]


def ragged(seed=0, dtype=torch.float64, axes=(3,)):
    """Return padded tensors, with NaN beyond the lengths, and the same as lists."""
    padded = tensors(noise(seed, (len(LENGTHS), 6, *axes)), dtype)
    lists = [[motion[:n].clone() for motion, n in zip(motions, LENGTHS, strict=True)] for motions in padded]
    for motions in padded:
        for motion, n in zip(motions, LENGTHS, strict=True):
            motion[n:] = torch.nan
    return padded, lists


@pytest.mark.parametrize("convention", EVERY_CONVENTION)
def test_unequal_lengths(make, convention):
    padded, lists = ragged()
    expected = npss.score(*padded, lengths=LENGTHS, convention=convention, normalize="bound")
    options = {"convention": convention, "normalize": "bound"}
    values = [
        npss.torch.score(*padded, lengths=LENGTHS, **options),
        npss.torch.score(*padded, lengths=torch.tensor(LENGTHS), **options),
        npss.torch.score(*lists, **options),
        npss.torch.score(padded[0], tuple(lists[1]), lengths=LENGTHS, **options),
    ]
    at_once, in_turn = make(**options), make(**options)
    at_once.update(padded[1], padded[0], lengths=LENGTHS)
    for truth, prediction in zip(*lists, strict=True):
        in_turn.update(preds=prediction, target=truth)
    values += [at_once.compute(), in_turn.compute()]
    at_once.merge_state(in_turn)
    values += [at_once.compute(), at_once(padded[1], padded[0], lengths=LENGTHS)]
    assert [value.item() for value in values] == pytest.approx([expected] * len(values), rel=1e-12)


def test_joints_of_unequal_lengths_in_single_precision():
    for axes, options in (((4, 5), {}), ((2, 3, 3), {"representation": "matrix"})):
        padded, lists = ragged(dtype=torch.float32, axes=axes)
        options |= {"normalize": "bound"}
        expected = npss.score(*padded, lengths=LENGTHS, **options)
        for value in (
            npss.torch.score(*padded, lengths=LENGTHS, **options),
            npss.torch.score(*([motion * 1e30 for motion in motions] for motions in lists), **options),
        ):
            assert value.item() == pytest.approx(expected, rel=1e-4)


def test_gradients_of_unequal_lengths_are_finite_and_end_with_the_sequence():
    padded, _ = ragged()
    pred = padded[1].requires_grad_()
    npss.torch.score(padded[0], pred, lengths=LENGTHS, normalize="bound").backward()
    for gradient, n in zip(pred.grad, LENGTHS, strict=True):
        assert gradient[:n].isfinite().all()
        assert gradient[:n].any()
        assert not gradient[n:].any()


def test_equal_lengths_and_the_plain_score(make):
    gt, pred = tensors(noise(shape=(3, 8, 2)))
    plain = npss.torch.score(gt[:, :6], pred[:, :6])
    assert npss.torch.score(gt, pred, lengths=[6, 6, 6]).item() == pytest.approx(plain.item(), rel=1e-14)
    assert npss.torch.score(list(gt[:, :6]), list(pred[:, :6])).item() == pytest.approx(plain.item(), rel=1e-14)
    normalised = npss.torch.score(gt[:, :6], pred[:, :6], normalize="bound")
    assert normalised.item() == pytest.approx(plain.item() / 3, rel=1e-14)
    metric = make()
    metric.update(pred, gt, lengths=[6, 6, 6])
    assert metric.compute().item() == pytest.approx(plain.item(), rel=1e-14)


def test_unequal_lengths_require_normalisation(make):
    padded, lists = ragged()
    refused = r"^normalize: expected 'bound' for sequences of 3 to 6 frames, whose scores are not comparable, got None"
    for call in (
        lambda: npss.torch.score(*padded, lengths=LENGTHS),
        lambda: npss.torch.score(*lists),
        lambda: make().update(padded[1], padded[0], lengths=LENGTHS),
    ):
        with pytest.raises(ValueError, match=refused):
            call()
    for call in (lambda: npss.torch.score(GOOD, GOOD, normalize="Bound"), lambda: make(normalize="Bound")):
        with pytest.raises(ValueError, match=r"^normalize: expected one of bound"):
            call()
    normalised, plain = make(normalize="bound"), filled(make(), lists[0][0], lists[1][0])
    assert "normalize='bound'" in repr(normalised)
    for fresh in (normalised, filled(make(normalize="bound"), lists[0][0], lists[1][0])):
        with pytest.raises(ValueError, match=r"^batches: different conventions, policies or numbers of frames \['any'"):
            copy.deepcopy(plain).merge_state(fresh)


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"lengths": [6, 3]}, ValueError, "lengths: expected one for each of 4 sequences"),
        ({"lengths": [6, 3, 7, 4]}, ValueError, "lengths: 7 at 2; expected a number of frames from 1 to 6"),
        ({"lengths": [6, 1, 6, 4]}, ValueError, "gt: one frame in sequence 1"),
        ({"gt": [], "pred": []}, ValueError, "gt: no sequences"),
        ({"gt": [np.ones((6, 3))]}, TypeError, "gt: sequence 0: expected a torch tensor, got ndarray"),
        ({"gt": [torch.ones(6)]}, ValueError, r"gt: sequence 0: expected shape"),
        ({"gt": [torch.ones(6, 3), torch.ones(6, 2)] * 2}, ValueError, "pred: sequence 1: its shape"),
        ({"gt": [torch.ones(6, 3)]}, ValueError, "pred: 4 sequences, but gt has 1"),
        ({"gt": torch.ones(4, 5, 3), "lengths": None}, ValueError, "pred: its shape"),
    ],
)
def test_invalid_sequences(change, error, message):
    gt, pred = tensors(noise(shape=(4, 6, 3)))
    options = {"gt": gt, "pred": pred, "lengths": LENGTHS, **change}
    with pytest.raises(error, match=f"^{message}"):
        npss.torch.score(**options, normalize="bound")


def test_values_of_sequences_that_are_not_finite(make):
    padded, _ = ragged()
    padded[1][1, 2, 0] = torch.inf
    careful, tolerant = make(normalize="bound"), make(normalize="bound", nan_policy="propagate")
    for call in (
        lambda: npss.torch.score(*padded, lengths=LENGTHS, normalize="bound"),
        lambda: careful.update(padded[1], padded[0], lengths=LENGTHS),
    ):
        with pytest.raises(ValueError, match=r"^preds?: inf at index \(1, 2, 0\)"):
            call()
    tolerant.update(padded[1], padded[0], lengths=LENGTHS)
    assert tolerant.compute().isnan()
