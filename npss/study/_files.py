"""The file of votes: CSV, read strictly."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from io import StringIO
from os import PathLike
from pathlib import Path

from npss.study._design import Question
from npss.study._votes import CHOICES, Vote

#: The columns of a file of votes.
COLUMNS = ("action", "question", "sequence", "model_a", "model_b", "participant", "choice")


def read_votes(*paths: str | PathLike[str]) -> list[Vote]:
    """Read the votes of a study from CSV files: one of all participants, or one of each.

    The first line names the columns: action, question, sequence, model_a, model_b, participant, choice. Every further
    line is a vote. Questions are numbered within an action; the choice is A (model_a), B (model_b) or tie.

    Parameters
    ----------
    *paths : path-like
        The files, UTF-8.

    Returns
    -------
    list of Vote
        In the order of the files.

    Raises
    ------
    TypeError
        If no file is named.
    ValueError
        If a file has no votes, a line is not as described, a participant answers a question twice, or a question is
        not the same for all. The message names the file and the line.
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
    for path in paths:
        before = len(votes)
        for where, cells in _lines(Path(path)):
            vote = _read_vote(where, cells)
            action, number = key = vote.action, vote.question.number
            if asked.setdefault(key, vote.question) != vote.question:
                raise ValueError(f"{where}: question {number} of {action} is another one than before: {asked[key]}")
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
    """Write votes to a CSV file, as `read_votes` reads it.

    Parameters
    ----------
    path : path-like
        The file. If it exists, it is overwritten.
    votes : sequence of Vote
        The votes.

    Returns
    -------
    None

    Raises
    ------
    OSError
        If the file cannot be written.

    Examples
    --------
    >>> from pathlib import Path
    >>> from tempfile import TemporaryDirectory
    >>> from npss import study
    >>> with TemporaryDirectory() as folder:
    ...     study.write_votes(Path(folder) / "votes.csv", [])
    ...     print((Path(folder) / "votes.csv").read_text(), end="")
    action,question,sequence,model_a,model_b,participant,choice
    """
    with Path(path).open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for vote in votes:
            asked = vote.question
            row = (vote.action, asked.number, asked.sequence, asked.model_a, asked.model_b)
            writer.writerow((*row, vote.participant, vote.choice))


def _lines(path: Path) -> Iterator[tuple[str, dict[str, str]]]:
    """Yield where each line after the first is, for errors to begin with, and its cells."""
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = error.object[: error.start].count(b"\n") + 1
        raise ValueError(f"{path}: line {line}: not UTF-8 ({error.reason})") from error
    reader = csv.reader(StringIO(text, newline=""), strict=True)
    try:
        header = next(reader, [])
        if sorted(header) != sorted(COLUMNS):
            raise ValueError(f"{path}: line 1: expected the columns {', '.join(COLUMNS)}, got {', '.join(header)!r}")
        for cells in reader:
            where = f"{path}: line {reader.line_num}"
            if len(cells) != len(header):
                raise ValueError(f"{where}: expected {len(header)} cells, got {len(cells)}")
            yield where, dict(zip(header, cells, strict=True))
    except csv.Error as error:
        raise ValueError(f"{path}: line {reader.line_num}: not CSV ({error})") from error


def _read_vote(where: str, cells: Mapping[str, str]) -> Vote:
    for name in COLUMNS:
        if not cells[name] or cells[name] != cells[name].strip():
            raise ValueError(f"{where}: {name}: expected text without blanks around it, got {cells[name]!r}")
    for name in ("question", "sequence"):
        if not re.fullmatch(r"[0-9]{1,9}", cells[name]):
            raise ValueError(f"{where}: {name}: expected a whole number, got {cells[name]!r}")
    if cells["model_a"] == cells["model_b"]:
        raise ValueError(f"{where}: model_a and model_b are both {cells['model_a']!r}")
    if cells["choice"] not in CHOICES:
        raise ValueError(f"{where}: choice: expected {', '.join(CHOICES)}, got {cells['choice']!r}")
    question = Question(int(cells["question"]), int(cells["sequence"]), cells["model_a"], cells["model_b"])
    return Vote(cells["action"], question, cells["participant"], cells["choice"])
