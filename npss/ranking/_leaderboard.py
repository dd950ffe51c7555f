"""Leaderboards: models by actions and metrics as a DataFrame, and as a paper or a page prints them."""

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
from npss.files._arrays import MAX_SIZE
from npss.ranking._methods import averaged, read_methods
from npss.ranking._results import Result, result_of_report, results_of_record
from npss.ranking._standings import check_truths, notes, standings
from npss.ranking._submissions import MEASURED, read_all
from npss.records import Record
from npss.validation import Seed, each, positive_number

if TYPE_CHECKING:
    from npss.ranking._frame import Leaderboard

Source = (
    str | PathLike[str] | Iterable[str | PathLike[str]] | Iterable[Record] | Mapping[str, Report | Mapping[str, Report]]
)


def leaderboard(
    source: Source,
    *,
    published: bool = False,
    by: str | None = None,
    metrics: Sequence[str] = (),
    groups: Mapping[str, Iterable[Label | None]] | Iterable[Label | None] | None = None,
    methods: Mapping[str, Sequence[str]] | None = None,
    level: float = 0.95,
    seed: Seed = 0,
    extra: Mapping[str, Value] | None = None,
    max_size: float = MAX_SIZE,
    **context: Value,
) -> Leaderboard:
    """Rank models: scores with intervals, and marks where a difference is more than chance.

    Parameters
    ----------
    source : path, sequence of paths, sequence of dict, or mapping
        A folder with a file of samples for each model (``MODEL.npz``, or ``MODEL/samples.npz``), or such
        files; records, as ``npss-baselines evaluate --format json`` prints them, or files of them (``.json``);
        or reports: a mapping from models to a `Report`, or to a mapping from actions to a `Report`. Records may hold
        other metrics, too, also of those that are not registered here: ``metrics`` and ``signatures`` by column (the
        field ``better:higher`` says that higher is better), and their values of the single sequences, of which the
        number is the mean, in ``sequences["metrics"]``, with weights in ``sequences["weight"]``, if they have some.
    published : bool, optional
        Show the published rows of the same meaning beside one's own, marked, and not ranked.
    by : str, optional
        The column by which written tables are sorted and show ranks, such as ``'NPSS released'``; by default the first.
    metrics : sequence of str, optional
        Other metrics that files of samples are measured by: names or headings of those that are registered; see
        `npss.metrics`.
    groups : mapping of str to labels, or labels; optional
        The blocks of the sequences of each action, as for `report`, or of the only action, in place of those that
        records and reports state. Files of samples state none: there, `protocol='srnn-8'` or `'random-256'` tells
        the blocks of actions of which `npss.protocol.TEST_LENGTHS` has the lengths.
    methods : mapping of str to sequence of str, optional
        The models that are runs of one method, with other seeds, by the name of the method: they are averaged in every
        sequence, and the method stands in their place, with the spread over its seeds beside it. Three or more each.
    level : float, optional
        Of the confidence intervals; a difference is marked at 1 minus it.
    seed : int or numpy.random.Generator, optional
        Of the generators behind intervals and tests.
    extra : mapping of str to str, int, float or bool; optional
        Fields of one's own that the signatures of numbers measured from files state.
    max_size : float, optional
        How much memory the arrays of one file of samples may take, in GiB; a file that declares more is refused.
    **context
        Known fields that these signatures state, such as ``protocol='srnn-8'``; see `signature`.

    Returns
    -------
    Leaderboard
        A ``pandas.DataFrame``, models by actions and columns (NPSS by convention, Euler error by time, other
        metrics), with NaN where a model has no number; ``.tidy`` has a row for each number with its interval, rank and
        signature, and ``.to_markdown()``, ``.to_latex()``, ``.to_html()`` and ``.to_csv()`` write it.

    Raises
    ------
    ImportError
        Without pandas; the message says how to install it.
    TypeError
        If `source` is none of these, or a keyword is no known field.
    ValueError
        If two numbers to be ranked together differ in meaning: shows both signatures. If models were scored on
        different ground truth, in different blocks, a model is there twice, a file is broken, no published row has
        the same meaning, no column is called `by`, `groups` do not fit the sequences, or `methods` the models.

    Notes
    -----
    In each column, models are ranked by 1 plus the number of models that are better by more than chance: the paired
    sign-flip test of `compare`, with Holm's correction over all pairs. Hence models share ranks; of fewer than six
    blocks, all have the first. Numbers without their single sequences (records made without ``--sequences``) are ranked
    by value.

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
    stated: dict[str, Any] = {**context, "extra": own} if own else {**context}
    if others := each("metrics", metrics, "names"):
        stated["metrics"] = others
    results = _results(source, positive_number("max_size", max_size), stated)
    if not results:
        raise ValueError("source: nothing to rank in it")
    if groups is not None:
        results = _in_blocks(results, groups)
    if runs_of:
        check_truths(results)
        results = averaged(results, runs_of)
    if published:
        results += _published(results)
    columns = list(dict.fromkeys(result.column for result in results))
    if by is not None and by not in columns:
        raise ValueError(f"by: expected one of {', '.join(columns)}; got {by!r}")
    found = standings(results, level=level, seed=seed)
    return Leaderboard.of(found, notes(found, level=level, seed=seed), by=by, level=level)


def _results(source: Any, max_size: float, context: Mapping[str, Any]) -> list[Result]:
    if isinstance(source, str | PathLike):
        source = [source]
    if not isinstance(source, Iterable):
        raise TypeError(f"source: expected paths, records or reports, got {source!r}")
    several = list(source)
    paths = not isinstance(source, Mapping) and all(isinstance(one, str | PathLike) for one in several)
    if context and not paths:
        raise ValueError(f"{next(iter(context))}: records and reports state their own; it is for files of samples")
    if isinstance(source, Mapping):
        return [result_of_report(*named) for named in _reports(source)]
    if paths:
        several = read_all([Path(one) for one in several], max_size=max_size, **context)
    elif not all(isinstance(one, Mapping) for one in several):
        raise TypeError(f"source: expected paths, or records, got {several!r:.200}")
    return [result for record in several for result in results_of_record(record)]


def _in_blocks(results: Sequence[Result], groups: Any) -> list[Result]:
    """Return results with other blocks of their sequences."""
    actions = list(dict.fromkeys(result.action for result in results))
    if not isinstance(groups, Mapping):
        if len(actions) > 1:
            raise TypeError(f"groups: expected labels by action, of {', '.join(actions)}")
        groups = {actions[0]: groups}
    if unknown := [action for action in groups if action not in actions]:
        raise ValueError(f"groups: no action is called {unknown[0]!r}; there are {', '.join(actions)}")
    names = {action: f"groups: {action or 'all'}" for action in groups}
    labels_of = {action: each(names[action], labels, "labels") for action, labels in groups.items()}
    known = {result.action for result in results if result.weight is not None}
    if useless := [action for action in groups if action not in known]:
        raise ValueError(f"{names[useless[0]]}: the single sequences of these numbers are not known")
    found = []
    for result in results:
        if result.weight is not None and result.action in groups:
            labels = read_groups(names[result.action], labels_of[result.action], len(result.weight))
            Blocks(labels, result.weight)  # of which one has power
            result = replace(result, groups=labels)
        found.append(result)
    return found


def _reports(source: Mapping[Any, Any]) -> Iterator[tuple[str, str, Report]]:
    """Yield model, action and report."""
    for model, reports in source.items():
        of_model = {"": reports} if isinstance(reports, Report) else reports
        if not isinstance(model, str) or not isinstance(of_model, Mapping):
            raise TypeError(
                f"source: expected a report, or some by action, of each model, got {model!r}: {reports!r:.100}"
            )
        for action, report in of_model.items():
            if not isinstance(action, str) or not isinstance(report, Report):
                raise TypeError(f"source: expected reports by action, of {model!r} got {action!r}: {report!r:.100}")
            yield model, action, report


def _published(results: list[Result]) -> list[Result]:
    """Return the published results that mean the same as some of those."""
    own = {(result.action, result.column): result.signature for result in results}
    records = published_rows.records() + published_rows.records(protocol="srnn-8-late")
    rows = [result for record in records for result in results_of_record(record)]
    same = [row for row in rows if own.get((row.action, row.column)) == row.signature]
    if not same:
        alike = next((row for row in rows if (row.action, row.column) in own), rows[0])
        mine = own.get((alike.action, alike.column), results[0].signature)
        raise ValueError(f"published: no published number means the same as one of yours: {alike.signature} and {mine}")
    return same
