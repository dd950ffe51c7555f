"""``npss-baselines train NAME``: fit a predictor that needs no iterations, such as ``ridge``."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from npss.console import Parser, Progress
from npss.validation import one_of
from npss_baselines.commands.sources import add_folder_options, folders_of, from_environment, needs
from npss_baselines.data import pose_sources
from npss_baselines.fitted import FITTED
from npss_baselines.runs import config, launch
from npss_baselines.runs.fitted import fit
from npss_baselines.runs.weights import FILE


def run(name: str, arguments: Sequence[str], command: Parser | None = None) -> None:
    """Fit, write the run, and print where.

    Parameters
    ----------
    name : str
        The name of the predictor.
    arguments : sequence of str
        Arguments after ``train NAME``.
    command : Parser, optional
        The parser of the command, which names these options in errors.

    Raises
    ------
    TypeError, ValueError, FileNotFoundError
        If an argument, a file or the motion is invalid.
    """
    parser = _parser(name)
    if command is not None:
        command.also_reads(parser)
    options = parser.parse_args(arguments)
    folders = {source: root for source, root in folders_of(options).items() if source in pose_sources()}
    data = options.data or (next(iter(folders)) if len(folders) == 1 else config.DATA)
    one_of("--data", data, tuple(pose_sources()))
    source = pose_sources()[data]
    if others := [other for other in folders if other != data]:
        raise ValueError(f"--{pose_sources()[others[0]].option}: this run trains on --data {data}")
    root = Path() if source.generated else folders.get(data) or from_environment(source)
    if root is None:
        raise ValueError(needs([source, *(other for other in pose_sources().values() if other.generated)], "--data "))
    if (options.out / config.FILE).exists():
        raise ValueError(f"--out: {options.out} already holds a run")
    actions = options.actions or source.default_actions[:1]
    actions = list(source.actions) if actions == ["all"] else actions
    with launch.exclusive_folders(options.out, [options.out], []), Progress("fitting") as progress:
        fitted = fit(
            name,
            source,
            root,
            actions,
            subjects=options.subjects,
            seed=options.seed,
            cache=options.cache,
            progress=progress,
        )
        fitted.save(options.out, paths={} if source.generated else {source.option: root})
    subjects = fitted.configuration.subjects
    read = [
        f"{action} of {', '.join(map(str, subjects[action]))}" if subjects[action] else action for action in actions
    ]
    print(f"{options.out / FILE}: {name}, fitted to {'; '.join(read)}")
    if others := [action for action in subjects if action not in actions]:
        print(f"    and to {len(others)} other actions")


def _parser(name: str) -> Parser:
    parser = Parser(
        prog=f"npss-baselines train {name}",
        description=f"Fit a predictor to training motion, in minutes: {name}, {FITTED[name].description}.",
        allow_abbrev=False,
    )
    sources = pose_sources()
    parser.add_argument(
        "--out", type=Path, metavar="RUN", required=True, help="write the run to this folder, created if missing"
    )
    parser.add_argument("--data", choices=tuple(sources), help=f"choose the source of motion (default: {config.DATA})")
    add_folder_options(parser, sources.values())
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="cache parsed files in this folder, to load them faster"
    )
    parser.add_argument(
        "--actions",
        "--action",
        nargs="+",
        metavar="ACTION",
        help="predict these actions, or all (default: the source's first)",
    )
    parser.add_argument(
        "--subjects",
        nargs="+",
        type=_subject,
        metavar="S",
        help="train on these subjects (default: for each action, all training subjects with files)",
    )
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="set the seed of the fit (default: %(default)s)"
    )
    return parser


def _subject(text: str) -> str | int:
    return int(text) if text.isdecimal() else text
