"""Training by Lightning: an interrupted and resumed run ends like an uninterrupted one."""

from __future__ import annotations

import logging
import signal
import sys
import time
import warnings
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, TypeVar, cast

import numpy as np
import torch

from npss.console import Progress, duration
from npss.extras import install_hint
from npss_baselines.runs.checkpoint import AtomicIO
from npss_baselines.runs.config import CHECKPOINT
from npss_baselines.runs.pace import Pace
from npss_baselines.runs.stopping import Stop, Stopped

try:
    from lightning.fabric.plugins.environments.lightning import LightningEnvironment
    from lightning.pytorch import LightningModule, Trainer
    from lightning.pytorch.callbacks import Callback, TQDMProgressBar
    from lightning.pytorch.loggers import TensorBoardLogger
    from lightning.pytorch.utilities.exceptions import SIGTERMException
except ImportError:
    raise ImportError(f"training needs lightning; {install_hint('all', baselines=True)}") from None

Module = TypeVar("Module", bound="Resumable")

_FIRST, _LATER = 30.0, 300.0  # most seconds until a process's first checkpoint, and between checkpoints
_MEASURED = 1.0  # seconds of steps to time before estimating the remaining time
_SLOW = 10.0  # seconds of a first step that says enough: preparing things takes a small part of it
_LONG = 10.0  # shortest remaining time, in seconds, that is printed


class Resumable(LightningModule):
    """A module in training whose step i always computes the same.

    Parameters
    ----------
    out : Path
        The folder of the checkpoint, which exists.
    work : sequence of float
        The amount of computation in each step, in any unit.
    what : str
        All steps in words: ``'10000 iterations'``.
    shorter : str
        A hint on how to train for less.
    """

    def __init__(self, out: Path, work: Sequence[float], *, what: str, shorter: str) -> None:
        super().__init__()
        self.out = out
        self.n_steps = len(work)
        self.stop = Stop()
        self._progress: Progress | None = None
        self._work = np.asarray(work, dtype=np.float64)
        self._share = np.cumsum(work) / np.sum(work)  # done after each step
        self._what, self._shorter = what, shorter

    def on_train_start(self) -> None:
        """Start the clock, and say where a run goes on."""
        self._resumed = self.global_step > 0
        self._done_before = self._done()
        if self._resumed:
            self._say(f"resuming at {self._done_before:.0%} of {self._what}")
        self._began: tuple[float, float] | None = None  # time and share done at the end of the first step
        self._estimated = False
        self._pace = Pace()
        self._saved = self._started = time.monotonic()
        self._patience = _FIRST

    def step_is_done(self, *, checkpoint: bool) -> None:
        """Save a checkpoint if requested or due, and show progress. Call it after each step."""
        due = time.monotonic() - self._saved >= self._patience
        if checkpoint or due or self.stop.received is not None:
            # Last: a run that is interrupted before this repeats the step, with the same result.
            self.trainer.save_checkpoint(self.out / CHECKPOINT)
            self._saved, self._patience = time.monotonic(), _LATER
        self.stop.check()
        self._estimate()
        if self._progress is not None:
            self._progress(self._done())

    def step_took(self, seconds: float) -> None:
        """Compare the duration of a step with those of the first ones; on a GPU, a step ends later."""
        if self.device.type == "cpu":
            slower = self._pace(seconds, float(self._work[self.global_step - 1]))
            if slower is not None:
                self._say(_advice(slower))

    def log_row(self, row: Mapping[str, Any], prefix: str = "") -> None:
        """Log the numbers of a row for TensorBoard, if enabled; `prefix` precedes their names."""
        if self.logger is not None:
            numbers = {f"{prefix}{name}": value for name, value in row.items() if not isinstance(value, str)}
            self.logger.log_metrics(numbers, step=self.global_step)

    def close(self) -> None:
        """Clear the progress line."""
        if self._progress is not None:
            self._progress.__exit__(None, None, None)

    def _done(self) -> float:
        """Return the share that is done."""
        return float(self._share[self.global_step - 1]) if self.global_step else 0.0

    def _say(self, line: str) -> None:
        """Print a line on standard error, or above the progress bar."""
        if self._progress is None:
            self.print(line)
        else:
            print(line, file=sys.stderr, flush=True)

    def _estimate(self) -> None:
        """Print the remaining time once; do not time a short first step, which also prepares things."""
        if self._estimated:
            return
        if self._began is not None and time.monotonic() - self._began[0] < _MEASURED:
            return
        if self.device.type == "cuda":
            torch.cuda.synchronize(self.device)
        now, done = time.monotonic(), self._done()
        began = self._began
        if began is None:
            self._began = now, done
            if self.trainer.progress_bar_callback is None:
                self._progress = Progress("training", done=done)
            if self.device.type == "cuda" or now - self._started < _SLOW:
                return
            began = self._started, self._done_before
        self._estimated = True
        remaining = (now - began[0]) * (1 - done) / (done - began[1])
        if remaining < _LONG:
            return
        line = f"about {duration(remaining)} {'left of' if self._resumed else 'for'} {self._what}"
        if self.device.type == "cpu":
            line += f" on {_threads()}"
        if not self._resumed:
            line += f"; {self._shorter}"
        self._say(line)


