"""``npss compare``: test whether the results of one model are better than those of another."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from npss._analysis.compare import Comparison, compare
from npss._metric.convention import CONVENTIONS
from npss._metric.registry import METRICS, NPSS
from npss.commands._leaderboard import add_groups, add_protocol, context_of, groups_of
from npss.files._formats import listed
from npss.files._samples import add_max_size, features_of
from npss.ranking._submissions import blocks_of, described, millimetres, naming, read_submissions, verified

_LEVEL = 0.95  # of intervals

_DESCRIPTION = """\
Test whether the results of one model are better than those of another, for each condition: the difference of their
scores, a confidence interval and a p-value (paired sign-flip test over blocks of sequences).

  npss compare A B        two {samples} files of results, or folders of .npy files, with the same ground truth
"""


def add_parser(commands: Any) -> None:
    """Add the command to ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "compare",
        help="test whether one model is better than another",
        description=_DESCRIPTION.format(samples=listed("samples")),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("a", type=Path, metavar="A", help="the results of one model")
    parser.add_argument("b", type=Path, metavar="B", help="the results of the other")
    parser.add_argument(
        "--metric", choices=tuple(METRICS), default=NPSS.name, help="compare by this metric (default: %(default)s)"
    )
    parser.add_argument(
        "--convention",
        choices=tuple(CONVENTIONS),
        help="compare by NPSS of this convention only (default: all)",
    )
    parser.add_argument(
        "--at-ms", type=float, metavar="MS", help="compare by a metric with times at this time, in milliseconds"
    )
    parser.add_argument(
        "--format", choices=("text", "json"), default="text", help="set the format of the output (default: %(default)s)"
    )
    add_protocol(parser)
    add_groups(parser)
    add_max_size(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Print the comparisons."""
    submissions = read_submissions([options.a, options.b], max_size=options.max_size)
    if len(submissions) != 2:
        raise ValueError(f"expected the results of two models, got {len(submissions)}: {', '.join(submissions)}")
    (name_a, a), (name_b, b) = submissions.items()
    if missing := a.keys() ^ b.keys():
        raise ValueError(f"only one of {name_a!r} and {name_b!r} has {', '.join(sorted(missing))}")
    if options.convention and options.metric != NPSS.name:
        raise ValueError(f"--convention: {options.metric} has none; leave it out")
    conventions = [options.convention] if options.convention else list(CONVENTIONS)
    groups, context = groups_of(options), context_of(options)
    found = []
    for condition, pair in a.items():
        fps, described_as = described(pair, context)
        stated = {"unwrap": "off", **described_as}
        if verification := verified(pair, pair if pair.meta is None else None, stated.get("protocol"), fps):
            stated |= verification.stated
        gt, pred_a = features_of(pair)
        pred_b = features_of(b[condition])[1]
        if METRICS[options.metric].takes == "positions" and pair.meta is not None:
            (gt, pred_a), pred_b = millimetres(pair, options.metric), millimetres(b[condition], options.metric)[1]
        for convention in conventions if options.metric == NPSS.name else (None,):
            chosen: dict[str, Any] = {} if convention is None else {"convention": convention}
            with naming(f"{name_a} and {name_b}", condition):
                comparison = compare(
                    gt,
                    pred_a,
                    pred_b,
                    metric=options.metric,
                    fps=fps,
                    at_ms=options.at_ms,
                    groups=blocks_of(pair, condition, groups, stated),
                    **chosen,
                    **stated,
                )
            found.append((condition, convention, comparison))
    if options.format == "json":
        print(json.dumps([_record(condition, name_a, name_b, of) for condition, _, of in found], indent=2))
    else:
        print(f"a: {name_a}\nb: {name_b}\n")
        print("\n\n".join(_text(condition, convention, comparison) for condition, convention, comparison in found))


def _text(condition: str, convention: str | None, comparison: Comparison) -> str:
    return f"{condition}{f', {convention}' if convention else ''}\n{comparison}"


def _record(condition: str, name_a: str, name_b: str, comparison: Comparison) -> dict[str, Any]:
    interval = None if comparison.p_value is None else list(comparison.interval(level=_LEVEL))
    return {
        "condition": condition,
        "a": {"model": name_a, "score": comparison.a_in_blocks},
        "b": {"model": name_b, "score": comparison.b_in_blocks},
        "difference": comparison.difference,
        "level": _LEVEL,
        "interval": interval,
        "p_value": comparison.p_value,
        "blocks": comparison.n,
        "better": comparison.better,
        "signature": comparison.signature,
    }
