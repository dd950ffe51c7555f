"""Training by Lightning such that a run that is cut off anywhere, and resumed, ends as if it had not been."""

from __future__ import annotations

import csv
import itertools
import logging
import math
import pickle
import sys
import warnings
from collections import defaultdict
from collections.abc import Iterator, Sequence
from functools import partial
from pathlib import Path
from typing import Any, cast

import numpy as np
import torch
from torch import Tensor
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from baselines.evaluate import Task
from baselines.models import MODELS
from baselines.models.base import MotionModel
from baselines.training import objectives, runs, validation
from baselines.training._files import write_atomically
from baselines.training.config import Configuration
from baselines.training.recipe import Recipe
from baselines.training.rmsprop import RMSpropTF
from baselines.training.validation import Row
from baselines.training.windows import Batches, TrainingSet

try:
    from lightning.pytorch import LightningModule, Trainer
    from lightning.pytorch.loggers import TensorBoardLogger
    from lightning.pytorch.plugins import TorchCheckpointIO
except ImportError:
    raise ImportError("training needs lightning: pip install 'npss[baselines]'") from None

#: The file of a run from which it goes on.
CHECKPOINT = "last.ckpt"
#: The file of a run with what was measured at each validation.
METRICS = "metrics.csv"


class Training(LightningModule):
    """A model in training: iteration i does the same whenever it is done.

    The batch is a function of the seed and of i, and so is all that is drawn in it, because torch's generators are
    seeded anew for each iteration; the learning rate is a function of i. What else an iteration depends on, the weights
    and the state of the optimiser, is in the checkpoint.

    Parameters
    ----------
    configuration : Configuration
        What the run is.
    training_set : TrainingSet
        Of its actions.
    validation_tasks : sequence of Task
        Of its actions.
    out : Path
        The folder of the run.
    """

    mean: Tensor
    std: Tensor

    def __init__(
        self, configuration: Configuration, training_set: TrainingSet, validation_tasks: Sequence[Task], out: Path
    ) -> None:
        super().__init__()
        recipe, seed = configuration.recipe, configuration.seed
        self.configuration = configuration
        self.recipe: Recipe = recipe
        self.batches = Batches(
            training_set, batch=recipe.batch, n_seed=recipe.n_seed, n_target=recipe.n_target, seed=seed
        )
        self.validation = validation_tasks
        self.normalization = training_set.normalization
        self.out = out
        torch.manual_seed(seed)
        self.model = MODELS[configuration.name].build(configuration.model, len(configuration.actions))
        self.average: AveragedModel | None = None
        if configuration.average is not None:
            decay = get_ema_multi_avg_fn(configuration.average)  # type: ignore[no-untyped-call]
            self.average = AveragedModel(self.model, multi_avg_fn=decay)
        kept = list(self.normalization.columns)
        self.register_buffer("mean", torch.tensor(self.normalization.mean[kept], dtype=torch.float32), persistent=False)
        self.register_buffer("std", torch.tensor(self.normalization.std[kept], dtype=torch.float32), persistent=False)
        #: One for each validation.
        self.rows: list[Row] = []
        #: The loss and its parts in each iteration since the last validation.
        self.losses: dict[str, list[Tensor]] = defaultdict(list)

    def train_dataloader(self) -> Iterator[tuple[Tensor, Tensor]]:
        """Return the batches that are left."""
        for iteration in itertools.count(self.global_step):
            batch = self.batches[iteration]
            yield torch.from_numpy(batch.poses), torch.from_numpy(batch.label)

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """Return the optimiser of the recipe."""
        recipe, parameters = self.recipe, self.model.parameters()
        if recipe.optimizer == "adam":
            return torch.optim.Adam(parameters, lr=recipe.lr)
        if recipe.optimizer == "sgd":
            return torch.optim.SGD(parameters, lr=recipe.lr, momentum=recipe.momentum)
        return RMSpropTF(parameters, lr=recipe.lr, momentum=recipe.momentum)

    def training_step(self, batch: tuple[Tensor, Tensor], _: int) -> Tensor:
        """Return the loss of an iteration."""
        iteration = self.global_step
        entropy = np.random.SeedSequence([self.configuration.seed, iteration, 1])  # without the 1, that of the batch
        torch.manual_seed(int(entropy.generate_state(1, np.uint64)[0]))
        statistics = objectives.Statistics(self.mean, self.std)
        parts = objectives.loss(self.model, *batch, self.recipe, iteration, statistics=statistics)
        for name, value in parts.items():
            self.losses[name].append(value.detach())
        if self.trainer.progress_bar_callback is not None:
            self.log("loss", parts["loss"], prog_bar=True, logger=False)
        return parts["loss"]

    def on_before_optimizer_step(self, optimizer: torch.optim.Optimizer) -> None:
        """Set the learning rate of the iteration."""
        for group in optimizer.param_groups:
            group["lr"] = self.recipe.learning_rate(self.global_step)

    def on_train_batch_end(self, *_: Any) -> None:
        """Average, validate and save, each in its turn."""
        done = self.global_step
        if self.average is not None:
            self.average.update_parameters(self.model)
        validate = done % self.configuration.validate_every == 0 or done == self.recipe.iterations
        if validate:
            self._validate(done)
        if validate or done % self.configuration.checkpoint_every == 0:
            # Last, because it is what counts: all that came before would be done again, and be the same.
            self.trainer.save_checkpoint(self.out / CHECKPOINT)

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Add what has been measured."""
        checkpoint["rows"] = self.rows
        checkpoint["losses"] = {name: torch.stack(values) for name, values in self.losses.items()}

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Restore what had been measured."""
        self.rows = checkpoint["rows"]
        self.losses.update({name: list(values.unbind()) for name, values in checkpoint["losses"].items()})

    def _validate(self, iteration: int) -> None:
        """Measure the model, keep it if it is the best so far, and write down what was measured."""
        row: Row = {"iteration": iteration, "lr": self.recipe.learning_rate(iteration - 1)}
        row |= {name: torch.stack(values).mean().item() for name, values in self.losses.items()}
        self.losses.clear()
        if not math.isfinite(row["loss"]):
            raise ValueError(
                f"training has diverged: the loss was {row['loss']} by iteration {iteration}; try a lower --recipe.lr"
            )
        model = self.model
        if self.average is not None:
            row |= {f"{name}_not_averaged": value for name, value in self._measure(model).items()}
            model = cast(MotionModel, self.average.module)
        row |= self._measure(model)
        self.rows.append(row)
        if row is validation.best(self.rows, self.configuration.select):
            measured = {**row, "signature": validation.signature(self.validation)}
            runs.save(self.out, model, self.normalization, measured)
        write_atomically(self.out / METRICS, self._write_rows)
        if self.logger is not None:
            self.logger.log_metrics(row, step=iteration)

    def _measure(self, model: MotionModel) -> Row:
        """Measure a model on the validation windows; what is random in it is drawn alike each time."""
        predictors = [
            runs.ModelPredictor(
                model, self.normalization, self.configuration.actions.index(task.action), np.random.default_rng(0)
            )
            for task in self.validation
        ]
        return validation.measure(predictors, self.validation)

    def _write_rows(self, path: Path) -> None:
        with path.open("w", newline="", encoding="utf-8") as file:
            writer = csv.DictWriter(file, dict.fromkeys(name for row in self.rows for name in row))
            writer.writeheader()
            writer.writerows(self.rows)


