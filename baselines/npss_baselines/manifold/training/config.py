"""The configuration of a run, ``config.json``: network, recipe, data and seed."""

from __future__ import annotations

import argparse
import hashlib
import math
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import jsonargparse

from npss.validation import each, one_of, positive_number
from npss_baselines.data.windows import checked_seed
from npss_baselines.manifold.model.autoencoder import AutoencoderConfig
from npss_baselines.manifold.model.initialization import INITIALIZATIONS
from npss_baselines.manifold.motion.dataset import MotionSet
from npss_baselines.manifold.motion.scaling import SCALES
from npss_baselines.manifold.training.recipe import RECIPES, Recipe, Stage
from npss_baselines.runs.config import FILE as FILE
from npss_baselines.runs.config import NOTES, HelpFormatter, argument_error, check_fields, read_fields
from npss_baselines.runs.config import write as write

NAME = "manifold"
LOSSES = ("mean", "sum")
SELECT = ("best", "last")


@dataclass(frozen=True)
class Data:
    """The training data of a run.

    Attributes
    ----------
    sources : tuple of str
        Sources of the clips: ``cmu``, ``cmu-styles``, ``h36m``, ``bvh``, ``synthetic``.
    clips, windows : int
        Number of clips and of windows.
    digest : str
        Hash of all windows; equal if and only if the windows are, to the bit.
    """

    sources: tuple[str, ...] = ()
    clips: int = 0
    windows: int = 0
    digest: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "sources", tuple(each("sources", self.sources, "names")))  # JSON gives a list
        for name, kind in (("clips", int), ("windows", int), ("digest", str)):
            if type(getattr(self, name)) is not kind:
                raise TypeError(f"{name}: expected {kind.__name__}, got {getattr(self, name)!r}")


def data_of(motion: MotionSet) -> Data:
    """Describe training data."""
    digest = hashlib.sha256(motion.windows.tobytes())
    digest.update(motion.mask.tobytes())
    sources = tuple(dict.fromkeys(clip.source for clip in motion.clips))
    return Data(sources, len(motion.clips), len(motion.windows), digest.hexdigest())


@dataclass(frozen=True)
class Configuration:
    """All settings that a run depends on, except data paths and the device.

    Attributes
    ----------
    name : str
        ``'manifold'``.
    model : AutoencoderConfig
        The network.
    scale : str
    size : float
        Scaling of the features: see `npss_baselines.manifold.motion.scaling`.
    loss : {'mean', 'sum'}
        Reduction of the squared errors in a window, and of the magnitudes of its hidden units.
    start : str
        Initial weights: see `npss_baselines.manifold.model.initialization`.
    layers, whole : Stage
        Training of each layer alone, then of all layers together.
    seed : int
        Seed of the initial weights and of every iteration.
    select : {'best', 'last'}
        Weights to keep from the epochs of the last stage: those with the smallest error on the validation subjects, or
        the last ones.
    quick : bool
        Whether to read only a small part of the data.
    data : Data
        The training data.

    Raises
    ------
    TypeError, ValueError
        If a field is invalid; the message begins with its name.
    """

    name: str
    model: AutoencoderConfig
    scale: str
    size: float
    loss: str
    start: str
    layers: Stage
    whole: Stage
    seed: int
    select: str
    quick: bool
    data: Data

    def __post_init__(self) -> None:
        one_of("name", self.name, (NAME,))
        one_of("scale", self.scale, SCALES)
        positive_number("size", self.size)
        one_of("loss", self.loss, LOSSES)
        one_of("start", self.start, INITIALIZATIONS)
        one_of("select", self.select, SELECT)
        checked_seed(self.seed)
        if not isinstance(self.quick, bool):
            raise TypeError(f"quick: expected true or false, got {self.quick!r}")
        if self.layers.structured:
            raise ValueError("layers: structured corruption is of windows, so that only all layers together see it")
        if not self.layers.epochs and not self.whole.epochs:
            raise ValueError("whole: expected at least one epoch in layers or whole")

    @property
    def phases(self) -> tuple[Phase, ...]:
        """The phases of training, in order."""
        layers = [Phase(f"layer {i + 1}", i, i + 1, self.layers) for i in range(self.model.depth)]
        phases = [*layers, Phase("whole", 0, self.model.depth, self.whole)]
        return tuple(phase for phase in phases if phase.stage.epochs)

    def work(self, phase: int) -> float:
        """Estimate the work for a window in a phase, in multiplications per frame and filter lag.

        Each layer divides the number of frames by `pool`, and has as many inputs as the previous layer has filters.
        """
        model, layers = self.model, self.phases[phase]
        widths = (model.n_features, *model.widths)
        return math.fsum(widths[i] * widths[i + 1] / model.pool**i for i in range(layers.first, layers.depth))


