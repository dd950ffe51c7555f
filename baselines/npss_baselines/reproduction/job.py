"""One run of the plan: train the model, measure it, and write its record."""

from __future__ import annotations

import json
import platform
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import torch

import npss
from npss.files import parse_json, read_json, read_text, write_text_atomically
from npss.predictors import PREDICTORS, Predictor
from npss_baselines.data import PoseSource
from npss_baselines.data.windows import digest
from npss_baselines.fitted import FITTED
from npss_baselines.models import MODELS
from npss_baselines.reproduction.measure import measure
from npss_baselines.reproduction.plan import Planned
from npss_baselines.runs import config, fitted, folder, launch
from npss_baselines.runs.config import Configuration
from npss_baselines.training import trainer

#: Fields of a record that the training leaves in the folder of the run, so that measuring can be repeated.
TRAINED = "trained.json"
#: The seconds that training has taken so far.
SECONDS = "seconds"


class Place(NamedTuple):
    """Where a run finds its motion and leaves its results."""

    source: PoseSource
    folder: Path
    out: Path
    trial: bool = False

    @property
    def cache(self) -> Path:
        """The folder of parsed files."""
        return self.out / "cache"

    def run(self, planned: Planned) -> Path:
        """Return the folder of a run."""
        return self.out / "runs" / planned.name

    def record(self, planned: Planned) -> Path:
        """Return the file of a record."""
        return self.out / "records" / f"{planned.name}.json"


def done(planned: Planned, place: Place) -> bool:
    """Return whether a run has its record.

    Raises
    ------
    OSError, ValueError
        If the record cannot be read, or is one of another plan; names the file.
    """
    file = place.record(planned)
    if not file.exists():
        return False
    record = read_json(file)
    if not isinstance(record, dict):
        raise ValueError(f"{file}: expected a record, got {type(record).__name__}")
    row = planned.row
    expected: dict[str, Any] = {"model": row.model, "recipe": row.recipe, "actions": planned.actions}
    if row.model in FITTED:
        subjects = {action: planned.subjects_of[action] for action in planned.actions}
        settings = asdict(FITTED[row.model].settings)
        expected["configuration"] = {"settings": settings, "data": place.source.name, "subjects": subjects}
    elif row.model in MODELS:
        expected["configuration"] = asdict(configuration_of(planned, place.source))
    if name := _difference(record, parse_json(json.dumps(expected))):
        raise ValueError(f"{file}: a record of another plan ({name} differs); delete it, or choose another --out")
    return True


def _difference(record: Mapping[str, Any], expected: Mapping[str, Any]) -> str:
    """Return the name of a field that differs, or nothing; fields that only one of the two has do not count."""
    for name, value in expected.items():
        if name not in record or record[name] == value:
            continue
        if not (isinstance(value, dict) and isinstance(record[name], dict)):
            return name
        if inner := _difference(record[name], value):
            return f"{name}.{inner}"
    return ""


def work(planned: Planned, place: Place) -> None:
    """Train, measure, and write the record; skip what is done."""
    if done(planned, place):
        return
    predictor_of, trained = _predictor(planned, place)
    source, draws = place.source, 2 if place.trial else None
    protocols = source.protocols[:1] if place.trial else source.protocols
    actions = [action for action in source.default_actions if action in planned.actions]
    tasks = [task for name in protocols for task in source.tasks(place.folder, actions, name, cache=place.cache)]
    measured = [measure(planned.row.name, predictor_of, task, draws=draws) for task in tasks]
    # Jumps of 2 pi decide some of the eight windows, so these are also scored without them.
    measured += [
        measure(planned.row.name, predictor_of, task, draws=draws, unwrapped="target")
        for task in tasks
        if task.protocol == protocols[0]
    ]
    record = {
        "row": planned.row.name,
        "model": planned.row.model,
        "recipe": planned.row.recipe,
        "actions": planned.actions,
        "seed": planned.seed,
        "why": planned.why,
        **trained,
        "measured_with": versions(),
        "measured": measured,
    }
    file = place.record(planned)
    file.parent.mkdir(parents=True, exist_ok=True)
    write_text_atomically(file, json.dumps(record) + "\n")


