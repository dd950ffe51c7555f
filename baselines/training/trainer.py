"""Training by Lightning such that runs that are cut off anywhere, and resumed, end as if they had not been."""

from __future__ import annotations

import itertools
import logging
import pickle
import sys
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, cast

import torch
from torch import Tensor, nn

from baselines.tasks import Task
from baselines.training._files import write_atomically
from baselines.training.captured import Captured
from baselines.training.config import CHECKPOINT, Configuration
from baselines.training.member import METRICS, Member
from baselines.training.recipe import Recipe
from baselines.training.rmsprop import RMSpropTF
from baselines.training.validation import Row
from baselines.training.windows import TrainingSet

try:
    from lightning.pytorch import LightningModule, Trainer
    from lightning.pytorch.loggers import TensorBoardLogger
    from lightning.pytorch.plugins import TorchCheckpointIO
except ImportError:
    raise ImportError("training needs lightning: pip install 'npss[baselines]'") from None

__all__ = ["CHECKPOINT", "METRICS", "AtomicIO", "Member", "train", "train_together"]

_Batches = Sequence[tuple[Tensor, Tensor]]  # one for each member


class Training(LightningModule):
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
        super().__init__()
        self.members = nn.ModuleList(members)
        self.configuration = members[0].configuration
        self.recipe: Recipe = self.configuration.recipe
        for member in members[1:]:
            one = member.configuration
            if replace(self.configuration, actions=one.actions, validate_on=one.validate_on, seed=one.seed) != one:
                raise ValueError(f"runs: {member.out} differs from {members[0].out} in more than actions and seed")
        self.out = out
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
        for member, of_member in zip(self._members(), parts, strict=True):
            member.keep(of_member)
        total = torch.stack([of_member["loss"] for of_member in parts]).sum()
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
                self._log(member, member.validate(done))
        if validate or done % self.configuration.checkpoint_every == 0:
            # Last, because it is what counts: all that came before would be done again, and be the same.
            self.trainer.save_checkpoint(self.out / CHECKPOINT)

    def _log(self, member: Member, row: Row) -> None:
        if self.logger is not None:
            prefix = "" if member.out == self.out else f"{member.out.relative_to(self.out)}/"
            self.logger.log_metrics({f"{prefix}{name}": value for name, value in row.items()}, step=self.global_step)

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Add what has been measured, and of whom."""
        members = self._members()
        checkpoint["runs"] = self._names()
        checkpoint["rows"] = [member.rows for member in members]
        checkpoint["losses"] = [member.kept() for member in members]

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Restore what had been measured."""
        names = checkpoint.get("runs", ["another version"])
        if names != self._names():
            raise ValueError(
                f"--resume: {self.out / CHECKPOINT} is of {', '.join(names)}, not of {', '.join(self._names())}"
            )
        for member, rows, losses in zip(self._members(), checkpoint["rows"], checkpoint["losses"], strict=True):
            member.rows = rows
            member.losses.update({name: list(values.unbind()) for name, values in losses.items()})


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
    checkpoint = out / CHECKPOINT
    logging.getLogger("lightning.pytorch").setLevel(logging.WARNING)  # no advertisements
    random = torch.random.fork_rng(devices=range(torch.cuda.device_count()))
    with random, _multiplying("high" if tf32 else "highest"), warnings.catch_warnings():
        # Lightning 2.6 itself uses what torch has deprecated since.
        warnings.filterwarnings("ignore", r".*LeafSpec", FutureWarning)
        warnings.filterwarnings("ignore", "GPU available but not used", UserWarning)  # as was asked
        training = Training([Member(*run) for run in runs], out)
        trainer = Trainer(
            accelerator=device,
            devices=1,
            max_epochs=-1,
            max_steps=training.recipe.iterations,
            plugins=[AtomicIO()],
            logger=TensorBoardLogger(out, name="", version="tensorboard") if tensorboard else False,
            enable_progress_bar=sys.stdout.isatty(),
            enable_checkpointing=False,
            enable_model_summary=False,
            default_root_dir=out,
        )
        trainer.fit(training, ckpt_path=checkpoint if checkpoint.exists() else None, weights_only=True)
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