class AtomicIO(TorchCheckpointIO):
    """Lightning's checkpoints, written such that the old one or the new one is there, whole."""

    def save_checkpoint(self, checkpoint: dict[str, Any], path: Any, storage_options: Any | None = None) -> None:
        """Write a checkpoint: Lightning's own way is by a file in another folder, perhaps of another disk."""
        write_atomically(Path(path), partial(torch.save, checkpoint))

    def load_checkpoint(self, path: Any, *arguments: Any, **options: Any) -> dict[str, Any]:
        """Read a checkpoint; nothing in it can run code."""
        try:
            return super().load_checkpoint(path, *arguments, **{**options, "weights_only": True})
        except (EOFError, pickle.UnpicklingError, RuntimeError) as error:
            raise ValueError(f"{path}: not a checkpoint ({error})") from error


def train(
    configuration: Configuration,
    training_set: TrainingSet,
    validation_tasks: Sequence[Task],
    out: Path,
    *,
    device: str = "cpu",
    tensorboard: bool = False,
) -> list[Row]:
    """Train a model, from the checkpoint on if the run has one.

    Parameters
    ----------
    configuration : Configuration
        What the run is.
    training_set : TrainingSet
        Of its actions.
    validation_tasks : sequence of Task
        Of its actions.
    out : Path
        The folder of the run; it is there.
    device : {'cpu', 'cuda'}, optional
        What it is computed on.
    tensorboard : bool, optional
        Write logs for TensorBoard, too.

    Returns
    -------
    list of dict
        What was measured at each validation.

    Raises
    ------
    ValueError
        If the data do not suffice, training diverges, or the checkpoint is broken.
    """
    checkpoint = out / CHECKPOINT
    logging.getLogger("lightning.pytorch").setLevel(logging.WARNING)  # no advertisements
    with torch.random.fork_rng(devices=range(torch.cuda.device_count())), warnings.catch_warnings():
        # Lightning 2.6 itself uses what torch has deprecated since.
        warnings.filterwarnings("ignore", r".*LeafSpec", FutureWarning)
        warnings.filterwarnings("ignore", "GPU available but not used", UserWarning)  # as was asked
        training = Training(configuration, training_set, validation_tasks, out)
        trainer = Trainer(
            accelerator=device,
            devices=1,
            max_epochs=-1,
            max_steps=configuration.recipe.iterations,
            gradient_clip_val=configuration.recipe.clip_norm,
            plugins=[AtomicIO()],
            logger=TensorBoardLogger(out, name="", version="tensorboard") if tensorboard else False,
            enable_progress_bar=sys.stdout.isatty(),
            enable_checkpointing=False,
            enable_model_summary=False,
            default_root_dir=out,
        )
        trainer.fit(training, ckpt_path=checkpoint if checkpoint.exists() else None, weights_only=True)
    return training.rows
