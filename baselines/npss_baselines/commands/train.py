"""``npss-baselines train``: train a model."""

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
    # The options depend on the model.
    parser: argparse.ArgumentParser = commands.add_parser("train", help="train a model", add_help=False, forward=True)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Train, and print the result."""
    # Imported here: other commands need no torch.
    if options.arguments[:1] == ["manifold"]:
        options.extra = "manifold"
        from npss_baselines.commands import train_manifold

        train_manifold.run(options.arguments[1:], options.parser)
        return
    if options.arguments[:1] == ["restorer"]:
        options.extra = "manifold"
        from npss_baselines.commands import train_restorer

        train_restorer.run(options.arguments[1:], options.parser)
        return
    from npss_baselines.fitted import FITTED

    if options.arguments[:1] and options.arguments[0] in FITTED:
        from npss_baselines.commands import train_fitted

        train_fitted.run(options.arguments[0], options.arguments[1:], options.parser)
        return
    from npss_baselines.commands import train_options
    from npss_baselines.runs import config, launch, weights
    from npss_baselines.training import selection, trainer

    command = options.arguments
    configuration, options = train_options.parse(command, options.parser)
    device = launch.device_of(options.device, tf32=options.tf32)
    runs = train_options.runs_of(configuration, options)
    folders = [out for _, out in runs]
    before = launch.existing_runs(folders)
    threads = launch.threads_of(options.threads, before)
    source = configuration.source
    root, recorded_in = train_options.folder_of(options, source, before)
    together, data = [], {}
    for run, out in runs:
        if run.actions not in data:
            with launch.explain_missing_data(source.option, root, recorded_in):
                data[run.actions] = data_of(run, root, options.cache)
        together.append((run, *data[run.actions], out))
    paths = {} if root is None else {source.option: root}
    with (
        launch.use_threads(threads),
        launch.explain_resuming(folders, train_options.resume_arguments(options, command)),
        launch.exclusive_folders(options.out, folders, before),
    ):
        for run, _, _, out in together:
            described = f"{device}, tf32" if options.tf32 else device
            config.write(out / config.FILE, run, described, paths, config.plugins_of(run))
        rows = trainer.train_together(
            together, options.out, device=device, tf32=options.tf32, tensorboard=options.tensorboard
        )
    for (run, _, tasks, out), measured in zip(together, rows, strict=True):
        best = selection.best(measured, run.select)
        print(
            f"{out / weights.FILE}: weights of iteration {best['iteration']:.0f} of {measured[-1]['iteration']:.0f}, "
            f"validation NPSS {best['npss_released']:.4f} (released) and {best['npss_paper']:.4f} (paper)"
        )
        print(f"    {selection.signature(tasks)}")


def data_of(configuration: Configuration, root: Path | None, cache: Path | None) -> tuple[TrainingSet, Sequence[Task]]:
    """Return the training set and the validation tasks of a run."""
    source = configuration.source
    if root is None and not source.generated:
        raise ValueError(needs([source, *(other for other in pose_sources().values() if other.generated)], "--data "))
    return configuration.motion(root or Path(), cache=cache)
