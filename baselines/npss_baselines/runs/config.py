"""The configuration of a run: model, recipe, data and seed, from ``config.json`` and the command line."""

from __future__ import annotations

import argparse
import json
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import torch

import npss
from npss.console import meant
from npss.extras import install_hint
from npss.files import doing, read_json, write_text_atomically
from npss.plugins import require
from npss.validation import each, is_integer, one_of, positive_integer, positive_number
from npss_baselines.data import SOURCES, PoseSource, pose_sources
from npss_baselines.data.tasks import Task
from npss_baselines.data.windows import TrainingSet, checked_seed
from npss_baselines.fitted import FITTED
from npss_baselines.models import MODELS
from npss_baselines.models.recipe import Recipe

try:
    import jsonargparse
except ImportError:
    raise ImportError(f"training needs jsonargparse; {install_hint('all', baselines=True)}") from None

#: The configuration file of a run.
FILE = "config.json"
#: The file that training resumes from: in the folder of a run, or above those of runs that are trained together.
CHECKPOINT = "last.ckpt"
#: The default source of motion.
DATA = "h36m"
SELECT = ("released", "paper", "euler", "last")
# Fields of the file that are not part of the configuration: versions, folders of the data, plugins to import.
NOTES = ("made_with", "paths", "plugins")


@dataclass(frozen=True)
class Configuration:
    """Everything that a run depends on, except the folder of the data and the device.

    Attributes
    ----------
    name : str
        The name of the model, in `npss_baselines.models.MODELS`.
    model : dataclass
        The fields of the model.
    recipe : Recipe
        How the model is trained.
    data : str
        The source of motion, in `npss_baselines.data.pose_sources`.
    actions : tuple of str
        Actions to train on, in the order of the label.
    subjects : tuple
        Subjects to train on, of the source's `train_subjects`; empty for generated motion.
    seed : int
        Seed of the initial weights and of every iteration.
    select : {'released', 'paper', 'euler', 'last'}
        Weights to keep: those with the lowest NPSS on the validation windows, by that convention; those with the
        lowest Euler error; or the last, as in the code released with the NPSS paper.
    average : float or None
        Decay of a moving average of the weights, which is then validated and kept.
    validate_on : tuple of str
        The actions of the validation windows.
    hold_out : tuple
        Training subjects whose windows are the validation windows; empty for those of the source.
    validate_every, checkpoint_every : int
        Iterations between validations, and between checkpoints.

    Raises
    ------
    TypeError, ValueError
        If a field is invalid; the message starts with its name.
    """

    name: str
    model: Any
    recipe: Recipe
    data: str
    actions: tuple[str, ...]
    subjects: tuple[Any, ...]
    seed: int
    select: str
    average: float | None
    validate_on: tuple[str, ...]
    validate_every: int
    checkpoint_every: int
    hold_out: tuple[Any, ...] = ()

    def __post_init__(self) -> None:
        one_of("data", self.data, tuple(pose_sources()))
        one_of("select", self.select, SELECT)
        checked_seed(self.seed)
        positive_integer("validate_every", self.validate_every)
        positive_integer("checkpoint_every", self.checkpoint_every)
        if self.average is not None and positive_number("average", self.average) >= 1:
            raise ValueError(f"average: expected a decay between 0 and 1, got {self.average}")
        _some_of("actions", self.actions, self.source.actions)
        _some_of("validate_on", self.validate_on, self.actions)
        if self.source.train_subjects or self.subjects:
            _some_of("subjects", self.subjects, self.source.train_subjects)
        if self.hold_out:
            _some_of("hold_out", self.hold_out, self.source.train_subjects)
        if both := [str(subject) for subject in self.hold_out if subject in self.subjects]:
            raise ValueError(f"hold_out: subject {both[0]} is one to train on")

    @property
    def source(self) -> PoseSource:
        """The source of motion."""
        return pose_sources()[self.data]

    def motion(self, folder: Path, *, cache: Path | None = None) -> tuple[TrainingSet, list[Task]]:
        """Read the training set and the validation windows.

        Parameters
        ----------
        folder : Path
            The folder of the data set; unused for generated motion.
        cache : Path, optional
            A folder, perhaps missing, to cache files that are faster to read.

        Raises
        ------
        TypeError, ValueError, FileNotFoundError
            As the methods of `npss_baselines.data.PoseSource`.
        """
        training_set = self.source.training_set(folder, self.actions, subjects=self.subjects, cache=cache)
        if self.hold_out:
            return training_set, self.source.held_out_tasks(folder, self.validate_on, self.hold_out, cache=cache)
        return training_set, self.source.validation_tasks(folder, self.validate_on, cache=cache)


def read(path: Path) -> Configuration:
    """Read a configuration; missing fields take the registry's defaults.

    Raises
    ------
    FileNotFoundError, ValueError
        If the file is missing or invalid; names it.
    """
    return read_with_parser(path)[0]


