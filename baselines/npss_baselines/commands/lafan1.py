"""``npss-baselines lafan1``: the baselines of in-betweening, from BVH files to the rows of its tables."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from npss.console import Progress
from npss.files import check_output, write_samples
from npss.inbetweening import BASELINES, Statistics, forward, measure, table, train_statistics, transition, windows
from npss.protocol import InBetweening, lafan1
from npss.records import Record
from npss_baselines.data.transition_clips import Clip, bones_differ, read_clip, read_clips

_DESCRIPTION = """\
Cut windows from BVH files, compute the statistics of the training windows, and measure both baselines of in-betweening
(zero-velocity and interpolation) by L2Q, L2P and NPSS.

  npss-baselines lafan1 --bvh DIR        LaFAN1's files, NAME_subjectN.bvh: subjects 1-4 train, subject 5 tests;
                                         published rows beside the baselines if the windows are the benchmark's
  npss-baselines lafan1 --bvh DIR --name mine --train 'a*.bvh' --test 'b*.bvh' --facing z
                                         other files, with the same or other windows, under a name of your own
"""

_SUBJECT = re.compile(r"subject(\d+)", re.IGNORECASE)
_OTHERS = ("train", "test", "fps", "facing", "past", "future", "transitions", "train_windows", "test_windows")


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss-baselines``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "lafan1",
        help="measure the baselines of in-betweening",
        description=_DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--bvh", type=Path, required=True, metavar="DIR", help="read the BVH files in this folder")
    parser.add_argument(
        "--stats",
        type=Path,
        metavar="FILE",
        help="write mean and std of the training windows, for L2P, to this .npz file",
    )
    parser.add_argument(
        "--format",
        choices=("text", "markdown", "json"),
        default="text",
        help="set the format of the output (default: %(default)s)",
    )
    parser.add_argument("--sequences", action="store_true", help="also store the values of single windows in JSON")
    others = parser.add_argument_group("other files and windows", "Each needs --name.")
    others.add_argument("--name", metavar="NAME", help="name the protocol in signatures")
    for part in ("train", "test"):
        others.add_argument(
            f"--{part}", nargs="+", metavar="PATTERN", help=f"choose the {part} files in DIR, such as 'walk/*.bvh'"
        )
        length, step = lafan1.cut("train" if part == "train" else "test")
        others.add_argument(
            f"--{part}-windows",
            nargs=2,
            type=int,
            metavar=("LENGTH", "STEP"),
            help=f"cut {part} windows of LENGTH frames every STEP (default: {length} {step})",
        )
    others.add_argument(
        "--fps", type=float, metavar="N", help="keep N frames per second: every frame, or every second, third ... one"
    )
    others.add_argument(
        "--facing", choices=("x", "y", "z"), help=f"set the root's axis that points forwards (default: {lafan1.facing})"
    )
    others.add_argument("--past", type=int, metavar="N", help=f"set the frames before (default: {lafan1.past})")
    others.add_argument("--future", type=int, metavar="N", help=f"set the frames after (default: {lafan1.future})")
    others.add_argument(
        "--transitions",
        nargs="+",
        type=int,
        metavar="N",
        help=f"set the lengths of transitions (default: {' '.join(map(str, lafan1.transitions))})",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the rows; write the statistics if requested."""
    if options.stats:
        check_output(options.stats)
    if options.name is None and (given := [name for name in _OTHERS if getattr(options, name) is not None]):
        raise ValueError(f"--{given[0].replace('_', '-')}: not the benchmark's; give --name NAME, a name of your own")
    train, test = _files(options)
    first = read_clip(train[0], fps=options.fps)
    protocol = lafan1 if options.name is None else _protocol(options, first)
    if len(first.skeleton.names) != protocol.joints:
        raise ValueError(f"{first.path}: {protocol.name} has {protocol.joints} joints, got {len(first.skeleton.names)}")
    clips = _Clips(first, protocol.fps)
    stats = train_statistics((clip.motion for clip in clips.read(train)), first.skeleton, protocol=protocol)
    if options.stats:
        write_samples(options.stats, stats._asdict())
    tested = list(clips.read(test))
    records = _rows(tested, first, stats, protocol, sequences=options.sequences)
    if options.format == "json":
        print(json.dumps(records, indent=2))
    else:
        counts = f"{_number(tested, protocol)} test windows of {len(test)} files, statistics of {len(train)}"
        notes = [f"{protocol.name}: {counts}"]
        if clips.other_bones:
            many = "" if len(clips.other_bones) == 1 else f" and {len(clips.other_bones) - 1} more"
            notes.append(f"Bones of {clips.other_bones[0]}{many} differ; all have those of {first.path}.")
        print("\n\n".join([*notes, *_text(records, protocol, markdown=options.format == "markdown")]))


