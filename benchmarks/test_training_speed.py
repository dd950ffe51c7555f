"""Time of a training iteration of VGRU-d (equation 6), with hand-written and with torch's backpropagation, in turn.

``pytest benchmarks/test_training_speed.py -s``

An iteration is a forward pass, a backward pass, clipping and an optimiser step, for 32 windows of 50 + 100 frames and
512 units, on one thread. Both have the same forward pass: after the seed frames, open and closed loop are one batch,
and one product gives the guides' contribution to all steps. Only the backward pass differs: `autograd` is torch's,
`by_hand` that of `npss_baselines.models._bptt`, which stays while it is 1.3 times as fast. On the CPU, processor time
is measured, which depends less on other programs. Read the ratios, not the times.

On a CUDA device, the benchmark also measures training's graphs: `captured`, loss and gradients as one graph, and
`together`, several models side by side, as time per model.
"""

import time
from functools import partial

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch")

from torch.nn import functional  # noqa: E402

from npss_baselines.models.derivatives import derivatives, next_derivatives, no_past  # noqa: E402
from npss_baselines.models.vtln import VTLN, VTLNConfig  # noqa: E402
from npss_baselines.training.captured import Captured  # noqa: E402

BATCH, SEED, FRAMES, TURNS, TOGETHER = 32, 50, 150, 5, 4
DEVICES = ["cpu", pytest.param("cuda", marks=pytest.mark.skipif(not torch.cuda.is_available(), reason="needs CUDA"))]


@pytest.fixture(autouse=True)
def one_thread():
    threads = torch.get_num_threads()
    torch.set_num_threads(1)
    torch.manual_seed(0)
    yield
    torch.set_num_threads(threads)


def autograd(model, poses, label, n_seed):
    """Compute `VTLN.open_and_closed` in training, with torch's backpropagation."""
    (batch, n_frames, _), cell, p = poses.shape, model.body.blocks(model.n_guide), model.config.dropout
    H = model.config.n_units
    guides = model._guides(label, n_frames)
    plans = torch.addmm(cell.plan_bias, guides.flatten(0, 1), cell.plan).view(n_frames, batch, -1)
    features = derivatives(poses, 3).transpose(0, 1)
    h, past, outputs = torch.zeros_like(guides[0]), no_past(poses, 3), []
    for t, (x, plan) in enumerate(zip(features, plans, strict=True)):
        own, past = next_derivatives(poses[:, t] if t < n_seed else outputs[-1][-batch:], past, 3)
        if t >= n_seed:
            x, plan = torch.cat([x, own]), torch.cat([plan, plan])
        if t == n_seed:
            h = torch.cat([h, h])
        x = functional.dropout(x, p)
        if cell.candidate_bias is None:
            of_candidate, of_gates = plan.split([H, 2 * H], 1)
            u, r = torch.sigmoid(torch.addmm(of_gates, torch.cat([x, h], 1), cell.gates)).chunk(2, 1)
            c = torch.tanh(torch.addmm(of_candidate, torch.cat([r * h, x], 1), cell.candidate))
        else:
            u, r, g = torch.sigmoid(torch.addmm(plan, torch.cat([x, h], 1), cell.gates)).chunk(3, 1)
            c = torch.tanh(torch.addmm(cell.candidate_bias, torch.cat([g, r * h, x], 1), cell.candidate))
        h = torch.lerp(c, h, u)
        outputs.append(model.decoder(functional.dropout(h, p)))
    opened = torch.stack([output[:batch] for output in outputs], 1)
    return opened, torch.stack([output[batch:] for output in outputs[n_seed:]], 1)


def by_hand(model, poses, label, n_seed):
    return model.open_and_closed(poses, label, n_seed)


def losses(outputs, poses):
    opened, closed = outputs
    return functional.mse_loss(opened, poses[:, 1:]), functional.mse_loss(closed, poses[:, SEED + 1 :])


def seconds(train, models, device):
    """Train models for an iteration, each by its optimiser, and return the seconds per model."""
    waits, clock = (torch.cuda.synchronize, time.perf_counter) if device == "cuda" else (int, time.process_time)
    waits()
    start = clock()
    for loss, (model, optimizer) in zip(train(), models, strict=True):
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimizer.step()
    waits()
    return (clock() - start) / len(models)


def contenders(cell, device):
    """Return, by name, a function that computes losses of models of a cell, and the models."""
    poses = torch.randn(BATCH, FRAMES + 1, 54, device=device)
    label = torch.ones(BATCH, 1, device=device)
    models = [VTLN(VTLNConfig(cell=cell), 1).to(device) for _ in range(TOGETHER)]
    models = [(model, torch.optim.RMSprop(model.parameters(), lr=1e-5, momentum=0.95)) for model in models]

    def weighted(outputs_of, model, poses, label):
        opened, closed = losses(outputs_of(model, poses[:, :-1], label, SEED), poses)
        return {"loss": opened + 0.6 * closed}

    first = models[0][0]
    methods = {
        backward.__name__: (lambda backward=backward: [weighted(backward, first, poses, label)["loss"]], models[:1])
        for backward in (autograd, by_hand)
    }
    if device == "cuda":
        graphs = [
            Captured(partial(weighted, by_hand, model), (poses, label), list(model.parameters())) for model, _ in models
        ]

        def replay(graphs):
            for graph in graphs:
                graph.launch(0, (poses, label))
            return [graph.result()["loss"] for graph in graphs]

        methods["captured"] = (lambda: replay(graphs[:1])), models[:1]
        methods[f"{TOGETHER} together"] = (lambda: replay(graphs)), models
    return methods


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("cell", ["code", "text"])
def test_an_iteration(device, cell):
    methods = contenders(cell, device)
    took = np.array([[seconds(*method, device) for method in methods.values()] for _ in range(TURNS + 1)])[1:]
    print(f"\n{device}, cell {cell}: ms an iteration, and speed relative to autograd")
    print("rounds  " + "".join(f"{name:>18}" for name in methods))
    for name, values in (("median", np.median(took, axis=0)), ("best", took.min(axis=0))):
        print(f"{name:8}" + "".join(f"{1e3 * value:10.1f} {values[0] / value:6.2f}x" for value in values))


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("cell", ["code", "text"])
def test_contenders_agree(cell, device):
    poses = torch.randn(4, FRAMES + 1, 54, device=device)
    model = VTLN(VTLNConfig(cell=cell, dropout=0.0), 1).to(device)
    values = []
    for outputs_of in (autograd, by_hand):
        torch.manual_seed(1)
        values += losses(outputs_of(model, poses[:, :-1], torch.ones(4, 1, device=device), SEED), poses)
    torch.testing.assert_close(values[2:], values[:2], rtol=1e-5, atol=0)