def read_with_parser(path: Path) -> tuple[Configuration, jsonargparse.ArgumentParser]:
    """Read a configuration like `read`; also return its parser."""
    values = read_fields(path)
    try:
        check_fields("", values, [*NOTES, *(field.name for field in fields(Configuration))])
        values = {name: value for name, value in values.items() if name not in NOTES}
        name = values.pop("name", None)
        one_of("name", name, tuple(MODELS))
        for group in ("model", "recipe"):
            default = getattr(MODELS[name], "config" if group == "model" else group)
            check_fields(f"{group}: ", values.get(group, {}), [field.name for field in fields(default)])
        parser = parser_of(name)
        return configuration_of(name, parser, lambda: parser.parse_object(values)), parser
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from error


def file_in(folder: Path) -> Path:
    """Return the configuration file of a run.

    Raises
    ------
    FileNotFoundError
        If it is missing.
    """
    if not (folder / FILE).is_file():
        problem = f"no {FILE} in it" if folder.is_dir() else "no such folder"
        raise FileNotFoundError(f"{folder}: {problem}")
    return folder / FILE


def paths_of(path: Path) -> dict[str, Path]:
    """Return the folders of a run's data, by the names of their options, as its configuration records them."""
    paths = read_fields(path).get("paths", {})
    if not isinstance(paths, dict) or not all(isinstance(folder, str) for folder in paths.values()):
        raise ValueError(f"{path}: paths: expected an object of names and folders, got {paths!r}")
    return {name: Path(folder) for name, folder in paths.items()}


def recorded_threads(path: Path) -> int | None:
    """Return the number of threads that a run was trained on, as its configuration records it; None if it does not."""
    made_with = read_fields(path).get("made_with", {})
    if not isinstance(made_with, dict):
        raise ValueError(f"{path}: made_with: expected an object, got {made_with!r}")
    threads = made_with.get("threads")  # older runs have none
    if threads is None:
        return None
    if not is_integer(threads) or threads < 1:
        raise ValueError(f"{path}: made_with: threads: expected a positive integer, got {threads!r}")
    return int(threads)


def read_fields(path: Path) -> dict[str, Any]:
    """Read the fields of a configuration; check only that the plugins it needs are imported.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read, is not a JSON object, or needs a plugin that is not imported; names it.
    """
    with doing("reading the configuration"):
        values = read_json(path)
    if not isinstance(values, dict):
        raise ValueError(f"{path}: expected an object, got {values!r}")
    try:
        require(values.get("plugins", []))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    return values


def check_fields(where: str, value: object, names: Sequence[str]) -> None:
    """Raise unless the value is an object without other fields: jsonargparse would import a class that one names."""
    if not isinstance(value, dict):
        raise ValueError(f"{where}expected an object, got {value!r}")
    if unknown := sorted(set(value) - set(names)):
        raise ValueError(f"{where}unknown field {unknown[0]!r}; expected {', '.join(names)}")


def write(
    path: Path,
    configuration: Any,
    device: str,
    paths: Mapping[str, Path] | None = None,
    plugins: Iterable[str] = (),
) -> None:
    """Write a configuration, with the versions, device and threads of the run and the folders of its data.

    Parameters
    ----------
    path : Path
        The file.
    configuration : dataclass
        Of this module, or of the manifold.
    device : str
        The device of the run.
    paths : mapping of str to Path, optional
        The folders of the data, by the names of their options.
    plugins : iterable of str, optional
        Modules to import before reading the configuration.
    """
    made_with = {
        "npss": npss.__version__,
        "torch": str(torch.__version__),
        "device": device,
        "threads": torch.get_num_threads(),
    }
    folders = {name: str(folder.resolve()) for name, folder in (paths or {}).items()}
    notes = dict(zip(NOTES, (made_with, folders, list(plugins)), strict=True))
    write_text_atomically(path, json.dumps(asdict(configuration) | notes, indent=2) + "\n")


def plugins_of(configuration: Configuration) -> list[str]:
    """Return the plugins that registered the model or the source of a run."""
    plugins = {MODELS.plugin(configuration.name), SOURCES.plugin(configuration.data)}
    return sorted(plugin for plugin in plugins if plugin is not None)


class HelpFormatter(jsonargparse.DefaultHelpFormatter):
    """jsonargparse's help, with types for fields of the model and the recipe only, and without empty defaults."""

    def _get_help_string(self, action: argparse.Action) -> str:
        if "." in action.dest:
            return str(super()._get_help_string(action))
        text = action.help or ""
        without = "(default:" in text or action.default in (None, argparse.SUPPRESS) or action.default is False
        return text if without else f"{text} (default: %(default)s)"


