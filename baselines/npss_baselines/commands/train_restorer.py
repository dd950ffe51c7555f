"""``npss-baselines train restorer``: train the restorer of motion."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from npss.console import Parser
from npss_baselines.commands.sources import add_folder_options, folders_of
from npss_baselines.data import SOURCES
from npss_baselines.manifold.motion.prepared import motion_set
from npss_baselines.manifold.motion.split import split, subjects_of
from npss_baselines.manifold.restorers.file import load, save
from npss_baselines.manifold.restorers.training import DEFAULT, QUICK, train_restorer
from npss_baselines.runs import launch


def run(arguments: Sequence[str], command: Parser | None = None) -> None:
    """Train, write the file, and print where.

    Parameters
    ----------
    arguments : sequence of str
        Arguments after ``train restorer``.
    command : Parser, optional
        The parser of the command, which names these options in errors.

    Raises
    ------
    TypeError, ValueError, FileNotFoundError
        If an argument, a file or the motion is invalid.
    """
    parser = _parser()
    if command is not None:
        command.also_reads(parser)
    options = parser.parse_args(arguments)
    if options.out.suffix != ".npz":
        raise ValueError(f"--out: expected a name that ends in .npz, got {options.out}")
    if not options.out.parent.is_dir():
        raise FileNotFoundError(f"--out: {options.out.parent}: no such folder")
    motion = motion_set(folders_of(options), cache=options.cache, quick=options.quick)
    training = split(motion).training
    subjects = ", ".join(subjects_of(training)) or "unknown"
    print(f"training on {len(training.clips)} clips of the subjects {subjects}", flush=True)
    with launch.use_threads(launch.threads_of(options.threads, [])):
        settings = QUICK if options.quick else DEFAULT
        restorer = train_restorer(training, seed=options.seed, settings=settings)
    save(options.out, restorer)
    print(f"{options.out}: {load(options.out).signature}")


def _parser() -> Parser:
    parser = Parser(
        prog="npss-baselines train restorer",
        description="Train the restorer of motion, on generated walks if no folder of motion is named. Subjects held "
        "out for tests and for validation do not take part.",
        allow_abbrev=False,
    )
    parser.add_argument("--out", type=Path, metavar="FILE", required=True, help="write this .npz file")
    add_folder_options(parser, SOURCES.values(), environment=False)
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="cache prepared motion in this folder, to load it faster"
    )
    parser.add_argument("--quick", action="store_true", help="use a small part of the data and few steps, to try it")
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="set the seed of all random choices (default: %(default)s)"
    )
    launch.add_threads(parser)
    return parser
