"""``npss study``: plan a user study, build its survey, evaluate its votes."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any, get_args

from npss import published
from npss._metric.convention import CONVENTIONS
from npss._pages import survey
from npss._pages._html import resource
from npss._pages.texts import read_texts
from npss._pages.travel import Root
from npss.commands import _votes
from npss.console import Parser
from npss.files._formats import listed
from npss.files._samples import add_max_size
from npss.files._write import check_output, write_text_atomically
from npss.ranking._submissions import read_records, read_submissions, records_of, sample_files
from npss.records import NUMBERS, Record
from npss.study import power, read_votes, sample_size
from npss.study._input import ALTERNATIVES
from npss.study._summary import summary
from npss.validation import positive_integer

_DESCRIPTION = """\
Plan a user study, build its survey, and evaluate its votes.

  npss study plan P_A P_B         questions needed to tell apart two metrics that agree with people on shares P_A and
                                  P_B of the questions
  npss study page DIR -o FILE     a survey on one HTML page, from the samples in DIR, one file per model
  npss study texts                the texts of the page as TOML, to translate or change
  npss study VOTES [VOTES ...]    results of the votes; short for npss study evaluate VOTES
"""
_EVALUATE = """\
Count votes by model, test which model of each pair participants prefer, and measure how much they agree. With scores,
also report how often each metric agrees with the majority, and test NPSS against the Euler error.

