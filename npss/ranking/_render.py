"""Leaderboards as text, Markdown, LaTeX or HTML: a table per action or per column, models by rank, notes below."""

from __future__ import annotations

import html
import math
import re
from collections.abc import Callable, Sequence
from typing import NamedTuple

from npss._analysis.sign_flip import MIN_BLOCKS_OF_TEST
from npss._metric.registry import direction
from npss.console._tables import markdown_code, markdown_text, table
from npss.ranking._standings import MARK, Standing, higher_headings, timed_headings

#: How to cite the metric.
CITE = (
    "Cite A. Gopalakrishnan et al., A Neural Temporal Model for Human Motion Prediction, CVPR 2019, "
    "and print the signature."
)
_LATEX = {
    **{letter: f"\\{letter}" for letter in "&%$#_{}"},
    **{
        "<": r"\textless{}",
        ">": r"\textgreater{}",
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
        "\\": r"\textbackslash{}",
        "|": r"\textbar{}",
        "`": r"\textasciigrave{}",
        "†": r"\dag{}",
    },
}


#: Standings by model, kind (published, reference or empty), and column; or action, in the table of a column.
Cells = dict[tuple[str, str, str], Standing]


class Table(NamedTuple):
    """The table of one action, with columns; or of one column, with actions in their place."""

    action: str
    columns: dict[str, str]  # columns and their short headings; the notes say the rest
    timed: frozenset[str]  # columns of single times
    by: str  # column by which models are ranked and sorted
    models: list[tuple[str, str]]  # and their kinds; best first, then published and reference ones
    cells: Cells
    signatures: list[str]

    def only(self, *, timed: bool) -> Table:
        """Keep the columns of single times, or the others, and the models with numbers in them."""
        columns = {column: short for column, short in self.columns.items() if (column in self.timed) == timed}
        models = [model for model in self.models if any((*model, column) in self.cells for column in columns)]
        return self._replace(columns=columns, models=models)

    def rank(self, model: str, kind: str) -> str:
        """Return the rank as text; empty if a model has none."""
        cell = self.cells.get((model, kind, self.by))
        return "" if cell is None or cell.rank is None else str(cell.rank)

    def row(self, model: str, kind: str, cell: Callable[[Standing], str]) -> list[str]:
        """Return the cells of a model, each written by `cell`; missing ones are empty."""
        standings = (self.cells.get((model, kind, column)) for column in self.columns)
        return ["" if standing is None else cell(standing) for standing in standings]


def tables(standings: Sequence[Standing], by: str | None = None, *, wide: bool = False) -> list[Table]:
    """Sort standings into one table per action, by a column (by the first one if the action lacks it).

    If `wide`, into one table per column, with actions side by side, by the first action.
    """
    if wide:
        return [_of_column(standings, column) for column in dict.fromkeys(one.result.column for one in standings)]
    parts = []
    single = len(timed_headings(standings)) == 1
    for action in dict.fromkeys(standing.result.action for standing in standings):
        of_action = [standing for standing in standings if standing.result.action == action]
        results = [standing.result for standing in of_action]
        columns = {result.column: result.time if single and result.time else result.column for result in results}
        timed = frozenset(result.column for result in results if result.time)
        chosen = by if by in columns else next(iter(columns))
        cells = {(s.result.model, s.result.kind, s.result.column): s for s in of_action}

        signatures = list(dict.fromkeys(result.signature for result in results))
        parts.append(Table(action, columns, timed, chosen, _models(cells, chosen), cells, signatures))
    return parts


def _of_column(standings: Sequence[Standing], column: str) -> Table:
    """Return the table of one column, with actions side by side."""
    of_column = [standing for standing in standings if standing.result.column == column]
    cells = {(s.result.model, s.result.kind, s.result.action): s for s in of_column}
    actions = {standing.result.action: standing.result.action or "all" for standing in of_column}
    first = next(iter(actions))
    signatures = list(dict.fromkeys(standing.result.signature for standing in of_column))
    return Table(column, actions, frozenset(), first, _models(cells, first), cells, signatures)


def _models(cells: Cells, by: str) -> list[tuple[str, str]]:
    """Return models and their kinds: the user's, then published and reference ones, each by a column."""

    def place(model: tuple[str, str]) -> tuple[str, bool, float]:
        cell = cells.get((*model, by))
        return model[1], cell is None, math.inf if cell is None else cell.result.loss

    return sorted(dict.fromkeys(key[:2] for key in cells), key=place)


