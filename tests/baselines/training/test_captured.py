"""Losses as CUDA graphs: which can be captured, and equal results alone and side by side."""

from dataclasses import replace
from functools import partial

import pytest

torch = pytest.importorskip("torch", reason="needs torch")

from torch.utils._python_dispatch import TorchDispatchMode  # noqa: E402

from npss_baselines.models import MODELS  # noqa: E402
from npss_baselines.models.base import POSE  # noqa: E402
from npss_baselines.models.recipe import REGIMES  # noqa: E402
from npss_baselines.models.vtln import VTLN, VTLNConfig  # noqa: E402
from npss_baselines.training.captured import Captured  # noqa: E402
from npss_baselines.training.objectives import loss  # noqa: E402

B, S, K = 3, 5, 7
SMALL = {"vgru": {"n_units": 8}, "erd": {"fc": 8, "size": 8, "fc_last": 8}, "srnn": {"fc": 8, "edge": 8, "node": 8}}
CASES = [(name, regime, {}) for name in MODELS for regime in REGIMES]
#: Fields that change what is computed.
CASES += [
    ("vgru-d", "eq6", {"cell": "text", "own_past": True, "derivative_step": 2}),
    ("vgru-d", "eq6", {"top_rnn": False, "restart_derivatives": True, "noise": "text"}),
    ("vgru-r1", "eq6", {"n_derivatives": 2}),
    ("vgru-ac", "auto-conditioning", {"own_past": True}),
    ("gru-d", "auto-conditioning", {"own_past": True}),
    ("gru-d", "eq6", {"own_past": True, "restart_derivatives": True}),
    ("srnn", "noise", {"full_width": True}),
]
every_case = pytest.mark.parametrize(("name", "regime", "fields"), CASES)


def case(name, regime, fields, device="cpu"):
    """Return a loss of a small model, and a batch."""
    torch.manual_seed(0)
    spec = MODELS[name]
    model = spec.build(replace(spec.config, **SMALL.get(name.partition("-")[0], {"size": 8}) | fields), 2).to(device)
    recipe = replace(
        spec.recipe, regime=regime, n_seed=S, n_target=K, closed_weight=((0, 0.5),), noise_std=((0, 0.1),), batch=B
    )
    batch = torch.randn(B, S + K + 1, POSE, device=device), torch.eye(2, device=device)[[0, 1, 0]]
    return model, partial(loss, model, recipe=recipe, iteration=0), batch


class NoLooking(TorchDispatchMode):
    """Refuse what a capture refuses: reading values, and making a tensor of Python's numbers."""

    def __torch_dispatch__(self, func, types, args=(), kwargs=None):
        name = func.name()
        assert name not in ("aten::_local_scalar_dense", "aten::nonzero", "aten::lift_fresh", "aten::equal"), name
        return func(*args, **kwargs or {})


@every_case
def test_no_loss_depends_on_values(name, regime, fields):
    _, call, batch = case(name, regime, fields)
    with NoLooking():
        call(*batch)["loss"].backward()


def test_losses_that_depend_on_values_are_detected():
    with NoLooking(), pytest.raises(AssertionError, match="_local_scalar_dense"):
        torch.ones(1).item()
    with NoLooking(), pytest.raises(AssertionError, match="lift_fresh"):
        torch.arange(3)[[2, 0]]


def by_autograd(model, call, batch, seed):
    torch.manual_seed(seed)
    parts = call(*batch)
    parameters = [parameter for parameter in model.parameters() if parameter.requires_grad]
    return {name: value.item() for name, value in parts.items()}, torch.autograd.grad(parts["loss"], parameters)


def by_graph(model, captured, batch, seed):
    captured.launch(seed, batch)
    parts = captured.result()
    model.zero_grad()
    (2 * parts["loss"]).backward()
    gradients = [parameter.grad / 2 for parameter in model.parameters() if parameter.requires_grad]
    return {name: value.item() for name, value in parts.items()}, gradients


@pytest.mark.usefixtures("gpu")
@every_case
def test_a_graph_computes_the_captured_loss(name, regime, fields):
    """For the captured batch and another, with other weights, with random numbers, and again."""
    model, call, batch = case(name, regime, fields, "cuda")
    captured = Captured(call, batch, list(model.parameters()))
    other = torch.randn_like(batch[0]), batch[1].flip(0)
    for inputs, seed in ((batch, 1), (other, 1), (other, 2), (batch, 1)):
        expected, actual = (f(model, what, inputs, seed) for f, what in ((by_autograd, call), (by_graph, captured)))
        assert actual[0] == pytest.approx(expected[0], rel=1e-5)
        torch.testing.assert_close(list(actual[1]), list(expected[1]), rtol=1e-4, atol=1e-6)
        with torch.no_grad():
            for parameter in model.parameters():
                parameter.mul_(1.01)


@pytest.mark.usefixtures("gpu")
def test_graphs_side_by_side_give_the_same_as_alone():
    """At full size, so that graphs overlap."""
    models = [VTLN(VTLNConfig(), 1).cuda() for _ in range(3)]
    recipe = replace(MODELS["vgru-d"].recipe, closed_weight=((0, 0.5),))
    batches = [(torch.randn(32, 151, POSE, device="cuda"), torch.ones(32, 1, device="cuda")) for _ in models]
    calls = [partial(loss, model, recipe=recipe, iteration=0) for model in models]
    graphs = [
        Captured(call, batch, list(model.parameters()))
        for model, call, batch in zip(models, calls, batches, strict=True)
    ]
    for turn in range(3):
        for i, graph in enumerate(graphs):
            graph.launch(10 * turn + i, batches[i])
        results = [graph.result() for graph in graphs]
        for model in models:
            model.zero_grad()
        sum(result["loss"] for result in results).backward()
        for i, model in enumerate(models):
            expected, gradients = by_autograd(model, calls[i], batches[i], 10 * turn + i)
            assert {name: value.item() for name, value in results[i].items()} == pytest.approx(expected, rel=1e-5)
            for parameter, gradient in zip(model.parameters(), gradients, strict=True):
                assert (parameter.grad - gradient).norm() <= 1e-4 * gradient.norm()


@pytest.mark.usefixtures("gpu")
def test_the_global_generator_is_left_alone():
    model, call, batch = case("vgru-d", "eq6", {}, "cuda")
    torch.manual_seed(3)
    expected = torch.randn(5, device="cuda")
    torch.manual_seed(3)
    captured = Captured(call, batch, list(model.parameters()))
    captured.launch(1, batch)
    captured.result()
    assert torch.equal(torch.randn(5, device="cuda"), expected)
