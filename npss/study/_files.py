"""Files of votes: CSV as spreadsheets and surveys write it, read strictly."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from io import StringIO
from os import PathLike
from pathlib import Path
from typing import TypeVar

from npss.files._text import read_text
from npss.files._write import write_text_atomically
from npss.study._design import CHOICES, SIDES, Question
from npss.study._votes import Vote

#: The columns of a file of votes.
COLUMNS = ("action", "question", "sequence", "model_a", "model_b", "participant", "choice")
#: Columns that a file may have beside them, with empty cells where there is nothing to tell.
OPTIONAL = ("position", "expected")
_Answer = TypeVar("_Answer", bound=str)
_DELIMITERS = (",", ";", "\t")


def read_votes(*paths: str | PathLike[str]) -> list[Vote]:
    """Read the votes of a study from CSV files: one for all participants, or one for each.

    The first line names the columns: action, question, sequence, model_a, model_b, participant, choice. Each further
    line is a vote. Questions are numbered within an action; the choice is A (model_a), B (model_b) or tie. Two further
    columns are optional: position, the place of the question in the participant's survey, and expected, the answer A
    or B to an attention check. Their cells may be empty. One participant may have seen a question with model_a and
    model_b swapped, which is still the same question.

    Cells are separated by commas, semicolons or tabs. Blanks around a cell and blank lines are ignored; the line of
    column names may be repeated, as in concatenated files.

    Parameters
    ----------
    *paths : path-like
        The files, in UTF-8; a folder stands for all ``.csv`` files in it that are not hidden.

    Returns
    -------
    list of Vote
        The votes in the order of the files; files of a folder are sorted by name.

    Raises
    ------
    TypeError
        If no path is given.
    ValueError
        If a folder has no ``.csv`` file, a file has no votes, a line is not as described, a participant answers a
        question twice, or participants answer different questions under one number. The message names the file and the
        line.
    OSError
        If a file cannot be opened.

    See Also
    --------
    write_votes : writes such a file.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from npss import study
    >>> vote = study.Vote("walking", study.Question(1, 4, "GRU-d", "VGRU-d"), "p07", "B")
    >>> with TemporaryDirectory() as folder:
    ...     study.write_votes(Path(folder) / "votes.csv", [vote])
    ...     study.read_votes(Path(folder) / "votes.csv") == [vote]
    True
    """
    if not paths:
        raise TypeError("paths: expected at least one file")
    votes: list[Vote] = []
    asked: dict[tuple[str, int], Question] = {}
    answered: dict[tuple[str, int, str], str] = {}
    for path in _files(map(Path, paths)):
        before = len(votes)
        for where, cells in _lines(path):
            vote = _read_vote(where, cells)
            action, number = key = vote.action, vote.question.number
            if asked.setdefault(key, vote.question) not in (vote.question, vote.question.mirrored()):
                raise ValueError(f"{where}: question {number} of {action} differs from before: {asked[key]}")
            answer = (*key, vote.participant)
            if answer in answered:
                raise ValueError(
                    f"{where}: participant {vote.participant!r} answers question {number} of {action} again, "
                    f"after {answered[answer]}"
                )
            answered[answer] = where
            votes.append(vote)
        if len(votes) == before:
            raise ValueError(f"{path}: no votes in it")
    return votes


def write_votes(path: str | PathLike[str], votes: Sequence[Vote]) -> None:
    """Write votes to a CSV file, as `read_votes` reads it; without optional columns where no vote needs them.

    Parameters
    ----------
    path : path-like
        The file. If it exists, it is replaced.
    votes : sequence of Vote
        The votes.

    Returns
    -------
    None

    Raises
    ------
    ValueError
        If a name is empty, or has surrounding blanks or carriage returns, which `read_votes` would not return.
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from npss import study
    >>> with TemporaryDirectory() as folder:
    ...     study.write_votes(Path(folder) / "votes.csv", [])
    ...     print((Path(folder) / "votes.csv").read_text(encoding="utf-8"), end="")
    action,question,sequence,model_a,model_b,participant,choice
    """
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    cells: list[dict[str, int | str | None]] = [
        {"position": vote.position, "expected": vote.question.expected} for vote in votes
    ]
    optional = [name for name in OPTIONAL if any(of_vote[name] for of_vote in cells)]
    writer.writerow((*COLUMNS, *optional))
    for index, vote in enumerate(votes, 1):
        asked = vote.question
        for name in (vote.action, asked.model_a, asked.model_b, vote.participant):
            if not name or name != name.strip() or "\r" in name:
                raise ValueError(
                    f"votes: expected names without surrounding blanks or carriage returns, got {name!r} in vote "
                    f"{index}"
                )
        row = (vote.action, asked.number, asked.sequence, asked.model_a, asked.model_b)
        writer.writerow((*row, vote.participant, vote.choice, *(cells[index - 1][name] for name in optional)))
    write_text_atomically(Path(path), text.getvalue())


def _files(paths: Iterable[Path]) -> Iterator[Path]:
    """Yield the files, and the files in folders."""
    for path in paths:
        if not path.is_dir():
            yield path
            continue
        inside = sorted(file for file in path.iterdir() if file.suffix.lower() == ".csv" and file.name[0] != ".")
        if not inside:
            raise ValueError(f"{path}: no .csv files in it")
        yield from inside


def _lines(path: Path) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield the file and line of each vote, for errors, and its cells."""
    # Concatenated files may have byte order marks inside.
    text = re.sub("^\ufeff", "", read_text(path), flags=re.MULTILINE)
    first = next((line for line in text.split("\n") if line.strip()), "")
    delimiter = max(_DELIMITERS, key=first.count)
    reader = csv.reader(StringIO(text, newline=""), delimiter=delimiter, skipinitialspace=True, strict=True)
    header: list[str] = []
    line = 1
    try:
        for row in reader:
            where, line = f"{path}: line {line}", reader.line_num + 1
            cells = [cell.strip() for cell in row]
            if not any(cells):
                continue
            if {*COLUMNS} <= {*cells} <= {*COLUMNS, *OPTIONAL} and len({*cells}) == len(cells):
                header = cells
                continue
            if not header:
                raise ValueError(f"{where}: expected the columns {', '.join(COLUMNS)}, got {', '.join(cells)!r}")
            if len(cells) != len(header):
                raise ValueError(f"{where}: expected {len(header)} cells, got {len(cells)}")
            yield where, dict(zip(header, cells, strict=True))
    except csv.Error as error:
        raise ValueError(f"{path}: line {line}: invalid CSV ({error})") from error


