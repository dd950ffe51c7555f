"""Time to train the manifold by the paper's schedule, and to project motion.

``pytest benchmarks/test_manifold_speed.py -s``

A step is the forward pass, backward pass and update of one window of (160, 63), with hand-written gradients
(`PerWindowSGD`) and with autograd and torch's SGD, in turn in one run. Hand-written gradients stay while they are 1.3
times as fast. Read the ratios; times are the best, in processor time. Both are extrapolated to four phases of 25 epochs
of 9673 windows, as in the paper.

``NPSS_MANIFOLD_SCHEDULE=25`` trains this schedule like the command, on 9673 generated windows, and prints its duration;
``=1`` trains one epoch a phase. ``NPSS_THREADS`` is the number of threads (default: 1).
"""

import os
import time
from dataclasses import replace

import numpy as np
import pytest

torch = pytest.importorskip("torch", reason="needs torch")
pytest.importorskip("lightning", reason="needs lightning")

from npss_baselines.data.synthetic import synthetic_clips  # noqa: E402
from npss_baselines.manifold.model.autoencoder import Autoencoder  # noqa: E402
from npss_baselines.manifold.model.per_window_sgd import PerWindowSGD  # noqa: E402
from npss_baselines.manifold.model.projector import Manifold  # noqa: E402
from npss_baselines.manifold.motion.dataset import prepare  # noqa: E402
from npss_baselines.manifold.motion.scaling import Scaling  # noqa: E402
from npss_baselines.manifold.training import config, trainer  # noqa: E402
from npss_baselines.manifold.training.loss import loss_of  # noqa: E402

