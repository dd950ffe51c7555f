"""``npss leaderboard``: rank the models whose predictions, or records, files hold."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from npss.commands._metrics import add_metrics
from npss.files._formats import listed
from npss.files._json import read_json
from npss.files._samples import add_max_size

if TYPE_CHECKING:
    from npss.ranking._frame import Leaderboard

FORMATS = ("text", "markdown", "latex", "html", "csv")

_DESCRIPTION = """\
Rank models, with intervals, and mark differences that are more than chance.

  npss leaderboard DIR            a folder with a file of samples ({samples}) for each model: MODEL.npz, or
                                  MODEL/samples.npz; models of the same name are told apart by what differs in their
                                  paths
  npss leaderboard FILE ...       such files, and records ({records}) as npss-baselines evaluate prints them

Needs pandas (extra pandas).
"""


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "leaderboard",
        help="rank models by their prediction files",
        description=_DESCRIPTION.format(samples=listed("samples"), records=listed("records")),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("paths", nargs="+", type=Path, metavar="PATH", help="a folder, samples or records")
    add_protocol(parser)
    add_groups(parser)
    add_metrics(parser)
    add_leaderboard_options(parser)
    parser.set_defaults(run=run)


def add_protocol(parser: argparse.ArgumentParser) -> None:
    """Add the option that says what files of samples do not say."""
    parser.add_argument("--protocol", help="state in the signature which test windows the samples are of")


def add_groups(parser: argparse.ArgumentParser) -> None:
    """Add the option that names the blocks of sequences."""
    parser.add_argument(
        "--groups",
        type=Path,
        metavar="FILE",
        help="read from this file (JSON) which sequences depend on each other: for each action a list with a label for "
        "each sequence, null for one in no block; --protocol srnn-8 or random-256 knows its own",
    )


def groups_of(options: argparse.Namespace) -> dict[str, Any] | None:
    """Read the blocks of sequences by action."""
    if options.groups is None:
        return None
    groups = read_json(options.groups)
    if not isinstance(groups, dict) or not all(isinstance(labels, list) for labels in groups.values()):
        raise ValueError(f"--groups {options.groups}: expected an object with a list of labels for each action")
    return groups


def context_of(options: argparse.Namespace) -> dict[str, Any]:
    """Return what the signatures of files of samples state besides."""
    return {"protocol": options.protocol} if options.protocol else {}


def add_leaderboard_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of whatever prints a leaderboard.

    Parameters
    ----------
    parser : ArgumentParser
        Of the command.
    """
    parser.add_argument("--published", action="store_true", help="show published rows of the same meaning, too")
    parser.add_argument(
        "--by", metavar="COLUMN", help="sort by this column, such as 'NPSS released' (default: the first)"
    )
    parser.add_argument(
        "--method",
        nargs="+",
        action="append",
        default=[],
        metavar=("NAME", "MODEL"),
        help="average the models that follow NAME, three or more runs of one method that differ in their seed",
    )
    parser.add_argument("--level", type=float, default=0.95, help="give intervals and marks this level (default: 0.95)")
    parser.add_argument("--format", choices=FORMATS, default="text")
    add_max_size(parser)


def run(options: argparse.Namespace) -> None:
    """Print the leaderboard."""
    board = leaderboard_of(
        options.paths,
        options,
        metrics=options.metrics,
        groups=groups_of(options),
        max_size=options.max_size,
        **context_of(options),
    )
    show_leaderboard(board, options)


def leaderboard_of(source: Any, options: argparse.Namespace, **context: Any) -> Leaderboard:
    """Return the leaderboard of whatever it can be made of.

    Parameters
    ----------
    source : object
        As for `npss.leaderboard`.
    options : Namespace
        Those that `add_leaderboard_options` adds.
    **context
        As for `npss.leaderboard`.

    Returns
    -------
    Leaderboard
        The leaderboard.

    Raises
    ------
    ValueError
        If a method is named twice; or as `npss.leaderboard`.
    """
    from npss.ranking._leaderboard import leaderboard  # here, since few commands need it

    methods: dict[str, list[str]] = {}
    for name, *models in options.method:
        if name in methods:
            raise ValueError(f"--method {name} is there twice")
        methods[name] = models
    return leaderboard(
        source, published=options.published, by=options.by, methods=methods, level=options.level, **context
    )


def show_leaderboard(board: Leaderboard, options: argparse.Namespace) -> None:
    """Print a leaderboard.

    Parameters
    ----------
    board : Leaderboard
        The leaderboard.
    options : Namespace
        Those that `add_leaderboard_options` adds; ``format`` counts.
    """
    print(getattr(board, f"to_{options.format}")())