def to_text(
    standings: Sequence[Standing],
    notes: Sequence[str],
    *,
    by: str | None = None,
    digits: int | None = None,
    wide: bool = False,
    markdown: bool = False,
) -> str:
    """Write the tables as text, the best of a column marked ``*``, or in Markdown, the best in bold."""
    escaped = markdown_text if markdown else str

    def cell(standing: Standing) -> str:
        value = _value(standing, digits)
        if standing.best:
            value = f"**{value}**" if markdown else f"{value}*"
        value += MARK if standing.worse else "" if markdown else " " * (not standing.best)
        # Intervals at many times would make the table too wide for text.
        ends = "" if standing.result.time else _ends(standing, digits)
        return value + (f" ({ends})" if ends else "")

    parts = []
    for part in tables(standings, by, wide=wide):
        rows = [[part.rank(*model), escaped(_name(*model)), *part.row(*model, cell)] for model in part.models]
        heading = escaped(f"{part.action or 'all'} (ranked by {part.by or 'all'})")
        parts.append(f"### {heading}" if markdown else heading)
        columns = [escaped(short) for short in part.columns.values()]
        align = "rl" + "r" * len(columns)
        parts.append(table(["rank", "model", *columns], rows, align, markdown=markdown))
        parts.append("\n".join(f"{markdown_code(s)}  " if markdown else f"    {s}" for s in part.signatures))
    hidden = timed_headings(standing for standing in standings if standing.low is not None)
    lines = [*notes, *(f"Intervals of the {heading}: in HTML and CSV." for heading in hidden), CITE]
    parts.append("\n".join(f"- {escaped(line)}" if markdown else line for line in lines))
    return "\n\n".join(parts)


def to_latex(
    standings: Sequence[Standing],
    notes: Sequence[str],
    *,
    by: str | None = None,
    digits: int | None = None,
    wide: bool = False,
    caption: str | None = None,
    label: str | None = None,
) -> str:
    """Write the tables in LaTeX, with the package booktabs: the best of a column in bold, intervals below.

    `caption` begins each caption, in LaTeX; `label` is that of the first table, with -2, -3, ... for the others.
    """

    def cell(standing: Standing) -> str:
        value = _value(standing, digits)
        value = f"\\textbf{{{value}}}" if standing.best else value
        return value + (r"\textsuperscript{\dag}" if standing.worse else "")

    def below(standing: Standing) -> str:
        ends = _latex(_ends(standing, digits))
        return f"{{\\tiny {ends}}}" if ends else ""

    parts = [f"% needs \\usepackage{{booktabs}}\n% {CITE}"]
    before = "" if not caption else f"{caption} " if caption.rstrip().endswith((".", "!", "?")) else f"{caption}. "
    for number, part in enumerate(tables(standings, by, wide=wide), 1):
        best = "best of the ranked models" if any(kind for _, kind in part.models) else "best"
        lines = [
            r"\begin{table}",
            r"\centering\footnotesize\setlength{\tabcolsep}{2pt}",
            f"\\caption{{{before}{_latex(part.action or 'All')}, ranked by {_latex(part.by)}: "
            f"{_latex(direction(higher_headings(part.cells.values())))}, {best} in bold, "
            f"{_latex(MARK)} significantly worse than the best}}",
        ]
        if label is not None:
            lines.append(f"\\label{{{label}{f'-{number}' if number > 1 else ''}}}")
        # NPSS above the Euler error, as papers print them: side by side they are wider than a page.
        for group in (part.only(timed=False), part.only(timed=True)):
            if group.columns:
                lines += _tabular(group, cell, below)
        lines.append(r"\scriptsize\raggedright")
        lines += [f"\\texttt{{{_latex(signature, breaks=True)}}}\\par" for signature in part.signatures]
        lines += [f"{_latex(line)}\\par" for line in _in_three_lines(part, notes)]
        lines.append(r"\end{table}")
        parts.append("\n".join(lines))
    return "\n\n".join(parts)


def _in_three_lines(part: Table, notes: Sequence[str]) -> list[str]:
    """Return what a reader must know of a table: what the numbers beside values are, the marks, and the sources."""
    own = [cell for (_, kind, _), cell in part.cells.items() if not kind]
    beside = [note for note in notes if note.startswith(("Intervals:", "Range:", "Without intervals:"))]
    # The blocks of this table's actions, and what they are a sample of.
    named = {"Inferred", *(cell.result.action or "all" for cell in own)}
    beside += [note for note in notes if named & set(note.partition(": ")[0].split(", "))]
    marks = [note for note in notes if note.startswith(MARK)] if any(cell.worse for cell in own) else []
    kinds = dict.fromkeys(kind for _, kind in part.models if kind)
    italic = [f"In italics: {' and '.join(kinds)}."] if kinds else []
    sources = [note for note in notes if note.startswith(tuple(f"{kind.capitalize()} numbers" for kind in kinds))]
    lines = [" ".join(beside), " ".join(marks), " ".join([*italic, *(sources if kinds else [])])]
    return [line for line in lines if line]


