"""What a run is: the model, the recipe, the data and the seed, as ``config.json`` and the command line state them."""

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
from npss.validation import each, one_of, positive_integer, positive_number
from npss_baselines.data import SOURCES, PoseSource, pose_sources
from npss_baselines.data.windows import checked_seed
from npss_baselines.models import MODELS
from npss_baselines.models.recipe import Recipe

try:
    import jsonargparse
except ImportError:
    raise ImportError(f"training needs jsonargparse; {install_hint('all', baselines=True)}") from None

#: The file of a run that states its configuration.
FILE = "config.json"
#: The file from which training goes on: of a run, or of all that are trained together, in the folder above theirs.
CHECKPOINT = "last.ckpt"
#: The data by default.
DATA = "h36m"
SELECT = ("released", "paper", "euler", "last")
# Stated in the file, but no part of the configuration: for those who read it, where the data were, and what to import.
NOTES = ("made_with", "paths", "plugins")


@dataclass(frozen=True)
class Configuration:
    """All that a run depends on, but for where the data are and what it is computed on.

    Attributes
    ----------
    name : str
        Of the model, one of `npss_baselines.models.MODELS`.
    model : dataclass
        The fields of the model.
    recipe : Recipe
        How it is trained.
    data : str
        The source of motion, one of `npss_baselines.data.pose_sources`.
    actions : tuple of str
        What is trained on, in the order of the label.
    subjects : tuple
        Who is trained on, of the source's `train_subjects`; nobody, where the data are generated.
    seed : int
        Of the initial weights and of every iteration.
    select : {'released', 'paper', 'euler', 'last'}
        Which weights are kept as the model: those with the least NPSS on the validation windows by that convention,
        or with the least Euler error, or the last ones, as the code released with the NPSS paper does.
    average : float or None
        Decay of a moving average of the weights, which then is what is validated and kept.
    validate_on : tuple of str
        The actions of the validation windows.
    validate_every, checkpoint_every : int
        Iterations between two validations, and between two checkpoints.

    Raises
    ------
    TypeError, ValueError
        If a field is not what it should be; the message begins with its name.
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

    @property
    def source(self) -> PoseSource:
        """The source of motion."""
        return pose_sources()[self.data]


def read(path: Path) -> Configuration:
    """Read a configuration; what it does not state is the registry's default.

    Raises
    ------
    FileNotFoundError, ValueError
        If it is not one; names the file.
    """
    return read_with_parser(path)[0]


def read_with_parser(path: Path) -> tuple[Configuration, jsonargparse.ArgumentParser]:
    """Read a configuration, as `read`; return the parser that has read it, too."""
    stated = stated_in(path)
    try:
        check_fields("", stated, [*NOTES, *(field.name for field in fields(Configuration))])
        stated = {name: value for name, value in stated.items() if name not in NOTES}
        name = stated.pop("name", None)
        one_of("name", name, tuple(MODELS))
        for group in ("model", "recipe"):
            known = getattr(MODELS[name], "config" if group == "model" else group)
            check_fields(f"{group}: ", stated.get(group, {}), [field.name for field in fields(known)])
        parser = parser_of(name)
        return configuration_of(name, parser, lambda: parser.parse_object(stated)), parser
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from error


def of_run(folder: Path) -> Path:
    """Return the configuration of a run.

    Raises
    ------
    FileNotFoundError
        If there is none.
    """
    if not (folder / FILE).is_file():
        lack = f"no {FILE} there" if folder.is_dir() else "there is no such folder"
        raise FileNotFoundError(f"reading the run {folder}: {lack}")
    return folder / FILE


def paths_of(path: Path) -> dict[str, Path]:
    """Return where the data of a run are, by the names of the options that said so, as its configuration states."""
    paths = stated_in(path).get("paths", {})
    if not isinstance(paths, dict) or not all(isinstance(found, str) for found in paths.values()):
        raise ValueError(f"{path}: paths: expected an object of names and folders, got {paths!r}")
    return {name: Path(found) for name, found in paths.items()}


def stated_in(path: Path) -> dict[str, Any]:
    """Read what a configuration states, of which nothing is checked yet but the plugins that it needs.

    Raises
    ------
    OSError, ValueError
        If it cannot be read, is no JSON object, or needs a plugin that is not imported; names the file.
    """
    with doing("reading the configuration"):
        stated = read_json(path)
    if not isinstance(stated, dict):
        raise ValueError(f"{path}: expected an object, got {stated!r}")
    try:
        require(stated.get("plugins", []))
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from error
    return stated


def check_fields(where: str, stated: object, names: Sequence[str]) -> None:
    """Raise unless it is an object with no other fields; jsonargparse would import a class that one may name."""
    if not isinstance(stated, dict):
        raise ValueError(f"{where}expected an object, got {stated!r}")
    if unknown := sorted(set(stated) - set(names)):
        raise ValueError(f"{where}there is no {unknown[0]!r}; there are {', '.join(names)}")


def write(
    path: Path,
    configuration: Any,
    device: str,
    paths: Mapping[str, Path] | None = None,
    plugins: Iterable[str] = (),
) -> None:
    """Write a configuration, and beside it what the run is made with and where its data are.

    Parameters
    ----------
    path : Path
        The file.
    configuration : dataclass
        This module's, or the manifold's.
    device : str
        What it is computed on.
    paths : mapping of str to Path, optional
        The folders of the data, by the names of the options that said so.
    plugins : iterable of str, optional
        What has to be imported before the configuration can be read.
    """
    made_with = {"npss": npss.__version__, "torch": str(torch.__version__), "device": device}
    found = {name: str(folder.resolve()) for name, folder in (paths or {}).items()}
    notes = dict(zip(NOTES, (made_with, found, list(plugins)), strict=True))
    write_text_atomically(path, json.dumps(asdict(configuration) | notes, indent=2) + "\n")


def plugins_of(configuration: Configuration) -> list[str]:
    """Return the plugins that have registered what a run is made of."""
    found = {MODELS.plugin(configuration.name), SOURCES.plugin(configuration.data)}
    return sorted(plugin for plugin in found if plugin is not None)


def parser_of(name: str) -> jsonargparse.ArgumentParser:
    """Return what reads the fields of a configuration; its defaults are the registry's, or worked out from the rest."""
    spec = MODELS[name]
    parser = jsonargparse.ArgumentParser(
        prog="npss-baselines train",
        usage="npss-baselines train [MODEL] --out RUN [--config FILE] [OPTION ...]",
        description=f"Train a model: one of {', '.join(MODELS)}. The options --model... below are those of "
        f"{name}; name another one before --help for its own.",
        exit_on_error=False,
        allow_abbrev=False,
        parser_mode="json",
    )
    sources = pose_sources()
    described = ", ".join(f"{name}: {source.description}" for name, source in sources.items())
    parser.add_argument("--data", choices=tuple(sources), default=DATA, help=f"the source of motion: {described}")
    parser.add_argument(
        "--actions", "--action", nargs="+", metavar="ACTION", help="of the source, or all; by default its first one"
    )
    parser.add_argument(
        "--subjects", nargs="+", type=str | int, metavar="S", help="whom to train on; by default all training subjects"
    )
    parser.add_argument("--seed", type=int, default=0, help="of the initial weights and of every iteration")
    parser.add_argument(
        "--select",
        choices=SELECT,
        default=SELECT[0],
        help="which weights are kept: the best on validation windows, by NPSS of that convention or by Euler error; "
        "or the last ones",
    )
    parser.add_argument(
        "--average", type=float, metavar="DECAY", help="validate and keep a moving average of the weights"
    )
    parser.add_argument(
        "--validate-on", nargs="+", metavar="ACTION", help="where files of the test subject lack; if none is named, all"
    )
    parser.add_argument("--validate-every", type=int, metavar="N", help="iterations; if not given, a twentieth of them")
    parser.add_argument(
        "--checkpoint-every", type=int, metavar="N", help="iterations; if not given, a hundredth of them"
    )
    parser.add_argument("--model", type=type(spec.config), default=spec.config)
    parser.add_argument("--recipe", type=Recipe, default=spec.recipe)
    return parser


