"""The registry of models: those of the NPSS paper and its baselines, each with its recipe."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, is_dataclass, replace
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import torch

from npss.plugins import Registry
from npss_baselines.models.base import MotionModel
from npss_baselines.models.erd import ERD, ERDConfig
from npss_baselines.models.gru_d import GRUd, GRUdConfig
from npss_baselines.models.lstm_3lr import LSTM3LR, LSTM3LRConfig
from npss_baselines.models.mbr import MBR, MBRConfig
from npss_baselines.models.recipe import Recipe
from npss_baselines.models.srnn import SRNN, SRNNConfig
from npss_baselines.models.vtln import VGRU_AC, VGRU_D, VGRU_R1, VTLN

#: The released code's lambda; the paper's text says "step schedule from zero".
_LAMBDA = ((500, 0.2), (1000, 0.4), (2000, 0.6), (4000, 0.8), (7000, 1.0))
#: From 50 frames to 100.
LONG_TERM = Recipe(lr=2e-4, lr_decay=0.6, lr_milestones=(2000, 4000, 6000, 8000), clip_norm=1.0, closed_weight=_LAMBDA)
#: From 50 frames to 10.
SHORT_TERM = replace(
    LONG_TERM,
    iterations=100_000,
    n_target=10,
    lr=1e-4,
    lr_decay=0.8,
    lr_milestones=tuple(range(5000, 60_001, 5000)),
    clip_norm=5.0,
)
#: The recipe of Martinez et al.; MBR-long is trained on 100 frames instead of 10.
SAMPLING = Recipe(
    regime="sampling",
    iterations=100_000,
    batch=16,
    n_target=10,
    optimizer="sgd",
    momentum=0.0,
    lr=0.005,
    lr_decay=0.95,
    lr_milestones=tuple(range(10_000, 100_000, 10_000)),
    clip_norm=5.0,
)
#: The recipe of Jain et al., for their model and those of Fragkiadaki et al. The optimiser is from their code. They do
#: not state the number of iterations; the one here ends a thousand iterations after the last change of the rate.
NOISE = Recipe(
    regime="noise",
    iterations=5500,
    batch=100,
    optimizer="sgd",
    momentum=0.99,
    lr=1e-3,
    lr_decay=0.1,
    lr_milestones=(1500, 4500),
    clip_norm=25.0,
    noise_std=((250, 0.01), (500, 0.05), (1000, 0.1), (1300, 0.2), (2000, 0.3), (2500, 0.5), (3300, 0.7)),
)


@dataclass(frozen=True)
class ModelSpec:
    """A model and its recipe.

    Parameters
    ----------
    name : str
        The name of the model.
    config : dataclass
        The sizes and choices of the model.
    build : callable
        ``build(config, n_actions)`` returns the model, with weights from torch's global generator.
    recipe : Recipe
        How the model is trained.
    cell : str, optional
        The type of its recurrent cells, if no field ``cell`` of its configuration chooses it.
    published : int, optional
        The number of parameters in Table 1 of the NPSS paper.
    """

    name: str
    config: Any
    build: Callable[[Any, int], MotionModel]
    recipe: Recipe
    cell: str = ""
    published: int | None = None

    @property
    def regime(self) -> str:
        """The training objective."""
        return self.recipe.regime

    def parameters(self, n_actions: int = 1, *, config: Any = None) -> int:
        """Count the trained parameters.

        Parameters
        ----------
        n_actions : int, optional
            The width of the label.
        config : dataclass, optional
            Other sizes and choices than the model's own.

        Returns
        -------
        int
            The number of parameters.

        Examples
        --------
        >>> MODELS["erd"].parameters()
        14842054
        """
        with torch.device("meta"):  # shapes without values
            model = self.build(self.config if config is None else config, n_actions)
        return sum(parameter.numel() for parameter in model.parameters() if parameter.requires_grad)


#: Models by name.
MODELS = Registry(
    "model",
    {
        spec.name: spec
        for spec in (
            ModelSpec("vgru-d", VGRU_D, VTLN, LONG_TERM, published=3_413_047),
            ModelSpec("gru-d", GRUdConfig(), GRUd, LONG_TERM, "gru", 2_735_670),
            ModelSpec("vgru-r1", VGRU_R1, VTLN, SHORT_TERM),
            ModelSpec("vgru-ac", VGRU_AC, VTLN, replace(LONG_TERM, regime="auto-conditioning", closed_weight=())),
            ModelSpec("mbr-unsup", MBRConfig(), MBR, SAMPLING, "gru"),
            ModelSpec("mbr-sup", MBRConfig(label=True), MBR, SAMPLING, "gru"),
            ModelSpec("mbr-long", MBRConfig(residual=False), MBR, replace(SAMPLING, n_target=100), "gru", 3_425_334),
            ModelSpec("erd", ERDConfig(), ERD, NOISE, "lstm", 14_842_054),
            ModelSpec("lstm-3lr", LSTM3LRConfig(), LSTM3LR, NOISE, "lstm", 20_282_054),
            ModelSpec("srnn", SRNNConfig(), SRNN, NOISE, "lstm", 18_368_534),
        )
    },
)


def register_model(spec: ModelSpec, *, replace: bool = False) -> None:
    """Register a model for the commands.

    Parameters
    ----------
    spec : ModelSpec
        The model that ``npss-baselines train NAME`` trains. The fields of its configuration are options.
    replace : bool, optional
        Replace a registered model of the same name, as when a notebook cell is run again.

    Raises
    ------
    TypeError
        If it is not a `ModelSpec`, its `build` is not a function, its `recipe` is not a `Recipe`, its configuration is
        not a dataclass, or a field of it is not plain data: numbers, text, None, and choices, unions and tuples of
        these. A run's ``config.json`` holds its value, and the name of a function or a class there would be imported.
    ValueError
        If the name is taken, by a built-in model or by another one without `replace`; if it is ``manifold``, which
        ``npss-baselines train`` trains; or if it begins with a hyphen, as options do.

    Examples
    --------
    >>> from npss_baselines.models import MODELS, register_model
    >>> register_model(MODELS["erd"])  # as if it were your own
    Traceback (most recent call last):
    ValueError: the model 'erd' is registered already
    """
    if not isinstance(spec, ModelSpec):
        raise TypeError(f"spec: expected a ModelSpec, got {spec!r}")
    if not is_dataclass(spec.config) or isinstance(spec.config, type):
        raise TypeError(f"spec: config: expected an instance of a dataclass, got {spec.config!r}")
    if not callable(spec.build):
        raise TypeError(f"spec: build: expected a function, got {spec.build!r}")
    if not isinstance(spec.recipe, Recipe):
        raise TypeError(f"spec: recipe: expected a Recipe, got {spec.recipe!r}")
    if spec.name == "manifold" or str(spec.name).startswith("-"):
        raise ValueError(f"spec: name: expected another name for `npss-baselines train`, got {spec.name!r}")
    types = get_type_hints(type(spec.config))
    for field in fields(spec.config):
        if not _is_plain(types[field.name]):
            raise TypeError(f"spec: config: {field.name}: expected plain data, got the type {types[field.name]}")
    MODELS.register(spec.name, spec, replace=replace)


def _is_plain(kind: Any) -> bool:
    """Return whether values of a type are plain data."""
    if kind in (bool, int, float, str, NoneType, Ellipsis) or get_origin(kind) is Literal:
        return True
    return get_origin(kind) in (tuple, list, Union, UnionType) and all(map(_is_plain, get_args(kind)))
