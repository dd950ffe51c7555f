"""The DataFrame of a leaderboard; the one module that needs pandas."""

from __future__ import annotations

from collections.abc import Sequence
from os import PathLike
from pathlib import Path
from typing import Any, ClassVar

from npss._analysis.bootstrap import METHOD
from npss._analysis.interval import RANGE
from npss.extras import install_hint
from npss.files._write import write_atomically
from npss.ranking import _render
from npss.ranking._standings import TEST, Standing

try:
    import pandas as pd
    from pandas.io.common import infer_compression
except ImportError:
    raise ImportError(f"npss.leaderboard needs pandas; {install_hint('pandas')}") from None


_TYPES = {
    **dict.fromkeys(("low", "high", "p_value", "in_blocks", "behind", "seed_low", "seed_high"), float),
    **dict.fromkeys(("rank", "blocks", "seeds"), "Int64"),
}


class Leaderboard(pd.DataFrame):  # type: ignore[misc]
    """Scores of models by actions and columns; `npss.leaderboard` makes it.

    It is a DataFrame, and what is computed from it (``board * 2``, ``board.T``) is a plain one; but it is written as a
    leaderboard: a table for each action, with ranks, intervals, marks and signatures.
    """

    _metadata: ClassVar = ["standings", "notes", "by", "level"]  # what pickling keeps
    standings: tuple[Standing, ...] = ()
    notes: tuple[str, ...] = ()
    by: str | None = None
    level: float = 0.95

    @property
    def _constructor(self) -> type[Any]:
        return pd.DataFrame  # type: ignore[no-any-return]

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
        board.standings = tuple(standings)
        board.notes = tuple(notes)
        board.by = by
        board.level = level
        return board

    @property
    def tidy(self) -> pd.DataFrame:
        """A row for each number: its interval, rank, p-value (of the difference from the best), signature, methods.

        ``in_blocks`` is the score of the sequences in blocks where some are left out, ``behind`` the share of blocks in
        which the best is better, ``seeds`` how many trained runs a method is the mean of, between which values.
        """
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
            ]
        ).astype(_TYPES)

    def to_text(self, *, digits: int | None = None) -> str:
        """Return the leaderboard for a terminal."""
        return _render.to_text(self.standings, self.notes, by=self.by, digits=digits)

    def to_markdown(self, *, digits: int | None = None) -> str:
        """Return the leaderboard in Markdown."""
        return _render.to_text(self.standings, self.notes, by=self.by, digits=digits, markdown=True)

    def to_latex(self, *, digits: int | None = None) -> str:
        """Return the leaderboard as LaTeX tables, for the package booktabs."""
        return _render.to_latex(self.standings, self.notes, by=self.by, digits=digits)

    def to_html(self, *, digits: int | None = None) -> str:
        """Return the leaderboard as HTML tables."""
        return _render.to_html(self.standings, self.notes, by=self.by, digits=digits)

    def to_csv(self, path: Any = None) -> str | None:
        """Write ``tidy`` as CSV, unrounded, to a file (its path, or what is open for writing), or return it."""
        if isinstance(path, str | PathLike):
            # pandas would see from the path, which is another one while it is written, whether to compress.
            tidy, how = self.tidy, infer_compression(path, "infer")
            write_atomically(Path(path).expanduser(), lambda part: tidy.to_csv(part, index=False, compression=how))
            return None
        written: str | None = self.tidy.to_csv(path, index=False)
        return written


def _order(values: dict[tuple[str, str], Any]) -> Any:
    """Return a key that keeps the columns of an action together, in the order in which actions come."""
    actions = list(dict.fromkeys(action for action, _ in values))
    places = {column: place for place, column in enumerate(values)}
    return lambda column: (actions.index(column[0]), places[column])
