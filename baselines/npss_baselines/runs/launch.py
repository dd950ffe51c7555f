"""What the commands that train have in common: the device, the folder that is theirs alone, and how to go on."""

from __future__ import annotations

import argparse
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
from npss_baselines.runs.config import CHECKPOINT, FILE
from npss_baselines.runs.stopping import Stopped

#: The file in the folder of a run that a process holds as long as it trains there.
LOCK = ".lock"
_PROGRAM = "npss-baselines"


def add_device(parser: argparse.ArgumentParser) -> None:
    """Add the option that `device_of` reads."""
    parser.add_argument(
        "--device", choices=("auto", "cpu", "cuda"), default="auto", help="auto: cuda if there is one, else cpu"
    )


def device_of(asked: str, *, tf32: bool = False) -> str:
    """Return the device, ``'cpu'`` or ``'cuda'``, that was asked for.

    Raises
    ------
    ValueError
        If there is none.
    """
    found = torch.cuda.is_available()
    if asked == "cuda" and not found:
        why = "this torch is built without CUDA" if torch.version.cuda is None else "torch finds no GPU"
        raise ValueError(f"--device cuda: {why}; --device cpu trains without")
    device = ("cuda" if found else "cpu") if asked == "auto" else asked
    if tf32 and device != "cuda":
        raise ValueError("--tf32: needs a CUDA device")
    return device


def begun(folders: Sequence[Path]) -> list[Path]:
    """Return those of some folders that hold a run."""
    return [folder for folder in folders if (folder / FILE).exists()]


@contextmanager
def folders_alone(out: Path, folders: Sequence[Path], before: Sequence[Path]) -> Iterator[None]:
    """Make the folders of runs, and let no other process train there meanwhile.

    An error of another kind than the system's leaves nothing behind of runs that have no checkpoint yet.

    Parameters
    ----------
    out : Path
        The folder of the checkpoint.
    folders : sequence of Path
        Those of the runs: the same, or folders in it.
    before : sequence of Path
        What `begun` has returned when the command decided what to do.

    Raises
    ------
    ValueError
        If another process trains there, or has begun to since.
    """
    everywhere = list(dict.fromkeys([out, *folders]))
    new = [path for folder in everywhere for path in (folder, *folder.parents) if not path.exists()]
    new = sorted(dict.fromkeys(new), reverse=True)  # what is inside comes first
    with ExitStack() as locks:
        for folder in everywhere:
            with doing("making the folder of the run"):
                folder.mkdir(parents=True, exist_ok=True)
            try:
                locks.enter_context(FileLock(folder / LOCK, timeout=0))
            except Timeout:
                raise ValueError(f"--out: another process is training in {folder}") from None
        if begun(folders) != list(before):
            raise ValueError(f"--out: another process has trained in {out} meanwhile; --resume goes on with its run")
        for folder in everywhere:
            for part in folder.glob(".*.part"):  # of a process that was killed while it wrote
                part.unlink()
        try:
            yield
        except BaseException as error:
            resumable = isinstance(error, OSError | KeyboardInterrupt | Stopped) and begun(folders)
            if not before and not resumable and not (out / CHECKPOINT).exists():
                for folder in folders:
                    (folder / FILE).unlink(missing_ok=True)
                for folder in everywhere:
                    (folder / LOCK).unlink(missing_ok=True)
                for folder in new:
                    with suppress(OSError):  # there is something else in it
                        folder.rmdir()
            raise


@contextmanager
def moved(option: str, root: Path | None, recorded_in: Path | None) -> Iterator[None]:
    """Let the error of a folder of data that is gone say that it is the run's, and which option gives another."""
    try:
        yield
    except FileNotFoundError as error:
        if recorded_in is None or root is None or root.exists():
            raise
        raise FileNotFoundError(
            f"{root} is not there, where {recorded_in} says that the data are; --{option} DIR gives another folder"
        ) from error


@contextmanager
def going_on(folders: Sequence[Path], arguments: Sequence[str]) -> Iterator[None]:
    """Let what ends training early say how to go on: a signal, by its exit status, 128 and its number; a full disk.

    Parameters
    ----------
    folders : sequence of Path
        Those of the runs.
    arguments : sequence of str
        What resumes them: the arguments of ``npss-baselines``.
    """

    def how() -> str:
        return f"; to go on: {_PROGRAM} {shlex.join(with_plugins(arguments))}" if begun(folders) else ""

    try:
        yield
    except (KeyboardInterrupt, Stopped) as stop:
        by = stop.signal if isinstance(stop, Stopped) else signal.SIGINT
        said = "interrupted" if by is signal.SIGINT else f"ended by {by.name}"
        print(f"{_PROGRAM}: {said}{how()}", file=sys.stderr)
        raise SystemExit(128 + by) from None
    except OSError as error:
        if error.strerror is None or not how():
            raise
        file = "" if error.filename is None else f"{error.filename}: "
        raise OSError(error.errno, f"{file}{error.strerror}{how()}") from error
