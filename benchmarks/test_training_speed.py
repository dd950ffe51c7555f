"""How long VGRU-d takes to train, against the same cells in a loop: one iteration of equation 6, in turn in one run.

``pytest benchmarks/test_training_speed.py -s``

An iteration is a forward pass, a backward pass, clipping and a step of the optimiser: 32 windows of 50 + 100 frames,
512 units, two threads. `loop` is the way in which one writes it down: the open loop over all frames, then seed and
closed loop, both by autograd and torch's dropout, with the guides in common. Turns alternate, so that what else
the machine does meets all of them. Read the ratios, not the times; and none of them, where another program keeps a
core busy: threads then wait for each other, and that is what one measures.

Where there is a CUDA device, the same is measured there, and besides, as training does it: `captured`, loss and
gradients as one graph; and `together`, so many models side by side, of which the time is that of one.
"""

import time
from functools import partial

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch")

from torch.nn import functional  # noqa: E402

from npss_baselines.models.derivatives import next_derivatives, no_past  # noqa: E402
from npss_baselines.models.vtln import VTLN, VTLNConfig  # noqa: E402
from npss_baselines.training.captured import Captured  # noqa: E402

BATCH, SEED, FRAMES, TURNS, TOGETHER = 32, 50, 150, 5, 4
DEVICES = ["cpu", pytest.param("cuda", marks=pytest.mark.skipif(not torch.cuda.is_available(), reason="needs CUDA"))]


@pytest.fixture(autouse=True)
def two_threads():
    threads = torch.get_num_threads()
    torch.set_num_threads(2)
    torch.manual_seed(0)
    yield
    torch.set_num_threads(threads)


def loop(model, poses, label, n_seed):
    """`VTLN.open_and_closed` by autograd, cell after cell."""
    p, n_frames = model.config.dropout, poses.shape[1]
    h = model.mu + functional.softplus(model.s).sqrt() * torch.randn(len(poses), len(model.mu), device=poses.device)
    guides = []
    for _ in range(n_frames):
        h = model.top(label, h)
        guides.append(h)

    def run(n_true):
        h, past, outputs = torch.zeros_like(guides[0]), no_past(poses, 3), []
        for t, guide in enumerate(reversed(guides)):
            x, past = next_derivatives(poses[:, t] if t < n_true else outputs[-1], past, 3)
            h = model.body(functional.dropout(x, p), h, guide)
            outputs.append(model.decoder(functional.dropout(h, p)))
        return torch.stack(outputs, 1)

    return run(n_frames), run(n_seed)[:, n_seed:]


def by_hand(model, poses, label, n_seed):
    return model.open_and_closed(poses, label, n_seed)


def losses(outputs, poses):
    opened, closed = outputs
    return functional.mse_loss(opened, poses[:, 1:]), functional.mse_loss(closed, poses[:, SEED + 1 :])


def seconds(train, models, device):
    """Train models once, each by its own optimiser, and return the seconds that it took for each of them."""
    waits = torch.cuda.synchronize if device == "cuda" else lambda: None
    waits()
    start = time.perf_counter()
    for loss, (model, optimizer) in zip(train(), models, strict=True):
        optimizer.zero_grad()
        loss.backward()
        torch.nn.utils.clip_grad_norm_(model.parameters(), 1.0)
        optimizer.step()
    waits()
    return (time.perf_counter() - start) / len(models)


def contenders(cell, device):
    """What trains models of a cell, by name: a function that returns their losses, and the models."""
    poses = torch.randn(BATCH, FRAMES + 1, 54, device=device)
    label = torch.ones(BATCH, 1, device=device)
    models = [VTLN(VTLNConfig(cell=cell), 1).to(device) for _ in range(TOGETHER)]
    models = [(model, torch.optim.RMSprop(model.parameters(), lr=1e-5, momentum=0.95)) for model in models]

    def weighted(outputs_of, model, poses, label):
        opened, closed = losses(outputs_of(model, poses[:, :-1], label, SEED), poses)
        return {"loss": opened + 0.6 * closed}

    first = models[0][0]
    found = {
        of.__name__: (lambda of=of: [weighted(of, first, poses, label)["loss"]], models[:1]) for of in (loop, by_hand)
    }
    if device == "cuda":
        graphs = [
            Captured(partial(weighted, by_hand, model), (poses, label), list(model.parameters())) for model, _ in models
        ]

        def replay(graphs):
            for graph in graphs:
                graph.launch(0, (poses, label))
            return [graph.result()["loss"] for graph in graphs]

        found["captured"] = (lambda: replay(graphs[:1])), models[:1]
        found[f"{TOGETHER} together"] = (lambda: replay(graphs)), models
    return found


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("cell", ["code", "text"])
def test_an_iteration(device, cell):
    every = contenders(cell, device)
    took = np.array([[seconds(*one, device) for one in every.values()] for _ in range(TURNS + 1)])[1:]
    print(f"\n{device}, cell {cell}: ms an iteration, and how many times faster than the loop")
    print("of turns" + "".join(f"{name:>18}" for name in every))
    for name, values in (("median", np.median(took, axis=0)), ("best", took.min(axis=0))):
        print(f"{name:8}" + "".join(f"{1e3 * value:10.1f} {values[0] / value:6.2f}x" for value in values))


@pytest.mark.parametrize("device", DEVICES)
@pytest.mark.parametrize("cell", ["code", "text"])
def test_what_is_compared_is_the_same(cell, device):
    poses = torch.randn(4, FRAMES + 1, 54, device=device)
    model = VTLN(VTLNConfig(cell=cell, dropout=0.0), 1).to(device)
    values = []
    for outputs_of in (loop, by_hand):
        torch.manual_seed(1)
        values += losses(outputs_of(model, poses[:, :-1], torch.ones(4, 1, device=device), SEED), poses)
    torch.testing.assert_close(values[2:], values[:2], rtol=1e-5, atol=0)
