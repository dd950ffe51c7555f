"""A small model, its training and the results."""

import os
import sys
from dataclasses import dataclass

import torch
from safetensors.torch import load_file
from torch import nn

from killing import kill_at
from npss_baselines.__main__ import main
from npss_baselines.commands import train_options
from npss_baselines.data.synthetic import synthetic_training_set, synthetic_validation
from npss_baselines.models import MODELS, ModelSpec
from npss_baselines.models.base import POSE, MotionModel
from npss_baselines.models.recipe import Recipe
from npss_baselines.runs import config, log, weights
from npss_baselines.training import trainer


@dataclass(frozen=True)
class TinyConfig:
    """The configuration of a small model.

    Attributes
    ----------
    units : int
        Units of the cell.
    dropout : float
        Dropout of the input.
    noise : float
        Standard deviation of the noise of each sequence.
    """

    units: int = 6
    dropout: float = 0.2
    noise: float = 0.5


class Tiny(MotionModel):
    """A cell with dropout and noise, whose results repeat only with the same seeds."""

    def __init__(self, settings, n_actions):
        super().__init__(n_actions)
        self.noise = settings.noise
        self.cell = nn.GRUCell(POSE + n_actions + 1, settings.units)
        self.dropout = nn.Dropout(settings.dropout)
        self.out = nn.Linear(settings.units, POSE)

    def begin(self, label, n_steps):
        noise = self.noise * torch.randn(len(label), 1, device=label.device)
        return torch.cat([label, noise], 1), torch.zeros(len(label), self.cell.hidden_size, device=label.device)

    def step(self, pose, state):
        context, hidden = state
        hidden = self.cell(torch.cat([self.dropout(pose), context], 1), hidden)
        return self.out(hidden), (context, hidden)


RECIPE = Recipe(
    iterations=10,
    batch=4,
    n_seed=6,
    n_target=4,
    lr=1e-2,
    lr_decay=0.5,
    lr_milestones=(4, 8),
    clip_norm=0.2,
    closed_weight=((3, 0.5),),
)
TINY = ModelSpec("tiny", TinyConfig(), Tiny, RECIPE)


def configured(*options):
    return train_options.parse(["tiny", "--data", "synthetic", "--out", "nowhere", "--validate-every", "3", *options])[
        0
    ]


def trained(out, configuration, training_set=None):
    """Train on few walkers, and return the rows."""
    out.mkdir(exist_ok=True)
    config.write(out / config.FILE, configuration, "cpu")
    training_set = training_set or synthetic_training_set(3, 60)
    return trainer.train(configuration, training_set, synthetic_validation(2), out)


def outcome(out):
    """Return the results of a run, to the bit."""
    checkpoint = torch.load(out / config.CHECKPOINT, weights_only=True)
    return {
        "weights": checkpoint["state_dict"],
        "optimizer": checkpoint["optimizer_states"],
        "iteration": checkpoint["global_step"],
        "kept": load_file(out / weights.FILE),
        "metrics": (out / log.FILE).read_text(encoding="utf-8"),
    }


def train_until_killed(out, configuration, moment, number):
    """Train in a separate process that kills itself at the n-th event of a kind."""
    MODELS.register("tiny", TINY)
    kill_at(moment, number, torch.optim.Optimizer, "zero_grad", "iteration")
    trained(out, configuration)


def command(*arguments):
    """Run ``npss-baselines``."""
    return main([str(argument) for argument in arguments])


def train_a_command(options, number):
    """Train in a separate process, which gets a signal."""
    loss = trainer.TrainingRun.loss

    def interrupted(*arguments):
        if arguments[-1] == 1:
            os.kill(os.getpid(), number)
        return loss(*arguments)

    trainer.TrainingRun.loss = interrupted
    sys.exit(command(*options))
