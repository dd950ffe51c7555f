"""``npss doctor``: what is installed, what is missing for what, and whether this machine computes what it should."""

from __future__ import annotations

import argparse
import platform
from typing import Any

import npss
from npss._metric.golden import GOLDEN, TOLERANCE, computed
from npss.console import installed, table, versions
from npss.extras import EXTRAS, HINT, install_hint


def add_parser(commands: Any) -> None:
    """Add the command to ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "doctor",
        help="check this installation",
        description="List what is installed and what an extra would add, and compute golden values on this machine. "
        "The exit status is 1 if one of them is off.",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the check; exit with 1 if a golden value is off."""
    print(versions("npss", npss.__version__, "numpy"))
    print(f"metric version {npss.METRIC_VERSION}\n{platform.platform()}\n")
    rows = [
        [extra.package, installed(extra.package) or "missing", extra.purpose, install_hint(name)]
        for name, extra in EXTRAS.items()
    ]
    models = ["npss-baselines", installed("npss-baselines") or "missing", "models and data", HINT.format("./baselines")]
    cells = [row if row[1] == "missing" else [*row[:3], ""] for row in [*rows, models]]
    print(table(["package", "version", "for", "to install it"], cells, "llll"))
    values = computed()
    off = [text for text, value in values.items() if not _equal(value, GOLDEN[text])]
    cells = [[f"{value:.12g}", "OFF" if text in off else "equal", text] for text, value in values.items()]
    print(f"\nGolden values, equal to a relative difference of {TOLERANCE:g}:\n")
    print(table(["here", "", "signature"], cells, "rll"))
    if off:
        print(f"\n{len(off)} of {len(values)} values are off: do not trust scores of this machine. {off[0]} should be")
        print(f"{GOLDEN[off[0]]!r}, and is {values[off[0]]!r}. Report it with this output.")
        raise SystemExit(1)
    print(f"\nAll {len(values)} values are equal: scores of this machine can be compared with those of others.")


def _equal(value: float, golden: float) -> bool:
    return abs(value - golden) <= TOLERANCE * abs(golden)
