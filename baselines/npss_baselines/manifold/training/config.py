"""What a run of the manifold is: the network, the recipe, the data and the seed, as ``config.json`` states them."""

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
from npss_baselines.runs.config import FILE, NOTES, check_fields, stated_in, there_are, write

__all__ = ["FILE", "Configuration", "Data", "data_of", "read", "write"]

NAME = "manifold"
LOSSES = ("mean", "sum")
SELECT = ("best", "last")


@dataclass(frozen=True)
class Data:
    """What a run is trained on.

    Attributes
    ----------
    sources : tuple of str
        Where the clips are from: ``cmu``, ``cmu-styles``, ``h36m``, ``synthetic``.
    clips, windows : int
        How many.
    digest : str
        Of all windows: the same if and only if they are, to the bit.
    """

    sources: tuple[str, ...] = ()
    clips: int = 0
    windows: int = 0
    digest: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "sources", tuple(each("sources", self.sources, "names")))  # read from JSON, a list
        for name, kind in (("clips", int), ("windows", int), ("digest", str)):
            if type(getattr(self, name)) is not kind:
                raise TypeError(f"{name}: expected {kind.__name__}, got {getattr(self, name)!r}")


def data_of(motion: MotionSet) -> Data:
    """Say what a run is trained on."""
    digest = hashlib.sha256(motion.windows.tobytes())
    digest.update(motion.mask.tobytes())
    sources = tuple(dict.fromkeys(clip.source for clip in motion.clips))
    return Data(sources, len(motion.clips), len(motion.windows), digest.hexdigest())


@dataclass(frozen=True)
class Configuration:
    """All that a run depends on, but for where the data are and what it is computed on.

    Attributes
    ----------
    name : str
        ``'manifold'``.
    model : AutoencoderConfig
        The network.
    scale : str
    size : float
        Of the features: see `npss_baselines.manifold.motion.scaling`.
    loss : {'mean', 'sum'}
        Of the squared errors of a window's values, and of the magnitudes of its hidden units.
    start : str
        The weights at first: see `npss_baselines.manifold.model.initialization`.
    layers, whole : Stage
        How it is trained: each layer alone, then all together.
    seed : int
        Of the initial weights and of every iteration.
    select : {'best', 'last'}
        Which weights are kept, of those after each epoch of the last stage: with the least error on the validation
        subjects, or the last ones.
    quick : bool
        Whether only a small part of the data is read.
    data : Data
        What it is trained on.

    Raises
    ------
    TypeError, ValueError
        If a field is not what it should be; the message begins with its name.
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
        if not self.layers.epochs and not self.whole.epochs:
            raise ValueError("whole: no stage has an epoch")

    @property
    def phases(self) -> tuple[Phase, ...]:
        """What training does, one after the other."""
        layers = [Phase(f"layer {i + 1}", i, i + 1, self.layers) for i in range(self.model.depth)]
        phases = [*layers, Phase("whole", 0, self.model.depth, self.whole)]
        return tuple(phase for phase in phases if phase.stage.epochs)

    def work(self, phase: int) -> float:
        """Return about how much there is to compute for a window in a phase, in multiplications of its frames' values.

        A layer has half as many frames as the one before, and as many inputs as that has filters.
        """
        model, layers = self.model, self.phases[phase]
        widths = (model.n_features, *model.widths)
        return math.fsum(widths[i] * widths[i + 1] / model.pool**i for i in range(layers.first, layers.depth))


@dataclass(frozen=True)
class Phase:
    """Layers in training.

    Attributes
    ----------
    name : str
        For those who read it.
    first, depth : int
        The first layer, counted from 0, and up to how many layers there are: ``layers[first:depth]``.
    stage : Stage
        How.
    """

    name: str
    first: int
    depth: int
    stage: Stage


def defaults(recipe: str = "default") -> Configuration:
    """Return what a run by a recipe is if nothing else is said."""
    one_of("--recipe", recipe, tuple(RECIPES))
    chosen: Recipe = RECIPES[recipe]
    return Configuration(
        name=NAME,
        model=AutoencoderConfig(unpool=chosen.unpool),
        scale=chosen.scale,
        size=chosen.size,
        loss=chosen.loss,
        start=chosen.start,
        layers=chosen.layers,
        whole=chosen.whole,
        seed=0,
        select=SELECT[0],
        quick=False,
        data=Data(),
    )


def quick(configuration: Configuration) -> Configuration:
    """Return a configuration with a small part of the data, and few epochs: for trying things."""
    layers, whole = configuration.layers, configuration.whole
    return replace(
        configuration,
        layers=replace(layers, epochs=min(layers.epochs, 5)),
        whole=replace(whole, epochs=min(whole.epochs, 20)),
        quick=True,
    )


def read(path: Path) -> Configuration:
    """Read a configuration; what it does not state is that of the default recipe.

    Raises
    ------
    FileNotFoundError, ValueError
        If it is not one; names the file.
    """
    values = stated_in(path)
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
    """Return what reads the fields of a configuration; `default` holds its defaults."""
    parser = jsonargparse.ArgumentParser(
        prog="npss-baselines train manifold",
        usage="npss-baselines train manifold --out RUN [--cmu DIR] [--styles DIR] [--h36m DIR] [OPTION ...]",
        description="Train the motion manifold. Without a folder of motion, on generated walks.",
        exit_on_error=False,
        allow_abbrev=False,
        parser_mode="json",
    )
    parser.add_argument("--scale", choices=SCALES, help="features that share a scale")
    parser.add_argument("--size", type=float, help="standard deviation of scaled features; for none, a factor")
    parser.add_argument("--loss", choices=LOSSES, help="reduction of the squared errors in a window")
    parser.add_argument("--start", choices=INITIALIZATIONS, help="initial weights")
    parser.add_argument("--seed", type=int, help="seed of the initial weights and of training")
    parser.add_argument(
        "--select", choices=SELECT, help="weights to keep: the best on validation subjects, or the last"
    )
    for name in ("model", "layers", "whole"):
        parser.add_argument(f"--{name}", type=type(getattr(default, name)), default=getattr(default, name))
    parser.set_defaults({name: getattr(default, name) for name in ("scale", "size", "loss", "start", "seed", "select")})
    return parser


def configuration_of(
    default: Configuration, parser: jsonargparse.ArgumentParser, parse: Callable[[], Any]
) -> Configuration:
    """Make the configuration of what was parsed; its data are those of `default`."""
    try:
        parsed = parser.instantiate(parse())
    except argparse.ArgumentError as error:
        raise ValueError(f"{error}{there_are(parser.get_defaults().keys(), str(error))}") from None
    names = [field.name for field in fields(Configuration) if field.name not in ("name", "quick", "data")]
    return replace(default, **{name: parsed[name] for name in names})
