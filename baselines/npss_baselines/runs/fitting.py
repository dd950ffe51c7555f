"""Training by Lightning such that a run that is cut off anywhere, and resumed, ends as if it had not been."""

from __future__ import annotations

import logging
import signal
import sys
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import torch

from npss.console import Progress, duration
from npss.extras import install_hint
from npss_baselines.runs.checkpoint import AtomicIO
from npss_baselines.runs.config import CHECKPOINT
from npss_baselines.runs.stopping import Stop, Stopped

try:
    from lightning.fabric.plugins.environments.lightning import LightningEnvironment
    from lightning.pytorch import LightningModule, Trainer
    from lightning.pytorch.callbacks import TQDMProgressBar
    from lightning.pytorch.loggers import TensorBoardLogger
    from lightning.pytorch.utilities.exceptions import SIGTERMException
except ImportError:
    raise ImportError(f"training needs lightning; {install_hint('all', baselines=True)}") from None

Module = TypeVar("Module", bound="Resumable")

_FIRST, _LATER = 30.0, 300.0  # seconds, at most, to a process' first checkpoint, and between two
_MEASURED = 1.0  # seconds of steps from which it is told how long all of them take
_LONG = 10.0  # seconds from which on that is worth telling


class Resumable(LightningModule):
    """A module in training, of which step i does the same whenever it is done.

    Parameters
    ----------
    out : Path
        The folder of the checkpoint; it is there.
    work : sequence of float
        How much there is to compute in each step, in any unit.
    what : str
        What all steps are, in words: ``'10000 iterations'``.
    shorter : str
        How to train for less.
    """

    def __init__(self, out: Path, work: Sequence[float], *, what: str, shorter: str) -> None:
        super().__init__()
        self.out = out
        self.n_steps = len(work)
        self.stop = Stop()
        self._progress: Progress | None = None
        self._share = np.cumsum(work) / np.sum(work)  # that is done, after each step
        self._what, self._shorter = what, shorter

    def on_train_start(self) -> None:
        """Begin to measure time."""
        self._resumed = self.global_step > 0
        self._began: tuple[float, float] | None = None  # when the first step was over, and what share was done
        self._told = False
        self._saved = time.monotonic()
        self._patience = _FIRST

    def step_is_done(self, *, checkpoint: bool) -> None:
        """Save a checkpoint, if one is asked for or due, and say how far training is. To be called after each step."""
        due = time.monotonic() - self._saved >= self._patience
        if checkpoint or due or self.stop.asked is not None:
            # Last, because it is what counts: all that came before would be done again, and be the same.
            self.trainer.save_checkpoint(self.out / CHECKPOINT)
            self._saved, self._patience = time.monotonic(), _LATER
        self.stop.check()
        self._tell_how_long()
        if self._progress is not None:
            self._progress(self._done())

    def log_row(self, row: Mapping[str, Any], prefix: str = "") -> None:
        """Log the numbers of a row for TensorBoard, if that is wanted; `prefix` stands before their names."""
        if self.logger is not None:
            numbers = {f"{prefix}{name}": value for name, value in row.items() if not isinstance(value, str)}
            self.logger.log_metrics(numbers, step=self.global_step)

    def close(self) -> None:
        """Clear what says how far training is."""
        if self._progress is not None:
            self._progress.__exit__(None, None, None)

    def _done(self) -> float:
        """Return the share that is done."""
        return float(self._share[self.global_step - 1]) if self.global_step else 0.0

    def _tell_how_long(self) -> None:
        """Say how long it takes, once that can be told from the first steps; the very first one prepares things."""
        if self._told:
            return
        if self._began is not None and time.monotonic() - self._began[0] < _MEASURED:
            return
        if self.device.type == "cuda":
            torch.cuda.synchronize(self.device)
        now, done = time.monotonic(), self._done()
        if self._began is None:
            self._began = now, done
            if self.trainer.progress_bar_callback is None:
                self._progress = Progress("training", done=done)
            return
        self._told = True
        left = (now - self._began[0]) * (1 - done) / (done - self._began[1])
        if left < _LONG:
            return
        line = f"about {duration(left)} {'left of' if self._resumed else 'for'} {self._what}"
        if not self._resumed:
            line += f"; {self._shorter}"
        if self._progress is None:
            self.print(line)  # above the bar
        else:
            print(line, file=sys.stderr, flush=True)


def torch_seed(seed: int, *step: int) -> int:
    """Return by what torch's generators are seeded in a step of a run: none is that of numpy's generator there."""
    entropy = np.random.SeedSequence([seed, *step, 1])  # without the 1, that of numpy's
    return int(entropy.generate_state(1, np.uint64)[0])


def fit(make: Callable[[], Module], *, device: str = "cpu", tensorboard: bool = False) -> Module:
    """Train a module, from its checkpoint on if there is one.

    One process trains, on one device, even if the environment is that of a job of several.

    Parameters
    ----------
    make : callable
        Makes the module.
    device : {'cpu', 'cuda'}, optional
        What it is computed on.
    tensorboard : bool, optional
        Write logs for TensorBoard, too.

    Returns
    -------
    Resumable
        The module, trained.

    Raises
    ------
    ValueError
        If the checkpoint is broken.
    KeyboardInterrupt, Stopped
        If a signal has ended training, after the step in which it came and its checkpoint.
    """
    logging.getLogger("lightning.pytorch").setLevel(logging.WARNING)  # no advertisements
    alone = LightningEnvironment()  # else Lightning looks for that of SLURM, torchrun and others
    alone.set_global_rank(0)
    with torch.random.fork_rng(devices=range(torch.cuda.device_count())), warnings.catch_warnings(), Stop() as stop:
        # Lightning 2.6 itself uses what torch has deprecated since.
        warnings.filterwarnings("ignore", r".*LeafSpec", FutureWarning)
        warnings.filterwarnings("ignore", "GPU available but not used", UserWarning)  # as was asked
        module = make()
        module.stop = stop
        checkpoint = module.out / CHECKPOINT
        terminal = sys.stdout.isatty()
        trainer = Trainer(
            accelerator=device,
            devices=1,
            num_nodes=1,
            max_epochs=-1,
            max_steps=module.n_steps,
            plugins=[AtomicIO(), alone],
            logger=TensorBoardLogger(module.out, name="", version="tensorboard") if tensorboard else False,
            enable_progress_bar=terminal,
            callbacks=[TQDMProgressBar()] if terminal else [],  # the same whether or not rich is installed
            enable_checkpointing=False,
            enable_model_summary=False,
            default_root_dir=module.out,
        )
        try:
            trainer.fit(module, ckpt_path=checkpoint if checkpoint.exists() else None, weights_only=True)
            stop.check()
        except SIGTERMException:  # Lightning has seen the signal first, which would be exit status 0
            raise Stopped(signal.SIGTERM) from None
        except Stopped as stopped:
            if stopped.signal is signal.SIGINT:
                raise KeyboardInterrupt from None
            raise
        finally:
            module.close()
    return module