def set_defaults(parser: jsonargparse.ArgumentParser, values: Mapping[str, Any]) -> None:
    """Give the parser of a configuration other defaults: values of fields, by name."""
    for name, value in values.items():
        if name in ("model", "recipe"):
            parser.set_defaults({f"{name}.{field.name}": getattr(value, field.name) for field in fields(value)})
        elif name != "name":
            parser.set_defaults({name: list(value) if isinstance(value, tuple) else value})


def configuration_of(
    name: str, parser: jsonargparse.ArgumentParser, parse: Callable[[], Any], *, also: Iterable[str] = ()
) -> Configuration:
    """Make the configuration of what was parsed, working out what was not said.

    Errors name the parser's options, and those that there are `also`.
    """
    try:
        parsed = parser.instantiate(parse())
    except argparse.ArgumentError as error:
        raise ValueError(f"{error}{there_are([*parser.get_defaults().keys(), *also], str(error))}") from None
    values = {"name": name} | {field.name: parsed[field.name] for field in fields(Configuration)[1:]}
    iterations, source = values["recipe"].iterations, pose_sources()[values["data"]]
    if values["actions"] is None:
        values["actions"] = source.default_actions[:1]
    elif list(values["actions"]) == ["all"]:
        values["actions"] = source.actions
    worked_out = {
        "validate_on": values["actions"],
        "subjects": source.train_subjects,
        "validate_every": max(1, iterations // 20),
        "checkpoint_every": max(1, iterations // 100),
    }
    values |= {key: value for key, value in worked_out.items() if values[key] is None}
    sequences = {key: tuple(each(key, values[key])) for key in ("actions", "validate_on", "subjects")}
    # A subject is what the source calls it, which on the command line is text.
    subjects = {str(subject): subject for subject in source.train_subjects}
    sequences["subjects"] = tuple(subjects.get(str(subject), subject) for subject in sequences["subjects"])
    return Configuration(**values | sequences)


def there_are(options: Iterable[str], error: str) -> str:
    """Return what to add to an error of unknown arguments: the option that was meant, or all that there are."""
    if "unrecognized" not in error:
        return ""
    names = [f"--{name if '.' in name else name.replace('_', '-')}" for name in sorted(options)]
    group = re.search(r"--\w+\.", error)
    of_group = [name for name in names if group and name.startswith(group[0])]
    return meant(error.split(), of_group or names) or f"; there are {', '.join(of_group or names)}"


def _some_of(name: str, values: Sequence[Any], choices: Sequence[Any]) -> None:
    """Raise unless values are some of the choices, each once."""
    if not values or not set(values) <= set(choices) or len(set(values)) < len(values):
        raise ValueError(
            f"{name}: expected some of {', '.join(map(str, choices)) or 'none'}, each once; "
            f"got {', '.join(map(str, values)) or 'none'}"
        )
