"""The models of the NPSS paper and its baselines, by name, each with the recipe by which it was trained."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from npss.plugins import Registry
from npss_baselines.models.base import MotionModel
from npss_baselines.models.erd import ERD, ERDConfig
from npss_baselines.models.gru_d import GRUd, GRUdConfig
from npss_baselines.models.lstm_3lr import LSTM3LR, LSTM3LRConfig
from npss_baselines.models.mbr import MBR, MBRConfig
from npss_baselines.models.recipe import Recipe
from npss_baselines.models.srnn import SRNN, SRNNConfig
from npss_baselines.models.vtln import VGRU_AC, VGRU_D, VGRU_R1, VTLN

#: As in the released code; the paper's text says "step schedule from zero".
_LAMBDA = ((500, 0.2), (1000, 0.4), (2000, 0.6), (4000, 0.8), (7000, 1.0))
#: 50 frames to 100.
LONG_TERM = Recipe(lr=2e-4, lr_decay=0.6, lr_milestones=(2000, 4000, 6000, 8000), clip_norm=1.0, closed_weight=_LAMBDA)
#: 50 frames to 10.
SHORT_TERM = replace(
    LONG_TERM,
    iterations=100_000,
    n_target=10,
    lr=1e-4,
    lr_decay=0.8,
    lr_milestones=tuple(range(5000, 60_001, 5000)),
    clip_norm=5.0,
)
#: Of Martinez et al.; MBR-long is trained on 100 frames instead of 10.
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
#: Of Jain et al., for their own model and for those of Fragkiadaki et al. The optimiser is that of their code; how many
#: iterations there were is not stated, and is chosen here: a thousand after the last change of the rate.
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
    """A model: what it is, and how it was trained.

    Parameters
    ----------
    name : str
        What it is called here.
    config : dataclass
        Its sizes and choices.
    build : callable
        ``build(config, n_actions)`` makes it, with weights from torch's global generator.
    recipe : Recipe
        How it was trained.
    cell : str, optional
        What its recurrent cells are, where no field ``cell`` of its configuration chooses.
    published : int, optional
        How many parameters Table 1 of the NPSS paper states.
    """

    name: str
    config: Any
    build: Callable[[Any, int], MotionModel]
    recipe: Recipe
    cell: str = ""
    published: int | None = None

    @property
    def regime(self) -> str:
        """What the loss is of."""
        return self.recipe.regime


#: By name.
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


def register_model(spec: ModelSpec) -> None:
    """Add a model to those of the commands.

    Parameters
    ----------
    spec : ModelSpec
        What is trained by ``npss-baselines train NAME``. The fields of its configuration are options.

    Raises
    ------
    TypeError
        If it is no `ModelSpec`.
    ValueError
        If there is another model of that name.
    """
    if not isinstance(spec, ModelSpec):
        raise TypeError(f"spec: expected a ModelSpec, got {spec!r}")
    MODELS.register(spec.name, spec)