VOTES are CSV files with the columns action, question, sequence, model_a, model_b, participant, choice (A, B or tie):
one file for all participants, one file each, or a folder of them. The pages of `npss study page` add the columns
position and expected (the answer to an attention check). A question is the same whatever its position and side.
"""
_PAGE = """\
Build a survey on one HTML page, which needs no network and sends nothing. Each participant gets a number: 1, 2, 3, ...
By it, the page chooses the order of actions and questions and their sides, balanced over participants.
"""
_PLAN = """\
Compute how many questions a study needs to tell apart two metrics (not two models), or the power of a number of
questions, for the two-proportion z test. The test treats the answers of the two metrics as independent samples.
"""


def add_parser(commands: Any) -> None:
    """Add the command to ``npss``."""
    parser: Parser = commands.add_parser(
        "study",
        help="plan a user study, build its survey, evaluate its votes",
        description=_DESCRIPTION,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    subcommands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for add in (_add_plan, _add_page, _add_texts, _add_evaluate):
        add(subcommands)
    parser.imply("evaluate", subcommands)


def _add_plan(subcommands: Any) -> None:
    parser: argparse.ArgumentParser = subcommands.add_parser(
        "plan", help="compute how many questions a study needs", description=_PLAN
    )
    parser.add_argument(
        "p_a", type=float, metavar="P_A", help="the share of questions on which the first metric is right"
    )
    parser.add_argument("p_b", type=float, metavar="P_B", help="the share on which the second metric is right")
    goal = parser.add_mutually_exclusive_group()
    goal.add_argument(
        "--power",
        type=float,
        default=0.8,
        metavar="P",
        help="set the power: the probability of finding the difference (default: %(default)s)",
    )
    goal.add_argument("--questions", type=int, metavar="N", help="compute the power of N questions instead")
    parser.add_argument(
        "--alternative",
        choices=ALTERNATIVES,
        default=ALTERNATIVES[0],
        help="test whether the first share is greater, less, or either (default: %(default)s)",
    )
    parser.add_argument(
        "--alpha",
        type=float,
        default=0.05,
        metavar="P",
        help="test at this significance level (default: %(default)s)",
    )
    parser.add_argument("--no-correction", action="store_true", help="leave out Yates' correction")
    _add_format(parser)
    parser.set_defaults(run=_plan)


def _add_format(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--format", choices=("text", "json"), default="text", help="set the format of the output (default: %(default)s)"
    )


def _add_page(subcommands: Any) -> None:
    parser: argparse.ArgumentParser = subcommands.add_parser(
        "page", help="build the page of a survey", description=_PAGE
    )
    parser.add_argument(
        "directory", type=Path, metavar="DIR", help=f"a folder with one file of samples ({listed('samples')}) per model"
    )
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help="write the page to FILE")
    parser.add_argument(
        "--questions",
        dest="n_questions",
        type=int,
        default=20,
        metavar="N",
        help="ask N questions on each action (default: %(default)s, as in the paper)",
    )
    parser.add_argument(
        "--seed",
        type=int,
        default=0,
        metavar="N",
        help="set the random seed for drawing the questions (default: %(default)s)",
    )
    parser.add_argument(
        "--actions", nargs="+", metavar="ACTION", help="choose the actions (default: all, if every file has the same)"
    )
    parser.add_argument(
        "--attention-checks",
        type=int,
        default=0,
        metavar="N",
        help="add N questions on each action with the recording itself as one of the motions, and the recording upside "
        "down as the other (default: %(default)s)",
    )
    parser.add_argument("--ties", action="store_true", help="also offer the answer that there is no preference")
    parser.add_argument(
        "--no-recording",
        action="store_true",
        help="show A and B without the recording, and ask which is more natural, instead of which is closer to it",
    )
    parser.add_argument(
        "--texts",
        type=Path,
        metavar="FILE",
        help="read the texts of the page from a TOML or JSON file: see study texts",
    )
    parser.add_argument(
        "--root",
        choices=get_args(Root),
        default="known",
        help="let the figures travel where the motion of the root is known, for the recording and all models, or keep "
        "the root fixed (default: %(default)s)",
    )
    parser.add_argument(
        "--root-steps",
        type=int,
        default=1,
        metavar="N",
        help="multiply the motion of the root by N, if the files have every Nth frame of a recording but the "
        "displacement since its last frame, as files of Human3.6M have with N = 2 (default: %(default)s)",
    )
    add_max_size(parser)
    parser.set_defaults(run=_page)


def _add_texts(subcommands: Any) -> None:
    parser: argparse.ArgumentParser = subcommands.add_parser(
        "texts",
        help="print the texts of the page",
        description="Print the texts of the page as TOML, with comments, to change in a file for `npss study page "
        "--texts FILE`.",
    )
    parser.set_defaults(run=_texts)


def _add_evaluate(subcommands: Any) -> None:
    parser: argparse.ArgumentParser = subcommands.add_parser(
        "evaluate",
        help="evaluate votes",
        description=_EVALUATE,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("votes", nargs="+", type=Path, metavar="VOTES", help="a CSV file of votes, or a folder of them")
    scores = parser.add_mutually_exclusive_group()
    scores.add_argument(
        "--scores",
        type=Path,
        metavar="RECORDS",
        help="rank models by their scores: of the samples in this folder, as for study page, or in this JSON file, a "
        "list of records as `npss-baselines evaluate --format json` prints them",
    )
    scores.add_argument("--published", action="store_true", help="rank models by the tables of the NPSS paper")
    parser.add_argument(
        "--convention", choices=tuple(CONVENTIONS), help="rank by NPSS of this convention only (default: all)"
    )
    parser.add_argument(
        "--alternative",
        choices=ALTERNATIVES,
        help="test whether NPSS agrees with the majority more often than the Euler error, less often, or either "
        "(default: greater, as in the paper)",
    )
    parser.add_argument(
        "--exclude-failed", action="store_true", help="leave out participants who fail an attention check"
    )
    _add_format(parser)
    parser.set_defaults(run=_evaluate)


def _plan(options: argparse.Namespace) -> None:
    """Print how many questions a study needs, and its power."""
    test = {"alternative": options.alternative, "alpha": options.alpha, "correction": not options.no_correction}
    if options.questions is None:
        n = sample_size(options.p_a, options.p_b, power=options.power, **test)
    else:
        n = positive_integer("questions", options.questions)
    plan = {"questions": n, "power": power(options.p_a, options.p_b, n, **test)}
    if options.format == "json":
        print(json.dumps({"p_a": options.p_a, "p_b": options.p_b, **test, **plan}, indent=2))
        return
    correction = "Yates' correction" if test["correction"] else "no correction"
    print(
        f"{n} questions tell {options.p_a:g} from {options.p_b:g} with a power of {plan['power']:.3f}\n"
        f"    two-proportion z test, pooled variance, {correction}, {options.alternative}, level {options.alpha:g}"
    )


def _page(options: argparse.Namespace) -> None:
    """Write the page of a survey, and print what to know before giving it to participants."""
    check_output(options.output, [*sample_files([options.directory]), *([options.texts] if options.texts else [])])
    made = survey(
        options.directory,
        n_questions=options.n_questions,
        seed=options.seed,
        actions=options.actions,
        attention_checks=options.attention_checks,
        ties=options.ties,
        recording=not options.no_recording,
        texts=read_texts(options.texts) if options.texts else None,
        root=options.root,
        root_steps=options.root_steps,
        max_size=options.max_size,
    )
    write_text_atomically(options.output, made.page)
    print(made)


def _texts(options: argparse.Namespace) -> None:
    """Print the texts of the page."""
    print(resource("survey.toml"), end="")


def _evaluate(options: argparse.Namespace) -> None:
    """Print the results of votes."""
    records = None
    if options.scores is not None:
        records = _read_records(options.scores)
    elif options.published:
        records = published.records()
    elif options.convention or options.alternative:
        raise ValueError("--convention and --alternative need scores: add --scores RECORDS or --published")
    results = summary(
        read_votes(*options.votes),
        records,
        conventions=(options.convention,) if options.convention else None,
        alternative=options.alternative or ALTERNATIVES[0],
        exclude_failed=options.exclude_failed,
    )
    print(json.dumps(results, indent=2) if options.format == "json" else _votes.text(results))


def _read_records(path: Path) -> list[Record]:
    """Read a file of records, or score a folder of samples; whether these are the needed scores shows in use."""
    if path.is_dir():
        return records_of(read_submissions([path]))
    records = read_records(path)
    for index, record in enumerate(records):
        for name in ("model", "action"):
            if not isinstance(record.get(name), str):
                raise ValueError(f"{path}: record {index} has no {name}")
        for name in (*NUMBERS, "signatures"):
            if not isinstance(record.get(name, {}), dict):
                raise ValueError(f"{path}: record {index}: {name} is not an object")
        if not all(isinstance(signature, str) for signature in record.get("signatures", {}).values()):
            raise ValueError(f"{path}: record {index}: signatures are not strings")
    return records
