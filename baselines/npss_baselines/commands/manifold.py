"""``npss-baselines manifold``: applications of a trained manifold, each with its numbers and its picture."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from npss.files import doing, write_figure_atomically
from npss.ranking import names_of_paths
from npss_baselines.commands.sources import add_folder_options, folders_of
from npss_baselines.data import SOURCES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from npss.records import Record
    from npss_baselines.manifold.evaluation.testbed import Testbed

_RESTORE = {
    "project": "windows as they are",
    "repair": "every value lost with probability .5",
    "kinect": "a simulated depth camera: jitter, drop-outs, an occluded limb",
    "fill": "the right wrist and hand missing throughout",
    "inbetween": "every 15th frame held: stepped keys",
}


def add_parser(commands: Any) -> None:
    """Add the commands to those of ``npss-baselines``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "manifold",
        help="use a trained motion manifold",
        description="Use a trained motion manifold: `npss-baselines train manifold` makes one.",
    )
    applications = parser.add_subparsers(title="applications", required=True, metavar="APPLICATION")
    for application, what in _RESTORE.items():
        restore = _add(applications, application, f"restore {what}", run_restoration)
        restore.add_argument("--clip", metavar="CLIP", help="of held-out subjects: what to draw (default: the first)")
        restore.set_defaults(application=application)
    interpolate = _add(applications, "interpolate", "between two motions, in the hidden space", run_interpolation)
    interpolate.add_argument(
        "--clips",
        nargs=2,
        metavar="CLIP",
        help="which two (default: pairs of held-out windows; drawn, 13_30 and a walk)",
    )
    _add(applications, "sample", "motion from codes drawn at random", run_sampling)
    filters = _add(applications, "filters", "the motion that excites a hidden unit", run_filters)
    filters.add_argument("--units", nargs="+", type=int, metavar="N", help="what to draw (default: what varies most)")
    distance = _add(applications, "distance", "the distance G of two clips", run_distance)
    distance.add_argument("clips", nargs=2, metavar="CLIP")
    nearest = _add(
        applications, "nearest", "how well G finds clips of the same action, or the clips nearest to one", run_nearest
    )
    nearest.add_argument("--clip", metavar="CLIP", help="show what is nearest to this one instead")
    nearest.add_argument("-n", type=int, default=5, metavar="N", help="clips to show (default: 5)")
    table = _add(applications, "table", "every number of every application", run_table, several=True)
    table.add_argument("--pictures", type=Path, metavar="DIR", help="draw all of them, too, into this folder")


def _add(applications: Any, name: str, what: str, run: Any, *, several: bool = False) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = applications.add_parser(
        name, help=what, description=what[0].upper() + what[1:] + "."
    )
    parser.add_argument("runs", nargs="+" if several else 1, type=Path, metavar="RUN", help="the folder of a run")
    add_folder_options(parser, SOURCES.values(), environment=False)
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="keep prepared motion there, to load faster next time"
    )
    parser.add_argument("--quick", action="store_true", help="a small part of the data, to try things")
    parser.add_argument("--seed", type=int, default=0, help="of all that is random (default: 0)")
    parser.add_argument(
        "--format", choices=("table", "json", "markdown"), help="default: table on a terminal, else json"
    )
    if not several:
        parser.add_argument("-o", "--output", type=Path, metavar="PICTURE", help="draw it, too, as .svg, .pdf or .png")
    parser.set_defaults(run=run, extra="manifold")
    return parser


def run_restoration(options: argparse.Namespace) -> None:
    """Print what restoring is worth, and draw a window."""
    from npss_baselines.manifold.evaluation.restoration import restoration
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    _show(options, list(restoration(testbed, options.application)))
    if options.output:
        _save(options.output, figures.restoration(testbed, options.application, clip=options.clip))


