"""Models in training: one, or several at once, each as if it were alone."""

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
from npss_baselines.training.member import Member
from npss_baselines.training.rmsprop import RMSpropTF
from npss_baselines.training.validation import Row

_Batches = Sequence[tuple[Tensor, Tensor]]  # one for each member


class Training(Resumable):
    """Runs in training, each as if it were alone.

    The learning rate is a function of the iteration. What else an iteration depends on beside `Member`, the weights and
    the state of the optimiser, is in the checkpoint.

    On a CUDA device the members' losses and gradients are captured, and computed side by side. NPSS as a part of the
    loss cannot be captured: it looks at values.

    Parameters
    ----------
    members : sequence of Member
        The runs. Their recipes are the same, and so are the iterations at which they validate.
    out : Path
        The folder of the checkpoint.
    """

    def __init__(self, members: Sequence[Member], out: Path) -> None:
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
            own = {name: getattr(other, name) for name in ("actions", "validate_on", "seed")}
            if replace(self.configuration, **own) != other:
                raise ValueError(f"runs: {member.out} differs from {members[0].out} in more than actions and seed")
        self._captured: list[Captured] = []
        self._captured_at: object = None

    def _members(self) -> list[Member]:
        return cast(list[Member], list(self.members))

    def _names(self) -> list[str]:
        """Return the folders of the runs, seen from that of the checkpoint."""
        return [str(member.out.relative_to(self.out)) for member in self._members()]

    def train_dataloader(self) -> Iterator[_Batches]:
        """Return the batches that are left."""
        for iteration in itertools.count(self.global_step):
            batches = [member.batch(iteration) for member in self._members()]
            yield [(torch.from_numpy(batch.poses), torch.from_numpy(batch.label)) for batch in batches]

    def configure_optimizers(self) -> torch.optim.Optimizer:
        """Return the optimiser of the recipe: what it does to a weight depends on that weight alone."""
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
        """Do what `_run` does, by graphs."""
        iteration, members = self.global_step, self._members()
        at = self.recipe.phase(iteration)
        if at != self._captured_at:
            self._captured = []  # frees the old ones first
            self._captured = [
                Captured(partial(member.loss, iteration=iteration), batch, list(member.model.parameters()))
                for member, batch in zip(members, batches, strict=True)
            ]
            self._captured_at = at
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
        """Average, validate and save, each in its turn."""
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
        """Add what has been measured, and of whom."""
        members = self._members()
        checkpoint["runs"] = self._names()
        checkpoint["motion"] = [member.motion for member in members]
        checkpoint["rows"] = [member.rows for member in members]
        checkpoint["losses"] = [member.kept() for member in members]

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Restore what had been measured."""
        names = checkpoint.get("runs", ["another version"])
        if names != self._names():
            raise ValueError(
                f"--resume: {self.out / CHECKPOINT} is of {', '.join(names)}, not of {', '.join(self._names())}"
            )
        motions = checkpoint.get("motion", [None] * len(names))  # older ones do not say
        for member, motion in zip(self._members(), motions, strict=True):
            if motion not in (None, member.motion):
                raise ValueError(f"--resume: {member.out} was trained on other motion than there is now")
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
    """Train several models at once, from the checkpoint on if there is one.

    Parameters
    ----------
    runs : sequence of tuple
        The first four arguments of `train`, for each run. Their configurations differ in actions and seeds only.
    out : Path
        The folder of the checkpoint; it is there.
    device, tensorboard
        As for `train`.
    tf32 : bool, optional
        On a CUDA device, let matrix products round what they multiply to ten bits of mantissa.

    Returns
    -------
    list of list of dict
        For each run, what was measured at each validation.

    Raises
    ------
    ValueError
        As `train`; or if configurations differ in more than that. One that diverges ends all.
    """
    with _multiplying("high" if tf32 else "highest"):
        training = fit(lambda: Training([Member(*run) for run in runs], out), device=device, tensorboard=tensorboard)
    return [member.rows for member in training._members()]


@contextmanager
def _multiplying(precision: str) -> Iterator[None]:
    """Set how exact matrix products of float32 are, those in torch's LSTM among them."""
    before, in_lstm = torch.get_float32_matmul_precision(), torch.backends.cudnn.allow_tf32
    torch.set_float32_matmul_precision(precision)
    torch.backends.cudnn.allow_tf32 = precision == "high"
    try:
        yield
    finally:
        torch.set_float32_matmul_precision(before)
        torch.backends.cudnn.allow_tf32 = in_lstm
