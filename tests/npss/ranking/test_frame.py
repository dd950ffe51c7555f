"""`npss.Leaderboard`: which derived frames are leaderboards, and which arguments of pandas its writers accept."""

import copy
import inspect
import io
import pickle
import subprocess
import sys

import numpy as np
import pytest

import npss

pd = pytest.importorskip("pandas")

WALKING = ("walking", "NPSS paper")
RNG = np.random.default_rng(0)
GT = RNG.normal(size=(8, 50, 3)).cumsum(axis=1)
PREDS = {"near": GT + RNG.normal(size=GT.shape), "far": GT + 9 * RNG.normal(size=GT.shape), "flat": 0 * GT}


@pytest.fixture
def board():
    """Three models on two actions, one of which a model lacks."""
    reports = {
        name: {
            action: npss.report(GT + shift, pred + shift, convention=convention)
            for action, shift, convention in (("walking", 0, "paper"), ("eating", 1, "literal"))
            if (name, action) != ("flat", "eating")
        }
        for name, pred in PREDS.items()
    }
    return npss.leaderboard(reports)


SELECTIONS = {
    "all": lambda board: board,
    "copy": lambda board: board.copy(),
    "shallow copy": copy.copy,
    "deep copy": copy.deepcopy,
    "pickle": lambda board: pickle.loads(pickle.dumps(board)),
    "sorted": lambda board: board.sort_values(WALKING, ascending=False),
    "sorted by name": lambda board: board.sort_index(),
    "reversed": lambda board: board.iloc[::-1],
    "some models": lambda board: board.loc[["far", "near"]],
    "a model less": lambda board: board.drop(index="near"),
    "a mask": lambda board: board[board[WALKING] > board[WALKING].min()],
    "a query": lambda board: board.query("model == 'far'"),
    "the first": lambda board: board.head(1),
    "none": lambda board: board.iloc[:0],
    "columns": lambda board: board[[WALKING]],
    "an action": lambda board: board[["walking"]],
    "an action alone": lambda board: board["walking"],
    "an action by its level": lambda board: board.xs("eating", axis=1),
    "columns in another order": lambda board: board[board.columns[::-1]],
    "without what is missing": lambda board: board.dropna(),
    "some cells": lambda board: board.where(board < board[WALKING].max()),
    "more models": lambda board: board.reindex(["near", "other"]),
    "parts put together": lambda board: pd.concat([board.loc[["far"]], board.loc[["near"]]]),
}


@pytest.mark.parametrize("name", SELECTIONS)
def test_a_selection_keeps_its_standings(board, name):
    selected = SELECTIONS[name](board)
    assert isinstance(selected, npss.Leaderboard)
    known = board.tidy.set_index(["model", "action", "column"])
    tidy = selected.tidy
    assert len(tidy) == selected.notna().to_numpy().sum()
    for row in tidy.itertuples():
        shown = row.column if selected.columns.nlevels == 1 else (row.action, row.column)
        assert selected.loc[row.model, shown] == row.value
    kept = tidy.set_index(["model", "action", "column"])
    if len(kept):
        pd.testing.assert_frame_equal(kept, known.loc[kept.index])
    assert list(kept.columns) == list(known.columns)


def test_marks_are_written_as_before(board):
    before = board.to_markdown()
    for name in ("copy", "deep copy", "pickle", "sorted", "reversed"):
        assert SELECTIONS[name](board).to_markdown() == before
    selected = board.loc[["far"]]["walking"].to_text()
    far = next(line for line in board["walking"].to_text().splitlines() if "far" in line)
    assert "†" in far
    assert [line.split() for line in selected.splitlines() if "far" in line] == [far.split()]
    assert "1 of 3 models; best, ranks and marks are among all of them." in selected
    assert "among all of them" not in before


def test_tables_stand_in_the_order_of_the_columns(board):
    first, last = (one.to_text() for one in (board, board[board.columns[::-1]]))
    assert first.index("walking (ranked") < first.index("eating (ranked")
    assert last.index("eating (ranked") < last.index("walking (ranked")


COMPUTED = {
    "twice": lambda board: board * 2,
    "the other way round": lambda board: board.T,
    "missing ones": lambda board: board.isna(),
    "rounded": lambda board: board.round(1),
    "as text": lambda board: board.astype(str),
    "as objects": lambda board: board.astype(object).replace(board.iloc[0, 0], "best"),
    "filled": lambda board: board.fillna(0.0),
    "ranks": lambda board: board.rank(),
    "a summary": lambda board: board.describe(),
    "a model twice": lambda board: board.loc[["near", "near"]],
    "an action of which nothing is there": lambda board: board.loc[["flat"]].xs("eating", axis=1).iloc[:, :0],
}


@pytest.mark.parametrize("name", COMPUTED)
def test_results_of_computations_are_plain_frames(board, name):
    assert type(COMPUTED[name](board)) is pd.DataFrame


