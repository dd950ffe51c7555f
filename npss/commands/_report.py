"""``npss report``: a full report of prediction files, on one page."""

from __future__ import annotations

import argparse
import io
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from npss._analysis.diagnose import diagnose
from npss._analysis.report import Report, report
from npss._metric.euler_error import moving_pair
from npss._metric.frames import whole_times
from npss._metric.registry import EULER_ERROR, NPSS
from npss._metric.signature import parse_signature
from npss._pages.report import Figure, report_page
from npss.commands._leaderboard import (
    add_groups,
    add_leaderboard_options,
    add_protocol,
    context_of,
    groups_of,
    leaderboard_of,
    show_leaderboard,
)
from npss.commands._metrics import add_metrics
from npss.console._progress import Progress
from npss.files._formats import listed
from npss.files._samples import Pair, features_of
from npss.files._write import check_output, write_text_atomically
from npss.protocol import FPS
from npss.ranking._render import html_tables, tables
from npss.ranking._submissions import TRUTH, Submissions, naming, read_submissions, records_of, sample_files
from npss.skeleton import FEATURE_NAMES, H36M, poses_to_positions
from npss.validation import Array

if TYPE_CHECKING:
    from npss.ranking._frame import Leaderboard

_SHOWN = 8  # animated sequences of an action; more would make the page large
_STRIP_MS = (160, 560, 1000, 2000, 4000)  # as in figure 2 of the NPSS paper


def add_parser(commands: Any) -> None:
    """Add the command to ``npss``."""
    parser: argparse.ArgumentParser = commands.add_parser(
        "report",
        help="write a full report of prediction files",
        description="Write a full report on one HTML page: leaderboard, diagnosis, pictures and moving skeletons. "
        "Needs pandas and matplotlib (extras pandas and plot).",
    )
    parser.add_argument(
        "paths",
        nargs="+",
        type=Path,
        metavar="PATH",
        help=f"results of models: {listed('samples')} files or folders of .npy files, or a folder of them",
    )
    parser.add_argument("-o", "--output", type=Path, required=True, metavar="FILE", help="write the page to FILE")
    add_protocol(parser)
    add_groups(parser)
    add_metrics(parser)
    add_leaderboard_options(parser)
    parser.set_defaults(run=run)


def run(options: argparse.Namespace) -> None:
    """Write the page, and print the leaderboard."""
    check_output(options.output, sample_files(options.paths))
    submissions = read_submissions(options.paths, max_size=options.max_size)
    records = records_of(submissions, metrics=options.metrics, **context_of(options))
    board = leaderboard_of(records, options, groups=groups_of(options))
    write_report(options.output, submissions, board)
    show_leaderboard(board, options)


def write_report(path: Path, submissions: Submissions, board: Leaderboard) -> None:
    """Write the page of some submissions and their leaderboard.

    Parameters
    ----------
    path : Path
        The file to write.
    submissions : mapping of str to mapping of str to Pair
        Predictions by model and action.
    board : Leaderboard
        The leaderboard of the same models and actions.
    """
    actions = list(dict.fromkeys(action for pairs in submissions.values() for action in pairs))
    parts = []
    with Progress("drawing") as progress:
        for done, action in enumerate(actions, 1):
            of_action = {model: pairs[action] for model, pairs in submissions.items() if action in pairs}
            parts.append(_Action(action, of_action, board))
            progress(done / len(actions))
    moving = [part for part in parts if part.clips]
    page = report_page(
        title=f"{len(submissions)} models on {', '.join(actions)}",
        boards=html_tables(board.standings, by=board.by),
        notes=board.notes,
        signatures=list(dict.fromkeys(standing.result.signature for standing in board.standings)),
        parts=[(part.action, part.parts) for part in parts],
        figures=[figure for part in parts for figure in part.figures],
        findings=[finding for part in parts for finding in part.findings],
        clips={part.action: part.clips for part in moving},
        fps=moving[0].fps if moving else FPS,
        skeleton=moving[0].skeleton if moving else H36M,
    )
    write_text_atomically(path, page)