def _tabular(part: Table, cell: Callable[[Standing], str], below: Callable[[Standing], str]) -> list[str]:
    """Return the lines of a table in LaTeX, with intervals below the cells of each model."""
    lines = [
        f"\\begin{{tabular}}{{rl{'r' * len(part.columns)}}}",
        r"\toprule",
        " & ".join(["rank", "model", *map(_latex, part.columns.values())]) + r" \\",
        r"\midrule",
    ]
    for place, (model, kind) in enumerate(part.models):
        if kind and place and not part.models[place - 1][1]:
            lines.append(r"\midrule")
        name = f"\\textit{{{_latex(_name(model, kind))}}}" if kind else _latex(model)
        lines.append(" & ".join([part.rank(model, kind), name, *part.row(model, kind, cell)]) + r" \\")
        if any(ends := part.row(model, kind, below)):
            lines.append(" & ".join(["", "", *ends]) + r" \\")
    return [*lines, r"\bottomrule", r"\end{tabular}", r"\par\medskip"]


def to_html(
    standings: Sequence[Standing],
    notes: Sequence[str],
    *,
    by: str | None = None,
    digits: int | None = None,
    wide: bool = False,
) -> str:
    """Write the tables as an HTML fragment, with signatures and notes below."""
    signatures = dict.fromkeys(standing.result.signature for standing in standings)
    items = "".join(f"<li><code>{html.escape(signature)}</code></li>" for signature in signatures)
    lines = "".join(f"<li>{html.escape(line)}</li>" for line in [*notes, CITE])
    below = f'<ul class="signatures">{items}</ul>\n<ul class="notes">{lines}</ul>'
    return "\n".join([*html_tables(standings, by=by, digits=digits, wide=wide), below])


def html_tables(
    standings: Sequence[Standing], *, by: str | None = None, digits: int | None = None, wide: bool = False
) -> list[str]:
    """Write each table in HTML, with intervals below the numbers."""

    def cell(standing: Standing) -> str:
        value = _value(standing, digits)
        value = f"<strong>{value}</strong>" if standing.best else value
        mark = f'<sup class="mark">{MARK}</sup>' if standing.worse else ""
        interval = _ends(standing, digits)
        return f"<td>{value}{mark}" + (f"<br><small>{interval}</small>" if interval else "") + "</td>"

    parts = []
    for part in tables(standings, by, wide=wide):
        heading = "".join(f'<th scope="col">{html.escape(short)}</th>' for short in part.columns.values())
        rows = []
        for model in part.models:
            cells = "".join(text or "<td></td>" for text in part.row(*model, cell))
            style = ' class="published"' if model[1] else ""
            name = html.escape(_name(*model))
            rows.append(f'<tr{style}><th scope="row">{name}</th><td>{part.rank(*model)}</td>{cells}</tr>')
        caption = html.escape(f"{part.action or 'All'}, ranked by {part.by or 'all'}")
        parts.append(
            f'<table class="board"><caption>{caption}</caption>'
            f'<thead><tr><th scope="col">model</th><th scope="col">rank</th>{heading}</tr></thead>'
            f"<tbody>{''.join(rows)}</tbody></table>"
        )
    return parts


def _name(model: str, kind: str) -> str:
    return f"{model} ({kind})" if kind else model


def _digits(standing: Standing, digits: int | None) -> int:
    """Return the decimal places: as given, those of the metric, or three."""
    if digits is None:
        digits = standing.result.digits
    return 3 if digits is None else digits


def _ends(standing: Standing, digits: int | None) -> str:
    """Return the text beside a value: its interval or range, the score in blocks, wins, seeds, and samples."""
    if standing.low is None or standing.high is None:
        return ""
    digits = _digits(standing, digits)
    high = "∞" if math.isinf(standing.high) else f"{standing.high:.{digits}f}"
    text = f"{'range ' * standing.is_range}{standing.low:.{digits}f}–{high}"
    if standing.in_blocks is not None:
        text = f"{standing.in_blocks:.{digits}f}: {text}"
    if standing.behind is not None and standing.behind[1] < MIN_BLOCKS_OF_TEST:
        text += f", {standing.behind[0]}/{standing.behind[1]}"
    if seeds := standing.result.seeds:
        text += f", seeds {min(seeds):.{digits}f}–{max(seeds):.{digits}f}"
    if samples := standing.result.samples:
        text += f", samples {min(samples):.{digits}f}–{max(samples):.{digits}f}"
    return text


def _value(standing: Standing, digits: int | None) -> str:
    """Round a value; a published or reference one to the digits that are known, at least two."""
    digits = _digits(standing, digits)
    if standing.result.source:
        digits = min(digits, max(2, len(str(standing.result.value).partition(".")[2])))
    return f"{standing.result.value:.{digits}f}"


def _latex(text: str, *, breaks: bool = False) -> str:
    """Escape text; `breaks`, for typewriter type, allows line breaks after each ``|``."""
    escaped = "".join(_LATEX.get(letter, letter) for letter in text)
    escaped = re.sub("-(?=-)", "-{}", escaped).replace("–", "--").replace("∞", r"$\infty$")
    return escaped.replace(_LATEX["|"], r"|\allowbreak{}") if breaks else escaped
