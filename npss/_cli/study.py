"""``npss study``: the page of a user study, and what its votes tell of models, participants and metrics."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from npss import published
from npss._convention import CONVENTIONS
from npss._records import Record
from npss._submissions import read_records
from npss._tables import table
from npss.study import read_votes
from npss.study._input import ALTERNATIVES
from npss.study._summary import LEVEL, MEANINGS, summary

_DESCRIPTION = """\
Make the page of a user study, and say what its votes tell.

  npss study VOTES [VOTES ...]    CSV files with the columns action, question, sequence, model_a, model_b,
                                  participant, choice (A, B or tie): one of all participants, or one of each.
                                  With scores, also how often each metric agrees with the majority, and the tests
                                  of NPSS against the Euler error
  npss study page DIR -o FILE     a survey as one page of HTML, of the samples in DIR: MODEL.h5 or MODEL.npz

The files come first, then the options.
"""
# The options of each form, which the other has not.
_OF_VOTES = ("scores", "published", "convention", "alternative", "format")
_OF_PAGE = ("output", "questions", "seed", "action")


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "study",
        help="make the page of a user study, evaluate its votes",
        description=_DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("files", nargs="+", metavar="FILE", help="files of votes; or the word page, and a folder")
    votes = parser.add_argument_group("with VOTES")
    scores = votes.add_mutually_exclusive_group()
    scores.add_argument(
        "--scores",
        type=Path,
        metavar="RECORDS",
        help="rank models by these scores: a JSON file, as `python -m baselines evaluate --format json` prints it",
    )
    scores.add_argument(
        "--published", action="store_true", default=None, help="rank models by the tables of the NPSS paper"
    )
    votes.add_argument("--convention", choices=tuple(CONVENTIONS), help="of NPSS, this convention alone")
    votes.add_argument(
        "--alternative",
        choices=ALTERNATIVES,
        help="whether NPSS agrees with the majority more often than the Euler error (greater, the default, as in the "
        "paper), less often, or either",
    )
    votes.add_argument("--format", choices=("text", "json"), help="default: text")
    page = parser.add_argument_group("with page")
    page.add_argument("-o", "--output", type=Path, metavar="FILE", help="where to write the page")
    page.add_argument("--questions", type=int, metavar="N", help="how many questions (default: 20, as in the paper)")
    page.add_argument("--seed", type=int, metavar="N", help="of the generator that draws them (default: 0)")
    page.add_argument("--action", help="which action, where the samples have several in common")
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Write the page, or print what the votes tell."""
    page = len(options.files) == 2 and options.files[0] == "page"
    for name in _OF_VOTES if page else _OF_PAGE:
        if getattr(options, name) is not None:
            raise ValueError(f"--{name} is an option of the other form: see npss study --help")
    if page:
        _write_page(options)
    else:
        _print_votes(options)


def _write_page(options: argparse.Namespace) -> None:
    from npss._pages import survey  # here, not above: votes are counted without it

    if options.output is None:
        raise ValueError("-o FILE says where to write the page")
    n_questions = 20 if options.questions is None else options.questions
    text = survey(Path(options.files[1]), n_questions=n_questions, seed=options.seed or 0, action=options.action)
    options.output.write_text(text, encoding="utf-8")


def _print_votes(options: argparse.Namespace) -> None:
    records = None
    if options.scores is not None:
        records = _read_records(options.scores)
    elif options.published:
        records = published.records()
    elif options.convention or options.alternative:
        raise ValueError("--convention and --alternative are about scores: --scores RECORDS or --published names them")
    told = summary(
        read_votes(*options.files),
        records,
        conventions=(options.convention,) if options.convention else None,
        alternative=options.alternative or ALTERNATIVES[0],
    )
    print(json.dumps(told, indent=2) if options.format == "json" else _text(told))


def _read_records(path: Path) -> list[Record]:
    """Read a file of records; what it must hold of them is seen when they are used."""
    records = read_records(path)
    for index, record in enumerate(records):
        for name in ("model", "action"):
            if not isinstance(record.get(name), str):
                raise ValueError(f"{path}: record {index} does not name its {name}")
        for name in ("npss", "euler_error", "signatures"):
            if not isinstance(record.get(name, {}), dict):
                raise ValueError(f"{path}: record {index}: {name} is no object")
        if not all(isinstance(signature, str) for signature in record.get("signatures", {}).values()):
            raise ValueError(f"{path}: record {index}: its signatures are no texts")
    return records