@dataclass(frozen=True)
class Phase:
    """A phase of training, and its layers.

    Attributes
    ----------
    name : str
        The name in logs.
    first, depth : int
        The layers ``layers[first:depth]``.
    stage : Stage
        Its settings.
    """

    name: str
    first: int
    depth: int
    stage: Stage


def defaults(recipe: str = "default") -> Configuration:
    """Return the default configuration of a recipe."""
    one_of("--recipe", recipe, tuple(RECIPES))
    settings: Recipe = RECIPES[recipe]
    return Configuration(
        name=NAME,
        model=AutoencoderConfig(unpool=settings.unpool),
        scale=settings.scale,
        size=settings.size,
        loss=settings.loss,
        start=settings.start,
        layers=settings.layers,
        whole=settings.whole,
        seed=0,
        select=SELECT[0],
        quick=False,
        data=Data(),
    )


def quick(configuration: Configuration) -> Configuration:
    """Return a configuration with few epochs and a small part of the data, to try things out."""
    layers, whole = configuration.layers, configuration.whole
    return replace(
        configuration,
        layers=replace(layers, epochs=min(layers.epochs, 5)),
        whole=replace(whole, epochs=min(whole.epochs, 20)),
        quick=True,
    )


def read(path: Path) -> Configuration:
    """Read a configuration; missing fields are those of the default recipe.

    Raises
    ------
    FileNotFoundError, ValueError
        If the file is missing or invalid. The message names it.
    """
    values = read_fields(path)
    try:
        check_fields("", values, [*NOTES, *(field.name for field in fields(Configuration))])
        values = {name: value for name, value in values.items() if name not in NOTES}
        one_of("name", values.pop("name", None), (NAME,))
        configuration = defaults()
        data = values.pop("data", {})
        check_fields("data: ", data, [field.name for field in fields(Data)])
        configuration = replace(configuration, quick=values.pop("quick", False), data=Data(**data))
        for group in ("model", "layers", "whole"):
            check_fields(
                f"{group}: ", values.get(group, {}), [field.name for field in fields(getattr(configuration, group))]
            )
        parser = parser_of(configuration)
        return configuration_of(configuration, parser, lambda: parser.parse_object(values))
    except (TypeError, ValueError) as error:
        raise ValueError(f"{path}: {error}") from error


def parser_of(default: Configuration) -> jsonargparse.ArgumentParser:
    """Return the parser of configuration options; `default` holds their defaults."""
    parser = jsonargparse.ArgumentParser(
        prog="npss-baselines train manifold",
        usage="npss-baselines train manifold --out RUN [--cmu DIR] [--styles DIR] [--h36m DIR] [OPTION ...]",
        description="Train the motion manifold, on generated walks if no folder of motion is named.",
        exit_on_error=False,
        allow_abbrev=False,
        parser_mode="json",
        formatter_class=HelpFormatter,
    )
    parser.add_argument(
        "--scale",
        choices=SCALES,
        help="scale no features, all alike (global), those of a kind alike, or each by itself",
    )
    parser.add_argument(
        "--size",
        type=float,
        metavar="STD",
        help="scale features to this standard deviation; with none, multiply them by it",
    )
    parser.add_argument(
        "--loss", choices=LOSSES, help="reduce the squared errors in a window to their mean or their sum"
    )
    parser.add_argument("--start", choices=INITIALIZATIONS, help="initialise weights in this way")
    parser.add_argument("--seed", type=int, metavar="N", help="set the seed of the initial weights and of training")
    parser.add_argument(
        "--select", choices=SELECT, help="keep these weights: the best on validation subjects, or the last"
    )
    for name in ("model", "layers", "whole"):
        parser.add_argument(f"--{name}", type=type(getattr(default, name)), default=getattr(default, name))
    parser.set_defaults({name: getattr(default, name) for name in ("scale", "size", "loss", "start", "seed", "select")})
    return parser


def configuration_of(
    default: Configuration, parser: jsonargparse.ArgumentParser, parse: Callable[[], Any]
) -> Configuration:
    """Build the configuration from parsed options; its data are those of `default`."""
    try:
        parsed = parser.instantiate(parse())
    except argparse.ArgumentError as error:
        raise ValueError(argument_error(error, parser.get_defaults().keys())) from None
    names = [field.name for field in fields(Configuration) if field.name not in ("name", "quick", "data")]
    return replace(default, **{name: parsed[name] for name in names})
