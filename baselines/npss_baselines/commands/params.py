"""``npss-baselines params``: count the models' parameters."""

from __future__ import annotations

import argparse
import json
import sys
from dataclasses import replace
from typing import Any

from npss.console import table

#: Width of the label, for models whose published count is of more than one action.
_ACTIONS = {"mbr-sup": 15}


def records() -> list[dict[str, Any]]:
    """Count the trained parameters of each model; VTLN models with either Body cell, as coded and as printed.

    Returns
    -------
    list of dict
        ``model``, ``cell``, ``actions`` (the width of the label), ``parameters``, ``published`` (None if unpublished).

    Examples
    --------
    >>> [record["parameters"] for record in records() if record["model"] in ("erd", "lstm-3lr")]
    [14842054, 20282054]
    """
    # Imported here: other commands need no torch.
    from npss_baselines.models import MODELS
    from npss_baselines.models.vtln import VTLNConfig

    counts = []
    for name, spec in MODELS.items():
        if isinstance(spec.config, VTLNConfig):
            variants = [(cell, replace(spec.config, cell=cell)) for cell in ("code", "text")]
        else:
            variants = [(spec.cell, spec.config)]
        for cell, config in variants:
            n_actions = _ACTIONS.get(name, 1)
            n = spec.parameters(n_actions, config=config)
            counts.append(
                {"model": name, "cell": cell, "actions": n_actions, "parameters": n, "published": spec.published}
            )
    return counts


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss-baselines``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "params",
        help="count the models' parameters",
        description="Count the models' parameters, beside the counts in Table 1 of the NPSS paper.",
    )
    parser.add_argument(
        "--format",
        choices=("table", "json"),
        help="set the format of the output (default: table on a terminal, else json)",
    )
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the counts."""
    counts = records()
    if (options.format or ("table" if sys.stdout.isatty() else "json")) == "json":
        print(json.dumps(counts, indent=2))
        return
    rows = []
    for record in counts:
        published, n = record["published"], record["parameters"]
        compared = ["", ""] if published is None else [f"{published:,}", f"{n - published:+,}"]
        rows.append([record["model"], record["cell"], str(record["actions"]), f"{n:,}", *compared])
    print(table(["model", "cell", "actions", "parameters", "Table 1", "difference"], rows, "llrrrr"))