def _text(told: dict[str, Any]) -> str:
    parts = [_participants(told), _pairs(told["pairs"])]
    if "metrics" in told:
        parts += [_rankings(told["metrics"]), _agreements(told["metrics"])]
    if told.get("comparisons"):
        parts += [*map(_comparison, told["comparisons"]), _notes("binomial_test", "mcnemar_test")]
    return "\n\n".join(parts)


def _notes(*names: str) -> str:
    return "\n".join(f"    {name}: {MEANINGS[name]}" for name in names)


def _participants(told: dict[str, Any]) -> str:
    rows, undefined = [], []
    for name, of in (*told["actions"].items(), ("all", told["overall"])):
        kappa = of["fleiss_kappa"]
        if kappa is None:
            undefined.append(f"    fleiss_kappa of {name} is not defined: {of['fleiss_kappa_undefined']}")
        numbers = [of["questions"], of["participants"], of["votes"], *of["majorities"].values()]
        rows.append([name, *map(str, numbers), "-" if kappa is None else f"{kappa:.3f}"])
    header = ["action", "questions", "participants", "votes", "majority A", "majority B", "tie", "fleiss_kappa"]
    return "\n".join([table(header, rows, "lrrrrrrr"), _notes("majorities", "fleiss_kappa"), *undefined])


def _pairs(pairs: list[dict[str, Any]]) -> str:
    rows = [
        [*pair["models"], str(pair["questions"])]
        + [str(number) for number in (*pair["votes"], pair["tied_votes"])]
        + [str(number) for number in (*pair["majorities"], pair["tied_majorities"])]
        for pair in pairs
    ]
    header = ["first", "second", "questions", "votes first", "second", "tie", "majorities first", "second", "tie"]
    return table(header, rows, "llrrrrrrr")


def _name(metric: str) -> str:
    return "Euler error" if metric == "euler_error" else f"NPSS {metric}"


def _rankings(metrics: dict[str, Any]) -> str:
    rows = []
    for action, ranking in next(iter(metrics.values()))["rankings"].items():
        for model in (place["model"] for place in ranking):
            rows.append([action, model])
            for of in metrics.values():
                place = next(place for place in of["rankings"][action] if place["model"] == model)
                rows[-1] += [f"{place['score']:.3f}", str(place["rank"])]
    header = ["action", "model", *(cell for metric in metrics for cell in (_name(metric), "rank"))]
    stated = {
        f"    {_name(metric)}: {signature or 'signature not stated'}": None
        for metric, of in metrics.items()
        for signature in of["signatures"].values()
    }
    return "\n".join([table(header, rows, "ll" + "rr" * len(metrics)), _notes("score", "rank"), *stated])


def _agreements(metrics: dict[str, Any]) -> str:
    rows = []
    for metric, of in metrics.items():
        for action, found in (*of["actions"].items(), ("all", of["overall"])):
            questions = found["agreed"] + found["disagreed"]
            shares = [f"{share:.3f}" for share in (found["rate"], *found["interval"])] if questions else ["-"] * 3
            ties = [str(found["tied_votes"]), str(found["tied_metric"])]
            rows.append([_name(metric), action, f"{found['agreed']}/{questions}", *shares, *ties])
    header = ["metric", "action", "agreed", "rate", "from", "to", "no majority", "metric tied"]
    return "\n".join([table(header, rows, "llrrrrrr"), _notes("rate")])


def _comparison(found: dict[str, Any]) -> str:
    joint, mcnemar, independent = found["joint"], found["mcnemar_test"], found["binomial_test"]
    a, b = _name(found["a"]), _name(found["b"])
    lines = [f"{a} against {b}, alternative: {mcnemar['alternative']}"]
    if independent:
        low, high = independent["interval_difference"]
        lines += [
            f"  {independent['method']}: z = {independent['statistic']:.3f}, p = {independent['p_value']:.5g}",
            f"  difference of the rates: {independent['difference']:.3f}, from {low:.3f} to {high:.3f} "
            f"(Newcombe's interval of level {LEVEL:g})",
        ]
    lines += [
        f"  {mcnemar['method']}: p = {mcnemar['p_value']:.5g}; right are both on {joint['both']} questions, "
        f"{a} alone on {joint['only_a']}, {b} alone on {joint['only_b']}, neither on {joint['neither']}; "
        f"{joint['tied']} with a tie left out",
    ]
    return "\n".join(lines)