def parser_of(name: str) -> jsonargparse.ArgumentParser:
    """Return the parser of a configuration's fields; defaults are the registry's, or derived from other fields."""
    spec = MODELS[name]
    parser = jsonargparse.ArgumentParser(
        prog="npss-baselines train",
        usage="npss-baselines train [MODEL] --out RUN [--config FILE] [OPTION ...]",
        description=f"Train a model: {', '.join(MODELS)}. The --model options below are those of {name}; to see "
        f"those of another model, name it before --help. Or fit a predictor in minutes: {', '.join(FITTED)}; name it "
        "before --help, too.",
        exit_on_error=False,
        allow_abbrev=False,
        parser_mode="json",
        formatter_class=HelpFormatter,
    )
    sources = pose_sources()
    described = "; ".join(f"{name}: {source.description}" for name, source in sources.items())
    parser.add_argument(
        "--data", choices=tuple(sources), default=DATA, help=f"choose the source of motion: {described}"
    )
    parser.add_argument(
        "--actions",
        "--action",
        nargs="+",
        metavar="ACTION",
        help="train on these actions, or all (default: the source's first)",
    )
    parser.add_argument(
        "--subjects",
        nargs="+",
        type=str | int,
        metavar="S",
        help="train on these subjects (default: all training subjects)",
    )
    parser.add_argument(
        "--seed", type=int, default=0, metavar="N", help="set the seed of the initial weights and every iteration"
    )
    parser.add_argument(
        "--select",
        choices=SELECT,
        default=SELECT[0],
        help="keep these weights: the best on validation windows, by NPSS of that convention or by Euler error; or the "
        "last",
    )
    parser.add_argument(
        "--average",
        type=float,
        metavar="DECAY",
        help="validate and keep a moving average of the weights with this decay (default: no average)",
    )
    parser.add_argument(
        "--hold-out",
        nargs="+",
        type=str | int,
        default=[],
        metavar="S",
        help="validate on windows of these training subjects, and do not train on them (default: the source's "
        "validation windows)",
    )
    parser.add_argument(
        "--validate-on",
        nargs="+",
        metavar="ACTION",
        help="validate on these actions, if test-subject files of others are missing (default: all)",
    )
    parser.add_argument(
        "--validate-every",
        type=int,
        metavar="N",
        help="validate after every N iterations (default: a twentieth of all)",
    )
    parser.add_argument(
        "--checkpoint-every",
        type=int,
        metavar="N",
        help="write a checkpoint after every N iterations (default: a hundredth of all)",
    )
    parser.add_argument("--model", type=type(spec.config), default=spec.config)
    parser.add_argument("--recipe", type=Recipe, default=spec.recipe)
    return parser


def set_defaults(parser: jsonargparse.ArgumentParser, values: Mapping[str, Any]) -> None:
    """Set the defaults of a configuration's parser: values of fields, by name."""
    for name, value in values.items():
        if name in ("model", "recipe"):
            parser.set_defaults({f"{name}.{field.name}": getattr(value, field.name) for field in fields(value)})
        elif name != "name":
            parser.set_defaults({name: list(value) if isinstance(value, tuple) else value})


def configuration_of(
    name: str, parser: jsonargparse.ArgumentParser, parse: Callable[[], Any], *, also: Iterable[str] = ()
) -> Configuration:
    """Build the configuration from parsed fields, deriving the missing ones.

    Errors name the parser's options and those in `also`.
    """
    try:
        parsed = parser.instantiate(parse())
    except argparse.ArgumentError as error:
        raise ValueError(argument_error(error, [*parser.get_defaults().keys(), *also])) from None
    values = {"name": name} | {field.name: parsed[field.name] for field in fields(Configuration)[1:]}
    iterations, source = values["recipe"].iterations, pose_sources()[values["data"]]
    if values["actions"] is None:
        values["actions"] = source.default_actions[:1]
    elif list(values["actions"]) == ["all"]:
        values["actions"] = source.actions
    derived = {
        "validate_on": values["actions"],
        "subjects": [subject for subject in source.train_subjects if str(subject) not in map(str, values["hold_out"])],
        "validate_every": max(1, iterations // 20),
        "checkpoint_every": max(1, iterations // 100),
    }
    values |= {key: value for key, value in derived.items() if values[key] is None}
    sequences = {key: tuple(each(key, values[key])) for key in ("actions", "validate_on", "subjects", "hold_out")}
    # The command line gives subjects as text; the source may name them otherwise.
    subjects = {str(subject): subject for subject in source.train_subjects}
    for key in ("subjects", "hold_out"):
        sequences[key] = tuple(subjects.get(str(subject), subject) for subject in sequences[key])
    return Configuration(**values | sequences)


def argument_error(problem: argparse.ArgumentError, options: Iterable[str]) -> str:
    """Return an error of jsonargparse as text; for unknown arguments, with the closest option, or all options."""
    error = re.sub(r'^Parser key "([\w.]+)":', r"\1:", str(problem))
    if "unrecognized" not in error:
        return error
    names = [f"--{name if '.' in name else name.replace('_', '-')}" for name in sorted(options)]
    group = re.search(r"--\w+\.", error)
    in_group = [name for name in names if group and name.startswith(group[0])]
    return error + (meant(error.split(), in_group or names) or f"; the options are {', '.join(in_group or names)}")


def _some_of(name: str, values: Sequence[Any], choices: Sequence[Any]) -> None:
    """Raise unless the values are one or more of the choices, without duplicates."""
    if not values or not set(values) <= set(choices) or len(set(values)) < len(values):
        raise ValueError(
            f"{name}: expected one or more of {', '.join(map(str, choices)) or 'none'}, without duplicates; "
            f"got {', '.join(map(str, values)) or 'none'}"
        )