def _read_vote(where: str, cells: Mapping[str, str]) -> Vote:
    for name in COLUMNS:
        if not cells[name]:
            raise ValueError(f"{where}: {name} is empty")
    for name in ("question", "sequence"):
        if not re.fullmatch(r"[0-9]{1,9}", cells[name]):
            raise ValueError(f"{where}: {name}: expected a whole number, got {cells[name]!r}")
    if cells["model_a"] == cells["model_b"]:
        raise ValueError(f"{where}: model_a and model_b are both {cells['model_a']!r}")
    choice = _choice(where, "choice", cells["choice"], CHOICES)
    position = cells.get("position") or None
    if position is not None and not re.fullmatch(r"[1-9][0-9]{0,8}", position):
        raise ValueError(f"{where}: position: expected a whole number from 1, got {position!r}")
    expected = _choice(where, "expected", cells["expected"], SIDES) if cells.get("expected") else None
    question = Question(int(cells["question"]), int(cells["sequence"]), cells["model_a"], cells["model_b"], expected)
    return Vote(cells["action"], question, cells["participant"], choice, position and int(position))


def _choice(where: str, name: str, text: str, choices: Sequence[_Answer]) -> _Answer:
    for choice in choices:
        if text == choice:
            return choice
    raise ValueError(f"{where}: {name}: expected {', '.join(choices)}, got {text!r}")
