"""The DataFrame of a leaderboard; the only module that needs pandas."""

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
    *("level", "in_blocks", "behind", "blocks", "seeds", "seed_low", "seed_high"),
    *("samples", "sample_low", "sample_high", "interval", "test"),
)
_TYPES = {
    **dict.fromkeys(("low", "high", "p_value", "in_blocks", "behind", "seed_low", "seed_high"), float),
    **dict.fromkeys(("sample_low", "sample_high"), float),
    **dict.fromkeys(("rank", "blocks", "seeds", "samples"), "Int64"),
}


class Leaderboard(pd.DataFrame):  # type: ignore[misc]
    """Scores of models by action and column, with ranks, intervals and marks, from `npss.leaderboard`.

    It is a DataFrame. Selections of its models, actions and columns, copies and sorted copies are leaderboards, too.
    They keep the ranks and marks among all models. Results of computations (``board * 2``, ``board.T``) are plain
    DataFrames.

    The writers ``to_text``, ``to_markdown``, ``to_latex`` and ``to_html`` write a table for each action (with
    ``wide=True`` one for each column, with actions side by side), sorted by rank, with intervals, marks and signatures;
    ``to_csv`` writes `tidy`. As in pandas, `buf` is a path or an open file
    to write to, or None to return text. For the tables of pandas, use ``pd.DataFrame(board)``.

    Attributes
    ----------
    tidy : pandas.DataFrame
        A row for each number: its interval, rank, p-value (of the difference from the best), signature and methods.
        ``in_blocks`` is the score of the sequences in blocks, if some are in none; ``behind`` the share of blocks in
        which the best is better; ``seeds`` the number of runs of a method, whose values lie between ``seed_low`` and
        ``seed_high``; ``samples`` the number of samples of a stochastic model, whose scores lie between
        ``sample_low`` and ``sample_high``.
    notes : tuple of str
        The notes below the tables: how intervals, marks and ranks were made.
    by : str or None
        The column by which tables are sorted and show ranks; None for the first.
    level : float
        The level of the confidence intervals.

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

    _metadata: ClassVar = ["_standings", "_notes", "by", "level"]  # kept by copies and pickles
    _standings: tuple[Standing, ...] = ()
    _notes: tuple[str, ...] = ()
    by: str | None = None
    level: float = 0.95

    @classmethod
    def of(cls, standings: Sequence[Standing], notes: Sequence[str], *, by: str | None, level: float) -> Leaderboard:
        """Lay out standings with models as rows, and actions and columns as columns, in the order of appearance."""
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
        """The standings of the numbers in the frame.

        Raises
        ------
        ValueError
            If a value is not one of the leaderboard's numbers; names the place.
        """
        return _standings_in(pd.DataFrame(self), self._standings)

    @property
    def notes(self) -> tuple[str, ...]:
        """The notes below the tables."""
        models = {standing.result.label for standing in self._standings}
        shown = {standing.result.label for standing in self.standings}
        if shown == models:
            return self._notes
        return *self._notes, f"{len(shown)} of {len(models)} models; best, ranks and marks are among all of them."

    @property
    def tidy(self) -> pd.DataFrame:
        """A row for each number: its interval, rank, p-value, signature and methods."""
        return pd.DataFrame(
            [
                {
                    **{name: getattr(result, name) for name in ("model", "action", "column", "value")},
                    **{name: getattr(standing, name) for name in ("low", "high", "rank", "best", "worse", "p_value")},
                    **{name: getattr(result, name) for name in ("source", "signature")},
                    "level": self.level,
                    "in_blocks": standing.in_blocks,
                    "behind": None if standing.behind is None else standing.behind[0] / standing.behind[1],
                    "blocks": None if result.blocks is None else result.blocks.n,
                    "seeds": len(result.seeds) or None,
                    "seed_low": min(result.seeds, default=None),
                    "seed_high": max(result.seeds, default=None),
                    "samples": len(result.samples) or None,
                    "sample_low": min(result.samples, default=None),
                    "sample_high": max(result.samples, default=None),
                    "interval": RANGE if standing.is_range else METHOD,
                    "test": TEST,
                }
                for standing, result in ((standing, standing.result) for standing in self.standings)
            ],
            columns=_COLUMNS,
        ).astype(_TYPES)

    def to_text(self, buf: Any = None, *, digits: int | None = None, wide: bool = False) -> str | None:
        """Write the leaderboard for a terminal.

        Parameters
        ----------
        buf : path or open file, optional
            The file to write to; by default the text is returned.
        digits : int, optional
            Decimal places; by default those of the metric.
        wide : bool, optional
            Write a table for each column, with actions side by side, instead of one for each action.

        Returns
        -------
        str or None

        Raises
        ------
        TypeError, ValueError
            If `buf` is neither, `digits` is not a whole number from 0 on, or a value of the frame was changed.
        """
        return self._write("to_text", partial(_render.to_text, wide=wide), buf, digits, {})

    def to_markdown(
        self, buf: Any = None, *, digits: int | None = None, wide: bool = False, **options: Any
    ) -> str | None:
        """Write the leaderboard in Markdown; parameters and errors as for `to_text`, without options of pandas."""
        return self._write("to_markdown", partial(_render.to_text, wide=wide, markdown=True), buf, digits, options)

    def to_latex(
        self,
        buf: Any = None,
        *,
        digits: int | None = None,
        wide: bool = False,
        caption: str | None = None,
        label: str | None = None,
        **options: Any,
    ) -> str | None:
        """Write LaTeX tables, for the package booktabs, with at most three lines of notes each.

        Parameters and errors as for `to_markdown`; also:

        Parameters
        ----------
        caption : str, optional
            The beginning of each caption, in LaTeX.
        label : str, optional
            The label of the first table; those of others end in -2, -3, ...
        """
        render = partial(_render.to_latex, wide=wide, caption=caption, label=label)
        return self._write("to_latex", render, buf, digits, options)

    def to_html(self, buf: Any = None, *, digits: int | None = None, wide: bool = False, **options: Any) -> str | None:
        """Write HTML tables; parameters and errors as for `to_markdown`."""
        return self._write("to_html", partial(_render.to_html, wide=wide), buf, digits, options)

    @renamed(path="path_or_buf")
    def to_csv(self, path_or_buf: Any = None, **options: Any) -> str | None:
        """Write `tidy` as CSV, unrounded.

        Parameters
        ----------
        path_or_buf : path or open file, optional
            The file to write to; by default the text is returned.
        **options
            As for ``pandas.DataFrame.to_csv``; ``index`` is False by default.

        Returns
        -------
        str or None

        Raises
        ------
        TypeError, ValueError
            As in pandas; or if a value of the frame was changed.
        """
        tidy, options = self.tidy, {"index": False, **options}
        compression = options.get("compression", "infer")
        whole = not {"mode", "storage_options"} & options.keys() and not isinstance(compression, Mapping)
        if isinstance(path_or_buf, str | PathLike) and whole:
            # pandas infers compression from the path, which differs while the file is written.
            options["compression"] = infer_compression(path_or_buf, compression)
            write_atomically(Path(path_or_buf).expanduser(), lambda part: tidy.to_csv(part, **options))
            return None
        written: str | None = tidy.to_csv(path_or_buf, **options)
        return written

    @property
    def _constructor(self) -> Any:
        """The function that pandas calls with frames derived from this one."""
        return partial(_derived, self)

    def _write(self, name: str, render: Any, buf: Any, digits: int | None, options: Mapping[str, Any]) -> str | None:
        """Write the tables to `buf`, or return them."""
        if options:
            option = next(iter(options))
            raise TypeError(
                f"{name}(): a leaderboard has no option {option!r}; "
                f"use pd.DataFrame(board).{name}({option}=...) for the table of pandas"
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
            raise TypeError(f"buf: expected a path or a file open for writing, got {buf!r}")
        return None


def _derived(board: Leaderboard, *args: Any, **kwargs: Any) -> pd.DataFrame:
    """Return a frame that pandas derived from a leaderboard, as a leaderboard if all its numbers are the board's."""
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
    """Return the standings of the numbers in a frame, in the order of its columns.

    The columns are pairs of action and column, or, as in ``board["walking"]``, columns of the only action with these
    numbers.

    Raises
    ------
    ValueError
        If the frame holds anything else; names the first place.
    """
    if not (frame.index.is_unique and frame.columns.is_unique):
        raise ValueError("duplicate models or columns in the frame of a leaderboard")
    by_action: dict[str, dict[tuple[str, str], dict[str, Standing]]] = {}
    for standing in standings:
        result = standing.result
        by_action.setdefault(result.action, {}).setdefault((result.action, result.column), {})[result.label] = standing
    if frame.columns.nlevels > 1:
        all_columns = {column: models for columns in by_action.values() for column, models in columns.items()}
        return _standings_at(frame, list(frame.columns), all_columns)
    matches = []
    for action, columns in by_action.items():
        try:
            matches.append(_standings_at(frame, [(action, column) for column in frame.columns], columns))
        except ValueError:
            continue
    if len(matches) != 1:
        raise ValueError("the columns of the frame are not those of one action of the leaderboard")
    return matches[0]


def _standings_at(
    frame: pd.DataFrame, columns: Sequence[Any], known: Mapping[Any, Mapping[Any, Standing]]
) -> list[Standing]:
    standings: list[Standing] = []
    for column, values in zip(columns, frame.to_numpy().T, strict=True):
        models = set()
        for model, value in zip(frame.index, values, strict=True):
            standing = known.get(column, {}).get(model)
            if not isinstance(value, float) or (
                value == value and (standing is None or standing.result.value != value)
            ):
                raise ValueError(
                    f"{model!r}, {column!r}: not the leaderboard's value; write pd.DataFrame(board) instead"
                )
            if value == value:
                models.add(model)
        standings += [standing for model, standing in known.get(column, {}).items() if model in models]
    return standings


def _order(values: dict[tuple[str, str], Any]) -> Any:
    """Return a key that keeps the columns of an action together, with actions in the order of appearance."""
    actions = list(dict.fromkeys(action for action, _ in values))
    places = {column: place for place, column in enumerate(values)}
    return lambda column: (actions.index(column[0]), places[column])
