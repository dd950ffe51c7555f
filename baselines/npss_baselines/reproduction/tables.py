"""The tables of the reference numbers, made from records alone, with published numbers beside them."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any, NamedTuple

from npss import parse_signature, published, signature, study
from npss.console import markdown_code, markdown_text, table
from npss.files import write_text_atomically
from npss.protocol import FPS, SLICES_MS
from npss.records import Record
from npss_baselines.reproduction.plan import Row
from npss_baselines.reproduction.results import EIGHT, MANY, Measured, Number, Results

#: The name in the published tables of each row, if it has one.
PUBLISHED = {
    "zero-velocity": "zero-velocity",
    "vgru-d": "VGRU-d",
    "vgru-d-faithful": "VGRU-d",
    "gru-d": "GRU-d",
    "vgru-ac": "VGRU-ac",
    "vgru-r1": "VGRU-r1 (SA)",
    "mbr-long": "MBR-long",
    "mbr-unsup": "MBR-unsup (SA)",
    "erd": "ERD",
    "lstm-3lr": "LSTM-3LR",
    "srnn": "SRNN",
    "vgru-r1-all": "VGRU-r1 (MA)",
    "mbr-unsup-all": "MBR-unsup (MA)",
    "mbr-sup-all": "MBR-sup (MA)",
}
#: The models of Table 2, and their rows.
TABLE_2 = ("vgru-d", "gru-d", "vgru-ac", "vgru-r1", "mbr-long", "mbr-unsup")
#: The recipe of predictors that every table shows.
UNTRAINED = "untrained"
#: The times of Table 6, in milliseconds.
SHORT_MS = (80, 160, 320, 400)
WINDOWS = ("0-1", "1-2", "2-4")
#: The metrics that rank models: a heading, the protocol, and the metric's name or the convention.
METRICS = (
    ("Euler error", EIGHT, "euler_error"),
    ("`released`", EIGHT, "released"),
    ("`paper`", EIGHT, "paper"),
    ("`literal`", EIGHT, "literal"),
    ("`released`, 256 windows", MANY, "released"),
    ("`paper`, 256 windows", MANY, "paper"),
)
#: What the cells of most tables hold.
EXPLAINED = (
    "Small: the interval (95 %, bootstrap over blocks of windows) or, with fewer than ten blocks, the range of blocks; "
    "then the standard deviation of single draws, if the model has noise. ±: the standard deviation over seeds."
)
#: What is counted, and which pair is named.
DISAGREEMENTS = (
    "Pairs of rows in a different order, without the running averages, whose NPSS is that of zero-velocity. Of these, "
    "the clearest: the pair whose numbers differ by the largest share in the metric that tells them apart less."
)


class Table(NamedTuple):
    """A table with its notes."""

    title: str
    header: Sequence[str]
    rows: Sequence[Sequence[str]]
    notes: Sequence[str]
    n_text: int = 2  # columns that are aligned to the left

    def markdown(self) -> str:
        """Return Markdown: the table, and its notes as lines."""
        if not self.rows:
            return "\n\n".join(["*No record.*", *self.notes])
        align = "l" * self.n_text + "r" * (len(self.header) - self.n_text)
        return "\n\n".join([table(self.header, self.rows, align, markdown=True), *self.notes])


def all_tables(results: Results) -> dict[str, Table]:
    """Return every table, perhaps without rows, by the name of its file, such as ``'table-4-walking'``."""
    found = {
        "ablation": ablation(results),
        "recipes": recipes(results),
        "records": records(results),
        "reproduces": reproduces(results),
        "table-1": table_1(results),
    }
    for action in results.actions:
        found |= {
            f"table-2-{action}": table_2(results, action),
            f"table-4-{action}": table_4(results, action),
            f"table-5-{action}": table_5(results, action),
            f"table-6-{action}": euler_table(results, action, "table-6", SHORT_MS),
            f"table-7-{action}": euler_table(results, action, "table-7", SLICES_MS),
            f"best-{action}": best(results, action),
            f"parts-{action}": parts(results, action),
            f"rankings-{action}": rankings(results, action),
            f"disagreements-{action}": disagreements(results, action),
        }
        if wraps(results, action):
            found[f"table-5-{action}-unwrapped"] = table_5(results, action, unwrap="target")
    return dict(sorted(found.items()))


def recipes(results: Results) -> Table:
    """Return what each recipe is, in words."""
    return Table("Recipes", ["recipe", ""], [[f"`{name}`", what] for name, what in results.plan.recipes.items()], [])


def records(results: Results) -> Table:
    """Return how many seeds of each row have a record on each action, of those in the plan."""
    rows = []
    for row in results.plan.rows.values():
        cells = []
        for action in results.actions:
            planned, missing = results.planned(row, action), results.missing(row, action)
            cells.append(f"{len(planned) - len(missing)} of {len(planned)}" if planned else "")
        if any(cells):
            rows.append([*named(row), *cells])
    return Table("Seeds with a record, of those in the plan", ["model", "recipe", *results.actions], rows, [])


def table_1(results: Results) -> Table:
    """Return Table 1: the numbers of parameters."""
    from npss_baselines.models import MODELS  # imports torch, which the other tables do not need

    rows = []
    for row in results.plan.rows.values():
        spec = MODELS.get(row.model) if "table-1" in row.tables else None
        if spec is not None and spec.published is not None:
            n = spec.parameters()
            rows.append([row.model, f"{spec.published:,}", f"{n:,}", f"{n - spec.published:+,}"])
    return Table("Table 1: parameters", ["model", "published", "here", "difference"], rows, [], n_text=1)


def table_4(results: Results, action: str) -> Table:
    """Return Table 4: NPSS over four seconds."""
    rows = []
    for row in shown(results, "table-4", action):
        rows.append(
            [
                *named(row),
                _published(row, action, "npss", "released"),
                *(
                    _cell(results, row, action, "npss", convention, protocol=protocol)
                    for protocol in (EIGHT, MANY)
                    for convention in ("released", "paper")
                ),
            ]
        )
    header = [
        "model",
        "recipe",
        "published",
        "`released`",
        "`paper`",
        "`released`, 256 windows",
        "`paper`, 256 windows",
    ]
    found = [results.of(action, protocol) for protocol in (EIGHT, MANY)]
    lines = signatures([of for rows_of in found for of in rows_of.values()], "npss", ("released", "paper"))
    notes = [_missing(results, "table-4", action), lines]
    return Table(f"Table 4, {action}: NPSS over four seconds", header, rows, _notes(notes))


def table_5(results: Results, action: str, *, unwrap: str = "off") -> Table:
    """Return Table 5: NPSS by window of time; perhaps without jumps of 2 pi."""
    rows: list[list[str]] = []
    for row in shown(results, "table-5", action):
        lines = [("published", [_published(row, action, "npss_windows", window) for window in WINDOWS])]
        if unwrap != "off":
            lines = []  # published numbers include the jumps
        for convention in ("released", "paper"):
            cells = [_cell(results, row, action, "npss", convention, window, unwrap=unwrap) for window in WINDOWS]
            lines.append((f"`{convention}`", cells))
        rows += _lines(row, lines)
    title = f"Table 5, {action}: NPSS by window of time" + (", jumps of 2π removed" if unwrap != "off" else "")
    of_action = results.of(action, EIGHT, unwrap)
    notes = [
        _missing(results, "table-5", action),
        *(signatures(of_action.values(), "npss", ("released", "paper"), window) for window in WINDOWS),
    ]
    return Table(title, ["model", "recipe", "NPSS", *(f"{window} s" for window in WINDOWS)], rows, _notes(notes), 3)


def euler_table(results: Results, action: str, name: str, times: Sequence[int]) -> Table:
    """Return Table 6 or 7: the Euler error by time."""
    rows: list[list[str]] = []
    for row in shown(results, name, action):
        cells = [_published(row, action, "euler_error", str(time)) for time in times]
        ours = [_cell(results, row, action, "euler_error", "", str(time)) for time in times]
        rows += _lines(row, [("published", cells), ("here", ours)])
    number = name.rpartition("-")[2]
    found = results.of(action)
    notes = [_missing(results, name, action), signatures(found.values(), "euler_error", [""])]
    header = ["model", "recipe", "Euler error", *(f"{time} ms" for time in times)]
    return Table(f"Table {number}, {action}: Euler error, radians", header, rows, _notes(notes), 3)


def parts(results: Results, action: str) -> Table:
    """Return what the score over four seconds is made of, and how fast the prediction moves."""
    rows = []
    for row in shown(results, "parts", action):
        record = results.of(action)[row.name].record
        if "parts" in record:
            made_of = [record["parts"][name] for name in ("released", "paper")]
            cells = [_short(made[part]) for made in made_of for part in ("form", "share", "share_floor")]
            rows.append([*named(row), *cells, _short(record["speed_ratio"], 2)])
    columns = [f"`{name}`: {part}" for name in ("released", "paper") for part in ("form", "share", "share floor")]
    lines = signatures(results.of(action).values(), "npss", ("released", "paper"))
    return Table(f"Parts of the score, {action}", ["model", "recipe", *columns, "speed"], rows, [lines])


def best(results: Results, action: str) -> Table:
    """Return the smallest published number of each column of the tables, beside those of the fitted predictors."""
    rows = [row for row in results.plan.rows.values() if row.recipe == "fitted" and row.name in results.of(action)]
    if not any(record["action"] == action for record in _published_records()):
        rows = []  # there is nothing to compare with
    still = results.of(action).get("zero-velocity")
    cells = []
    columns = [("npss", "released", "", "`released`, 0-4 s")]
    columns += [("npss", "released", window, f"`released`, {window} s") for window in WINDOWS]
    columns += [("euler_error", "", str(time), f"Euler error, {time} ms") for time in SLICES_MS]
    for metric, convention, at, heading in columns if rows else ():
        section = "npss_windows" if metric == "npss" and at else metric
        least = min(value for _, value in _published_column(action, section, at or convention))
        if metric == "euler_error" and still is not None:
            least = min(least, still.number(metric, convention, at).value)
        ours = [results.of(action)[row.name].number(metric, convention, at) for row in rows]
        marked = [f"**{_value(number)}**" if number.value < least else _value(number) for number in ours]
        cells.append([heading, _short(least), *marked])
    header = ["number", "to beat", *(row.name for row in rows)]
    note = (
        "To beat: the smallest published number of any model; for Euler errors, zero-velocity as measured here if that "
        "is lower. In bold: below it. Euler errors are in radians."
    )
    found = [results.of(action)[row.name] for row in rows]
    lines = [signatures(found, "npss", ["released"], window) for window in ("", *WINDOWS)]
    lines.append(signatures(found, "euler_error", [""]))
    title = f"The best published numbers and the fitted predictors, {action}"
    return Table(title, header, cells, [note, "  \n".join(lines)] if rows else [], 1)


def ablation(results: Results) -> Table:
    """Return the ablation: the model without one part each, and the difference."""
    rows, action = [], "walking"
    whole = results.of(action).get("vgru-d")
    for row in shown(results, "ablation", action):
        number = _number(results, row, action, "npss", "released")
        difference = ""
        if whole is not None and number is not None and row.recipe == whole.row.recipe and row.name != "vgru-d":
            difference = _signed(number.value - whole.number("npss", "released").value)
        cells = [
            _cell(results, row, action, "npss", convention, protocol=protocol)
            for protocol in (EIGHT, MANY)
            for convention in ("released", "paper")
        ]
        euler = [_cell(results, row, action, "euler_error", "", time) for time in ("400", "1000")]
        found = results.of(action).get(row.name)
        speed = "" if found is None or "speed_ratio" not in found.record else _short(found.record["speed_ratio"], 2)
        rows.append([*named(row), *cells[:1], difference, *cells[1:], *euler, speed])
    header = ["model", "recipe", "`released`", "minus vgru-d", "`paper`", "`released`, 256 windows"]
    header += ["`paper`, 256 windows", "Euler error, 400 ms", "Euler error, 1000 ms", "speed"]
    notes = [_missing(results, "ablation", action)]
    return Table("Ablation, walking: the model without one part", header, rows, _notes(notes))


def reproduces(results: Results) -> Table:
    """Return the published numbers that have a row here, and how far the row is from them."""
    rows = []
    for action in results.actions:
        for found in results.of(action).values():
            compared = []
            for metric, convention, at in (("npss", "released", ""), ("euler_error", "", "400")):
                theirs = published_value(found.row, action, metric, at or convention)
                ours = found.number(metric, convention, at)
                share = "" if theirs is None else _per_cent(ours.value / theirs - 1)
                compared += ["" if theirs is None else _as_published(theirs), _value(ours) if share else "", share]
            if any(compared):
                rows.append([*named(found.row), action, *compared])
    header = ["model", "recipe", "action", "`released`, published", "here", "difference"]
    header += ["Euler error at 400 ms, published", "here", "difference"]
    return Table("Published and measured", header, rows, [], 3)


def table_2(results: Results, action: str) -> Table:
    """Return Table 2: ranks of the models of the paper, by its tables and, if all have records, by these."""
    theirs = {}
    names = {row: PUBLISHED[row] for row in TABLE_2}
    for metric in ("euler_error", "released"):
        try:
            scores = study.model_scores(_published_records(), list(names.values()), action=action, metric=metric)
        except ValueError:  # the paper has no such action
            return Table("", [], [], [])
        ranks = study.rank(scores)
        theirs[metric] = {row: str(ranks[name]) for row, name in names.items()}
    missing = [row for row in names if row not in results.of(action)]
    measured = () if missing else METRICS
    ours = [ranks_of(results, action, protocol, metric, TABLE_2) for _, protocol, metric in measured]
    rows = [
        [row, theirs["euler_error"][row], theirs["released"][row], *(ranks[row] for ranks in ours)]
        for row in sorted(names, key=lambda row: int(theirs["released"][row]))
    ]
    header = ["model", "Table 7", "Table 4", *(heading for heading, *_ in measured)]
    notes = ["Ranks among these models. Table 7, Euler error: the sum over its six times, as the paper ranks."]
    if missing:
        notes.append(f"Not yet ranked here: {', '.join(missing)} {'have' if len(missing) > 1 else 'has'} no record.")
    else:
        (euler, released), (their_euler, their_released) = ours[:2], theirs.values()
        notes.append(
            f"Pairs of models in the order of the paper: {_in_order(euler, their_euler)} by Euler error, "
            f"{_in_order(released, their_released)} by `released`. In the same order by Euler error and by `released`: "
            f"{_in_order(euler, released)} here, {_in_order(their_euler, their_released)} in the paper."
        )
    return Table(f"Table 2, {action}: ranks", header, rows, notes, 1)


def rankings(results: Results, action: str) -> Table:
    """Return the ranks of all rows on an action by each metric and convention."""
    ours = {heading: ranks_of(results, action, protocol, metric) for heading, protocol, metric in METRICS}
    columns = {heading: ranks for heading, ranks in ours.items() if ranks}
    rows = [
        [*named(found.row), *(ranks.get(row, "") for ranks in columns.values())]
        for row, found in results.of(action).items()
    ]
    rows.sort(key=lambda cells: int(cells[3] or 0) if len(cells) > 3 else 0)
    return Table(f"Ranks, {action}", ["model", "recipe", *columns], rows, ["Euler error: the sum over the six times."])


def disagreements(results: Results, action: str) -> Table:
    """Return how many pairs of rows each two metrics put in a different order."""
    ranks, scores = {}, {}
    for heading, protocol, metric in METRICS:
        found = _scores(results, action, protocol, metric)
        # NPSS does not tell running averages from zero-velocity, so their pairs would count one difference thrice.
        found = {row: score for row, score in found.items() if not row.startswith("running-average")}
        if len(found) > 1:
            ranks[heading], scores[heading] = study.rank(found), found
    counts: dict[tuple[str, str], str] = {}
    notes = [DISAGREEMENTS] if ranks else []
    for one, other in combinations(ranks, 2):
        pairs = list(combinations([row for row in ranks[one] if row in ranks[other]], 2))
        differ = [(a, b) for a, b in pairs if (ranks[one][a] - ranks[one][b]) * (ranks[other][a] - ranks[other][b]) < 0]
        counts[one, other] = f"{len(differ)} of {len(pairs)}"
        if differ:
            pair = max(differ, key=lambda pair: min(_gap(scores[one], pair), _gap(scores[other], pair)))
            first, second = sorted(pair, key=lambda row: scores[one][row])
            notes.append(f"- {one}: {first} before {second}; {other}: {second} before {first}.")
    rows = [[one, *(counts.get((one, other), "") for other in list(ranks)[1:])] for one in list(ranks)[:-1]]
    lines = [notes[0], "\n".join(notes[1:])] if len(notes) > 1 else []
    return Table(f"Pairs in a different order, {action}", ["", *list(ranks)[1:]], rows, lines, 1)


def numbers(results: Results) -> str:
    """Return every number as CSV, with its spread, interval and signature, and what each score is made of."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(
        ["row", "model", "recipe", "action", "metric", "convention", "at", "value", "seeds", "std_over_seeds"]
        + ["draws", "std_over_draws", "low", "high", "interval", "signature"]
    )
    for found in results.all():
        for number in found.numbers():
            span = _span(results, found, number)
            ends = ["", "", ""] if span is None else [_digits(span.low), _digits(span.high), span.kind]
            writer.writerow(
                [found.row.name, found.row.model, found.row.recipe, found.action, number.metric, number.convention]
                + [number.at, _digits(number.value), len(found.seeds), _digits(number.over_seeds), found.draws]
                + [_digits(number.over_draws), *ends, number.signature]
            )
        for metric, convention, value, line in _made_of(found):
            writer.writerow(
                [
                    found.row.name,
                    found.row.model,
                    found.row.recipe,
                    found.action,
                    metric,
                    convention,
                    "",
                    _digits(value),
                ]
                + [len(found.seeds), "", found.draws, "", "", "", "", line]
            )
    return file.getvalue()


