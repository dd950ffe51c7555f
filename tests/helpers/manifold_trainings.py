"""A small manifold, its training and the results."""

from dataclasses import replace

import torch
from safetensors.torch import load_file

from killing import kill_at
from npss_baselines.data.synthetic import synthetic_clips
from npss_baselines.manifold.model.autoencoder import AutoencoderConfig
from npss_baselines.manifold.motion.dataset import prepare
from npss_baselines.manifold.training import config, schedule, trainer
from npss_baselines.manifold.training.recipe import Stage
from npss_baselines.runs import log, weights
from npss_baselines.runs.config import CHECKPOINT

TINY = AutoencoderConfig(widths=(4, 5), kernel=3, unpool="half", eps=0.05)


def small_chunks(assign=setattr):
    assign(schedule, "CHUNK", 3)
    assign(trainer, "CHECKPOINT_EVERY", 2)


def walkers(n, n_frames, seed):
    motion = prepare(synthetic_clips(n, n_frames, seed))
    mask = motion.mask.copy()
    mask[0, 100:] = False  # like a short clip
    return replace(motion, mask=mask)


def configured(**changes):
    """Return a configuration with both kinds of stages: single windows and SGD, batches and Adam."""
    defaults = {
        "model": TINY,
        "size": 0.5,
        "start": "glorot",
        "layers": Stage(epochs=2, lr=0.05, lr_decay=0.9, sparsity=0.01, unpool="random"),
        "whole": Stage(epochs=3, batch=3, optimizer="adam", lr=1e-2, lr_schedule="cosine", clip_norm=0.1, rescale=True),
    }
    return replace(config.defaults(), **defaults | changes)


def trained(out, configuration, sets):
    """Train, and return the rows."""
    out.mkdir(exist_ok=True)
    config.write(out / config.FILE, configuration, "cpu")
    return trainer.train(configuration, *sets, out)


def outcome(out):
    """Return the results of a run, to the bit."""
    checkpoint = torch.load(out / CHECKPOINT, weights_only=True)
    return {
        "weights": checkpoint["state_dict"],
        "optimizers": checkpoint["optimizer_states"],
        "chunk": checkpoint["global_step"],
        "kept": load_file(out / weights.FILE),
        "metrics": (out / log.FILE).read_text(encoding="utf-8"),
    }


def train_until_killed(out, configuration, sets, moment, number):
    """Train in a separate process that kills itself at the n-th event of a kind."""
    small_chunks()
    kill_at(moment, number, trainer.Training, "_step", "batch")
    trained(out, configuration, sets)
