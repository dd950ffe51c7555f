"""``npss score``: score files, by every convention unless one is named."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, get_args

import numpy as np

from npss import stochastic
from npss._analysis.diagnose import diagnose
from npss._metric.convention import CONVENTIONS, ConventionName
from npss._metric.euler_error import euler_error_curve
from npss._metric.fields import FIELDS, Value
from npss._metric.metric import Metric
from npss._metric.registry import EULER_ERROR, METRICS, NPSS
from npss._metric.signature import parse_signature
from npss.commands._metrics import add_metrics
from npss.console._tables import markdown_code, markdown_text, table
from npss.files._arrays import naming_file
from npss.files._formats import listed
from npss.files._results import read_results
from npss.files._samples import Pair, add_max_size, converted, read_pair
from npss.protocol import FPS, VERIFIED
from npss.ranking._submissions import described, positions_for, times_of, verified
from npss.records import Record, measure, signature_of
from npss.rotations._unwrap import unwrap
from npss.stochastic._score import Reduction
from npss.validation import Array, motion_pair

_DESCRIPTION = """\
Score a prediction against its ground truth.

  npss score GT PRED      two {array} files, (N, T, D), (T, D) or (N, T, J, C) (with --representation matrix,
                          (N, T, J, 3, 3)); or two {arrays} files, whose arrays pair by name (--key
                          chooses one; single values, text and Python objects are ignored)
  npss score RESULTS      one {samples} file of CONDITION/gt and CONDITION/pred with a meta, or a folder of
                          CONDITION_gt.npy and CONDITION_pred.npy; or of expmap/gt/ACTION_i and expmap/preds/ACTION_i,
                          each (T, 99): Human3.6M exponential maps at 25 frames per second, with the Euler error