def _made_of(found: Measured) -> Iterator[tuple[str, str, float, str]]:
    """Yield the parts of each score and the speed: metric, convention, value and signature."""
    for convention, made_of in found.record.get("parts", {}).items():
        line = found.number("npss", convention).signature
        for part, value in made_of.items():
            if value is not None:  # `literal` has no floor
                yield f"npss_{part}", convention, value, line
    if "speed_ratio" in found.record:
        stated = parse_signature(found.record["signature"])
        kept = ("representation", "frames", "fps", "protocol", "unwrap", "draws")
        context = {name: stated[name] for name in kept if name in stated}
        line = signature(None, metric="speed_ratio", extra={"start": FPS}, **context)
        yield "speed_ratio", "", found.record["speed_ratio"], line


def package_data(results: Results) -> str:
    """Return the small table of package ``npss``, in the form of its published numbers, as CSV."""
    file = io.StringIO()
    writer = csv.writer(file, lineterminator="\n")
    writer.writerow(
        ["table", "model", "recipe", "action", "metric", "convention", "at", "frames", "value", "seeds", "spread"]
        + ["draws"]
    )
    for found in results.all():
        if (found.protocol, found.unwrap) != (EIGHT, "off") or found.row.tables == ("ablation",):
            continue
        for number in found.numbers():
            if number.convention == "literal":
                continue
            place = "6" if "table-6" in found.row.tables and "table-7" not in found.row.tables else "7"
            place = place if number.metric == "euler_error" else "5" if number.at else "4"
            writer.writerow(
                [place, found.row.name, found.row.recipe, found.action, number.metric, number.convention, number.at]
                + [100, _digits(number.value), len(found.seeds)]
                + [_digits(number.over_seeds), found.draws]
            )
    return file.getvalue()


