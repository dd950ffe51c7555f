"""Tests of npss.identify with functions of torch."""

import functools

import pytest

import npss

torch = pytest.importorskip("torch")


def released(gt, pred):
    first, second = (torch.fft.fft(motion, dim=1).real ** 2 for motion in (gt, pred))
    weight = first.sum(dim=1)
    cdf, other = (torch.cumsum(power / power.sum(dim=1, keepdim=True), dim=1) for power in (first, second))
    return (weight * (cdf - other).abs().sum(dim=1)).sum() / weight.sum()


@pytest.mark.parametrize(
    "convert",
    [
        lambda motion: motion,
        lambda motion: motion.float(),
        lambda motion: motion.bfloat16().float(),
        lambda motion: motion.half().float(),
    ],
    ids=["float64", "float32", "bfloat16", "float16"],
)
@pytest.mark.parametrize("finish", [lambda value: value, lambda value: value.item(), lambda value: value.bfloat16()])
def test_precisions(convert, finish):
    result = npss.identify(lambda gt, pred: finish(released(convert(gt), convert(pred))))
    assert result.convention == "released"
    assert "tensors of float64 (N, T, D)" in str(result)


def test_functions_of_float32_only():
    def single(gt, pred):
        assert gt.dtype == torch.float32
        return released(gt, pred)

    result = npss.identify(single)
    assert result.convention == "released"
    assert "tensors of float32 (N, T, D)" in str(result)


def test_gradients():
    factor = torch.ones((), requires_grad=True)
    assert npss.identify(lambda gt, pred: factor * released(gt, pred)).convention == "released"


def test_modules():
    class Loss(torch.nn.Module):
        def forward(self, preds, target):
            return released(target, preds)

    assert npss.identify(Loss()).order == "pred,gt"
    assert npss.identify(Loss).convention == "released"


def test_functions_of_this_library():
    import npss.torch

    assert npss.identify(npss.torch.score).convention == "paper"


def test_metrics_of_torchmetrics():
    pytest.importorskip("torchmetrics")
    from npss.torchmetrics import NPSS

    assert npss.identify(NPSS).convention == "paper"
    for make in (functools.partial(NPSS, convention="released"), NPSS(convention="released")):
        assert (npss.identify(make).convention, npss.identify(make).order) == ("released", "pred,gt")
