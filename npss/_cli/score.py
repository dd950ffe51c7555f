"""``npss score``: the score of files, under every convention unless one is named."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np

from npss._cli import files
from npss._convention import CONVENTIONS
from npss._euler_error import euler_error_curve
from npss._poses import poses_to_euler
from npss._records import Record, measure, signature_of
from npss._signature import Value
from npss._tables import table
from npss.protocol import SLICES_MS

_DESCRIPTION = """\
Score a prediction against its ground truth.

  npss score GT PRED      two .npy files, (N, T, D) or (T, D); or two .npz files, whose arrays pair by name
  npss score SAMPLES      one .h5 or .npz file of expmap/gt/ACTION_i and expmap/preds/ACTION_i, each (T, 99):
                          Human3.6M exponential maps at 25 frames per second; the Euler error is printed, too

Without --convention, the score is shown under each of paper, released and literal: they are different numbers.
"""


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "score",
        help="score files of motion",
        description=_DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="GT and PRED, or SAMPLES alone")
    parser.add_argument("--convention", choices=tuple(CONVENTIONS), help="score by this convention alone")
    parser.add_argument("--format", choices=("text", "json", "markdown"), default="text")
    parser.add_argument(
        "--expmap",
        action="store_true",
        help="GT and PRED hold Human3.6M exponential maps (99 columns): convert them to Euler angles first",
    )
    parser.add_argument("--representation", help="what the arrays hold, to be stated in the signature")
    parser.add_argument("--protocol", help="which test windows these are, to be stated in the signature")
    parser.add_argument("--fps", type=float, help="frames per second, to be stated in the signature")
    parser.add_argument(
        "--windows", type=float, nargs="+", default=(), metavar="S", help="score windows with these edges in seconds"
    )
    parser.add_argument(
        "--at-ms", type=int, nargs="+", default=(), metavar="MS", help="Euler error at these times in milliseconds"
    )
    parser.add_argument(
        "--unwrap",
        choices=("off", "target"),
        default="off",
        help="remove jumps of 2 pi before scoring (not done by default)",
    )
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
    if options.representation:
        context["representation"] = options.representation
    fps, at_ms = options.fps, options.at_ms
    if len(options.files) == 2:
        pairs = files.read_pair(*options.files)
        if options.expmap:
            pairs = [pair._replace(gt=poses_to_euler(pair.gt), pred=poses_to_euler(pair.pred)) for pair in pairs]
            context["representation"] = "euler"
    elif len(options.files) == 1:
        pairs = files.read_samples(*options.files)
        context["representation"] = "euler"
        fps = files.SAMPLES_FPS if fps is None else fps
    else:
        raise ValueError(f"expected GT and PRED, or SAMPLES alone, got {len(options.files)} files")
    records = []
    for pair in pairs:
        n_frames = pair.gt.shape[-2] if pair.gt.ndim > 1 else 0
        within = [time for time in SLICES_MS if time * fps <= n_frames * 1000] if len(options.files) == 1 else ()
        measured = measure(
            pair.gt,
            pair.pred,
            conventions=(options.convention,) if options.convention else tuple(CONVENTIONS),
            fps=fps,
            at_ms=at_ms or within,
            edges_s=options.windows,
            unwrapped=options.unwrap,
            frames=n_frames,
            **context,
        )
        record = {"action": pair.name, **measured} if pair.name is not None else measured
        if pair.stored_curve is not None:
            curve = euler_error_curve(pair.gt, pair.pred)
            record["stored_curve_difference"] = float(np.abs(curve - pair.stored_curve).max())
        records.append(record)
    return records


def _text(record: Record, *, markdown: bool) -> str:
    rows = [
        ["NPSS", name, f"{value:.4f}", signature_of(record, "npss", name)] for name, value in record["npss"].items()
    ]
    for name, windows in record.get("npss_windows", {}).items():
        for window, value in windows.items():
            which = signature_of(record, "npss", name, window=window)
            rows.append([f"NPSS {window} s", name, f"{value:.4f}", which])
    for time, value in record.get("euler_error", {}).items():
        rows.append([f"Euler error {time} ms", "", f"{value:.3f}", signature_of(record, "euler_error")])
    if markdown:
        rows = [[*row[:3], "`" + row[3].replace("|", "\\|") + "`"] for row in rows]
    lines = [table(["metric", "convention", "value", "signature"], rows, "llrl", markdown=markdown)]
    if "action" in record:
        lines.insert(0, f"### {record['action']}\n" if markdown else record["action"])
    if "stored_curve_difference" in record:
        difference = record["stored_curve_difference"]
        verdict = "reproduced" if difference < 1e-6 else "NOT reproduced"
        lines.append(f"\nThe file's own Euler error curve is {verdict}: largest difference {difference:.1e} rad.")
    return "\n".join(lines)