def filled(template: str, results: Results) -> str:
    """Fill a page: ``{{ table-4-walking }}`` with a table, ``{{ ROW ACTION NUMBER }}`` with a number of a record.

    Parameters
    ----------
    template : str
        The text. ``NUMBER`` is a convention, a convention and a window (``released 0-1``), or milliseconds; a protocol
        may follow (default: the eight windows), and ``unwrapped``.
    results : Results
        The results.

    Returns
    -------
    str
        The page.

    Raises
    ------
    ValueError
        If there is no such table or number; names it.
    """
    made = all_tables(results)

    def text(match: re.Match[str]) -> str:
        words = match[1].split()
        if len(words) == 1:
            if words[0] not in made:
                raise ValueError(f"template: no table {words[0]!r}; expected one of {', '.join(made)}")
            return made[words[0]].markdown()
        row, action, name, *others = words
        unwrap = "target" if "unwrapped" in others else "off"
        protocol = next((word for word in others if word in results.protocols), EIGHT)
        window = next((word for word in others if word in WINDOWS), "")
        found = results.of(action, protocol, unwrap).get(row)
        if found is None:
            raise ValueError(f"template: no record for {match[0]}")
        if name.isdigit():
            return _short(found.number("euler_error", "", name).value)
        return _short(found.number("npss", name, window).value)

    return re.sub(r"\{\{ (.*?) \}\}", text, template)


