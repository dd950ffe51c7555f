"""What the training commands share: the device, threads, exclusive folders, and hints on how to resume."""

from __future__ import annotations

import argparse
import os
import shlex
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from pathlib import Path

import torch
from filelock import FileLock, Timeout

from npss.files import doing
from npss.plugins import with_plugins
from npss.validation import positive_integer
from npss_baselines.runs.config import CHECKPOINT, FILE, recorded_threads
from npss_baselines.runs.stopping import Stopped

#: The file in the folder of a run that the training process locks.
LOCK = ".lock"
_PROGRAM = "npss-baselines"


def add_device(parser: argparse.ArgumentParser) -> None:
    """Add the option that `device_of` reads."""
    parser.add_argument(
        "--device",
        choices=("auto", "cpu", "cuda"),
        default="auto",
        help="train on this device; auto: cuda if available, else cpu (default: %(default)s)",
    )


def device_of(requested: str, *, tf32: bool = False) -> str:
    """Return the device, ``'cpu'`` or ``'cuda'``, for a value of ``--device``.

    Raises
    ------
    ValueError
        If it is unavailable.
    """
    available = torch.cuda.is_available()
    if requested == "cuda" and not available:
        reason = "this torch is built without CUDA" if torch.version.cuda is None else "torch finds no GPU"
        raise ValueError(f"--device cuda: {reason}; --device cpu trains without a GPU")
    device = ("cuda" if available else "cpu") if requested == "auto" else requested
    if tf32 and device != "cuda":
        raise ValueError("--tf32: needs a CUDA device")
    return device


def add_threads(parser: argparse.ArgumentParser) -> None:
    """Add the option that `threads_of` reads."""
    parser.add_argument(
        "--threads",
        type=int,
        metavar="N",
        help="use N threads on the CPU; more than one is faster only while no other program uses these cores "
        "(default: that of the run to resume, else the environment variable OMP_NUM_THREADS, else 1)",
    )


def threads_of(requested: int | None, runs: Sequence[Path]) -> int:
    """Return the number of threads, for a value of ``--threads``.

    Parameters
    ----------
    requested : int or None
        The value.
    runs : sequence of Path
        The folders of the runs to resume. With their number of threads, they end as if uninterrupted.

    Raises
    ------
    ValueError
        If it is not positive, or a run's configuration is invalid.
    """
    if requested is not None:
        return positive_integer("--threads", requested)
    for run in runs:
        if (recorded := recorded_threads(run / FILE)) is not None:
            return recorded
    return torch.get_num_threads() if "OMP_NUM_THREADS" in os.environ else 1


@contextmanager
def use_threads(n: int) -> Iterator[None]:
    """Let torch use this number of threads."""
    before = torch.get_num_threads()
    torch.set_num_threads(n)
    try:
        yield
    finally:
        torch.set_num_threads(before)


def existing_runs(folders: Sequence[Path]) -> list[Path]:
    """Return the folders that hold a run."""
    return [folder for folder in folders if (folder / FILE).exists()]


@contextmanager
def exclusive_folders(out: Path, folders: Sequence[Path], before: Sequence[Path]) -> Iterator[None]:
    """Create the folders of runs, and lock them against other processes.

    After an error, except a system error or a signal, new runs without a checkpoint leave nothing behind.

    Parameters
    ----------
    out : Path
        The folder of the checkpoint.
    folders : sequence of Path
        The folders of the runs: `out`, or folders in it.
    before : sequence of Path
        The result of `existing_runs` when the command started.

    Raises
    ------
    ValueError
        If another process trains there, or has started a run since.
    """
    locked = list(dict.fromkeys([out, *folders]))
    new = [path for folder in locked for path in (folder, *folder.parents) if not path.exists()]
    new = sorted(dict.fromkeys(new), reverse=True)  # inner folders first
    with ExitStack() as locks:
        for folder in locked:
            with doing("creating the folder of the run"):
                folder.mkdir(parents=True, exist_ok=True)
            try:
                locks.enter_context(FileLock(folder / LOCK, timeout=0))
            except Timeout:
                raise ValueError(f"--out: another process is training in {folder}") from None
        if existing_runs(folders) != list(before):
            raise ValueError(f"--out: another process has trained in {out} meanwhile; --resume continues its run")
        for folder in locked:
            for part in folder.glob(".*.part"):  # left by a process that was killed while writing
                part.unlink()
        try:
            yield
        except BaseException as error:
            resumable = isinstance(error, OSError | KeyboardInterrupt | Stopped) and existing_runs(folders)
            if not before and not resumable and not (out / CHECKPOINT).exists():
                for folder in folders:
                    (folder / FILE).unlink(missing_ok=True)
                for folder in locked:
                    (folder / LOCK).unlink(missing_ok=True)
                for folder in new:
                    with suppress(OSError):  # holds other files
                        folder.rmdir()
            raise


@contextmanager
def explain_missing_data(option: str, root: Path | None, recorded_in: Path | None) -> Iterator[None]:
    """Add to the error of a missing data folder that a run recorded it, and which option replaces it."""
    try:
        yield
    except FileNotFoundError as error:
        if recorded_in is None or root is None or root.exists():
            raise
        raise FileNotFoundError(
            f"{root}: no such folder; {recorded_in} records it as the folder of the data; --{option} DIR replaces it"
        ) from error


@contextmanager
def explain_resuming(folders: Sequence[Path], arguments: Sequence[str]) -> Iterator[None]:
    """Print how to resume when a signal or a full disk stops training; exit with 128 plus the signal's number.

    Parameters
    ----------
    folders : sequence of Path
        The folders of the runs.
    arguments : sequence of str
        The arguments of ``npss-baselines`` that resume them.
    """

    def hint() -> str:
        return f"; to resume: {_PROGRAM} {shlex.join(with_plugins(arguments))}" if existing_runs(folders) else ""

    try:
        yield
    except (KeyboardInterrupt, Stopped) as stop:
        number = stop.signal if isinstance(stop, Stopped) else signal.SIGINT
        message = "interrupted" if number is signal.SIGINT else f"stopped by {number.name}"
        print(f"{_PROGRAM}: {message}{hint()}", file=sys.stderr)
        raise SystemExit(128 + number) from None
    except OSError as error:
        if error.strerror is None or not hint():
            raise
        file = "" if error.filename is None else f"{error.filename}: "
        raise OSError(error.errno, f"{file}{error.strerror}{hint()}") from error
