"""``npss-baselines manifold measure``, ``table``, ``filters`` and ``distance``: numbers and figures of manifolds."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from npss.files import doing, write_figure_atomically, write_text_atomically
from npss.ranking import names_of_paths
from npss_baselines.commands.sources import add_folder_options, folders_of
from npss_baselines.data import SOURCES

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from npss.records import Record
    from npss_baselines.manifold.evaluation.testbed import Testbed

_RESTORE = {
    "project": "reconstruct uncorrupted windows",
    "repair": "restore windows in which each value is missing with probability .5",
    "kinect": "restore windows from a simulated depth camera: jitter, drop-outs, an occluded limb",
    "fill": "restore windows without right wrist and hand",
    "inbetween": "restore windows of stepped keys: every 15th frame, held",
}


def add_parsers(commands: Any) -> None:
    """Add the commands."""
    measure: argparse.ArgumentParser = commands.add_parser(
        "measure",
        help="measure an application on held-out windows",
        description="Measure an application on windows of held-out subjects.",
    )
    applications = measure.add_subparsers(title="applications", required=True, metavar="APPLICATION")
    for application, summary in _RESTORE.items():
        restore = _add(applications, application, summary, run_restoration)
        restore.add_argument("--clip", metavar="CLIP", help="draw this clip of a held-out subject (default: the first)")
        restore.set_defaults(application=application)
        _add_restorer(restore)
    interpolate = _add(applications, "interpolate", "interpolate two motions", run_interpolation)
    interpolate.add_argument(
        "--clips",
        nargs=2,
        metavar="CLIP",
        help="interpolate these clips (default: pairs of held-out windows; in the picture, 13_30 and a walk)",
    )
    _add(applications, "sample", "sample motion from random codes", run_sampling)
    nearest = _add(
        applications,
        "nearest",
        "measure retrieval of clips of the same action, or rank all clips by every distance to one",
        run_nearest,
    )
    nearest.add_argument("--clip", metavar="CLIP", help="list the clips nearest to this clip")
    nearest.add_argument("-n", type=int, default=5, metavar="N", help="list N clips (default: %(default)s)")
    table = _add(commands, "table", "measure all applications", run_table, several=True)
    table.add_argument("--pictures", type=Path, metavar="DIR", help="also write every picture to this folder")
    _add_restorer(table)
    filters = _add(commands, "filters", "show the motion of single hidden units", run_filters)
    filters.add_argument(
        "--units", nargs="+", type=int, metavar="N", help="draw these hidden units (default: those that vary most)"
    )
    distance = _add(commands, "distance", "measure the distance G of two clips of the sources", run_distance)
    distance.add_argument("clips", nargs=2, metavar="CLIP", help="the names of two clips")


def _add(applications: Any, name: str, summary: str, run: Any, *, several: bool = False) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = applications.add_parser(
        name, help=summary, description=f"{summary[0].upper()}{summary[1:]}."
    )
    parser.add_argument("runs", nargs="+" if several else 1, type=Path, metavar="RUN", help="the folder of a run")
    add_folder_options(parser, SOURCES.values(), environment=False)
    parser.add_argument(
        "--cache", type=Path, metavar="DIR", help="cache prepared motion in this folder, to load it faster"
    )
    parser.add_argument("--quick", action="store_true", help="use a small part of the data, to try things out")
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="set the seed of all random choices (default: %(default)s)"
    )
    parser.add_argument(
        "--format",
        choices=("table", "json", "markdown"),
        help="set the format of the output (default: table on a terminal, else json)",
    )
    if not several:
        parser.add_argument(
            "-o",
            "--output",
            type=Path,
            metavar="PICTURE",
            help="also write a picture (.svg, .pdf or .png); of `interpolate` also a moving page (.html)",
        )
    parser.set_defaults(run=run, extra="manifold")
    return parser


def _add_restorer(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--restorer",
        type=Path,
        nargs="+",
        metavar="FILE",
        help="measure these restorers, from `npss-baselines train restorer` (default: that of the package)",
    )


def run_restoration(options: argparse.Namespace) -> None:
    """Print measures of restored windows, and draw one."""
    from npss_baselines.manifold.evaluation.restoration import restoration
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    _show(options, list(restoration(testbed, options.application)))
    if options.output:
        _save(options.output, figures.restoration(testbed, options.application, clip=options.clip))


def run_interpolation(options: argparse.Namespace) -> None:
    """Print measures of interpolations, and draw one."""
    from npss_baselines.manifold.evaluation.synthesis import interpolation
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    clips = options.clips and [figures.clip_named(testbed.motions, clip) for clip in options.clips]
    _show(options, list(interpolation(testbed, clips)))
    if options.output and options.output.suffix.lower() == ".html":
        write_text_atomically(options.output, figures.moving_interpolation(testbed, clips))
        print(options.output, file=sys.stderr)
    elif options.output:
        _save(options.output, figures.interpolation(testbed, clips))


def run_sampling(options: argparse.Namespace) -> None:
    """Print measures of samples, and draw some."""
    from npss_baselines.manifold.evaluation.synthesis import sampling
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    _show(options, list(sampling(testbed)))
    if options.output:
        _save(options.output, figures.samples(testbed))


def run_filters(options: argparse.Namespace) -> None:
    """Print measures of hidden units, and draw some."""
    from npss_baselines.manifold.evaluation.synthesis import filtering
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    _show(options, list(filtering(testbed)))
    if options.output:
        _save(options.output, figures.filters(testbed, options.units))


def run_distance(options: argparse.Namespace) -> None:
    """Print the distances of two clips, and draw them."""
    from npss_baselines.manifold.evaluation.similarity import distance
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    clips = [figures.clip_named(testbed.motions, clip) for clip in options.clips]
    records = list(distance(testbed, *clips))
    _show(options, records, listed=True)
    if options.output:
        captions = (f"{record['metric']} by {record['method']}: {record['value']:.4g}" for record in records)
        _save(options.output, figures.whole_clips(testbed.motions, clips, ", ".join(captions)))


def run_nearest(options: argparse.Namespace) -> None:
    """Print measures of retrieval, or the clips nearest to a clip, and draw them."""
    from npss_baselines.manifold.evaluation.similarity import nearness, ranking
    from npss_baselines.manifold.show import figures

    testbed = _testbed(options)
    if options.clip is None:
        records = list(nearness(testbed))
        if not records:
            raise ValueError("retrieval needs clips of at least two actions; name a --clip, or other motion")
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
    """Print all measures, and draw all pictures."""
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
    """Load runs and motion."""
    from npss_baselines.manifold.applications.method import Method
    from npss_baselines.manifold.evaluation.testbed import RESERVED, Testbed
    from npss_baselines.manifold.motion.prepared import motion_set
    from npss_baselines.manifold.restorers import file
    from npss_baselines.manifold.training.folder import load

    runs = {"manifold": options.runs[0]} if len(options.runs) == 1 else names_of_paths(options.runs, taken=RESERVED)
    manifolds = {name: load(run).projector for name, run in runs.items()}
    motions = motion_set(folders_of(options), cache=options.cache, quick=options.quick)
    files = getattr(options, "restorer", None)
    if files is None:
        return Testbed(motions, manifolds, options.seed)
    names = {"": files[0]} if len(files) == 1 else names_of_paths(files)
    trained = {Method("restorer", name): file.load(path) for name, path in names.items()}
    return Testbed(motions, manifolds, options.seed, trained)


def _show(options: argparse.Namespace, records: Sequence[Record], *, listed: bool = False) -> None:
    from npss_baselines.manifold.evaluation import table

    form = options.format or ("table" if sys.stdout.isatty() else "json")
    layout = table.listing if listed else table.text
    print(json.dumps(records, indent=2) if form == "json" else layout(records, markdown=form == "markdown"))


def _save(path: Path, figure: Figure) -> None:
    write_figure_atomically(path, figure)
    print(path, file=sys.stderr)
