"""``npss-baselines reproduce``: train and measure the models of the reference numbers."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import npss
from npss.console import duration, table
from npss.plugins import with_plugins
from npss.validation import positive_integer
from npss_baselines.commands.sources import add_pose_source, pose_source_of
from npss_baselines.reproduction import BUDGETS

if TYPE_CHECKING:
    from npss_baselines.reproduction.job import Place
    from npss_baselines.reproduction.plan import Planned

#: The file that the process of the command locks.
LOCK = ".lock"
#: The file of a run's output.
LOG = "log.txt"

_DESCRIPTION = """\
Train and measure the models of the reference numbers, from raw files to tables, by a plan: the most important first,
with one single-threaded process for each core. To resume, repeat the command: it skips what is done.
--out holds runs/ (models), records/ (a JSON file for each run) and tables/.
"""


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss-baselines``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "reproduce", help="reproduce the reference numbers", description=_DESCRIPTION
    )
    add_pose_source(parser)
    parser.add_argument("--out", type=Path, metavar="DIR", help="write the results to this folder, created if missing")
    parser.add_argument(
        "--only",
        nargs="+",
        default=[],
        metavar="NAME",
        help="run only these tables, rows or runs, by the names that --list prints",
    )
    parser.add_argument(
        "--budget",
        choices=BUDGETS,
        default="full",
        help="run this much of the plan; minutes: every step on a small scale, as a trial; hours: one seed of each "
        "model; full: all (default: %(default)s)",
    )
    parser.add_argument(
        "--plan", type=Path, metavar="FILE", help="run this plan, a TOML file, instead of the project's"
    )
    parser.add_argument("--list", action="store_true", help="list the runs, with what is done, and run nothing")
    parser.add_argument(
        "--workers", type=int, metavar="N", help="run N processes at once (default: one for each available core)"
    )
    parser.add_argument("--run-name", dest="run_name", help=argparse.SUPPRESS)  # for the processes of single runs
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Run the plan; or one run of it, in this process."""
    if options.out is None and not options.list:
        raise ValueError("--out DIR is required: the folder of the results")
    # Imported here: other commands need no torch.
    from npss_baselines.reproduction.job import Place, work
    from npss_baselines.reproduction.plan import read_plan
    from npss_baselines.runs import launch

    trial = options.budget == BUDGETS[0]
    source, folder = pose_source_of(options, "synthetic" if trial else None)
    runs = read_plan(options.plan).runs(source, budget=options.budget, only=options.only)
    out = options.out
    place = None if out is None else Place(source, folder, out / "trial" if trial else out, trial)
    if place is None or options.list:
        print(_listed(runs, place))
        return
    folders = [place.run(planned) for planned in runs]
    with launch.explain_resuming(folders, _arguments(place, options)):
        if options.run_name is not None:
            work(next(planned for planned in runs if planned.name == options.run_name), place)
        else:
            _run_all(runs, place, options)


def _run_all(runs: Sequence[Planned], place: Place, options: argparse.Namespace) -> None:
    """Run what is left of the plan, each run in its process."""
    from npss_baselines.reproduction import processes, tables
    from npss_baselines.reproduction.job import done
    from npss_baselines.reproduction.plan import read_plan
    from npss_baselines.reproduction.results import Results, read_records

    _ = npss.Leaderboard  # without pandas, which the tables need, this says how to install it
    read_records(place.out / "records")  # before hours of work: it refuses what the tables could not be made of
    left = [planned for planned in runs if not done(planned, place)]
    available = processes.cores() if options.workers is None else positive_integer("--workers", options.workers)
    workers = max(1, min(available, len(left)))
    time = duration(60 * sum(planned.row.minutes for planned in left) / workers)
    _say(f"{len(runs)} runs, {len(runs) - len(left)} done; about {time} for the others, {workers} at once")
    jobs = [
        processes.Job(planned.name, _command(planned, place, options), place.run(planned) / LOG, planned.row.minutes)
        for planned in left
    ]
    with _locked(place.out):
        failed = processes.run(jobs, workers=workers, say=_say)
    tables.write(Results(read_plan(options.plan), read_records(place.out / "records")), place.out / "tables")
    _say(f"the tables of what is done are in {place.out / 'tables'}")
    if failed:
        raise ValueError(f"{len(failed)} of {len(runs)} runs failed: {', '.join(job.name for job in failed)}")


def _arguments(place: Place, options: argparse.Namespace) -> list[str]:
    """Return the arguments that run the same plan."""
    source = [f"--{place.source.option}", *([] if place.source.generated else [str(place.folder)])]
    plan = [] if options.plan is None else ["--plan", str(options.plan)]
    only = ["--only", *options.only] if options.only else []
    return ["reproduce", *source, "--out", str(options.out), "--budget", options.budget, *plan, *only]


def _command(planned: Planned, place: Place, options: argparse.Namespace) -> list[str]:
    """Return the command of a run's process: this command, with the run's name."""
    arguments = with_plugins([*_arguments(place, options), "--run-name", planned.name])
    return [sys.executable, "-m", "npss_baselines", *arguments]


def _listed(runs: Sequence[Planned], place: Place | None) -> str:
    """Return a table of the runs, with their state if there is a place for their results."""
    rows = []
    for planned in runs:
        state = "" if place is None else _state(planned, place)
        minutes = duration(60 * planned.row.minutes)
        rows.append([planned.name, planned.row.model, planned.row.recipe, minutes, state, planned.why])
    return table(["run", "model", "recipe", "one core", "state", "why"], rows, "lllrll")


def _state(planned: Planned, place: Place) -> str:
    """Return whether a run is done, failed or begun; empty if it is none of these."""
    from npss_baselines.reproduction.job import done
    from npss_baselines.reproduction.processes import has_failed

    folder = place.run(planned)
    if done(planned, place):
        return "done"
    return "failed" if has_failed(folder / LOG) else "begun" if folder.exists() else ""


@contextmanager
def _locked(out: Path) -> Iterator[None]:
    """Lock the folder of the results against other processes."""
    from filelock import FileLock, Timeout  # here, since other commands need no filelock

    out.mkdir(parents=True, exist_ok=True)
    try:
        with FileLock(out / LOCK, timeout=0):
            yield
    except Timeout:
        raise ValueError(f"--out: another process is reproducing in {out}") from None


def _say(line: str) -> None:
    print(line, file=sys.stderr, flush=True)
