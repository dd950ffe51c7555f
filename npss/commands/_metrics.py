"""The option for metrics other than NPSS and the Euler error."""

from __future__ import annotations

import argparse

from npss._metric.registry import EULER_ERROR, METRICS, NPSS


def add_metrics(parser: argparse.ArgumentParser) -> None:
    """Add the option ``--metrics``.

    Parameters
    ----------
    parser : ArgumentParser
        The parser of the command.
    """
    others = ", ".join(name for name in METRICS if name not in (NPSS.name, EULER_ERROR.name))
    parser.add_argument(
        "--metrics",
        nargs="+",
        default=(),
        metavar="NAME",
        help=f"also measure by these metrics: {others}, or any other registered metric",
    )
