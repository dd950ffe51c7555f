"""``npss-baselines manifold``: the uses of a trained manifold, each with its numbers and its picture."""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from npss.files import doing, write_figure_atomically
from npss.ranking import names_of_paths

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from npss.records import Record
    from npss_baselines.manifold.evaluation.testbed import Bench

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
    uses = parser.add_subparsers(title="uses", required=True, metavar="USE")
    for use, what in _RESTORE.items():
        restore = _use(uses, use, f"restore {what}", run_restoration)
        restore.add_argument("--clip", metavar="CLIP", help="of held-out subjects: what to draw (default: the first)")
        restore.set_defaults(use=use)
    interpolate = _use(uses, "interpolate", "between two motions, in the hidden space", run_interpolation)
    interpolate.add_argument(
        "--clips",
        nargs=2,
        metavar="CLIP",
        help="which two (default: pairs of held-out windows; drawn, 13_30 and a walk)",
    )
    _use(uses, "sample", "motion from codes drawn at random", run_sampling)
    filters = _use(uses, "filters", "the motion that excites a hidden unit", run_filters)
    filters.add_argument("--units", nargs="+", type=int, metavar="N", help="what to draw (default: what varies most)")
    distance = _use(uses, "distance", "the distance G of two clips", run_distance)
    distance.add_argument("clips", nargs=2, metavar="CLIP")
    nearest = _use(
        uses, "nearest", "how well G finds clips of the same action, or the clips nearest to one", run_nearest
    )
    nearest.add_argument("--clip", metavar="CLIP", help="show what is nearest to this one instead")
    nearest.add_argument("-n", type=int, default=5, metavar="N", help="clips to show (default: 5)")
    table = _use(uses, "table", "every number of every use", run_table, several=True)
    table.add_argument("--pictures", type=Path, metavar="DIR", help="draw all of them, too, into this folder")


def _use(uses: Any, name: str, what: str, run: Any, *, several: bool = False) -> argparse.ArgumentParser:
    parser: argparse.ArgumentParser = uses.add_parser(name, help=what, description=what[0].upper() + what[1:] + ".")
    parser.add_argument("runs", nargs="+" if several else 1, type=Path, metavar="RUN", help="the folder of a run")
    for option, where in (
        ("--cmu", "CMU's clips: NN/NN_NN.bvh and clips.csv"),
        ("--styles", "more of CMU's dances and martial arts"),
        ("--h36m", "Human3.6M's dataset/"),
    ):
        parser.add_argument(option, type=Path, metavar="DIR", help=f"the folder of {where}")
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
    from npss_baselines.manifold.evaluation import measure as evaluation
    from npss_baselines.manifold.show import figures as gallery

    bench = _bench(options)
    _show(options, list(evaluation.restoration(bench, options.use)))
    if options.output:
        _save(options.output, gallery.restoration(bench, options.use, clip=options.clip))


def run_interpolation(options: argparse.Namespace) -> None:
    """Print what interpolation is worth, and draw one."""
    from npss_baselines.manifold.evaluation import measure as evaluation
    from npss_baselines.manifold.show import figures as gallery

    bench = _bench(options)
    clips = options.clips and [gallery.clip_named(bench.motions, clip) for clip in options.clips]
    _show(options, list(evaluation.interpolation(bench, clips)))
    if options.output:
        _save(options.output, gallery.interpolation(bench, clips))


def run_sampling(options: argparse.Namespace) -> None:
    """Print what samples are worth, and draw some."""
    from npss_baselines.manifold.evaluation import measure as evaluation
    from npss_baselines.manifold.show import figures as gallery

    bench = _bench(options)
    _show(options, list(evaluation.sampling(bench)))
    if options.output:
        _save(options.output, gallery.samples(bench))


def run_filters(options: argparse.Namespace) -> None:
    """Print what hidden units do, and draw some."""
    from npss_baselines.manifold.evaluation import measure as evaluation
    from npss_baselines.manifold.show import figures as gallery

    bench = _bench(options)
    _show(options, list(evaluation.filtering(bench)))
    if options.output:
        _save(options.output, gallery.filters(bench, options.units))


def run_distance(options: argparse.Namespace) -> None:
    """Print how far two clips are from each other, and draw them."""
    from npss_baselines.manifold.evaluation import measure as evaluation
    from npss_baselines.manifold.show import figures as gallery

    bench = _bench(options)
    clips = [gallery.clip_named(bench.motions, clip) for clip in options.clips]
    records = list(evaluation.distance(bench, *clips))
    _show(options, records, listed=True)
    if options.output:
        said = (f"{record['metric']} by {record['method']}: {record['value']:.4g}" for record in records)
        _save(options.output, gallery.whole_clips(bench.motions, clips, ", ".join(said)))


def run_nearest(options: argparse.Namespace) -> None:
    """Print the clips that are nearest to one, or how well nearest clips are of the same action; and draw it."""
    from npss_baselines.manifold.evaluation import measure as evaluation
    from npss_baselines.manifold.show import figures as gallery

    bench = _bench(options)
    if options.clip is None:
        records = list(evaluation.nearness(bench))
        if not records:
            raise ValueError(
                "no two actions among these clips, so there is nothing to tell apart; name a CLIP, or other motion"
            )
        _show(options, records)
        if options.output:
            _save(options.output, gallery.retrieval(records))
        return
    query = gallery.clip_named(bench.motions, options.clip)
    ranked = list(evaluation.ranking(bench, query, options.n))
    _show(options, ranked, listed=True)
    if options.output:
        name = next(iter(bench.manifolds))
        clips = [query, *(record["index"] for record in ranked if record["method"] == name)]
        _save(options.output, gallery.whole_clips(bench.motions, clips, f"nearest to the first by G of {name}"))


def run_table(options: argparse.Namespace) -> None:
    """Print every number, and draw every picture."""
    from npss_baselines.manifold.evaluation import table
    from npss_baselines.manifold.show import figures as gallery

    bench = _bench(options)
    records = list(table.records_of(bench))
    _show(options, records)
    if options.pictures:
        with doing("making the folder of the pictures"):
            options.pictures.mkdir(parents=True, exist_ok=True)
        for name, figure in gallery.all_pictures(bench, records):
            _save(options.pictures / f"{name}.png", figure)


def _bench(options: argparse.Namespace) -> Bench:
    """Load the runs, and the motion."""
    from npss_baselines.manifold.evaluation.testbed import TAKEN, Bench
    from npss_baselines.manifold.motion.prepared import motion_set
    from npss_baselines.manifold.training.folder import load

    runs = {"manifold": options.runs[0]} if len(options.runs) == 1 else names_of_paths(options.runs, taken=TAKEN)
    manifolds = {name: load(run).projector for name, run in runs.items()}
    motions = motion_set(options.cmu, options.styles, options.h36m, cache=options.cache, quick=options.quick)
    return Bench(motions, manifolds, options.seed)


def _show(options: argparse.Namespace, records: Sequence[Record], *, listed: bool = False) -> None:
    from npss_baselines.manifold.evaluation import table

    form = options.format or ("table" if sys.stdout.isatty() else "json")
    laid_out = table.listing if listed else table.text
    print(json.dumps(records, indent=2) if form == "json" else laid_out(records, markdown=form == "markdown"))


def _save(path: Path, figure: Figure) -> None:
    write_figure_atomically(path, figure)
    print(path, file=sys.stderr)
