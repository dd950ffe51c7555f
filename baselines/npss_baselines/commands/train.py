"""Train a model on Human3.6M, or on a gait that needs no data."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from npss_baselines.commands.sources import needs
from npss_baselines.data import pose_sources
from npss_baselines.data.tasks import Task

if TYPE_CHECKING:
    from npss_baselines.data.windows import TrainingSet
    from npss_baselines.runs.config import Configuration


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss-baselines``."""
    # Which options there are depends on the model.
    parser: argparse.ArgumentParser = commands.add_parser("train", help="train a model", add_help=False, forward=True)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Train, and say what has come of it."""
    # Imported where they are used: the other commands need no torch.
    if options.arguments[:1] == ["manifold"]:
        options.extra = "manifold"
        from npss_baselines.commands import train_manifold

        train_manifold.run(options.arguments[1:])
        return
    from npss_baselines.commands import arguments
    from npss_baselines.runs import config, launch, weights
    from npss_baselines.training import trainer, validation

    said = options.arguments
    configuration, options = arguments.parse(said)
    device = launch.device_of(options.device, tf32=options.tf32)
    several = arguments.runs_of(configuration, options)
    folders = [out for _, out in several]
    before = launch.begun(folders)
    source = configuration.source
    root, recorded_in = arguments.folder_of(options, source, before)
    together, read = [], {}
    for one, out in several:
        if one.actions not in read:
            with launch.moved(source.option, root, recorded_in):
                read[one.actions] = data_of(one, root, options.cache)
        together.append((one, *read[one.actions], out))
    paths = {} if root is None else {source.option: root}
    with (
        launch.going_on(folders, arguments.resuming(options, said)),
        launch.folders_alone(options.out, folders, before),
    ):
        for one, _, _, out in together:
            made_on = f"{device}, tf32" if options.tf32 else device
            config.write(out / config.FILE, one, made_on, paths, config.plugins_of(one))
        rows = trainer.train_together(
            together, options.out, device=device, tf32=options.tf32, tensorboard=options.tensorboard
        )
    for (one, _, tasks, out), of_run in zip(together, rows, strict=True):
        kept = validation.best(of_run, one.select)
        print(
            f"{out / weights.FILE}: the weights of iteration {kept['iteration']:.0f} of {of_run[-1]['iteration']:.0f}, "
            f"on validation windows NPSS {kept['npss_released']:.4f} (released) and {kept['npss_paper']:.4f} (paper)"
        )
        print(f"    {validation.signature(tasks)}")


def data_of(configuration: Configuration, root: Path | None, cache: Path | None) -> tuple[TrainingSet, Sequence[Task]]:
    """Return what a run is trained on, and the windows by which its weights are chosen."""
    source = configuration.source
    if root is None and not source.generated:
        raise ValueError(needs([source, *(other for other in pose_sources().values() if other.generated)], "--data "))
    folder = root or Path()
    training_set = source.training_set(folder, configuration.actions, subjects=configuration.subjects, cache=cache)
    return training_set, source.validation_tasks(folder, configuration.validate_on, cache=cache)