@pytest.mark.parametrize(
    "change",
    [
        lambda board: board.rename(index={"near": "ours"}),
        lambda board: board.reset_index(),
        lambda board: board.swaplevel(axis=1),
    ],
)
def test_other_names_and_columns_are_not_written_as_scores(board, change):
    changed = change(board)
    with pytest.raises(ValueError, match=r"not the leaderboard's value; write pd\.DataFrame\(board\) instead$"):
        changed.to_markdown()
    assert pd.DataFrame(changed).to_csv()


def test_a_value_that_was_changed_is_not_written_as_a_score(board):
    changed = board.copy()
    changed.loc["far", WALKING] = 0.001
    for write in (changed.to_text, changed.to_markdown, changed.to_latex, changed.to_html, changed.to_csv):
        with pytest.raises(
            ValueError, match=r"^'far', \('walking', 'NPSS paper'\): not the leaderboard's value; write"
        ):
            write()
    assert "0.001" in pd.DataFrame(changed).to_csv()
    board["walking", "mine"] = 1.0
    with pytest.raises(ValueError, match=r"^'near', \('walking', 'mine'\): not the leaderboard's value"):
        _ = board.tidy
    with pytest.raises(ValueError, match=r"^'a', 0: not|^the columns"):
        npss.Leaderboard([[1.0]], index=["a"]).to_text()


WRITERS = ("to_markdown", "to_latex", "to_html")


@pytest.mark.parametrize("name", ["to_text", *WRITERS])
def test_writers_write_to_what_pandas_writes_to(board, tmp_path, name):
    write = getattr(board, name)
    text = write()
    stream = io.StringIO()
    assert write(stream) is None
    assert stream.getvalue() == text
    for path in (tmp_path / "a", str(tmp_path / "b")):
        assert write(path) is None
        with open(path, encoding="utf-8", newline="") as file:  # noqa: PTH123
            assert file.read() == text
    assert write(buf=None, digits=1) != text
    for wrong in (3, b"a"):
        with pytest.raises(TypeError, match=r"^buf: expected a path or a file open for writing, got"):
            write(wrong)
    for error, digits in ((TypeError, 1.0), (TypeError, True), (TypeError, "3"), (ValueError, -1)):
        with pytest.raises(error, match=r"^digits: expected a whole number"):
            write(digits=digits)


@pytest.mark.parametrize("name", [*WRITERS, "to_csv"])
def test_every_call_of_pandas_is_understood(board, name):
    """Each argument has pandas' name and place, and is taken, or refused in words."""
    pandas, own = (inspect.signature(getattr(frame, name)) for frame in (pd.DataFrame, npss.Leaderboard))
    by_place = [key for key, one in pandas.parameters.items() if one.kind == one.POSITIONAL_OR_KEYWORD]
    assert list(own.parameters)[: len(by_place)] == by_place
    options = [key for key, one in pandas.parameters.items() if one.kind == one.KEYWORD_ONLY]
    own.bind(board, None, **dict.fromkeys(options))
    if name != "to_csv":
        for option in sorted({*options} - {"caption", "label"} if name == "to_latex" else options):
            with pytest.raises(TypeError, match=rf"^{name}\(\): a leaderboard has no option '{option}'; use pd"):
                getattr(board, name)(**{option: None})


def test_csv_takes_the_options_of_pandas(board, tmp_path):
    tidy = board.tidy
    options = {"sep": ";", "na_rep": "-", "columns": ["model", "value"], "float_format": "%.2f", "index": True}
    assert board.to_csv(**options) == tidy.to_csv(**options)
    path = tmp_path / "board.csv"
    board.to_csv(path, **options)
    assert path.read_text(encoding="utf-8") == tidy.to_csv(**options)
    board.to_csv(path, mode="a", header=False)
    assert path.read_text(encoding="utf-8") == tidy.to_csv(**options) + tidy.to_csv(index=False, header=False)
    for compression in ("gzip", {"method": "gzip", "mtime": 1}):
        board.to_csv(tmp_path / "packed", compression=compression)
        pd.testing.assert_frame_equal(
            pd.read_csv(tmp_path / "packed", compression="gzip"), pd.read_csv(io.StringIO(board.to_csv()))
        )
    with pytest.raises(TypeError, match="unexpected keyword argument 'colour'"):
        board.to_csv(path, colour="red")
    with pytest.raises(TypeError, match=r"to_csv\(\) has no argument 'path': it is called 'path_or_buf'"):
        board.to_csv(path=path)


def test_all_of_npss_can_be_imported_without_pandas():
    code = "import sys; sys.modules['pandas'] = None; from npss import *; assert 'Leaderboard' not in dir(); report"
    hidden = (
        "import importlib.util as u; f = u.find_spec; u.find_spec = lambda name: None if name == 'pandas' else f(name)"
    )
    subprocess.run([sys.executable, "-c", f"{hidden}; {code}"], check=True)
