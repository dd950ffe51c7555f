"""Make a leaderboard from files, records or reports."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any

from npss import published as published_rows
from npss._analysis.blocks import Blocks, Label, read_groups
from npss._analysis.report import Report
from npss._metric.fields import Value, check_names
from npss._metric.signature import differences
from npss.files._arrays import MAX_SIZE
from npss.ranking._methods import averaged, read_methods
from npss.ranking._results import Result, result_of_report, results_of_record
from npss.ranking._standings import check_truths, notes, standings
from npss.ranking._submissions import MEASURED, read_all
from npss.records import Record
from npss.stochastic import SampleReport
from npss.validation import Seed, each, positive_number

if TYPE_CHECKING:
    from npss.ranking._frame import Leaderboard

Source = (
    str
    | PathLike[str]
    | Iterable[str | PathLike[str]]
    | Iterable[Record]
    | Mapping[str, Report | SampleReport | Mapping[str, Report | SampleReport]]
)


def leaderboard(
    source: Source,
    *,
    published: bool = False,
    reference: bool = False,
    by: str | None = None,
    columns: Sequence[str] = (),
    metrics: Sequence[str] = (),
    edges_ms: Sequence[float] = (),
    groups: Mapping[str, Iterable[Label | None]] | Iterable[Label | None] | None = None,
    methods: Mapping[str, Sequence[str]] | None = None,
    level: float = 0.95,
    seed: Seed = 0,
    extra: Mapping[str, Value] | None = None,
    max_size: float = MAX_SIZE,
    **context: Value,
) -> Leaderboard:
    """Rank models by their scores, with intervals, and mark significant differences.

    Parameters
    ----------
    source : path, sequence of paths, sequence of dict, or mapping
        A folder with one file of samples per model (``MODEL.npz`` or ``MODEL/samples.npz``), or such files; records, as
        ``npss-baselines evaluate --format json`` prints them, or files of records (``.json``); or reports: a mapping
        from models to a `Report` or `npss.stochastic.SampleReport`, or to a mapping from actions to such. Records may
        hold other metrics, even unregistered ones: ``metrics`` and ``signatures`` by column (the field
        ``better:higher`` means that higher is better), and the values of single sequences, whose mean is the number, in
        ``sequences["metrics"]``, with any weights in ``sequences["weight"]``.
    published : bool, optional
        Also show published rows of the same meaning; they are marked and not ranked.
    reference : bool, optional
        Also show the rows of the same meaning that this project measured (`npss.published.reference`); they are marked
        and not ranked, and may be averages over draws.
    by : str, optional
        The column by which written tables are sorted and show ranks, such as ``'NPSS released'``; by default the first,
        or the first with published or reference rows if they are shown.
    columns : sequence of str, optional
        The columns to show, in this order, or the beginnings of their names: ``'NPSS released'`` also stands for its
        windows, ``'Euler error'`` for all times. By default all.
    metrics : sequence of str, optional
        Names or headings of other registered metrics, by which files of results are measured; see `npss.metrics`.
    edges_ms : sequence of float, optional
        Edges of windows of time, in milliseconds, in which files of results are scored, too, without intervals:
        ``(0, 1000, 2000, 4000)`` for table 5 of the NPSS paper.
    groups : mapping of str to labels, or labels; optional
        The blocks of the sequences of each action, as for `report`, or of the only action. They replace those that
        records and reports state. Files of samples state none; for them, `protocol='srnn-8'` or `'random-256'` implies
        the blocks of actions whose lengths are in `npss.protocol.TEST_LENGTHS`.
    methods : mapping of str to sequence of str, optional
        The runs of each method, by its name: three or more models that differ in their seed. They are averaged in every
        sequence; the method replaces them, with the range over seeds beside its value.
    level : float, optional
        The confidence level of intervals; a difference is marked at significance level 1 - `level`.
    seed : int or numpy.random.Generator, optional
        The seed of the generators for intervals and tests.
    extra : mapping of str to str, int, float or bool; optional
        Fields of your own for the signatures of numbers measured from files.
    max_size : float, optional
        The most memory that the arrays of one file of samples may take, in GiB; larger files are refused.
    **context
        Known fields for these signatures, such as ``protocol='srnn-8'``; see `signature`.

    Returns
    -------
    Leaderboard
        A ``pandas.DataFrame``, models by actions and columns (NPSS by convention, Euler error by time, other
        metrics), with NaN where a model has no number. ``.tidy`` has a row for each number with its interval, rank and
        signature; ``.to_markdown()``, ``.to_latex()``, ``.to_html()`` and ``.to_csv()`` write it.

    Raises
    ------
    ImportError
        If pandas is missing; the message says how to install it.
    TypeError
        If `source` is none of these, or a keyword is not a known field.
    ValueError
        If two numbers to be ranked together differ in meaning; shows both signatures. If models were scored on
        different ground truth or in different blocks, a model is a duplicate, a file is broken, no published or
        reference row has the same meaning, no column is called `by`, `groups` do not fit the sequences, or `methods`
        the models.

    Notes
    -----
    In each column, a model's rank is 1 plus the number of models that are significantly better, by the paired
    sign-flip test of `compare` with Holm's correction over all pairs. So models share ranks; with fewer than six
    blocks, all rank first. Numbers without single sequences (records made without ``--sequences``) are ranked by value.

    References
    ----------
    A. Gopalakrishnan et al., "A Neural Temporal Model for Human Motion Prediction", CVPR 2019, tables 4 to 7 (the
    published rows).

    Examples
    --------
    >>> import numpy as np
    >>> import npss
    >>> rng = np.random.default_rng(0)
    >>> gt = rng.normal(size=(8, 50, 3)).cumsum(axis=1)
    >>> models = {"close": gt + 0.3 * rng.normal(size=gt.shape), "far": rng.normal(size=gt.shape)}
    >>> board = npss.leaderboard({name: npss.report(gt, pred) for name, pred in models.items()})
    >>> board.tidy[["model", "rank", "best", "worse"]]
       model  rank   best  worse
    0  close     1   True  False
    1    far     2  False   True
    """
    from npss.ranking._frame import Leaderboard

    own = check_names(leaderboard, context, extra, MEASURED)
    runs_of = read_methods(methods)
    options: dict[str, Any] = {**context, "extra": own} if own else {**context}
    if others := each("metrics", metrics, "names"):
        options["metrics"] = others
    if edges := each("edges_ms", edges_ms):
        options["edges_ms"] = edges
    shown = each("columns", columns, "names")
    results = _results(source, positive_number("max_size", max_size), options)
    if not results:
        raise ValueError("source: it has nothing to rank")
    if groups is not None:
        results = _in_blocks(results, groups)
    if runs_of:
        check_truths(results)
        results = averaged(results, runs_of)
    beside: list[Result] = []
    if published:
        records = published_rows.records() + published_rows.records(protocol="srnn-8-late")
        beside += _same("published", results, records)
    if reference:
        beside += _same("reference", results, published_rows.reference())
    results += beside
    if shown:
        results = _chosen(results, shown)
    names = list(dict.fromkeys(result.column for result in results))
    if by is not None and by not in names:
        raise ValueError(f"by: expected one of {', '.join(names)}; got {by!r}")
    if by is None and beside:
        of_others = {result.column for result in beside}
        by = next((name for name in names if name in of_others), None)
    ranked = standings(results, level=level, seed=seed)
    return Leaderboard.of(ranked, notes(ranked, level=level, seed=seed), by=by, level=level)


def _results(source: Any, max_size: float, context: Mapping[str, Any]) -> list[Result]:
    if isinstance(source, str | PathLike):
        source = [source]
    if not isinstance(source, Iterable):
        raise TypeError(f"source: expected paths, records or reports, got {source!r}")
    items = list(source)
    paths = not isinstance(source, Mapping) and all(isinstance(item, str | PathLike) for item in items)
    if context and not paths:
        raise ValueError(f"{next(iter(context))}: only for files of samples; records and reports state their own")
    if isinstance(source, Mapping):
        return [result_of_report(*named) for named in _reports(source)]
    if paths:
        items = read_all([Path(path) for path in items], max_size=max_size, **context)
    elif not all(isinstance(item, Mapping) for item in items):
        raise TypeError(f"source: expected paths, or records, got {items!r:.200}")
    return [result for record in items for result in results_of_record(record)]


def _chosen(results: Sequence[Result], columns: Sequence[str]) -> list[Result]:
    """Return the results of some columns, in their order; a column is named whole or by its beginning."""
    chosen: dict[str, None] = {}
    names = list(dict.fromkeys(result.column for result in results))
    for column in columns:
        found = [name for name in names if f"{name} ".startswith(f"{column} ")]
        if not found:
            raise ValueError(f"columns: expected some of {', '.join(names)}; got {column!r}")
        chosen |= dict.fromkeys(found)
    places = {name: place for place, name in enumerate(chosen)}
    kept = [result for result in results if result.column in places]
    return sorted(kept, key=lambda result: places[result.column])


def _in_blocks(results: Sequence[Result], groups: Any) -> list[Result]:
    """Return results with these blocks of sequences."""
    actions = list(dict.fromkeys(result.action for result in results))
    if not isinstance(groups, Mapping):
        if len(actions) > 1:
            raise TypeError(f"groups: expected labels for each action: {', '.join(actions)}")
        groups = {actions[0]: groups}
    if unknown := [action for action in groups if action not in actions]:
        raise ValueError(f"groups: unknown action {unknown[0]!r}; expected one of {', '.join(actions)}")
    names = {action: f"groups: {action or 'all'}" for action in groups}
    labels_of = {action: each(names[action], labels, "labels") for action, labels in groups.items()}
    with_sequences = {result.action for result in results if result.weight is not None}
    if useless := [action for action in groups if action not in with_sequences]:
        raise ValueError(f"{names[useless[0]]}: the values of single sequences are unknown")
    regrouped = []
    for result in results:
        if result.weight is not None and result.action in groups:
            labels = read_groups(names[result.action], labels_of[result.action], len(result.weight))
            Blocks(labels, result.weight)  # checks that a block has power
            result = replace(result, groups=labels)
        regrouped.append(result)
    return regrouped


def _reports(source: Mapping[Any, Any]) -> Iterator[tuple[str, str, Report | SampleReport]]:
    """Yield model, action and report."""
    for model, reports in source.items():
        of_model = {"": reports} if isinstance(reports, Report | SampleReport) else reports
        if not isinstance(model, str) or not isinstance(of_model, Mapping):
            raise TypeError(
                f"source: expected a report, or reports by action, for each model, got {model!r}: {reports!r:.100}"
            )
        for action, report in of_model.items():
            if not isinstance(action, str) or not isinstance(report, Report | SampleReport):
                raise TypeError(f"source: expected reports by action for {model!r}, got {action!r}: {report!r:.100}")
            yield model, action, report


def _same(kind: str, results: list[Result], records: Sequence[Record]) -> list[Result]:
    """Return the published or reference results that mean the same as some of `results`."""
    own = {(result.action, result.column): result for result in results}
    rows = [result for record in records for result in results_of_record(record)]
    same = [row for row in rows if (mine := own.get((row.action, row.column))) is not None and row.means_as(mine)]
    if not same:
        raise ValueError(f"{kind}: no {kind} number means the same as yours: {_nearest(results, rows)}")
    return same


def _nearest(results: Sequence[Result], rows: Sequence[Result]) -> str:
    """Say how the number that is nearest in meaning to a published or reference one differs from it."""
    pairs = [(mine, row) for mine in results for row in rows if mine.column == row.column]
    if not pairs:
        return f"theirs are {', '.join(dict.fromkeys(row.column for row in rows))}"

    def distance(pair: tuple[Result, Result]) -> tuple[int, bool]:
        mine, row = pair
        return len(differences(mine.signature, row.signature)), mine.action != row.action

    mine, row = min(pairs, key=distance)
    found = differences(mine.signature, row.signature)
    if mine.action != row.action:
        found.append(f"the action must be {row.action!r}, not {mine.action!r}")
    return f"{mine.column} of {mine.model}: {'; '.join(found)}"