def write(results: Results, folder: Path) -> None:
    """Write every table as Markdown, and every number as CSV."""
    folder.mkdir(parents=True, exist_ok=True)
    for name, made in all_tables(results).items():
        if not made.rows:
            continue
        write_text_atomically(folder / f"{name}.md", f"# {made.title}\n\n{made.markdown()}\n\n{EXPLAINED}\n")
    write_text_atomically(folder / "numbers.csv", numbers(results))


def shown(results: Results, name: str, action: str) -> list[Row]:
    """Return the rows of a table with numbers on an action, measured or published, untrained ones on top."""
    of_action, section = results.of(action), "npss" if name == "table-4" else "npss_windows"
    at = {"table-4": "released", "table-5": WINDOWS[0], "table-6": "80", "table-7": "1000"}.get(name)
    section = section if name in ("table-4", "table-5") else "euler_error"
    rows: list[Row] = []
    for row in results.plan.rows.values():
        of_table = name in row.tables or row.recipe == UNTRAINED or (name == "parts" and "table-4" in row.tables)
        known = at is not None and published_value(row, action, section, at) is not None
        new = PUBLISHED.get(row.name) not in [PUBLISHED.get(other.name) for other in rows]
        if of_table and (row.name in of_action or (known and new)):
            rows.append(row)
    return sorted(rows, key=lambda row: row.recipe != UNTRAINED)


