"""Methods: averages of runs that differ only in their seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from npss.ranking._results import Result
from npss.validation import each

#: The least number of seeds for a claim about a method.
MIN_SEEDS = 3


def read_methods(methods: Mapping[str, Sequence[str]] | None) -> dict[str, list[str]]:
    """Read the names of the runs of each method.

    Raises
    ------
    TypeError, ValueError
        If `methods` is not a mapping of names to names, a name is empty, a method has fewer than three runs, or a run
        is a duplicate.
    """
    if methods is None:
        return {}
    if not isinstance(methods, Mapping):
        raise TypeError(f"methods: expected a mapping of names to models, got {methods!r:.100}")
    runs_of: dict[str, list[str]] = {}
    seen: set[str] = set()
    for method, models in methods.items():
        runs = each("methods", models, "names of models")
        if strange := [name for name in (method, *runs) if not isinstance(name, str)]:
            raise TypeError(f"methods: expected names of models, got {strange[0]!r}")
        if not method.strip():
            raise ValueError(f"methods: the name of a method is empty: {method!r}")
        if len(runs) < MIN_SEEDS:
            raise ValueError(f"methods: {method!r} has {len(runs)} runs; a method needs {MIN_SEEDS} or more")
        for run in runs:
            if run in seen:
                raise ValueError(f"methods: duplicate run {run!r}")
            seen.add(run)
        runs_of[method] = runs
    return runs_of


def averaged(results: Sequence[Result], methods: Mapping[str, Sequence[str]]) -> list[Result]:
    """Replace the runs of each method by their average in every sequence.

    An action or column that only some of the runs have is an error: the average would cover fewer seeds.

    Raises
    ------
    ValueError
        If a run is not among the results, or a number is missing in some runs or differs in meaning.
    """
    of_run = {run: method for method, runs in methods.items() for run in runs}
    own = [result for result in results if not result.source]
    names = {result.model for result in own}
    if unknown := [run for run in of_run if run not in names]:
        raise ValueError(f"methods: unknown model {unknown[0]!r}; expected one of {', '.join(sorted(names))}")
    if taken := [method for method in methods if method in names - of_run.keys()]:
        raise ValueError(f"methods: {taken[0]!r} is also the name of a model")
    averages: list[Result] = []
    cells: dict[tuple[str, str, str], list[Result]] = {}
    for result in own:
        if result.model not in of_run:
            averages.append(result)
        else:
            cells.setdefault((of_run[result.model], result.action, result.column), []).append(result)
    for (method, action, column), runs in cells.items():
        where = f"methods: {method!r} on {action!r}, {column}"
        models = [run.model for run in runs]
        if missing := sorted({*methods[method]} - {*models}):
            raise ValueError(f"{where}: {missing[0]!r} has no such number")
        if duplicates := [model for model in models if models.count(model) > 1]:
            raise ValueError(f"{where}: duplicate run {duplicates[0]!r}")
        first = runs[0]
        for other in runs[1:]:
            if other.signature != first.signature:
                raise ValueError(f"{where}: runs have different numbers: {first.signature} and {other.signature}")
            if other.groups != first.groups:
                raise ValueError(f"{where}: runs were scored in different blocks")
        numerators = [run.numerator for run in runs if run.numerator is not None]
        has_sequences = len(numerators) == len(runs)
        averages.append(
            replace(
                first,
                model=method,
                value=float(np.mean([run.value for run in runs])),
                numerator=np.mean(numerators, axis=0) if has_sequences else None,
                weight=first.weight if has_sequences else None,
                seeds=tuple(run.value for run in runs),
                samples=(),
            )
        )
    return averages + [result for result in results if result.source]
