"""Run jobs in processes of their own: in order, several at once, failures again at the end."""

from __future__ import annotations

import os
import subprocess
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

from npss.console import Progress, duration
from npss_baselines.runs.stopping import Stop

#: Variables that limit the threads of numerical libraries; they are read when a process starts.
_THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")
_POLL = 0.2  # seconds between two looks at the processes
_AT_MOST = 0.95  # of a job's expected time that counts as done before it ends


@dataclass(frozen=True)
class Job:
    """A command to run.

    Attributes
    ----------
    name : str
        The name in messages.
    command : sequence of str
        The arguments of the process.
    log : Path
        The file of its output.
    minutes : float
        The expected time.
    """

    name: str
    command: Sequence[str]
    log: Path
    minutes: float


def cores() -> int:
    """Return the number of cores that this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def run(jobs: Sequence[Job], *, workers: int, say: Callable[[str], None]) -> list[Job]:
    """Run jobs, `workers` at once, with one thread each; then run those that failed again.

    Parameters
    ----------
    jobs : sequence of Job
        The jobs, in order.
    workers : int
        Number of processes at once.
    say : callable
        Called with a line for each job that ends.

    Returns
    -------
    list of Job
        The jobs that failed twice.

    Raises
    ------
    Stopped
        If a signal ended the work, after all processes have ended.
    """
    with Stop() as stop, Progress("reproducing") as progress:
        total, done = sum(job.minutes for job in jobs), 0.0
        failed = [*jobs]

        def show(share: float) -> None:
            progress(min((done + share) / total, 1.0) if total else 1.0)

        for again in ("to be run again at the end", "for the second time"):
            jobs, failed = failed, []
            for job, seconds, status in _ended(jobs, workers, stop, show):
                if status == 0:
                    done += job.minutes
                    say(f"{job.name}: done in {duration(seconds)}")
                else:
                    failed.append(job)
                    _failure(job.log).touch()
                    say(f"{job.name}: failed after {duration(seconds)}, {again}; see {job.log}")
        return failed


def has_failed(log: Path) -> bool:
    """Return whether the job with this log failed, and has not run since."""
    return _failure(log).exists()


def _failure(log: Path) -> Path:
    """Return the file that marks a job as failed, until it runs again."""
    return log.with_suffix(".failed")


def _ended(
    jobs: Sequence[Job], workers: int, stop: Stop, show: Callable[[float], None]
) -> Iterator[tuple[Job, float, int]]:
    """Yield each job when it has ended, with its time in seconds and its exit status."""
    waiting, running = list(jobs), list[_Running]()
    try:
        while waiting or running:
            while waiting and len(running) < workers:
                running.append(_Running(waiting.pop(0)))
            time.sleep(_POLL)
            stop.check()
            show(sum(process.done() for process in running))
            for process in [*running]:
                status = process.status()
                if status is not None:
                    running.remove(process)
                    yield process.job, process.seconds(), status
    finally:
        for process in running:
            process.stop()
        for process in running:
            process.wait()


class _Running:
    """A job that runs."""

    def __init__(self, job: Job) -> None:
        job.log.parent.mkdir(parents=True, exist_ok=True)
        _failure(job.log).unlink(missing_ok=True)
        self.job, self._began = job, time.monotonic()
        threads = dict.fromkeys(_THREADS, "1")
        with job.log.open("ab") as log:
            # In a session of its own, it gets one signal, from here: at a second, a training saves no checkpoint.
            self._process = subprocess.Popen(
                job.command, env=os.environ | threads, stdout=log, stderr=log, start_new_session=True
            )

    def seconds(self) -> float:
        """Return the seconds since it began."""
        return time.monotonic() - self._began

    def done(self) -> float:
        """Return the expected minutes that it has done."""
        return min(self.seconds() / 60, _AT_MOST * self.job.minutes)

    def status(self) -> int | None:
        """Return the exit status, or None."""
        return self._process.poll()

    def stop(self) -> None:
        """Ask it to stop, which a training does after its step."""
        self._process.terminate()

    def wait(self) -> None:
        """Wait for its end."""
        self._process.wait()