def versions() -> dict[str, str]:
    """Return the versions and the processor that numbers depend on in their last digits."""
    return {
        "npss": npss.__version__,
        "numpy": np.__version__,
        "python": platform.python_version(),
        "processor": _processor(),
    }


def _predictor(planned: Planned, place: Place) -> tuple[Callable[[str], Predictor], dict[str, Any]]:
    """Return the predictor of each action, and what a record says about its training."""
    if planned.row.model in PREDICTORS:
        return lambda action: PREDICTORS[planned.row.model], {}
    run = place.run(planned)
    if not (run / TRAINED).exists():
        _train(planned, place, run)
    trained = folder.load(run)
    return lambda action: trained.predictor(action, seed=0), parse_json(read_text(run / TRAINED))


def _train(planned: Planned, place: Place, run: Path) -> None:
    """Train the model of a run, from its checkpoint if it has one; or fit the predictor."""
    if planned.row.model in FITTED:
        (run / SECONDS).unlink(missing_ok=True)  # fitting begins anew, and so does its time
    with _timed(run / SECONDS), launch.exclusive_folders(run, [run], launch.existing_runs([run])):
        trained = _fit(planned, place, run) if planned.row.model in FITTED else _train_model(planned, place, run)
    trained["seconds"] = int(read_text(run / SECONDS))
    trained["trained_with"] = {**versions(), "torch": str(torch.__version__), "threads": torch.get_num_threads()}
    write_text_atomically(run / TRAINED, json.dumps(trained) + "\n")


def _fit(planned: Planned, place: Place, run: Path) -> dict[str, Any]:
    """Fit a predictor; return what the record says about it."""
    of_run = fitted.fit(
        planned.row.model,
        place.source,
        place.folder,
        planned.actions,
        subjects=planned.subjects_of,
        seed=planned.seed,
        cache=place.cache,
    )
    of_run.save(run)
    return {"configuration": asdict(of_run.configuration)}


def _train_model(planned: Planned, place: Place, run: Path) -> dict[str, Any]:
    """Train a model; return what the record says about it."""
    configuration, file = configuration_of(planned, place.source), run / config.FILE
    if file.exists() and config.read(file) != configuration:
        raise ValueError(f"{file}: a run of another plan; delete its folder, or choose another --out")
    training_set, tasks = configuration.motion(place.folder, cache=place.cache)
    config.write(file, configuration, "cpu", {}, config.plugins_of(configuration))
    rows = trainer.train(configuration, training_set, tasks, run)
    return {"configuration": asdict(configuration), "motion": digest(training_set), "validation": rows}


def configuration_of(planned: Planned, source: PoseSource) -> Configuration:
    """Return the configuration of a run: the model's own recipe, scaled, and the settings of the plan."""
    row, spec = planned.row, MODELS[planned.row.model]
    recipe = spec.recipe if row.iterations is None else spec.recipe.compressed(row.iterations)
    settings = {name: value for name, value in row.settings.items() if name not in ("recipe", "model")}
    return Configuration(
        **{
            "name": row.model,
            "model": replace(spec.config, **row.settings.get("model", {})),
            "recipe": replace(recipe, **row.settings.get("recipe", {})),
            "data": source.name,
            "actions": planned.actions,
            "subjects": planned.subjects or source.train_subjects,
            "seed": planned.seed,
            "select": "released",
            "average": None,
            "validate_on": tuple(action for action in planned.actions if action in source.default_actions),
            "validate_every": max(1, recipe.iterations // 5),
            "checkpoint_every": max(1, recipe.iterations // 20),
            **settings,
        }
    )


@contextmanager
def _timed(file: Path) -> Iterator[None]:
    """Add the seconds that a block takes to those in a file, if its folder is there in the end."""
    began, before = time.monotonic(), float(read_text(file)) if file.exists() else 0.0
    try:
        yield
    finally:
        if file.parent.exists():
            write_text_atomically(file, f"{before + time.monotonic() - began:.0f}\n")


def _processor() -> str:
    """Return the name of the processor, if the system tells it."""
    with suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
