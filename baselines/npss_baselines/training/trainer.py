"""The training loop: one run, or several at once with the same results."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import torch
from torch import Tensor, nn

from npss_baselines.data.tasks import Task
from npss_baselines.data.windows import TrainingSet
from npss_baselines.models.recipe import Recipe
from npss_baselines.runs.config import CHECKPOINT, Configuration
from npss_baselines.runs.fitting import Resumable, fit
from npss_baselines.training.captured import Captured
from npss_baselines.training.rmsprop import RMSpropTF
from npss_baselines.training.selection import Row
from npss_baselines.training.training_run import TrainingRun

_Batches = Sequence[tuple[Tensor, Tensor]]  # one per member


class Training(Resumable):
    """Runs in training, each with the same result as alone.

    The learning rate is a function of the iteration. The weights and the state of the optimiser, on which an iteration
    also depends, are in the checkpoint.

    On a CUDA device, the members' losses and gradients are captured and computed side by side. NPSS in the loss cannot
    be captured, because its control flow depends on values.

    Parameters
    ----------
    members : sequence of TrainingRun
        The runs, with the same recipe and validation schedule.
    out : Path
        The folder of the checkpoint.
    """

    def __init__(self, members: Sequence[TrainingRun], out: Path) -> None:
        recipe: Recipe = members[0].configuration.recipe
        super().__init__(
            out,
            [recipe.work(iteration) for iteration in range(recipe.iterations)],
            what=f"{recipe.iterations} iterations",
            shorter="--iterations N trains for fewer, all schedules in proportion",
        )
        self.members = nn.ModuleList(members)
        self.configuration = members[0].configuration
        self.recipe = recipe
        for member in members[1:]:
            other = member.configuration
            differences = {name: getattr(other, name) for name in ("actions", "validate_on", "seed")}
            if replace(self.configuration, **differences) != other:
                raise ValueError(f"runs: {member.out} differs from {members[0].out} in more than actions and seed")
        self._captured: list[Captured] = []
        self._captured_phase: object = None

    def _members(self) -> list[TrainingRun]:
        return cast(list[TrainingRun], list(self.members))

    def _names(self) -> list[str]:
        """Return the folders of the runs, relative to that of the checkpoint."""
        return [str(member.out.relative_to(self.out)) for member in self._members()]

    def train_dataloader(self) -> Iterator[_Batches]:
        """Return the remaining batches."""
        for iteration in itertools.count(self.global_step):
            batches = [member.batch(iteration) for member in self._members()]
            yield [(torch.from_numpy(batch.poses), torch.from_numpy(batch.label)) for batch in batches]

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """Return the optimiser of the recipe, which treats every weight independently."""
        recipe = self.recipe
        parameters = [parameter for member in self._members() for parameter in member.model.parameters()]
        if recipe.optimizer == "adam":
            return torch.optim.Adam(parameters, lr=recipe.lr)
        if recipe.optimizer == "sgd":
            return torch.optim.SGD(parameters, lr=recipe.lr, momentum=recipe.momentum)
        return RMSpropTF(parameters, lr=recipe.lr, momentum=recipe.momentum)

    def training_step(self, batches: _Batches, _: int) -> Tensor:
        """Return the sum of the losses of an iteration."""
        captured = self.device.type == "cuda" and self.recipe.npss_weight == 0
        parts = self._replay(batches) if captured else self._run(batches)
        for member, losses in zip(self._members(), parts, strict=True):
            member.keep(losses)
        total = torch.stack([losses["loss"] for losses in parts]).sum()
        if self.trainer.progress_bar_callback is not None:
            self.log("loss", total / len(parts), prog_bar=True, logger=False)
        return total

    def _run(self, batches: _Batches) -> list[dict[str, Tensor]]:
        """Return the losses of an iteration, and their parts."""
        iteration, parts = self.global_step, []
        for member, batch in zip(self._members(), batches, strict=True):
            torch.manual_seed(member.seed(iteration))
            parts.append(member.loss(*batch, iteration))
        return parts

    def _replay(self, batches: _Batches) -> list[dict[str, Tensor]]:
        """Do the same as `_run`, by CUDA graphs."""
        iteration, members = self.global_step, self._members()
        phase = self.recipe.phase(iteration)
        if phase != self._captured_phase:
            self._captured = []  # free the old graphs first
            self._captured = [
                Captured(partial(member.loss, iteration=iteration), batch, list(member.model.parameters()))
                for member, batch in zip(members, batches, strict=True)
            ]
            self._captured_phase = phase
        for member, captured, batch in zip(members, self._captured, batches, strict=True):
            captured.launch(member.seed(iteration), batch)
        return [captured.result() for captured in self._captured]

    def configure_gradient_clipping(self, *_: Any, **__: Any) -> None:
        """Clip the gradient of each member by its own norm."""
        if self.recipe.clip_norm is not None:
            for member in self._members():
                nn.utils.clip_grad_norm_(member.model.parameters(), self.recipe.clip_norm)

    def on_before_optimizer_step(self, optimizer: torch.optim.Optimizer) -> None:
        """Set the learning rate of the iteration."""
        for group in optimizer.param_groups:
            group["lr"] = self.recipe.learning_rate(self.global_step)

    def on_train_batch_end(self, *_: Any) -> None:
        """Average, validate and save when due."""
        done, members = self.global_step, self._members()
        for member in members:
            if member.average is not None:
                member.average.update_parameters(member.model)
        validate = done % self.configuration.validate_every == 0 or done == self.recipe.iterations
        if validate:
            for member in members:
                prefix = "" if member.out == self.out else f"{member.out.relative_to(self.out)}/"
                self.log_row(member.validate(done), prefix)
        self.step_is_done(checkpoint=validate or done % self.configuration.checkpoint_every == 0)

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Add the runs, their rows and losses."""
        members = self._members()
        checkpoint["runs"] = self._names()
        checkpoint["motion"] = [member.motion for member in members]
        checkpoint["rows"] = [member.rows for member in members]
        checkpoint["losses"] = [member.kept() for member in members]

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Check the runs; restore their rows and losses."""
        names = checkpoint.get("runs", ["another version"])
        if names != self._names():
            raise ValueError(
                f"--resume: {self.out / CHECKPOINT} holds {', '.join(names)}, not {', '.join(self._names())}"
            )
        motions = checkpoint.get("motion", [None] * len(names))  # older checkpoints have none
        for member, motion in zip(self._members(), motions, strict=True):
            if motion not in (None, member.motion):
                raise ValueError(f"--resume: {member.out} was trained on other motion than this")
        for member, rows, losses in zip(self._members(), checkpoint["rows"], checkpoint["losses"], strict=True):
            member.rows = rows
            member.losses.update({name: list(values.unbind()) for name, values in losses.items()})


def train(
    configuration: Configuration,
    training_set: TrainingSet,
    validation_tasks: Sequence[Task],
    out: Path,
    *,
    device: str = "cpu",
    tensorboard: bool = False,
) -> list[Row]:
    """Train a model, from its checkpoint if the run has one.

    Parameters
    ----------
    configuration : Configuration
        The configuration of the run.
    training_set : TrainingSet
        The training set of its actions.
    validation_tasks : sequence of Task
        The validation tasks of its actions.
    out : Path
        The folder of the run, which exists.
    device : {'cpu', 'cuda'}, optional
        The device to train on.
    tensorboard : bool, optional
        Also write TensorBoard logs.

    Returns
    -------
    list of dict
        A row of numbers per validation.

    Raises
    ------
    ValueError
        If clips are too short, training diverges, or the checkpoint is broken.
    KeyboardInterrupt, Stopped
        As `npss_baselines.runs.fitting.fit`.
    """
    run = (configuration, training_set, validation_tasks, out)
    (rows,) = train_together([run], out, device=device, tensorboard=tensorboard)
    return rows


def train_together(
    runs: Sequence[tuple[Configuration, TrainingSet, Sequence[Task], Path]],
    out: Path,
    *,
    device: str = "cpu",
    tf32: bool = False,
    tensorboard: bool = False,
) -> list[list[Row]]:
    """Train several models at once, from their checkpoint if there is one.

    Parameters
    ----------
    runs : sequence of tuple
        The first four arguments of `train` for each run. The configurations differ only in actions and seeds.
    out : Path
        The folder of the checkpoint, which exists.
    device, tensorboard
        As for `train`.
    tf32 : bool, optional
        On a CUDA device, let matrix products round their factors to ten bits of mantissa.

    Returns
    -------
    list of list of dict
        For each run, a row of numbers per validation.

    Raises
    ------
    ValueError
        As `train`; or if configurations differ in other fields. One run that diverges ends all.
    """
    with _matmul_precision("high" if tf32 else "highest"):
        training = fit(
            lambda: Training([TrainingRun(*run) for run in runs], out), device=device, tensorboard=tensorboard
        )
    return [member.rows for member in training._members()]


@contextmanager
def _matmul_precision(precision: str) -> Iterator[None]:
    """Set the precision of float32 matrix products, including those in torch's LSTM."""
    before, in_lstm = torch.get_float32_matmul_precision(), torch.backends.cudnn.allow_tf32
    torch.set_float32_matmul_precision(precision)
    torch.backends.cudnn.allow_tf32 = precision == "high"
    try:
        yield
    finally:
        torch.set_float32_matmul_precision(before)
        torch.backends.cudnn.allow_tf32 = in_lstm
