"""``npss study``: the page of a user study, what its votes tell, and how many questions it needs."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from npss import published
from npss._metric.convention import CONVENTIONS
from npss.commands import _votes
from npss.console import Parser
from npss.files._formats import listed
from npss.files._samples import add_max_size
from npss.files._write import check_output, write_text_atomically
from npss.ranking._submissions import read_records, sample_files
from npss.records import NUMBERS, Record
from npss.study import power, read_votes, sample_size
from npss.study._input import ALTERNATIVES
from npss.study._summary import summary

_DESCRIPTION = """\
Plan a user study, make its page, and say what its votes tell.

  npss study plan P_A P_B         how many questions it takes to tell a metric that agrees with people on the share P_A
                                  of questions from one that agrees with them on P_B
  npss study page DIR -o FILE     a survey as one page of HTML, of the samples in DIR, a file for each model
  npss study VOTES [VOTES ...]    what the votes tell: short for npss study evaluate VOTES
"""
_EVALUATE = """\
Say what votes tell of models and participants; with scores, also how often each metric agrees with the majority, and
the tests of NPSS against the Euler error.

VOTES are CSV files with the columns action, question, sequence, model_a, model_b, participant, choice (A, B or tie):
one of all participants, one of each, or a folder of them.
"""
_PLAN = """\
Say how many questions a study needs, or what its power is with some number of them: of the two-proportion z test,
which takes the answers of the two metrics as independent samples.
"""


def add_parser(commands: Any) -> None:
    """Add the command to those of ``npss``."""
    parser: Parser = commands.add_parser(
        "study",
        help="plan a user study, make its page, evaluate its votes",
        description=_DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    forms = parser.add_subparsers(title="forms", required=True, metavar="FORM")
    for add in (_add_plan, _add_page, _add_evaluate):
        add(forms)
    parser.imply("evaluate", forms)


def _add_plan(forms: Any) -> None:
    parser: argparse.ArgumentParser = forms.add_parser(
        "plan", help="say how many questions a study needs", description=_PLAN
    )
    parser.add_argument(
        "p_a", type=float, metavar="P_A", help="the share of questions on which the first metric is right"
    )
    parser.add_argument("p_b", type=float, metavar="P_B", help="that of the second metric")
    wanted = parser.add_mutually_exclusive_group()
    wanted.add_argument(
        "--power",
        type=float,
        default=0.8,
        metavar="P",
        help="find the difference with this probability (default: %(default)s)",
    )
    wanted.add_argument("--questions", type=int, metavar="N", help="say the power of this many questions instead")
    parser.add_argument("--alternative", choices=ALTERNATIVES, default=ALTERNATIVES[0], help="default: %(default)s")
    parser.add_argument(
        "--alpha", type=float, default=0.05, metavar="P", help="test at this level of significance (default: 0.05)"
    )
    parser.add_argument("--no-correction", action="store_true", help="leave out Yates' correction")
    parser.add_argument("--format", choices=("text", "json"), default="text", help="default: %(default)s")
    parser.set_defaults(run=_plan)


def _add_page(forms: Any) -> None:
    parser: argparse.ArgumentParser = forms.add_parser("page", help="make the page of a survey")
    parser.add_argument("directory", type=Path, metavar="DIR", help=f"samples of each model, {listed('samples')}")
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help="write the page to this file")
    parser.add_argument(
        "--questions", type=int, default=20, metavar="N", help="ask this many questions (default: 20, as in the paper)"
    )
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="seed the generator that draws them (default: 0)"
    )
    parser.add_argument("--action", help="choose the action, where the samples have several in common")
    add_max_size(parser)
    parser.set_defaults(run=_page)


def _add_evaluate(forms: Any) -> None:
    parser: argparse.ArgumentParser = forms.add_parser(
        "evaluate",
        help="say what votes tell",
        description=_EVALUATE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("votes", nargs="+", type=Path, metavar="VOTES", help="a CSV file of votes, or a folder of them")
    scores = parser.add_mutually_exclusive_group()
    scores.add_argument(
        "--scores",
        type=Path,
        metavar="RECORDS",
        help="rank models by these scores: a JSON file, as `npss-baselines evaluate --format json` prints it",
    )
    scores.add_argument("--published", action="store_true", help="rank models by the tables of the NPSS paper")
    parser.add_argument("--convention", choices=tuple(CONVENTIONS), help="rank by NPSS of this convention alone")
    parser.add_argument(
        "--alternative",
        choices=ALTERNATIVES,
        help="test whether NPSS agrees with the majority more often than the Euler error (greater, the default, as in "
        "the paper), less often, or either",
    )
    parser.add_argument("--format", choices=("text", "json"), default="text", help="default: %(default)s")
    parser.set_defaults(run=_evaluate)


def _plan(options: argparse.Namespace) -> None:
    """Print how many questions a study needs, and the power that it has with them."""
    test = {"alternative": options.alternative, "alpha": options.alpha, "correction": not options.no_correction}
    n = options.questions
    if n is None:
        n = sample_size(options.p_a, options.p_b, power=options.power, **test)
    found = {"questions": n, "power": power(options.p_a, options.p_b, n, **test)}
    if options.format == "json":
        print(json.dumps({"p_a": options.p_a, "p_b": options.p_b, **test, **found}, indent=2))
        return
    correction = "Yates' correction" if test["correction"] else "no correction"
    print(
        f"{n} questions tell {options.p_a:g} from {options.p_b:g} with a power of {found['power']:.3f}\n"
        f"    two-proportion z test, pooled variance, {correction}, {options.alternative}, level {options.alpha:g}"
    )


def _page(options: argparse.Namespace) -> None:
    """Write the page of a survey."""
    from npss._pages import survey  # here, not above: votes are counted without it

    check_output(options.output, sample_files([options.directory]))
    text = survey(
        options.directory,
        n_questions=options.questions,
        seed=options.seed,
        action=options.action,
        max_size=options.max_size,
    )
    write_text_atomically(options.output, text)


def _evaluate(options: argparse.Namespace) -> None:
    """Print what votes tell."""
    records = None
    if options.scores is not None:
        records = _read_records(options.scores)
    elif options.published:
        records = published.records()
    elif options.convention or options.alternative:
        raise ValueError("--convention and --alternative are about scores: --scores RECORDS or --published names them")
    told = summary(
        read_votes(*options.votes),
        records,
        conventions=(options.convention,) if options.convention else None,
        alternative=options.alternative or ALTERNATIVES[0],
    )
    print(json.dumps(told, indent=2) if options.format == "json" else _votes.text(told))


def _read_records(path: Path) -> list[Record]:
    """Read a file of records; what it must hold of them is seen when they are used."""
    records = read_records(path)
    for index, record in enumerate(records):
        for name in ("model", "action"):
            if not isinstance(record.get(name), str):
                raise ValueError(f"{path}: record {index} does not name its {name}")
        for name in (*NUMBERS, "signatures"):
            if not isinstance(record.get(name, {}), dict):
                raise ValueError(f"{path}: record {index}: {name} is no object")
        if not all(isinstance(signature, str) for signature in record.get("signatures", {}).values()):
            raise ValueError(f"{path}: record {index}: its signatures are no texts")
    return records