def wraps(results: Results, action: str) -> bool:
    """Return whether removing jumps of 2 pi changes a score of the eight windows."""
    with_jumps, without = results.of(action), results.of(action, EIGHT, "target")
    return any(
        without[row].number("npss", "paper").value != found.number("npss", "paper").value
        for row, found in with_jumps.items()
        if row in without
    )


def named(row: Row) -> list[str]:
    """Return the cells that name a row: its name and recipe."""
    return [row.name, row.recipe]


def signatures(found: Any, metric: str, conventions: Sequence[str], at: str = "") -> str:
    """Return the signatures of numbers as lines of code."""
    lines = dict.fromkeys(
        number.signature
        for convention in conventions
        for measured in found
        for number in measured.numbers()
        if (number.metric, number.convention) == (metric, convention) and (number.at == at or not convention)
    )
    return "  \n".join(map(markdown_code, lines))


def ranks_of(
    results: Results, action: str, protocol: str, metric: str, rows: Sequence[str] | None = None
) -> dict[str, str]:
    """Return the ranks of rows by a metric, as text."""
    scores = _scores(results, action, protocol, metric)
    if rows is not None:
        scores = {row: score for row, score in scores.items() if row in rows}
    return {row: str(rank) for row, rank in study.rank(scores).items()}


