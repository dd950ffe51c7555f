"""Methods rather than trained runs: each is the mean of runs that differ in nothing but their seed."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from npss.ranking._results import Result
from npss.validation import each

#: Seeds of which a claim about a method needs at least so many.
MIN_SEEDS = 3


def read_methods(methods: Mapping[str, Sequence[str]] | None) -> dict[str, list[str]]:
    """Read which models are the runs of which method.

    Raises
    ------
    TypeError, ValueError
        If they are not names by name, a name is empty, a method has fewer than three runs, or a run is there twice.
    """
    if methods is None:
        return {}
    if not isinstance(methods, Mapping):
        raise TypeError(f"methods: expected the models of each method by its name, got {methods!r:.100}")
    found: dict[str, list[str]] = {}
    seen: set[str] = set()
    for method, models in methods.items():
        runs = each("methods", models, "names of models")
        if strange := [name for name in (method, *runs) if not isinstance(name, str)]:
            raise TypeError(f"methods: expected names of models, got {strange[0]!r}")
        if not method.strip():
            raise ValueError(f"methods: the name of a method is empty: {method!r}")
        if len(runs) < MIN_SEEDS:
            raise ValueError(
                f"methods: {method!r} has {len(runs)} runs; to speak of a method takes {MIN_SEEDS} or more"
            )
        for run in runs:
            if run in seen:
                raise ValueError(f"methods: {run!r} is there twice")
            seen.add(run)
        found[method] = runs
    return found


def averaged(results: Sequence[Result], methods: Mapping[str, Sequence[str]]) -> list[Result]:
    """Return results with each method in the place of its runs: what they have in every sequence, averaged.

    An action or column that only some of the runs have is an error: the mean would be of another number of seeds.

    Raises
    ------
    ValueError
        If a run is not among the results, or a number is not there of all runs, or does not mean the same.
    """
    of_run = {run: method for method, runs in methods.items() for run in runs}
    own = [result for result in results if not result.source]
    names = {result.model for result in own}
    if unknown := [run for run in of_run if run not in names]:
        raise ValueError(f"methods: no model is called {unknown[0]!r}; there are {', '.join(sorted(names))}")
    if taken := [method for method in methods if method in names - of_run.keys()]:
        raise ValueError(f"methods: there is a model called {taken[0]!r}, too")
    found: list[Result] = []
    cells: dict[tuple[str, str, str], list[Result]] = {}
    for result in own:
        if result.model not in of_run:
            found.append(result)
        else:
            cells.setdefault((of_run[result.model], result.action, result.column), []).append(result)
    for (method, action, column), runs in cells.items():
        where = f"methods: {method!r} on {action!r}, {column}"
        if lacking := sorted({*methods[method]} - {run.model for run in runs}):
            raise ValueError(f"{where}: {lacking[0]!r} has no such number")
        if len(runs) > len(methods[method]):
            raise ValueError(f"{where}: a run is there twice")
        first = runs[0]
        for other in runs[1:]:
            if other.signature != first.signature:
                raise ValueError(f"{where}: runs have different numbers: {first.signature} and {other.signature}")
            if other.groups != first.groups:
                raise ValueError(f"{where}: runs were scored in different blocks")
        alone = [run.numerator for run in runs if run.numerator is not None]
        known = len(alone) == len(runs)
        found.append(
            replace(
                first,
                model=method,
                value=float(np.mean([run.value for run in runs])),
                numerator=np.mean(alone, axis=0) if known else None,
                weight=first.weight if known else None,
                seeds=tuple(run.value for run in runs),
            )
        )
    return found + [result for result in results if result.source]
