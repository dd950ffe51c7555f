"""The DataFrame of a leaderboard; the one module that needs pandas."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from functools import partial
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar

from npss._analysis.bootstrap import METHOD
from npss._analysis.interval import RANGE
from npss.extras import install_hint
from npss.files._write import write_atomically, write_text_atomically
from npss.ranking import _render
from npss.ranking._standings import TEST, Standing
from npss.validation import is_integer, renamed

try:
    import pandas as pd
    from pandas.io.common import infer_compression
except ImportError:
    raise ImportError(f"npss.Leaderboard and npss.leaderboard need pandas; {install_hint('pandas')}") from None


_COLUMNS = (
    *("model", "action", "column", "value", "low", "high", "rank", "best", "worse", "p_value", "source", "signature"),
    *("level", "in_blocks", "behind", "blocks", "seeds", "seed_low", "seed_high", "interval", "test"),
)
_TYPES = {
    **dict.fromkeys(("low", "high", "p_value", "in_blocks", "behind", "seed_low", "seed_high"), float),
    **dict.fromkeys(("rank", "blocks", "seeds"), "Int64"),
}


class Leaderboard(pd.DataFrame):  # type: ignore[misc]
    """Scores of models by actions and columns, with ranks, intervals and marks; `npss.leaderboard` makes it.

    It is a DataFrame. Selections of its models, actions and columns, copies and sorted ones are leaderboards too, and
    keep ranks and marks, which stay those among all models. What is computed from it (``board * 2``, ``board.T``) is a
    plain DataFrame.

    The writers ``to_text``, ``to_markdown``, ``to_latex`` and ``to_html`` write a table for each action, sorted by
    rank, with intervals, marks and signatures; ``to_csv`` writes `tidy`. They take `buf` as pandas' own writers do: a
    path or an open file to write to, or None to return text. For the tables of pandas itself, write
    ``pd.DataFrame(board)``.

    Attributes
    ----------
    tidy : pandas.DataFrame
        A row for each number: its interval, rank, p-value (of the difference from the best), signature and methods.
        ``in_blocks`` is the score of the sequences in blocks where some are left out, ``behind`` the share of blocks in
        which the best is better, ``seeds`` how many trained runs a method is the mean of, between which values.
    notes : tuple of str
        What is written below the tables: how intervals, marks and ranks were made.
    by : str or None
        The column by which tables are sorted and show ranks; None for the first one.
    level : float
        Of the confidence intervals.

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> rng = np.random.default_rng(0)
    >>> gt = rng.normal(size=(8, 50, 3)).cumsum(axis=1)
    >>> reports = {name: npss.report(gt, gt + size * rng.normal(size=gt.shape)) for name, size in (("a", 1), ("b", 9))}
    >>> board = npss.leaderboard({name: {"walking": report} for name, report in reports.items()})
    >>> isinstance(board.loc[["b"]], npss.Leaderboard), isinstance(board * 2, npss.Leaderboard)
    (True, False)
    >>> print(board["walking"].to_markdown(digits=2).splitlines()[0])
    ### walking (ranked by NPSS paper)
    """

    _metadata: ClassVar = ["_standings", "_notes", "by", "level"]  # what copies and pickles keep
    _standings: tuple[Standing, ...] = ()
    _notes: tuple[str, ...] = ()
    by: str | None = None
    level: float = 0.95

    @classmethod
    def of(cls, standings: Sequence[Standing], notes: Sequence[str], *, by: str | None, level: float) -> Leaderboard:
        """Lay standings out, models as rows, actions and columns as columns, in the order in which they come."""
        values: dict[tuple[str, str], dict[str, float]] = {}
        for standing in standings:
            result = standing.result
            values.setdefault((result.action, result.column), {})[result.label] = result.value
        models = list(dict.fromkeys(model for column in values.values() for model in column))
        columns = pd.MultiIndex.from_tuples(sorted(values, key=_order(values)), names=["action", "column"])
        rows = [[values[column].get(model, float("nan")) for column in columns] for model in models]
        board = cls(rows, index=pd.Index(models, name="model"), columns=columns, dtype=float)
        board._standings = tuple(standings)
        board._notes = tuple(notes)
        board.by = by
        board.level = level
        return board

    @property
    def standings(self) -> list[Standing]:
        """What is known of the numbers that the frame holds now.

        Raises
        ------
        ValueError
            If a value is none of the numbers of which it was made: names the place.
        """
        return _standings_in(pd.DataFrame(self), self._standings)

    @property
    def notes(self) -> tuple[str, ...]:
        """What is written below the tables."""
        models = {one.result.label for one in self._standings}
        shown = {one.result.label for one in self.standings}
        if shown == models:
            return self._notes
        return *self._notes, f"{len(shown)} of {len(models)} models; best, ranks and marks are those among all of them."

    @property
    def tidy(self) -> pd.DataFrame:
        """A row for each number: its interval, rank, p-value, signature and methods."""
        return pd.DataFrame(
            [
                {
                    **{name: getattr(one.result, name) for name in ("model", "action", "column", "value")},
                    **{name: getattr(one, name) for name in ("low", "high", "rank", "best", "worse", "p_value")},
                    **{name: getattr(one.result, name) for name in ("source", "signature")},
                    "level": self.level,
                    "in_blocks": one.in_blocks,
                    "behind": None if one.behind is None else one.behind[0] / one.behind[1],
                    "blocks": None if one.result.blocks is None else one.result.blocks.n,
                    "seeds": len(one.result.seeds) or None,
                    "seed_low": min(one.result.seeds, default=None),
                    "seed_high": max(one.result.seeds, default=None),
                    "interval": RANGE if one.is_range else METHOD,
                    "test": TEST,
                }
                for one in self.standings
            ],
            columns=_COLUMNS,
        ).astype(_TYPES)

    def to_text(self, buf: Any = None, *, digits: int | None = None) -> str | None:
        """Write the leaderboard for a terminal.

        Parameters
        ----------
        buf : path or open file, optional
            Where to write; by default the text is returned.
        digits : int, optional
            Decimal places; by default those of the metric.

        Returns
        -------
        str or None

        Raises
        ------
        TypeError, ValueError
            If `buf` is neither, `digits` is no whole number from 0 on, or a value of the frame was changed.
        """
        return self._written("to_text", _render.to_text, buf, digits, {})

    def to_markdown(self, buf: Any = None, *, digits: int | None = None, **options: Any) -> str | None:
        """Write the leaderboard in Markdown; parameters and errors as for `to_text`, and no option of pandas."""
        return self._written("to_markdown", partial(_render.to_text, markdown=True), buf, digits, options)

    def to_latex(self, buf: Any = None, *, digits: int | None = None, **options: Any) -> str | None:
        """Write LaTeX tables, for the package booktabs; parameters and errors as for `to_markdown`."""
        return self._written("to_latex", _render.to_latex, buf, digits, options)

    def to_html(self, buf: Any = None, *, digits: int | None = None, **options: Any) -> str | None:
        """Write HTML tables; parameters and errors as for `to_markdown`."""
        return self._written("to_html", _render.to_html, buf, digits, options)

    @renamed(path="path_or_buf")
    def to_csv(self, path_or_buf: Any = None, **options: Any) -> str | None:
        """Write `tidy` as CSV, unrounded.

        Parameters
        ----------
        path_or_buf : path or open file, optional
            Where to write; by default the text is returned.
        **options
            As for ``pandas.DataFrame.to_csv``; ``index`` is False unless you say otherwise.

        Returns
        -------
        str or None

        Raises
        ------
        TypeError, ValueError
            As pandas; or if a value of the frame was changed.
        """
        tidy, options = self.tidy, {"index": False, **options}
        how = options.get("compression", "infer")
        whole = not {"mode", "storage_options"} & options.keys() and not isinstance(how, Mapping)
        if isinstance(path_or_buf, str | PathLike) and whole:
            # pandas would see from the path, which is another one while it is written, whether to compress.
            options["compression"] = infer_compression(path_or_buf, how)
            write_atomically(Path(path_or_buf).expanduser(), lambda part: tidy.to_csv(part, **options))
            return None
        written: str | None = tidy.to_csv(path_or_buf, **options)
        return written

    @property
    def _constructor(self) -> Any:
        """What pandas calls with the frames that it makes from this one."""
        return partial(_derived, self)

    def _written(self, name: str, render: Any, buf: Any, digits: int | None, options: Mapping[str, Any]) -> str | None:
        """Write the tables to `buf`, or return them."""
        if options:
            option = next(iter(options))
            raise TypeError(
                f"{name}(): a leaderboard has no option {option!r}; "
                f"pd.DataFrame(board).{name}({option}=...) writes the table of pandas"
            )
        if digits is not None and not is_integer(digits):
            raise TypeError(f"digits: expected a whole number, got {digits!r}")
        if digits is not None and digits < 0:
            raise ValueError(f"digits: expected a whole number from 0 on, got {digits}")
        text: str = render(self.standings, self.notes, by=self.by, digits=digits)
        if buf is None:
            return text
        if isinstance(buf, str | PathLike):
            write_text_atomically(Path(buf).expanduser(), text)
        elif hasattr(buf, "write"):
            buf.write(text)
        else:
            raise TypeError(f"buf: expected a path or a file that is open for writing, got {buf!r}")
        return None


def _derived(board: Leaderboard, *args: Any, **kwargs: Any) -> pd.DataFrame:
    """Return a frame that pandas made from a leaderboard: a leaderboard where all its numbers are some of that one."""
    frame = pd.DataFrame(*args, **kwargs)
    try:
        _standings_in(frame, board._standings)
    except ValueError:
        return frame
    derived = Leaderboard(frame)
    for name in Leaderboard._metadata:
        setattr(derived, name, getattr(board, name))
    return derived


def _standings_in(frame: pd.DataFrame, standings: Iterable[Standing]) -> list[Standing]:
    """Return the standings of the numbers that a frame holds, in the order of its columns.

    Its columns are actions and columns, or, as in ``board["walking"]``, columns of the one action with such numbers.

    Raises
    ------
    ValueError
        If it holds anything else: names the first place.
    """
    if not (frame.index.is_unique and frame.columns.is_unique):
        raise ValueError("duplicate models or columns in the frame of a leaderboard")
    known: dict[str, dict[tuple[str, str], dict[str, Standing]]] = {}
    for one in standings:
        result = one.result
        known.setdefault(result.action, {}).setdefault((result.action, result.column), {})[result.label] = one
    if frame.columns.nlevels > 1:
        every = {column: of_column for columns in known.values() for column, of_column in columns.items()}
        return _standings_at(frame, list(frame.columns), every)
    found = []
    for action, columns in known.items():
        try:
            found.append(_standings_at(frame, [(action, column) for column in frame.columns], columns))
        except ValueError:
            continue
    if len(found) != 1:
        raise ValueError("the columns of the frame are not those of one action of the leaderboard")
    return found[0]


def _standings_at(
    frame: pd.DataFrame, columns: Sequence[Any], known: Mapping[Any, Mapping[Any, Standing]]
) -> list[Standing]:
    found: list[Standing] = []
    for column, values in zip(columns, frame.to_numpy().T, strict=True):
        held = set()
        for model, value in zip(frame.index, values, strict=True):
            one = known.get(column, {}).get(model)
            if not isinstance(value, float) or (value == value and (one is None or one.result.value != value)):
                raise ValueError(
                    f"{model!r}, {column!r}: not the leaderboard's value; write pd.DataFrame(board) instead"
                )
            if value == value:
                held.add(model)
        found += [one for model, one in known.get(column, {}).items() if model in held]
    return found


def _order(values: dict[tuple[str, str], Any]) -> Any:
    """Return a key that keeps the columns of an action together, in the order in which actions come."""
    actions = list(dict.fromkeys(action for action, _ in values))
    places = {column: place for place, column in enumerate(values)}
    return lambda column: (actions.index(column[0]), places[column])