def _in_order(one: dict[str, str], other: dict[str, str]) -> str:
    """Return how many pairs of rows two rankings put in the same order, of all."""
    pairs = list(combinations(one, 2))
    same = [(int(one[a]) - int(one[b])) * (int(other[a]) - int(other[b])) > 0 for a, b in pairs]
    return f"{sum(same)} of {len(pairs)}"


def _scores(results: Results, action: str, protocol: str, metric: str) -> dict[str, float]:
    """Return the score of each row; the Euler error is the sum over the six times."""
    scores = {}
    for row, found in results.of(action, protocol).items():
        if metric == "euler_error":
            scores[row] = sum(found.number(metric, "", str(time)).value for time in SLICES_MS)
        else:
            scores[row] = found.number("npss", metric).value
    return scores


def _gap(scores: dict[str, float], pair: tuple[str, str]) -> float:
    one, other = (scores[row] for row in pair)
    return abs(one - other) / max(one, other)


def _lines(row: Row, lines: Sequence[tuple[str, Sequence[str]]]) -> Iterator[list[str]]:
    """Yield the lines of a row that have numbers; only the first names it."""
    name = named(row)
    for label, cells in lines:
        if any(cells):
            yield [*name, label, *cells]
            name = ["", ""]


def _number(
    results: Results,
    row: Row,
    action: str,
    metric: str,
    convention: str,
    at: str = "",
    *,
    protocol: str = EIGHT,
    unwrap: str = "off",
) -> Number | None:
    found = results.of(action, protocol, unwrap).get(row.name)
    return None if found is None else found.number(metric, convention, at)


