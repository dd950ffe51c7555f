"""The plan of the reference numbers: which rows, on which actions and seeds, in which order, and why."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from npss.files import doing, read_text
from npss.predictors import PREDICTORS
from npss.validation import each, one_of, positive_integer, positive_number
from npss_baselines.data import PoseSource
from npss_baselines.data.windows import checked_seed
from npss_baselines.fitted import FITTED
from npss_baselines.models import MODELS
from npss_baselines.reproduction import BUDGETS

#: Iterations and batch size of a trial.
TRIAL = {"iterations": 3, "batch": 4}


@dataclass(frozen=True)
class Row:
    """A row of the tables: a model and how it is trained.

    Attributes
    ----------
    name : str
        The name of the row, unique in the plan.
    model : str
        The name of the model or predictor.
    recipe : str
        The name of its recipe in the plan.
    tables : tuple of str
        The tables that show the row.
    iterations : int or None
        Iterations of training, to which the schedules of the model's recipe are scaled; None for the model's own.
    settings : dict
        Fields of the run's configuration that differ from the model's, nested as in ``config.json``.
    minutes : float
        The minutes that training takes on one core, roughly: for the time left alone.
    """

    name: str
    model: str
    recipe: str
    tables: tuple[str, ...]
    iterations: int | None = None
    settings: Mapping[str, Any] = field(default_factory=dict)
    minutes: float = 0.1


@dataclass(frozen=True)
class Planned:
    """A run of the plan.

    Attributes
    ----------
    row : Row
        The row of the tables that it belongs to.
    actions : tuple of str
        The actions to train on.
    subjects_of : dict of str to tuple
        The subjects to train on, for each action of the source; empty tuples for generated motion.
    seed : int
        The seed.
    why : str
        Why it is in the plan.
    """

    row: Row
    actions: tuple[str, ...]
    subjects_of: Mapping[str, tuple[Any, ...]]
    seed: int
    why: str

    @property
    def subjects(self) -> tuple[Any, ...]:
        """The subjects that have recordings of all actions."""
        first, *others = (self.subjects_of[action] for action in self.actions)
        return tuple(subject for subject in first if all(subject in each for each in others))

    @property
    def name(self) -> str:
        """The name of the run, of its folder and of its record."""
        action = self.actions[0] if len(self.actions) == 1 else f"{len(self.actions)}-actions"
        return f"{self.row.name}/{action}-seed-{self.seed}"


@dataclass(frozen=True)
class Plan:
    """The plan.

    Attributes
    ----------
    rows : dict of str to Row
        All rows, by name.
    order : tuple of dict
        Groups of runs, the most important first: ``rows``, ``actions``, ``seeds``, ``budget``, ``together``, ``why``.
    recipes : dict of str to str
        What each recipe is, in words.
    subjects : dict of str to tuple
        The subjects to train on, for actions that not all subjects have recordings of.
    """

    rows: Mapping[str, Row]
    order: tuple[Mapping[str, Any], ...]
    recipes: Mapping[str, str]
    subjects: Mapping[str, tuple[Any, ...]]

    def runs(self, source: PoseSource, *, budget: str = "full", only: Sequence[str] = ()) -> list[Planned]:
        """Return the runs, the most important first.

        Parameters
        ----------
        source : PoseSource
            The source of motion. One without the actions of the plan trains on its own default actions.
        budget : {'minutes', 'hours', 'full'}, optional
            How much of the plan to run.
        only : sequence of str, optional
            Names of runs, rows, tables, or models that are no rows; by default, all.

        Raises
        ------
        ValueError
            If a name is that of no run, row, table or model, or of none within the budget; if the budget is unknown; or
            if the source has some actions of the plan, but none of a group.
        """
        one_of("budget", budget, BUDGETS)
        planned, full = ({run.name: run for run in self._runs(source, of)} for of in (budget, "full"))
        for name in only:
            if name not in {**full, **planned}:
                one_of("only", name, self.names())
        runs = {name: run for name, run in planned.items() if not only or self._has(run, {*only})}
        if only and not runs:
            raise ValueError(f"only: the plan has no run of {', '.join(only)} within the budget {budget!r}")
        return list(runs.values())

    def names(self) -> tuple[str, ...]:
        """Return the names of tables, rows and models."""
        rows = self.rows.values()
        tables = [table for row in rows for table in row.tables]
        return tuple(dict.fromkeys([*tables, *self.rows, *(row.model for row in rows)]))

    def _has(self, run: Planned, only: set[str]) -> bool:
        """Return whether one of the names is that of a run, its row, its tables, or a model that is no row."""
        models = {run.row.model} - self.rows.keys()
        return bool(only & {run.name, run.row.name, *run.row.tables, *models})

    def _runs(self, source: PoseSource, budget: str) -> Iterator[Planned]:
        foreign = not any(action in source.actions for group in self.order for action in group["actions"])
        for group in self.order:
            is_trial = group["budget"] == "minutes"
            if is_trial != (budget == "minutes") or (group["budget"] == "full" and budget == "hours"):
                continue
            actions = tuple(action for action in group["actions"] if action in source.actions)
            if not actions and foreign:
                actions = source.default_actions[:1]
            elif not actions:
                raise ValueError(f"order: actions: {source.name} has none of {', '.join(group['actions'])}")
            trained_on = [actions] if group["together"] else [(action,) for action in actions]
            for seed in group["seeds"]:
                for of_run in trained_on:  # a table of one action is worth more than a row on all
                    for row in group["rows"]:
                        planned = self.rows[row]
                        planned = trial(planned) if is_trial else planned
                        yield Planned(planned, of_run, self._subjects(source), seed, group["why"])

    def _subjects(self, source: PoseSource) -> dict[str, tuple[Any, ...]]:
        """Return the subjects to train on, for each action."""
        chosen = {action: self.subjects.get(action, source.train_subjects) for action in source.actions}
        return {
            action: tuple(s for s in source.train_subjects if s in of_action) for action, of_action in chosen.items()
        }


def trial(row: Row) -> Row:
    """Return a row that takes seconds to train."""
    if row.iterations is None:
        return row
    settings = {**row.settings, "recipe": {**row.settings.get("recipe", {}), "batch": TRIAL["batch"]}}
    return replace(row, iterations=TRIAL["iterations"], settings=settings, minutes=0.1)


def read_plan(path: Path | None = None) -> Plan:
    """Read a plan.

    Parameters
    ----------
    path : Path, optional
        A TOML file; by default, ``plan.toml`` beside this module.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read or is invalid; names the table and the key.
    """
    if path is None:
        text, name = files(__package__).joinpath("plan.toml").read_text(encoding="utf-8"), "plan.toml"
    else:
        with doing("reading the plan"):
            text, name = read_text(path), str(path)
    try:
        return _plan(tomllib.loads(text))
    except (TypeError, ValueError) as error:
        raise ValueError(f"{name}: {error}") from error


def _plan(values: Mapping[str, Any]) -> Plan:
    _keys("", values, {"recipes", "rows", "order"}, {"subjects"})
    models = (*PREDICTORS, *FITTED, *MODELS)
    recipes, rows = _table("recipes", values["recipes"]), {}
    for name, recipe in recipes.items():
        _keys(f"recipes.{name}: ", recipe, {"what"}, {"settings"})
    for name, row in _table("rows", values["rows"]).items():
        where = f"rows.{name}: "
        _keys(where, row, {"model", "recipe", "tables"}, {"iterations", "settings", "minutes"})
        one_of(f"{where}recipe", row["recipe"], tuple(recipes))
        one_of(f"{where}model", row["model"], models)
        if row.get("iterations") is not None:
            positive_integer(f"{where}iterations", row["iterations"])
        positive_number(f"{where}minutes", row.get("minutes", 1))
        each(f"{where}tables", row["tables"], "names")
        own = _table(f"{where}settings", row.get("settings", {}))
        settings = _merged(recipes[row["recipe"]].get("settings", {}), own)
        rows[name] = Row(name, **{**row, "tables": tuple(row["tables"]), "settings": settings})
    order = []
    if not isinstance(values["order"], list):
        raise TypeError(f"order: expected a list of tables, [[order]], got {values['order']!r:.100}")
    for i, group in enumerate(values["order"]):
        where = f"order[{i}]: "
        _keys(where, group, {"rows", "actions", "seeds", "budget", "why"}, {"together"})
        one_of(f"{where}budget", group["budget"], BUDGETS)
        for row in each(f"{where}rows", group["rows"], "names"):
            one_of(f"{where}rows", row, tuple(rows))
        each(f"{where}actions", group["actions"], "names")
        for seed in each(f"{where}seeds", group["seeds"], "integers"):
            checked_seed(seed)
        order.append({"together": False, **group})
    subjects = {
        action: tuple(each(f"subjects.{action}", of_action))
        for action, of_action in _table("subjects", values.get("subjects", {})).items()
    }
    return Plan(rows, tuple(order), {name: recipe["what"] for name, recipe in recipes.items()}, subjects)


def _keys(where: str, value: Any, required: set[str], optional: Iterable[str] = ()) -> None:
    """Raise unless a table has the required keys, and no others than the optional ones."""
    _table(where.removesuffix(": "), value)
    if missing := required - set(value):
        raise ValueError(f"{where}missing {', '.join(sorted(missing))}")
    known = required | set(optional)
    if unknown := set(value) - known:
        raise ValueError(f"{where}unknown {', '.join(sorted(unknown))}; expected {', '.join(sorted(known))}")


def _table(where: str, value: Any) -> dict[str, Any]:
    """Return a table, or raise."""
    if not isinstance(value, dict):
        raise TypeError(f"{where}: expected a table, got {value!r:.100}")
    return value


def _merged(first: Mapping[str, Any], second: Mapping[str, Any]) -> dict[str, Any]:
    """Merge nested tables; values of the second take precedence."""
    merged = {**first, **second}
    both = [name for name in first if isinstance(first[name], dict) and isinstance(second.get(name), dict)]
    return merged | {name: _merged(first[name], second[name]) for name in both}
