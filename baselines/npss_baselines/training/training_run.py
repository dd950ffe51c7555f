"""A run in training: model, batches and validation. Several can be trained together."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import cast

import numpy as np
import torch
from torch import Tensor, nn
from torch.optim.swa_utils import AveragedModel, get_ema_multi_avg_fn

from npss_baselines.data.tasks import Task
from npss_baselines.data.windows import Batch, Batches, TrainingSet, digest
from npss_baselines.models import MODELS
from npss_baselines.models.base import MotionModel
from npss_baselines.runs import folder, log
from npss_baselines.runs.config import Configuration
from npss_baselines.runs.fitting import torch_seed
from npss_baselines.runs.predictor import ModelPredictor
from npss_baselines.training import objectives, selection
from npss_baselines.training.selection import Row


class TrainingRun(nn.Module):
    """A model in training, alone or with others; iteration i always computes the same.

    The batch, and the random numbers of the iteration, are functions of the seed and i: seed torch's generators with
    `seed` for each iteration.

    Parameters
    ----------
    configuration : Configuration
        The configuration of the run.
    training_set : TrainingSet
        The training set of its actions.
    validation_tasks : sequence of Task
        The validation tasks of its actions.
    out : Path
        The folder of the run.
    """

    mean: Tensor
    std: Tensor

    def __init__(
        self, configuration: Configuration, training_set: TrainingSet, validation_tasks: Sequence[Task], out: Path
    ) -> None:
        super().__init__()
        recipe = configuration.recipe
        self.configuration = configuration
        self._batches = Batches(
            training_set, batch=recipe.batch, n_seed=recipe.n_seed, n_target=recipe.n_target, seed=configuration.seed
        )
        #: The digest of the training set: a run cannot resume with other motion.
        self.motion = digest(training_set)
        self._validation = validation_tasks
        self._normalization = training_set.normalization
        self.out = out
        torch.manual_seed(configuration.seed)
        self.model = MODELS[configuration.name].build(configuration.model, len(configuration.actions))
        self.average: AveragedModel | None = None
        if configuration.average is not None:
            decay = get_ema_multi_avg_fn(configuration.average)  # type: ignore[no-untyped-call]
            self.average = AveragedModel(self.model, multi_avg_fn=decay)
        columns = list(self._normalization.columns)
        for name in ("mean", "std"):
            statistic = torch.tensor(getattr(self._normalization, name)[columns], dtype=torch.float32)
            self.register_buffer(name, statistic, persistent=False)
        #: One row per validation.
        self.rows: list[Row] = []
        #: The loss and its parts, for each iteration since the last validation.
        self.losses: dict[str, list[Tensor]] = defaultdict(list)

    def batch(self, iteration: int) -> Batch:
        """Return the batch of an iteration."""
        return self._batches[iteration]

    def seed(self, iteration: int) -> int:
        """Return the seed of torch's generators in an iteration."""
        return torch_seed(self.configuration.seed, iteration)

    def loss(self, poses: Tensor, label: Tensor, iteration: int) -> dict[str, Tensor]:
        """Return the loss of a batch, and its parts."""
        statistics = objectives.Statistics(self.mean, self.std)
        return objectives.loss(self.model, poses, label, self.configuration.recipe, iteration, statistics=statistics)

    def keep(self, parts: Mapping[str, Tensor]) -> None:
        """Keep the loss of an iteration until the next validation."""
        for name, value in parts.items():
            self.losses[name].append(value.detach())

    def kept(self) -> dict[str, Tensor]:
        """Return the kept losses (n,) by name."""
        # Losses from a checkpoint are on the CPU.
        device = self.mean.device
        return {name: torch.stack([value.to(device) for value in values]) for name, values in self.losses.items()}

    def validate(self, iteration: int) -> Row:
        """Validate the model, save it if it is the best so far, and record and return the row."""
        recipe, select = self.configuration.recipe, self.configuration.select
        row: Row = {"iteration": iteration, "lr": recipe.learning_rate(iteration - 1)}
        row |= {name: values.mean().item() for name, values in self.kept().items()}
        self.losses.clear()
        if not math.isfinite(row["loss"]):
            raise self._diverged(iteration, f"the loss was {row['loss']}")
        model = self.model
        if self.average is not None:
            row |= {f"{name}_not_averaged": value for name, value in self._measure(model, iteration).items()}
            model = cast(MotionModel, self.average.module)
        row |= self._measure(model, iteration)
        self.rows.append(row)
        if row is selection.best(self.rows, select):
            measured = {**row, "signature": selection.signature(self._validation)}
            folder.save(self.out, model, self._normalization, measured)
        log.write(self.out, self.rows)
        return row

    def _measure(self, model: MotionModel, iteration: int) -> Row:
        """Measure a model on the validation windows, with the same noise each time."""
        predictors = [
            ModelPredictor(
                model, self._normalization, self.configuration.actions.index(task.action), np.random.default_rng(0)
            )
            for task in self._validation
        ]
        try:
            return selection.measure(predictors, self._validation)
        except ValueError as error:  # the last step may have diverged, after its loss was computed
            raise self._diverged(iteration, str(error)) from error

    def _diverged(self, iteration: int, symptom: str) -> ValueError:
        return ValueError(
            f"training of {self.out} has diverged by iteration {iteration}: {symptom}; try a lower --recipe.lr"
        )