class _Action:
    """The part of the page about one action."""

    def __init__(self, action: str, pairs: Mapping[str, Pair], board: Leaderboard) -> None:
        self.action = action
        first = next(iter(pairs.values()))
        self._gt = features_of(first)[0]
        self._preds = {model: features_of(pair)[1] for model, pair in pairs.items()}
        (table,) = (table for table in tables(board.standings, board.by) if table.action == action)
        best = table.models[0][0]
        self._best = best if best in pairs else next(iter(pairs))  # a method has no predictions of its own
        shown = next(
            table.cells[best, "", column].result
            for column in (table.by, *table.columns)
            if table.cells[best, "", column].result.heading == NPSS.heading
        )
        meaning = parse_signature(shown.signature)
        self._groups = shown.groups
        self._context = {
            name: meaning[name] for name in ("representation", "protocol", "unwrap", "verified") if name in meaning
        }
        self._is_euler = meaning.get("representation") == "euler"
        self.fps = float(meaning.get("fps", FPS))
        meta = first.meta
        names = FEATURE_NAMES if meta is None else meta.feature_names(self._gt.shape[2])
        options: dict[str, Any] = {"convention": meaning["convention"], "feature_names": names}
        options |= {"fps": meaning["fps"]} if "fps" in meaning else {}
        self._options = options | self._context
        self._reports = {model: report(self._gt, pred, **self._options) for model, pred in self._preds.items()}
        self.parts = [f"{model}: {NPSS.heading} {of.score:.4f}, {of.parts}" for model, of in self._reports.items()]
        self.parts.append(next(iter(self._reports.values())).signature)
        self.findings = [(f"{action}, {label}", lines) for label, lines in self._diagnose() if lines]
        if "fps" not in meaning:
            self.findings.append((f"{action}, spectra", ["note: no spectra: no fps"]))
        self.clips: dict[str, Array] = {}
        if meta is not None and (why := meta.not_drawn()):
            self.findings.append((f"{action}, motion", [f"note: no moving figures: {why}"]))
        else:
            motions = {TRUTH: first.gt, **{model: pair.pred for model, pair in pairs.items()}}
            for label, motion in motions.items():
                with naming(label, action):
                    self.clips[label] = (poses_to_positions if meta is None else meta.positions)(motion[:_SHOWN])
        self.skeleton = H36M if meta is None or not self.clips else meta.skeleton(self.clips[TRUTH])
        self.figures = list(self._draw())

    def _diagnose(self) -> Iterator[tuple[str, list[str]]]:
        """Yield the findings about the ground truth, once, and about each prediction."""
        convention = self._options["convention"]
        diagnoses = {model: diagnose(self._gt, pred, convention=convention) for model, pred in self._preds.items()}
        truth = [str(finding) for diagnosis in diagnoses.values() for finding in diagnosis if finding.argument == "gt"]
        yield TRUTH, list(dict.fromkeys(truth))
        for model, diagnosis in diagnoses.items():
            yield model, [str(finding) for finding in diagnosis if finding.argument == "pred"]

    def _draw(self) -> Iterator[Figure]:
        from npss import plot  # imported here: matplotlib is slow to import

        times = whole_times(_STRIP_MS, self.fps, self._gt.shape[1])
        if times and self.clips:
            first = {label: positions[0] for label, positions in self.clips.items()}
            strip = plot.film_strip(first, fps=self.fps, at_ms=times, skeleton=self.skeleton)
            yield self._figure("the first sequence", strip, "At the times of figure 2 of the NPSS paper.")
        if self._is_euler and not moving_pair(self._gt, self._gt)[2].all():  # still sequences have no Euler error
            errors = plot.errors(self._gt, self._preds, fps=self.fps, groups=self._groups, **self._context)
            yield self._figure(f"{EULER_ERROR.heading} over time", errors, "With pointwise bands over blocks.")
        best = self._reports[self._best]
        if best.score == 0:
            return  # nothing has a share of 0
        shares = plot.contributions(best)
        others = " Of another model, a report on its file alone shows them." if len(self._preds) > 1 else ""
        caption = f"Shares of joints and sequences.{others}"
        yield self._figure(f"where the score of {self._best} comes from", shares, caption)
        if "fps" not in self._options:
            return  # frequencies have no unit
        sequence, feature = _largest(best)
        place: dict[str, Any] = {"sequence": sequence, "feature": feature, "names": (TRUTH, self._best)}
        spectra = plot.spectra(self._gt, self._preds[self._best], **place, **self._options)
        caption = "The feature and sequence that cost most."
        yield self._figure(f"the spectra behind it, {self._best}", spectra, caption)

    def _figure(self, title: str, figure: Any, caption: str) -> Figure:
        svg = io.StringIO()
        figure.savefig(svg, format="svg", bbox_inches="tight")
        return Figure(f"{self.action}: {title}", svg.getvalue(), caption)


def _largest(report: Report) -> tuple[int, int]:
    """Return the sequence and feature that contribute most."""
    parts: Array = report.weight * report.emd
    sequence, feature = divmod(int(parts.argmax()), parts.shape[1])
    return sequence, feature
