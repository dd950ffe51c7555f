"""Time of a training iteration on one thread and on two, which spin or sleep while they wait for each other.

``pytest benchmarks/test_threads_speed.py -s``

An iteration is one of the model's recipe, but with 10 + 20 frames: shorter sequences have the same steps, and so nearly
the same ratios. Each way runs in a process of its own, since torch reads the way of waiting when it is imported. The
processes take turns, first without other load and then beside programs that keep a processor busy each. Read the
ratios: above 1, two threads are faster than one. The first table is of an idle machine only if nothing else runs there.

``NPSS_THREADS`` is the larger number of threads (default: 2), ``NPSS_TURNS`` that of turns (default: 5).
"""

import os
import subprocess
import sys
import time
from contextlib import ExitStack, contextmanager
from dataclasses import replace

import numpy as np
import pytest

MODELS = ("vgru-d", "gru-d", "mbr-long", "lstm-3lr", "manifold")
THREADS, TURNS = int(os.environ.get("NPSS_THREADS", "2")), int(os.environ.get("NPSS_TURNS", "5"))
WAYS = {"one": (1, {}), "spinning": (THREADS, {"GOMP_SPINCOUNT": "300000"}), "sleeping": (THREADS, {})}
BUSY = (0, 1, 2)


def iteration_of(name):
    """Return a function that trains a model for an iteration."""
    import torch

    from npss_baselines import models
    from npss_baselines.manifold.model.autoencoder import Autoencoder
    from npss_baselines.manifold.training import config
    from npss_baselines.manifold.training.loss import loss_of
    from npss_baselines.training import objectives

    torch.manual_seed(0)
    if name == "manifold":
        configuration = config.defaults()
        network, stage = Autoencoder(configuration.model), configuration.whole
        windows = torch.randn(stage.batch, 160, 63) / 8
        of_frames, of_steps = (torch.full((stage.batch, n, 1), 1e-4) for n in (160, 160 // configuration.model.stride))
        options = {"corruption": stage.corruption, "sparsity": stage.sparsity, "random": stage.unpool == "random"}

        def loss():
            return loss_of(network.first(), windows, of_frames, of_steps, rescale=stage.rescale, **options)
    else:
        spec = models.MODELS[name]
        recipe = replace(spec.recipe, n_seed=10, n_target=20)
        network = spec.build(spec.config, 1)
        poses, label = torch.randn(recipe.batch, recipe.window, 54), torch.ones(recipe.batch, 1)

        def loss():
            return objectives.loss(network, poses, label, recipe, recipe.iterations - 1)["loss"]

    optimizer = torch.optim.SGD(network.parameters(), lr=1e-6)

    def train():
        optimizer.zero_grad()
        loss().backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 1.0)
        optimizer.step()

    return train


def work(name, threads):
    """Train for an iteration per line of standard input; print its seconds."""
    import torch

    torch.set_num_threads(int(threads))
    train = iteration_of(name)
    train()
    print("ready", flush=True)
    for _ in sys.stdin:
        start = time.perf_counter()
        train()
        print(time.perf_counter() - start, flush=True)


@contextmanager
def process(*arguments, **variables):
    """Start a process that answers line by line; return a function that asks it."""
    without = {name: value for name, value in os.environ.items() if not name.startswith(("OMP_", "GOMP_"))}
    environment = {**without, "OMP_WAIT_POLICY": "PASSIVE", **variables}
    command = [sys.executable, *arguments]
    with subprocess.Popen(command, env=environment, stdin=-1, stdout=-1, encoding="utf-8") as started:

        def ask():
            print(file=started.stdin, flush=True)
            return float(started.stdout.readline())

        try:
            assert started.stdout.readline() == "ready\n"
            yield ask
        finally:
            started.kill()


@pytest.mark.parametrize("model", MODELS)
def test_an_iteration(model):
    pytest.importorskip("lightning", reason="needs lightning")
    print(f"\n{model}: s an iteration on one thread, and how many times faster {THREADS} are (median of {TURNS} turns)")
    with ExitStack() as stack:
        ways = [
            stack.enter_context(process(__file__, model, str(threads), **variables))
            for threads, variables in WAYS.values()
        ]
        for busy in BUSY:
            with ExitStack() as load:
                for _ in range(busy):
                    load.enter_context(process("-c", "print('ready', flush=True)\nwhile True: pass"))
                one, *others = np.median([[ask() for ask in ways] for _ in range(TURNS)], axis=0)
            ratios = ", ".join(f"{way} {one / other:.2f}" for way, other in zip(list(WAYS)[1:], others, strict=True))
            print(f"beside {busy} busy programs: {one:6.3f} s; {ratios}", flush=True)


if __name__ == "__main__":
    work(*sys.argv[1:])
