"""Train a model on Human3.6M, or on a gait that needs no data."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from baselines.data import h36m
from baselines.tasks import Task

if TYPE_CHECKING:
    from baselines.training.config import Configuration
    from baselines.training.windows import TrainingSet


def add_parser(commands: Any) -> None:
    """Add the command to those of ``python -m baselines``."""
    # Which options there are depends on the model: nothing is one to this parser, and `parse` reads them all.
    parser: argparse.ArgumentParser = commands.add_parser(
        "train", help="train a model", add_help=False, prefix_chars="\0"
    )
    parser.add_argument("arguments", nargs="*")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Train, and say what has come of it."""
    # Imported where it is used: the other commands need no torch.
    import torch

    if options.arguments[:1] == ["manifold"]:
        from baselines.manifold import train_command

        train_command.run(options.arguments[1:])
        return
    from baselines.training import arguments, config, runs, trainer, validation

    configuration, options = arguments.parse(options.arguments)
    device = options.device
    if device == "auto":
        device = "cuda" if torch.cuda.is_available() else "cpu"
    if options.tf32 and device != "cuda":
        raise ValueError("--tf32: needs a CUDA device")
    together, read = [], {}
    for one, out in arguments.runs_of(configuration, options):
        if one.actions not in read:
            read[one.actions] = data_of(one, options.h36m, options.cache)
        together.append((one, *read[one.actions], out))
    for one, _, _, out in together:
        out.mkdir(parents=True, exist_ok=True)
        config.write(out / config.FILE, one, f"{device}, tf32" if options.tf32 else device)
    rows = trainer.train_together(
        together, options.out, device=device, tf32=options.tf32, tensorboard=options.tensorboard
    )
    for (one, _, tasks, out), of_run in zip(together, rows, strict=True):
        kept = validation.best(of_run, one.select)
        print(
            f"{out / runs.FILE}: the weights of iteration {kept['iteration']:.0f} of {of_run[-1]['iteration']:.0f}, "
            f"on validation windows NPSS {kept['npss_released']:.4f} (released) and {kept['npss_paper']:.4f} (paper)"
        )
        print(f"    {validation.signature(tasks)}")


def data_of(configuration: Configuration, root: Path | None, cache: Path | None) -> tuple[TrainingSet, Sequence[Task]]:
    """Return what a run is trained on, and the windows by which its weights are chosen."""
    from baselines.training import windows

    if configuration.data == "synthetic":
        return windows.synthetic_training_set(), windows.synthetic_validation()
    if root is None:
        raise ValueError("--h36m DIR names the folder of Human3.6M; --data synthetic needs no data")
    data = h36m.open_root(root, cache=cache)
    training_set = windows.h36m_training_set(data, configuration.actions, subjects=configuration.subjects)
    return training_set, windows.h36m_validation(data, configuration.validate_on)