Give the files before the options. Without --convention, all three scores are printed (paper, released and literal);
they are not comparable with each other.
"""


def add_parser(commands: Any) -> None:
    """Add the command to ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "score",
        help="score motion files",
        description=_DESCRIPTION.format(array=listed("array"), arrays=listed("arrays"), samples=listed("samples")),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="GT and PRED, or RESULTS alone")
    parser.add_argument("--convention", choices=tuple(CONVENTIONS), help="score by this convention only (default: all)")
    parser.add_argument(
        "--format",
        choices=("text", "json", "markdown"),
        default="text",
        help="set the format of the output (default: %(default)s)",
    )
    parser.add_argument(
        "--expmap",
        action="store_true",
        help="convert GT and PRED from Human3.6M exponential maps (99 columns) to Euler angles first",
    )
    parser.add_argument("--key", metavar="NAME", help="score only the arrays of this name (default: all)")
    parser.add_argument("--representation", metavar="NAME", help="state in the signature what the features are")
    parser.add_argument(
        "--quaternions",
        choices=tuple(FIELDS["quaternions"].means),
        help="state in the signature how the signs of quaternions were chosen",
    )
    parser.add_argument(
        "--protocol",
        metavar="NAME",
        help="state in the signature which test windows these are; "
        f"{', '.join(VERIFIED)}: also compare the ground truth to theirs, and stand beside no published rows if it is "
        "another; other names are unverified",
    )
    parser.add_argument(
        "--fps", type=float, metavar="N", help="state the frames per second, which --edges-ms and --at-ms need"
    )
    parser.add_argument(
        "--edges-ms",
        type=float,
        nargs="+",
        default=(),
        metavar="MS",
        help="also score the windows between these edges, in milliseconds",
    )
    parser.add_argument(
        "--at-ms",
        type=float,
        nargs="+",
        default=(),
        metavar="MS",
        help="print the Euler error at these times, in milliseconds",
    )
    add_metrics(parser)
    parser.add_argument(
        "--unwrap",
        choices=("off", "target"),
        default="off",
        help="remove jumps of 2 pi before scoring (default: %(default)s)",
    )
    parser.add_argument(
        "--workers", type=int, default=1, metavar="N", help="use N threads, -1 for all CPUs (default: %(default)s)"
    )
    add_max_size(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the scores."""
    records = _records(options)
    if options.format == "json":
        print(json.dumps(records, indent=2))
    else:
        print("\n\n".join(_text(record, markdown=options.format == "markdown") for record in records))


def _records(options: argparse.Namespace) -> list[Record]:
    context: dict[str, Value] = {"protocol": options.protocol} if options.protocol else {}
    for name in ("representation", "quaternions"):
        if getattr(options, name):
            context[name] = getattr(options, name)
    fps, samples = options.fps, len(options.files) == 1
    if samples:
        if options.key is not None:
            raise ValueError(f"--key chooses an array of GT and PRED, but {options.files[0]} is a file of results")
        if options.expmap or options.representation or options.quaternions or fps is not None:
            raise ValueError(
                f"{options.files[0]}: a meta states what results are, and samples are Human3.6M exponential maps at "
                f"{FPS} frames per second, converted to Euler angles; leave out --expmap, --representation, "
                "--quaternions and --fps"
            )
        poses = read_results(*options.files, max_size=options.max_size)
        if poses[0].meta is not None:
            with naming_file(*options.files):
                return [_of_results(pair, options, context) for pair in poses]
        with naming_file(*options.files):
            pairs = [converted(pair) for pair in poses]
        fps = FPS
    elif len(options.files) == 2:
        poses = pairs = read_pair(*options.files, key=options.key, max_size=options.max_size)
        if options.expmap:
            if options.representation:
                raise ValueError("--representation: --expmap implies euler; leave it out")
            pairs = [converted(pair) for pair in pairs]
    else:
        raise ValueError(f"expected GT and PRED, or RESULTS alone, got {len(options.files)} files")
    if samples or options.expmap:
        context["representation"] = "euler"
    advice = "; --key NAME scores a single array" if len(pairs) > 1 and not samples else ""
    sources = poses if samples or options.expmap else [None] * len(pairs)
    return [
        _record(pair, pose, options, fps, samples, context, advice) for pair, pose in zip(pairs, sources, strict=True)
    ]


def _of_results(pair: Pair, options: argparse.Namespace, context: dict[str, Value]) -> Record:
    """Return the record of a condition, which its meta describes."""
    fps, stated = described(pair, context)
    is_euler = stated.get("representation") == "euler"
    record = _record(pair, None, options, fps, is_euler and fps is not None, stated, "")
    if pair.samples is not None:
        of_samples = {"fps": fps, "unwrap": "off", **stated}
        if verification := verified(pair, None, stated.get("protocol"), fps):
            of_samples |= verification.stated
        record["samples"] = _of_samples(pair, pair.samples, tuple(record["npss"]), options, of_samples)
    return record


def _of_samples(
    pair: Pair, samples: Array, conventions: Sequence[ConventionName], options: argparse.Namespace, stated: Any
) -> list[Record]:
    """Return the NPSS of several samples of each sequence, by convention and reduction."""
    if options.unwrap != "off":
        raise ValueError(f"--unwrap: not for the samples of {pair.name}; leave it out, or the samples")
    scored = []
    for convention in conventions:
        for reduction in get_args(Reduction):
            report = stochastic.report(pair.gt, samples, reduction=reduction, convention=convention, **stated)
            scored.append(
                {
                    "n": len(samples),
                    "reduction": reduction,
                    "convention": convention,
                    "npss": report.score,
                    "signature": report.signature,
                }
            )
    return scored


def _record(
    pair: Pair,
    poses: Pair | None,
    options: argparse.Namespace,
    fps: float | None,
    samples: bool,
    context: dict[str, Any],
    advice: str,
) -> Record:
    n_frames = pair.gt.shape[-2 if pair.gt.ndim == 2 else 1] if pair.gt.ndim > 1 else 0
    times, protocol = options.at_ms, context.get("protocol")
    if not times and (samples or pair.meta is not None):
        times = times_of(is_euler=samples, metrics=options.metrics, fps=fps, n_frames=n_frames)
    try:
        verification = verified(pair, poses, protocol, fps)
        record = measure(
            pair.gt,
            pair.pred,
            conventions=(options.convention,) if options.convention else tuple(CONVENTIONS),
            fps=fps,
            at_ms=times,
            angles=pair.meta is None or pair.meta.representation == "euler",
            edges_ms=options.edges_ms,
            metrics=options.metrics,
            poses=None if poses is None else (poses.gt, poses.pred),
            positions=positions_for(pair, options.metrics),
            unwrapped=options.unwrap,
            workers=options.workers,
            frames=n_frames,
            **context,
            **({} if verification is None else verification.stated),
        )
    except (TypeError, ValueError) as error:
        of_an_option = str(error).partition(":")[0] in vars(options)
        where = "" if pair.name is None or of_an_option else f"{pair.name}: "
        raise type(error)(f"{where}{error}{'' if of_an_option else advice}") from error
    if protocol is not None:
        unverified = {"protocol": protocol, "ok": None}
        record["verification"] = unverified if verification is None else verification.as_dict()
    motions = motion_pair(pair.gt, pair.pred, context.get("representation"))
    if options.unwrap != "off":
        motions = unwrap(motions[0]), unwrap(motions[1])
    record["diagnosis"] = [str(finding) for finding in diagnose(*motions, convention=options.convention or "paper")]
    if pair.stored_curve is not None and not record.get("still"):
        curve = euler_error_curve(pair.gt, pair.pred)
        record["stored_curve_difference"] = float(np.abs(curve - pair.stored_curve).max())
    return record if pair.name is None else {"action": pair.name, **record}


def _verdict(verification: dict[str, Any]) -> list[str]:
    """Say whether the scores may stand beside published ones."""
    protocol = verification["protocol"]
    if verification["ok"] is None:
        return [f"Protocol {protocol}: unverified; names that are verified: {', '.join(VERIFIED)}."]
    if verification["ok"]:
        return [f"Protocol {protocol}: verified: {'; '.join(verification['agrees'])}."]
    if verification["findings"]:
        lines = [f"Protocol {protocol}: NOT its ground truth, so these scores must not stand beside published ones:"]
    else:
        lines = [f"Protocol {protocol}: undecided whether this is its ground truth:"]
    return lines + [f"- {sentence}" for sentence in (*verification["findings"], *verification["undecided"])]


def _text(record: Record, *, markdown: bool) -> str:
    signatures = record["signatures"]
    rows = [[NPSS.heading, name, _rounded(NPSS, value), signatures[name]] for name, value in record["npss"].items()]
    for name, windows in record.get("npss_windows", {}).items():
        for window, value in windows.items():
            signature = signature_of(record, NPSS.name, name, window=window)
            rows.append([NPSS.column(window=window), name, _rounded(NPSS, value), signature])
    for time, value in record.get("euler_error", {}).items():
        rows.append([EULER_ERROR.column(at_ms=time), "", _rounded(EULER_ERROR, value), signatures[EULER_ERROR.name]])
    for column, value in record.get("metrics", {}).items():
        metric = METRICS[parse_signature(signatures[column])["metric"]]
        rows.append([column, "", _rounded(metric, value), signatures[column]])
    for one in record.get("samples", ()):
        heading = f"{NPSS.heading}, {one['reduction']} of {one['n']} samples"
        rows.append([heading, one["convention"], _rounded(NPSS, one["npss"]), one["signature"]])
    if markdown:
        rows = [[*row[:3], markdown_code(row[3]).replace("|", "\\|")] for row in rows]
    lines = [table(["metric", "convention", "value", "signature"], rows, "llrl", markdown=markdown)]
    if "action" in record:
        lines.insert(0, f"### {markdown_text(record['action'])}\n" if markdown else record["action"])
    if "still" in record:
        still = ", ".join(map(str, record["still"]))
        lines.append(f"\nNo Euler error, since nothing moves in the ground truth: sequence {still}.")
    if "stored_curve_difference" in record:
        difference = record["stored_curve_difference"]
        verdict = "reproduced" if difference < 1e-6 else "NOT reproduced"
        lines.append(f"\nThe file's own Euler error curve is {verdict}: largest difference {difference:.1e} rad.")
    if "verification" in record:
        lines += ["", *(markdown_text(line) if markdown else line for line in _verdict(record["verification"]))]
    if record["diagnosis"]:
        lines.append("\nDiagnosis:")
        lines += [f"- {finding}" for finding in record["diagnosis"]]
    return "\n".join(lines)


def _rounded(metric: Metric, value: float) -> str:
    return f"{value:.{4 if metric.digits is None else metric.digits}f}"