def _cell(
    results: Results,
    row: Row,
    action: str,
    metric: str,
    convention: str,
    at: str = "",
    *,
    protocol: str = EIGHT,
    unwrap: str = "off",
) -> str:
    """Return a number as a cell: its value and spread over seeds; below, its interval and spread over draws."""
    found = results.of(action, protocol, unwrap).get(row.name)
    if found is None:
        return ""
    number = found.number(metric, convention, at)
    span = _span(results, found, number)
    below = [] if span is None else [f"{_short(span.low)}–{_short(span.high)}"]
    if number.over_draws is not None:
        below.append(f"draws {_spread(number.over_draws)}")
    return _value(number) + (f"<br><small>{'; '.join(below)}</small>" if below else "")


def _span(results: Results, found: Measured, number: Number) -> Any:
    window = number.at if number.metric == "npss" else ""
    spans = results.spans(found.action, found.protocol, found.unwrap, window)
    return spans.get((found.row.name, number.convention or number.at))


def published_value(row: Row, action: str, section: str, at: str) -> float | None:
    """Return a published number: NPSS by convention, a window of Table 5, or the Euler error at a time."""
    column = _published_column(action, section, at)
    return next((value for model, value in column if model == PUBLISHED.get(row.name)), None)


def _published_column(action: str, section: str, at: str) -> Iterator[tuple[str, float]]:
    """Yield the models and published numbers of one column of a table."""
    for record in _published_records():
        numbers = record.get(section, {}) if record["action"] == action else {}
        numbers = numbers.get("released", {}) if section == "npss_windows" else numbers
        if at in numbers:
            yield record["model"], float(numbers[at])


@cache
def _published_records() -> list[Record]:
    return published.records()


def _published(row: Row, action: str, section: str, at: str) -> str:
    value = published_value(row, action, section, at)
    return "" if value is None else _as_published(value)


def _as_published(value: float) -> str:
    """Return a number with the digits that were published, at least two."""
    return _short(value, len(str(value).partition(".")[2]))


def _value(number: Number) -> str:
    spread = number.over_seeds
    return _short(number.value) if spread is None else f"{_short(number.value)} {_spread(spread)}"


def _spread(std: float) -> str:
    return f"±{_short(std)}" if std >= 0.0005 else "±<.001"


def _signed(difference: float) -> str:
    return ("-" if difference < 0 else "+") + _short(abs(difference))


def _per_cent(share: float) -> str:
    text = f"{100 * share:+.0f} %"
    return "0 %" if text in ("+0 %", "-0 %") else text


def _short(value: float, digits: int = 3) -> str:
    """Return a number without the zero before the point."""
    text = f"{value:.{max(2, min(digits, 3))}f}"
    return text.replace("0.", ".", 1) if text.lstrip("-").startswith("0.") else text


def _digits(value: float | None) -> str:
    return "" if value is None else f"{value:.6g}"


def _missing(results: Results, name: str, action: str) -> str:
    """Return a line about the runs of a table that have no record."""
    rows: dict[tuple[int, ...], list[str]] = {}
    for row in results.plan.rows.values():
        seeds = results.missing(row, action) if name in row.tables else ()
        if seeds:
            rows.setdefault(seeds, []).append(row.name)
    parts = [f"{', '.join(names)} (seed {', '.join(map(str, seeds))})" for seeds, names in rows.items()]
    return markdown_text(f"Not yet measured: {'; '.join(parts)}.") if parts else ""


def _notes(notes: Sequence[str]) -> list[str]:
    return [note for note in notes if note]
