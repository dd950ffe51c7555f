"""The results of a plan: its records, averaged over seeds, with intervals over blocks of windows."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

import npss
from npss.files import read_json
from npss.records import Record
from npss_baselines.evaluation.draws import averaged
from npss_baselines.reproduction.plan import Plan, Row

#: The protocol of the published tables, and the one with many windows.
EIGHT, MANY = "srnn-8", "random-256"
#: The parts of a record that hold numbers of the whole, averaged over draws.
SECTIONS = ("npss", "npss_windows", "euler_error")


class Span(NamedTuple):
    """The ends of an interval, or of the range of blocks if they are too few for an interval."""

    low: float
    high: float
    kind: str  # "range of blocks", or the method of the interval


class Number(NamedTuple):
    """One number of a row, averaged over seeds and draws.

    Attributes
    ----------
    metric : str
        ``'npss'`` or ``'euler_error'``.
    convention : str
        The convention of NPSS; empty for the Euler error.
    at : str
        The window in seconds, such as ``'0-1'``, empty for all frames; or the time in milliseconds.
    value : float
        The mean.
    over_seeds, over_draws : float or None
        Standard deviations: of the means of seeds; of single draws, averaged over seeds. None for one seed, or without
        noise.
    signature : str
        The signature.
    """

    metric: str
    convention: str
    at: str
    value: float
    over_seeds: float | None
    over_draws: float | None
    signature: str


@dataclass(frozen=True)
class Measured:
    """The numbers of one row on one action and protocol.

    Attributes
    ----------
    row : Row
        The row.
    action, protocol, unwrap : str
        The task.
    seeds : tuple of int
        The seeds of the runs.
    record : dict
        The record, averaged over them.
    """

    row: Row
    action: str
    protocol: str
    unwrap: str
    seeds: tuple[int, ...]
    record: Record
    records: tuple[Record, ...]

    @property
    def draws(self) -> int:
        """The number of predictions of each run that were averaged."""
        return int(self.record.get("draws", 1))

    def numbers(self) -> Iterable[Number]:
        """Return the numbers: NPSS over all frames and by window, and the Euler error."""
        return self._numbers.values()

    def number(self, metric: str, convention: str = "", at: str = "") -> Number:
        """Return one number; raise a ValueError if there is none."""
        if (metric, convention, at) in self._numbers:
            return self._numbers[metric, convention, at]
        raise ValueError(f"{self.row.name} on {self.action}: no {metric} {convention} {at}".rstrip())

    @cached_property
    def _numbers(self) -> dict[tuple[str, str, str], Number]:
        """All numbers, by metric, convention, and window or time."""
        of: list[tuple[str, str, str, tuple[str, ...], float]]
        of = [("npss", name, "", ("npss", name), value) for name, value in self.record["npss"].items()]
        for name, windows in self.record["npss_windows"].items():
            of += [("npss", name, at, ("npss_windows", name, at), value) for at, value in windows.items()]
        errors = self.record["euler_error"].items()
        of += [("euler_error", "", at, ("euler_error", at), value) for at, value in errors]
        return {each[:3]: self._number(*each) for each in of}

    def _number(self, metric: str, convention: str, at: str, path: Sequence[str], value: float) -> Number:
        by_seed = [_at(record, path) for record in self.records]
        spread = [_at(record["std"], path) for record in self.records if "std" in record]
        context = {"window": at} if metric == "npss" and at else {}
        return Number(
            metric,
            convention,
            at,
            value,
            float(np.std(by_seed, ddof=1)) if len(by_seed) > 1 else None,
            float(np.mean(spread)) if spread else None,
            npss.records.signature_of(self.record, metric, convention or None, **context),
        )


class Results:
    """All records of a plan.

    Parameters
    ----------
    plan : Plan
        The plan, which orders the rows.
    records : sequence of dict
        The records, as `npss_baselines.reproduction.job.work` writes them.

    Raises
    ------
    ValueError
        If a record is of no row of the plan, or two are of the same row, actions and seed.
    """

    def __init__(self, plan: Plan, records: Sequence[Record]) -> None:
        self.plan = plan
        self.runs: dict[tuple[str, tuple[str, ...], int], Record] = {}
        for record in records:
            if record["row"] not in plan.rows:
                raise ValueError(f"records: {record['row']!r} is no row of the plan")
            key = record["row"], tuple(record["actions"]), record["seed"]
            if key in self.runs:
                raise ValueError(f"records: two of {record['row']!r} on {', '.join(key[1])}, seed {key[2]}")
            self.runs[key] = record
        groups: dict[tuple[str, str, str, str], dict[int, Record]] = {}
        for (row, _, seed), record in sorted(self.runs.items()):
            for measured in record["measured"]:
                stated = npss.parse_signature(measured["signature"])
                place = row, measured["action"], stated["protocol"], stated["unwrap"]
                if seed in groups.setdefault(place, {}):
                    raise ValueError(f"records: two of {row!r} on {measured['action']}, seed {seed}")
                groups[place][seed] = measured
        rows = list(plan.rows)
        measured = {
            place: Measured(plan.rows[place[0]], *place[1:], tuple(of_place), _mean(of_place), tuple(of_place.values()))
            for place, of_place in groups.items()
        }
        actions = self._actions(place[1] for place in measured)
        order = sorted(measured, key=lambda place: (rows.index(place[0]), actions.index(place[1])))
        self._measured = {place: measured[place] for place in order}
        self._spans: dict[tuple[str, str, str, str], dict[tuple[str, str], Span]] = {}

    @cached_property
    def protocols(self) -> tuple[str, ...]:
        """The protocols, the eight windows of published tables first."""
        found = dict.fromkeys(place[2] for place in self._measured)
        return tuple(sorted(found, key=lambda name: (name != EIGHT, name != MANY)))

    @cached_property
    def actions(self) -> tuple[str, ...]:
        """The actions, in the order of the plan."""
        return self._actions(place[1] for place in self._measured)

    def _actions(self, found: Iterable[str]) -> tuple[str, ...]:
        """Order actions: those of the plan first."""
        names = dict.fromkeys(found)
        planned = dict.fromkeys(action for group in self.plan.order for action in group["actions"])
        return (*(action for action in planned if action in names), *(name for name in names if name not in planned))

    def all(self) -> Iterator[Measured]:
        """Yield all numbers, in the order of the plan."""
        yield from self._measured.values()

    def of(self, action: str, protocol: str = EIGHT, unwrap: str = "off") -> dict[str, Measured]:
        """Return the rows on an action, in the order of the plan; records without `EIGHT` have another in its place."""
        protocols = self.protocols
        if protocol == EIGHT and EIGHT not in protocols and protocols:  # such as generated motion
            protocol = protocols[0]
        return {place[0]: found for place, found in self._measured.items() if place[1:] == (action, protocol, unwrap)}

    def spans(self, action: str, protocol: str = EIGHT, unwrap: str = "off", window: str = "") -> Mapping[Any, Span]:
        """Return the interval or range of each row and column, over blocks of windows, at 95 %.

        Parameters
        ----------
        action, protocol, unwrap : str
            The task.
        window : str, optional
            The window of time in seconds; by default all frames.

        Returns
        -------
        mapping of (str, str) to Span
            By the name of the row, and the convention or the time in milliseconds. Numbers without single sequences
            have none.
        """
        key = action, protocol, unwrap, window
        if key not in self._spans:
            of_rows = self.of(action, protocol, unwrap).values()
            records = [record for found in of_rows if (record := _for_leaderboard(found, window)) is not None]
            self._spans[key] = {}
            for row in npss.leaderboard(records).tidy.itertuples() if records else ():
                if row.low == row.low:  # not NaN
                    column = row.column.removeprefix("NPSS ").removeprefix("Euler error ").removesuffix(" ms")
                    self._spans[key][row.model, column] = Span(row.low, row.high, row.interval)
        return self._spans[key]

    def planned(self, row: Row, action: str) -> tuple[int, ...]:
        """Return the seeds of a row on an action that are in the plan, beyond its trial."""
        seeds = {
            seed
            for group in self.plan.order
            if row.name in group["rows"] and action in group["actions"] and group["budget"] != "minutes"
            for seed in group["seeds"]
        }
        return tuple(sorted(seeds))

    def missing(self, row: Row, action: str) -> tuple[int, ...]:
        """Return the planned seeds of a row on an action that have no record."""
        done = {seed for name, actions, seed in self.runs if name == row.name and action in actions}
        return tuple(seed for seed in self.planned(row, action) if seed not in done)


def read_records(folder: Path) -> list[Record]:
    """Read the records of a folder, ``ROW/ACTION-seed-N.json``.

    Raises
    ------
    OSError, ValueError
        If a file cannot be read or holds no record; names the file.
    """
    records = []
    for path in sorted(folder.glob("*/*.json")):
        record = read_json(path)
        _check(f"{path}: ", record, {"row": str, "actions": list, "seed": int, "measured": list})
        for i, measured in enumerate(record["measured"]):
            _check_measured(f"{path}: measured[{i}]: ", measured)
        records.append(record)
    return records


def _check_measured(where: str, measured: object) -> None:
    """Raise unless a measured task of a record has what the tables need."""
    _check(where, measured, {"action": str, "signature": str, **dict.fromkeys(SECTIONS, dict)})
    assert isinstance(measured, dict)
    try:
        stated = npss.parse_signature(measured["signature"])
    except ValueError as error:
        raise ValueError(f"{where}signature: {error}") from error
    if missing := {"protocol", "unwrap"} - set(stated):
        raise ValueError(f"{where}signature: no {', '.join(sorted(missing))} in {measured['signature']!r:.200}")
    for section in SECTIONS:
        _check_numbers(f"{where}{section}: ", measured[section])


def _check_numbers(where: str, values: Mapping[str, Any]) -> None:
    for name, value in values.items():
        if isinstance(value, dict):
            _check_numbers(f"{where}{name}: ", value)
        elif not isinstance(value, (int, float)) or isinstance(value, bool):
            raise ValueError(f"{where}expected a number as {name!r}, got {value!r:.100}")


def _check(where: str, values: object, kinds: Mapping[str, type]) -> None:
    """Raise unless `values` is an object with fields of these types."""
    if not isinstance(values, dict):
        raise ValueError(f"{where}expected a record, got {type(values).__name__}")
    for name, kind in kinds.items():
        if not isinstance(values.get(name), kind):
            raise ValueError(f"{where}expected {kind.__name__} as {name!r}, got {values.get(name)!r:.100}")


def _mean(of_seeds: Mapping[int, Record]) -> Record:
    """Average the records of seeds."""
    kept = ("by_draw", "std")  # of single runs
    return dict(averaged([{k: v for k, v in one.items() if k not in kept} for one in of_seeds.values()]))


def _at(values: Any, path: Sequence[str]) -> float:
    for name in path:
        values = values[name]
    return float(values)


def _for_leaderboard(found: Measured, window: str) -> Record | None:
    """Return a record that a leaderboard can read beside others: without draws, of all frames or of a window."""
    record = found.record
    stated = {name: value for name, value in npss.parse_signature(record["signature"]).items() if name != "draws"}
    # Each row has an action of its own, since those of an action would be tested in pairs, which takes long.
    chosen: Record = {"model": found.row.name, "action": found.row.name}
    if not window:
        sequences = record.get("sequences")
        return (
            None
            if not sequences
            else {
                **chosen,
                "npss": record["npss"],
                "euler_error": record["euler_error"],
                "sequences": sequences,
                "signature": npss.signature(**stated),
            }
        )
    if window not in record.get("sequences_of_windows", {}):
        return None
    whole = {name: record["sequences"][name] for name in ("statistics", "groups") if name in record["sequences"]}
    return {
        **chosen,
        "npss": {name: windows[window] for name, windows in record["npss_windows"].items()},
        "sequences": {**whole, **record["sequences_of_windows"][window]},
        "signature": npss.signature(**{**stated, "window": window}),
    }