WINDOWS, EPOCHS = 9673, 25
WALKERS, FRAMES = 17, 160 + 80 * (WINDOWS // 17 - 1)  # 17 walks of 569 windows
TURNS, STEPS = 10, 20
#: Operations of a projection as convolutions: a multiplication and an addition for each frame and weight, twice.
OPERATIONS = 2 * 2 * 15 * (160 * 63 * 64 + 80 * 64 * 128 + 40 * 128 * 256)
#: The largest ratio of a projection's time to the floor, by windows in a batch.
AT_MOST = {1: 2.0, 64: 1.3}


@pytest.fixture(autouse=True)
def threads():
    before = torch.get_num_threads()
    torch.set_num_threads(int(os.environ.get("NPSS_THREADS", "1")))
    torch.manual_seed(0)
    yield
    torch.set_num_threads(before)


def seconds(work):
    start = time.process_time()
    for _ in range(STEPS):
        work()
    return (time.process_time() - start) / STEPS


def contenders(phase, network):
    """Return a step with hand-written gradients and one with autograd, on the same layers and window."""
    stage, layers = phase.stage, network.first(phase.depth)[phase.first :]
    options = {"corruption": stage.corruption, "sparsity": stage.sparsity, "random": stage.unpool == "random"}
    with torch.no_grad():
        seen = network.encode(torch.randn(1, 160, 63) / 8, phase.first).contiguous()
    of_frames = torch.full((1, seen.shape[1], 1), 1 / seen[0].numel())
    of_steps = torch.full((1, 160 // 2**phase.depth, 1), 1e-4)
    sgd = PerWindowSGD(layers, seen.shape[1], **options)
    optimizer = torch.optim.SGD([parameter for layer in layers for parameter in layer.parameters()], lr=1e-3)

    @torch.no_grad()
    def by_hand():
        sgd.step(seen[0], of_frames[0], of_steps[0], 1e-3)

    def autograd():
        optimizer.zero_grad()
        loss_of(layers, seen, of_frames, of_steps, **options).backward()
        optimizer.step()

    return by_hand, autograd


def test_steps_of_the_schedule():
    configuration = config.defaults("paper")
    network = Autoencoder(configuration.model)
    print(f"\n{torch.get_num_threads()} threads; ms a step, best of {TURNS} rounds of {STEPS}")
    print(f"{'phase':10}{'by hand':>9}{'autograd':>10}{'times faster':>14}")
    total = np.zeros(2)
    for phase in configuration.phases:
        steps = contenders(phase, network)
        took = np.array([[seconds(step) for step in steps] for _ in range(TURNS + 1)])[1:].min(0)
        total += took
        print(f"{phase.name:10}{1e3 * took[0]:9.2f}{1e3 * took[1]:10.2f}{took[1] / took[0]:14.2f}")
    hand, autograd = total * WINDOWS * EPOCHS / 60
    print(f"whole schedule, {EPOCHS} epochs of {WINDOWS} windows a phase: {hand:.0f} min, autograd {autograd:.0f} min")


def floor(size=1024):
    """Return the seconds that a projection's operations take in a large matrix product."""
    first, second = torch.randn(2, size, size)
    started = time.process_time()
    first @ second
    return (time.process_time() - started) * OPERATIONS / (2 * size**3)


def test_projection():
    """Compare projections with the floor: a convolution's operations at the rate of a large matrix product.

    Floor and projections take turns. Their best times have a ratio of at most `AT_MOST`, for motions alone and in
    batches.
    """
    network = Autoencoder(config.defaults("paper").model).eval()
    manifold = Manifold(network, Scaling(np.zeros(63), np.ones(63)), "untrained")
    motions = np.random.default_rng(0).normal(0, 0.1, (64, 160, 63)).astype(np.float32)
    parts = torch.from_numpy(motions)
    rows = {
        ("projected", 1): lambda: manifold.project(motions[:1]),
        ("projected", 64): lambda: manifold.project(motions),
        ("encoded", 1): lambda: manifold.encode(motions[:1]),
        ("encoded", 64): lambda: manifold.encode(motions),
        ("projected by convolutions", 1): lambda: network.project(parts[:1]),
        ("projected by convolutions", 64): lambda: network.project(parts),
    }
    took, floors = {row: [] for row in rows}, []
    with torch.no_grad():
        for _ in range(TURNS + 1):
            floors.append(floor())
            for (what, n), work in rows.items():
                started = time.process_time()
                for _ in range(STEPS if n == 1 else 1):
                    work()
                took[what, n].append((time.process_time() - started) / (STEPS if n == 1 else n))
    ms = 1e3 * min(floors)
    print(f"\n{torch.get_num_threads()} threads; ms a window of (160, 63), best of {TURNS} rounds")
    print(f"floor: {OPERATIONS / 1e6:.0f} MFLOP at {OPERATIONS / ms / 1e6:.0f} GFLOP/s: {ms:.2f}")
    for (what, n), times in took.items():
        best = 1e3 * min(times[1:])
        print(f"{what:26} in batches of {n:2} {best:6.2f} {best / ms:6.2f} x floor")
    for n, most in AT_MOST.items():
        assert 1e3 * min(took["projected", n]) <= most * ms


@pytest.mark.skipif("NPSS_MANIFOLD_SCHEDULE" not in os.environ, reason="needs NPSS_MANIFOLD_SCHEDULE")
def test_the_whole_schedule(tmp_path):
    epochs = int(os.environ["NPSS_MANIFOLD_SCHEDULE"])
    training_set = prepare(synthetic_clips(WALKERS, FRAMES, seed=1))
    validation_set = prepare(synthetic_clips(2, 500, seed=2))
    assert training_set.windows.shape == (WINDOWS, 160, 63)
    configuration = config.defaults("paper")
    configuration = replace(
        configuration,
        layers=replace(configuration.layers, epochs=epochs),
        whole=replace(configuration.whole, epochs=epochs),
    )
    start = time.perf_counter()
    rows = trainer.train(configuration, training_set, validation_set, tmp_path)
    took = time.perf_counter() - start
    print(f"\n{torch.get_num_threads()} threads, {epochs} epochs of {WINDOWS} windows a phase: {took / 60:.1f} min")
    for row in rows:
        print(f"{row['phase']:8} epoch {row['epoch']:3} loss {row['loss']:.5f} joint error {row['error']:.4f}")