@dataclass
class _Clips:
    """Files of one skeleton; the names of those with other bones are kept."""

    like: Clip
    fps: float

    def __post_init__(self) -> None:
        self.other_bones: list[Path] = []

    def read(self, paths: Sequence[Path]) -> Iterator[Clip]:
        with Progress(f"reading {len(paths)} files") as progress:
            for done, clip in enumerate(read_clips(paths, like=self.like, fps=self.fps), 1):
                if bones_differ(clip, self.like):
                    self.other_bones.append(clip.path)
                yield clip
                progress(done / len(paths))


def _files(options: argparse.Namespace) -> tuple[list[Path], list[Path]]:
    """Return the files of training and test clips."""
    if not options.bvh.is_dir():
        raise ValueError(f"--bvh {options.bvh}: expected a folder")
    chosen = {}
    for part, subjects in (("train", lafan1.train_subjects), ("test", lafan1.test_subjects)):
        if options.name is None:
            files = [path for path in sorted(options.bvh.rglob("*.bvh")) if _subject(path) in subjects]
            wanted = f"NAME_subjectN.bvh, N of {', '.join(map(str, subjects))}"
        else:
            if not (patterns := getattr(options, part)):
                raise ValueError(f"--{part}: expected patterns of files, which --name needs")
            files = sorted({path for pattern in patterns for path in options.bvh.glob(pattern) if path.is_file()})
            wanted = " ".join(patterns)
        if not files:
            raise ValueError(f"--bvh {options.bvh}: no files to {part}: {wanted}")
        chosen[part] = files
    if both := sorted({*chosen["train"]} & {*chosen["test"]}):
        raise ValueError(f"--test: {both[0]} is also a training file")
    return chosen["train"], chosen["test"]


def _subject(path: Path) -> int | None:
    match = _SUBJECT.search(path.stem)
    return int(match[1]) if match else None


def _protocol(options: argparse.Namespace, first: Clip) -> InBetweening:
    """Return a protocol of the user's own."""
    given = {name: getattr(options, name) for name in ("facing", "past", "future", "transitions")}
    changed: dict[str, Any] = {name: value for name, value in given.items() if value is not None}
    for part in ("train", "test"):
        if cut := getattr(options, f"{part}_windows"):
            changed |= {f"{part}_length": cut[0], f"{part}_step": cut[1]}
    changed |= {"windows": None, "zero_velocity": {}, "train_subjects": (), "test_subjects": ()}
    return replace(lafan1, name=options.name, joints=len(first.skeleton.names), fps=first.fps, **changed)


def _rows(
    clips: Sequence[Clip], first: Clip, stats: Statistics, protocol: InBetweening, *, sequences: bool
) -> list[Record]:
    """Measure both baselines on every transition."""
    cut = windows([clip.motion for clip in clips], protocol=protocol)
    groups = [clip.path.stem for clip in clips for _ in protocol.starts(len(clip.motion.root))]
    records = []
    with Progress("measuring") as progress:
        for n in protocol.transitions:
            parts = transition(cut, n, protocol=protocol)
            gt = forward(parts.truth, first.skeleton)
            past = forward(parts.past, first.skeleton).quaternions[:, -1]
            for name, predict in BASELINES.items():
                pred = forward(predict(parts), first.skeleton)
                how: dict[str, Any] = {"stats": stats, "past": past, "protocol": protocol, "model": name}
                if sequences:
                    how |= {"sequences": True, "groups": groups}
                records.append(measure(gt, pred, **how))
                progress(len(records) / (len(protocol.transitions) * len(BASELINES)))
    return records


def _number(clips: Sequence[Clip], protocol: InBetweening) -> int:
    """Return the number of test windows."""
    return int(np.sum([len(protocol.starts(len(clip.motion.root))) for clip in clips]))


def _text(records: Sequence[Record], protocol: InBetweening, *, markdown: bool) -> Iterator[str]:
    """Yield the table, with published rows only if the ground truth is the benchmark's."""
    findings = list(dict.fromkeys(found for record in records for found in record["verification"]["findings"]))
    yield table(records, published=protocol == lafan1 and not findings, markdown=markdown)
    if findings:
        yield "\n".join(
            ["Published rows are left out, since this is another ground truth:", *(f"- {f}" for f in findings)]
        )
