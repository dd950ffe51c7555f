"""``npss-baselines sensitivity``: show how each metric responds to distortions of motion."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from npss.files import check_output, write_figure_atomically
from npss.records import Record
from npss_baselines.commands.sources import add_pose_source, pose_source_of
from npss_baselines.evaluation.sensitivity import motion_of, study, tabulate


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss-baselines``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "sensitivity",
        help="show how each metric responds to distortions of motion",
        description="Distort walking in time and space, and score it: NPSS under every convention, and the Euler error "
        "(averaged over all frames).",
    )
    add_pose_source(parser)
    parser.add_argument(
        "--format",
        choices=("table", "json", "markdown"),
        help="set the format of the output (default: table on a terminal, else json)",
    )
    parser.add_argument(
        "-o",
        "--output",
        type=Path,
        metavar="PICTURE",
        help="also write a picture (.svg, .pdf or .png); needs matplotlib",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the records; draw them if requested."""
    if options.output:
        check_output(options.output)
    records = study(motion_of(*pose_source_of(options)))
    if options.output:
        _draw(records, options.output)
    form = options.format or ("table" if sys.stdout.isatty() else "json")
    print(json.dumps(records, indent=2) if form == "json" else tabulate(records, markdown=form == "markdown"))


def _draw(records: Sequence[Record], path: Path) -> None:
    from npss import plot

    try:
        write_figure_atomically(path, plot.sensitivity(records))
    except ImportError as error:
        raise ValueError(f"-o: {error}") from None
