"""``npss diagnose``: look for pitfalls that change scores silently."""

from __future__ import annotations

import argparse
import json
from dataclasses import asdict
from pathlib import Path
from typing import Any

from npss._analysis.diagnose import diagnose
from npss.files._formats import listed
from npss.files._results import read_results
from npss.files._samples import add_max_size, features_of, read_pair

_DESCRIPTION = """\
Look for pitfalls that change scores silently: jumps and flipped signs of rotations, shifted or padded frames, degrees,
swapped axes, features without power. Nothing is repaired.

  npss diagnose RESULTS   one {samples} file of results, or a folder of .npy files
  npss diagnose GT PRED   two {array} files, or two {arrays} files whose arrays pair by name
"""


def add_parser(commands: Any) -> None:
    """Add the command to ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "diagnose",
        help="look for pitfalls in motion files",
        description=_DESCRIPTION.format(samples=listed("samples"), array=listed("array"), arrays=listed("arrays")),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="+", type=Path, metavar="FILE", help="RESULTS alone, or GT and PRED")
    parser.add_argument("--key", metavar="NAME", help="diagnose only the arrays of this name (default: all)")
    parser.add_argument("--representation", metavar="NAME", help="state what the features of GT and PRED are")
    parser.add_argument(
        "--format", choices=("text", "json"), default="text", help="set the format of the output (default: %(default)s)"
    )
    add_max_size(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the findings."""
    if len(options.files) == 1:
        if options.key is not None or options.representation is not None:
            raise ValueError(f"{options.files[0]}: results state what they are; leave out --key and --representation")
        pairs = read_results(*options.files, max_size=options.max_size)
        motions = [features_of(pair) for pair in pairs]
    elif len(options.files) == 2:
        pairs = read_pair(*options.files, key=options.key, max_size=options.max_size)
        motions = [(pair.gt, pair.pred) for pair in pairs]
    else:
        raise ValueError(f"expected RESULTS alone, or GT and PRED, got {len(options.files)} files")
    found = [
        (pair.name, diagnose(gt, pred, representation=options.representation))
        for pair, (gt, pred) in zip(pairs, motions, strict=True)
    ]
    if options.format == "json":
        records = [{"condition": name, "findings": [asdict(finding) for finding in of]} for name, of in found]
        print(json.dumps(records, indent=2))
        return
    for name, findings in found:
        where = "" if name is None else f"{name}: "
        lines = [f"- {finding}" for finding in findings]
        print("\n".join([f"{where}{len(lines) or 'no'} finding{'' if len(lines) == 1 else 's'}", *lines]))