def run_interpolation(options: argparse.Namespace) -> None:
    """Print what interpolation is worth, and draw one."""
    from npss_baselines.manifold.evaluation.synthesis import interpolation
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    clips = options.clips and [figures.clip_named(testbed.motions, clip) for clip in options.clips]
    _show(options, list(interpolation(testbed, clips)))
    if options.output:
        _save(options.output, figures.interpolation(testbed, clips))


def run_sampling(options: argparse.Namespace) -> None:
    """Print what samples are worth, and draw some."""
    from npss_baselines.manifold.evaluation.synthesis import sampling
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    _show(options, list(sampling(testbed)))
    if options.output:
        _save(options.output, figures.samples(testbed))


def run_filters(options: argparse.Namespace) -> None:
    """Print what hidden units do, and draw some."""
    from npss_baselines.manifold.evaluation.synthesis import filtering
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    _show(options, list(filtering(testbed)))
    if options.output:
        _save(options.output, figures.filters(testbed, options.units))


def run_distance(options: argparse.Namespace) -> None:
    """Print how far two clips are from each other, and draw them."""
    from npss_baselines.manifold.evaluation.similarity import distance
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    clips = [figures.clip_named(testbed.motions, clip) for clip in options.clips]
    records = list(distance(testbed, *clips))
    _show(options, records, listed=True)
    if options.output:
        said = (f"{record['metric']} by {record['method']}: {record['value']:.4g}" for record in records)
        _save(options.output, figures.whole_clips(testbed.motions, clips, ", ".join(said)))


def run_nearest(options: argparse.Namespace) -> None:
    """Print the clips that are nearest to one, or how well nearest clips are of the same action; and draw it."""
    from npss_baselines.manifold.evaluation.similarity import nearness, ranking
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    if options.clip is None:
        records = list(nearness(testbed))
        if not records:
            raise ValueError(
                "no two actions among these clips, so there is nothing to tell apart; name a CLIP, or other motion"
            )
        _show(options, records)
        if options.output:
            _save(options.output, figures.retrieval(records))
        return
    query = figures.clip_named(testbed.motions, options.clip)
    ranked = list(ranking(testbed, query, options.n))
    _show(options, ranked, listed=True)
    if options.output:
        name = next(iter(testbed.manifolds))
        clips = [query, *(record["index"] for record in ranked if record["method"] == name)]
        _save(options.output, figures.whole_clips(testbed.motions, clips, f"nearest to the first by G of {name}"))


def run_table(options: argparse.Namespace) -> None:
    """Print every number, and draw every picture."""
    from npss_baselines.manifold.evaluation.measure import measure_all
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    records = list(measure_all(testbed))
    _show(options, records)
    if options.pictures:
        with doing("making the folder of the pictures"):
            options.pictures.mkdir(parents=True, exist_ok=True)
        for name, figure in figures.all_figures(testbed, records):
            _save(options.pictures / f"{name}.png", figure)


def _testbed(options: argparse.Namespace) -> Testbed:
    """Load the runs, and the motion."""
    from npss_baselines.manifold.evaluation.testbed import RESERVED, Testbed
    from npss_baselines.manifold.motion.prepared import motion_set
    from npss_baselines.manifold.training.folder import load

    runs = {"manifold": options.runs[0]} if len(options.runs) == 1 else names_of_paths(options.runs, taken=RESERVED)
    manifolds = {name: load(run).projector for name, run in runs.items()}
    motions = motion_set(folders_of(options), cache=options.cache, quick=options.quick)
    return Testbed(motions, manifolds, options.seed)


def _show(options: argparse.Namespace, records: Sequence[Record], *, listed: bool = False) -> None:
    from npss_baselines.manifold.evaluation import table

    form = options.format or ("table" if sys.stdout.isatty() else "json")
    laid_out = table.listing if listed else table.text
    print(json.dumps(records, indent=2) if form == "json" else laid_out(records, markdown=form == "markdown"))


def _save(path: Path, figure: Figure) -> None:
    write_figure_atomically(path, figure)
    print(path, file=sys.stderr)
