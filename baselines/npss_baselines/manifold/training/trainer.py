"""Train the manifold. An interrupted and resumed run gives the same result as an uninterrupted one."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor

from npss_baselines.data.motion import JOINTS
from npss_baselines.manifold.applications import corrupt
from npss_baselines.manifold.model.autoencoder import Autoencoder, TiedLayer
from npss_baselines.manifold.model.initialization import initialize
from npss_baselines.manifold.model.per_window_sgd import PerWindowSGD
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.features import local_positions
from npss_baselines.manifold.motion.measures import joint_error
from npss_baselines.manifold.motion.scaling import fit_scaling
from npss_baselines.manifold.training import folder
from npss_baselines.manifold.training.config import Configuration, Phase
from npss_baselines.manifold.training.loss import loss_of
from npss_baselines.manifold.training.schedule import Place, Schedule
from npss_baselines.runs import log
from npss_baselines.runs.fitting import Resumable, fit, torch_seed

#: The results of an epoch: numbers by name, and the name of the phase.
Row = dict[str, Any]

#: Largest number of chunks between checkpoints.
CHECKPOINT_EVERY = 20
_AT_ONCE = 64  # windows, where no gradient is needed


class Training(Resumable):
    """The Lightning module that trains the manifold; the work on a chunk of batches is reproducible.

    Parameters
    ----------
    configuration : Configuration
        The configuration of the run.
    training_set, validation_set : MotionSet
        Motion to train on, and to choose weights by.
    out : Path
        The folder of the run.
    """

    def __init__(
        self, configuration: Configuration, training_set: MotionSet, validation_set: MotionSet, out: Path
    ) -> None:
        phases = configuration.phases
        schedule = Schedule(phases, len(training_set.windows))
        super().__init__(
            out,
            [configuration.work(schedule[step].phase) for step in range(len(schedule))],
            what=f"{sum(phase.stage.epochs for phase in phases)} epochs",
            shorter="--layers.epochs N and --whole.epochs N train for fewer"
            + ("" if configuration.quick else ", --quick also on a small part of the data"),
        )
        self.automatic_optimization = False
        self.configuration = configuration
        self.phases = phases
        self.schedule = schedule
        self.validation_set = validation_set
        self.scaling = fit_scaling(training_set.windows, training_set.mask, configuration.scale, configuration.size)
        self.windows, self.validation_windows = (
            torch.from_numpy(self.scaling.normalize(motion.windows).astype(np.float32))
            for motion in (training_set, validation_set)
        )
        self.mask = torch.from_numpy(training_set.mask)
        torch.manual_seed(configuration.seed)
        self.network = Autoencoder(configuration.model)
        initialize(self.network, configuration.start)
        #: The results of each epoch.
        self.rows: list[Row] = []
        self.losses: list[tuple[float, int]] = []  # since the last row: average of a chunk, number of its windows
        self._phase = -1  # prepared by `_begin`
        self._seen = self._of_frames = self._of_steps = torch.empty(0)
        self._sgd: PerWindowSGD | None = None

    def train_dataloader(self) -> Iterator[Tensor]:
        """Yield the window indices of the remaining chunks."""
        for step in range(self.global_step, len(self.schedule)):
            place = self.schedule[step]
            rng = np.random.default_rng([self.configuration.seed, place.phase, place.epoch])
            windows = self.schedule.chunk[place.phase] * self.phases[place.phase].stage.batch
            order = rng.permutation(len(self.windows))[place.chunk * windows :][:windows]
            yield torch.from_numpy(order)

    def configure_optimizers(self) -> list[torch.optim.Optimizer]:
        """Return an optimiser for each phase."""
        kinds = {"adam": torch.optim.Adam, "sgd": torch.optim.SGD}
        return [kinds[phase.stage.optimizer](self._in_training(phase), lr=phase.stage.lr) for phase in self.phases]

    def training_step(self, chunk: Tensor, _: int) -> None:
        """Train on a chunk."""
        place = self.schedule[self.global_step]
        phase = self.phases[place.phase]
        if place.phase != self._phase:
            self._begin(place.phase)
        number = place.epoch * self.schedule.chunks[place.phase] + place.chunk
        torch.manual_seed(torch_seed(self.configuration.seed, place.phase, number))
        optimizers = self.optimizers()
        counted = optimizers[place.phase] if isinstance(optimizers, list) else optimizers
        optimizer = counted.optimizer
        total = torch.zeros((), device=self.device)
        for i, batch in enumerate(torch.split(chunk, phase.stage.batch)):
            share = (place.chunk * self.schedule.chunk[place.phase] + i) / self.schedule.batches[place.phase]
            lr = phase.stage.learning_rate(place.epoch, share)
            total += len(batch) * self._step(phase, batch, optimizer, lr)
        if self._sgd is not None:
            self._sgd.keep()
        optimizer.zero_grad()
        counted.step()  # only counts the chunk: there is no gradient
        loss = total.item() / len(chunk)
        if not math.isfinite(loss):
            raise _diverged(phase, place, f"the loss was {loss}")
        self.losses.append((loss, len(chunk)))
        if self.trainer.progress_bar_callback is not None:
            self.log("loss", loss, prog_bar=True, logger=False)

    def _step(self, phase: Phase, batch: Tensor, optimizer: torch.optim.Optimizer, lr: float) -> Tensor:
        """Train on a batch and return its loss."""
        if self._sgd is not None:
            i = int(batch)
            return self._sgd.step(self._seen[i], self._of_frames[i], self._of_steps[i], lr)
        stage = phase.stage
        parameters = self._in_training(phase)
        layers = self.network.first(phase.depth)[phase.first :]
        loss = loss_of(
            layers,
            self._seen[batch],
            self._of_frames[batch],
            self._of_steps[batch],
            corruption=stage.corruption,
            sparsity=stage.sparsity,
            random=stage.unpool == "random",
            rescale=stage.rescale,
            corrupted=self._corrupted(batch, layers) if stage.structured else None,
        )
        optimizer.zero_grad()
        self.manual_backward(loss)
        if stage.clip_norm is not None:
            torch.nn.utils.clip_grad_norm_(parameters, stage.clip_norm)
        for group in optimizer.param_groups:
            group["lr"] = lr
        optimizer.step()
        return loss.detach()

    def _corrupted(self, batch: Tensor, layers: Sequence[TiedLayer]) -> Tensor:
        """Corrupt windows as applications do; some are projected, up to twice, and get their known values back.

        So the layers see what they meet when projection and known values take turns.
        """
        windows = self.scaling.unnormalize(self.windows[batch.cpu()].numpy())
        seed = np.random.default_rng(int(torch.randint(2**31, ())))
        left = corrupt.structured(windows, self.scaling.mean, JOINTS, seed=seed)
        values = torch.from_numpy(self.scaling.normalize(left.features)).to(self._seen)
        known = torch.from_numpy(left.known).to(values.device)
        given = values
        with torch.no_grad():
            for _ in range(int(torch.randint(3, ()))):
                for layer in layers:
                    values = layer(values)
                for layer in reversed(layers):
                    values = layer.inverse(values)
                values = torch.where(known, given, values)
        return values

    def _begin(self, number: int) -> None:
        """Begin a phase: encode all windows by the layers below those in training, and weight their frames."""
        phase = self.phases[number]
        stage, layers = phase.stage, self.network.first(phase.depth)[phase.first :]
        parts = torch.split(self.windows.to(self.device), _AT_ONCE)
        with torch.no_grad():
            self._seen = torch.cat([self.network.encode(part, phase.first).contiguous() for part in parts])
        pool = self.configuration.model.pool
        mean = self.configuration.loss == "mean"
        self._of_frames = _weights(self.mask, pool**phase.first, self._seen.shape[2], mean=mean).to(self.device)
        self._of_steps = _weights(self.mask, pool**phase.depth, layers[-1].bias.numel(), mean=mean).to(self.device)
        self._sgd = None
        plain = stage.optimizer == "sgd" and stage.clip_norm is None and not stage.rescale
        if stage.batch == 1 and plain and pool == 2:
            self._sgd = PerWindowSGD(
                layers,
                self._seen.shape[1],
                corruption=stage.corruption,
                sparsity=stage.sparsity,
                random=stage.unpool == "random",
            )
        self._phase = number

    def _in_training(self, phase: Phase) -> list[torch.nn.Parameter]:
        return [
            parameter for layer in self.network.first(phase.depth)[phase.first :] for parameter in layer.parameters()
        ]

    def on_train_batch_end(self, *_: Any) -> None:
        """Measure at the end of an epoch, and save checkpoints."""
        done = self.schedule[self.global_step - 1]
        epoch_ends = done.chunk + 1 == self.schedule.chunks[done.phase]
        if epoch_ends:
            self._measure(done)
        self.step_is_done(checkpoint=epoch_ends or self.global_step % CHECKPOINT_EVERY == 0)

    def on_save_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Add the results so far."""
        checkpoint["rows"] = self.rows
        checkpoint["losses"] = self.losses

    def on_load_checkpoint(self, checkpoint: dict[str, Any]) -> None:
        """Restore the results so far."""
        self.rows = checkpoint["rows"]
        self.losses = checkpoint["losses"]

    def _measure(self, done: Place) -> None:
        """Measure the trained layers, save the network if it is the best so far, and log the results."""
        phase = self.phases[done.phase]
        try:
            error = self._error(phase.depth)
        except ValueError as problem:  # the last step can diverge without any later loss to show it
            raise _diverged(phase, done, f"reconstructed windows: {problem}") from problem
        n = sum(windows for _, windows in self.losses)
        row: Row = {
            "phase": phase.name,
            "epoch": done.epoch + 1,
            "lr": phase.stage.learning_rate(done.epoch),
            "loss": math.fsum(loss * windows for loss, windows in self.losses) / n,
            "error": error,
        }
        self.losses = []
        self.rows.append(row)
        if done.phase == len(self.phases) - 1 and row is best(self.rows, self.configuration.select):
            folder.save(self.out, self.network, self.scaling, row)
        log.write(self.out, self.rows)
        self.log_row(row)

    def _error(self, depth: int) -> float:
        """Return the joint error of the first `depth` layers on the validation windows, in body heights."""
        with torch.no_grad():
            parts = torch.split(self.validation_windows.to(self.device), _AT_ONCE)
            scaled = np.concatenate([self.network.project(part, depth).cpu().numpy() for part in parts])
        motion = self.validation_set
        projected = local_positions(self.scaling.unnormalize(scaled))
        return joint_error(local_positions(motion.windows), projected, motion.mask)