class _Steps(Callback):
    """Times the steps of a `Resumable`, without the validation and the checkpoint after them."""

    def on_train_batch_start(self, *_: Any) -> None:
        self._began = time.monotonic()

    def on_train_batch_end(self, trainer: Trainer, module: LightningModule, *_: Any) -> None:
        cast(Resumable, module).step_took(time.monotonic() - self._began)  # before the module's own method


def _threads() -> str:
    """Return the number of threads in words."""
    n = torch.get_num_threads()
    return "1 thread" if n == 1 else f"{n} threads"


def _advice(slower: float) -> str:
    """Return what to do where training has become slower."""
    line = f"training is {slower:.0f} times slower than at first: other programs may be using the processor"
    if torch.get_num_threads() == 1:
        return f"{line}; training can be stopped, and resumed later"
    return f"{line}; beside them, one thread is faster: stop training, and resume it with --threads 1"


def torch_seed(seed: int, *step: int) -> int:
    """Return the seed of torch's generators in a step of a run; numpy's generator there has a different one."""
    entropy = np.random.SeedSequence([seed, *step, 1])  # without the 1, it would be numpy's
    return int(entropy.generate_state(1, np.uint64)[0])


def fit(make: Callable[[], Module], *, device: str = "cpu", tensorboard: bool = False) -> Module:
    """Train a module, from its checkpoint if it has one.

    Train in one process on one device, even inside a job of several.

    Parameters
    ----------
    make : callable
        Returns the module.
    device : {'cpu', 'cuda'}, optional
        The device to train on.
    tensorboard : bool, optional
        Also write TensorBoard logs.

    Returns
    -------
    Resumable
        The trained module.

    Raises
    ------
    ValueError
        If the checkpoint is broken.
    KeyboardInterrupt, Stopped
        If a signal ended training: after the current step and its checkpoint.
    """
    logging.getLogger("lightning.pytorch").setLevel(logging.WARNING)  # no advertisements
    single_process = LightningEnvironment()  # else Lightning detects SLURM, torchrun and others
    single_process.set_global_rank(0)
    with torch.random.fork_rng(devices=range(torch.cuda.device_count())), warnings.catch_warnings(), Stop() as stop:
        # Lightning 2.6 uses functions that torch has deprecated since.
        warnings.filterwarnings("ignore", r".*LeafSpec", FutureWarning)
        warnings.filterwarnings("ignore", "GPU available but not used", UserWarning)  # as requested
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
            plugins=[AtomicIO(), single_process],
            logger=TensorBoardLogger(module.out, name="", version="tensorboard") if tensorboard else False,
            enable_progress_bar=terminal,
            callbacks=[_Steps(), *([TQDMProgressBar()] if terminal else [])],  # the same bar with or without rich
            enable_checkpointing=False,
            enable_model_summary=False,
            default_root_dir=module.out,
        )
        try:
            trainer.fit(module, ckpt_path=checkpoint if checkpoint.exists() else None, weights_only=True)
            stop.check()
        except SIGTERMException:  # Lightning caught the signal first and would exit with status 0
            raise Stopped(signal.SIGTERM) from None
        except Stopped as stopped:
            if stopped.signal is signal.SIGINT:
                raise KeyboardInterrupt from None
            raise
        finally:
            module.close()
    return module
