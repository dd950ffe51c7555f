"""``npss leaderboard``: rank models by files of their predictions or records."""

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
Rank models, with confidence intervals, and mark significant differences.

  npss leaderboard DIR            a folder with one file of samples ({samples}) per model: MODEL.npz or
                                  MODEL/samples.npz; models of the same name are shown with part of their paths
  npss leaderboard FILE ...       such files, and records ({records}) as npss-baselines evaluate prints them

Needs pandas (extra pandas).
"""


def add_parser(commands: Any) -> None:
    """Add the command to ``npss``."""
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
    parser.add_argument(
        "--edges-ms",
        type=float,
        nargs="+",
        default=(),
        metavar="MS",
        help="also score files of results in the windows between these edges, in milliseconds: 0 1000 2000 4000 for "
        "Table 5 of the NPSS paper",
    )
    add_leaderboard_options(parser)
    parser.set_defaults(run=run)


def add_protocol(parser: argparse.ArgumentParser) -> None:
    """Add the option for the protocol, which files of samples do not state."""
    parser.add_argument("--protocol", metavar="NAME", help="state in the signature which test windows these are")


def add_groups(parser: argparse.ArgumentParser) -> None:
    """Add the option for the blocks of sequences."""
    parser.add_argument(
        "--groups",
        type=Path,
        metavar="FILE",
        help="read blocks of dependent sequences from this JSON file: for each action, a list with one label per "
        "sequence, null for a sequence in no block (default: the blocks of --protocol)",
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
    """Return the further fields of the signatures of files of samples."""
    return {"protocol": options.protocol} if options.protocol else {}


def add_leaderboard_options(parser: argparse.ArgumentParser) -> None:
    """Add the options of a command that prints a leaderboard.

    Parameters
    ----------
    parser : ArgumentParser
        The parser of the command.
    """
    parser.add_argument("--published", action="store_true", help="also show published rows of the same meaning")
    parser.add_argument(
        "--reference", action="store_true", help="also show rows of the same meaning that this project measured"
    )
    parser.add_argument(
        "--by", metavar="COLUMN", help="sort by this column, such as 'NPSS released' (default: the first)"
    )
    parser.add_argument(
        "--columns",
        nargs="+",
        default=(),
        metavar="COLUMN",
        help="show only these columns, or those whose names begin so: 'NPSS released' 'Euler error' (default: all)",
    )
    parser.add_argument("--wide", action="store_true", help="write a table for each column, with actions side by side")
    parser.add_argument("--caption", metavar="TEXT", help="begin the captions of LaTeX tables with this text, in LaTeX")
    parser.add_argument(
        "--label", metavar="NAME", help="label the first LaTeX table, and the others NAME-2, NAME-3, ..."
    )
    parser.add_argument(
        "--method",
        dest="methods",
        nargs="+",
        action="append",
        default=[],
        metavar=("NAME", "MODEL"),
        help="average these models, three or more runs of one method that differ in their seed, as NAME (repeatable)",
    )
    parser.add_argument(
        "--level",
        type=float,
        default=0.95,
        metavar="P",
        help="set the confidence level of intervals and marks (default: %(default)s)",
    )
    parser.add_argument(
        "--format", choices=FORMATS, default="text", help="set the format of the output (default: %(default)s)"
    )
    add_max_size(parser)


def run(options: argparse.Namespace) -> None:
    """Print the leaderboard."""
    board = leaderboard_of(
        options.paths,
        options,
        metrics=options.metrics,
        edges_ms=options.edges_ms,
        groups=groups_of(options),
        max_size=options.max_size,
        **context_of(options),
    )
    show_leaderboard(board, options)


def leaderboard_of(source: Any, options: argparse.Namespace, **context: Any) -> Leaderboard:
    """Return the leaderboard of a source.

    Parameters
    ----------
    source : object
        As for `npss.leaderboard`.
    options : Namespace
        The values of the options that `add_leaderboard_options` adds.
    **context
        As for `npss.leaderboard`.

    Returns
    -------
    Leaderboard
        The leaderboard.

    Raises
    ------
    ValueError
        If a method is a duplicate; or as `npss.leaderboard`.
    """
    from npss.ranking._leaderboard import leaderboard  # imported here: few commands need it

    methods: dict[str, list[str]] = {}
    for name, *models in options.methods:
        if name in methods:
            raise ValueError(f"--method {name}: duplicate method")
        methods[name] = models
    return leaderboard(
        source,
        published=options.published,
        reference=options.reference,
        by=options.by,
        columns=options.columns,
        methods=methods,
        level=options.level,
        **context,
    )


def show_leaderboard(board: Leaderboard, options: argparse.Namespace) -> None:
    """Print a leaderboard.

    Parameters
    ----------
    board : Leaderboard
        The leaderboard.
    options : Namespace
        The values of the options that `add_leaderboard_options` adds.

    Raises
    ------
    ValueError
        If a caption or a label is given for another format than LaTeX, or ``--wide`` for CSV.
    """
    latex = {name: getattr(options, name) for name in ("caption", "label") if getattr(options, name) is not None}
    if latex and options.format != "latex":
        raise ValueError(f"--{next(iter(latex))}: only with --format latex")
    if options.wide and options.format == "csv":
        raise ValueError("--wide: not with --format csv, which has a row for each number")
    wide = {"wide": True} if options.wide else {}
    print(getattr(board, f"to_{options.format}")(**wide, **latex))