def _diverged(phase: Phase, place: Place, sign: str) -> ValueError:
    option = "whole" if phase.name == "whole" else "layers"
    return ValueError(
        f"training has diverged: {sign} in epoch {place.epoch + 1} of {phase.name}; try a lower --{option}.lr"
    )


def best(rows: Sequence[Row], select: str) -> Row:
    """Return the row of the weights to keep: the first with the smallest error in the last phase, or the last."""
    last = [row for row in rows if row["phase"] == rows[-1]["phase"]]
    return last[-1] if select == "last" else min(last, key=lambda row: float(row["error"]))


def _weights(mask: Tensor, pooled: int, width: int, *, mean: bool) -> Tensor:
    """Return the weights of the frames of windows, (n, T / pooled, 1).

    A pooled frame counts if any of its frames does.
    """
    weights = mask.view(len(mask), -1, pooled).any(2).float()
    if mean:
        weights /= weights.sum(1, keepdim=True) * width
    return weights.unsqueeze(2)


def train(
    configuration: Configuration,
    training_set: MotionSet,
    validation_set: MotionSet,
    out: Path,
    *,
    device: str = "cpu",
    tensorboard: bool = False,
) -> list[Row]:
    """Train the manifold, or resume from the checkpoint if the run has one.

    Parameters
    ----------
    configuration : Configuration
        The configuration of the run.
    training_set, validation_set : MotionSet
        Motion to train on, and to choose weights by, of different subjects.
    out : Path
        The folder of the run, which exists.
    device : {'cpu', 'cuda'}, optional
        The device to train on.
    tensorboard : bool, optional
        Whether to write TensorBoard logs, too.

    Returns
    -------
    list of dict
        The results of each epoch: ``phase``, ``epoch`` from 1 on, ``lr``, the average ``loss``, and ``error``, the
        joint error on the validation set, in body heights.

    Raises
    ------
    ValueError
        If the data do not match the network, training diverges, or the checkpoint is broken.
    KeyboardInterrupt, Stopped
        As `npss_baselines.runs.fitting.fit`.
    """
    n_frames, n_features = training_set.windows.shape[1:]
    if n_features != configuration.model.n_features:
        raise ValueError(f"model.n_features: {configuration.model.n_features}, but the motion has {n_features}")
    if n_frames % configuration.model.stride:
        raise ValueError(f"model: {n_frames} frames are not a multiple of {configuration.model.stride} per step")
    return fit(
        lambda: Training(configuration, training_set, validation_set, out), device=device, tensorboard=tensorboard
    ).rows
