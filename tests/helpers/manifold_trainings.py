"""A manifold that is quick to train, its training, and what that comes to."""

import os
import signal
from dataclasses import replace
from pathlib import Path

import torch
from safetensors.torch import load_file

from npss_baselines.data.synthetic import synthetic_clips
from npss_baselines.manifold.model.autoencoder import AutoencoderConfig
from npss_baselines.manifold.motion.dataset import prepare
from npss_baselines.manifold.training import config, schedule, trainer
from npss_baselines.manifold.training.recipe import Stage
from npss_baselines.runs import metrics, weights
from npss_baselines.runs.config import CHECKPOINT

TINY = AutoencoderConfig(widths=(4, 5), kernel=3, unpool="half", eps=0.05)


def small_chunks(assign=setattr):
    assign(schedule, "CHUNK", 3)
    assign(trainer, "CHECKPOINT_EVERY", 2)


def walkers(n, n_frames, seed):
    motion = prepare(synthetic_clips(n, n_frames, seed))
    mask = motion.mask.copy()
    mask[0, 100:] = False  # as if its clip were short
    return replace(motion, mask=mask)


def configured(**changes):
    """Both kinds of stages: layers by single windows and SGD, the whole by batches and Adam."""
    usual = {
        "model": TINY,
        "size": 0.5,
        "start": "glorot",
        "layers": Stage(epochs=2, lr=0.05, lr_decay=0.9, sparsity=0.01, unpool="random"),
        "whole": Stage(epochs=3, batch=3, optimizer="adam", lr=1e-2, lr_schedule="cosine", clip_norm=0.1, rescale=True),
    }
    return replace(config.defaults(), **usual | changes)


def trained(out, configuration, sets):
    """Train, and return the rows."""
    out.mkdir(exist_ok=True)
    config.write(out / config.FILE, configuration, "cpu")
    return trainer.train(configuration, *sets, out)


def outcome(out):
    """What a run has come to, to the bit."""
    checkpoint = torch.load(out / CHECKPOINT, weights_only=True)
    return {
        "weights": checkpoint["state_dict"],
        "optimizers": checkpoint["optimizer_states"],
        "chunk": checkpoint["global_step"],
        "kept": load_file(out / weights.FILE),
        "metrics": (out / metrics.FILE).read_text(encoding="utf-8"),
    }


def train_until_killed(out, configuration, sets, moment, number):
    """Train in a process of its own, which kills itself when something happens for the so-manieth time."""
    small_chunks()
    left = [number]

    def die_in_time():
        left[0] -= 1
        if left[0] == 0:
            os.kill(os.getpid(), signal.SIGKILL)

    rename, step = Path.replace, trainer.Training._step

    def replace_file(part, target):
        if moment == "writing":
            if left[0] == 1:  # only half of it is there
                os.truncate(part, part.stat().st_size // 2)
            die_in_time()
        rename(part, target)
        if moment == "written":
            die_in_time()

    def begin_batch(*arguments):
        if moment == "batch":
            die_in_time()
        return step(*arguments)

    Path.replace, trainer.Training._step = replace_file, begin_batch
    trained(out, configuration, sets)
